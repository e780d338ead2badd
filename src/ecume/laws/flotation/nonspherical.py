"""Equilibria of floating bodies other than spheres: discs, cylinders, ellipsoids and bubbles.

Lengths are in L, and weights in gamma L. Discs are pinned and standing cylinders have upright sides and sharp rims;
ellipsoids have one axis upright and a mean contact line. Long cylinders that lie in the surface are two-dimensional
problems with exact solutions; their weights are in gamma.

A gas bubble below the surface is covered by a thin film with two surfaces: a spherical cap of radius 4/P at the
bubble's pressure P. Below the rim of the film the surface of the bubble obeys d(phi)/ds = P + z - sin(phi)/r, from its
lowest point upwards. The outer surface of the liquid starts at the rim. All three surfaces have the same direction at
the rim, since the tension of the film is twice that of each of the others [princen1963].
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Annotated, Any, NamedTuple

import numpy as np

from ecume.errors import BadInput, FloaterSinks
from ecume.laws.arguments import as_distances, as_given
from ecume.laws.flotation.balance import Contact, Floating, Load, greatest_load, round_load, stable_load
from ecume.laws.flotation.bodies import Bubble, Disc, Ellipsoid, HorizontalCylinder, Liquid, VerticalCylinder
from ecume.laws.flotation.young_laplace import (
    STEEPEST,
    OuterMeniscus,
    outer_meniscus,
    sloping_amplitude,
    sloping_height,
)
from ecume.laws.special import bessel_k0, bessel_k1
from ecume.units import Angle, Array, Force, Length, Lengths, Number, Real, Unit, with_prefix

WIDEST = 600.0
"""The largest radius of a rim in capillary lengths; K0 and K1, which fall as exp(-r), underflow beyond."""
UPRIGHT = 0.5 * math.pi
"""The filling angle of a contact line at a rim or on an upright side."""


def disc_charge(radius: Number, load: Number) -> Number:
    """Charge of a pinned disc for small slopes, A = W/(2 pi a K1(a) + pi a^2 K0(a)); lengths in L,
    loads in gamma L.

    Derived: the balance of [keller1998] on the linear meniscus -A K0(r).

    >>> round(disc_charge(0.5, 0.1), 6)
    0.016864
    """
    return load / (2.0 * math.pi * radius * bessel_k1(radius) + math.pi * radius**2 * bessel_k0(radius))


def disc_floating(disc: Disc, liquid: Liquid, theory: str) -> Floating:
    """Equilibrium of a pinned disc: W = 2 pi gamma r sin(psi) + rho g pi r^2 |z_c|. The linear theory includes the
    heave and has a closed form.

    [keller1998].
    """
    length = liquid.capillary_length
    radius, load = disc.radius / length, disc.load / (liquid.surface_tension * length)
    found = _at_rim(radius, load, (-STEEPEST, STEEPEST), theory)
    if found is None:
        raise _disc_sinks(disc, liquid)
    return found


def cylinder_floating(cylinder: VerticalCylinder, liquid: Liquid, theory: str) -> Floating:
    """Equilibrium of a standing cylinder: psi = theta - 90 degrees on its side; pinned at the upper rim up to psi =
    theta, at the lower one down to psi = theta - 180 degrees, by Gibbs's condition at edges. [keller1998].
    """
    length, angle = liquid.capillary_length, cylinder.contact_angle
    radius, height = cylinder.radius / length, cylinder.height / length
    base, side = math.pi * radius**2, angle - UPRIGHT
    weight = base * height * (cylinder.density - liquid.gas_density) / liquid.density_difference
    line, charge = _side_surface(radius, side, theory)
    sine = math.sin(side) if theory == "nonlinear" else side
    # The height of the bottom for a contact line on the side: buoyancy carries the remaining weight.
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
    """The equilibrium with a contact line pinned at a rim, for slopes between two bounds; None if the load cannot be
    carried.
    """
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
    """Height and amplitude of the surface at an upright side for a slope angle; A = psi/K1(a) in the linear theory."""
    if abs(slope) < 1e-12:
        return 0.0, 0.0
    if theory != "nonlinear":
        charge = slope / bessel_k1(radius)
        return -charge * bessel_k0(radius), charge
    surface = outer_meniscus(radius, slope)
    return surface.height, surface.amplitude


def greatest_rim_load(radius: Length, liquid: Liquid, steepest: Angle = STEEPEST) -> Force:
    """Greatest load that a pinned round rim carries at slopes up to `steepest`. [keller1998].

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


class Spheroid(NamedTuple):
    """A spheroid on a liquid: its semi-axes in L, and pure numbers."""

    radius: float
    height: float
    contact_angle: float
    density_ratio: float

    @property
    def volume(self) -> float:
        """The volume in L^3."""
        return 4.0 / 3.0 * math.pi * self.radius**2 * self.height


def spheroid_contact(radius: Number, height: Number, contact_angle: Angle, slope_angle: Angle) -> Contact:
    """Contact line of a spheroid with semi-axes a (horizontal) and c (upright), where its slope is alpha = pi - theta +
    psi.

    r = a sin(t), z = -c cos(t), tan(alpha) = (c/a) tan(t). Lengths in L.
    """
    sine, cosine = math.sin(contact_angle - slope_angle), -math.cos(contact_angle - slope_angle)
    norm = math.hypot(radius * sine, height * cosine)
    sin_t, cos_t = radius * sine / norm, height * cosine / norm
    turning = radius * height / norm**2  # dt/dalpha
    unit = math.pi * radius**2 * height
    return Contact(
        radius=radius * sin_t,
        radius_change=radius * cos_t * turning,
        volume=unit * (2.0 / 3.0 - cos_t + cos_t**3 / 3.0),
        volume_change=unit * sin_t**3 * turning,
        height=-height * cos_t,
    )


def ellipsoid_floating(ellipsoid: Ellipsoid, liquid: Liquid, theory: str) -> Floating:
    """Equilibrium of an ellipsoid, in the three theories of spheres. [vella2005]."""
    length = liquid.capillary_length
    along, across, upright = (axis / length for axis in ellipsoid.semi_axes)
    ratio = (ellipsoid.density - liquid.gas_density) / liquid.density_difference
    spheroid = Spheroid(math.sqrt(along * across), upright, ellipsoid.contact_angle, ratio)
    return THEORIES[theory](spheroid)


def linear_spheroid(spheroid: Spheroid) -> Floating:
    """Equilibrium of a small spheroid with small slopes: A = (W - V)/2 pi, and A/r is the slope at the contact line.
    [vella2005].
    """
    contact = _at(spheroid, 0.0)
    charge = _free_charge(spheroid, contact)
    slope = charge / contact.radius
    height = -slope * bessel_k0(contact.radius) / bessel_k1(contact.radius)
    return _floating(spheroid, math.atan(slope), height, charge)


def closed_form_spheroid(spheroid: Spheroid) -> Floating:
    """Equilibrium with small slopes, but with heave and filling: r z' [1 + V'/(2 pi r) + r K0/(2 K1)] = (W - V)/2 pi.
    See `closed_form_charge`. [vella2005].
    """
    contact = _at(spheroid, 0.0)
    radius, k0, k1 = contact.radius, bessel_k0(contact.radius), bessel_k1(contact.radius)
    kept = 1.0 + contact.volume_change / (2.0 * math.pi * radius) + radius * k0 / (2.0 * k1)
    slope = _free_charge(spheroid, contact) / (radius * kept)
    return _floating(spheroid, math.atan(slope), -slope * k0 / k1, slope / k1)


def nonlinear_spheroid(spheroid: Spheroid) -> Floating:
    """Equilibrium with the full meniscus and the full balance. Raises FloaterSinks without one. [keller1998]."""
    neutral = _at(spheroid, 0.0).volume / spheroid.volume
    if spheroid.density_ratio == neutral:
        return _floating(spheroid, 0.0, 0.0, 0.0)
    heavy = spheroid.density_ratio > neutral
    limit = spheroid.contact_angle if heavy else spheroid.contact_angle - math.pi
    load = _load(spheroid)
    found = stable_load(load, spheroid.density_ratio, neutral, limit, _guess(spheroid, limit))
    if found is None:
        raise _sinks(spheroid, load, heavy=heavy)
    return _floating(spheroid, found.slope_angle, found.meniscus.height, found.meniscus.amplitude)


def _load(spheroid: Spheroid) -> Callable[[float], Load]:
    """The density ratio carried at a slope angle, as a function."""
    return lambda psi: round_load(_at(spheroid, psi), psi, spheroid.volume)


def _at(spheroid: Spheroid, slope_angle: float) -> Contact:
    return spheroid_contact(spheroid.radius, spheroid.height, spheroid.contact_angle, slope_angle)


def _guess(spheroid: Spheroid, limit: float) -> float:
    if _at(spheroid, 0.0).radius < 1e-12:
        return 0.5 * limit
    return math.copysign(min(abs(closed_form_spheroid(spheroid).slope_angle), 0.5 * abs(limit)), limit)


def _free_charge(spheroid: Spheroid, contact: Contact) -> float:
    """The load that is not balanced at a flat surface, over 2 pi."""
    if contact.radius < 1e-12:
        raise BadInput(
            "the linear theories have no slope at a contact angle of 0 or 180 degrees; use the nonlinear theory"
        )
    return (spheroid.density_ratio * spheroid.volume - contact.volume) / (2.0 * math.pi)


def _floating(spheroid: Spheroid, slope: float, height: float, charge: float) -> Floating:
    contact = _at(spheroid, slope)
    filling = math.pi - spheroid.contact_angle + slope
    return Floating(slope, filling, contact.radius, height, height - contact.height, charge)


def _sinks(spheroid: Spheroid, load: Callable[[float], Load], *, heavy: bool) -> FloaterSinks:
    if not heavy:
        return FloaterSinks("this ellipsoid is so light that it leaves the liquid; take a denser one")
    most = greatest_load(load, spheroid.contact_angle).carried if spheroid.contact_angle > 1e-9 else 1.0
    return FloaterSinks(
        f"an ellipsoid of density ratio D = {spheroid.density_ratio:.5g} sinks: at a contact angle of "
        f"{math.degrees(spheroid.contact_angle):.4g} degrees the surface carries D_max = {most:.5g} at most; "
        "take a smaller or lighter one, or a larger contact angle"
    )


THEORIES: dict[str, Callable[[Spheroid], Floating]] = {
    "nonlinear": nonlinear_spheroid,
    "closed-form": closed_form_spheroid,
    "linear": linear_spheroid,
}


LineEnergies = Annotated[Real, Unit("J/m")]
LineForces = Annotated[Real, Unit("N/m")]


def lying_load(radius: Number, contact_angle: Angle, slope_angle: Angle) -> Load:
    """Density ratio of a lying cylinder that floats with this slope angle, for a radius R in L.

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
    # The amplitude relative to the axis, which determines the force on distant neighbors.
    amplitude = -sloping_amplitude(slope_angle) * math.exp(radius * sine)
    surface = OuterMeniscus(height, amplitude, -deepening, np.empty(0), np.empty(0))
    return Load(slope_angle, carried / unit, change / unit, surface)


def lying_floating(lying: HorizontalCylinder, liquid: Liquid, theory: str) -> Floating:
    """The equilibrium of a lying cylinder.

    "linear": psi = (B/2) (pi D - pi + theta - sin(2 theta)/2); "closed-form" includes heave and filling, corrections of
    order sqrt(B). [vella2005].
    """
    radius = lying.radius / liquid.capillary_length
    ratio = (lying.density - liquid.gas_density) / liquid.density_difference
    found = LYING[theory](radius, ratio, lying.contact_angle)
    slope, surface = found.slope_angle, found.meniscus
    filling = math.pi - lying.contact_angle + slope
    center = surface.height + radius * math.cos(filling)
    return Floating(slope, filling, radius * math.sin(filling), surface.height, center, surface.amplitude)


def linear_lying(radius: Number, density_ratio: Number, contact_angle: Angle) -> Load:
    """Equilibrium of a thin lying cylinder with small slopes: psi = (B/2) (pi D - pi + theta - sin(2 theta)/2), A =
    psi. [vella2005].
    """
    psi = _free_slope(radius, density_ratio, contact_angle)
    return Load(psi, density_ratio, 1.0, OuterMeniscus(-psi, psi, -1.0, np.empty(0), np.empty(0)))


def closed_form_lying(radius: Number, density_ratio: Number, contact_angle: Angle) -> Load:
    """Equilibrium with small slopes, but with heave and filling: `linear_lying` over 1 + sqrt(B) sin(theta) + B
    sin(theta)^2. [vella2005].
    """
    a = radius * math.sin(contact_angle)
    psi = _free_slope(radius, density_ratio, contact_angle) / (1.0 + a + a * a)
    amplitude = psi * math.exp(a)
    return Load(psi, density_ratio, 1.0, OuterMeniscus(-psi, amplitude, -1.0, np.empty(0), np.empty(0)))


def nonlinear_lying(radius: Number, density_ratio: Number, contact_angle: Angle) -> Load:
    """Equilibrium with the exact plane surface and the full balance; raises FloaterSinks. [keller1998]."""
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
    """Force per length between two parallel lying cylinders, F = E/L; positive repels. See `lying_pair_energy`.

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


LARGEST = 2.0
"""The largest radius of a bubble in L for the shooting method; larger ones are domes with unstable films."""
SMALLEST_SHOT = 0.01
"""The radius of a bubble in L below which the limit of small bubbles is accurate to 1e-8, while shooting is not."""
CORE = 1e-4
"""The lowest part of the bubble, over its radius, that is approximated by a sphere."""
TOLERANCE = 1e-12
GROWTH = 1.5


class Shape(NamedTuple):
    """The shape of a bubble: the rim of its film, and the surfaces below and above it."""

    rim_angle: float
    rim_radius: float
    rim_height: float
    volume: float
    """the whole volume"""
    moment: float
    """volume times the height of its centroid"""
    lifted: float
    """volume below the level of the rim"""


def bubble_floating(bubble: Bubble, liquid: Liquid, theory: str) -> Floating:
    """Equilibrium of a bubble. "linear" and "closed-form": a small sphere, A = -(2/3) R B, whose film has the radius
    (2/sqrt 3) R^2/L.

    "nonlinear": the deformed bubble and the full meniscus. [nicolson1949, princen1963].
    """
    radius = bubble.radius / liquid.capillary_length
    return nonlinear_bubble(radius) if theory == "nonlinear" else linear_bubble(radius)


def linear_bubble(radius: Number) -> Floating:
    """Equilibrium of a small spherical bubble: lift (4/3) pi R^3 = 2 pi r_f sin(beta), sin(beta) = r_f/2R; radius in L.
    [nicolson1949].

    >>> round(linear_bubble(0.1).charge, 9)
    -0.000666667
    """
    charge, rim = -2.0 / 3.0 * radius**3, 2.0 / math.sqrt(3.0) * radius**2
    slope = -math.asin(min(1.0, 0.5 * rim / radius))
    height = -charge * bessel_k0(rim)
    return Floating(slope, math.pi + slope, rim, height, height - radius, charge)


@lru_cache(maxsize=256)
def nonlinear_bubble(radius: Number) -> Floating:
    """Equilibrium of a bubble with the volume (4/3) pi R^3, R in L, by shooting from its lowest
    point. [princen1963].

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
    """Pressure and depth of the lowest point, by continuation from smaller bubbles."""
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
    """A guess from a smaller bubble, with equal depth over radius, and equal curvature of the lowest point times
    radius.
    """
    smaller = radius / GROWTH
    pressure, depth = _found(smaller)
    deeper = depth * GROWTH
    return (pressure - depth) / GROWTH + deeper, deeper


def _shape(pressure: float, depth: float) -> Shape:
    """The shape from the lowest point to the edge of the film, where r = (4/P) sin(phi)."""
    shot = _shot(pressure, depth)
    r, z, phi, volume, moment = (float(last) for last in shot.y[:, -1])
    film, beta = 4.0 / pressure, math.pi - phi
    rise = film * (1.0 - math.cos(beta))
    cap = math.pi * rise**2 * (film - rise / 3.0)
    over = math.pi * rise**3 * (film / 3.0 - rise / 12.0)  # the moment of the cap about its base
    return Shape(beta, r, z, volume + cap, moment + cap * z + over, volume)


def _shot(pressure: float, depth: float) -> Any:
    """The curve r, z and phi, and the volume with its moment, along the arc."""
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
