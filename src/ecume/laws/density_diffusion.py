"""Diffusion of density between SPH particles, which removes noise from the pressure.

    drho_i/dt = ... + sum_j V_j flow_ij,    with what j has in excess of i by one of these laws.

The excess must vanish in a liquid at rest under gravity; otherwise the level drifts. Molteni's does not vanish (the
surface rises until the tank diverges), Fourtakas's linear one nearly does, Fourtakas's with the exact column and
Antuono's do. Antuono's gradients are wrong beside walls of dummy particles and are not used there.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

from ecume.units import Density, Length, Number, Speed, Unit

Potential = Annotated[float, Unit("m^2/s^2")]
Diffusivity = Annotated[float, Unit("m^2/s")]


def strength(delta: Number, smoothing_length: Length, sound_speed: Speed) -> Diffusivity:
    """2 delta h c_0: what all flows of a liquid share. [antuono2010].

    >>> strength(0.1, 0.5, 10.0)
    1.0
    """
    return 2.0 * delta * smoothing_length * sound_speed


def flow(excess: Number, slope: Number) -> Number:
    """-excess F: toward the particle with less of the quantity, since F is never positive. [antuono2010].

    >>> flow(1.0, -2.0)
    2.0
    """
    return -excess * slope


def beyond_rest(here: Number, there: Number, rise: Number) -> Number:
    """What is there in excess of here, less `rise`, by which it would be more at rest; of any quantity. [antuono2010].

    Of the enthalpy rise is the potential g.(x_j - x_i), whatever the exponent of Tait's liquid; times rho_0/c_0^2 it
    is an excess of density.

    >>> beyond_rest(1.0, 4.0, 3.0)
    0.0
    """
    return there - here - rise


def mean_rise(rise_i: Number, rise_j: Number) -> Number:
    """(grad_i + grad_j).(x_j - x_i) / 2 from the two projections: what lies between by both gradients. [antuono2010].

    >>> mean_rise(2.0, 4.0)
    3.0
    """
    return 0.5 * (rise_i + rise_j)


def molteni_excess(density_i: Density, density_j: Density) -> Density:
    """rho_j - rho_i. Not at rest: the weight of the liquid makes it flow up. [molteni2009].

    >>> molteni_excess(1000.0, 1001.0)
    1.0
    """
    return beyond_rest(density_i, density_j, 0.0 * density_i)


def antuono_excess(density_i: Density, density_j: Density, rise_i: Density, rise_j: Density) -> Density:
    """rho_j - rho_i less what the renormalized gradients make of the way from i to j. [antuono2010].

    rise: grad rho . (x_j - x_i) with the renormalized gradient of i, and that of j. Zero for every linear density.

    >>> antuono_excess(1000.0, 1003.0, 2.0, 4.0)
    0.0
    """
    return beyond_rest(density_i, density_j, mean_rise(rise_i, rise_j))


def fourtakas_linear_excess(
    density_i: Density, density_j: Density, potential: Potential, reference_density: Density, sound_speed: Speed
) -> Density:
    """rho_j - rho_i less rho_0 g.(x_j - x_i) / c_0^2, what the weight makes under the linear law. [fourtakas2019].

    potential: g.(x_j - x_i), positive when j lies deeper. To first order what the paper's inverse of Tait's law gives
    at rho_0: with gamma = 7 a tank's level creeps by one or two percent in 1e5 steps.

    >>> fourtakas_linear_excess(1000.0, 1001.0, 1.0, 1000.0, 10.0)
    -9.0
    """
    return beyond_rest(density_i, density_j, reference_density * potential / (sound_speed * sound_speed))


def fourtakas_excess(
    density_i: Density, density_j: Density, potential: Potential, sound_speed_i: Speed, exponent: Number
) -> Density:
    """rho_j - rho_i less what weight makes in an exact column of Tait's liquid. After [fourtakas2019].

    potential: g.(x_j - x_i), positive when j lies deeper; sound_speed_i: Tait's at rho_i, not c_0. Zero between any two
    particles of the column at rest, for every exponent.

    >>> fourtakas_excess(1000.0, 1000.0, 0.0, 10.0, 7.0)
    0.0
    """
    head = potential / (sound_speed_i * sound_speed_i)
    return beyond_rest(density_i, density_j, density_i * hydrostatic_gain(head, exponent))


def hydrostatic_gain(head: Number, exponent: Number) -> Number:
    """(1 + a u)^(1/a) - 1 with a = gamma - 1: how much denser a liquid at rest is by the head u = g d/c^2 deeper.

    The binomial series to the seventh order, without powers and branches: loops vectorize. For gamma = 1 exp(u) - 1.
    Relative error below 1e-7 for |a u| < 0.1, below 1e-14 for |a u| < 0.01. [monaghan1994].

    >>> abs(hydrostatic_gain(0.001, 7.0) / (1.006 ** (1 / 6) - 1) - 1) < 1e-12
    True
    """
    a = exponent - 1.0
    u = head
    # Constants are multiplied, not divided by: a division takes as long as all the rest of a term.
    sixth = 1.0 + (1.0 - 5.0 * a) * (1.0 / 6.0) * u * (1.0 + (1.0 - 6.0 * a) * (1.0 / 7.0) * u)
    fourth = 1.0 + (1.0 - 3.0 * a) * 0.25 * u * (1.0 + (1.0 - 4.0 * a) * 0.2 * u * sixth)
    return u * (1.0 + (1.0 - a) * 0.5 * u * (1.0 + (1.0 - 2.0 * a) * (1.0 / 3.0) * u * fourth))


EXCESSES: dict[str, Callable[..., float]] = {
    "molteni": molteni_excess,
    "antuono": antuono_excess,
    "fourtakas-linear": fourtakas_linear_excess,
    "fourtakas": fourtakas_excess,
}
"""The laws by name, each with its own arguments."""


BOLTZMANN = 1.380649e-23
"""J/K, exact by definition."""
SMALL = 0.05
"""Below this ratio a series replaces differences that would cancel."""

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
    """The height kT / W over which a suspension thins by e: c(y) = c(0) exp(-y W / kT). [perrin1909].

    >>> sedimentation_length(4.0, 2.0)
    2.0
    """
    return thermal / weight


def velocity_variance(ratio: Number) -> Number:
    """Variance of the velocity over kT/m, 1 - e^(-2 r), r = t/tau, from a given one. [uhlenbeck1930].

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
    """What an initial acceleration A gives in a time t against linear drag: A t (1 - e^-r)/r. [uhlenbeck1930].

    >>> velocity_gain(0.0), round(velocity_gain(1.0), 6)
    (1.0, 0.632121)
    """
    return -math.expm1(-ratio) / ratio if ratio > 0.0 else 1.0


def displacement_gain(ratio: Number) -> Number:
    """What it adds to the displacement v t: (A t^2 / 2) 2 (r - 1 + e^-r)/r^2. [uhlenbeck1930].

    >>> displacement_gain(0.0), round(displacement_gain(1.0), 6)
    (1.0, 0.735759)
    """
    if ratio < SMALL:
        return 1.0 - ratio * (1.0 / 3.0 - ratio * (1.0 / 12.0 - ratio * (1.0 / 60.0 - ratio * (1.0 / 360.0))))
    return 2.0 * (ratio + math.expm1(-ratio)) / (ratio * ratio)


def reflected_gain(change: Length, variance: Area, exponential: Number) -> Length:
    """How far a reflected Brownian motion is at least from its wall at the end of a step (m), and where it is if it met
    the wall: [d + sqrt(d^2 + 2 s^2 E)]/2. [lepingle1995; gobet2001].

    The distance from the wall would change by `change` d, drift and noise together, with the variance s^2; E is a
    random number from the exponential distribution of mean 1. Then d less the result is distributed as the lowest
    distance less the initial one on a path with this end, so that the larger of the free and this distance is exactly
    that of the reflected motion with a constant drift, for a flat wall and any length of the step. At curved walls and
    contacts of discs the error of mean values is of first order in the step.

    >>> reflected_gain(-2.0, 0.0, 1.0), reflected_gain(0.0, 2.0, 1.0)
    (0.0, 1.0)
    """
    return 0.5 * (change + math.sqrt(change * change + 2.0 * variance * exponential))


def reflected_gap(mirrored: Length, approach: Length, drift: Length, variance: Area, draw: Number) -> Length:
    """The gap at the end of a step (m) of a reflected Brownian motion whose free path ends beyond the wall, at the
    distance `mirrored` m: without drift it is m. [scala2007; behringer2012].

    The gap is y at the beginning; it changes by the drift d (positive away from the wall) and by noise of the variance
    s^2, which ends it at -m: the `approach` by noise is y + d + m. The reflected motion is above z with the probability
    P(free > z) + exp(2 d z/s^2) Phi(-(z + y + d)/s). Its second term over its value at z = 0 is the distribution of the
    gaps that this function returns. The mirrored ones have the same without the exponential. For an attraction the
    gap is therefore the smaller of m and of a number from the exponential distribution of mean s^2/(2 |d|), which is
    kT over the force. For a repulsion some gaps grow, to the next event beyond m of a process whose rate is the hazard
    rate of the mirrored gaps less 2 d/s^2, linear in the gap. This holds for drifts up to s/2, above which collisions
    are rare. `draw` is a random number between 0 and 1.

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
