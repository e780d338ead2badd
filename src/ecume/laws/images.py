"""What a floater's own meniscus does to it when a wall mirrors it: forces of images, for point charges.

A wall on which the liquid keeps its contact angle mirrors a meniscus as it is, and attracts; a wall that pins the
contact line mirrors it upside down, and repels: for either sign of the charge. Exact in linear theory.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume.errors import BadInput
from ecume.laws.arguments import SMALLEST, as_distances, as_given, chosen, require_positive
from ecume.laws.flotation.bodies import Liquid
from ecume.laws.special import bessel_k1, scaled_bessel_i0, scaled_bessel_k0, scaled_bessel_k1
from ecume.units import Array, Force, Forces, Length, Lengths, Number, Numbers

WALLS = {"fixed-angle": 1.0, "pinned": -1.0}
"""The sign of an image: of a wall that keeps the contact angle, and of one that pins the contact line."""
MOST_TERMS = 100_000
DIGITS = 20.0
"""Terms smaller than exp(-2 DIGITS) of the sum are ignored."""
CENTER = 1e-6
"""In L: nearer the middle the force is in proportion to r."""
FAR = 40.0
"""In L: images farther away are ignored."""


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
    """Force of a plane wall's image on a floater, positive to the wall: (2 pi gamma/L) A^2 K1(2 d/L), or minus that.

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

    Reflections on four walls make a lattice of images: at x + 2 k W, and at -x + (2 k + 1) W with the sign of the wall;
    each pulls as [nicolson1949]'s pair law says.

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
    """How far a coordinate's images are, and their signs, from the nearest outward in pairs, itself first."""
    images = [(0.0, 1.0)]
    for k in range(1, math.ceil(FAR / width) + 2):
        images += [(2.0 * k * width, 1.0), (-2.0 * k * width, 1.0)]
    for k in range(math.ceil(FAR / width) + 2):
        images += [((2 * k + 1) * width - 2.0 * x, sign), (-(2 * k + 1) * width - 2.0 * x, sign)]
    return images


class Sums(NamedTuple):
    """Over the orders m of a dish's images, at each r: of c_m I_m(r)^2 and of c_m I_m(r) I_m'(r)."""

    height: Array
    slope: Array


def dish_sums(r: Numbers, dish_radius: Number, sign: Number) -> Sums:
    """Both sums, for distances from the axis and a dish's radius, in L; `sign` as in `WALLS`. [nicolson1949]."""
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
    """Logarithms of the products of the ratios before each."""
    return np.concatenate([np.zeros((1, ratios.shape[1])), np.cumsum(np.log(ratios[:-1]), axis=0)])


def _i_ratios(x: Array, terms: int) -> Array:
    """I_{m+1}(x)/I_m(x), downwards from a guess that is forgotten on the way: orders and arguments never overflow."""
    ratios, ratio = np.empty((terms, len(x))), np.zeros_like(x)
    for m in range(terms + 30 + int(x.max()), 0, -1):
        ratio = 1.0 / (ratio + 2.0 * m / x)
        if m <= terms:
            ratios[m - 1] = ratio
    return ratios


def _k_ratios(x: float, terms: int) -> Array:
    """K_{m+1}(x)/K_m(x), upwards."""
    ratios = np.empty((terms, 1))
    ratios[0] = scaled_bessel_k1(x) / scaled_bessel_k0(x)
    for m in range(1, terms):
        ratios[m] = 1.0 / ratios[m - 1] + 2.0 * m / x
    return ratios
