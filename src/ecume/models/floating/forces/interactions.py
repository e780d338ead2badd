"""The table of interactions: forces between floats, and between floats and walls. A scene combines one or more.

A part is a NamedTuple of constants, and its type is the key of its row. `evaluate` adds up the forces of all parts.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ecume._jit import composed, each_selected
from ecume._tables import by_constants
from ecume.engine.neighbors import NeighborLists, sort_positions
from ecume.engine.walls import Walls
from ecume.laws import camphor, contact_lines, ewald, multipole, pair_laws, radiated_waves, rafts
from ecume.models.floating.forces.activity import (
    Activity,
    activity_forces,
    activity_of,
    add_work_of_activity,
    make_activity_scratch,
    no_activity_energy,
    renew_activity,
    with_activity,
)
from ecume.models.floating.forces.barrier import (
    Barrier,
    barrier_lines,
    barrier_numbers,
    barrier_of,
    carry_barrier,
    make_barrier_scratch,
    move_barrier,
    moved_walls,
    no_barrier_energy,
    with_barrier,
)
from ecume.models.floating.forces.ewald_grid import (
    Split,
    make_reference,
    place_grid,
    smooth_forces,
    split_energy,
    split_lines,
)
from ecume.models.floating.forces.films import (
    CoupledFilms,
    Films,
    apply_coupled_films,
    apply_films,
    coupled_films_of,
    films_of,
)
from ecume.models.floating.forces.flow_and_noise import add_flow, clock
from ecume.models.floating.forces.magnets import (
    DipoleMoments,
    MagneticField,
    dipole_energies,
    dipole_forces,
    dipoles_of,
    magnetic_energy,
    magnetic_field_of,
    magnetic_forces,
    magnetic_lines,
    make_magnetic_scratch,
    make_sorted_moments,
    renew_field,
    sort_moments,
)
from ecume.models.floating.forces.multipoles import (
    Multipoles,
    PairTables,
    correction_energy,
    correction_forces,
    corrections_of,
    kick_multipole_spins,
    make_multipole_scratch,
    multipole_energy,
    multipole_forces,
    multipoles_of,
)
from ecume.models.floating.forces.pair_forces import (
    Superposed,
    make_sorted,
    sort_floats,
    superposed_energy,
    superposed_forces,
    superposed_of,
)
from ecume.models.floating.forces.surfactant import (
    BUDGETS,
    Surfactant,
    advance_surfactant,
    keep_motion,
    make_surfactant_scratch,
    no_surfactant_energy,
    surfactant_forces,
    surfactant_lines,
    surfactant_numbers,
    surfactant_of,
    surfactant_work,
    with_surfactant,
)
from ecume.models.floating.forces.waves import (
    Waves,
    keep_ways,
    kick_wave_spins,
    make_waves_scratch,
    no_wave_energy,
    wave_forces,
    wave_lines,
    waves_of,
    with_headings,
)
from ecume.models.floating.options import Built, Option
from ecume.models.floating.parameters import Parameters, Parts, Scratch, State, Workspace, clear
from ecume.models.floating.shaped.bodies import (
    Shaped,
    make_shaped_scratch,
    rounding_of_energies,
    shaped_energies,
    shaped_forces,
)
from ecume.models.floating.shaped.constants import shapes_of
from ecume.models.invariants import Invariant
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene


def no_scratch(part: Any, parameters: Parameters, state: State, workspace: Workspace) -> Any:
    """Return an empty workspace."""
    return ()


@dataclass(frozen=True, kw_only=True)
class Interaction(Option):
    """A row of the table, and everything that depends on it."""

    slot: str = "interaction"
    constants: type
    """the type of the part, a NamedTuple"""
    make: Callable[[Parameters, FloatingScene], Built]
    """make(parameters without parts, scene). Raises SceneError"""
    add_forces: Callable[..., None] | None
    """add_forces(part, scratch, parameters, position, lists, force): add to the forces (N, 2)"""
    energy: Callable[..., tuple[float, float]]
    """energy(part, scratch, parameters, state, workspace): among floats and at walls (J); forces are minus its
    gradient
    """
    rounding: Callable[[Any, Parameters], float] = lambda part, parameters: 0.0
    """rounding(part, parameters): the largest error (J) by which an energy whose terms cancel is rounded"""
    adds_to_pairs: bool = False
    """whether a method's forces are added to those of the pair law; if not, they replace them"""
    compiled: bool = True
    """whether compiled code can call `add_forces`; if not, Python runs the time steps"""
    scratch: Callable[[Any, Parameters, State, Workspace], Any] = no_scratch
    sort: Callable[..., None] | None = None
    """sort(part, scratch, parameters, lists): called after new lists"""
    kick_spins: Callable[..., None] | None = None
    """kick_spins(part, scratch, parameters, state, first): half a kick of the spins, before and after a step"""
    add_work: Callable[..., None] | None = None
    """add_work(part, scratch, parameters, state, workspace): the work in a step of forces that have no energy"""
    moved_walls: Callable[[Any, Walls], Walls] | None = None
    """moved_walls(scratch, walls): the walls where steps have moved them; None if they rest"""
    state: Callable[[Any, State], State] = lambda part, state: state
    """state(part, state): the state with the data of the part"""
    inertia: Callable[[Any], Array | None] = lambda part: None
    """inertia(part): of floats that the part turns (kg m^2), (N,)"""
    arrays: Callable[[Any], Mapping[str, tuple[Array, str]]] = lambda part: {}
    """arrays(part): quantities for frames, with units"""
    numbers: Callable[[Any, State], Mapping[str, tuple[float, str]]] = lambda part, state: {}
    """numbers(part, state): numbers for frames, with units"""
    invariants: tuple[Invariant, ...] = ()
    """what must hold for these numbers during a run"""
    lines: Callable[[Any, Parameters], list[tuple[str, str, str]]] = lambda part, parameters: []
    """lines(part, parameters): further lines of `ecume check`"""
    pairs_worth: Callable[[Any, float], float] = lambda part, time_step: 0.0
    """pairs_worth(part, time_step): work of a time step in addition to lists, in pairs"""
    points: Callable[[Any], float] = lambda part: 0.0
    """points(part): number of grid points, for the estimate of memory"""
    laws: tuple[Callable[..., Any], ...] = ()
    """functions whose docstrings name the references that `ecume cite` lists"""


def _with_amplitudes(part: Multipoles, state: State) -> State:
    """Return the state with an array for the multipoles."""
    return state._replace(amplitudes=np.zeros((len(state.position), 2 * part.rims.response.shape[1])))


def _turned(part: Multipoles) -> Array | None:
    return np.asarray(part.inertia) if len(part.inertia) else None


ROUND = frozenset({"round"})
INTERACTIONS = {
    "superposition": Interaction(
        path="interaction.method", name="'superposition'", constants=Superposed, make=superposed_of,
        add_forces=superposed_forces, energy=superposed_energy, scratch=make_sorted, sort=sort_floats,
        gives=ROUND | {"moving walls", "pair sum", "grid", "superposed", "no torques"},
    ),
    "shapes": Interaction(
        path="particles", name="a float with a shape", constants=Shaped, make=shapes_of, add_forces=shaped_forces,
        energy=shaped_energies, rounding=rounding_of_energies, scratch=make_shaped_scratch,
        inertia=lambda part: np.asarray(part.inertia), gives=frozenset({"moving walls"}),
        laws=(contact_lines.ellipsoid_undulation, contact_lines.spread_charges, contact_lines.quadrupole_energy),
        needs={
            "turns bodies": "its drag differs along and across, and kicks must turn it",
            "superposed": "its charges are superposed",
            "charges": "its contact line is a set of charges",
            "point charges": "the wall acts on each of its charges by itself, without images of the others",
            "outer walls": "it can touch a wall that bulges toward it with an edge, and not with a corner only",
        },
    ),
    "multipole": Interaction(
        path="interaction.method", name="'multipole'", constants=Multipoles, make=multipoles_of,
        add_forces=multipole_forces, energy=multipole_energy, scratch=make_multipole_scratch,
        kick_spins=kick_multipole_spins, state=_with_amplitudes, inertia=_turned,
        gives=ROUND | {"undulations", "no torques"}, laws=(multipole.solve,),
        needs={
            "menisci": "multipoles are the shape of the liquid's surface",
            "multipoles": "the surface between floats and wall is solved as a whole",
            "apart": "the surface has no solution where contact lines overlap",
            "open": "the surface is solved as a whole, and far from all floats it is flat",
        },
    ),
    "pair-corrected": Interaction(
        path="interaction.method", name="'pair-corrected'", constants=PairTables, make=corrections_of,
        add_forces=correction_forces, energy=correction_energy, adds_to_pairs=True,
        gives=ROUND | {"moving walls", "pair sum", "no torques"},
        laws=(multipole.solve,),
        needs={"menisci": "tables hold what two menisci do beyond their sum"},
    ),
    "dipoles": Interaction(
        path="particles", name="a magnetic moment", constants=DipoleMoments, make=dipoles_of, add_forces=dipole_forces,
        energy=dipole_energies, scratch=make_sorted_moments, sort=sort_moments,
        arrays=lambda part: {"magnetic_moment": (part.moment.copy(), "A*m^2")},
        gives=ROUND | {"moving walls", "pair sum", "undulations", "grid", "superposed", "no torques"},
        laws=(pair_laws.dipole_force,),
    ),
    "magnetic field": Interaction(
        path="magnetic_field", name="a magnetic field", constants=MagneticField, make=magnetic_field_of,
        add_forces=magnetic_forces, energy=magnetic_energy, scratch=make_magnetic_scratch, kick_spins=renew_field,
        lines=magnetic_lines, arrays=lambda part: {"magnetic_moment": (part.permanent.copy(), "A*m^2")},
        gives=ROUND | {"moving walls", "pair sum", "undulations", "grid", "superposed", "no torques"},
        laws=(pair_laws.oblique_dipole_energy, pair_laws.induced_moment),
        needs={"kicks at the ends": "the work of a field that changes is known at the ends of a step"},
    ),
    "grid": Interaction(
        path="interaction.summation", name="'grid'", constants=Split, make=lambda parameters, scene: Built(()),
        add_forces=smooth_forces, energy=split_energy, compiled=False, scratch=make_reference, sort=place_grid,
        lines=split_lines,
        pairs_worth=lambda part, time_step: part.work[1], points=lambda part: part.points,
        gives=ROUND | {"moving walls", "superposed", "no torques"},
        laws=(ewald.short_energy, ewald.smooth_wave, ewald.grid_error),
        needs={
            "menisci": "its waves are those of the liquid's surface",
            "grid": "the split into a near and a smooth part is that of one charge at the center of each float",
            "open": "its waves decay toward borders without floats behind them",
        },
    ),
    "activity": Interaction(
        path="activity", name="an active force", constants=Activity, make=activity_of, add_forces=activity_forces,
        energy=no_activity_energy, scratch=make_activity_scratch, kick_spins=renew_activity,
        add_work=add_work_of_activity, state=with_activity,
        gives=ROUND | {"moving walls", "pair sum", "grid", "superposed", "undulations", "no torques"},
        needs={
            "drag": "drag limits the speed that an active force gives",
            "takes noise": "a random force has no derivative, on which the order of such a scheme rests",
        },
    ),
    "waves": Interaction(
        path="waves", name="a source of waves", constants=Waves, make=waves_of, add_forces=wave_forces,
        energy=no_wave_energy, scratch=make_waves_scratch, kick_spins=kick_wave_spins, add_work=keep_ways,
        state=with_headings,
        inertia=lambda part: np.asarray(part.inertia), lines=wave_lines,
        pairs_worth=lambda part, time_step: 2.0 * float(len(part.owner)) ** 2,
        gives=ROUND | {"moving walls", "pair sum", "grid", "superposed", "undulations"},
        laws=(radiated_waves.slope_per_force, radiated_waves.mean_force),
        needs={
            "drag": "waves take their energy from outside, and drag takes it from the floats",
            "kicks at the ends": "the work of waves, which have no energy, is known at the ends of a step",
            "kicks spins": "the torques of waves turn floats",
            "open": "waves of images would overlap to infinity",
            "single drag": "the flow of a float that turns moves its neighbors",
        },
    ),
    "surfactant": Interaction(
        path="surfactant", name="a surfactant", constants=Surfactant, make=surfactant_of,
        add_forces=surfactant_forces, energy=no_surfactant_energy, compiled=False, scratch=make_surfactant_scratch,
        kick_spins=advance_surfactant, add_work=keep_motion, state=with_surfactant,
        numbers=surfactant_numbers, lines=surfactant_lines, invariants=BUDGETS,
        pairs_worth=surfactant_work, points=lambda part: float(part.wet.size),
        gives=ROUND | {"pair sum", "grid", "superposed", "undulations", "no torques"},
        laws=(camphor.propulsion, camphor.threshold_friction),
        needs={
            "drag": "surface tension drives floats, and drag limits their speed",
            "kicks at the ends": "the concentration diffuses from the places of floats at the end of a step",
            "round": "floats release over a disc, on whose perimeter the surface tension acts",
            "bounded": "the concentration is computed on a grid, which has an end",
        },
    ),
    "barrier": Interaction(
        path="dish.barrier", name="a barrier", constants=Barrier, make=barrier_of, add_forces=None,
        energy=no_barrier_energy, scratch=make_barrier_scratch, kick_spins=move_barrier, add_work=carry_barrier,
        moved_walls=moved_walls, state=with_barrier, numbers=barrier_numbers, lines=barrier_lines,
        gives=ROUND | {"pair sum", "grid", "superposed", "undulations", "no torques"},
        laws=(rafts.buckling_pressure, rafts.pressure_left),
        needs={
            "kicks at the ends": "its force is that of contacts, which act at the ends of a step",
            "full mobility": "its force is that of the impulses that stop floats",
            "lone": "a wall that moves makes liquid flow, which would carry floats that feel the flow of others",
            "moving walls": "the surface and the concentration are those in equilibrium with walls at rest",
            "no noise": "floats that diffuse meet walls at rest within a step",
        },
    ),
}  # fmt: skip
"""The interactions by name."""

METHODS = tuple(name for name, row in INTERACTIONS.items() if row.path == "interaction.method")
"""Choices of `interaction.method`."""

OF_THE_CHOICE = frozenset({"name", "path", "make", "adds_to_pairs", "gives", "needs", "laws"})
"""Fields that are read from the row that a scene chooses: rows with constants of one type may differ in them."""

BY_CONSTANTS = by_constants(INTERACTIONS.values(), OF_THE_CHOICE)


@dataclass(frozen=True, kw_only=True)
class Resistance(Option):
    """A row of the table of resistances, which slow floats in addition to drag."""

    slot: str = "resistance"
    constants: type
    """the type of the part, a NamedTuple"""
    make: Callable[[Parameters, FloatingScene], Built]
    """make(parameters without parts, scene). Raises SceneError"""
    slow: Callable[..., None]
    """slow(part, scratch, parameters, state, workspace, first): change velocities after a kick, and midstep velocities
    after the first one of a step
    """
    scratch: Callable[[Any], Any] = lambda moving: ()
    """scratch(workspace of the integrator): the workspace"""


RESISTANCES = {
    "films": Resistance(
        path="hydrodynamics.lubrication", name="a film", constants=Films, make=films_of, slow=apply_films,
        needs={
            "kicks at the ends": "the friction of a film has no upper limit, so that it must act on a whole kick",
            "drag": "the friction of a film is a multiple of the drag of its floats",
            "stokes": "the friction of a film is a multiple of Stokes's drag",
            "round": "the film between two floats is known for spheres",
            "lubricated": "a spring would push floats apart without resistance by the film between them",
        },
    ),
}  # fmt: skip
"""The resistances by name."""

RESISTANCES["coupled films"] = replace(
    RESISTANCES["films"], constants=CoupledFilms, make=coupled_films_of, slow=apply_coupled_films,
    scratch=lambda moving: moving,
)  # fmt: skip

RESISTANCES_BY_CONSTANTS = by_constants(RESISTANCES.values(), OF_THE_CHOICE)

add_forces = each_selected(BY_CONSTANTS, "add_forces")

sort_parts = each_selected(BY_CONSTANTS, "sort")

add_work_of_forces = each_selected(BY_CONSTANTS, "add_work")

kick_spins = each_selected(BY_CONSTANTS, "kick_spins")

apply_resistances = each_selected(RESISTANCES_BY_CONSTANTS, "slow")


@composed
def evaluate(
    parts: Parts, scratches: Scratch, parameters: Parameters, position: Array, lists: NeighborLists, force: Array
) -> None:
    """Sum the forces on all floats at these positions and at the time of the clock; the neighbor lists must be valid
    there.
    """
    clear(force)
    sort_positions(lists, position)
    add_forces(parts.interactions, scratches.interactions, parameters, position, lists, force)
    if parameters.drift.flows and parameters.scheme.drags_along:
        add_flow(parameters, float(clock(scratches)), position, force)


def interactions_of(parameters: Parameters) -> list[tuple[Any, Interaction]]:
    """The parts of the parameters, each with its row."""
    return [(part, BY_CONSTANTS[type(part)]) for part in parameters.parts.interactions]
