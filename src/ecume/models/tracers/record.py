"""The tracers, as the driver sees them: observing, diagnosis, summary."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ecume.laws import brownian_motion, carrier_flows, drag, gases, unsteady_forces
from ecume.models.costs import Content, frame_cost, require_memory, within_steps
from ecume.models.diagnosis import first_broken, when
from ecume.models.gravity import gravity_text
from ecume.models.invariants import INJECTED, Invariant, NumberHistory, Numbers, energy_never_rises
from ecume.models.liquids import correlations_of
from ecume.models.model import Model, Source
from ecume.models.size_report import sizes_rows
from ecume.models.step_counts import last_step
from ecume.models.tracers import gridded_flows
from ecume.models.tracers.drag_laws import DRAGS
from ecume.models.tracers.energy_budget import exchange, has_external_work, overdamped_kinetic_energy
from ecume.models.tracers.flow_loops import loops_for
from ecume.models.tracers.flow_steps import advance
from ecume.models.tracers.liquid_flow import LiquidFlow, OwnShape, varying_flow
from ecume.models.tracers.named_flows import DETOURS, NAMED_FLOWS
from ecume.models.tracers.openings import species_of
from ecume.models.tracers.parameters import (
    AIR,
    CAPPED,
    Fluid,
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
from ecume.models.tracers.tank import around, body_of, bounds
from ecume.models.tracers.time_stepping import UNBOUNDED
from ecume.scenes.tracers import ObstacleSpec, TracersScene
from ecume.trajectories.frame import Frame
from ecume.trajectories.gsd import SIDES
from ecume.units import Array, duration_text, size_text, with_prefix

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
SECONDS_PER_STEP = 2e-5
SECONDS_PER_PARTICLE = 5e-7
BYTES_PER_PARTICLE = 940
"""Resident at the most, while frames are recorded: measured with 1e5 and 4e5 particles in 3D."""
NUMBERS = 20
"""The approximate number of numbers in a frame."""


def checked_parameters(scene: TracersScene) -> Parameters:
    """The parameters of a scene. Raises SceneError if memory or steps exceed the limits."""
    count = sum(species.count for species in scene.particles)
    require_memory("particles", f"{count} particles", BYTES_PER_PARTICLE * count)
    parameters = within_steps(scene, parameters_of(scene))
    for _, speed, remark in through_solids(scene, parameters):
        warnings.warn(f"obstacles: {remark} ({speed})", FlowWarning, stacklevel=2)
    return parameters


class FlowWarning(UserWarning):
    """The flow of a scene is not one that a liquid can have."""


def observe(parameters: Parameters, state: State, scratch: Workspace) -> Frame:
    """The frame of this instant. Particles that left remain at their exit, and are ignored in numbers."""
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
        **{f"came_through_opening_{m}": float((entered == m).sum()) for m in range(holes)},
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
    """The particle without a finite position, the time, and the remedy."""
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
    """The positions, with NaN for values too large to be one."""
    return np.where(np.abs(numbers) < UNBOUNDED, numbers, np.nan)


def summary(scene: TracersScene) -> list[tuple[str, str, str]]:
    """Derived numbers: name, value with unit, remark. Raises SceneError for whatever would keep a run from starting."""
    parameters = checked_parameters(scene)
    start(scene, parameters)
    fluid = parameters.fluid
    steps, count = last_step(scene, parameters.steps_per_frame), len(parameters.bodies.radius)
    stepping = steps * (SECONDS_PER_STEP + SECONDS_PER_PARTICLE * count)
    vectors = dict.fromkeys(("position", "velocity"), scene.dimensions)
    cost = frame_cost(scene, Content(count, {**vectors, "speed": 1, "left": 1}, NUMBERS), steps)
    return [
        ("liquid", f"{fluid.density:.4g} kg/m^3, {with_prefix(fluid.viscosity, 'Pa s')}", scene.liquid.name),
        ("gravity", *gravity_text((*(0.0,) * (scene.dimensions - 1), -fluid.gravity))),
        *(row for index in range(len(scene.particles)) for row in summary_of(scene, parameters, index)),
        *sizes_rows(parameters.bodies.radius),
        *flow_rows(scene, parameters),
        *through_solids(scene, parameters),
        ("walls", str(len(parameters.bouncing.kind)), f"{len(scene.openings)} openings"),
        *(row for index in range(len(scene.openings)) for row in coming(scene, parameters, index)),
        ("time step", with_prefix(parameters.time_step, "s"), accuracy_of(parameters)),
        ("steps", str(steps), f"{parameters.steps_per_frame} per frame"),
        *cost.rows(),
        ("memory", size_text(count * BYTES_PER_PARTICLE), f"{count} particles"),
        ("time on this machine", duration_text(stepping + cost.seconds), f"roughly{cost.remark(stepping)}"),
    ]


def accuracy_of(parameters: Parameters) -> str:
    """The accuracy of a time step."""
    if parameters.current == ():
        return "exact between walls for linear drag"
    smooth = parameters.fluid.thermal == 0.0 and bool(parameters.bodies.overdamped.all())
    return f"of {'fourth' if smooth else 'second'} order in a flow that varies"


def coming(scene: TracersScene, parameters: Parameters, index: int) -> list[tuple[str, str, str]]:
    """The particles that will enter through an opening."""
    count = int((parameters.arrivals.opening == index).sum())
    hole = scene.openings[index]
    if hole.rate is None and hole.concentration is None:
        return []
    species = scene.particles[species_of(scene, hole)].name
    return [(f"opening {index}", f"{count} enter", f"of {species}, {count / scene.duration:.4g} per second")]


def summary_of(scene: TracersScene, parameters: Parameters, index: int) -> list[tuple[str, str, str]]:
    """The rows of one species."""
    fluid, bodies, species = parameters.fluid, parameters.bodies, scene.particles[index]
    first = int(np.argmax(bodies.species == index))
    mass, friction, speed = (float(values[first]) for values in (bodies.mass, bodies.friction, bodies.settling))
    name, rows = species.name, []
    if friction > 0.0:
        reynolds = drag.particle_reynolds(abs(speed), float(bodies.radius[first]), fluid.density, fluid.viscosity)
        way = "sinks" if speed > 0.0 else "rises" if speed < 0.0 else "neutrally buoyant"
        regime = "overdamped: without inertia" if bodies.overdamped[first] else "inertial"
        rows += [
            (f"{name}: terminal speed", with_prefix(abs(speed), "m/s"), f"{way}; Reynolds number {reynolds:.3g}"),
            (f"{name}: relaxation time", with_prefix(drag.relaxation_time(mass, friction), "s"), regime),
        ]
        rows += slip_of(scene, fluid, index)
    if fluid.thermal > 0.0 and friction > 0.0:
        spread, weight = (
            brownian_motion.diffusivity(fluid.thermal, friction),
            abs(mass * float(bodies.apparent_gravity[first])),
        )
        rows.append((f"{name}: diffusion coefficient", with_prefix(spread, "m^2/s"), "along each axis <x^2> = 2 D t"))
        if weight > 0.0:
            layer = brownian_motion.sedimentation_length(fluid.thermal, weight)
            rows.append(
                (f"{name}: sedimentation length", with_prefix(layer, "m"), "height of the layer in equilibrium")
            )
    return rows


SLIPS = 0.01
"""The Knudsen number from which a remark states the slip: 1.3 % of the speed."""


def slip_of(scene: TracersScene, fluid: Fluid, index: int) -> list[tuple[str, str, str]]:
    """The slip of a gas along one species, estimated at one atmosphere where the scene states no mean free path."""
    known, path, species = fluid.mean_free_path > 0.0, fluid.mean_free_path, scene.particles[index]
    if not known and 0.0 < fluid.density < gases.DENSEST:
        path = gases.mean_free_path(fluid.density, fluid.viscosity, gases.ATMOSPHERE)
    if path < SLIPS * species.radius:
        return []
    factor = drag.cunningham_factor(path, species.radius)
    remark = f"the gas slips: {factor:.3g} times as fast as by Stokes's law"
    if not known:
        remark = f"Stokes's law is {factor:.3g} times too slow in a gas at 1 atm: set liquid.mean_free_path"
        remark += f' = "{with_prefix(path, "m", 3)}"'
    return [(f"{species.name}: Knudsen number", f"{path / species.radius:.3g}", remark)]


CROSSING = 0.01
"""The reported normal velocity at the surface of an obstacle, over the largest speed."""


def flow_at(parameters: Parameters, places: Array) -> Array:
    """(n, d) the velocity of the liquid at places, at time 0 (m/s)."""
    fluid, current, d = parameters.fluid, parameters.current, parameters.dimensions
    loops = None if current == () or isinstance(current.shape, OwnShape) else loops_for(current, d)
    return LiquidFlow(np.array(fluid.flow), fluid.shear_rate, current, loops).velocity(places, 0.0)


def flow_through(parameters: Parameters, body: ObstacleSpec) -> float:
    """The largest velocity of the liquid normal to the surface of an obstacle (m/s)."""
    places, normals = surface_points(body)
    return float(np.abs((flow_at(parameters, places) * normals).sum(axis=1)).max())


def surface_points(body: ObstacleSpec) -> tuple[Array, Array]:
    """Points on an obstacle, and the normals there."""
    low, high = (np.array(corner, float) for corner in around(body))
    surfaces, middle = body_of(body), 0.5 * (low + high)
    ways = np.random.default_rng(0).normal(size=(POINTS, len(low)))
    ways /= np.sqrt((ways**2).sum(axis=1))[:, None]
    if body.radius is not None:
        return middle + body.radius * ways, ways
    # Each way from the middle ends at the nearest plane that it meets.
    inward = surfaces.place[:, : len(low)]
    if body.vertices:
        middle = np.mean(np.array(body.vertices, float), axis=0)
    depth = middle @ inward.T + surfaces.size
    with np.errstate(divide="ignore", invalid="ignore"):
        far = np.where(ways @ inward.T < 0.0, depth / -(ways @ inward.T), np.inf)
    face = far.argmin(axis=1)
    return middle + far[np.arange(POINTS), face][:, None] * ways, -inward[face]


POINTS = 400
"""On an obstacle, at which the flow is examined."""


def largest_flow(parameters: Parameters, low: Array, high: Array) -> float:
    """The largest speed of the liquid around a box (m/s)."""
    wide = 0.5 * (high - low)
    places = np.random.default_rng(0).uniform(low - wide, high + wide, (POINTS, len(low)))
    return float(np.sqrt((flow_at(parameters, places) ** 2).sum(axis=1)).max())


def flow_rows(scene: TracersScene, parameters: Parameters) -> list[tuple[str, str, str]]:
    """The flow that varies in place or time."""
    if parameters.current == ():
        return []
    given = scene.flow
    by_keys = given.name or given.field is not None or given.around_obstacles != "none"
    if scene.user_laws and not by_keys:  # the flow may be one of the laws
        return []
    flow = varying_flow(scene, bounds(scene))
    past = f"{given.around_obstacles}, around the obstacle"
    plain = "uniform or sheared" if given.around_obstacles == "none" else past
    scales, what = flow.scales, given.name or ("from a file" if given.field is not None else plain)
    length = with_prefix(scales.length, "m", 3) if math.isfinite(scales.length) else "infinity"
    rows = [("flow", with_prefix(scales.speed, "m/s", 3), f"{what}: largest speed; changes over {length}")]
    viscosity = parameters.fluid.viscosity / parameters.fluid.density
    if given.around_obstacles == "creeping" and viscosity > 0.0:
        reynolds = 2.0 * flow.current.shape.radius * float(np.sqrt((flow.uniform**2).sum())) / viscosity
        rows.append(("obstacle: Reynolds number", f"{reynolds:.3g}", "the creeping flow is that at numbers below 1"))
    if given.name == "tube" and not (scene.tank is not None and scene.tank.vertices):
        rows.append(("wall of the tube", "none", "the tank alone turns particles back: beyond the radius they go on"))
    slow = int(parameters.bodies.overdamped.sum())
    if parameters.forces.any and slow:
        remark = "fluid_acceleration, faxen and lift act on particles with inertia only"
        rows.append(("forces of the flow", f"none on {slow} of {len(parameters.bodies.radius)} particles", remark))
    if viscosity > 0.0 and scales.rate > 0.0:
        ratio = unsteady_forces.history_ratio(float(parameters.bodies.radius.max()), viscosity, scales.rate)
        rows.append(("history force", f"{ratio:.2g}", "Basset's over Stokes's drag: not included"))
    if scene.flow.field is not None:
        remark = "of the fluxes of the file is divergence, which the interpolation omits"
        if scene.flow.field.interpolation == "linear":
            rows.append(("divergence", "kept", "the interpolation is linear: particles may cluster"))
        else:
            rows.append(("divergence", f"{100.0 * flow.removed:.2g} %", remark))
    return rows


def through_solids(scene: TracersScene, parameters: Parameters) -> list[tuple[str, str, str]]:
    """The flow through obstacles, with its size: the liquid does not go around them."""
    rows = []
    for index, body in enumerate(scene.obstacles):
        low, high = (np.array(corner) for corner in around(body))
        speed, usual = flow_through(parameters, body), largest_flow(parameters, low, high)
        if speed > CROSSING * usual:
            size, bodies = 0.5 * float((high - low).max()), parameters.bodies
            slowest = float((bodies.mass / np.where(bodies.friction > 0.0, bodies.friction, np.inf)).max())
            remark = "the flow does not go around obstacles: particles in their way are held against the front; Stokes "
            remark += f"number {slowest * speed / size:.2g}"
            remark += ": in a real flow they would pass by" if slowest * speed < 0.1 * size else ""
            rows.append((f"flow through obstacle {index}", with_prefix(speed, "m/s"), remark))
    return rows


# --- Invariants of tracers: their number and their energy


RISE = 1e-6
"""The permitted relative rise of the energy; flights between walls are exact."""


def invariants(scene: TracersScene, parameters: Parameters) -> list[Invariant]:
    """The rows of a scene. The work of liquid and openings is in the energy budget, see `energy_budget`."""
    every = Invariant("mass", "particles that are neither inside nor gone through an opening", 0.0, _missing)
    return [every, energy_never_rises(RISE)]


def _missing(seen: NumberHistory) -> float:
    """The number of particles missing from the balance of those at the start, entered, left and present."""
    entered_count = _through("came", seen.now) - _through("came", seen.first)
    gone = _through("left", seen.now) - _through("left", seen.first)
    held = _deposited(seen.now) - _deposited(seen.first)
    return abs(seen.first["particles_inside"] + entered_count - gone - held - seen.now["particles_inside"])


def _through(way: str, numbers: Numbers) -> float:
    return sum(value for name, value in numbers.items() if name.startswith(f"{way}_through_opening_"))


def _deposited(numbers: Numbers) -> float:
    return sum(value for name, value in numbers.items() if name.startswith("deposited_on_wall_"))


# --- The laws behind a scene of tracers, whose docstrings cite the papers


def laws_of(scene: Any) -> list[Source]:
    """Drag and heat."""
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
    flow += [around.law] if around is not None else []
    given = scene.hydrodynamics
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
    """The tracers with external laws of the user."""
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
