"""Ellipsoids with one axis upright, by their mean contact line. Lengths in L, weights in gamma L."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from ecume.errors import BadInput, FloaterSinks
from ecume.laws.flotation.bodies import Liquid
from ecume.laws.flotation.carrying import Contact, Floating, Load, greatest_load, round_load, stable_load
from ecume.laws.flotation.shapes import Ellipsoid
from ecume.laws.special import bessel_k0, bessel_k1
from ecume.units import Angle, Number


class Spheroid(NamedTuple):
    """A spheroid on a liquid: its semi-axes in L, and pure numbers."""

    radius: float
    height: float
    contact_angle: float
    density_ratio: float

    @property
    def volume(self) -> float:
        """In L^3."""
        return 4.0 / 3.0 * math.pi * self.radius**2 * self.height


def spheroid_contact(radius: Number, height: Number, contact_angle: Angle, slope_angle: Angle) -> Contact:
    """Where a spheroid with semi-axes a (horizontal) and c (upright) is as steep as alpha = pi - theta + psi.

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
    """An ellipsoid, in the three theories of spheres. [vella2005]."""
    length = liquid.capillary_length
    along, across, upright = (axis / length for axis in ellipsoid.semi_axes)
    ratio = (ellipsoid.density - liquid.gas_density) / liquid.density_difference
    spheroid = Spheroid(math.sqrt(along * across), upright, ellipsoid.contact_angle, ratio)
    return THEORIES[theory](spheroid)


def linear_spheroid(spheroid: Spheroid) -> Floating:
    """Small slopes, a small body: A = (W - V)/2 pi, and A/r is the slope at the contact line. [vella2005]."""
    contact = _at(spheroid, 0.0)
    charge = _free_charge(spheroid, contact)
    slope = charge / contact.radius
    height = -slope * bessel_k0(contact.radius) / bessel_k1(contact.radius)
    return _floating(spheroid, math.atan(slope), height, charge)


def closed_form_spheroid(spheroid: Spheroid) -> Floating:
    """Small slopes, heave and filling kept: r z' [1 + V'/(2 pi r) + r K0/(2 K1)] = (W - V)/2 pi. See
    `closed_form_charge`. [vella2005].
    """
    contact = _at(spheroid, 0.0)
    radius, k0, k1 = contact.radius, bessel_k0(contact.radius), bessel_k1(contact.radius)
    kept = 1.0 + contact.volume_change / (2.0 * math.pi * radius) + radius * k0 / (2.0 * k1)
    slope = _free_charge(spheroid, contact) / (radius * kept)
    return _floating(spheroid, math.atan(slope), -slope * k0 / k1, slope / k1)


def nonlinear_spheroid(spheroid: Spheroid) -> Floating:
    """The full meniscus and the full balance; raises FloaterSinks where nothing carries the spheroid. [keller1998]."""
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
    """Slope angle to the density ratio that it carries."""
    return lambda psi: round_load(_at(spheroid, psi), psi, spheroid.volume)


def _at(spheroid: Spheroid, slope_angle: float) -> Contact:
    return spheroid_contact(spheroid.radius, spheroid.height, spheroid.contact_angle, slope_angle)


def _guess(spheroid: Spheroid, limit: float) -> float:
    if _at(spheroid, 0.0).radius < 1e-12:
        return 0.5 * limit
    return math.copysign(min(abs(closed_form_spheroid(spheroid).slope_angle), 0.5 * abs(limit)), limit)


def _free_charge(spheroid: Spheroid, contact: Contact) -> float:
    """What the flat surface leaves to be carried, over 2 pi."""
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
