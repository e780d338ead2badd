"""Capillary-gravity waves of floats that oscillate vertically, and their mean mutual forces.

A point that presses on a deep, weakly viscous liquid with Re(F e^(i omega t)) radiates a ring wave. The surface obeys
(d/dt + 2 nu k^2)^2 eta = -(g k + sigma k^3/rho) eta - k P/rho, weakly damped potential flow [dias2008]. With
wavenumbers over k_c = (rho omega^2/sigma)^(1/3) its transform is -F k/(sigma k_c^2 D(k)), where

    D(k) = eps^2 k^4 + k^3 + 2 i eps k^2 + beta k - 1,    eps = 2 nu k_c^2/omega,    beta = rho g/(sigma k_c^2).

Partial fractions of k^2/D with the roots k_j and the weights c_j = k_j^2/D'(k_j) give the surface and its slope in
closed form, by Struve's and Bessel's functions [oza2023].
"""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume.errors import BadInput
from ecume.laws.arguments import require_not_negative, require_positive
from ecume.units import Acceleration, Density, Lengths, Number, SurfaceTension, Unit, Viscosity

Complexes = NDArray[np.complex128]
Frequency = Annotated[float, Unit("1/s")]
Wavenumber = Annotated[float, Unit("1/m")]

LARGEST_DAMPING = 0.3
"""The largest eps for which the damping by the liquid counts as weak."""
LARGEST_WEIGHT = 1000.0
"""The largest rho g/(sigma k_c^2) for which the sums keep 1e-3 of the height: above about 0.06 Hz on water."""
NODES = 160
FIRST, LAST = -3.2, 64.0
"""The limits of the integration: ln of the first point, where e^-u makes the integrand vanish, and the exponent of the
last one.
"""


class Ripples(NamedTuple):
    """Waves of one frequency on a liquid."""

    wavenumber: float
    """k_c (1/m)"""
    tension: float
    """N/m"""
    damping: float
    """eps"""
    gravity: float
    """beta: the square of the ratio of lengths 1/(k_c L) with the capillary length L"""
    roots: Complexes
    """(4,) of D; the first is the propagating wave"""
    weights: Complexes
    """(4,) c_j; they add up to zero"""

    @property
    def wavelength(self) -> float:
        """Wavelength of the propagating wave (m)."""
        return float(2.0 * math.pi / (self.wavenumber * self.roots[0].real))

    @property
    def decay_length(self) -> float:
        """Distance over which viscosity reduces the amplitude of the propagating wave by a factor e (m); infinite
        without viscosity.
        """
        slope = abs(self.roots[0].imag)
        return 1.0 / (self.wavenumber * slope) if slope > 0.0 else math.inf


def ripples(
    frequency: Frequency, density: Density, tension: SurfaceTension, viscosity: Viscosity, gravity: Acceleration
) -> Ripples:
    """The waves of a deep liquid at a frequency f = omega/2 pi. [oza2023].

    >>> round(1e3 * ripples(100.0, 1000.0, 0.07, 1e-3, 9.81).wavelength, 3)
    3.583
    """
    require_positive("frequency", frequency)
    require_positive("density", density)
    require_positive("surface tension", tension)
    require_not_negative("viscosity", viscosity)
    require_not_negative("gravity", gravity)
    omega = 2.0 * math.pi * frequency
    scale = (density * omega**2 / tension) ** (1.0 / 3.0)
    if tension * scale**2 == 0.0:
        raise BadInput(f"at {frequency:g} Hz waves are longer than any number; expected a higher frequency")
    damping = max(2.0 * viscosity * scale**2 / (density * omega), 1e-9)
    if damping > LARGEST_DAMPING:
        raise BadInput(
            f"the waves of {frequency:g} Hz have the damping 2 nu k^2/omega = {damping:.3g}; expected at most "
            f"{LARGEST_DAMPING:g}: a less viscous liquid or a lower frequency"
        )
    weight = density * gravity / (tension * scale**2)
    if weight > LARGEST_WEIGHT:
        raise BadInput(
            f"at {frequency:g} Hz weight exceeds surface tension {weight:.3g} times; expected at most "
            f"{LARGEST_WEIGHT:g} times: a higher frequency"
        )
    polynomial = np.array([damping**2, 1.0, 2j * damping, weight, -1.0])
    roots = np.roots(polynomial).astype(np.complex128)
    # Newton's method restores digits that the companion matrix loses by its large root -1/eps^2.
    for _ in range(3):
        roots = roots - np.polyval(polynomial, roots) / np.polyval(np.polyder(polynomial), roots)
    roots = roots[np.argsort(np.abs(roots - 1.0 / (1.0 + weight) ** (1.0 / 3.0)))]
    weights = np.asarray(roots**2 / np.polyval(np.polyder(polynomial), roots), np.complex128)
    return Ripples(scale, tension, damping, weight, np.asarray(roots, np.complex128), weights)


def surface_per_force(distance: Lengths, waves: Ripples) -> Complexes:
    """Complex height of the surface over the amplitude of a point force on the liquid, downward positive (m/N): eta =
    -(1/4 sigma) sum_j c_j [H_0 - Y_0](-k_j k_c r) [oza2023].
    """
    x = waves.wavenumber * np.asarray(distance, dtype=float)
    total = sum(c * struve_minus_bessel(-k * x) for k, c in zip(waves.roots, waves.weights, strict=True))
    return np.asarray(-total / (4.0 * waves.tension))


def slope_per_force(distance: Lengths, waves: Ripples) -> Complexes:
    """Derivative of this height by the distance (1/N): (k_c/4 sigma) sum_j c_j k_j [2/pi - H_1 + Y_1](-k_j k_c r)
    [oza2023].
    """
    x = waves.wavenumber * np.asarray(distance, dtype=float)
    total = sum(c * k * slope_of_struve_minus_bessel(-k * x) for k, c in zip(waves.roots, waves.weights, strict=True))
    return np.asarray(waves.wavenumber * total / (4.0 * waves.tension))


def mean_force(slope: complex, source: complex, other: complex) -> float:
    """Mean lateral force (N) on a point source with the force Re(`other` e^(i omega t)) in the wave of another
    `source`, along the direction from that source: -(1/2) Re(conj(other) source slope), from the slope of
    `slope_per_force` (1/N).

    For forces in phase, both points receive the same force. With a phase difference they do not, since waves carry
    momentum away. [oza2023].
    """
    return -0.5 * float((other.conjugate() * source * slope).real)


def steepness(force: float, waves: Ripples) -> Number:
    """Wavenumber times amplitude of the wave at one wavelength from a source of this force (N): much less than one for
    waves of small amplitude. [oza2023].
    """
    height = abs(complex(surface_per_force(np.array([waves.wavelength]), waves)[0]))
    return force * height * 2.0 * math.pi / waves.wavelength


def struve_minus_bessel(z: Any) -> Complexes:
    """Difference H_0(z) - Y_0(z) of Struve's function and Bessel's of the second kind, for complex z, not on the
    negative real axis. [abramowitz1964, 12.1.8, 9.1.35].

    For Re z > 0 it is (2/pi) int_0^inf e^(-z t)/sqrt(1 + t^2) dt, along a ray on which the integrand decays. On the
    left, H_0(-w) = -H_0(w), and the continuation of Y_0 adds a Hankel function.

    >>> round(float(struve_minus_bessel(1.0).real), 9)
    0.480399663
    """
    given = np.asarray(z, dtype=np.complex128)
    left, right = given.real < 0.0, np.where(given.real < 0.0, -given, given)
    found = _laplace(right, 0)
    return np.asarray(np.where(left, -found + _beyond(given, 0), found))


def slope_of_struve_minus_bessel(z: Any) -> Complexes:
    """Derivative 2/pi - H_1(z) + Y_1(z) of `struve_minus_bessel`, without cancellation at large z. [abramowitz1964,
    12.1.8, 12.1.11].

    >>> round(float(slope_of_struve_minus_bessel(1.0).real), 9)
    -0.343050385
    """
    given = np.asarray(z, dtype=np.complex128)
    left, right = given.real < 0.0, np.where(given.real < 0.0, -given, given)
    return np.asarray(np.where(left, _beyond(given, 1), 0.0) - _laplace(right, 1))


def _beyond(z: Complexes, order: int) -> Complexes:
    """The term of the continuation across the imaginary axis: -2i H^(2)(-z) above the real axis and
    2i H^(1)(-z) below.
    """
    from scipy.special import hankel1, hankel2

    w = np.where(z.real < 0.0, -z, 1.0)
    return np.asarray(np.where(z.imag > 0.0, -2j * hankel2(order, w), 2j * hankel1(order, w)))


def _laplace(z: Complexes, power: int) -> Complexes:
    """The integral (2/pi) int_0^inf t^power e^(-z t)/sqrt(1 + t^2) dt for Re z > 0, with t = s e^(-i arg z / 2) and s =
    e^(u - e^-u), by the trapezoidal rule.
    """
    turn = np.exp(-0.5j * np.angle(z))[..., None]
    end = 1.0 + np.log1p(LAST / np.abs(z))[..., None]
    u = FIRST + (end - FIRST) * np.linspace(0.0, 1.0, NODES)
    s = np.exp(u - np.exp(-u))
    t = s * turn
    values = t**power * np.exp(-z[..., None] * t) / np.sqrt(1.0 + t * t) * turn * s * (1.0 + np.exp(-u))
    return np.asarray(2.0 / math.pi * np.sum(values, axis=-1) * (end[..., 0] - FIRST) / (NODES - 1))
