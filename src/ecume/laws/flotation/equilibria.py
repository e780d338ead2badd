"""Floating bodies in SI units: their equilibrium, their mutual forces, and the surface around them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ecume.errors import BadInput, FloaterSinks
from ecume.laws.arguments import SMALLEST, as_distances, as_given, chosen, elementwise, require_numbers
from ecume.laws.capillarity import pair_strength
from ecume.laws.flotation.balance import BALANCES, CHARGES, Floating, nonlinear_balance
from ecume.laws.flotation.bodies import (
    Bubble,
    Disc,
    Ellipsoid,
    HorizontalCylinder,
    Liquid,
    Sphere,
    VerticalCylinder,
    bond_number,
    density_ratio,
)
from ecume.laws.flotation.nonspherical import (
    bubble_floating,
    cylinder_floating,
    disc_floating,
    ellipsoid_floating,
    lying_floating,
)
from ecume.laws.flotation.young_laplace import outer_meniscus, refined
from ecume.units import Angle, Array, Energies, Forces, Length, Lengths, Number

Upright = Sphere | Disc | Bubble | VerticalCylinder | Ellipsoid
"""Bodies whose far field is K0, which attract or repel each other."""
Body = Upright | HorizontalCylinder
KEPT = 4096
LEAVES = ("bottom", "leaves the liquid", "denser")


@dataclass(frozen=True)
class Equilibrium:
    """The equilibrium of a floating body. Heights are measured upwards from the undisturbed
    surface.

    slope_angle: of the surface at the contact line, positive where it rises outward (a heavy body).
    filling_angle: inclination of the body's own surface there, from the bottom; a sphere's polar angle, 90 degrees at
    rims and upright sides. contact_radius: of the contact line (a lying cylinder: half the distance of the two).
    center_height: of a disc's rim, of a bubble's centroid, of any other body's middle. charge: amplitude A of the far
    field -A K0(r/L), from a lying cylinder -A exp(-|x|/L), with x from its axis.
    floats: always True; a theory that finds no equilibrium raises FloaterSinks.
    """

    slope_angle: Angle
    filling_angle: Angle
    contact_radius: Length
    contact_height: Length
    center_height: Length
    charge: Length
    floats: bool = True


@lru_cache(maxsize=KEPT)
def equilibrium(body: Body, liquid: Liquid, theory: str = "nonlinear") -> Equilibrium:
    """The equilibrium of a body by the theory "nonlinear", "closed-form" or "linear". Raises
    FloaterSinks without one.

    The formulas are in `nonlinear_balance` and other balances for spheres, `disc_floating`,
    `cylinder_floating`, `lying_floating`, `ellipsoid_floating`, `bubble_floating`. [vella2005, keller1998].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> heavy = equilibrium(Sphere(1e-3, 1300.0, 1.57), water)
    >>> heavy.slope_angle > 0 and heavy.contact_height < 0
    True
    >>> equilibrium(Bubble(5e-4), water).charge < 0
    True
    """
    chosen(BALANCES, theory, "theory of flotation")
    if type(body) not in FLOATING:
        raise BadInput(f"got {body!r}; expected a floating body: {', '.join(kind.__name__ for kind in FLOATING)}")
    found, length = FLOATING[type(body)](body, liquid, theory), liquid.capillary_length
    if not 0.0 <= found.filling_angle <= math.pi:
        # The linear theories do not limit slopes, so that the contact line may be beyond the end of the body.
        beyond, outcome, cure = ("top", "sinks", "lighter") if found.slope_angle > 0.0 else LEAVES
        raise FloaterSinks(
            f"by the {theory} theory the contact line would lie beyond the {beyond} of this {type(body).__name__}: it "
            f"{outcome}; take a {cure} one, or theory = 'nonlinear', which limits the load of the surface"
        )
    return Equilibrium(
        slope_angle=found.slope_angle,
        filling_angle=found.filling_angle,
        contact_radius=found.contact_radius * length,
        contact_height=found.contact_height * length,
        center_height=found.center_height * length,
        charge=found.charge * length,
    )


def capillary_charge(body: Body, liquid: Liquid, theory: str = "nonlinear") -> Length:
    """Capillary charge A: the surface far from the body is -A K0(r/L); positive for a heavy one, negative for a light
    one.

    Like charges attract, unlike repel. Theories: "nonlinear", "closed-form" (spheres: within 0.1 % at B = 0.1),
    "linear" (R B Sigma). Raises FloaterSinks. [vella2005].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> capillary_charge(Sphere(1e-3, 100.0, 1.57), water) < 0
    True
    """
    if isinstance(body, Sphere):
        charge = chosen(CHARGES, theory, "theory of flotation")
        equilibrium(body, liquid)  # raises FloaterSinks, which linear theories never do
        return body.radius * charge(*sphere_numbers(body, liquid))
    return equilibrium(body, liquid, theory).charge


def sphere_numbers(sphere: Sphere, liquid: Liquid) -> tuple[float, float, float]:
    """Bond number, density ratio and contact angle. Raises BadInput for bodies that cannot float."""
    numbers = bond_number(sphere, liquid), density_ratio(sphere, liquid), sphere.contact_angle
    require_numbers(*numbers)
    return numbers


def _sphere_floating(sphere: Sphere, liquid: Liquid, theory: str) -> Floating:
    found, radius = BALANCES[theory](*sphere_numbers(sphere, liquid)), sphere.radius / liquid.capillary_length
    return Floating(
        slope_angle=found.slope_angle,
        filling_angle=found.filling_angle,
        contact_radius=radius * math.sin(found.filling_angle),
        contact_height=found.contact_height,
        center_height=found.contact_height + radius * math.cos(found.filling_angle),
        charge=found.charge,
    )


FLOATING: dict[type, Callable[[Any, Liquid, str], Floating]] = {
    Sphere: _sphere_floating,
    Disc: disc_floating,
    Bubble: bubble_floating,
    VerticalCylinder: cylinder_floating,
    HorizontalCylinder: lying_floating,
    Ellipsoid: ellipsoid_floating,
}


POINT = 0.01
"""The least radius of a contact line in the linear theories, over the body's radius: K0 diverges at zero."""


def pair_energy(a: Upright, b: Upright, distance: Lengths, liquid: Liquid, theory: str = "nonlinear") -> Energies:
    """Energy of two floating bodies whose centers are `distance` apart, zero when far; negative for like charges.

    E = -2 pi gamma A_a A_b K0(l/L); the compiled law is `capillarity.pair_energy`, which states the validity.
    [nicolson1949].

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

    F = -(2 pi gamma/L) A_a A_b K1(l/L); the compiled law is `capillarity.pair_force`. [nicolson1949].

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
    """Height of the surface around a single floating sphere, at a distance from its axis; negative
    around a heavy one.

    "closed-form" and "linear": h = -A K0(r/L), the contact line at R sin(theta) (R/100 at least). "nonlinear": the
    Young–Laplace profile, interpolated to 1e-7 of the charge (1e-2 at an upright neck). Inside the contact line, where
    there is no surface, it is the height of the contact line (for an overhanging meniscus, that of its neck), so that
    pictures have no holes. [vella2005].

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
    """The nonlinear surface in capillary lengths, z = -b(r) K0(r), with b interpolated from nodes; b is the charge
    beyond them.
    """
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


MODES = 80
"""The number of modes: accurate to 3e-3 for touching spheres of 90 degrees, whose contact lines touch, and much better
otherwise.
"""
WIDEST = 100.0


@elementwise
@lru_cache(maxsize=1024)
def superposition_excess(contact_angle: Angle, gap: Number) -> Number:
    """Relative excess of the force over `capillarity.pair_force` for two equal spheres much smaller than L; `gap` over
    a diameter.

    Each contact line slides in the other's curved meniscus and responds to its n-th mode with (n-1)/(n+1) of it. Both
    responses are solved together, with h = Re(A ln z + sum_n a_n z^-n) about each; the force is the residue of
    Blasius's integral, A c_1 - sum_n n (n+1) a_n c_(n+1), with c_n the regular coefficients there. At B = 0.1 the
    excess is a third larger, at B = 1 about three times as large. Derived; the limit of small bodies of
    [vassileva2005].

    >>> [round(superposition_excess(math.radians(degrees), 0.0), 3) for degrees in (30.0, 60.0)]
    [0.003, 0.038]
    """
    rim = 0.5 * math.sin(contact_angle) / (1.0 + gap)  # contact radius over the distance of the centers
    n = np.arange(1, MODES + 2)
    # Lengths over that distance; a_n in units of rim^n, c_n of rim^-n.
    source = -(rim**n) / n
    mutual = np.array([[math.comb(m + k - 1, k) * rim ** (m + k) for m in n[:-1]] for k in n])
    answer = ((n - 1.0) / (n + 1.0))[:-1]
    own = np.linalg.solve(np.eye(MODES) - answer[:, None] * mutual[:-1], answer * source[:-1])
    regular = source + mutual @ own
    if rim == 0.0:
        return 0.0
    force = -regular[0] / rim + float(np.sum(n[:-1] * n[1:] * own * regular[1:])) / rim
    return float(force) - 1.0


@elementwise
def superposition_reach(contact_angle: Angle, excess: Number) -> Number:
    """Gap, over a diameter, beyond which `superposition_excess` is below `excess`; zero if it
    always is.

    [vassileva2005].

    >>> superposition_reach(math.radians(60.0), 0.05)
    0.0
    """
    from scipy.optimize import brentq

    if superposition_excess(contact_angle, 0.0) <= excess:
        return 0.0
    least = superposition_excess(contact_angle, WIDEST)
    if excess <= least:
        raise BadInput(
            f"the excess is {excess!r}; expected more than {least:.2g}, that of a gap of {WIDEST:g} diameters"
        )
    return float(brentq(lambda gap: superposition_excess(contact_angle, gap) - excess, 0.0, WIDEST, xtol=1e-9))
