"""Frames of tanks: particles in their initial order, pressures, gauges, numbers and invariants.

The four pressures of a liquid. Frames hold the gauge pressure; the others are derived from it and the position.

| name | definition |
|---|---|
| `pressure` | gauge pressure p, zero at the reference density |
| `hydrostatic_pressure` | p_h = rho_0 g (H - y): that of a liquid at rest up to the initial level H; negative above H |
| `dynamic_pressure` | p - p_h: zero at rest |
| `absolute_pressure` | p + p_atm |

Heights are measured against gravity, whatever its direction. Along periodic sides no pressure balances gravity, and
that component of gravity is ignored. [batchelor1967]
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from ecume._portable import dot, product
from ecume.engine.interpolation import added, dry, near, planes
from ecume.laws.hydrostatics import hydrostatic_pressure
from ecume.laws.kernels import kernel
from ecume.laws.states import tait_pressure
from ecume.laws.wall_forces import between_planes, covered_part, smeared
from ecume.models.invariants import (
    INJECTED,
    NUMERICAL,
    Invariant,
    NumberHistory,
    at_most,
    energy_never_rises,
    kept,
    part_of,
)
from ecume.models.sph.boundaries.forces_on_solids import loads
from ecume.models.sph.boundaries.rigid_bodies import drive_at, with_moved_solids
from ecume.models.sph.boundaries.touching_solids import exchanged_loads
from ecume.models.sph.boundaries.walls import (
    Repelled,
    all_braked,
    all_repelled,
    drawn_owner,
    energy_of,
    repulsion_load,
)
from ecume.models.sph.integration.passive_particles import surroundings
from ecume.models.sph.parameters import Gauge, Parameters, PressureReference, up_axis
from ecume.models.sph.rates.gradients import set_viscosity
from ecume.models.sph.rates.right_hand_side import fill
from ecume.models.sph.rates.surface_tension import surface_energy
from ecume.models.sph.report.energy_budget import (
    energies,
    has_external_work,
    has_numerical_work,
    has_unbudgeted_work,
    liquid_alone,
    spreading_energy,
)
from ecume.models.sph.setup.choices import filled, held_pull
from ecume.models.sph.setup.shapes import part_of as part_of_space
from ecume.models.sph.state import (
    ENTERED,
    GUARD_HITS,
    ITERATIONS,
    LEFT,
    LOST,
    MOST_ITERATIONS,
    MOST_SUBSTEPS,
    SUBSTEPS,
    WORK,
    State,
    Workspace,
)
from ecume.scenes.sph import SphScene
from ecume.scenes.sph.tank import TankSpec
from ecume.trajectories.frame import Frame
from ecume.trajectories.gsd import SIDES as BOX_SIDES
from ecume.units import Array


def reference_of(scene: SphScene) -> PressureReference:
    """The reference of a scene's pressures."""
    liquid, gravity = filled(scene.liquid), held_pull(scene)
    return PressureReference(
        liquid.density or 0.0, gravity, level_of(scene, upward(gravity)), liquid.atmospheric_pressure
    )


def level_of(scene: SphScene, up: Array) -> float:
    """The initial level of the liquid (m): the height of its largest connected part. Drops above it are ignored."""
    regions = [part_of_space(region, scene.spacing) for region in scene.fluid]
    low, high = (np.array(corners) for corners in zip(*(region.bounds() for region in regions), strict=True))
    meet = (np.maximum(low, low[:, None]) < np.minimum(high, high[:, None]) + scene.spacing).all(axis=2)
    from scipy.sparse.csgraph import connected_components

    _, part = connected_components(meet)
    volume = np.bincount(part, weights=[region.volume() for region in regions])
    largest = np.flatnonzero(part == int(np.argmax(volume)))
    return max(regions[k].extent_along(up) for k in largest)


def upward(gravity: Array) -> Array:
    """The direction (d,) against gravity; zero without gravity."""
    size = float(np.linalg.norm(gravity))
    up: Array = -gravity / size if size > 0.0 else np.zeros(len(gravity))
    return up


def hydrostatic(reference: PressureReference, position: Array) -> Array:
    """The hydrostatic pressure (Pa) at positions (N, d)."""
    gravity = reference.gravity
    height = product(upward(gravity), position.T)
    return hydrostatic_pressure(height, reference.level, reference.density, float(np.linalg.norm(gravity)))


Kind = Callable[[PressureReference, Array, Array], Array]
"""The signature of a pressure (Pa) as a function of the reference, the gauge pressure (N,) and the position (N, d)."""

PRESSURES: Mapping[str, Kind] = {
    "pressure": lambda reference, gauge, position: gauge,
    "hydrostatic_pressure": lambda reference, gauge, position: hydrostatic(reference, position),
    "dynamic_pressure": lambda reference, gauge, position: gauge - hydrostatic(reference, position),
    "absolute_pressure": lambda reference, gauge, position: gauge + reference.atmospheric,
}
"""The pressures by name, for gauges, figures, pages and exports."""


KERNEL = "wendland-c2"
QUADRATURE = 200
"""The number of points along an axis in the integral over a gauge's surroundings."""
ACROSS = 6
"""The number of points along the line of a sensor, or along a radius and around a disc."""

Readings = tuple[dict[str, float], dict[str, str]]
"""The values of gauges, and their units."""


def gauges_of(scene: SphScene, reach: float) -> tuple[Gauge, ...]:
    """The gauges of a scene; a row of gauges is expanded into single gauges."""
    found = []
    ends, periods = _ends(scene)
    for spec in scene.gauges:
        first = np.array(spec.position)
        places = [first] if spec.end is None else np.linspace(first, np.array(spec.end), spec.count or 2)
        for name, place in zip(spec.names, places, strict=True):
            area = sensing_area(scene.tank, place, spec.diameter or 0.0)
            floor = np.array([scene.tank.low, scene.tank.high], np.float64)
            found.append(
                Gauge(
                    name,
                    place,
                    area,
                    spec.quantities,
                    _ground(floor, place, (reach, scene.up_axis)),
                    floor,
                    ends,
                    periods,
                )
            )
    return tuple(found)


def sensing_area(tank: TankSpec, place: Array, diameter: float) -> Array:
    """Points (n, d) with equal shares of the sensing area of a sensor, along the nearest side of the tank and within
    it; only the position itself if the diameter is zero.
    """
    if diameter == 0.0:
        return place[None]
    low, high = np.array(tank.low), np.array(tank.high)
    across = int(np.argmin(np.minimum(place - low, high - place)))
    along = [axis for axis in range(len(place)) if axis != across]
    points = np.tile(place, (ACROSS * (ACROSS if len(along) > 1 else 1), 1))
    share = (np.arange(ACROSS) + 0.5) / ACROSS
    if len(along) == 1:
        points[:, along[0]] += (share - 0.5) * diameter
    else:  # rings with equal areas
        radius, angle = np.meshgrid(0.5 * diameter * np.sqrt(share), 2.0 * np.pi * share)
        points[:, along] += np.stack([(radius * np.cos(angle)).ravel(), (radius * np.sin(angle)).ravel()], axis=1)
    inside: Array = points[((points >= low) & (points <= high)).all(axis=1)]
    return inside if len(inside) else place[None]


def _ends(scene: SphScene) -> tuple[Array, Array]:
    """The ends (2, d) and the periods (d,) of a tank, as in `Gauge`. Buffers behind inflows and outflows count as
    solid, since gauges do not read them.
    """
    sides = _kinds(scene)
    bounds = np.array([scene.tank.low, scene.tank.high], np.float64)
    closed = np.array([kind not in ("open", "periodic") for kind in sides]).reshape(-1, 2).T
    periodic = np.array([kind == "periodic" for kind in sides[::2]])
    ends = np.where(closed, bounds, [[-math.inf], [math.inf]])
    return ends, np.where(periodic, bounds[1] - bounds[0], math.inf)


def _ground(tank: Array, place: Array, seen: tuple[float, int]) -> float:
    """The integral of the kernel over the floor of a tank, (2, d) corners, around a gauge with a reach and an upward
    axis.
    """
    reach, up = seen
    level = [axis for axis in range(len(place)) if axis != up]
    shape = kernel(KERNEL, dim=len(level))
    axes = [reach * ((np.arange(QUADRATURE) + 0.5) / (0.5 * QUADRATURE) - 1.0)] * len(level)
    away = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)
    weight = np.asarray(shape.value(np.linalg.norm(away, axis=1), reach / shape.support))
    there = place[level] + away
    inside = ((there > tank[0, level]) & (there < tank[1, level])).all(axis=1)
    return float(weight[inside].sum() / weight.sum())


class Surroundings(NamedTuple):
    """The liquid and the solids that gauges read, at one instant."""

    position: Array
    """(N, d) m, in the initial order of particles, so that sums do not depend on sorting"""
    table: Array
    """(N, d + 2) velocity, pressure and volume"""
    solid: Array
    """(n, d) m, dummies of obstacles and bodies"""
    solid_volume: Array
    shift: Array
    """(2, d) m, how far the sides of the tank have moved since the start"""
    reach: float
    spacing: float
    up: int
    """the axis that points up"""


def readings(parameters: Parameters, state: State, pressure: Array) -> Readings:
    """The values of all gauges, with walls and bodies at the positions in `parameters`."""
    numbers, units = dict[str, float](), dict[str, str]()
    if parameters.gauges:
        around = surroundings_of(parameters, state, pressure)
        for gauge in parameters.gauges:
            for name, value, unit in _read(gauge, around, parameters.pressure_reference):
                numbers[f"{gauge.name}_{name}"], units[f"{gauge.name}_{name}"] = value, unit
    return numbers, units


def surroundings_of(parameters: Parameters, state: State, pressure: Array) -> Surroundings:
    """The liquid and the solids that gauges read at this instant."""
    order = np.argsort(state.identity)
    table = np.column_stack([state.velocity[:, order].T, pressure[order], (state.mass / state.density)[order]])
    dummies, sides = parameters.boundary.dummies, 2 * parameters.dimension
    solid = dummies.owner >= sides
    shift = np.zeros(sides)
    for side, drive in parameters.drives:
        shift[side] = drive_at(drive, float(state.clock[0]))[0][0]
    return Surroundings(
        state.position[:, order].T, table, dummies.position[:, solid].T, dummies.volume[solid],
        shift.reshape(-1, 2).T, parameters.support, parameters.spacing, up_axis(parameters),
    )  # fmt: skip


def _read(gauge: Gauge, around: Surroundings, reference: PressureReference) -> Iterator[tuple[str, float, str]]:
    """Yield the name, the value and the unit of each quantity of a gauge."""
    kinds = [name for name in PRESSURES if name in gauge.measures]
    if kinds or "velocity" in gauge.measures:
        close = _close(gauge, around)
        found = np.array([_at_place(point, close) for point in gauge.area])
        if kinds:
            found[:, -1] *= [_covered(point, gauge, close) for point in gauge.area]
        *velocity, pressure = np.mean(found, axis=0).tolist()
        middle = gauge.area.mean(axis=0, keepdims=True)
        for name in kinds:
            yield name, float(PRESSURES[name](reference, np.array([pressure]), middle)[0]), "Pa"
        if "velocity" in gauge.measures:
            yield from ((f"velocity_{axis}", value, "m/s") for axis, value in zip("xyz", velocity, strict=False))
    if "level" in gauge.measures:
        yield "level", _depth(gauge, around), "m"


def _close(gauge: Gauge, around: Surroundings) -> Surroundings:
    """The particles within the range of a gauge, including those across periodic sides."""
    far = around.reach + float(np.abs(gauge.area - gauge.place).max())
    liquid, solid = (_beside(gauge, position) for position in (around.position, around.solid))
    seen, touched = ((np.abs(position - gauge.place) < far).all(axis=1) for position in (liquid, solid))
    return around._replace(
        position=liquid[seen], table=around.table[seen], solid=solid[touched], solid_volume=around.solid_volume[touched]
    )


def _beside(gauge: Gauge, position: Array) -> Array:
    """Positions, or their periodic images closest to a gauge."""
    position = position.copy()
    for axis in np.flatnonzero(np.isfinite(gauge.periods)):
        periods = np.round((position[:, axis] - gauge.place[axis]) / gauge.periods[axis])
        position[:, axis] -= periods * gauge.periods[axis]
    return position


def _at_place(place: Array, around: Surroundings) -> list[float]:
    """The velocity and the pressure of the liquid at a position, exact for linear fields; zero at a dry position."""
    position, table, reach = around.position, around.table, around.reach
    close = (np.abs(position - place) < reach).all(axis=1)
    pairs = near(place[None], position[close], reach)
    shape = kernel(KERNEL, dim=len(place))
    weight = table[close, -1][pairs.particle] * shape.value(pairs.distance, reach / shape.support)
    if dry(pairs, weight)[0]:
        return [0.0] * (table.shape[1] - 1)
    found: list[float] = planes(pairs, weight, table[close, :-1])[0].tolist()
    return found


def _covered(place: Array, gauge: Gauge, around: Surroundings) -> float:
    """The fraction of the area around a position that is wet, see `ecume.laws.wall_forces`, relative to the space
    between the sides of the tank and outside solids.
    """
    spacing, ends = around.spacing, gauge.ends + around.shift - place
    room = math.prod(between_planes(low, high, spacing) for low, high in ends.T.tolist())
    room -= _smeared(around.solid - place, around.solid_volume, spacing)
    return covered_part(_smeared(around.position - place, around.table[:, -1], spacing), room)


def _smeared(away: Array, volume: Array, spacing: float) -> float:
    """The sum of the kernels of particles at these displacements."""
    dimension = away.shape[1]
    q = np.sqrt((away * away).sum(axis=1)) / spacing
    return dot(volume, np.array([smeared(each, dimension) for each in q.tolist()])) / math.pow(spacing, dimension)


def _depth(gauge: Gauge, around: Surroundings) -> float:
    """The volume of liquid around a position on the floor, per area of the floor between the present sides."""
    axes, reach = np.array([axis for axis in range(len(gauge.place)) if axis != around.up]), around.reach
    level, place = around.position[:, axes], gauge.place[axes]
    close = (np.abs(level - place) < reach).all(axis=1)
    pairs = near(place[None], level[close], reach)
    shape = kernel(KERNEL, dim=len(place))
    weight = around.table[close, -1][pairs.particle] * shape.value(pairs.distance, reach / shape.support)
    moved = around.shift[:, axes].any()
    ground = _ground(gauge.floor + around.shift, gauge.place, (reach, around.up)) if moved else gauge.ground
    return part_of(float(added(pairs, weight)[0]), ground)


ARRAY_UNITS = {
    "position": "m",
    "velocity": "m/s",
    "density": "kg/m^3",
    "pressure": "Pa",
    "mass": "kg",
    "species": "1",
}
NUMBER_UNITS = {
    "kinetic_energy": "J",
    "potential_energy": "J",
    "elastic_energy": "J",
    "surface_energy": "J",
    "total_energy": "J",
    "momentum_x": "kg*m/s",
    "momentum_y": "kg*m/s",
    "momentum_z": "kg*m/s",
    "center_x": "m",
    "center_y": "m",
    "center_z": "m",
    "front": "m",
    "top": "m",
    "largest_speed": "m/s",
    "largest_pressure": "Pa",
    "density_change": "1",
    "volume": "m^3",
    "guard_hits": "1",
    "leaning": "1",
    "particles_entered": "1",
    "particles_left": "1",
    "particles_lost": "1",
    "substeps": "1",
    "most_substeps": "1",
}


BODY_UNITS = {
    **dict.fromkeys("xyz", "m"),
    **{f"velocity_{axis}": "m/s" for axis in "xyz"},
    **{f"spin_{axis}": "1/s" for axis in "xyz"},
    "angle": "rad",
    "position": "m",
}
PER_DEPTH = {"J": "J/m", "N": "N/m", "N*m": "N*m/m", "kg": "kg/m", "kg*m/s": "kg/s", "m^3": "m^2"}
"""The units of 2D tanks instead of each unit: quantities are per meter of depth."""


def in_dimension(units: Mapping[str, str], dimension: int) -> dict[str, str]:
    """The units of a tank's quantities in 2D or 3D."""
    return {name: PER_DEPTH.get(unit, unit) if dimension == 2 else unit for name, unit in units.items()}


def observe(parameters: Parameters, state: State, workspace: Workspace) -> Frame:
    """The frame of this instant. In 2D energies, masses, momenta, forces and volumes are per meter of depth."""
    still = parameters.gravity
    parameters = with_moved_solids(parameters, state)
    leaning = all_repelled(parameters, state)
    solid, units = of_solids(parameters, state, workspace, [*leaning, *all_braked(parameters, state)])
    propped = sum(energy_of(parameters, state, each) for each in leaning)
    propped += spreading_energy(parameters, state, workspace)
    state = liquid_alone(parameters, state)
    order = np.argsort(state.identity)
    arrays = {
        "position": np.ascontiguousarray(state.position[:, order].T),
        "velocity": np.ascontiguousarray(state.velocity[:, order].T),
        "density": state.density[order],
        "pressure": gauge_pressure(parameters, state)[order],
        "mass": state.mass[order],
        "species": state.region[order],
    }
    if parameters.second is not None:
        arrays["liquid"] = parameters.second.kind[state.region[order]].astype(np.int64)
    periods = np.abs(parameters.boundary.sides.shift).max(axis=0, initial=0.0)
    if periods.any() and state.image.size:
        arrays["image"] = np.ascontiguousarray(state.image[:, order].T)
    if parameters.passive_tracers.start[-1]:
        arrays = {
            name: np.concatenate([arrays[name], more])
            for name, more in passive_arrays(parameters, state, workspace).items()
        }
    surface = surface_energy(parameters, workspace)
    energy = energies(parameters._replace(gravity=still), state, propped, surface)
    numbers = {**energy, **motion(state), **extremes(parameters, state)}
    numbers["leaning"] = float(sum(len(each.who) for each in leaning))
    pressure = gauge_pressure(parameters, state)
    read, read_units = readings(parameters, state, pressure)
    time = int(state.step[0]) * parameters.time_step
    listed = {name: float(numbers[name]) for name in NUMBER_UNITS}
    if parameters.bodies.shapes:
        listed["bodies_energy"] = energy["bodies_energy"]
    if parameters.projection is not None:
        listed |= of_solver(parameters, state)
        units |= dict.fromkeys(of_solver(parameters, state), "1")
    if parameters.second is not None:
        listed |= of_liquids(parameters, state)
        units |= {name: "m" if "center" in name else "m/s" for name in of_liquids(parameters, state)}
    if has_external_work(parameters):
        listed[INJECTED] = float(state.budget[WORK])
    if has_numerical_work(parameters):
        listed[NUMERICAL] = float(state.numerical[WORK])
    units |= {name: "J" for name in (INJECTED, NUMERICAL, "bodies_energy") if name in listed}
    box = {name: side for name, side in zip(BOX_SIDES, periods.tolist(), strict=False) if side > 0.0}
    counts = {name: "1" for name in arrays if name in ("image", "liquid")}
    listed, units = listed | box, units | dict.fromkeys(box, "m") | counts
    units = in_dimension({**ARRAY_UNITS, **NUMBER_UNITS, **units, **read_units}, parameters.dimension)
    return Frame(time, arrays, {**listed, **solid, **read}, units)


def passive_arrays(parameters: Parameters, state: State, workspace: Workspace) -> dict[str, Array]:
    """The arrays with the passive particles after the liquid, as further species. They have no mass; their pressure is
    that of the surrounding liquid, or zero outside it.
    """
    tracers, material, count = parameters.passive_tracers, parameters.material, state.passive_position.shape[1]
    group = np.repeat(np.arange(len(tracers.groups)), np.diff(tracers.start))
    density = np.array([each.density for each in tracers.groups])[group]
    return {
        "position": state.passive_position.T,
        "velocity": state.passive_velocity.T,
        "density": np.where(density > 0.0, density, material.density),
        "pressure": surroundings(parameters, workspace, state.passive_position).pressure
        + weight_above(parameters, state.passive_position),
        "mass": np.zeros(count),
        "species": tracers.regions + group,
        **({"image": state.passive_image.T} if state.passive_image.size else {}),
        **({"liquid": np.zeros(count, np.int64)} if parameters.second is not None else {}),
    }


def of_solids(
    parameters: Parameters, state: State, workspace: Workspace, pushed: list[Repelled]
) -> tuple[dict[str, float], dict[str, str]]:
    """Forces and torques on walls, obstacles and bodies, reflections, and poses of bodies, with units. In 2D forces are
    per meter of depth, and torques about z.
    """
    fill(parameters, state, workspace)
    if parameters.viscosity_varies:
        set_viscosity(parameters, workspace)
    axes, turns = "xyz"[: parameters.dimension], "z" if parameters.dimension == 2 else "xyz"
    numbers, units = dict[str, float](), dict[str, str]()
    more = [(parameters.boundary.names[owner], struck[:3], struck[3:]) for owner, struck in enumerate(state.struck)]
    averaged = parameters.projection is not None and bool(state.struck.any())  # see `solver_loads`
    if not averaged:
        more += [(parameters.boundary.names[each.owner], *repulsion_load(parameters, state, each)) for each in pushed]
        exchanged = exchanged_loads(parameters, state, workspace)
        more += [(parameters.boundary.names[owner], *load) for owner, load in exchanged.items()]
    for name, force, torque in loads(parameters, workspace):
        force, torque = (0.0 * force, 0.0 * torque) if averaged else (force, torque)
        force = sum((own for owner, own, _ in more if owner == name), start=force)
        torque = sum((own for owner, _, own in more if owner == name), start=torque)
        numbers |= {f"{name}_force_{axis}": float(force[k]) for k, axis in enumerate(axes)}
        numbers |= {f"{name}_torque_{axis}": float(torque["xyz".index(axis)]) for axis in turns}
        units |= dict.fromkeys((key for key in numbers if key.startswith(f"{name}_force")), "N")
        units |= dict.fromkeys((key for key in numbers if key.startswith(f"{name}_torque")), "N*m")
    names = parameters.boundary.names
    drawn = [drawn_owner(parameters, number) for number in parameters.bodies.drawn]
    guarded = {names[k] for k in (*parameters.boundary.guard.owner, *drawn)}
    numbers |= {f"{name}_hits": float(state.hits[k]) for k, name in enumerate(names) if name in guarded}
    for body in range(len(parameters.bodies.shapes)):
        name = names[len(names) - len(parameters.bodies.shapes) + body]
        numbers |= pose_of(state, body, (axes, turns), (name, parameters.bodies.pose[3:, body]))
    for side, drive in parameters.drives:
        numbers[f"{names[side]}_position"] = float(drive_at(drive, float(state.clock[0]))[0][0])
    owned = {f"{owner}_{kind}": unit for owner in names for kind, unit in BODY_UNITS.items()}
    return numbers, {name: units.get(name) or owned.get(name, "1") for name in numbers}


def pose_of(state: State, body: int, letters: tuple[str, str], which: tuple[str, Array]) -> dict[str, float]:
    """Position, velocity, orientation and spin of a body. The orientation is the rotation since the start: an angle in
    2D, a quaternion in 3D. letters = (axes of positions, axes of rotation), which = (name, orientation at the start).
    """
    (axes, turns), (name, start), pose, move = letters, which, state.pose[:, body], state.motion[:, body]
    found = {f"{name}_{axis}": float(pose[k]) for k, axis in enumerate(axes)}
    found |= {f"{name}_velocity_{axis}": float(move[k]) for k, axis in enumerate(axes)}
    found |= {f"{name}_spin_{axis}": float(move[3 + "xyz".index(axis)]) for axis in turns}
    if len(axes) == 2:
        return {**found, f"{name}_angle": 2.0 * math.atan2(pose[6], pose[3])}
    since = turned_since(pose[3:], start)
    return {**found, **{f"{name}_q{part}": float(since[k]) for k, part in enumerate("wxyz")}}


def turned_since(now: Array, start: Array) -> Array:
    """The quaternion q of the rotation from `start` to `now`: q = now start*."""
    (a, b, c, d), (w, x, y, z) = now, start
    return np.array(
        [
            a * w + b * x + c * y + d * z,
            b * w - a * x - c * z + d * y,
            c * w - a * y + b * z - d * x,
            d * w - a * z - b * y + c * x,
        ]
    )


LIQUIDS = ("first", "second")
"""The names of two liquids in scenes and numbers of frames."""


def of_liquids(parameters: Parameters, state: State) -> dict[str, float]:
    """The center of mass of each of two liquids, and its velocity; NaN once a liquid has left completely."""
    found: dict[str, float] = {}
    for name, (_, who) in zip(LIQUIDS, parameters.parts(state.region), strict=True):
        mass = state.mass[who]
        total = float(np.sum(mass)) or math.nan
        for axis, letter in enumerate("xyz"[: parameters.dimension]):
            found[f"{name}_center_{letter}"] = dot(mass, state.position[axis, who]) / total
            found[f"{name}_velocity_{letter}"] = dot(mass, state.velocity[axis, who]) / total
    return found


def of_solver(parameters: Parameters, state: State) -> dict[str, float]:
    """The iterations since the start, the largest number of iterations in a substep, and the mean excess of density."""
    excess = np.maximum(state.density / parameters.material.density - 1.0, 0.0)
    return {
        "iterations": float(state.tally[ITERATIONS]),
        "most_iterations": float(state.tally[MOST_ITERATIONS]),
        "density_error": float(np.mean(excess)),
    }


def pressure_in(parameters: Parameters, state: State) -> Array:
    """The pressure (N,) in Pa: of Tait's equation, or of the solver for incompressible liquids."""
    if parameters.projection is not None:
        return state.pressure.copy()
    found = np.empty_like(state.density)
    for liquid, who in parameters.parts(state.region):
        found[who] = tait_pressure(state.density[who], *liquid.laws)
    return found


def gauge_pressure(parameters: Parameters, state: State) -> Array:
    """The gauge pressure (N,) in Pa: of Tait's equation, plus the hydrostatic part where the forces omit it."""
    pressure: Array = pressure_in(parameters, state) + weight_above(parameters, state.position)
    return pressure


def weight_above(parameters: Parameters, position: Array) -> Array:
    """The hydrostatic pressure (N,) in Pa below the initial surface that forces omit, at positions (d, N)."""
    up = up_axis(parameters)
    weight: Array = -parameters.material.density * parameters.hydrostatic[up] * (parameters.surface - position[up])
    return weight


def motion(state: State) -> Mapping[str, float]:
    """Momentum and center of mass; z is zero in two dimensions, and all are zero once all liquid has left."""
    total = float(np.sum(state.mass))
    momentum, center = np.zeros(3), np.zeros(3)
    momentum[: len(state.velocity)] = np.sum(state.velocity * state.mass, axis=1)
    if total > 0.0:
        center[: len(state.position)] = np.sum(state.position * state.mass, axis=1) / total
    names = "xyz"
    return {
        **{f"momentum_{name}": momentum[axis] for axis, name in enumerate(names)},
        **{f"center_{name}": center[axis] for axis, name in enumerate(names)},
    }


def extremes(parameters: Parameters, state: State) -> Mapping[str, float]:
    """Extent, largest speed, pressure and density change, and counts of substeps and exchanged particles. Without
    liquid, all of which may have left, the former are zero.
    """
    change = np.abs(state.density / parameters.of_each("density", state.region) - 1.0)
    return {
        "front": _largest(state.position[0]),
        "top": _largest(state.position[up_axis(parameters)]),
        "largest_speed": math.sqrt(_largest((state.velocity**2).sum(axis=0))),
        "largest_pressure": _largest(gauge_pressure(parameters, state)),
        "density_change": _largest(change),
        "volume": np.sum(state.mass / state.density),
        "guard_hits": state.tally[GUARD_HITS],
        "particles_entered": state.population[ENTERED],
        "particles_left": state.population[LEFT],
        "particles_lost": state.population[LOST],
        "substeps": state.tally[SUBSTEPS],
        "most_substeps": state.tally[MOST_SUBSTEPS],
    }


def _largest(values: Array) -> float:
    """The largest value; zero of none."""
    return float(values.max()) if values.size else 0.0


SQUEEZED = 0.2
"""The largest change of density that a weakly compressible liquid may have; the method is meant for 1 %."""
MACH = 0.3
"""The largest speed over the speed of sound; the method is meant for a tenth, and the density changes by its square."""
RISE = 0.02
"""The tolerated rise of the energy, relative: density diffusion and shifting add a little."""
TURNED_BACK = 1e-3
"""The tolerated number of reflections by the guard, per particle and step."""
FAINT = 0.05
"""The speed, over the expected one, below which the kinetic energy is comparable to the changes of energy while layers
settle.
"""
DRIFT = 1e-6
"""The tolerated drift of momentum, relative."""


def invariants(scene: SphScene, parameters: Parameters) -> list[Invariant]:
    """The invariants of a scene."""
    return list(_rows(scene, parameters))


def _rows(scene: SphScene, parameters: Parameters) -> Iterator[Invariant]:
    volume = scene.spacing ** len(scene.tank.low)
    if "open" not in _kinds(scene):
        yield at_most("mass", "particles that are lost", "particles_lost", 0.0)
    yield at_most("density", "its largest change, over the density at rest", "density_change", SQUEEZED)
    if parameters.projection is None:
        sound = min(each.sound_speed for each in parameters.materials)
        says = "the Mach number; set liquid.maximum_speed to the speed that is reached"
        yield Invariant("sound", says, MACH, lambda seen: seen.largest["largest_speed"] / sound)

    def turned_back(seen: NumberHistory) -> float:
        return part_of(seen.now["guard_hits"] * volume, seen.first["volume"] * max(seen.now["step"], 1.0))

    yield Invariant("guard", "particles turned back behind a wall, a particle and step", TURNED_BACK, turned_back)
    if not has_unbudgeted_work(parameters):
        yield energy_never_rises(RISE, _faint(parameters))
    if _alone(scene):
        density = max(each.density for each in parameters.materials)

        def momenta(seen: NumberHistory) -> float:
            return math.sqrt(2.0 * density * seen.first["volume"] * seen.largest["kinetic_energy"])

        yield kept("momentum", ("momentum_x", "momentum_y", "momentum_z"), momenta, DRIFT)


def _faint(parameters: Parameters) -> Callable[[NumberHistory], float]:
    """The energy of a slight motion, and of the weight lifted by a particle diameter: liquid at rest moves by some
    hundredths of this while its layers settle.
    """
    pull, fastest = float(np.linalg.norm(parameters.gravity)), parameters.material.fastest
    each = max(liquid.density for liquid in parameters.materials)
    each *= 0.5 * (FAINT * fastest) ** 2 + pull * parameters.spacing
    return lambda seen: each * seen.first["volume"]


def _kinds(scene: SphScene) -> list[str]:
    """The kind of each side of the tank."""
    return [getattr(scene.tank, side).kind for side in scene.sides]


def _alone(scene: SphScene) -> bool:
    """Whether no external force acts on the liquid."""
    around = all(kind == "periodic" for kind in _kinds(scene))
    pulled = bool(np.any(scene.gravity)) or scene.central_force is not None
    return around and not (pulled or scene.bodies or scene.obstacles)
