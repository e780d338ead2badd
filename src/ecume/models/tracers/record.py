"""The record of the tracer model: the functions that a run calls."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ecume.laws import brownian_motion, carrier_flows, drag, gases, unsteady_forces, wall_drag
from ecume.models import gridded_flows
from ecume.models.costs import require_memory, within_steps
from ecume.models.diagnosis import first_broken, when
from ecume.models.invariants import INJECTED, Invariant, NumberHistory, Numbers, energy_never_rises
from ecume.models.liquids import correlations_of
from ecume.models.model import Model, Source
from ecume.models.tracers import obstacle_flows, obstacle_flows_3d
from ecume.models.tracers.check_report import BYTES_PER_PARTICLE, beyond_field, summary_in, through_solids
from ecume.models.tracers.drag_laws import DRAGS
from ecume.models.tracers.energy_budget import exchange, has_external_work, overdamped_kinetic_energy
from ecume.models.tracers.flow_loops import loops_for
from ecume.models.tracers.flow_steps import advance
from ecume.models.tracers.liquid_flow import LiquidFlow, OwnShape, varying_flow
from ecume.models.tracers.named_flows import DETOURS, NAMED_FLOWS
from ecume.models.tracers.parameters import (
    AIR,
    CAPPED,
    Parameters,
    State,
    Workspace,
    entered_count,
    fluid_of,
    parameters_of,
    workspace,
)
from ecume.models.tracers.parameters import TRACERS as ACCESS
from ecume.models.tracers.start import layout, start
from ecume.models.tracers.tank import bounds
from ecume.models.tracers.time_stepping import UNBOUNDED
from ecume.scenes.tracers import TracersScene
from ecume.trajectories.frame import Frame
from ecume.trajectories.gsd import SIDES
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.models.user_laws import BoundLaw

ARRAY_UNITS = {
    "position": "m",
    "velocity": "m/s",
    "speed": "m/s",
    "radius": "m",
    "density": "kg/m^3",
    "species": "1",
    "left": "1",
    "image": "1",
}


def checked_parameters(scene: TracersScene) -> Parameters:
    """The parameters of a scene. Raises SceneError if memory or steps exceed the limits."""
    count = sum(species.count for species in scene.particles)
    require_memory("particles", f"{count} particles", BYTES_PER_PARTICLE * count)
    parameters = within_steps(scene, parameters_of(scene))
    for _, speed, remark in through_solids(scene, parameters, flow_of(parameters)):
        warnings.warn(f"obstacles: {remark} ({speed})", FlowWarning, stacklevel=2)
    for (_, value, remark), warned in beyond_field(scene, parameters):
        if warned:
            warnings.warn(f"flow.field: {value} {remark}", FlowWarning, stacklevel=2)
    return parameters


def flow_of(parameters: Parameters) -> LiquidFlow:
    """The flow of the parameters, without its scales of variation; user-defined flows are not included."""
    fluid, current, d = parameters.fluid, parameters.current, parameters.dimensions
    loops = None if current == () or isinstance(current.shape, OwnShape) else loops_for(current, d)
    return LiquidFlow(np.array(fluid.flow), fluid.shear_rate, current, loops)


class FlowWarning(UserWarning):
    """The flow of a scene is not that of an incompressible liquid, or not known everywhere."""


def observe(parameters: Parameters, state: State, scratch: Workspace) -> Frame:
    """The frame of this instant. Particles that left remain at their exit, and do not contribute to numbers."""
    bodies, inside, there = parameters.bodies, np.flatnonzero(state.left < 0), len(state.left)
    speed = np.sqrt((state.velocity**2).sum(axis=1))
    mass, height = bodies.mass[inside], state.position[inside, -1]
    kinetic = 0.5 * float(np.sum(mass * speed[inside] ** 2))
    potential = float(np.sum(mass * bodies.apparent_gravity[inside] * height))
    entered = parameters.arrivals.opening[: entered_count(parameters, state)]
    arrays = {
        "position": state.position.copy(),
        "velocity": state.velocity.copy(),
        "speed": speed,
        "radius": bodies.radius[:there].copy(),
        "density": bodies.density[:there].copy(),
        "species": bodies.species[:there].copy(),
        "left": state.left.copy(),
    }
    if len(state.image):
        arrays["image"] = state.image.copy()
    every, holes = parameters.bouncing.hole, len(parameters.bouncing.hole) - parameters.deposits
    held = {int(wall): holes + m for m, wall in enumerate(every[holes:])}
    sides = {name: side for name, side in zip(SIDES, parameters.periodic.sides, strict=True) if side > 0.0}
    numbers = {
        "kinetic_energy": kinetic,
        "potential_energy": potential,
        "total_energy": kinetic + potential,
        "mean_height": float(height.mean()) if len(height) else 0.0,
        "largest_speed": float(speed[inside].max(initial=0.0)),
        "particles_inside": float(len(inside)),
        "hits": float(state.hits.sum()),
        **{f"hits_on_wall_{k}": float(count) for k, count in enumerate(state.hits)},
        **{f"left_through_opening_{m}": float((state.left == m).sum()) for m in range(holes)},
        **{f"entered_through_opening_{m}": float((entered == m).sum()) for m in range(holes)},
        **{f"deposited_on_wall_{k}": float((state.left == m).sum()) for k, m in held.items()},
        "flights_cut_short": float(state.tally[CAPPED]),
        **sides,
    }
    if has_external_work(parameters):
        numbers[INJECTED] = float(state.work[0]) + overdamped_kinetic_energy(parameters, state)
    units = {name: "J" if name.endswith(("energy", INJECTED)) else "1" for name in numbers}
    units |= {"mean_height": "m", "largest_speed": "m/s", **dict.fromkeys(sides, "m")}
    return Frame(int(state.step[0]) * parameters.time_step, arrays, numbers, {**ARRAY_UNITS, **units})


def diagnosis(parameters: Parameters, state: State) -> str:
    """The message on the particle without a finite position, with the time and the remedy."""
    broken = first_broken({"position": _somewhere(state.position), "velocity": _somewhere(state.velocity)})
    worst = int(np.argmax((state.velocity**2).sum(axis=1))) if broken is None else broken.particle
    what = f"is outside, at {state.position[worst].tolist()}"
    if broken is not None:
        what = f"has no finite {broken.term} any more"
    return (
        f"{when(parameters, state)} particle {worst} {what}: its step of {parameters.time_step:.3g} s was too "
        f"long. Set integration.time_step = {0.25 * parameters.time_step:.2g}"
    )


def _somewhere(numbers: Array) -> Array:
    """The positions, with NaN in place of values that are too large."""
    return np.where(np.abs(numbers) < UNBOUNDED, numbers, np.nan)


def summary(scene: TracersScene) -> list[tuple[str, str, str]]:
    """Derived numbers: name, value with unit, remark. Raises SceneError if the run could not start."""
    return summary_in(scene, checked_parameters(scene), varying_flow(scene, bounds(scene)))


# --- Invariants of tracers: their number and their energy


RISE = 1e-6
"""The permitted relative rise of the energy; flights between walls are exact."""


def invariants(scene: TracersScene, parameters: Parameters) -> list[Invariant]:
    """The invariants of a scene. The work of liquid and openings is in the energy budget, see `energy_budget`."""
    every = Invariant("mass", "particles that are neither inside nor gone through an opening", 0.0, _missing)
    return [every, energy_never_rises(RISE)]


def _missing(seen: NumberHistory) -> float:
    """The number of particles missing in the balance of initial, entered, left and present particles."""
    entered_count = _through("entered", seen.now) - _through("entered", seen.first)
    gone = _through("left", seen.now) - _through("left", seen.first)
    held = _deposited(seen.now) - _deposited(seen.first)
    return abs(seen.first["particles_inside"] + entered_count - gone - held - seen.now["particles_inside"])


def _through(way: str, numbers: Numbers) -> float:
    return sum(value for name, value in numbers.items() if name.startswith(f"{way}_through_opening_"))


def _deposited(numbers: Numbers) -> float:
    return sum(value for name, value in numbers.items() if name.startswith("deposited_on_wall_"))


# --- The laws behind a scene of tracers, whose docstrings cite the papers


def laws_of(scene: Any) -> list[Source]:
    """The sources of the laws of drag and diffusion."""
    heat: list[Source] = (
        [brownian_motion.diffusivity, brownian_motion.displacement_variance] if scene.hydrodynamics.brownian else []
    )
    medium: list[Source] = (
        [gases.air_density, gases.air_viscosity, gases.mean_free_path]
        if scene.liquid.name == AIR
        else correlations_of(scene.liquid.name)
    )
    slip: list[Source] = [drag.cunningham_factor] if fluid_of(scene).mean_free_path > 0.0 else []
    walls: list[Source] = [brownian_motion.reflected_gain] if scene.hydrodynamics.brownian else []
    named = NAMED_FLOWS.get(scene.flow.name)
    flow: list[Source] = [*named.papers] if named is not None else []
    around = DETOURS.get((scene.flow.around_obstacles, scene.dimensions))
    flow += [around] if around is not None and named is None else []
    if scene.flow.around_obstacles != "none" and named is not None:
        flow.append(obstacle_flows.channel_flow if scene.dimensions == 2 else obstacle_flows_3d.solid_flow)
    given = scene.hydrodynamics
    walls += [wall_drag.perpendicular_factor, wall_drag.parallel_factor] if given.wall_drag else []
    forces: dict[Source, bool] = {
        unsteady_forces.liquid_inertia: given.fluid_acceleration,
        unsteady_forces.faxen_velocity: given.faxen,
        unsteady_forces.saffman_lift: given.lift,
    }
    flow += [law for law, used in forces.items() if used]
    flow += [carrier_flows.time_factor] if scene.flow.pulse is not None else []
    field = scene.flow.field
    faces = field is not None and field.interpolation == "divergence-free" and scene.dimensions == 3
    grids: list[Source] = [gridded_flows.face_velocity] if faces else []
    return [*DRAGS[scene.hydrodynamics.drag].papers, *heat, *walls, *medium, *slip, *flow, *grids]


def extended(laws: Sequence[BoundLaw]) -> Model:
    """The model of tracers with user laws."""
    from ecume.models.tracers import user_laws

    return user_laws.extended(TRACERS, laws)


TRACERS = Model(
    name="tracers",
    state=State,
    parameters=checked_parameters,
    start=start,
    layout=layout,
    workspace=workspace,
    advance=advance,
    observe=observe,
    constant=frozenset(["radius", "density", "species"]),
    main_numbers=("kinetic_energy", "mean_height", "particles_inside", "hits"),
    diagnosis=diagnosis,
    exchange=exchange,
    access=ACCESS,
    extended=extended,
    invariants=invariants,
    laws=laws_of,
    summary=summary,
)
