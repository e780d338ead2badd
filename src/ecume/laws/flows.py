"""Exact flows to hold a simulated liquid against: vortices, channels, waves, shaken tanks and drops that swing.

The functions of Taylor and Green welcome arrays: they also start runs.

A dish that is moved, as floats see it from inside: the place, velocity and acceleration of a swing, and its pull.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from ecume.errors import BadInput
from ecume.laws.arguments import require_not_negative, require_positive
from ecume.units import (
    Acceleration,
    Angle,
    Angles,
    Density,
    Force,
    Friction,
    KinematicViscosity,
    Length,
    Mass,
    Number,
    Pressure,
    Rate,
    Real,
    Speed,
    Time,
    Unit,
    Viscosity,
)

Speeds = Annotated[Real, Unit("m/s")]
Pressures = Annotated[Real, Unit("Pa")]
Wavenumber = Annotated[float, Unit("1/m")]
Stretching = Annotated[float, Unit("1/s^2")]
TERMS = 400
"""Number of terms of the series: the remainder is below 1e-7 of the largest speed at any time."""
CHANNEL_MODES = 199
"""Number of terms of the double series in each direction: the remainder is below 1e-7 of its largest value."""


def taylor_green_velocity(phase_along: Angles, phase_across: Angles, speed: Speed) -> Speeds:
    """Velocity along one axis of a square lattice of vortices, -U cos(k x) sin(k y).

    Angles: k x along that axis, k y across it. The other component is the same with -U and the phases exchanged, and
    with -U k_x/k_y where the lattice is not square. [taylor1937].

    >>> float(taylor_green_velocity(0.0, math.pi / 2.0, 2.0))
    -2.0
    """
    velocity: Real = -speed * np.cos(phase_along) * np.sin(phase_across)
    return velocity


def taylor_green_pressure(
    phase_x: Angles, phase_y: Angles, speed_x: Speed, speed_y: Speed, density: Density
) -> Pressures:
    """Gauge pressure in the vortices, -(rho/4) (U^2 cos(2 k_x x) + V^2 cos(2 k_y y)): low in their centers.

    U, V: largest speeds along x and y, equal in a square lattice. [taylor1937].

    >>> float(taylor_green_pressure(0.0, 0.0, 1.0, 1.0, 1000.0))
    -500.0
    """
    swing: Real = speed_x**2 * np.cos(2.0 * phase_x) + speed_y**2 * np.cos(2.0 * phase_y)
    return -0.25 * density * swing


def taylor_green_decay(
    wavenumber_x: Wavenumber, wavenumber_y: Wavenumber, kinematic_viscosity: KinematicViscosity
) -> Rate:
    """Rate at which all velocities of the vortices fall, nu (k_x^2 + k_y^2); energy and pressure fall twice as fast.

    Exact at every Reynolds number: the flow only fades. [taylor1937].

    >>> round(math.exp(-taylor_green_decay(2.0 * math.pi, 2.0 * math.pi, 0.01)), 6)
    0.454041
    """
    return float(kinematic_viscosity * (wavenumber_x**2 + wavenumber_y**2))


def poiseuille_start(
    height: Length,
    time: Time,
    width: Length,
    kinematic_viscosity: KinematicViscosity,
    acceleration: Acceleration,
) -> Speed:
    """Speed at y of a liquid between two resting plates that is pulled along them from t = 0 on.

    F y (L - y)/(2 nu) - sum over odd n of 4 F L^2/(nu pi^3 n^3) sin(n pi y/L) exp(-n^2 pi^2 nu t/L^2); in the end the
    largest speed is F L^2/(8 nu). F: acceleration; L: width; nu: kinematic viscosity. [morris1997].

    >>> round(poiseuille_start(0.5, 0.1125, 1.0, 1.0, 8.0), 6)
    0.659993
    """
    nu = kinematic_viscosity
    steady = 0.5 * acceleration / nu * height * (width - height)
    scale = 4.0 * acceleration * width**2 / (nu * math.pi**3)
    terms = (
        math.sin(n * math.pi * height / width) * math.exp(-((n * math.pi / width) ** 2) * nu * time) / n**3
        for n in range(1, TERMS, 2)
    )
    return steady - scale * math.fsum(terms)


def channel_speed(height: Length, width: Length, speed: Speed) -> Speed:
    """Speed at y of a viscous liquid that flows steadily between two resting plates.

    6 U y (L - y)/L^2; 3/2 U in the middle. U: the mean `speed`; L: width. [batchelor1967, sec. 4.2].

    >>> channel_speed(0.5, 1.0, 1.0)
    1.5
    """
    return 6.0 * speed * height * (width - height) / (width * width)


def channel_pressure_drop(viscosity: Viscosity, speed: Speed, length: Length, width: Length) -> Pressure:
    """Return the pressure drop along a channel between two parallel walls, 12 eta u L / H^2, with the mean speed u of
    its parabola. Exact for developed flow; more at an entrance.

    >>> round(channel_pressure_drop(0.05, 1.0, 3.0, 1.0), 12)
    1.8
    """
    return 12.0 * viscosity * speed * length / (width * width)


def couette_start(
    height: Length,
    time: Time,
    width: Length,
    kinematic_viscosity: KinematicViscosity,
    speed: Speed,
) -> Speed:
    """Speed at y of a liquid between a resting plate at 0 and one at L that moves from t = 0 on.

    V sum over k of erfc(((2k+1) L - y)/s) - erfc(((2k+1) L + y)/s) with s = 2 sqrt(nu t): the layer that the plate
    drags along, and its images behind both. V: speed of the plate; L: width; nu: kinematic viscosity. The series of
    sines [morris1997] is the same, and loses all digits where nothing moves yet. [batchelor1967, sec. 4.3].

    >>> round(couette_start(0.5, 0.1125, 1.0, 1.0, 1.0), 6)
    0.290275
    """
    reach = 2.0 * math.sqrt(kinematic_viscosity * time)
    images = 1 + math.ceil(6.0 * reach / width)
    terms = (
        math.erfc(((2 * k + 1) * width - height) / reach) - math.erfc(((2 * k + 1) * width + height) / reach)
        for k in range(images)
    )
    return speed * math.fsum(terms)


def patch_pressure(across: Length, along: Length, width: Length, stretching: Stretching, density: Density) -> Pressure:
    """Gauge pressure in a square of liquid without walls at the instant at which it moves as v = G x.

    rho S sum over odd m, n of 16/(m n pi^2 ((m pi/L)^2 + (n pi/L)^2)) sin(m pi x/L) sin(n pi y/L), from one corner: the
    solution of lap p = -rho S with S = tr(G^2) that is zero on the sides. It is negative everywhere inside where the
    patch spins like a solid, S = -2 w^2. L: width. [colagrossi2005].

    >>> round(patch_pressure(0.5, 0.5, 1.0, -2.0, 1.0), 6)
    -0.147343
    """
    modes = np.arange(1, CHANNEL_MODES + 1, 2) * math.pi / width
    m, n = modes[:, None], modes[None, :]
    terms = np.sin(m * across) * np.sin(n * along) / (m * n * (m * m + n * n))
    return float(16.0 * density * stretching / width**2 * terms.sum())


def ball_pressure(
    distance: Length, radius: Length, stretching: Stretching, density: Density, dimensions: Number
) -> Pressure:
    """Gauge pressure in a disc or ball of liquid without walls while it moves as v = G x, rho S (R^2 - r^2)/(2 d).

    S = tr(G^2) + d w^2, where w^2 times its distance pulls everything to the center; 2 s^2 where a disc is stretched at
    the rate s. The solution of lap p = -rho S that is zero on the surface. d: dimensions. [monaghan1994] with w = 0,
    [monaghan2013].

    >>> ball_pressure(0.0, 1.0, 2.0 * 100.0**2, 1.0, 2.0)
    5000.0
    """
    return 0.5 * density * stretching / dimensions * (radius**2 - distance**2)


def drop_strain_change(strain_rate: Rate, pull_rate: Rate, width: Length, height: Length) -> Stretching:
    """How fast the rate of strain of an elliptic drop changes, (s^2 + w^2) (b^2 - a^2)/(a^2 + b^2).

    The drop flows as u = s x, v = -s y, so that da/dt = s a and db/dt = -s b; each particle is pulled to the center by
    w^2 times its distance (not at all if w = 0). s: rate of strain; w: rate of the pull; a: width, b: height, both
    half. (s^2 + w^2) (a^2 + b^2) is conserved. [monaghan1994] with w = 0, [monaghan2013].

    >>> drop_strain_change(2.0, 1.0, 1.0, 1.0)
    0.0
    """
    a, b = width * width, height * height
    return (strain_rate**2 + pull_rate**2) * (b - a) / (a + b)


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


def group_velocity(wavenumber: Wavenumber, depth: Length, gravity: Acceleration) -> Speed:
    """Velocity c_g = (omega/2k) (1 + 2 k H/sinh(2 k H)) at which small waves carry their energy.

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


SLOSHING_MODES = 39
"""The last of the odd ones that are summed: the n-th weighs 1/n^2 or less."""


@dataclass(frozen=True)
class Tank:
    """A rectangle full of liquid to a depth, with walls that do not hold it."""

    length: Length
    depth: Length
    gravity: Acceleration
    kinematic_viscosity: KinematicViscosity = 0.0


@dataclass(frozen=True)
class BaseExcitation:
    """What pulls along the tank beside gravity, A sin(Omega t + phi), from rest on: minus the tank's acceleration."""

    amplitude: Acceleration
    turning: Rate
    phase: Angle = 0.0


def sloshing_height(x: Length, time: Time, tank: Tank, excitation: BaseExcitation) -> Length:
    """How far the surface is above its level at x, positive upwards: the sum of b_n(t) cos(n pi x / L) over odd n.

    x: from the left wall; b_n: `sloshing_mode`. Even modes are not stirred by a tank that stays level. For heights far
    below depth and length, off resonance. [ibrahim2005, faltinsen2009].

    >>> still = BaseExcitation(amplitude=0.02, turning=1e-6, phase=math.pi / 2)
    >>> level = sloshing_height(0.0, 1e4, Tank(2.0, 1.0, 9.81, 1e-3), still)
    >>> round(level / (-0.02 / 9.81), 2)  # a slow pull tilts the surface by A/g
    0.99
    """
    odd = range(1, SLOSHING_MODES + 1, 2)
    return sum(sloshing_mode(time, mode, tank, excitation) * math.cos(mode * math.pi * x / tank.length) for mode in odd)


def sloshing_mode(time: Time, mode: Number, tank: Tank, excitation: BaseExcitation) -> Length:
    """The b of b'' + 2 c b' + omega^2 b = -4 tanh(k H)/(n pi) A sin(Omega t + phi), from rest; n odd, k = n pi / L.

    The pull's potential, -A x, is 4 A L/(n pi)^2 cos(k x) along the surface, and rises it by k tanh(k H) times that.
    omega: `ecume.laws.flows.wave_frequency`; c = 2 nu k^2, the decay in a liquid thin enough for c << omega.
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
    # Two decays that swing, or two that creep where friction is too strong; their sum is real all the same.
    apart = cmath.sqrt(decay**2 - swing**2)
    one, other = -decay + apart, -decay - apart
    free = (rate - other * start) * cmath.exp(one * time) - (rate - one * start) * cmath.exp(other * time)
    return (turned * cmath.exp(1j * excitation.turning * time)).imag - (free / (one - other)).real


def drop_period(tension: SpecificTension, radius: Length, mode: Number, dimensions: Number) -> Time:
    """Period of a drop that swings a little in its mode n (2: ellipse), without viscosity and air.

    omega^2 = n (n-1) (n+dim-1) sigma / (rho R^3): n (n-1) (n+2) for a ball, n (n^2-1) for a disc. [lamb1932, art. 273,
    275].

    >>> round(drop_period(1.0, 1.0, 2, 3) / (2 * math.pi / math.sqrt(8.0)), 12)
    1.0
    """
    require_positive("radius", radius)
    return 2.0 * math.pi / math.sqrt(mode * (mode - 1.0) * (mode + dimensions - 1.0) * tension / radius**3)


def drop_decay(
    tension: SpecificTension,
    kinematic_viscosity: KinematicViscosity,
    radius: Length,
    mode: Number,
    dimensions: Number,
) -> Decay:
    """Decay and frequency of a small swing of a viscous drop without air, in its mode n.

    The root s = -rate + i frequency of the linear Navier-Stokes equations without stress on the surface, R = 1:
    (s^2 + 2 nu n (n-1) s + omega^2) (k^2 + 2t - 2Q) = 2t (omega^2 + 2 nu n (n-1+Q) s), where k^2 = s/nu,
    t = (n-1) (n+dim-2), and Q = k I_{m+1}(k)/I_m(k) with m = n in 2D, n + 1/2 in 3D: what a potential flow,
    r^n, and the vorticity from the surface, I_m, do together. For thin liquids the rate is nu (n-1) (2n+dim-2)/R^2,
    2n (n-1) nu/R^2 for a disc and (n-1) (2n+1) nu/R^2 for a ball [lamb1932, art. 355].

    >>> found = drop_decay(1.0, 1e-4, 1.0, 2, 3)
    >>> round(found.rate / 5e-4, 2), round(found.frequency / math.sqrt(8.0), 4)
    (0.99, 1.0)
    """
    require_not_negative("kinematic_viscosity", kinematic_viscosity)
    swing = 2.0 * math.pi / drop_period(tension, radius, mode, dimensions)
    nu = kinematic_viscosity / (radius * radius)
    if nu == 0.0:
        return Decay(0.0, swing)
    root = complex(-nu * (mode - 1.0) * (2.0 * mode + dimensions - 2.0), swing)
    before, at_before = root * (1.0 + 1e-3), _stress(root * (1.0 + 1e-3), nu, swing, (mode, dimensions))
    for _ in range(60):
        here = _stress(root, nu, swing, (mode, dimensions))
        if here == at_before:
            break
        step = here * (root - before) / (here - at_before)
        before, at_before, root = root, here, root - step
        if abs(step) < 1e-13 * abs(root):
            break
    if not (root.imag > 1e-9 * swing and abs(root - before) < 1e-9 * abs(root)):
        raise BadInput(
            f"a drop of {radius:g} m is overdamped at a kinematic viscosity of {kinematic_viscosity:g} m^2/s"
        )
    return Decay(-root.real, root.imag)


def _stress(s: complex, nu: float, swing: float, mode: tuple[float, float]) -> complex:
    from scipy.special import ive

    n, dimensions = mode
    k, t = cmath.sqrt(s / nu), (n - 1.0) * (n + dimensions - 2.0)
    order = n + 0.5 * (dimensions - 2.0)
    above, here = ive([order + 1.0, order], [k, k])
    vorticity = k * complex(above / here)
    potential = (s * s + 2.0 * nu * n * (n - 1.0) * s + swing * swing) * (k * k + 2.0 * t - 2.0 * vorticity)
    return potential / (k * k) - 2.0 * t / (k * k) * (swing * swing + 2.0 * nu * n * (n - 1.0 + vorticity) * s)


def sway_place(amplitude: Length, turning: Rate, time: Time) -> Length:
    """Where a dish is that swings about A, from rest at 0: x = A (1 - cos(Omega t)).

    >>> round(sway_place(2.0, math.pi, 1.0), 12)
    4.0
    """
    return amplitude * (1.0 - math.cos(turning * time))


def sway_velocity(amplitude: Length, turning: Rate, time: Time) -> Speed:
    """Its velocity, A Omega sin(Omega t): the slope of `sway_place` in time.

    >>> sway_velocity(2.0, 3.0, 0.0)
    0.0
    """
    return amplitude * turning * math.sin(turning * time)


def sway_acceleration(amplitude: Length, turning: Rate, time: Time) -> Acceleration:
    """Its acceleration, A Omega^2 cos(Omega t): the slope of `sway_velocity` in time.

    >>> sway_acceleration(2.0, 3.0, 0.0)
    18.0
    """
    return amplitude * turning**2 * math.cos(turning * time)


def left_behind(mass: Mass, friction: Friction, acceleration: Acceleration, velocity: Speed, slip: Number) -> Force:
    """What a dish in motion does to a float, as seen from the dish: F = -s (m a + zeta V).

    The liquid goes along with the part 1 - s of the dish's velocity V and acceleration a: what it is carried by at
    s = 0 it does not feel, since liquid that is moved as a whole is in an even gravity, only a tilted one. At s = 1 the
    liquid rests, and the float lags by its own inertia and by all of its drag.

    >>> left_behind(2.0, 0.5, 3.0, 4.0, 0.0) == 0.0, left_behind(2.0, 0.5, 3.0, 4.0, 1.0)
    (True, -8.0)
    """
    return -slip * (mass * acceleration + friction * velocity)
