"""Rows of `ecume check` for tracers: speeds, diffusion, slip, the flow, flow through obstacles, and costs."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from ecume.laws import brownian_motion, drag, gases, unsteady_forces
from ecume.models.costs import Content, frame_cost
from ecume.models.expected_events import event_row
from ecume.models.gravity import gravity_text
from ecume.models.size_report import sizes_rows
from ecume.models.step_counts import last_step
from ecume.models.tracers.liquid_flow import LiquidFlow, OwnShape
from ecume.models.tracers.openings import species_of
from ecume.models.tracers.parameters import (
    Fluid,
    Parameters,
)
from ecume.models.tracers.start import start
from ecume.models.tracers.tank import around, body_of, bounds
from ecume.scenes.tracers import ObstacleSpec, TracersScene
from ecume.units import Array, duration_text, size_text, with_prefix

SECONDS_PER_STEP = 2e-5
SECONDS_PER_PARTICLE = 5e-7
BYTES_PER_PARTICLE = 680
"""Largest resident memory per particle, in 3D while two frames are in memory: measured with 4e5 particles. Of these 56
are the state, 72 the bodies, 96 to 220 the workspace and 88 a frame.
"""
NUMBERS = 20
"""The approximate number of numbers in a frame."""


def summary_in(scene: TracersScene, parameters: Parameters, flow: LiquidFlow) -> list[tuple[str, str, str]]:
    """The rows of `ecume check` in a flow, which may be a function of the user."""
    first = start(scene, parameters)
    fluid = parameters.fluid
    steps, count = last_step(scene, parameters.steps_per_frame), len(parameters.bodies.radius)
    openings = len(scene.openings)
    stepping = steps * (SECONDS_PER_STEP + SECONDS_PER_PARTICLE * count)
    vectors = dict.fromkeys(("position", "velocity"), scene.dimensions)
    cost = frame_cost(scene, Content(count, {**vectors, "speed": 1, "left": 1}, NUMBERS), steps)
    return [
        ("liquid", f"{fluid.density:.4g} kg/m^3, {with_prefix(fluid.viscosity, 'Pa s')}", scene.liquid.name),
        ("gravity", *gravity_text((*(0.0,) * (scene.dimensions - 1), -fluid.gravity))),
        *(row for index in range(len(scene.particles)) for row in summary_of(scene, parameters, index)),
        *sizes_rows(parameters.bodies.radius),
        *flow_rows(scene, parameters, flow),
        *started_on_land(scene, flow, first.position),
        *through_solids(scene, parameters, flow),
        ("walls", str(len(parameters.bouncing.kind)), f"{openings} opening{'' if openings == 1 else 's'}"),
        *(row for index in range(len(scene.openings)) for row in coming(scene, parameters, index)),
        ("time step", with_prefix(parameters.time_step, "s"), accuracy_of(parameters, flow)),
        ("steps", str(steps), f"{parameters.steps_per_frame} per frame"),
        *cost.rows(),
        ("memory", size_text(count * BYTES_PER_PARTICLE), f"{count} particles"),
        ("time on this machine", duration_text(stepping + cost.seconds), f"roughly{cost.remark(stepping)}"),
    ]


TOO_LONG = 5.0
"""The step from which a remark says that it does not resolve the flow, over the longest one that does."""


def accuracy_of(parameters: Parameters, flow: LiquidFlow) -> str:
    """The row on the accuracy of the time step."""
    if parameters.current == ():
        return "exact between walls for linear drag"
    fits = flow.scales.longest_step()
    if parameters.time_step > TOO_LONG * fits:
        return f"too long for a flow that changes this fast: set integration.time_step to {with_prefix(fits, 's', 2)}"
    if parameters.around != () and parameters.bodies.overdamped.any():
        return "of first order where the diffusivity depends on place; exact in equilibrium"
    smooth = parameters.fluid.thermal == 0.0 and bool(parameters.bodies.overdamped.all())
    return f"of {'fourth' if smooth else 'second'} order in a flow that varies"


def coming(scene: TracersScene, parameters: Parameters, index: int) -> list[tuple[str, str, str]]:
    """The number of particles that will enter through an opening."""
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
        if parameters.current == ():
            pull = 0.0 if bodies.overdamped[first] else abs(float(bodies.apparent_gravity[first]))
            rows += settled(scene, name, speed - fluid.flow[scene.dimensions - 1], pull)
    if fluid.thermal > 0.0 and friction > 0.0:
        spread, weight = (
            brownian_motion.diffusivity(fluid.thermal, friction),
            abs(mass * float(bodies.apparent_gravity[first])),
        )
        rows.append((f"{name}: diffusion coefficient", with_prefix(spread, "m^2/s"), "along each axis <x^2> = 2 D t"))
        if weight > 0.0:
            layer = brownian_motion.sedimentation_length(fluid.thermal, weight)
            noise = math.sqrt(2.0 * spread * parameters.time_step)
            corners = corners_remark(scene, noise / layer) if bodies.overdamped[first] else ""
            remark = f"height of the layer in equilibrium{corners}"
            rows.append((f"{name}: sedimentation length", with_prefix(layer, "m"), remark))
    return rows


def corners_remark(scene: TracersScene, ratio: float) -> str:
    """The remark on a sediment layer that is thinner than the noise of a step by this ratio. It is empty if the step
    resolves the layer, and if all walls are at right angles.
    """
    right = scene.tank is None or (scene.tank.high is not None and not scene.obstacles)
    if ratio <= 1.0 or right:
        return ""
    return f"; the noise of a step is {ratio:.2g} times it: wrong by half in corners, set a shorter time_step"


def settled(scene: TracersScene, name: str, speed: float, pull: float) -> list[tuple[str, str, str]]:
    """The row on the time in which one species crosses a box from rest at a downward terminal speed (m/s), which it
    reaches with the acceleration `pull` (m/s^2; 0 of particles without inertia). It is empty without bottom and top,
    and if particles may leave.
    """
    tank = scene.tank
    if tank is None or tank.high is None or "xyz"[scene.dimensions - 1] in tank.periodic or scene.openings:
        return []
    height = float(tank.high[-1]) - (float(tank.low[-1]) if tank.low is not None else 0.0)
    way, time = "settles" if speed > 0.0 else "rises", fall_time(height, abs(speed), pull)
    times = scene.duration, scene.frame_every
    return event_row(f"{name}: {way}", time, times, "over the height of the tank, without noise")


def fall_time(height: float, speed: float, pull: float) -> float:
    """The time (s) of a fall from rest over a height (m) with a terminal speed (m/s) and an initial acceleration
    (m/s^2): sqrt((H/W)^2 + 2 H/g), right for short and for long falls with linear drag. Without acceleration H/W.
    """
    if speed == 0.0:
        return math.inf
    return math.sqrt((height / speed) ** 2 + (2.0 * height / pull if pull > 0.0 else 0.0))


SLIPS = 0.01
"""The Knudsen number from which a remark states the slip: 1.3 % of the speed."""


def slip_of(scene: TracersScene, fluid: Fluid, index: int) -> list[tuple[str, str, str]]:
    """The row on the slip of one species in a gas, estimated at one atmosphere unless the scene gives a mean free
    path.
    """
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


def flow_through(flow: LiquidFlow, body: ObstacleSpec) -> float:
    """The largest velocity of the liquid normal to the surface of an obstacle, at time 0 (m/s)."""
    places, normals = surface_points(body)
    return float(np.abs((flow.velocity(places, 0.0) * normals).sum(axis=1)).max())


def surface_points(body: ObstacleSpec) -> tuple[Array, Array]:
    """Points on an obstacle, and the surface normals there."""
    low, high = (np.array(corner, float) for corner in around(body))
    surfaces, middle = body_of(body), 0.5 * (low + high)
    ways = np.random.default_rng(0).normal(size=(POINTS, len(low)))
    ways /= np.sqrt((ways**2).sum(axis=1))[:, None]
    if body.radius is not None:
        return middle + body.radius * ways, ways
    # Each ray from the center ends at the nearest plane.
    inward = surfaces.place[:, : len(low)]
    if body.vertices:
        middle = np.mean(np.array(body.vertices, float), axis=0)
    depth = middle @ inward.T - surfaces.size
    with np.errstate(divide="ignore", invalid="ignore"):
        far = np.where(ways @ inward.T < 0.0, depth / -(ways @ inward.T), np.inf)
    face = far.argmin(axis=1)
    return middle + far[np.arange(POINTS), face][:, None] * ways, -inward[face]


POINTS = 400
"""The number of points on an obstacle at which the flow is sampled."""


def largest_flow(flow: LiquidFlow, low: Array, high: Array) -> float:
    """The largest speed of the liquid in and around a box, at time 0 (m/s)."""
    wide = 0.5 * (high - low)
    places = np.random.default_rng(0).uniform(low - wide, high + wide, (POINTS, len(low)))
    return float(np.sqrt((flow.velocity(places, 0.0) ** 2).sum(axis=1)).max())


def flow_rows(scene: TracersScene, parameters: Parameters, flow: LiquidFlow) -> list[tuple[str, str, str]]:
    """The rows on a flow that varies in place or time."""
    if parameters.current == ():
        return history_while_relaxing(parameters)
    given = scene.flow
    past = f"{given.around_obstacles}, around {'the obstacle' if len(scene.obstacles) == 1 else 'obstacles'}"
    past_obstacles = given.around_obstacles != "none"
    own = "by a function of the user" if isinstance(flow.current.shape, OwnShape) else "uniform or sheared"
    plain = own if given.around_obstacles == "none" else past
    scales, what = (
        flow.scales,
        ("" if past_obstacles else given.name) or ("from a file" if given.field is not None else plain),
    )
    length = with_prefix(scales.length, "m", 3) if math.isfinite(scales.length) else "infinity"
    rows = [("flow", with_prefix(scales.speed, "m/s", 3), f"{what}: largest speed; changes over {length}")]
    viscosity = parameters.fluid.viscosity / parameters.fluid.density
    if given.around_obstacles == "creeping" and viscosity > 0.0:
        size = max(float(np.max(np.subtract(*around(body)[::-1]))) for body in scene.obstacles)
        reynolds = size * (abs(given.speed) if given.speed else float(np.sqrt((flow.uniform**2).sum()))) / viscosity
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
    rows += [row for row, _ in beyond_field(scene, parameters)]
    if scene.flow.field is not None:
        remark = "of the fluxes of the file is divergence, which the interpolation omits"
        if scene.flow.field.interpolation == "linear":
            rows.append(("divergence", "kept", "the interpolation is linear: particles may cluster"))
        else:
            rows.append(("divergence", f"{100.0 * flow.removed:.2g} %", remark))
    return rows


def history_while_relaxing(parameters: Parameters) -> list[tuple[str, str, str]]:
    """The row on Basset's force on particles with inertia, as they reach their terminal speed in a steady flow."""
    bodies, fluid = parameters.bodies, parameters.fluid
    dragged = (bodies.overdamped == 0) & (bodies.friction > 0.0)
    if not dragged.any() or fluid.viscosity == 0.0:
        return []
    rates = bodies.friction[dragged] / bodies.mass[dragged]
    grains = set(zip(bodies.radius[dragged].tolist(), rates.tolist(), strict=True))
    viscosity = fluid.viscosity / fluid.density
    ratio = max(unsteady_forces.history_ratio(radius, viscosity, rate) for radius, rate in grains)
    remark = "Basset's over Stokes's drag before the terminal speed is reached: not included"
    return [("history force", f"{ratio:.2g}", remark)]


STILL = 1e-9
"""The speed of liquid on land, up to rounding, over the largest one."""


def started_on_land(scene: TracersScene, flow: LiquidFlow, position: Array) -> list[tuple[str, str, str]]:
    """The row on particles that start where a file has no velocities."""
    if scene.flow.field is None or flow.scales.speed == 0.0:
        return []
    speed = np.sqrt((flow.velocity(position, 0.0) ** 2).sum(axis=1))
    count = int((speed < STILL * flow.scales.speed).sum())
    remark = f"of {len(position)} particles, where the file has no velocity: weight and noise alone move them"
    return [("start on land", str(count), remark)] if count else []


BEYOND = 0.1
"""The part of the tank beyond the grid of a file from which a run warns."""


def beyond_field(scene: TracersScene, parameters: Parameters) -> list[tuple[tuple[str, str, str], bool]]:
    """The rows on the parts of the tank and of the run for which a file has no velocities, and whether they are a
    warning; empty if the file covers both. The tank beyond the liquid of a recorded run is no warning.
    """
    field = scene.flow.field
    if field is None:
        return []
    rows, shape = [], parameters.current.shape
    (low, high), (left, right) = bounds(scene), covered(shape, scene.dimensions)
    sides = np.subtract(high, low)
    common = np.clip(np.minimum(right, high) - np.maximum(left, low), 0.0, None)
    missing = 1.0 - float(np.prod(common / sides))
    if missing > 1e-6 and scene.tank is not None:
        remark = "of the tank is beyond the grid of the file: velocities there are those at its edge"
        rows.append((("beyond the grid", f"{100.0 * missing:.3g} %", remark), missing > BEYOND and not of_run(scene)))
    first, last = float(shape.times[0]), float(shape.times[-1])
    if len(shape.times) > 1 and (first > 0.0 or last < scene.duration * (1.0 - 1e-9)):
        value = f"{with_prefix(first, 's', 3)} to {with_prefix(last, 's', 3)}"
        remark = "of the file; before and after these times its first and last velocities hold"
        rows.append((("times of the flow", value, remark), True))
    return rows


def of_run(scene: TracersScene) -> bool:
    """Whether the flow is that of a recorded run."""
    return scene.flow.field is not None and Path(scene.flow.field.file).is_dir()


def covered(shape: Any, dimensions: int) -> tuple[Array, Array]:
    """The corners (d,) of the grid of a flow from a file, in m."""
    if hasattr(shape, "along"):
        nodes = shape.along.shape[1], shape.across.shape[2], shape.upward.shape[3]
    else:
        nodes = shape.nodes.shape[1:-1]
    low, step, count = (np.array(each, float) for each in (shape.low, shape.step, nodes))
    used = [0, 2] if dimensions == 2 and len(low) == 3 else list(range(dimensions))
    return low[used], (low + step * (count - 1.0))[used]


def through_solids(scene: TracersScene, parameters: Parameters, flow: LiquidFlow) -> list[tuple[str, str, str]]:
    """The row on liquid that flows through the surfaces of obstacles, with its largest normal velocity."""
    rows = []
    for index, body in enumerate(scene.obstacles):
        low, high = (np.array(corner) for corner in around(body))
        speed, usual = flow_through(flow, body), largest_flow(flow, low, high)
        if speed > CROSSING * usual:
            size, bodies = 0.5 * float((high - low).max()), parameters.bodies
            slowest = float((bodies.mass / np.where(bodies.friction > 0.0, bodies.friction, np.inf)).max())
            remark = "the flow does not go around obstacles: particles in their way are held against the front; Stokes "
            remark += f"number {slowest * speed / size:.2g}"
            remark += ": in a real flow they would pass by" if slowest * speed < 0.1 * size else ""
            rows.append((f"flow through obstacle {index}", with_prefix(speed, "m/s"), remark))
    return rows
