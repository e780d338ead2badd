"""The shapes of floats: outline, contact line, inertia and friction of each, in equilibrium."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecume.laws import flotation, immersion
from ecume.laws.contact_lines import (
    Line,
    ellipsoid_friction,
    ellipsoid_turning_friction,
    ellipsoid_undulation,
    elongation,
    needle_charge,
    spread_charges,
    star_charges,
)
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import ShapeSpec


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
    elongation: float = 0.0
    """see `contact_lines.elongation`"""
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
    """A shape as specified in a scene."""

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
    wet = float(immersion.factor_at_filling(balance.filling_angle, liquid.share_above))
    inertia = mass * (axes[0] ** 2 + axes[1] ** 2) / 5.0
    friction, long = _friction(axes, wet, liquid), elongation(axes[0], axes[1])
    figure = Figure(skeleton_of(given.shape, given.radius), line, inertia, friction, long)
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
    wet = float(immersion.factor_at_filling(balance.filling_angle, liquid.share_above))
    friction = _friction((given.radius, thick, thick), wet, liquid)
    figure = Figure(skeleton_of(given.shape, given.radius), line, inertia, friction, elongation(given.radius, thick))
    return FloatingShape(body, balance, shaft + ends, figure)


def _plate(given: Given, liquid: flotation.Liquid) -> FloatingShape:
    """A flat body with a pinned contact line: its equilibrium and drag are those of a disc of the same area."""
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
    figure = Figure(skeleton, line, inertia, friction, tips=tips)
    return FloatingShape(body, balance, given.density * area * thickness, figure)


def _friction(axes: tuple[float, float, float], wet: float, liquid: flotation.Liquid) -> tuple[float, float, float]:
    """The friction of an ellipsoid with these semi-axes, times the fraction `wet` (0.5 for a sphere at 90 degrees)."""
    a, b, c = axes
    viscosity = wet * liquid.viscosity_of_both
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
    """The constants of a sphere or a disc in a scene with shapes: no force turns it, and friction stops its spin."""
    radius = kind.radius
    share = 0.4 if isinstance(kind, flotation.Sphere) else 0.5
    turning = friction * radius**2 * (4.0 / 3.0 if isinstance(kind, flotation.Sphere) else 1.0)
    line = Line(radius, radius, charge)
    skeleton = Skeleton(axes=(radius, radius))
    return Figure(skeleton, line, share * mass * radius**2, (friction, friction, turning))


def inner_radius(skeleton: Skeleton) -> float:
    """The smallest distance of an outline from its center (m)."""
    return float(np.hypot(*silhouette(skeleton).T).min())


def covered_by_outline(figure: Figure) -> float:
    """The smallest distance of the charges of a body from its outline, and thus from any wall (m)."""
    apart = silhouette(figure.skeleton)[:, None] - charges_of(figure)[0]
    return float(np.hypot(apart[..., 0], apart[..., 1]).min())


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
    """The distance along each ray to the line parallel to an edge at the distance `aside`; zero if the ray does not
    cross it.
    """
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
