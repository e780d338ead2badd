"""A gas bubble that floats under the surface, with its own shape: a film on top, a drop of gas below. Lengths in L.

The film, thin and with two surfaces, is a spherical cap of radius 4/P under the bubble's pressure P. Below its rim the
gas meets the liquid: d(phi)/ds = P + z - sin(phi)/r from the lowest point up. Outside the surface leaves the rim. All
three meet in one direction, since the film pulls with twice the tension of each of the others [princen1963].
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ecume.errors import BadInput
from ecume.laws.flotation.bodies import Liquid
from ecume.laws.flotation.carrying import Floating
from ecume.laws.flotation.shapes import Bubble
from ecume.laws.flotation.young_laplace import outer_meniscus
from ecume.laws.special import bessel_k0
from ecume.units import Array, Number

LARGEST = 2.0
"""In L: beyond, a bubble is a dome whose film would not last, and the shooting below is not tried."""
SMALLEST_SHOT = 0.01
"""In L: below, a bubble is a small one to 1e-8, which shooting is not."""
CORE = 1e-4
"""The lowest part of the bubble, over its radius, that is a sphere's."""
TOLERANCE = 1e-12
GROWTH = 1.5


class Shape(NamedTuple):
    """A bubble's shape: the rim of its film, and what is below and above it."""

    rim_angle: float
    rim_radius: float
    rim_height: float
    volume: float
    """all of it"""
    moment: float
    """volume times the height of its centroid"""
    lifted: float
    """the volume below the level of the rim"""


def bubble_floating(bubble: Bubble, liquid: Liquid, theory: str) -> Floating:
    """A bubble. "linear" and "closed-form": a small one, A = -(2/3) R B, whose film has the radius (2/sqrt 3) R^2/L.

    "nonlinear": its own shape and the full meniscus. [nicolson1949, princen1963].
    """
    radius = bubble.radius / liquid.capillary_length
    return nonlinear_bubble(radius) if theory == "nonlinear" else linear_bubble(radius)


def linear_bubble(radius: Number) -> Floating:
    """A small sphere of gas: lift (4/3) pi R^3 = 2 pi r_f sin(beta), sin(beta) = r_f/2R; radius in L. [nicolson1949].

    >>> round(linear_bubble(0.1).charge, 9)
    -0.000666667
    """
    charge, rim = -2.0 / 3.0 * radius**3, 2.0 / math.sqrt(3.0) * radius**2
    slope = -math.asin(min(1.0, 0.5 * rim / radius))
    height = -charge * bessel_k0(rim)
    return Floating(slope, math.pi + slope, rim, height, height - radius, charge)


@lru_cache(maxsize=256)
def nonlinear_bubble(radius: Number) -> Floating:
    """The bubble of a given volume, (4/3) pi R^3, R in L: shot from its lowest point. [princen1963].

    >>> round(nonlinear_bubble(1.0).charge / linear_bubble(1.0).charge, 3)
    1.067
    """
    if radius < SMALLEST_SHOT:
        return linear_bubble(radius)
    if radius > LARGEST:
        raise BadInput(f"the bubble's radius is {radius:.3g} capillary lengths; these laws are for {LARGEST:g} at most")
    pressure, depth = _found(radius)
    shape = _shape(pressure, depth)
    surface = outer_meniscus(shape.rim_radius, -shape.rim_angle)
    center = shape.moment / shape.volume
    filling = math.pi - shape.rim_angle
    return Floating(-shape.rim_angle, filling, shape.rim_radius, surface.height, center, surface.amplitude)


@lru_cache(maxsize=256)
def _found(radius: float) -> tuple[float, float]:
    """Pressure and depth of the lowest point; larger bubbles from smaller ones."""
    from scipy.optimize import root

    guess = (2.0 / radius + radius, 2.0 * radius) if radius < 0.15 else _carried_on(radius)
    volume = 4.0 / 3.0 * math.pi * radius**3

    def miss(logarithms: Array) -> Array:
        shape = _shape(*(math.exp(each) for each in logarithms))
        outside = outer_meniscus(shape.rim_radius, -shape.rim_angle).height
        return np.array([(shape.rim_height - outside) / radius, shape.volume / volume - 1.0])

    solution = root(miss, np.log(guess), method="hybr", options={"xtol": 1e-13})
    if not float(np.max(np.abs(solution.fun))) < 1e-8:
        raise ArithmeticError(f"the shape of a bubble of radius {radius:g} capillary lengths was not found")
    pressure, depth = np.exp(solution.x)
    return float(pressure), float(depth)


def _carried_on(radius: float) -> tuple[float, float]:
    """A guess from a smaller bubble: depth over radius, and the lowest point's curvature times radius, stay."""
    smaller = radius / GROWTH
    pressure, depth = _found(smaller)
    deeper = depth * GROWTH
    return (pressure - depth) / GROWTH + deeper, deeper


def _shape(pressure: float, depth: float) -> Shape:
    """From the lowest point up to where the film begins, r = (4/P) sin(phi)."""
    shot = _shot(pressure, depth)
    r, z, phi, volume, moment = (float(last) for last in shot.y[:, -1])
    film, beta = 4.0 / pressure, math.pi - phi
    rise = film * (1.0 - math.cos(beta))
    cap = math.pi * rise**2 * (film - rise / 3.0)
    over = math.pi * rise**3 * (film / 3.0 - rise / 12.0)  # the cap's moment, from its base
    return Shape(beta, r, z, volume + cap, moment + cap * z + over, volume)


def _shot(pressure: float, depth: float) -> Any:
    """r, z, phi, volume and its moment along the arc."""
    from scipy.integrate import solve_ivp

    curvature = 0.5 * (pressure - depth)
    step = CORE / curvature

    def growth(_: float, at: Array) -> tuple[float, float, float, float, float]:
        r, z, phi = at[0], at[1], at[2]
        sine = math.sin(phi)
        slab = math.pi * r * r * sine
        return math.cos(phi), sine, pressure + z - sine / r, slab, slab * z

    def film_begins(_: float, at: Array) -> float:
        return float(4.0 / pressure * math.sin(at[2]) - at[0]) if at[2] > 0.5 * math.pi else 1.0

    film_begins.terminal = True  # type: ignore[attr-defined]  # SciPy's way to stop there
    start = step, -depth + 0.5 * curvature * step**2, curvature * step, 0.0, 0.0
    return solve_ivp(growth, (0.0, 8.0 / curvature), start, "DOP853", events=film_begins, rtol=TOLERANCE, atol=1e-16)
