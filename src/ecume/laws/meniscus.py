"""The liquid's surface at walls: a plane wall, a round dish, a rectangular dish. Heights are measured from the
undisturbed surface.

The contact angle is that of the wall, through the liquid: below 90 degrees the liquid rises at the wall. A brim that
is overfull, or that pins the contact line, is just another angle. A fixed volume of liquid moves the undisturbed
surface and pulls at nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from ecume.errors import BadInput
from ecume.laws.arguments import as_distances, as_given, chosen, elementwise, require_angle, require_positive
from ecume.laws.flotation.bodies import Liquid
from ecume.laws.flotation.plane import sloping_amplitude, sloping_height
from ecume.laws.images import image_force, plane_image_force, rectangle_image_force
from ecume.units import Angle, Array, Length, Lengths, Number

__all__ = [
    "dish_height",
    "facing_amplitude",
    "image_force",
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
"""Radius, in L, from which a dish is integrated: nearer the axis its surface is the linear one to 1e-12."""
SHALLOW = 25.0
"""Farther than this from the wall (in L) slopes are below 1e-10, and the surface is the linear one."""
TOLERANCE = 1e-12
KEPT = 256
TURNS = 60


@elementwise
def wall_height(contact_angle: Angle, liquid: Liquid) -> Length:
    """Height of the liquid at a plane wall, exact: L sqrt(2 (1 - sin theta)), negative where it is pressed down.
    [landau1987, par. 61].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> round(wall_height(0.0, water) / water.capillary_length, 9)
    1.414213562
    """
    return liquid.capillary_length * plane_wall_height(contact_angle)


@elementwise
def wall_amplitude(contact_angle: Angle, liquid: Liquid) -> Length:
    """A_w: far from a plane wall the surface is A_w exp(-x/L); positive where the liquid rises, zero at 90 degrees.

    A_w = 4 L exp(-2 - u + 2 tanh u), with u = arccosh(2 L/h) at the wall's h: the exact profile, far away. The linear
    theory says L cot(theta): half as much again at 45 degrees, infinite at 0. Derived from [landau1987, par. 61].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> round(wall_amplitude(math.radians(45.0), water) / water.capillary_length, 9)
    0.683288922
    """
    return liquid.capillary_length * plane_amplitude(contact_angle)


def linear_wall_amplitude(contact_angle: Angle, liquid: Liquid) -> Length:
    """L cot(theta): what the linear theory takes for `wall_amplitude`; too large by half at 45 degrees. [landau1987].

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
    """A_w / (1 - exp(-W/L)): the amplitude of each of two plane walls that face each other, W apart.

    Each wall's meniscus is mirrored by the other; with this amplitude the sum of the two exponentials keeps the
    slope at both. Exact in linear theory. [chan1981].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> facing_amplitude(0.01, 0.8, water) > wall_amplitude(0.8, water)
    True
    """
    require_positive("width", width)
    alone = chosen(AMPLITUDES, theory, "amplitude of a wall")(contact_angle, liquid)
    return alone / -math.expm1(-width / liquid.capillary_length)


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
    for _ in range(TURNS):  # from above, where x(u) is convex: Newton's method cannot overshoot
        slope = 1.0 - 2.0 / np.cosh(np.minimum(u, 300.0)) ** 2
        excess = u - start + 2.0 * (math.tanh(start) - np.tanh(u)) - x
        u = np.where(slope > 0.0, u - excess / np.where(slope > 0.0, slope, 1.0), u)
    profile = math.copysign(1.0, highest) * 4.0 * np.exp(-u) / (1.0 + np.exp(-2.0 * u))
    return as_given(liquid.capillary_length * np.where(x == 0.0, highest, profile))


def dish_height(
    r: Lengths, dish_radius: Length, contact_angle: Angle, liquid: Liquid, theory: str = "amplitude"
) -> Lengths:
    """Height of the surface in a round dish, at a distance r from its axis.

    "amplitude": A_w I0(r/L)/I1(a/L), the linear field with the plane wall's exact far amplitude; at the middle right
    to 1 % for dishes of 2 L and more, 5 % of L; low within 2 L of the wall. "linear": cot(theta) in the place of A_w/L.
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
    """`wall_height` in capillary lengths.

    >>> round(plane_wall_height(math.radians(30.0)), 12)
    1.0
    """
    require_angle("contact_angle", contact_angle)
    # sqrt(2 (1 - sin theta)), without its cancellation at 90 degrees
    return sloping_height(contact_angle - 0.5 * math.pi)


def plane_amplitude(contact_angle: Angle) -> Number:
    """`wall_amplitude` in capillary lengths.

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
    """I0(r)/I1(a), lengths in L; without overflow."""
    from scipy.special import i0e, i1e

    shape: Array = i0e(r) / i1e(dish_radius) * np.exp(r - dish_radius)
    return shape


def _nonlinear_field(r: Array, dish_radius: float, contact_angle: float) -> Array:
    """The exact surface; rising menisci only are solved, the others are their mirror images."""
    if abs(plane_wall_height(contact_angle)) < 1e-9:
        return _amplitude_field(r, dish_radius, contact_angle)
    core, height, shot = _dish_profile(dish_radius, min(contact_angle, math.pi - contact_angle))
    inner = height * _linear_shape(np.minimum(r, core), dish_radius) / _linear_shape(np.array(core), dish_radius)
    outer = _height_at(np.maximum(r, core), shot)
    return math.copysign(1.0, plane_wall_height(contact_angle)) * np.where(r > core, outer, inner)


def _height_at(r: Array, shot: Any) -> Array:
    """z(r) along a shot: bisect for the arc length, on which r grows."""
    low, high = np.zeros(r.shape), np.full(r.shape, shot.t[-1])
    for _ in range(TURNS):
        middle = 0.5 * (low + high)
        short = shot.sol(middle.ravel())[0].reshape(r.shape) < r
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    height: Array = shot.sol(high.ravel())[1].reshape(r.shape)
    # At a wall that is wetted all over r stands still, and only the end itself is sharp.
    return np.where(r >= shot.y[0, -1] * (1.0 - TOLERANCE), shot.y[1, -1], height)


@lru_cache(maxsize=KEPT)
def _dish_profile(dish_radius: float, contact_angle: float) -> tuple[float, float, Any]:
    """Where the integration starts, the height there, and the shot that meets the wall at the contact angle."""
    from scipy.optimize import brentq

    core = max(CORE, dish_radius - SHALLOW) if dish_radius > 2.0 * CORE else 0.5 * dish_radius

    def miss(logarithm: float) -> float:
        return float(_shot(core, math.exp(logarithm), contact_angle).y[0, -1]) - dish_radius

    # The higher the middle, the sooner the surface has the slope at the wall.
    guess = math.log(float(_amplitude_field(np.array(core), dish_radius, contact_angle)))
    low, high = guess - 0.5, guess + 0.5
    while miss(low) < 0.0:
        low -= 1.0
    while miss(high) > 0.0:
        high += 1.0
    height = math.exp(float(brentq(miss, low, high, xtol=1e-13)))
    return core, height, _shot(core, height, contact_angle)


def _shot(core: float, height: float, contact_angle: float) -> Any:
    """The surface from (core, height) outward until it has the slope of the wall: r, z and psi along the arc
    length.
    """
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
