"""Exact waves to hold a simulated liquid against: frequency and viscous decay."""

from __future__ import annotations

import cmath
import math
from typing import Annotated, NamedTuple

from ecume.errors import BadInput
from ecume.laws.arguments import require_not_negative, require_positive
from ecume.units import Acceleration, KinematicViscosity, Length, Speed, Unit

Wavenumber = Annotated[float, Unit("1/m")]
Rate = Annotated[float, Unit("1/s")]
SpecificTension = Annotated[float, Unit("m^3/s^2")]
"""Surface tension over density."""


class Decay(NamedTuple):
    """A wave that dies away as exp(-rate t) cos(frequency t)."""

    rate: Rate
    frequency: Rate


def wave_frequency(
    wavenumber: Wavenumber, depth: Length, gravity: Acceleration, tension: SpecificTension = 0.0
) -> Rate:  # fmt: skip
    """Angular frequency, omega^2 = (g k + (sigma/rho) k^3) tanh(k H), of small waves without viscosity.

    k: wavenumber, n pi / L for the n-th standing wave in a tank of the length L; H: depth; sigma/rho: tension.
    [lamb1932, art. 228, 267].

    >>> round(wave_frequency(math.pi / 2.0, 1.0, 9.81), 6)
    3.759371
    """
    restoring = gravity * wavenumber + tension * wavenumber**3
    return math.sqrt(restoring * math.tanh(wavenumber * depth))


def viscous_decay(
    wavenumber: Wavenumber,
    depth: Length,
    gravity: Acceleration,
    kinematic_viscosity: KinematicViscosity,
    tension: SpecificTension = 0.0,
) -> Decay:
    """Decay and frequency of a small wave in a viscous liquid that slips freely on its bottom.

    The root s = -rate + i frequency of (s + 2 nu k^2)^2 + omega_0^2 = 4 nu^2 k^3 m tanh(k H)/tanh(m H), where
    m^2 = k^2 + s/nu: the linear Navier-Stokes equations with no stress on the surface, at every Reynolds number as long
    as the wave swings. In deep water it is [lamb1932, art. 349]. The common 2 nu k^2 is its limit for thin liquids,
    and a third too fast at Re = sqrt(g H) H/nu = 50.

    >>> found = viscous_decay(math.pi, 1.0, 1.0, 0.02)
    >>> round(found.rate, 7), round(found.frequency, 7)
    (0.2966515, 1.6817676)
    """
    require_positive("wavenumber", wavenumber)
    require_not_negative("kinematic_viscosity", kinematic_viscosity)
    swing = wave_frequency(wavenumber, depth, gravity, tension)
    if kinematic_viscosity == 0.0:
        return Decay(0.0, swing)
    k, nu = wavenumber, kinematic_viscosity
    root = complex(-2.0 * nu * k * k, swing)
    for _ in range(60):
        step = _newton_step(root, k, depth, nu, swing)
        root -= step
        if abs(step) < 1e-14 * abs(root):
            break
    if not (root.imag > 1e-9 * swing and abs(step) < 1e-9 * abs(root)):
        raise BadInput(f"a wave of wavenumber {k:g} /m is overdamped at a kinematic viscosity of {nu:g} m^2/s")
    return Decay(-root.real, root.imag)


def standing_wave_velocity(
    x: Length, height: Length, *, wavenumber: Wavenumber, depth: Length, speed: Speed
) -> tuple[Speed, Speed]:
    """Velocity along x and upwards in a small standing wave, when its surface is flat and rises at cos(k x).

    u = -U sin(k x) cosh(k y)/sinh(k H), v = U cos(k x) sinh(k y)/sinh(k H): no divergence, no rotation, nothing through
    the bottom or through walls where sin(k x) = 0. y: height above the bottom; H: depth; U: speed, of the surface at
    x = 0. [lamb1932, art. 228].

    >>> standing_wave_velocity(0.0, 2.0, wavenumber=math.pi, depth=2.0, speed=0.1)
    (-0.0, 0.1)
    """
    require_positive("wavenumber", wavenumber)
    require_positive("depth", depth)
    k, below, above = wavenumber, -2.0 * wavenumber * depth, -2.0 * wavenumber * height
    # sinh and cosh as e^(k y - k H) times factors near one: in deep water they overflow.
    scale = speed * math.exp(k * height - k * depth) / math.expm1(below)
    along = scale * math.sin(k * x) * (1.0 + math.exp(above))
    return along, scale * math.cos(k * x) * math.expm1(above)


def _newton_step(s: complex, k: float, depth: float, nu: float, swing: float) -> complex:
    m = cmath.sqrt(k * k + s / nu)
    cotangent = 1.0 / cmath.tanh(m * depth)
    weight = 4.0 * nu * nu * k**3 * math.tanh(k * depth)
    value = (s + 2.0 * nu * k * k) ** 2 + swing * swing - weight * m * cotangent
    change = cotangent - m * depth * (cotangent * cotangent - 1.0)
    return value / (2.0 * (s + 2.0 * nu * k * k) - weight * change / (2.0 * nu * m))
