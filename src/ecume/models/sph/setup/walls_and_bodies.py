"""Boundaries of a scene: mirrors with images, layers of dummy particles, reflecting surfaces, open sides and bodies."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ecume._portable import length, product
from ecume.engine.cells import Integers, Sides
from ecume.engine.formulas import formula_at
from ecume.engine.outlines import Mesh
from ecume.engine.shapes import Ball, Box, Polygon, Shape, fitted_axis
from ecume.engine.walls import Surfaces, box, disc, outside, planes, polygon, sheet, together
from ecume.errors import BadInput, Fault, SceneError
from ecume.laws.kernels import kernel
from ecume.laws.tension import solid_color
from ecume.models.sph.boundaries.driven_bodies import on_path
from ecume.models.sph.boundaries.rigid_bodies import drive_at, rotations
from ecume.models.sph.parameters import Bodies, BodyPath, Boundary, Drive, Dummies, Guard, Material, OpenBoundary, Roll
from ecume.models.sph.rates.methods import PRESSURE_FORCES
from ecume.models.sph.setup.choices import color_reach_of, contact_cosine, impacts_dissipate, require_wetting, sides_of
from ecume.models.sph.setup.shapes import (
    OwnAxes,
    dummies_of,
    in_own_axes,
    obstacle_dummies,
    obstacles_of,
    shape_of,
    solids_of,
)
from ecume.scenes.sph import BaseExcitationSpec, BodyMotionSpec, BodySpec, MotionSpec, RollSpec, SphScene
from ecume.scenes.sph.motions import tried
from ecume.units import Array, with_prefix

LAYERED = ("wall", "inflow", "outflow")
LEAST_PERIOD = 1.2
"""The smallest period of a tank, in supports: lists extend slightly beyond a support."""


def boundary_of(scene: SphScene, material: Material, support: float) -> Boundary:
    """The tank, its obstacles, and the particles of bodies relative to their centers."""
    require_long_periods(scene, max(support, color_reach_of(scene)))
    require_wetting(scene)
    sides, table, image_owner = imaging_sides(scene)
    solids = solids_of(scene)
    middle = 0.5 * (np.array(scene.tank.low) + np.array(scene.tank.high))
    walls = 2 * len(middle)
    names = (*scene.sides, *scene.obstacle_names, *scene.body_names)
    centers = np.zeros((len(names), 3))
    centers[:, : len(middle)] = [*[middle] * walls, *[solid.middle() for solid in solids]]
    dummies = joined([_layers(scene, material, support), *_of_solids(scene, material, support)])
    wetting = np.array([contact_cosine(scene, spec) for spec in (*sides_of(scene), *scene.obstacles, *scene.bodies)])
    color = np.array([solid_color(cosine) for cosine in wetting.tolist()])
    return Boundary(sides, table, image_owner, dummies, guard_of(scene, support), names, centers, wetting, color)


def require_long_periods(scene: SphScene, support: float) -> None:
    """Raise SceneError if a periodic tank is shorter than a support: a particle would then interact with several images
    of a neighbor.
    """
    size = np.array(scene.tank.high) - np.array(scene.tank.low)
    for axis in range(len(size)):
        if side_of(scene, 2 * axis).kind == "periodic" and size[axis] < LEAST_PERIOD * support:
            least = LEAST_PERIOD * support
            got = f"{with_prefix(size[axis], 'm', 4)} along {'xyz'[axis]}, where the tank is periodic"
            raise SceneError(
                [Fault("tank.high", f"got {got}; expected {with_prefix(least, 'm', 4)}, or a smaller spacing")]
            )


def joined(pieces: list[Dummies]) -> Dummies:
    """All dummies in one tuple, in order."""
    return Dummies(*(np.ascontiguousarray(np.concatenate(parts, axis=-1)) for parts in zip(*pieces, strict=True)))


def dummies_at(points: Array, volume: Array, viscosity: float, owner: int) -> Dummies:
    """The dummies of a solid at rest, from points (n, d)."""
    count = len(points)
    number = np.full(count, owner, np.int64)
    bearer = np.full(points.T.shape, owner, np.int64)
    return Dummies(points.T.copy(), np.zeros_like(points.T), np.full(count, viscosity), volume, number, bearer)


def _of_solids(scene: SphScene, material: Material, support: float) -> list[Dummies]:
    pieces, first = [], 2 * len(scene.tank.low)
    for index, (points, volume) in enumerate(obstacle_dummies(scene, support)):
        viscosity = material.viscosity * holds(scene.obstacles[index], scene)
        pieces.append(dummies_at(points, volume, viscosity, first + index))
    for index, spec in enumerate(scene.bodies):
        shape = shape_of(spec)
        points, volume = dummies_of(shape, scene.spacing, support)
        viscosity = material.viscosity * holds(spec, scene)
        owner = first + len(scene.obstacles) + index
        turn = in_own_axes(shape).turn[: points.shape[1], : points.shape[1]]
        pieces.append(dummies_at(product(points - shape.middle(), turn), volume, viscosity, owner))
    return pieces


def holds(side: Any, scene: SphScene) -> bool:
    """Whether the no-slip condition holds at a wall: by default where the scene gives a viscosity."""
    return bool(side.slip == "no-slip" or (side.slip is None and scene.liquid.sticks))


def narrowest_channel(scene: SphScene, axis: int) -> float:
    """The smallest distance (m) between two opposite no-slip walls along an axis; infinite without such walls."""
    low, high = scene.tank.low, scene.tank.high
    pairs = [(side_of(scene, 2 * k), side_of(scene, 2 * k + 1), k) for k in range(len(low)) if k != axis]
    return min(
        (
            high[k] - low[k]
            for first, second, k in pairs
            if all(each.kind == "wall" and holds(each, scene) for each in (first, second))
        ),
        default=math.inf,
    )


def imaging_sides(scene: SphScene) -> tuple[Sides, Array, Integers]:
    """The sides with images, mirrors first since periodic sides repeat mirrored particles, and the index of each in the
    tank (-1 for periodic sides).
    """
    dimension = len(scene.tank.low)
    mirrors = scene.tank.walls == "mirror"
    rows, numbers = [], []
    for number in range(2 * dimension):
        side, axis = side_of(scene, number), number // 2
        if side.kind == "periodic" or (side.kind == "wall" and mirrors):
            rows.append(_row(scene, number, axis, holds(side, scene)))
            numbers.append(number if side.kind == "wall" else -1)
    order = sorted(range(len(rows)), key=lambda k: -rows[k][3 * dimension])
    table = np.array([rows[k] for k in order]).reshape(-1, 4 * dimension + 2)
    owner, d = np.array([numbers[k] for k in order], np.int64), dimension
    periodic = table[:, 3 * d] == 0.0
    shift = np.where(periodic[:, None], table[:, 2 * d : 3 * d], 0.0)
    return Sides(table[:, :d], table[:, d : 2 * d], shift, (~periodic).astype(np.int64)), table, owner


def _row(scene: SphScene, number: int, axis: int, hold: bool) -> list[float]:
    """The row of a side: point, normal, shift or velocity, whether it is a mirror, whether it has no slip,
    acceleration.
    """
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    side, first = side_of(scene, number), number % 2 == 0
    normal, third = np.zeros(len(low)), np.zeros(len(low))
    normal[axis] = 1.0 if first else -1.0
    if side.kind == "periodic":
        third[axis] = (high - low)[axis] * normal[axis]
    elif side.velocity is not None:
        third[:] = side.velocity
    flags = float(side.kind == "wall"), float(hold)
    return [*(low if first else high), *normal, *third, *flags, *np.zeros(len(low))]


def layers_around(scene: SphScene, support: float) -> tuple[Array, Array]:
    """The layers of dummies (n, d) behind the walls of the tank, as thick as the support, and their volumes."""
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    dimension, spacing = len(low), scene.spacing
    if scene.tank.walls != "dummy":
        return np.zeros((0, dimension)), np.zeros(0)
    axes, volume = [], 1.0
    for axis in range(dimension):
        cells, widths = fitted_axis(low[axis], high[axis], spacing)
        layers = math.ceil(support / widths[0] - 1e-9)
        # Walls continue along the buffers of in- and outflows.
        first = -layers if side_of(scene, 2 * axis).kind in LAYERED else 0
        last = len(cells) + layers if side_of(scene, 2 * axis + 1).kind in LAYERED else len(cells)
        axes.append(low[axis] + widths[0] * (np.arange(first, last) + 0.5))
        volume *= widths[0]
    points = np.stack([grid.ravel() for grid in np.meshgrid(*axes, indexing="ij")], axis=1)
    walled = np.array([side_of(scene, number).kind == "wall" for number in range(2 * dimension)])
    outside = (((points < low) & walled[0::2]) | ((points > high) & walled[1::2])).any(axis=1)
    return points[outside], np.full(int(outside.sum()), volume)


def _layers(scene: SphScene, material: Material, support: float) -> Dummies:
    """The dummies of the tank, with the motion and slip of their sides."""
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    points, volumes = layers_around(scene, support)
    velocity, viscosity, owner = np.zeros_like(points), np.zeros(len(points)), np.zeros(len(points), np.int64)
    bearer = np.full(points.T.shape, -1)
    # A moving side moves its layers; layers in corners belong to the adjacent walls, which are at rest.
    for number in range(2 * len(low)):
        side, axis = side_of(scene, number), number // 2
        behind = points[:, axis] < low[axis] if number % 2 == 0 else points[:, axis] > high[axis]
        if side.kind == "wall":
            owner[behind] = bearer[axis, behind] = number
        if side.kind == "wall" and holds(side, scene):
            viscosity[behind] = material.viscosity
        if side.velocity is not None:
            velocity[behind] = side.velocity
    place, speed = np.ascontiguousarray(points.T), np.ascontiguousarray(velocity.T)
    return Dummies(place, speed, viscosity, volumes, owner, np.where(bearer < 0, owner, bearer))


OFF = 1e-3
"""The distance from the walls at which the guard keeps particles, in spacings."""
STANDOFF = 0.1
"""The distance, in spacings, below which walls repel particles (see `boundaries.walls`). A larger one slows the front
of a dam break.
"""


def guard_of(scene: SphScene, support: float) -> Guard:
    """The surfaces that reflect particles: all sides that are walls, and obstacles with few surfaces (see
    `has_surfaces`).
    """
    pieces, owner, own = [], list[int](), list[Any]()
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    for number, name in enumerate(scene.sides):
        if getattr(scene.tank, name).kind == "wall":
            normal = (1.0 - 2.0 * (number % 2)) * np.eye(len(low))[number // 2]
            pieces.append(planes([high if number % 2 else low], [normal]))
            owner.append(number)
            own.append(getattr(scene.tank, name))
    for index, (spec, shape) in enumerate(zip(scene.obstacles, obstacles_of(scene), strict=True)):
        if not has_surfaces(shape):
            continue
        pieces.append(_obstacle(shape, f"obstacles[{index}]"))
        owner += [2 * len(low) + index] * len(pieces[-1].kind)
        own += [spec] * len(pieces[-1].kind)
    walls = together(*pieces) if pieces else box(low.tolist(), high.tolist())._replace(**_nothing(len(low)))
    normal, tangential = (np.array([_own(scene, spec, key) for spec in own]) for key in COEFFICIENTS)
    packed = sheet(walls, normal, tangential)
    reach = STANDOFF * scene.spacing * (scene.tank.walls != "reflect")
    return Guard(
        packed, np.array(owner, np.int64), OFF * scene.spacing, reach, support, braking_weights(scene, support)
    )


PLANES = 129
"""The number of distances at which the kernel is summed over planes."""


def braking_weights(scene: SphScene, support: float) -> Array:
    """The kernel summed over planes up to the support (1/m); empty without braking."""
    if not impacts_dissipate(scene):
        return np.empty(0)
    shape = kernel(scene.method.kernel, dim=len(scene.tank.low))
    found: Array = np.asarray(shape.over_plane(np.linspace(0.0, shape.support, PLANES))) * (shape.support / support)
    return found


COEFFICIENTS = ("restitution", "tangential_restitution")


def _own(scene: SphScene, spec: Any, key: str) -> float:
    """The coefficient of a side or an obstacle; the default is that of the tank."""
    given = getattr(spec, key)
    return float(getattr(scene.tank, key) if given is None else given)


def _nothing(dimension: int) -> dict[str, Any]:
    none = np.zeros(0, np.int64)
    return {
        "kind": none,
        "place": np.zeros((0, 3)),
        "size": np.zeros(0),
        "velocity": np.zeros((0, 3)),
        "face": np.zeros((0, 2), np.int64),
    }


def has_surfaces(shape: Shape) -> bool:
    """Whether a shape is a box, a ball or a convex polygon, whose few surfaces can reflect particles. Other shapes move
    particles to the nearest point of their surface.
    """
    return isinstance(shape, (Ball, Box)) or (isinstance(shape, Polygon) and shape.convex())


def _obstacle(shape: Shape, path: str) -> Surfaces:
    try:
        if isinstance(shape, Ball):
            return outside(disc(tuple(shape.center), shape.radius))
        low, high = shape.bounds()
        return outside(polygon(shape.vertices) if isinstance(shape, Polygon) else box(low.tolist(), high.tolist()))
    except BadInput as error:
        raise SceneError([Fault(f"{path}.vertices", str(error))]) from error


ENDS = ("inflow", "outflow")


def open_boundaries_of(scene: SphScene, support: float) -> tuple[OpenBoundary, ...]:
    """The open sides, which have buffers behind them."""
    found, tank = [], scene.tank
    transported = PRESSURE_FORCES[scene.method.pressure_force].transported
    if transported and any(side.kind in ENDS for side in sides_of(scene)):
        message = "got 'transport', which is for closed flows; with in- and outflows use 'sum'"
        raise SceneError([Fault("method.pressure_force", message)])
    if scene.central_force is not None and any(side.kind in ENDS for side in sides_of(scene)):
        message = "goes with no in- or outflow: the pressure of the liquid behind those follows from gravity alone"
        raise SceneError([Fault("central_force", message)])
    layers = int(np.ceil(support / scene.spacing - 1e-9))
    for number in range(2 * len(tank.low)):
        side, axis = side_of(scene, number), number // 2
        if side.kind not in ENDS:
            continue
        low, high = np.array(tank.low), np.array(tank.high)
        place = float((low if number % 2 == 0 else high)[axis])
        level = place if axis == scene.up_axis else float(high[scene.up_axis])
        if side.level is not None:
            level = min(float(high[scene.up_axis]), side.level)
        if axis != scene.up_axis:
            high[scene.up_axis] = level
        walls = np.array([_walled(scene, k) and k != axis for k in range(len(low))])
        found.append(
            OpenBoundary(
                zone=number + 1,
                axis=axis,
                inward=1.0 if number % 2 == 0 else -1.0,
                place=place,
                enters=side.kind == "inflow",
                speed=side.speed or 0.0,
                curved=np.where(walls, 1.0 + (np.arange(len(low)) == scene.up_axis) * (side.level is not None), 0.0)
                * (side.profile == "parabolic"),
                low=low,
                high=high,
                layers=layers,
                pressure=side.pressure,
                level=level,
            )
        )
    return tuple(found)


def side_of(scene: SphScene, number: int) -> Any:
    """A side of the tank."""
    return sides_of(scene)[number]


def _walled(scene: SphScene, axis: int) -> bool:
    """Whether there is a wall at the low end of an axis."""
    return bool(side_of(scene, 2 * axis).kind == "wall")


def bounds_of(scene: SphScene) -> Array:
    """The limits (2, d) beyond which liquid that left through an open side is removed: one diagonal of the tank away
    from the tank.
    """
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    ends, far = np.array([low, high]), length(high - low)
    for number in range(2 * len(low)):
        kind = side_of(scene, number).kind
        sign = 2.0 * (number % 2) - 1.0
        ends[number % 2, number // 2] += sign * (far if kind == "open" or kind in ENDS else np.inf)
    return ends


UPRIGHT = (1.0, 0.0, 0.0, 0.0)
TOUCHING = 1e-3
"""The gap, in spacings, below which two solids touch."""
PANEL = {2: 0.25, 3: 0.5}
"""Width of the panels on which the pressure on solids is integrated, in spacings, by dimension."""


def bodies_of(scene: SphScene, boundary: Boundary) -> Bodies:
    """The bodies of a scene in their initial positions."""
    _require_possible(scene)
    shapes, obstacles = [shape_of(spec) for spec in scene.bodies], obstacles_of(scene)
    own = [in_own_axes(shape) for shape in shapes]
    centered = tuple(each.shape for each in own)
    mass = np.array([mass_of(spec, shape) for spec, shape in zip(scene.bodies, shapes, strict=True)])
    inertia = np.array([shape.inertia() for shape in centered]).reshape(-1, 3).T
    if len(scene.tank.low) == 2:
        inertia = inertia * np.array([[0.0], [0.0], [1.0]])
    first = len(boundary.names) - len(shapes)
    pose = np.array([_pose(*pair) for pair in zip(shapes, own, strict=True)]).reshape(-1, 7).T.copy()
    motion = np.array([_motion(spec) for spec in scene.bodies]).reshape(-1, 6).T.copy()
    paths = paths_of(scene)
    for body, path in paths:
        pose[:, body], motion[:, body], _ = on_path(path, 0.0)
        inertia[:, body] = 0.0
    return Bodies(
        shapes=centered,
        rims=tuple(_wide(shape.rim(0.5 * scene.spacing)) for shape in centered),
        pose=pose,
        motion=motion,
        mass=mass,
        inertia=np.ascontiguousarray(np.where(np.isfinite(mass), mass, 0.0) * inertia),
        restitution=np.array([spec.restitution for spec in scene.bodies]),
        friction=np.array([spec.friction for spec in scene.bodies]),
        first=int(np.count_nonzero(boundary.dummies.owner < first)),
        obstacles=tuple(obstacles),
        obstacle_rims=tuple(_wide(shape.rim(0.5 * scene.spacing)) for shape in obstacles),
        panels=tuple(shape.panels(PANEL[len(scene.tank.low)] * scene.spacing) for shape in (*obstacles, *centered)),
        drawn=tuple(number for number, shape in enumerate(obstacles) if not has_surfaces(shape)),
        paths=paths,
    )


def paths_of(scene: SphScene) -> tuple[tuple[int, BodyPath], ...]:
    """The paths of bodies with a prescribed motion. Raises SceneError where one leads through a wall."""
    found = []
    for body, spec in enumerate(scene.bodies):
        if spec.motion is None:
            continue
        shape = shape_of(spec)
        pose = np.array(_pose(shape, in_own_axes(shape)))
        pivot = pose[:3] if spec.motion.pivot is None else _wide(np.array([spec.motion.pivot]))[0]
        axis = np.array(spec.motion.axis) / length(np.array(spec.motion.axis))
        drive = _drive_of_body(spec.motion, len(scene.tank.low), scene.duration)
        path = BodyPath(drive, pivot.copy(), axis, pose)
        if np.abs(drive_at(drive, 0.0)[0]).max() > 1e-12:
            message = "has moved the body at t = 0; expected a path that begins at 0, where the body is drawn"
            raise SceneError([Fault(f"bodies[{body}].motion", message)])
        _require_within_walls(scene, body, path)
        found.append((body, path))
    return tuple(found)


def _drive_of_body(spec: BodyMotionSpec, dimension: int, duration: float) -> Drive:
    """The drive of displacement and angle of a body, four rows."""
    height, times, values = np.zeros(4), np.zeros(1), np.zeros((4, 1))
    formulas = spec.formulas()
    if formulas:
        return Drive(height, 0.0, 0.0, 0.0, times, values, formulas)
    if spec.times:
        times, values = np.array(spec.times), np.zeros((4, len(spec.times)))
        if spec.positions:
            values[:dimension] = np.array(spec.positions).T
        if spec.angles:
            values[3] = spec.angles
    elif spec.frequency is None:
        end = max(duration, spec.start) + duration if spec.until is None else spec.until
        times, values = np.array([spec.start, end]), np.zeros((4, 2))
        values[:dimension, 1] = (end - spec.start) * np.array(spec.velocity or (0.0,) * dimension)
        values[3, 1] = (end - spec.start) * spec.spin
    else:
        height[:dimension] = spec.amplitude or (0.0,) * dimension
        height[3] = spec.angle_amplitude
    return Drive(height, 2.0 * math.pi * (spec.frequency or 0.0), spec.phase, -math.sin(spec.phase), times, values)


TRIED = 200
"""The number of times at which a path is compared with the walls, beside those of its table and the ends of a sine."""


def _instants(drive: Drive, duration: float) -> Array:
    """The times of a run at which a path is compared with the walls."""
    # The extrema of the first periods suffice for a sine.
    ends = [((k + 0.5) * math.pi - drive.phase) / drive.turning for k in range(-3, 6) if drive.turning > 0.0]
    times = np.concatenate([np.linspace(0.0, duration, TRIED), drive.times, ends])
    return np.unique(times[(times >= 0.0) & (times <= duration)])


def _require_within_walls(scene: SphScene, body: int, path: BodyPath) -> None:
    """Raise SceneError where a path leads through a wall of the tank, since the wall would create images of the
    dummies. A path may lead through open sides.
    """
    slack = TOUCHING * scene.spacing
    walled = [number for number, side in enumerate(sides_of(scene)) if side.kind != "open"]
    shape, middle = shape_of(scene.bodies[body]), path.pose[:3]
    rim = _wide(shape.rim(0.5 * scene.spacing)) - middle
    for time in _instants(path.drive, scene.duration):
        pose = on_path(path, float(time))[0]
        turn = product(rotations(pose[:, None])[0], rotations(path.pose[:, None])[0].T)
        points = pose[:3] + product(rim, turn.T)
        for number in walled:
            axis, upper = divmod(number, 2)
            beyond = points[:, axis] - scene.tank.high[axis] if upper else scene.tank.low[axis] - points[:, axis]
            deep = float(beyond.max())
            if deep > slack:
                where = f"{with_prefix(deep, 'm', 3)} through the {scene.sides[number]} side at t = {time:.3g} s"
                message = f"leads {where}; expected a path inside of the tank, or through a side that is open"
                raise SceneError([Fault(f"bodies[{body}].motion", message)])


def driven_speeds(scene: SphScene) -> list[float]:
    """An upper bound of the speed of each body with a prescribed motion (m/s)."""
    speeds = []
    for body, path in paths_of(scene):
        rate = fastest_rates(path.drive, scene.duration)
        rim = _wide(shape_of(scene.bodies[body]).rim(0.5 * scene.spacing)) - path.pivot
        reach = np.sqrt((rim**2).sum(axis=1).max())
        speeds.append(length(rate[:3]) + float(rate[3] * reach))
    return speeds


def fastest_rates(drive: Drive, duration: float) -> Array:
    """An upper bound of the rate of each row of a drive; of a formula the largest one at many times of a run."""
    rate = np.abs(drive.amplitude) * drive.turning
    if len(drive.times) > 1:
        rate = rate + np.abs(np.diff(drive.values) / np.diff(drive.times)).max(axis=1)
    if drive.formulas:
        fastest = [max(abs(formula_at(text, time)[1]) for time in tried(duration)) for text in drive.formulas]
        rate = rate + np.array(fastest)
    return rate


def _pose(shape: Shape, own: OwnAxes) -> list[float]:
    """The middle of a body, and the quaternion of its principal axes."""
    turn = own.turn
    from scipy.spatial.transform import Rotation

    upright = UPRIGHT if (turn == np.eye(3)).all() else np.roll(Rotation.from_matrix(turn).as_quat(), 1).tolist()
    return [*_wide(shape.middle()[None])[0], *upright]


def _require_possible(scene: SphScene) -> None:
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    faults = []
    for index, spec in enumerate(scene.bodies):
        ends = np.stack(shape_of(spec).bounds())
        if any(side.kind == "periodic" for side in sides_of(scene)):
            faults.append(Fault(f"bodies[{index}]", "a tank with bodies cannot have periodic sides; use walls"))
        if spec.motion is None and ((ends[0] < low - 1e-9).any() or (ends[1] > high + 1e-9).any()):
            faults.append(Fault(f"bodies[{index}]", "reaches out of the tank; expected a body inside it"))
    faults += _overlaps(scene)
    for name, shape in _named(scene):
        if isinstance(shape, Mesh) and shape.overlaps():
            faults.append(Fault(name, "has shells that overlap; unite them where they were drawn"))
    if scene.bodies and scene.method.pressure_split == "modified":
        faults.append(Fault("method.pressure_split", "got 'modified'; bodies need the whole pressure: use 'none'"))
    if faults:
        raise SceneError(faults)


def _named(scene: SphScene) -> list[tuple[str, Shape]]:
    """Obstacles and bodies with their names in messages."""
    return list(zip(scene.solid_labels, solids_of(scene), strict=True))


def _overlaps(scene: SphScene) -> list[Fault]:
    """Faults of bodies that start inside an obstacle or an earlier body, beyond rounding."""
    faults, slack = [], TOUCHING * scene.spacing
    solids = _named(scene)[: len(scene.obstacles)]
    for index, spec in enumerate(scene.bodies):
        mine = shape_of(spec)
        for name, other in solids:
            deep = _overlap(mine, other, 0.5 * scene.spacing)
            if deep > slack:
                faults.append(
                    Fault(
                        f"bodies[{index}]", f"starts {with_prefix(deep, 'm', 3)} inside {name}; leave room between them"
                    )
                )
        solids.append((spec.name or f"bodies[{index}]", mine))
    return faults


def _overlap(one: Shape, other: Shape, fine: float) -> float:
    """The depth of the deepest rim point of one shape inside the other (m); negative without overlap."""
    pairs = (one, other), (other, one)
    return max(-float(inside.nearest(outer.rim(fine))[0].min()) for outer, inside in pairs)


def mass_of(spec: BodySpec, shape: Shape) -> float:
    """The mass of a body (kg; in 2D kg per meter of depth); infinite with a prescribed motion."""
    if spec.motion is not None:
        return math.inf
    return spec.mass if spec.mass is not None else float(spec.density or 0.0) * shape.volume()


def _motion(spec: BodySpec) -> list[float]:
    velocity = [*(spec.velocity or ()), 0.0, 0.0, 0.0][:3]
    return [*velocity, *(spec.spin if isinstance(spec.spin, tuple) else (0.0, 0.0, spec.spin))]


def _wide(points: Array) -> Array:
    return np.pad(points, ((0, 0), (0, 3 - points.shape[1])))


def drives_of(scene: SphScene) -> tuple[tuple[int, Drive], ...]:
    """The drives of moving sides, by the side's index."""
    found = []
    for number, name in enumerate(scene.sides):
        motion = getattr(scene.tank, name).motion
        if motion is not None:
            found.append((number, _drive(motion, motion.amplitude, motion.positions, -1.0)))
    return tuple(found)


def base_excitation_of(scene: SphScene) -> Drive | None:
    """The acceleration that the base excitation adds to gravity."""
    excitation = scene.base_excitation
    return None if excitation is None else _drive(excitation, excitation.amplitude, excitation.accelerations, 0.0)


def roll_of(scene: SphScene) -> Roll | None:
    """The rotation of the tank; by default about the middle of its floor. Raises SceneError beside what it would have
    to turn as well.
    """
    spec = scene.roll
    if spec is None:
        return None
    kinds = {side.kind for side in sides_of(scene)}
    present = {
        "bodies": bool(scene.bodies),
        "central_force": scene.central_force is not None,
        "passive_tracers": any(one.radius > 0.0 for one in scene.passive_tracers),
        "tank": bool(kinds & {"periodic", "inflow", "outflow"}),
        "method.pressure_split": scene.method.pressure_split != "none",
    }
    if there := [name for name, is_there in present.items() if is_there]:
        message = (
            "does not go with [roll], which acts on liquid between walls alone; expected none, or a tank that is one "
            "of [[bodies]] with a motion"
        )
        raise SceneError([Fault(name, message) for name in there])
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    middle = 0.5 * (low + high)
    middle[scene.up_axis] = low[scene.up_axis]
    pivot = middle if spec.pivot is None else np.array(spec.pivot)
    axis = np.array(spec.axis) / length(np.array(spec.axis))
    return Roll(_drive(spec, spec.amplitude, (), -1.0), _wide(pivot[None])[0], axis)


def _drive(spec: MotionSpec | BaseExcitationSpec | RollSpec, amplitude: object, values: object, origin: float) -> Drive:
    if spec.formula:
        texts = (spec.formula,) if isinstance(spec.formula, str) else spec.formula
        none = np.zeros(len(texts))
        return Drive(none, 0.0, 0.0, 0.0, np.zeros(1), none[:, None], texts)
    if amplitude is None and not isinstance(spec, RollSpec):
        return Drive(np.zeros(1), 0.0, 0.0, 0.0, np.array(spec.times), np.atleast_2d(np.array(values).T))
    height = np.atleast_1d(np.array(amplitude, np.float64))
    none = np.zeros((len(height), 1))
    start = origin * math.sin(spec.phase)
    return Drive(height, 2.0 * math.pi * (spec.frequency or 0.0), spec.phase, start, np.zeros(1), none)


def fastest_drive(scene: SphScene) -> float:
    """The largest speed of a moving side."""
    return max((float(fastest_rates(drive, scene.duration)[0]) for _, drive in drives_of(scene)), default=0.0)
