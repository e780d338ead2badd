"""From the shapes of a scene to constants: outline, contact line, inertia and friction of each shape, the tables of
all bodies, and their time scales.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.engine.outlines import Outlines, Stance, bodies_near, turn_corners, wall_near
from ecume.engine.walls import wall_count
from ecume.errors import Fault, SceneError
from ecume.laws import drag, flotation
from ecume.laws.contact_lines import (
    Line,
    ellipsoid_friction,
    ellipsoid_turning_friction,
    ellipsoid_undulation,
    needle_charge,
    spread_charges,
    star_charges,
)
from ecume.models.floating.dishes import wall_strengths
from ecume.models.floating.options import Built
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.setup.kinds import distinct_kinds
from ecume.models.floating.shaped.bodies import Shaped, body_pair_forces
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene, ShapeSpec


FINE = 720
"""Number of points of an outline for area and inertia; the area is accurate to 1e-5."""

WET = 0.5
"""Friction of a flat body at the surface, over that of an immersed body."""


class Skeleton(NamedTuple):
    """An outline in the frame of the body; see `ecume.engine.outlines.Outlines`. Lengths in m."""

    axes: tuple[float, float] = (0.0, 0.0)
    corners: tuple[tuple[float, float], ...] = ()
    edges: tuple[tuple[int, int], ...] = ()
    rounding: float = 0.0


class Figure(NamedTuple):
    """One body: outline, contact line, inertia and friction."""

    skeleton: Skeleton
    line: Line
    """the contact line, with its charge"""
    inertia: float
    """kg m^2"""
    friction: tuple[float, float, float]
    """along, across (N s/m), turning (N m s)"""
    tips: float = 0.0
    """m: distance of the charges of the arms of a star from its center"""


def charges_of(figure: Figure) -> tuple[Array, Array]:
    """Positions (P, 2) and charges (P,) inside the contact line (m)."""
    return star_charges(figure.line, figure.tips) if figure.tips else spread_charges(figure.line)


class FloatingShape(NamedTuple):
    """A shape in equilibrium."""

    body: flotation.Body
    equilibrium: flotation.Equilibrium
    mass: float
    figure: Figure


class Given(NamedTuple):
    """A shape as given in a scene."""

    shape: ShapeSpec
    radius: float
    density: float
    contact_angle: float
    """NaN if an edge pins the contact line"""
    theory: str


def floating_shape(given: Given, liquid: flotation.Liquid) -> FloatingShape:
    """Return a shape in equilibrium. Raises BadInput if it sinks."""
    return SHAPE_KINDS[given.shape.kind](given, liquid)


def _ellipsoid(given: Given, liquid: flotation.Liquid) -> FloatingShape:
    width = given.shape.width or 0.0
    axes = given.radius, 0.5 * width, 0.5 * (given.shape.thickness or width)
    body = flotation.Ellipsoid(axes, given.density, given.contact_angle)
    balance = flotation.equilibrium(body, liquid)
    charge = flotation.capillary_charge(body, liquid, given.theory)
    rise = given.shape.undulation
    if rise is None:
        rise = ellipsoid_undulation(axes[0], axes[1], given.contact_angle)
    cut = balance.contact_radius / math.sqrt(axes[0] * axes[1])
    line = Line(cut * axes[0], cut * axes[1], charge, given.shape.mode or 2, rise)
    mass = given.density * 4.0 / 3.0 * math.pi * math.prod(axes)
    wet = float(drag.factor_at_filling(balance.filling_angle))
    inertia = mass * (axes[0] ** 2 + axes[1] ** 2) / 5.0
    figure = Figure(skeleton_of(given.shape, given.radius), line, inertia, _friction(axes, wet, liquid))
    return FloatingShape(body, balance, mass, figure)


def _needle(given: Given, liquid: flotation.Liquid) -> FloatingShape:
    thick = 0.5 * (given.shape.width or 0.0)
    body = flotation.HorizontalCylinder(thick, given.density, given.contact_angle)
    balance = flotation.equilibrium(body, liquid, given.theory)
    straight = 2.0 * (given.radius - thick)
    charge = needle_charge(2.0 * given.radius, balance.slope_angle)
    line = Line(given.radius, balance.contact_radius, charge, given.shape.mode or 2, given.shape.undulation or 0.0)
    shaft, ends = (given.density * math.pi * thick**2 * length for length in (straight, 4.0 / 3.0 * thick))
    inertia = shaft * (3.0 * thick**2 + straight**2) / 12.0
    inertia += ends * (0.4 * thick**2 + 0.25 * straight**2 + 0.375 * straight * thick)
    wet = float(drag.factor_at_filling(balance.filling_angle))
    friction = _friction((given.radius, thick, thick), wet, liquid)
    figure = Figure(skeleton_of(given.shape, given.radius), line, inertia, friction)
    return FloatingShape(body, balance, shaft + ends, figure)


def _plate(given: Given, liquid: flotation.Liquid) -> FloatingShape:
    """A flat body with a pinned contact line: equilibrium and drag are those of a disc of the same area."""
    skeleton = skeleton_of(given.shape, given.radius)
    thickness = given.shape.thickness or given.shape.width or 2.0 * _half_side(given.shape, given.radius)
    area, second = moments(silhouette(skeleton, count=FINE))
    even = math.sqrt(area / math.pi)
    solid = flotation.VerticalCylinder(even, thickness, given.density, 0.5 * math.pi)
    body = flotation.disc_of_cylinder(solid, liquid, given.shape.rim)
    balance = flotation.equilibrium(body, liquid)
    charge = flotation.capillary_charge(body, liquid, given.theory)
    line = Line(given.radius, given.radius, charge, given.shape.mode or 2, given.shape.undulation or 0.0)
    friction = _friction((even, even, 0.5 * thickness), WET, liquid)
    inertia = given.density * thickness * second
    tips = given.radius - skeleton.rounding if given.shape.kind == "star" else 0.0
    figure = Figure(skeleton, line, inertia, friction, tips)
    return FloatingShape(body, balance, given.density * area * thickness, figure)


def _friction(axes: tuple[float, float, float], wet: float, liquid: flotation.Liquid) -> tuple[float, float, float]:
    """The friction of an ellipsoid with these semi-axes, times the fraction `wet` (0.5 for a sphere at 90 degrees)."""
    a, b, c = axes
    viscosity = wet * liquid.viscosity
    return (
        ellipsoid_friction(a, b, c, viscosity),
        ellipsoid_friction(b, a, c, viscosity),
        ellipsoid_turning_friction(a, b, c, viscosity),
    )


SHAPE_KINDS: dict[str, Callable[[Given, flotation.Liquid], FloatingShape]] = {
    "ellipsoid": _ellipsoid,
    "needle": _needle,
    "square": _plate,
    "star": _plate,
}


def skeleton_of(shape: ShapeSpec, radius: float) -> Skeleton:
    """The outline of a shape inside its circumscribed circle."""
    thick = 0.5 * (shape.width or 0.0)
    if shape.kind == "ellipsoid":
        return Skeleton(axes=(radius, thick))
    if shape.kind == "needle":
        return Skeleton((0.0, 0.0), ((thick - radius, 0.0), (radius - thick, 0.0)), ((0, 1),), thick)
    if shape.kind == "square":
        half = _half_side(shape, radius)
        out = math.sqrt(2.0) * (1.0 - shape.corner) * half
        corners = ((out, 0.0), (0.0, out), (-out, 0.0), (0.0, -out))
        return Skeleton((0.0, 0.0), corners, ((0, 1), (1, 2), (2, 3), (3, 0)), shape.corner * half)
    turns = [2.0 * math.pi * arm / shape.arms for arm in range(shape.arms)]
    tips = [((radius - thick) * math.cos(turn), (radius - thick) * math.sin(turn)) for turn in turns]
    edges = tuple((0, arm + 1) for arm in range(shape.arms))
    return Skeleton((0.0, 0.0), ((0.0, 0.0), *tips), edges, thick)


def _half_side(shape: ShapeSpec, radius: float) -> float:
    """Half the side of a square whose rounded corners touch the circumscribed circle."""
    return radius / (math.sqrt(2.0) * (1.0 - shape.corner) + shape.corner)


def round_figure(kind: flotation.Sphere | flotation.Disc, charge: float, mass: float, friction: float) -> Figure:
    """The figure of a sphere or a disc in a scene with shapes: no force turns it, and friction stops its spin."""
    radius = kind.radius
    share = 0.4 if isinstance(kind, flotation.Sphere) else 0.5
    turning = friction * radius**2 * (4.0 / 3.0 if isinstance(kind, flotation.Sphere) else 1.0)
    line = Line(radius, radius, charge)
    skeleton = Skeleton(axes=(radius, radius))
    return Figure(skeleton, line, share * mass * radius**2, (friction, friction, turning))


def silhouette(skeleton: Skeleton, count: int = 120) -> Array:
    """(count, 2) points of the outline in the frame of the body: each ray from its center crosses it once."""
    turn = 2.0 * math.pi * np.arange(count) / count
    rays = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    if skeleton.axes[0] > 0.0:
        ellipse: Array = rays * np.array(skeleton.axes)
        return ellipse
    places = np.array(skeleton.corners)
    reached = np.max([_out_of_disc(rays, place, skeleton.rounding) for place in places], axis=0)
    for (k, m), side in itertools.product(skeleton.edges, (-1.0, 1.0)):
        reached = np.maximum(reached, _out_of_side(rays, places[k], places[m], side * skeleton.rounding))
    points: Array = rays * reached[:, None]
    return points


def _out_of_disc(rays: Array, center: Array, radius: float) -> Array:
    """The distance along each ray to the far side of a disc; zero if it misses the disc."""
    along, across = rays @ center, rays[:, 0] * center[1] - rays[:, 1] * center[0]
    half = np.sqrt(np.maximum(radius**2 - across**2, 0.0))
    reached: Array = np.where(np.abs(across) <= radius, np.maximum(along + half, 0.0), 0.0)
    return reached


def _out_of_side(rays: Array, start: Array, end: Array, aside: float) -> Array:
    """The distance along each ray to the line parallel to an edge; zero if it does not cross it."""
    along = (end - start) / np.hypot(*(end - start))
    normal = np.array([-along[1], along[0]])
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (normal @ start + aside) / (rays @ normal)
        place = distance * (rays @ along) - start @ along
    met = np.isfinite(distance) & (distance > 0.0) & (place >= 0.0) & (place <= np.hypot(*(end - start)))
    return np.where(met, distance, 0.0)


def moments(points: Array) -> tuple[float, float]:
    """Area (m^2) and polar second moment (m^4) of a polygon around the origin."""
    following = np.roll(points, -1, axis=0)
    cross = points[:, 0] * following[:, 1] - points[:, 1] * following[:, 0]
    squares = np.sum(points**2 + points * following + following**2, axis=1)
    return 0.5 * float(cross.sum()), float(cross @ squares) / 12.0


NEIGHBORS = 6.0
NEARLY = 1.001
"""Distance over the touching distance at which the stiffness of the attraction is computed."""

TURN = 0.2
"""rad: the time step is a twentieth of the time for this rotation, since contacts predict tips along straight lines."""

MOST_SHAPES = 100_000
"""Floats have some ten to a hundred charges each, so that a step of so many already sums over some 1e9 pairs."""

DIFFERENCE = 1e-4
"""Step of finite differences, over the radius or in rad."""


def shapes_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """Return floats that turn and touch at their outlines. Raises SceneError if they are too large for the dish."""
    if faults := [*_too_many(len(parameters.floats.radius)), *_too_flat(parameters, parameters.walls.disc_radius)]:
        raise SceneError(faults)
    kinds, number = distinct_kinds(scene)
    figures = [kind.figure for kind in kinds]
    shaped = make_shaped([figures[k] for k in number], drag=scene.hydrodynamics.resists)
    strength = wall_strengths(scene, parameters.floats._replace(charge=shaped.charge))
    shaped = shaped._replace(wall_strength=strength)
    return Built(shaped, min(shortest_time(shaped, parameters, number), spinning_time(shaped, parameters, scene)))


def make_shaped(figures: Sequence[Figure], *, drag: bool = True) -> Shaped:
    """Return the tables of all bodies."""
    spread = [charges_of(figure) for figure in figures]
    shares = 1.0 if drag else 0.0
    return Shaped(
        outlines=outlines_of([figure.skeleton for figure in figures]),
        place=np.concatenate([places for places, _ in spread]),
        charge=np.concatenate([charges for _, charges in spread]),
        first=_firsts([len(charges) for _, charges in spread]),
        wall_strength=np.zeros((0, 0)),
        inertia=np.array([figure.inertia for figure in figures]),
        friction=shares * np.array([figure.friction for figure in figures]),
        places=_most_places([figure.skeleton for figure in figures]),
    )


def outlines_of(skeletons: Sequence[Skeleton]) -> Outlines:
    """Return the outlines of all bodies."""
    firsts = _firsts([len(skeleton.corners) for skeleton in skeletons])
    edges = [
        np.array(skeleton.edges, np.int64).reshape(-1, 2) + first
        for skeleton, first in zip(skeletons, firsts, strict=False)
    ]
    return Outlines(
        axes=np.array([skeleton.axes for skeleton in skeletons]),
        rounding=np.array([skeleton.rounding for skeleton in skeletons]),
        corner=np.concatenate([np.reshape(skeleton.corners, (-1, 2)) for skeleton in skeletons]),
        first_corner=firsts,
        edge=np.concatenate(edges),
        first_edge=_firsts([len(skeleton.edges) for skeleton in skeletons]),
    )


def _firsts(counts: Sequence[int]) -> Integers:
    return np.cumsum([0, *counts]).astype(np.int64)


def _most_places(skeletons: Sequence[Skeleton]) -> int:
    """The largest number of contact points of two bodies."""
    corners = max(len(skeleton.corners) for skeleton in skeletons)
    edges = max(len(skeleton.edges) for skeleton in skeletons)
    return 1 + corners + edges + corners * corners + 2 * corners * edges


def _too_many(count: int) -> list[Fault]:
    """The fault of more floats than sums over the charges of each pair can serve."""
    if count <= MOST_SHAPES:
        return []
    return [Fault("particles", f"got {count} floats in a scene with shapes; expected at most {MOST_SHAPES}")]


def _too_flat(parameters: Parameters, dish_radius: float) -> list[Fault]:
    """The fault of a float so large that it would touch a round wall at two points."""
    if float(parameters.floats.radius.max()) < 0.5 * dish_radius:
        return []
    return [Fault("dish.radius", f"{dish_radius:g} m is less than twice the radius of a float with a shape")]


def shortest_time(shaped: Shaped, parameters: Parameters, number: Integers) -> float:
    """The shortest time scale (s) of oscillation or relaxation of a pair, for six touching neighbors."""
    first = [int(np.flatnonzero(number == kind)[0]) for kind in np.unique(number)]
    found = [_times(shaped, parameters, (i, j)) for i, j in itertools.combinations_with_replacement(first, 2)]
    return min(found, default=math.inf)


def spinning_time(shaped: Shaped, parameters: Parameters, scene: FloatingScene) -> float:
    """The time (s) in which a float turns by `TURN` if the whole initial kinetic energy becomes rotation."""
    starts = [*(species.velocity for species in scene.particles), *((row.vx, row.vy) for row in scene.rows)]
    speed = max(math.hypot(*velocity) for velocity in starts)
    spin = speed * math.sqrt(float(np.max(parameters.floats.mass / shaped.inertia)))
    return TURN / spin if spin > 0.0 else math.inf


def _times(shaped: Shaped, parameters: Parameters, pair: tuple[int, int]) -> float:
    """The shortest time scale of two touching bodies, over their angles."""
    times = []
    ways = 0.0, 0.25 * math.pi, 0.5 * math.pi
    for turns in itertools.product(ways, ways):
        glide, turn = _stiffnesses(shaped, parameters, pair, turns)
        masses = parameters.floats.mass
        for i in pair:
            for stiff, inertia, friction in (
                (glide, masses[i], shaped.friction[i, :2].min()),
                (turn, shaped.inertia[i], shaped.friction[i, 2]),
            ):
                if stiff > 0.0:
                    slow = 0.0 if not parameters.scheme.inertia else math.sqrt(inertia / (NEIGHBORS * stiff))
                    times.append(max(slow, friction / (NEIGHBORS * stiff)))
    return min(times, default=math.inf)


def _stiffnesses(
    shaped: Shaped, parameters: Parameters, pair: tuple[int, int], turns: tuple[float, float]
) -> tuple[float, float]:
    """The stiffnesses |dF/dl| (N/m) and |d torque/d angle| (N m) of two touching bodies, by finite differences."""
    apart = touching_distance(shaped, parameters, pair, turns) * NEARLY
    size = DIFFERENCE * float(parameters.floats.radius[list(pair)].min())
    near, far = (_pull(shaped, parameters, pair, turns, apart + step) for step in (0.0, size))
    turned = _pull(shaped, parameters, pair, (turns[0] + DIFFERENCE, turns[1]), apart)
    return abs(far[0] - near[0]) / size, abs(turned[2] - near[2]) / DIFFERENCE


def _pull(
    shaped: Shaped, parameters: Parameters, pair: tuple[int, int], turns: tuple[float, float], apart: float
) -> tuple[float, float, float, float]:
    """The forces and torques of two bodies, the second to the right of the first; both may be the same body."""
    blocks = [slice(shaped.first[k], shaped.first[k + 1]) for k in pair]
    two = shaped._replace(
        charge=np.concatenate([shaped.charge[block] for block in blocks]),
        first=_firsts([block.stop - block.start for block in blocks]),
    )
    at = np.concatenate([_turned(shaped.place[block], turn) for block, turn in zip(blocks, turns, strict=True)])
    found: tuple[float, float, float, float] = body_pair_forces(two, parameters, at, (0, 1), (apart, 0.0))
    return found


def _turned(points: Array, angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.asarray(points @ np.array([[c, s], [-s, c]]))


def touching_distance(
    shaped: Shaped, parameters: Parameters, pair: tuple[int, int], turns: tuple[float, float]
) -> float:
    """The distance of the centers of two touching bodies, the second to the right of the first, by bisection."""
    outlines = _two(shaped.outlines, pair)
    near, far = 0.0, 2.0 * float(parameters.floats.radius[list(pair)].max())
    found = np.zeros((shaped.places, 8))
    for _ in range(30):
        middle = 0.5 * (near + far)
        stance = Stance(np.array([[0.0, 0.0], [middle, 0.0]]), np.array(turns), np.zeros_like(outlines.corner))
        turn_corners(outlines, stance)
        total = bodies_near(outlines, stance, 0, 1, far, found)
        apart = total == 0 or float(found[:total, 0].min()) > 0.0
        near, far = (near, middle) if apart and middle > 1e-3 * far else (middle, far)
    return far


def _two(outlines: Outlines, pair: tuple[int, int]) -> Outlines:
    """The outlines of two bodies, which may be the same."""
    corners = [slice(outlines.first_corner[k], outlines.first_corner[k + 1]) for k in pair]
    edges = [slice(outlines.first_edge[k], outlines.first_edge[k + 1]) for k in pair]
    first = _firsts([part.stop - part.start for part in corners])
    return Outlines(
        outlines.axes[list(pair)],
        outlines.rounding[list(pair)],
        np.concatenate([outlines.corner[part] for part in corners]),
        first,
        np.concatenate(
            [outlines.edge[e] - c.start + first[k] for k, (e, c) in enumerate(zip(edges, corners, strict=True))]
        ),
        _firsts([part.stop - part.start for part in edges]),
    )


def overlaps(
    outlines: Outlines, places: int, parameters: Parameters, at: tuple[Array, Array], reach: float
) -> list[tuple[int, int, float]]:
    """Pairs (i, j, gap) nearer than `reach`, for bodies `at` these positions and angles; a wall number k stands as
    N + k. For starts and frames: each with each.
    """
    (position, angle), radius, count = at, parameters.floats.radius, len(at[0])
    stance = Stance(np.ascontiguousarray(position), np.ascontiguousarray(angle), np.zeros_like(outlines.corner))
    turn_corners(outlines, stance)
    near, found = np.zeros((places, 8)), []
    for i in range(count):
        apart = np.hypot(*(position[i + 1 :] - position[i]).T)
        for j in i + 1 + np.flatnonzero(apart < radius[i] + radius[i + 1 :] + reach):
            total = bodies_near(outlines, stance, i, int(j), reach, near)
            if total:
                found.append((i, int(j), float(near[:total, 0].min())))
        for wall in range(wall_count(parameters.walls)):
            total = wall_near(outlines, stance, parameters.walls, (i, wall), reach, near)
            if total:
                found.append((i, count + wall, float(near[:total, 0].min())))
    return found
