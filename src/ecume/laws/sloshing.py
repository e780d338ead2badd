"""How a liquid in a shaken tank rises at the walls, as long as it rises little: potential flow, mode by mode."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

from ecume.laws.waves import wave_frequency
from ecume.units import Acceleration, Angle, KinematicViscosity, Length, Number, Rate, Time

MODES = 39
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
    odd = range(1, MODES + 1, 2)
    return sum(sloshing_mode(time, mode, tank, excitation) * math.cos(mode * math.pi * x / tank.length) for mode in odd)


def sloshing_mode(time: Time, mode: Number, tank: Tank, excitation: BaseExcitation) -> Length:
    """The b of b'' + 2 c b' + omega^2 b = -4 tanh(k H)/(n pi) A sin(Omega t + phi), from rest; n odd, k = n pi / L.

    The pull's potential, -A x, is 4 A L/(n pi)^2 cos(k x) along the surface, and rises it by k tanh(k H) times that.
    omega: `ecume.laws.waves.wave_frequency`; c = 2 nu k^2, the decay in a liquid thin enough for c << omega.
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
