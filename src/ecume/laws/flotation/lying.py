"""Long cylinders that lie in the surface: two dimensions, where everything is exact. Lengths in L, weights in gamma."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated

import numpy as np

from ecume.errors import FloaterSinks
from ecume.laws.arguments import as_distances, as_given
from ecume.laws.flotation.bodies import Liquid
from ecume.laws.flotation.carrying import Floating, Load, greatest_load, stable_load
from ecume.laws.flotation.plane import sloping_amplitude, sloping_height
from ecume.laws.flotation.shapes import HorizontalCylinder
from ecume.laws.flotation.young_laplace import OuterMeniscus
from ecume.units import Angle, Length, Lengths, Number, Real, Unit

LineEnergies = Annotated[Real, Unit("J/m")]
LineForces = Annotated[Real, Unit("N/m")]


def lying_load(radius: Number, contact_angle: Angle, slope_angle: Angle) -> Load:
    """The density ratio that floats with this slope angle, for a cylinder of radius R in L.

    pi B D = 2 sin(psi) + B [phi - sin(phi) cos(phi) - 2 (z_c/R) sin(phi)], phi = pi - theta + psi, z_c = -2 sin(psi/2).
    [keller1998, vella2005].
    """
    sine, cosine = math.sin(contact_angle - slope_angle), -math.cos(contact_angle - slope_angle)
    filling = math.pi - contact_angle + slope_angle
    height, deepening = sloping_height(slope_angle), math.cos(0.5 * slope_angle)
    carried = 2.0 * math.sin(slope_angle) + radius**2 * (filling - sine * cosine) - 2.0 * radius * sine * height
    change = 2.0 * math.cos(slope_angle) + 2.0 * (radius * sine) ** 2
    change += 2.0 * radius * (sine * deepening - cosine * height)
    unit = math.pi * radius**2
    # From the axis: what a neighbor far away sees.
    amplitude = -sloping_amplitude(slope_angle) * math.exp(radius * sine)
    surface = OuterMeniscus(height, amplitude, -deepening, np.empty(0), np.empty(0))
    return Load(slope_angle, carried / unit, change / unit, surface)


def lying_floating(lying: HorizontalCylinder, liquid: Liquid, theory: str) -> Floating:
    """How a lying cylinder floats.

    "linear": psi = (B/2) (pi D - pi + theta - sin(2 theta)/2); "closed-form" keeps its heave and filling, which count
    as sqrt(B). [vella2005].
    """
    radius = lying.radius / liquid.capillary_length
    ratio = (lying.density - liquid.gas_density) / liquid.density_difference
    found = LYING[theory](radius, ratio, lying.contact_angle)
    slope, surface = found.slope_angle, found.meniscus
    filling = math.pi - lying.contact_angle + slope
    center = surface.height + radius * math.cos(filling)
    return Floating(slope, filling, radius * math.sin(filling), surface.height, center, surface.amplitude)


def linear_lying(radius: Number, density_ratio: Number, contact_angle: Angle) -> Load:
    """Small slopes, a thin cylinder: psi = (B/2) (pi D - pi + theta - sin(2 theta)/2), A = psi. [vella2005]."""
    psi = _free_slope(radius, density_ratio, contact_angle)
    return Load(psi, density_ratio, 1.0, OuterMeniscus(-psi, psi, -1.0, np.empty(0), np.empty(0)))


def closed_form_lying(radius: Number, density_ratio: Number, contact_angle: Angle) -> Load:
    """`linear_lying` over 1 + sqrt(B) sin(theta) + B sin(theta)^2: heave and filling kept. [vella2005]."""
    a = radius * math.sin(contact_angle)
    psi = _free_slope(radius, density_ratio, contact_angle) / (1.0 + a + a * a)
    amplitude = psi * math.exp(a)
    return Load(psi, density_ratio, 1.0, OuterMeniscus(-psi, amplitude, -1.0, np.empty(0), np.empty(0)))


def nonlinear_lying(radius: Number, density_ratio: Number, contact_angle: Angle) -> Load:
    """The exact plane surface and the full balance; raises FloaterSinks. [keller1998]."""
    neutral = 1.0 - (contact_angle - 0.5 * math.sin(2.0 * contact_angle)) / math.pi
    heavy = density_ratio > neutral
    limit = contact_angle if heavy else contact_angle - math.pi
    guess = _free_slope(radius, density_ratio, contact_angle) / (1.0 + radius * math.sin(contact_angle))
    guess = math.copysign(min(abs(guess), 0.5 * abs(limit)), limit)
    found = stable_load(lambda psi: lying_load(radius, contact_angle, psi), density_ratio, neutral, limit, guess)
    if found is not None:
        return found
    if not heavy:
        raise FloaterSinks("this cylinder is so light that it leaves the liquid; take a denser one")
    most = greatest_load(lambda psi: lying_load(radius, contact_angle, psi), contact_angle).carried
    raise FloaterSinks(
        f"a lying cylinder of density ratio D = {density_ratio:.5g} sinks: at a Bond number of {radius**2:.4g} and a "
        f"contact angle of {math.degrees(contact_angle):.4g} degrees the surface carries D_max = {most:.5g} at most; "
        "take a thinner or lighter one, or a larger contact angle"
    )


def lying_pair_energy(distance: Lengths, charge_i: Length, charge_j: Length, liquid: Liquid) -> LineEnergies:
    """Energy per length of two parallel lying cylinders: E = -(2 gamma/L) A_i A_j exp(-l/L), l between their axes.

    The charges are the far amplitudes, so that it is exact far away; negative for like charges. [nicolson1949].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> lying_pair_energy(5e-3, 1e-5, 1e-5, water) < 0 < lying_pair_energy(5e-3, 1e-5, -1e-5, water)
    True
    """
    length = liquid.capillary_length
    strength = 2.0 * liquid.surface_tension * charge_i * charge_j / length
    return as_given(-strength * np.exp(-as_distances("distance", distance) / length))


def lying_pair_force(distance: Lengths, charge_i: Length, charge_j: Length, liquid: Liquid) -> LineForces:
    """Force per length of two parallel lying cylinders, F = E/L; positive repels. See `lying_pair_energy`.

    For two equal ones it is rho g h_m^2/2, h_m the height midway, where the surface is level. [nicolson1949].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> lying_pair_force(5e-3, 1e-5, 1e-5, water) < 0
    True
    """
    return as_given(np.asarray(lying_pair_energy(distance, charge_i, charge_j, liquid)) / liquid.capillary_length)


def _free_slope(radius: float, density_ratio: float, contact_angle: float) -> float:
    wetted = math.pi - contact_angle + 0.5 * math.sin(2.0 * contact_angle)
    return 0.5 * radius**2 * (math.pi * density_ratio - wetted)


LYING: dict[str, Callable[[float, float, float], Load]] = {
    "nonlinear": nonlinear_lying,
    "closed-form": closed_form_lying,
    "linear": linear_lying,
}
