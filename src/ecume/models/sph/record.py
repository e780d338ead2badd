"""The SPH model as a record of functions, and the quantities that actions may change in a tank."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ecume._columns import RECORD
from ecume._plain_files import memory_limit
from ecume.engine.cells import Integers
from ecume.errors import Fault, SceneError
from ecume.models.actions import Access
from ecume.models.costs import within_steps
from ecume.models.diagnosis import first_broken, when
from ecume.models.layouts import Layout
from ecume.models.model import Model, Row
from ecume.models.sph.boundaries.driven_bodies import drive_bodies
from ecume.models.sph.boundaries.open_boundaries import exchange, with_buffers
from ecume.models.sph.boundaries.rigid_bodies import at_reference, with_moved_solids
from ecume.models.sph.boundaries.walls import flag_outside
from ecume.models.sph.integration.time_stepping import advance
from ecume.models.sph.parameters import Liquid, Parameters
from ecume.models.sph.projection import failed
from ecume.models.sph.report.check_report import advice
from ecume.models.sph.report.observation import invariants, observe
from ecume.models.sph.setup.building import parameters_of
from ecume.models.sph.setup.choices import kernel_of, laws_of, require_right_split, smoothing_of
from ecume.models.sph.setup.initial_particles import liquid_of
from ecume.models.sph.setup.shapes import part_of
from ecume.models.sph.state import (
    MOST_SKIN,
    RESIDUAL,
    WORK,
    WORST,
    State,
    Workspace,
    likely_neighbors,
    make_state,
    workspace_at,
)
from ecume.scenes.sph import SphScene
from ecume.units import with_prefix

if TYPE_CHECKING:
    from ecume.models.user_laws import BoundLaw


def faults(scene: SphScene, parameters: Parameters, state: State) -> list[str]:
    """Messages on the particles behind a wall, in a solid, or beyond an open side."""
    guard, outside = with_moved_solids(parameters, state).boundary.guard, np.zeros(len(state.mass), np.bool_)
    if len(guard.owner):
        flag_outside(state.position, guard.sheet.kind, guard.sheet.number, 0.0, outside)
    low, high = parameters.bounds[:, :, None]
    outside |= ((state.position < low) | (state.position > high)).any(axis=0)
    return [
        f"particle {i} is outside, at {state.position[:, k].tolist()} m; expected a position in the tank"
        for i, k in zip(state.identity[outside], np.flatnonzero(outside), strict=True)
        if state.zone[k] == 0
    ]


def changed(state: State, moved: bool) -> None:
    """Mark forces as invalid after positions or velocities were changed."""
    state.ready[0] = 0
    if moved:
        state.reference[...] = state.position
        state.pose_reference[...] = state.pose
        state.clock[1] = state.clock[0]


def ids(state: State) -> Integers:
    """The permanent numbers of particles. Particles in buffers behind open sides are not part of the liquid yet."""
    return np.where(state.zone == 0, state.identity, -1)


TANKS = Access(
    arrays=lambda state: {"position": state.position.T, "velocity": state.velocity.T},
    ids=ids,
    faults=faults,
    changed=changed,
    work=lambda state: state.budget[WORK : WORK + 1],
)


def start(scene: SphScene, parameters: Parameters) -> State:
    """The initial state of the liquid."""
    other = None if parameters.second is None else parameters.second.material
    state = make_state(parameters, liquid_of(scene, parameters.material, other))
    drive_bodies(parameters, state)
    return with_buffers(parameters, state)


def layout(scene: SphScene, parameters: Parameters, state: State) -> Layout:
    """The arrays of a state with this number of particles, which changes with open sides."""
    vectors, rows = np.zeros((parameters.dimension, state.mass.size)), np.zeros(state.mass.size)
    liquid = Liquid(vectors, vectors, rows, rows, rows, np.zeros(state.mass.size, np.int64))
    blank = make_state(parameters, liquid)
    if not state.image.size:  # states of a former version
        blank = blank._replace(image=state.image, passive_image=state.passive_image)
    if not state.struck.size:  # states of a former version
        blank = blank._replace(struck=state.struck)
    return Layout(
        blank,
        {
            "identity": (0, math.inf),
            "region": (0, len(scene.fluid) - 1),
            "zone": (0, len(parameters.open_boundaries)),
            "skin": (0.0, MOST_SKIN * parameters.support),
        },
    )


def workspace(parameters: Parameters, state: State, room: float) -> Workspace:
    """The workspace with lists and tables at the state's reference positions."""
    return workspace_at(at_reference(parameters, state), state)


def checked_parameters(scene: SphScene) -> Parameters:
    """The parameters of a scene, if it fits into the memory of the machine."""
    count = particles_expected(scene)
    needed = count * bytes_per_particle(scene)
    there = memory_limit()
    if needed > there:
        message = f"about {count:.3g} particles need {needed / 1e9:.3g} GB, this process may use {there / 1e9:.3g} GB"
        too_many = Fault("spacing", f"got {scene.spacing:g} m: {message}; use a wider spacing")
        raise SceneError(regions_beyond(scene) or [too_many])
    require_right_split(scene)
    return within_steps(scene, parameters_of(scene))


def regions_beyond(scene: SphScene) -> list[Fault]:
    """Faults of regions larger than their tank, probably given in another unit."""
    faults, room = [], np.array(scene.tank.high) - np.array(scene.tank.low)
    for index, region in enumerate(scene.fluid):
        low, high = part_of(region, scene.spacing).bounds()
        if (high - low > room).any():
            size = " x ".join(f"{length:.4g}" for length in high - low)
            faults.append(Fault(f"fluid[{index}]", f"is {size} m large, larger than the tank; is a unit missing?"))
    return faults


def particles_expected(scene: SphScene) -> float:
    """A rough upper bound of the number of particles, before they are placed."""
    total = 0.0
    for region in scene.fluid:
        low, high = part_of(region, scene.spacing).bounds()
        total += float(np.prod((high - low) / scene.spacing + 1.0))
    return total


FIRST_LISTS = 1.1
"""The range of lists over the support; it is 1.03 to 1.25, depending on the speed of the flow."""
WHILE_OBSERVED = 14
"""Numbers per particle that exist while the energies of a frame are summed, at most; measured in 2D and 3D."""
INT32, DOUBLE = 4.0, 8.0
"""Bytes of a number."""


ALLOCATED = 1.1
"""The memory that a run takes per particle over that of its arrays: 1.02 in 3D, 1.2 in 2D, measured. The allocator
keeps some of the memory of arrays that larger ones have replaced.
"""


def bytes_per_particle(scene: SphScene) -> float:
    """The memory per particle (bytes) that a run takes."""
    return ALLOCATED * bytes_of_arrays(scene)


def bytes_of_arrays(scene: SphScene) -> float:
    """The memory per particle (bytes) of the arrays that are in use while a frame is made: state, tables, lists, the
    frame, and what its energies, forces and surface need meanwhile; and of those while lists are made, which the
    allocator keeps.

    Rows of tables that a scene does not use are never written, and take no memory. One wall along each axis is assumed
    to have images or dummies.
    """
    dimension, spacing = len(scene.tank.low), scene.spacing
    reach = FIRST_LISTS * kernel_of(scene).support * smoothing_of(scene)
    number = INT32 if scene.method.precision == "single" else DOUBLE
    # position, velocity, acceleration, reference; density, its rate, mass, numbers
    state = DOUBLE * (4 * dimension + 5)
    fields = number * (3 * dimension + 9)  # position and two velocities; nine scalars
    rates = number * (dimension + 2)
    made = DOUBLE * 2 * dimension + INT32 * 2  # two orders of positions; cells, and the places in them
    lists = 3.0 * INT32 + INT32 * likely_neighbors(dimension, reach / spacing)
    frame = DOUBLE * (2 * dimension + 4 + WHILE_OBSERVED)  # two vectors and four scalars
    return state + entries_per_particle(scene, reach) * (fields + number * RECORD + made) + rates + lists + frame


def entries_per_particle(scene: SphScene, reach: float) -> float:
    """The entries of fields, with images or dummies behind one wall along each axis, per particle."""
    sizes = [np.subtract(*reversed(part_of(region, scene.spacing).bounds())) for region in scene.fluid]
    return float(sum(np.prod(size + reach) for size in sizes) / sum(np.prod(size) for size in sizes))


def diagnosis(parameters: Parameters, state: State) -> str:
    """The message on the first particle that failed, with the time and the remedy."""
    if parameters.projection is not None and failed(parameters.projection, state):
        return unsolved(parameters, state)
    with np.errstate(over="ignore"):  # a diverged particle may have an infinite speed
        speed = np.sqrt((state.velocity**2).sum(axis=0))
    terms = {"position": state.position.T, "density": state.density, "velocity": state.velocity.T, "speed": speed}
    broken = first_broken({**terms, "acceleration": state.acceleration.T})
    worst = int(np.argmax(speed)) if broken is None else broken.particle
    what = (
        f"moves at {with_prefix(speed[worst], 'm/s', 3)}"
        if broken is None
        else f"has a {broken.term} that is not finite"
    )
    where = ", ".join(f"{x:.4g}" for x in state.position[:, worst])
    expected = with_prefix(parameters.material.fastest, "m/s", 3)
    return (
        f"{when(parameters, state)} particle {int(state.identity[worst])} {what} (at {where} m); the maximum "
        f"speed is {expected}. Set liquid.maximum_speed to a speed that the flow reaches, or "
        f"integration.courant_number to {0.5 * parameters.courant:.2g}, or look for liquid that starts inside of "
        "other liquid or of a wall"
    )


def unsolved(parameters: Parameters, state: State) -> str:
    """The message that the pressure did not converge: the particle with the largest error, and the remedy."""
    settings = parameters.projection
    assert settings is not None  # noqa: S101  # only a solver fails
    worst = int(np.flatnonzero(state.identity == int(state.tally[WORST]))[0])
    where = ", ".join(f"{x:.4g}" for x in state.position[:, worst])
    return (
        f"{when(parameters, state)} the pressure did not converge: got an error of {state.tally[RESIDUAL]:.2g} of the "
        f"density after {settings.iterations} iterations, the largest at particle {int(state.identity[worst])} (at "
        f"{where} m); expected {settings.tolerance:.2g} or less. Set integration.pressure_iterations to "
        f"{2 * settings.iterations}, integration.pressure_tolerance to {10.0 * settings.tolerance:.2g}, or "
        f"integration.courant_number to {0.5 * parameters.courant:.2g}"
    )


def summary(scene: SphScene) -> list[Row]:
    """The rows of `ecume check`: name, value with unit, remark."""
    parameters = checked_parameters(scene)
    state = start(scene, parameters)
    return advice(scene, parameters, state.position, bytes_per_particle(scene))


def extended(laws: Sequence[BoundLaw]) -> Model:
    """The model with user laws."""
    from ecume.models.sph import user_laws

    return user_laws.extended(SPH, laws)


SPH = Model(
    name="sph",
    state=State,
    parameters=checked_parameters,
    start=start,
    layout=layout,
    workspace=workspace,
    advance=advance,
    observe=observe,
    constant=frozenset(["mass", "species"]),
    main_numbers=("kinetic_energy", "total_energy", "largest_speed", "largest_pressure", "density_change"),
    diagnosis=diagnosis,
    invariants=invariants,
    laws=laws_of,
    summary=summary,
    exchange=exchange,
    access=TANKS,
    extended=extended,
)
