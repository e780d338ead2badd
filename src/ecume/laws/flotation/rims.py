"""Bodies with upright sides and sharp rims: pinned discs and standing cylinders. Lengths in L, loads in gamma L."""

from __future__ import annotations

import math

from ecume.errors import BadInput, FloaterSinks
from ecume.laws.flotation.bodies import Disc, Liquid
from ecume.laws.flotation.carrying import Contact, Floating, Load, greatest_load, round_load, stable_load
from ecume.laws.flotation.shapes import VerticalCylinder
from ecume.laws.flotation.young_laplace import STEEPEST, outer_meniscus
from ecume.laws.special import bessel_k0, bessel_k1
from ecume.units import Angle, Force, Length, Number
from ecume.value_texts import with_prefix

WIDEST = 600.0
"""In capillary lengths: the menisci of wider rims are no numbers any more, since K0 and K1 fall as exp(-r)."""
UPRIGHT = 0.5 * math.pi
"""The filling angle of a line at a rim or on an upright side."""


def disc_charge(radius: Number, load: Number) -> Number:
    """A = W/(2 pi a K1(a) + pi a^2 K0(a)): the charge of a pinned disc, small slopes; lengths in L, loads in gamma L.

    Derived: the balance of [keller1998] on the linear meniscus -A K0(r).

    >>> round(disc_charge(0.5, 0.1), 6)
    0.016864
    """
    return load / (2.0 * math.pi * radius * bessel_k1(radius) + math.pi * radius**2 * bessel_k0(radius))


def disc_floating(disc: Disc, liquid: Liquid, theory: str) -> Floating:
    """A pinned disc: W = 2 pi gamma r sin(psi) + rho g pi r^2 |z_c|. Its linear theory is closed, with its heave.

    [keller1998].
    """
    length = liquid.capillary_length
    radius, load = disc.radius / length, disc.load / (liquid.surface_tension * length)
    found = _at_rim(radius, load, (-STEEPEST, STEEPEST), theory)
    if found is None:
        raise _disc_sinks(disc, liquid)
    return found


def cylinder_floating(cylinder: VerticalCylinder, liquid: Liquid, theory: str) -> Floating:
    """A standing cylinder: psi = theta - 90 degrees on its side; pinned at the upper rim up to psi = theta, at the
    lower one down to psi = theta - 180 degrees, as Gibbs says of edges. [keller1998].
    """
    length, angle = liquid.capillary_length, cylinder.contact_angle
    radius, height = cylinder.radius / length, cylinder.height / length
    base, side = math.pi * radius**2, angle - UPRIGHT
    weight = base * height * (cylinder.density - liquid.gas_density) / liquid.density_difference
    line, charge = _side_surface(radius, side, theory)
    sine = math.sin(side) if theory == "nonlinear" else side
    # Where the bottom lies when the line is on the side: what tension does not carry is buoyancy.
    bottom = (2.0 * math.pi * radius * sine - weight) / base
    if line - height <= bottom <= line:
        return Floating(side, UPRIGHT, radius, line, bottom + 0.5 * height, charge)
    if bottom < line - height:
        found, center = _at_rim(radius, weight - base * height, (side, angle), theory), -0.5 * height
    else:
        found, center = _at_rim(radius, weight, (angle - math.pi, side), theory), 0.5 * height
    if found is None:
        raise _cylinder_sinks(cylinder, liquid)
    return found._replace(center_height=found.contact_height + center)


def _at_rim(radius: float, load: float, between: tuple[float, float], theory: str) -> Floating | None:
    """A line pinned at a rim, the slope between two bounds; None where nothing carries the load."""
    if radius > WIDEST:
        raise BadInput(
            f"the radius is {radius:.3g} capillary lengths; expected at most {WIDEST:g}; "
            "plain numbers are SI: is the radius one in meters?"
        )
    charge = disc_charge(radius, load)
    slope, height = math.atan(charge * bessel_k1(radius)), -charge * bessel_k0(radius)
    if theory == "nonlinear" and load != 0.0:
        limit = between[1] if load > 0.0 else between[0]
        unit, guess = 2.0 * math.pi * radius, math.copysign(min(abs(slope), 0.5 * abs(limit)), load)
        found = stable_load(lambda psi: _rim_load(radius, unit, psi), load / unit, 0.0, limit, guess)
        if found is None:
            return None
        slope, charge, height = found.slope_angle, found.meniscus.amplitude, found.meniscus.height
    if not between[0] <= slope <= between[1]:
        return None
    return Floating(slope, UPRIGHT, radius, height, height, charge)


def _rim_load(radius: float, unit: float, slope_angle: float) -> Load:
    return round_load(Contact(radius, 0.0, 0.0, 0.0, 0.0), slope_angle, unit)


def _side_surface(radius: float, slope: float, theory: str) -> tuple[float, float]:
    """Height and amplitude of the surface that leaves an upright side with a slope angle; A = psi/K1(a) if linear."""
    if abs(slope) < 1e-12:
        return 0.0, 0.0
    if theory != "nonlinear":
        charge = slope / bessel_k1(radius)
        return -charge * bessel_k0(radius), charge
    surface = outer_meniscus(radius, slope)
    return surface.height, surface.amplitude


def greatest_rim_load(radius: Length, liquid: Liquid, steepest: Angle = STEEPEST) -> Force:
    """The greatest load that a pinned round rim carries with slopes up to `steepest`. [keller1998].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> 2.0 * math.pi * 0.072 * 1e-3 < greatest_rim_load(1e-3, water) < 8e-4
    True
    """
    within = radius / liquid.capillary_length
    most = greatest_load(lambda psi: _rim_load(within, 1.0, psi), steepest).carried if steepest > 0.0 else 0.0
    return most * liquid.surface_tension * liquid.capillary_length


def _disc_sinks(disc: Disc, liquid: Liquid) -> FloaterSinks:
    most = with_prefix(greatest_rim_load(disc.radius, liquid), "N", 5)
    radius, load = with_prefix(disc.radius, "m"), with_prefix(disc.load, "N")
    verb, way = ("sinks", "lighter") if disc.load > 0.0 else ("leaves the liquid", "heavier")
    return FloaterSinks(
        f"a disc of radius {radius} with a load of {load} {verb}: its rim carries {most} at most, up or down; "
        f"take a {way} or a wider one"
    )


def _cylinder_sinks(cylinder: VerticalCylinder, liquid: Liquid) -> FloaterSinks:
    volume = math.pi * cylinder.radius**2 * cylinder.height
    excess = (cylinder.density - liquid.density) * liquid.gravity * volume
    if excess < 0.0:
        return FloaterSinks("this cylinder is so light that the surface lets go of its lower rim; take a denser one")
    most = with_prefix(greatest_rim_load(cylinder.radius, liquid, cylinder.contact_angle), "N", 5)
    return FloaterSinks(
        f"a cylinder of density {cylinder.density:.5g} kg/m^3 sinks: weight less buoyancy: {with_prefix(excess, 'N')}; "
        f"the upper rim carries {most} at most; take a flatter or lighter one, or a larger contact angle"
    )
