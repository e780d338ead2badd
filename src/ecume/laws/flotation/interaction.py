"""Floating bodies on a liquid, in SI: how they pull at one another, and the surface around a sphere."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ecume.errors import BadInput
from ecume.laws.arguments import SMALLEST, as_distances, as_given
from ecume.laws.capillarity import pair_strength
from ecume.laws.flotation.balance import nonlinear_balance
from ecume.laws.flotation.bodies import Liquid, Sphere
from ecume.laws.flotation.equilibria import Upright, capillary_charge, sphere_numbers
from ecume.laws.flotation.shapes import HorizontalCylinder
from ecume.laws.flotation.young_laplace import outer_meniscus, refined
from ecume.units import Array, Energies, Forces, Lengths

POINT = 0.01
"""Share of the radius that a contact line has at least in the linear theories, where K0 would have no bound."""


def pair_energy(a: Upright, b: Upright, distance: Lengths, liquid: Liquid, theory: str = "nonlinear") -> Energies:
    """Energy of two floating bodies whose centers are `distance` apart, zero when far; negative for like charges.

    E = -2 pi gamma A_a A_b K0(l/L); the law that runs compile is `capillarity.pair_energy`, where its validity
    stands. [nicolson1949].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> ball = Sphere(1e-3, 1300.0, 1.5708)
    >>> pair_energy(ball, ball, distance=4e-3, liquid=water) < 0
    True
    """
    from scipy.special import k0

    return as_given(
        -_strength(a, b, liquid, theory) * k0(as_distances("distance", distance, SMALLEST) / liquid.capillary_length)
    )


def pair_force(a: Upright, b: Upright, distance: Lengths, liquid: Liquid, theory: str = "nonlinear") -> Forces:
    """Force between two floating bodies; positive repels, so that like charges give a negative one.

    F = -(2 pi gamma/L) A_a A_b K1(l/L); the law that runs compile is `capillarity.pair_force`. [nicolson1949].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> heavy, light = Sphere(1e-3, 1300.0, 1.5708), Sphere(1e-3, 100.0, 1.5708)
    >>> pair_force(heavy, heavy, 4e-3, water) < 0 < pair_force(heavy, light, 4e-3, water)
    True
    """
    from scipy.special import k1

    length = liquid.capillary_length
    return as_given(
        -_strength(a, b, liquid, theory) / length * k1(as_distances("distance", distance, SMALLEST) / length)
    )


def surface_height(sphere: Sphere, distance: Lengths, liquid: Liquid, theory: str = "nonlinear") -> Lengths:
    """Height of the surface around one floating sphere, at a distance from its axis; negative around a heavy one.

    "closed-form" and "linear": h = -A K0(r/L), the contact line at R sin(theta) (R/100 at least). "nonlinear": the
    Young–Laplace profile, interpolated to 1e-7 of the charge (1e-2 at an upright neck). Inside the contact line
    there is no surface: the height of the contact line stands for it (where the meniscus overhangs, that of its
    neck), so that a picture has no hole. [vella2005].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> surface_height(Sphere(1e-3, 1300.0, 1.5708), 3e-3, water) < 0
    True
    """
    from scipy.special import k0

    if not isinstance(sphere, Sphere):
        raise BadInput(f"got {sphere!r}; expected a Sphere: the surface around other bodies is `multipole.height`")
    length = liquid.capillary_length
    r = as_distances("distance", distance) / length
    if theory == "nonlinear":
        return as_given(length * _profile(r, *sphere_numbers(sphere, liquid)))
    nearest = sphere.radius * max(math.sin(sphere.contact_angle), POINT) / length
    return as_given(-capillary_charge(sphere, liquid, theory) * k0(np.maximum(r, nearest)))


def _profile(r: Array, bond: float, ratio: float, angle: float) -> Array:
    """The nonlinear surface in capillary lengths, z = -b(r) K0(r), with b from the nodes and the charge beyond them."""
    from scipy.interpolate import CubicSpline
    from scipy.special import k0

    found = nonlinear_balance(bond, ratio, angle)
    if found.charge == 0.0:
        return np.zeros_like(r)
    radii, amplitudes = _outer_branch(math.sqrt(bond) * math.sin(found.filling_angle), found.slope_angle)
    inside = np.clip(r, radii[0], radii[-1])
    profile: Array = -CubicSpline(np.log(radii), amplitudes)(np.log(inside)) * k0(np.maximum(r, radii[0]))
    return profile


@lru_cache(maxsize=1024)
def _outer_branch(radius: float, slope_angle: float) -> tuple[Array, Array]:
    radii, amplitudes = refined(outer_meniscus(radius, slope_angle))
    first = int(np.argmin(radii))
    return radii[first:], amplitudes[first:]


def _strength(a: Upright, b: Upright, liquid: Liquid, theory: str) -> float:
    for body in (a, b):
        if isinstance(body, HorizontalCylinder):
            raise BadInput(
                f"{body!r} lies in the surface, where two of them attract per length; expected bodies of finite "
                "length, or lying_pair_force and lying_pair_energy"
            )
    charges = capillary_charge(a, liquid, theory) * capillary_charge(b, liquid, theory)
    return pair_strength(liquid.surface_tension, charges, 1.0)
