"""Brownian motion of a sphere: random displacements and velocities during a time, with and without inertia.

A particle of mass m and friction zeta relaxes in tau = m / zeta; with the ratio r = t / tau the velocity and the
displacement after a time t are normal numbers whose variances are exact for any r.
"""

from __future__ import annotations

import math
from typing import Annotated

from ecume.units import Area, Force, Friction, Length, Number, Unit

Diffusivity = Annotated[float, Unit("m^2/s")]
BOLTZMANN = 1.380649e-23
"""J/K, exact by definition."""
SMALL = 0.05
"""The ratio below which series replace differences of almost equal terms."""

Energy = Annotated[float, Unit("J")]


def thermal_energy(temperature: Annotated[float, Unit("K")]) -> Energy:
    """Thermal energy kT, J. [einstein1905].

    >>> round(thermal_energy(293.15) * 1e21, 4)
    4.0474
    """
    return BOLTZMANN * temperature


def diffusivity(thermal: Energy, friction: Friction) -> Diffusivity:
    """Diffusion coefficient D = kT / zeta: along each axis <x^2> = 2 D t. [einstein1905].

    >>> diffusivity(4.0, 2.0)
    2.0
    """
    return thermal / friction


def sedimentation_length(thermal: Energy, weight: Force) -> Length:
    """The height kT / W over which the concentration of a suspension decreases by a factor e: c(y) = c(0) exp(-y W /
    kT). [perrin1909].

    >>> sedimentation_length(4.0, 2.0)
    2.0
    """
    return thermal / weight


def velocity_variance(ratio: Number) -> Number:
    """Variance of the velocity, after a given initial one, over kT/m: 1 - e^(-2 r), r = t/tau. [uhlenbeck1930].

    >>> round(velocity_variance(0.5), 6)
    0.632121
    """
    return -math.expm1(-2.0 * ratio)


def displacement_variance(ratio: Number) -> Number:
    """Variance of the displacement over kT tau^2/m, 2 r - 3 + 4 e^-r - e^(-2 r); 2 r for long times. [uhlenbeck1930].

    >>> round(displacement_variance(1.0), 6), round(displacement_variance(100.0), 6)
    (0.336182, 197.0)
    """
    if ratio < SMALL:
        tail = 7.0 / 30.0 - ratio * (1.0 / 12.0 - ratio * (31.0 / 1260.0 - ratio / 160.0))
        return ratio**3 * (2.0 / 3.0 - ratio * (0.5 - ratio * tail))
    lost = -math.expm1(-ratio)
    return 2.0 * (ratio - lost) - lost * lost


def covariance(ratio: Number) -> Number:
    """Covariance of displacement and velocity over kT tau/m, (1 - e^-r)^2. [uhlenbeck1930].

    >>> round(covariance(1.0), 6)
    0.399576
    """
    lost = -math.expm1(-ratio)
    return lost * lost


def velocity_gain(ratio: Number) -> Number:
    """Velocity gained during a time t by an initial acceleration A against linear drag, over A t: (1 - e^-r)/r.
    [uhlenbeck1930].

    >>> velocity_gain(0.0), round(velocity_gain(1.0), 6)
    (1.0, 0.632121)
    """
    return -math.expm1(-ratio) / ratio if ratio > 0.0 else 1.0


def displacement_gain(ratio: Number) -> Number:
    """Displacement by an initial acceleration A against linear drag, beyond v t, over A t^2 / 2: 2 (r - 1 + e^-r)/r^2.
    [uhlenbeck1930].

    >>> displacement_gain(0.0), round(displacement_gain(1.0), 6)
    (1.0, 0.735759)
    """
    if ratio < SMALL:
        return 1.0 - ratio * (1.0 / 3.0 - ratio * (1.0 / 12.0 - ratio * (1.0 / 60.0 - ratio * (1.0 / 360.0))))
    return 2.0 * (ratio + math.expm1(-ratio)) / (ratio * ratio)


def reflected_gain(change: Length, variance: Area, exponential: Number) -> Length:
    """Final distance (m) of a Brownian motion from a wall that it has met in a step: [d + sqrt(d^2 + 2 s^2 E)]/2.
    [lepingle1995; gobet2001].

    Drift and noise together would change the distance from the wall by d = `change`, with the variance s^2; E is a
    random number from the exponential distribution of mean 1. The minimum of the distance on a path with this end,
    relative to the initial distance, has the distribution of d minus the result. Therefore the larger one of the free
    distance and this result is exactly the distance of the reflected motion with a constant drift, for a flat wall and
    any length of the step. At curved walls and contacts of discs the error of mean values is of first order in the
    step.

    >>> reflected_gain(-2.0, 0.0, 1.0), reflected_gain(0.0, 2.0, 1.0)
    (0.0, 1.0)
    """
    return 0.5 * (change + math.sqrt(change * change + 2.0 * variance * exponential))


def reflected_gap(mirrored: Length, approach: Length, drift: Length, variance: Area, draw: Number) -> Length:
    """The gap (m) at the end of a step of a reflected Brownian motion whose free path ends behind the wall, at the
    depth `mirrored`, m; without drift the gap is m. [scala2007; behringer2012].

    The initial gap is y. It changes by the drift d (positive away from the wall) and by noise of the variance s^2, and
    would end at -m: the `approach` by noise is y + d + m. The reflected motion ends above z with the probability P(free
    > z) + exp(2 d z/s^2) Phi(-(z + y + d)/s). Its second term over its value at z = 0 is the distribution of the gaps
    that this function returns. The distribution of the mirrored gaps is the same without the exponential. For an
    attraction the gap is therefore the smaller of m and of a number from the exponential distribution of mean s^2/(2
    |d|), which is kT over the force. For a repulsion some gaps are larger: they are the next event beyond m of a
    process whose rate is the hazard rate of the mirrored gaps minus 2 d/s^2, approximated as linear in the gap. This
    holds for drifts up to s/2, above which collisions are rare. `draw` is a random number between 0 and 1.

    >>> reflected_gap(0.5, 1.0, 0.0, 1.0, 0.3), reflected_gap(0.5, 1.0, -10.0, 1.0, math.exp(-1.0))
    (0.5, 0.05)
    """
    rate = -2.0 * drift / variance
    if rate >= 0.0:
        return min(mirrored, -math.log(draw) / rate) if rate > 0.0 else mirrored
    spread, deviations = math.sqrt(variance), max(approach, 0.0) / math.sqrt(variance)
    hazard = hazard_rate(deviations)
    growing = min(-rate * spread / hazard, MOST_GROWING)
    if draw >= growing:
        return mirrored
    # The hazard rate of the gaps grows with its slope at m.
    least, slope = hazard * (1.0 - growing), hazard * (hazard - deviations)
    return mirrored + spread * (math.sqrt(least * least - 2.0 * slope * math.log(draw / growing)) - least) / slope


MOST_GROWING = 0.8
"""The largest fraction of gaps that grow by a repulsion."""

FAR = 20.0
"""Standard deviations beyond which Mills's ratio is that of its asymptotic series."""


def hazard_rate(deviations: Number) -> Number:
    """The hazard rate of the normal distribution, exp(-a^2/2)/integral of it beyond a: the inverse of Mills's ratio.

    >>> round(hazard_rate(0.0), 6), round(hazard_rate(30.0), 3)
    (0.797885, 30.033)
    """
    if deviations > FAR:
        return deviations + 1.0 / deviations
    beyond = 0.5 * math.sqrt(2.0 * math.pi) * math.erfc(deviations / math.sqrt(2.0))
    return math.exp(-0.5 * deviations * deviations) / beyond
