"""Menisci at plane, round and rectangular walls, and the image forces on floats near them.

Image forces: at a wall with a constant contact angle the image of a float has the same sign, and the wall attracts the
float; at a wall that pins the contact line the image has the opposite sign, and the wall repels the float. Both hold
for charges of either sign. Exact in linear theory.

Surfaces at walls: a plane wall, a round dish, a rectangular dish. Heights are measured from the undisturbed surface.
The contact angle is that of the wall, through the liquid: below 90 degrees the liquid rises at the wall. An overfull
brim, or one that pins the contact line, corresponds to another angle. A fixed volume of liquid shifts the undisturbed
surface, without forces.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ecume.errors import BadInput
from ecume.laws.arguments import SMALLEST, as_distances, as_given, chosen, elementwise, require_angle, require_positive
from ecume.laws.flotation.bodies import Liquid
from ecume.laws.flotation.young_laplace import sloping_amplitude, sloping_height
from ecume.laws.special import bessel_k1, scaled_bessel_i0, scaled_bessel_k0, scaled_bessel_k1
from ecume.units import Angle, Angles, Array, Force, Forces, Length, Lengths, Number, Numbers

WALLS = {"fixed-angle": 1.0, "pinned": -1.0}
"""The sign of an image: for a wall that keeps the contact angle, and for one that pins the contact line."""
MOST_TERMS = 100_000
DIGITS = 20.0
"""Terms smaller than exp(-2 DIGITS) of the sum are ignored."""
CENTER = 1e-6
"""The distance from the axis, in L, below which the force is proportional to r."""
FAR = 40.0
"""The distance in L beyond which images are ignored."""


def image_force(charge: Length, r: Lengths, dish_radius: Length, liquid: Liquid, wall: str = "fixed-angle") -> Forces:
    """Radial force of a round dish's images on a floater at r from its axis; positive points outward, to the wall.

    F = (2 pi gamma/L) A^2 sum_m c_m I_m(r) I_m'(r), with c_m = -(2 - delta_m0) K_m'(a)/I_m'(a) for a wall that keeps
    its contact angle ("fixed-angle": attracts), c_m = -(2 - delta_m0) K_m(a)/I_m(a) for one that pins the contact line
    ("pinned": repels). A: the charge; a: dish_radius. Near the wall it tends to `plane_image_force`. Derived from
    [nicolson1949]'s point charge.

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> image_force(1e-5, 0.018, 0.02, water) > 0 > image_force(1e-5, 0.018, 0.02, water, wall="pinned")
    True
    """
    require_positive("dish_radius", dish_radius)
    sign, length = chosen(WALLS, wall, "wall"), liquid.capillary_length
    distances = as_distances("r", r)
    if bool(np.any(distances >= dish_radius)):
        raise BadInput(f"r is {np.max(distances):g} m; expected less than the dish's radius, {dish_radius:g} m")
    slope = dish_sums(distances.ravel() / length, dish_radius / length, sign).slope
    strength = 2.0 * math.pi * liquid.surface_tension * charge**2 / length
    return as_given(strength * np.reshape(slope, distances.shape))


def plane_image_force(charge: Length, distance: Lengths, liquid: Liquid, wall: str = "fixed-angle") -> Forces:
    """Force of a plane wall's image on a float, positive toward the wall: (2 pi gamma/L) A^2 K1(2
    d/L), or minus that.

    [nicolson1949]'s pair law between a floater and its mirror image.

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> plane_image_force(1e-5, 1e-3, water) == -plane_image_force(1e-5, 1e-3, water, wall="pinned")
    True
    """
    from scipy.special import k1

    length = liquid.capillary_length
    distances = as_distances("distance", distance, SMALLEST)
    strength = chosen(WALLS, wall, "wall") * 2.0 * math.pi * liquid.surface_tension * charge**2 / length
    return as_given(strength * k1(2.0 * distances / length))


def rectangle_image_force(
    charge: Length,
    position: tuple[Length, Length],
    size: tuple[Length, Length],
    liquid: Liquid,
    wall: str = "fixed-angle",
) -> tuple[Force, Force]:
    """Force (x, y) of a rectangular dish's images on a floater; `position` from its middle, `size` full widths.

    Reflections at four walls give a lattice of images: at x + 2 k W, and at -x + (2 k + 1) W with the sign of the wall;
    the force of each is [nicolson1949]'s pair law.

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> x, y = rectangle_image_force(1e-5, (0.009, 0.0), (0.02, 0.03), water)
    >>> x > 0 == y
    True
    """
    sign, length = chosen(WALLS, wall, "wall"), liquid.capillary_length
    for coordinate, width in zip(position, size, strict=True):
        require_positive("width", width)
        if not abs(coordinate) < 0.5 * width:
            raise BadInput(f"position {position!r} is outside the dish of {size[0]:g} m by {size[1]:g} m")
    across, along = (_line(x / length, width / length, sign) for x, width in zip(position, size, strict=True))
    pull_x, pull_y = 0.0, 0.0
    for apart_x, sign_x in across:
        for apart_y, sign_y in along:
            apart = math.hypot(apart_x, apart_y)
            if 0.0 < apart < FAR:
                pull = sign_x * sign_y * bessel_k1(apart) / apart
                pull_x += pull * apart_x
                pull_y += pull * apart_y
    strength = 2.0 * math.pi * liquid.surface_tension * charge**2 / length
    return strength * pull_x, strength * pull_y


def _line(x: float, width: float, sign: float) -> list[tuple[float, float]]:
    """The distances and signs of the images of a coordinate, in pairs from the nearest on, after the coordinate
    itself.
    """
    images = [(0.0, 1.0)]
    for k in range(1, math.ceil(FAR / width) + 2):
        images += [(2.0 * k * width, 1.0), (-2.0 * k * width, 1.0)]
    for k in range(math.ceil(FAR / width) + 2):
        images += [((2 * k + 1) * width - 2.0 * x, sign), (-(2 * k + 1) * width - 2.0 * x, sign)]
    return images


class Sums(NamedTuple):
    """The two sums over the orders m of the images of a dish, at each r: of c_m I_m(r)^2 and of c_m I_m(r) I_m'(r)."""

    height: Array
    slope: Array


def dish_sums(r: Numbers, dish_radius: Number, sign: Number) -> Sums:
    """Both sums over images in a round dish, for distances from the axis and the radius in L; `sign` as in `WALLS`.
    [nicolson1949].
    """
    given = np.atleast_1d(r)
    near = np.maximum(given, CENTER)
    terms = math.ceil(DIGITS / -math.log(float(near.max()) / dish_radius)) + 20
    if terms > MOST_TERMS:
        raise BadInput(
            f"r is within {dish_radius - given.max():.2g} L of the wall of a dish of {dish_radius:.4g} L: "
            "too near for the sum; use plane_image_force"
        )
    m, wall = np.arange(terms)[:, None], np.array([dish_radius])
    inner, outer, falling = _i_ratios(near, terms), _i_ratios(wall, terms), _k_ratios(dish_radius, terms)
    start_i = np.array([math.log(scaled_bessel_i0(x)) + x for x in near])
    start_wall = math.log(scaled_bessel_i0(dish_radius)) + dish_radius
    start_k = math.log(scaled_bessel_k0(dish_radius)) - dish_radius
    logarithm = 2.0 * (start_i + _running(inner)) + start_k + _running(falling) - start_wall - _running(outer)
    weight = np.exp(logarithm) * np.where(m == 0, 1.0, 2.0)
    if sign > 0.0:
        weight = weight * (falling - m / dish_radius) / (outer + m / dish_radius)
    slope = (weight * (inner + m / near)).sum(axis=0) * given / near
    return Sums(sign * weight.sum(axis=0), sign * slope)


def _running(ratios: Array) -> Array:
    """The logarithms of cumulative products of the ratios."""
    return np.concatenate([np.zeros((1, ratios.shape[1])), np.cumsum(np.log(ratios[:-1]), axis=0)])


def _i_ratios(x: Array, terms: int) -> Array:
    """The ratios I_{m+1}(x)/I_m(x), by downward recurrence from a guess whose effect vanishes; orders and arguments
    never overflow.
    """
    ratios, ratio = np.empty((terms, len(x))), np.zeros_like(x)
    for m in range(terms + 30 + int(x.max()), 0, -1):
        ratio = 1.0 / (ratio + 2.0 * m / x)
        if m <= terms:
            ratios[m - 1] = ratio
    return ratios


def _k_ratios(x: float, terms: int) -> Array:
    """The ratios K_{m+1}(x)/K_m(x), by upward recurrence."""
    ratios = np.empty((terms, 1))
    ratios[0] = scaled_bessel_k1(x) / scaled_bessel_k0(x)
    for m in range(1, terms):
        ratios[m] = 1.0 / ratios[m - 1] + 2.0 * m / x
    return ratios


__all__ = [
    "dish_height",
    "facing_amplitude",
    "facing_pair",
    "image_force",
    "inclined_amplitude",
    "linear_wall_amplitude",
    "plane_amplitude",
    "plane_height",
    "plane_image_force",
    "plane_wall_height",
    "rectangle_height",
    "rectangle_image_force",
    "wall_amplitude",
    "wall_height",
]

CORE = 1e-3
"""The radius in L at which integration starts: closer to the axis, the linear surface is accurate to 1e-12."""
SHALLOW = 25.0
"""The distance from the wall (in L) beyond which slopes are below 1e-10, and the surface is the linear one."""
TOLERANCE = 1e-12
KEPT = 256
TURNS = 60


@elementwise
def wall_height(contact_angle: Angle, liquid: Liquid) -> Length:
    """Height of the liquid at a plane wall, exact: L sqrt(2 (1 - sin theta)), negative where it is depressed.
    [landau1987, par. 61].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> round(wall_height(0.0, water) / water.capillary_length, 9)
    1.414213562
    """
    return liquid.capillary_length * plane_wall_height(contact_angle)


@elementwise
def wall_amplitude(contact_angle: Angle, liquid: Liquid) -> Length:
    """Amplitude A_w of the meniscus far from a plane wall, A_w exp(-x/L); positive where the liquid rises, zero at 90
    degrees.

    A_w = 4 L exp(-2 - u + 2 tanh u), with u = arccosh(2 L/h) at the height h at the wall: the far field of the exact
    profile. The linear theory gives L cot(theta): 1.5 times as much at 45 degrees, infinite at 0. Derived from
    [landau1987, par. 61].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> round(wall_amplitude(math.radians(45.0), water) / water.capillary_length, 9)
    0.683288922
    """
    return liquid.capillary_length * plane_amplitude(contact_angle)


def linear_wall_amplitude(contact_angle: Angle, liquid: Liquid) -> Length:
    """Amplitude L cot(theta) of the linear theory for `wall_amplitude`; 1.5 times too large at 45 degrees.
    [landau1987].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> round(linear_wall_amplitude(math.radians(45.0), water) / water.capillary_length, 12)
    1.0
    """
    require_angle("contact_angle", contact_angle)
    if math.sin(contact_angle) < 1e-12:
        raise BadInput("the linear theory has no height at 0 or 180 degrees; use the amplitude theory")
    return liquid.capillary_length / math.tan(contact_angle)


AMPLITUDES: dict[str, Callable[[float, Liquid], float]] = {
    "amplitude": wall_amplitude,
    "linear": linear_wall_amplitude,
}


def facing_amplitude(width: Length, contact_angle: Angle, liquid: Liquid, theory: str = "amplitude") -> Length:
    """Amplitude A_w / (1 - exp(-W/L)) of each of two plane walls that face each other at a distance
    W.

    Each wall mirrors the meniscus of the other; with this amplitude the sum of the two exponentials has the correct
    slope at both walls. Exact in linear theory. [chan1981].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> facing_amplitude(0.01, 0.8, water) > wall_amplitude(0.8, water)
    True
    """
    require_positive("width", width)
    alone = chosen(AMPLITUDES, theory, "amplitude of a wall")(contact_angle, liquid)
    return alone / -math.expm1(-width / liquid.capillary_length)


class Tilt(NamedTuple):
    """The tilt of a dish: the angle of its axis from the vertical (rad), and the direction from the x axis to which its
    rim leans (rad).
    """

    angle: Angle = 0.0
    direction: Angle = 0.0


LEVEL = Tilt()


def level_cut(points: Lengths, tilt: Tilt) -> Lengths:
    """Where the lines through these points (K, 2) of a dish, parallel to its axis, meet the level surface: farther from
    the axis by 1/cos(angle) along the direction of the tilt. The axis meets the surface at the origin.

    >>> level_cut(np.array([[1.0, 1.0]]), Tilt(math.pi / 3.0)).round(12).tolist()
    [[2.0, 1.0]]
    """
    along = np.array([math.cos(tilt.direction), math.sin(tilt.direction)])
    stretch = 1.0 / math.cos(tilt.angle) - 1.0
    return as_given(np.asarray(points) + stretch * np.outer(np.asarray(points) @ along, along))


def level_normals(outward: Numbers, tilt: Tilt) -> Numbers:
    """The outward normals (K, 2) of the walls' lines in the level surface, from those of the walls in the dish.

    >>> level_normals(np.array([[1.0, 0.0], [0.6, 0.8]]), Tilt(math.pi / 3.0)).round(6).tolist()
    [[1.0, 0.0], [0.351123, 0.936329]]
    """
    along, given = np.array([math.cos(tilt.direction), math.sin(tilt.direction)]), np.asarray(outward)
    turned = given + (math.cos(tilt.angle) - 1.0) * np.outer(given @ along, along)
    return as_given(turned / np.linalg.norm(turned, axis=1)[:, None])


def inclinations(outward: Numbers, tilt: Tilt) -> Angles:
    """The inclinations (rad) of walls from the vertical, positive where a wall leans away from the liquid.

    A wall whose outward normal in the dish is n leans by beta, sin(beta) = sin(angle) n.d, with the direction d of the
    tilt.

    >>> inclinations(np.array([[1.0, 0.0], [0.0, 1.0]]), Tilt(0.3)).round(12).tolist()
    [0.3, 0.0]
    """
    share = np.asarray(outward) @ np.array([math.cos(tilt.direction), math.sin(tilt.direction)])
    return as_given(np.arcsin(np.clip(math.sin(tilt.angle) * share, -1.0, 1.0)))


def inclined_amplitude(contact_angle: Angle, inclination: Angle, liquid: Liquid, theory: str = "amplitude") -> Length:
    """Amplitude A of the meniscus A exp(-x/L) far from a plane wall that leans by beta, x from its line in the level
    surface: A = A_w(theta + beta) exp(-h_w tan(beta)/L).

    Such a wall meets the liquid as a vertical one with the contact angle theta + beta; its contact line is h_w(theta +
    beta) above the level surface, and therefore farther out by h_w tan(beta). Exact for a plane wall. "linear": L
    cot(theta + beta), without the second factor, which is of second order in the slope. Derived from [landau1987, par.
    61].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> inclined_amplitude(0.8, 0.0, water) == wall_amplitude(0.8, water)
    True
    >>> inclined_amplitude(0.8, 0.1, water) < wall_amplitude(0.9, water) < inclined_amplitude(0.8, -0.1, water)
    True
    """
    meets = contact_angle + inclination
    if not 0.0 <= meets <= math.pi:
        got = f"{math.degrees(contact_angle):.4g} and {math.degrees(inclination):.4g} degrees"
        raise BadInput(f"the contact angle and the inclination of the wall are {got}; expected a sum from 0 to 180")
    amplitude = chosen(AMPLITUDES, theory, "amplitude of a wall")(meets, liquid)
    if theory == "linear":
        return amplitude
    return amplitude * math.exp(-plane_wall_height(meets) * math.tan(inclination))


def facing_pair(first: Length, second: Length, width: Length, liquid: Liquid) -> tuple[Length, Length]:
    """Amplitudes of two plane walls that face each other, from those that each has alone: (A_1 + A_2 e)/(1 - e^2) with
    e = exp(-W/L), and the same with the numbers exchanged. For equal walls this is `facing_amplitude`. [chan1981].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> alone = wall_amplitude(0.8, water)
    >>> abs(facing_pair(alone, alone, 0.01, water)[0] / facing_amplitude(0.01, 0.8, water) - 1.0) < 1e-12
    True
    """
    require_positive("width", width)
    reach = math.exp(-width / liquid.capillary_length)
    left = -math.expm1(-2.0 * width / liquid.capillary_length)
    return (first + second * reach) / left, (second + first * reach) / left


EXACT = 1e-4
"""Singular values of the menisci of tangents below this, over the largest, count as zero: such menisci cancel."""


class Oval(NamedTuple):
    """An elliptic dish: the lengths of both axes (m), and its tilt."""

    size: tuple[Length, Length]
    tilt: Tilt = LEVEL


def oval_amplitudes(
    oval: Oval, directions: Angles, contact_angle: Angle, liquid: Liquid, theory: str = "amplitude"
) -> Lengths:
    """Amplitudes of plane menisci A exp(-d/L) at tangents of an elliptic dish, whose sum is the surface in the dish.

    A tangent touches at (a cos t, b sin t) for each t of `directions`. Each exponential solves the linear equation h =
    L^2 (h_xx + h_yy), and so does their sum. Least squares give it the slope A/L of a wall, `inclined_amplitude`, at
    256 points of the edge, as in Trefftz's method; without tilt the error of the slope is below 1 % for axes from 2 to
    400 L with a ratio of up to 4. In a circle all amplitudes are equal, and the sum over many tangents is
    A_w I0(r/L)/I1(a/L); a tilt adds A_1 I1(r/L)/I1'(a/L) cos(phi) in first order. [landau1987, par. 61].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> around = 2.0 * math.pi * np.arange(64) / 64.0
    >>> found = oval_amplitudes(Oval((0.04, 0.04)), around, 0.8, water)
    >>> at_center = float(np.sum(found)) * math.exp(-0.02 / water.capillary_length)
    >>> abs(at_center / dish_height(0.0, 0.02, 0.8, water) - 1.0) < 1e-6
    True
    """
    for name, length in (("size[0]", oval.size[0]), ("size[1]", oval.size[1])):
        require_positive(name, length)
    edge, outward, inclination = _cut_tangents(oval, 2.0 * math.pi * np.arange(256.0) / 256.0)
    touch, normal, _ = _cut_tangents(oval, directions)
    slope = [inclined_amplitude(contact_angle, float(each), liquid, theory) for each in inclination]
    away = np.sum(touch * normal, axis=1) - edge @ normal.T
    menisci = (outward @ normal.T) * np.exp(-away / liquid.capillary_length)
    return as_given(np.linalg.lstsq(menisci, np.array(slope), rcond=EXACT)[0])


def _cut_tangents(oval: Oval, directions: Angles) -> tuple[Array, Array, Array]:
    """The points of the edge in the level surface, the outward normals and the inclinations of the wall there."""
    points, outward = oval_tangents(oval.size, directions)
    normal, inclination = level_normals(outward, oval.tilt), inclinations(outward, oval.tilt)
    return np.asarray(level_cut(points, oval.tilt)), np.asarray(normal), np.asarray(inclination)


def oval_tangents(size: tuple[Length, Length], directions: Angles) -> tuple[Lengths, Numbers]:
    """The points (K, 2) of an ellipse at (a cos t, b sin t), and its outward normals there."""
    half, unit = 0.5 * np.array(size), np.column_stack([np.cos(directions), np.sin(directions)])
    outward = unit / half
    return half * unit, outward / np.linalg.norm(outward, axis=1)[:, None]


def plane_height(distance: Lengths, contact_angle: Angle, liquid: Liquid) -> Lengths:
    """Height of the surface at a distance from one plane wall, exact.

    x/L = u - u_0 + 2 (tanh u_0 - tanh u), with u = arccosh(2 L/h) and u_0 at the wall. [landau1987, par. 61].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> plane_height(0.0, 0.8, water) == wall_height(0.8, water)
    True
    """
    x = as_distances("distance", distance) / liquid.capillary_length
    highest = plane_wall_height(contact_angle)
    if highest == 0.0:
        return as_given(np.zeros_like(x))
    start = math.acosh(2.0 / abs(highest))
    u = x + start + 2.0 * (1.0 - math.tanh(start))
    for _ in range(TURNS):  # from above: x(u) is convex, so that Newton's method cannot overshoot
        slope = 1.0 - 2.0 / np.cosh(np.minimum(u, 300.0)) ** 2
        excess = u - start + 2.0 * (math.tanh(start) - np.tanh(u)) - x
        u = np.where(slope > 0.0, u - excess / np.where(slope > 0.0, slope, 1.0), u)
    profile = math.copysign(1.0, highest) * 4.0 * np.exp(-u) / (1.0 + np.exp(-2.0 * u))
    return as_given(liquid.capillary_length * np.where(x == 0.0, highest, profile))


def dish_height(
    r: Lengths, dish_radius: Length, contact_angle: Angle, liquid: Liquid, theory: str = "amplitude"
) -> Lengths:
    """Height of the surface in a round dish, at a distance r from its axis.

    "amplitude": A_w I0(r/L)/I1(a/L), the linear field with the plane wall's exact far amplitude; accurate in the middle
    to 1 % for dishes of 2 L and more, to 5 % for L; too low within 2 L of the wall. "linear": cot(theta) instead of
    A_w/L.
    "nonlinear": the axisymmetric Young–Laplace equation, shot from the middle. [vella2005, landau1987].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> 0 < dish_height(0.0, 0.01, 0.8, water) < dish_height(0.01, 0.01, 0.8, water)
    True
    """
    require_positive("dish_radius", dish_radius)
    require_angle("contact_angle", contact_angle)
    field = chosen(DISHES, theory, "theory of the dish")
    distances = as_distances("r", r)
    if bool(np.any(distances > dish_radius * (1.0 + 1e-9))):
        raise BadInput(f"r is {np.max(distances):g} m, outside the dish of radius {dish_radius:g} m")
    length = liquid.capillary_length
    return as_given(length * field(np.minimum(distances, dish_radius) / length, dish_radius / length, contact_angle))


def rectangle_height(
    position: tuple[Lengths, Lengths], size: tuple[Length, Length], contact_angle: Angle, liquid: Liquid
) -> Lengths:
    """Height of the surface in a rectangular dish: the sum of four plane menisci; `position` is from its middle,
    `size` full widths.

    h = sum over the walls of the `facing_amplitude` times exp(-x/L). Exact in linear theory (it is the separable
    solution, and its slope is right on each wall); steep menisci are higher within 2 L of a wall, most of all in the
    corners. [landau1987, par. 61].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> rectangle_height((0.0, 0.0), (0.02, 0.03), 0.8, water) > 0
    True
    """
    total = np.zeros(np.broadcast_shapes(np.shape(position[0]), np.shape(position[1])))
    for coordinate, width in zip(position, size, strict=True):
        amplitude = facing_amplitude(width, contact_angle, liquid)
        away = 0.5 * width - np.abs(np.asarray(coordinate, dtype=np.float64))
        if not bool(np.all(away >= -1e-9 * width)):
            raise BadInput(f"position {position!r} is outside the dish of {size[0]:g} m by {size[1]:g} m")
        length = liquid.capillary_length
        total = total + amplitude * (np.exp(-away / length) + np.exp((away - width) / length))
    return as_given(total)


def plane_wall_height(contact_angle: Angle) -> Number:
    """Height `wall_height` in capillary lengths.

    >>> round(plane_wall_height(math.radians(30.0)), 12)
    1.0
    """
    require_angle("contact_angle", contact_angle)
    # sqrt(2 (1 - sin theta)), without its cancellation at 90 degrees
    return sloping_height(contact_angle - 0.5 * math.pi)


def plane_amplitude(contact_angle: Angle) -> Number:
    """Amplitude `wall_amplitude` in capillary lengths.

    >>> round(plane_amplitude(0.0), 12)
    0.922317584014
    """
    require_angle("contact_angle", contact_angle)
    return sloping_amplitude(contact_angle - 0.5 * math.pi)


def _amplitude_field(r: Array, dish_radius: float, contact_angle: float) -> Array:
    return plane_amplitude(contact_angle) * _linear_shape(r, dish_radius)


def _linear_field(r: Array, dish_radius: float, contact_angle: float) -> Array:
    if math.sin(contact_angle) < 1e-12:
        raise BadInput("the linear theory has no height at 0 or 180 degrees; use the amplitude theory")
    return _linear_shape(r, dish_radius) / math.tan(contact_angle)


def _linear_shape(r: Array, dish_radius: float) -> Array:
    """The ratio I0(r)/I1(a) without overflow; lengths in L."""
    from scipy.special import i0e, i1e

    shape: Array = i0e(r) / i1e(dish_radius) * np.exp(r - dish_radius)
    return shape


def _nonlinear_field(r: Array, dish_radius: float, contact_angle: float) -> Array:
    """The exact surface. Only rising menisci are computed; depressed ones are mirror images."""
    if abs(plane_wall_height(contact_angle)) < 1e-9:
        return _amplitude_field(r, dish_radius, contact_angle)
    core, height, shot = _dish_profile(dish_radius, min(contact_angle, math.pi - contact_angle))
    inner = height * _linear_shape(np.minimum(r, core), dish_radius) / _linear_shape(np.array(core), dish_radius)
    outer = _height_at(np.maximum(r, core), shot)
    return math.copysign(1.0, plane_wall_height(contact_angle)) * np.where(r > core, outer, inner)


def _height_at(r: Array, shot: Any) -> Array:
    """The height z(r) on a computed curve, by bisection for the arc length, with which r increases."""
    low, high = np.zeros(r.shape), np.full(r.shape, shot.t[-1])
    for _ in range(TURNS):
        middle = 0.5 * (low + high)
        short = shot.sol(middle.ravel())[0].reshape(r.shape) < r
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    height: Array = shot.sol(high.ravel())[1].reshape(r.shape)
    # At a contact angle of 0 the curve is vertical at the wall: r determines the height only at its end.
    return np.where(r >= shot.y[0, -1] * (1.0 - TOLERANCE), shot.y[1, -1], height)


@lru_cache(maxsize=KEPT)
def _dish_profile(dish_radius: float, contact_angle: float) -> tuple[float, float, Any]:
    """The start of the integration, the height there, and the solution with the contact angle at the wall."""
    from scipy.optimize import brentq

    core = max(CORE, dish_radius - SHALLOW) if dish_radius > 2.0 * CORE else 0.5 * dish_radius

    def miss(logarithm: float) -> float:
        return float(_shot(core, math.exp(logarithm), contact_angle).y[0, -1]) - dish_radius

    # The higher the surface in the middle, the sooner its slope is that at the wall.
    guess = math.log(float(_amplitude_field(np.array(core), dish_radius, contact_angle)))
    low, high = guess - 0.5, guess + 0.5
    while miss(low) < 0.0:
        low -= 1.0
    while miss(high) > 0.0:
        high += 1.0
    height = math.exp(float(brentq(miss, low, high, xtol=1e-13)))
    return core, height, _shot(core, height, contact_angle)


def _shot(core: float, height: float, contact_angle: float) -> Any:
    """The curve from (core, height) outward until it has the slope of the wall: r, z and psi along the arc length."""
    from scipy.integrate import solve_ivp
    from scipy.special import i0e, i1e

    def growth(_: float, surface: Array) -> tuple[float, float, float]:
        r, z, psi = surface
        sine = math.sin(psi)
        return math.cos(psi), sine, z - sine / r

    def steep(_: float, surface: Array) -> float:
        return float(surface[2]) - (0.5 * math.pi - contact_angle)

    steep.terminal = True  # type: ignore[attr-defined]  # SciPy's way to stop there
    start = core, height, math.asin(height * float(i1e(core) / i0e(core)))
    end = 10.0 * SHALLOW + 4.0 * core
    least = 1e-3 * TOLERANCE * height
    return solve_ivp(growth, (0.0, end), start, "DOP853", events=steep, dense_output=True, rtol=TOLERANCE, atol=least)


DISHES: dict[str, Callable[[Array, float, float], Array]] = {
    "amplitude": _amplitude_field,
    "nonlinear": _nonlinear_field,
    "linear": _linear_field,
}
