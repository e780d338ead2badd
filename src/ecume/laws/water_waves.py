"""Waves on a liquid of finite depth, their viscous decay, and sloshing in a shaken tank."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from ecume.errors import BadInput
from ecume.laws.arguments import require_not_negative, require_positive
from ecume.units import (
    Acceleration,
    Angle,
    Density,
    KinematicViscosity,
    Length,
    Number,
    Rate,
    Speed,
    SurfaceTension,
    Time,
    Unit,
)

SpecificTension = Annotated[float, Unit("m^3/s^2")]
"""Surface tension over density."""

Wavenumber = Annotated[float, Unit("1/m")]

SquaredFrequency = Annotated[float, Unit("1/s^2")]


class Layer(NamedTuple):
    """One of two liquids between a floor and a lid."""

    density: Density
    depth: Length


class Decay(NamedTuple):
    """A wave that decays as exp(-rate t) cos(frequency t)."""

    rate: Rate
    frequency: Rate


def wave_frequency(
    wavenumber: Wavenumber, depth: Length, gravity: Acceleration, tension: SpecificTension = 0.0
) -> Rate:  # fmt: skip
    """Angular frequency of small waves without viscosity, omega^2 = (g k + (sigma/rho) k^3) tanh(k
    H).

    k: wavenumber, n pi / L for the n-th standing wave in a tank of the length L; H: depth; sigma/rho: tension.
    [lamb1932, art. 228, 267].

    >>> round(wave_frequency(math.pi / 2.0, 1.0, 9.81), 6)
    3.759371
    """
    restoring = gravity * wavenumber + tension * wavenumber**3
    return math.sqrt(restoring * math.tanh(wavenumber * depth))


def interface_frequency_squared(
    wavenumber: Wavenumber, lower: Layer, upper: Layer, gravity: Acceleration, tension: SurfaceTension = 0.0
) -> SquaredFrequency:
    """Square of the angular frequency of small waves in the interface of two liquids without viscosity,
    omega^2 = (g k (rho_1 - rho_2) + sigma k^3)/(rho_1 coth k h_1 + rho_2 coth k h_2).

    k: wavenumber; rho_1, h_1: density and depth of the lower liquid, above a floor; rho_2, h_2: of the upper one, below
    a lid; sigma: tension. Below zero it is minus the square of the growth rate (Rayleigh-Taylor). [lamb1932, art. 231,
    268].

    >>> deep = interface_frequency_squared(1.0, Layer(3.0, 100.0), Layer(1.0, 100.0), 9.81)
    >>> round(deep, 9)
    4.905
    """
    restoring = gravity * wavenumber * (lower.density - upper.density) + tension * wavenumber**3
    inertia = sum(layer.density / math.tanh(wavenumber * layer.depth) for layer in (lower, upper))
    return restoring / inertia


def group_velocity(wavenumber: Wavenumber, depth: Length, gravity: Acceleration) -> Speed:
    """Group velocity c_g = (omega/2k) (1 + 2 k H/sinh(2 k H)), at which small waves transport
    energy.

    k, H, omega: wavenumber, depth, and `wave_frequency` without tension. Half of the phase velocity in deep water,
    all of it in shallow water. [lamb1932, art. 236].

    >>> round(group_velocity(1.0, 100.0, 9.81), 6) == round(0.5 * math.sqrt(9.81), 6)
    True
    >>> round(group_velocity(1e-4, 1.0, 9.81), 4) == round(math.sqrt(9.81), 4)
    True
    """
    twice = 2.0 * wavenumber * depth
    share = twice / math.sinh(twice) if twice < 100.0 else 0.0
    return 0.5 * wave_frequency(wavenumber, depth, gravity) / wavenumber * (1.0 + share)


def viscous_decay(
    wavenumber: Wavenumber,
    depth: Length,
    gravity: Acceleration,
    kinematic_viscosity: KinematicViscosity,
    tension: SpecificTension = 0.0,
) -> Decay:
    """Decay and frequency of a small wave in a viscous liquid that slips freely on its bottom.

    The root s = -rate + i frequency of (s + 2 nu k^2)^2 + omega_0^2 = 4 nu^2 k^3 m tanh(k H)/tanh(m H), where
    m^2 = k^2 + s/nu: the linear Navier-Stokes equations with no stress on the surface, at every Reynolds number at
    which the wave oscillates. In deep water it is [lamb1932, art. 349]. The common 2 nu k^2 is its limit for low
    viscosity, and a third too high at Re = sqrt(g H) H/nu = 50.

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
    # sinh and cosh, which overflow in deep water, as e^(k y - k H) times factors near one.
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


SLOSHING_MODES = 39
"""The last of the odd modes in the sum; mode n has a weight of 1/n^2 or less."""


@dataclass(frozen=True)
class Tank:
    """A rectangular tank filled to a depth, with free slip at its walls."""

    length: Length
    depth: Length
    gravity: Acceleration
    kinematic_viscosity: KinematicViscosity = 0.0


@dataclass(frozen=True)
class BaseExcitation:
    """Inertial acceleration along the tank, A sin(Omega t + phi) from rest: minus the tank's acceleration."""

    amplitude: Acceleration
    turning: Rate
    phase: Angle = 0.0


def sloshing_height(x: Length, time: Time, tank: Tank, excitation: BaseExcitation) -> Length:
    """Height of the surface above its level at x: the sum of b_n(t) cos(n pi x / L) over odd n.

    x: from the left wall; b_n: `sloshing_mode`. Horizontal motion does not excite even modes. For heights far below
    depth and length, off resonance. [ibrahim2005, faltinsen2009].

    >>> still = BaseExcitation(amplitude=0.02, turning=1e-6, phase=math.pi / 2)
    >>> level = sloshing_height(0.0, 1e4, Tank(2.0, 1.0, 9.81, 1e-3), still)
    >>> round(level / (-0.02 / 9.81), 2)  # a slow pull tilts the surface by A/g
    0.99
    """
    odd = range(1, SLOSHING_MODES + 1, 2)
    return sum(sloshing_mode(time, mode, tank, excitation) * math.cos(mode * math.pi * x / tank.length) for mode in odd)


def sloshing_mode(time: Time, mode: Number, tank: Tank, excitation: BaseExcitation) -> Length:
    """Amplitude b of a mode, b'' + 2 c b' + omega^2 b = -4 tanh(k H)/(n pi) A sin(Omega t + phi), from rest; n odd, k =
    n pi / L.

    The potential of the excitation, -A x, contains 4 A L/(n pi)^2 cos(k x), which accelerates the surface by k tanh(k
    H) times that.
    omega: `ecume.laws.water_waves.wave_frequency`; c = 2 nu k^2, the decay rate at a low viscosity, c << omega.
    [ibrahim2005, faltinsen2009].

    >>> round(sloshing_mode(1.3, 1.0, Tank(2.0, 1.0, 1.0), BaseExcitation(0.01, 0.9)), 9)
    -0.003165623
    """
    k = mode * math.pi / tank.length
    swing = wave_frequency(k, tank.depth, tank.gravity)
    decay = 2.0 * tank.kinematic_viscosity * k * k
    push = -4.0 * math.tanh(k * tank.depth) / (mode * math.pi) * excitation.amplitude
    follows = push / complex(swing**2 - excitation.turning**2, 2.0 * decay * excitation.turning)
    turned = follows * cmath.exp(1j * excitation.phase)
    start, rate = turned.imag, (1j * excitation.turning * turned).imag
    # Two oscillating decays, or two monotonic ones with strong damping; in both cases the sum is real.
    apart = cmath.sqrt(decay**2 - swing**2)
    one, other = -decay + apart, -decay - apart
    free = (rate - other * start) * cmath.exp(one * time) - (rate - one * start) * cmath.exp(other * time)
    return (turned * cmath.exp(1j * excitation.turning * time)).imag - (free / (one - other)).real
