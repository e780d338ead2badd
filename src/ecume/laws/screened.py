"""K1 for a loop over many pairs: without branches and library calls, so that the loop vectorizes."""

from __future__ import annotations

import math
from typing import NamedTuple

from ecume._fused import fused
from ecume.units import Number

DEGREE = 16
FARTHEST = 25.0
"""The argument up to which `decay` is accurate."""
SHIFTS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.0)
HALVINGS = 32.0
HALF_PI = 0.5 * math.pi
"""A name, since a loop in single precision takes only names and literals of this module in single precision."""


class ScreenedFit(NamedTuple):
    """K1 on [lower, upper]: a polynomial of degree 16 in s = slope / (x + shift) - offset, which runs from -1 to 1."""

    lower: float
    upper: float
    shift: float
    slope: float
    offset: float
    origin: float
    """where the exponential is 1: the weights contain exp(-origin)"""
    weights: tuple[float, ...]
    error: float


def fit_k1(lower: float, upper: float) -> ScreenedFit:
    """Fit K1 on [lower, upper] (in capillary lengths) and measure the fit's largest relative error.

    K1(x) = exp(-x) sqrt(1 + pi x / 2) / x * Q(s), where Q stays between 0.8 and 1.1: 1/x is K1's pole, and the root its
    tail. Q is a polynomial in s, a shifted and scaled 1/(x + c); the best c depends on how close pairs come. The error
    is at most 2e-7, however close they come, and 1e-14 where they stay a capillary length apart. If `upper` is above
    25, `decay` adds its error at the distance from the middle of the interval: 1e-5 at the ends for upper = 100.

    >>> fit_k1(0.2, 10.0).error < 1e-9
    True
    """
    return min((_fit(lower, upper, shift) for shift in SHIFTS), key=lambda fit: fit.error)


def _fit(lower: float, upper: float, shift: float) -> ScreenedFit:
    import numpy as np
    from numpy.polynomial import chebyshev, polynomial
    from scipy.special import k1e

    bounds = 1 / (upper + shift), 1 / (lower + shift)
    middle, half = (bounds[0] + bounds[1]) / 2, (bounds[1] - bounds[0]) / 2

    def wanted(x: np.ndarray) -> np.ndarray:
        ratio: np.ndarray = x * k1e(x) / np.sqrt(1 + np.pi / 2 * x)
        return ratio

    nodes = np.cos(np.pi * (np.arange(120) + 0.5) / 120)
    values = wanted(1 / (middle + half * nodes) - shift)
    weights = chebyshev.cheb2poly(chebyshev.chebfit(nodes, values, DEGREE, w=1 / values))
    x = np.geomspace(lower, upper, 4001)
    fitted = polynomial.polyval((1 / (x + shift) - middle) / half, weights)
    error = float(np.max(np.abs(fitted / wanted(x) - 1)))
    origin = 0.5 * (lower + upper) if upper > FARTHEST else 0.0
    scaled = tuple(float(w) for w in weights * math.exp(-origin))
    return ScreenedFit(lower, upper, shift, 1 / half, middle / half, origin, scaled, error)


def decay(x: Number) -> Number:
    """exp(-x) for |x| <= 25: the 32nd power of a short series. Its relative error is below 1e-12 up to |x| = 12, and
    grows to 1e-8 at 25 and 6e-5 at 50.

    >>> abs(decay(12.0) / math.exp(-12.0) - 1) < 1e-12 < abs(decay(25.0) / math.exp(-25.0) - 1) < 1e-8
    True
    """
    y = -x / HALVINGS
    q = fused(fused(fused(y, 1 / 39916800, 1 / 3628800), y, 1 / 362880), y, 1 / 40320)
    q = fused(fused(fused(q, y, 1 / 5040), y, 1 / 720), y, 1 / 120)
    q = fused(fused(fused(q, y, 1 / 24), y, 1 / 6), y, 1 / 2)
    series = fused(fused(q, y, 1.0), y, 1.0)
    power2 = series * series
    power4 = power2 * power2
    power8 = power4 * power4
    power16 = power8 * power8
    return power16 * power16


def k1_over_x(x_squared: Number, fit: ScreenedFit) -> Number:
    """K1(x) / x from the square of x, within `fit.error` on [fit.lower, fit.upper]; below, as at fit.lower.

    That is what a pair force needs: F times the direction is proportional to K1(x)/x times the displacement. One
    division and two roots; the bound keeps an overlapping pair from a force without limit.
    """
    x_squared = max(x_squared, fit.lower * fit.lower)
    x = math.sqrt(x_squared)
    shifted = x + fit.shift
    inverse = 1.0 / (x_squared * shifted)
    s = fused(x_squared * inverse, fit.slope, -fit.offset)
    w = fit.weights
    q = fused(fused(fused(w[16], s, w[15]), s, w[14]), s, w[13])
    q = fused(fused(fused(q, s, w[12]), s, w[11]), s, w[10])
    q = fused(fused(fused(q, s, w[9]), s, w[8]), s, w[7])
    q = fused(fused(fused(q, s, w[6]), s, w[5]), s, w[4])
    q = fused(fused(fused(q, s, w[3]), s, w[2]), s, w[1])
    q = fused(q, s, w[0])
    return decay(x - fit.origin) * math.sqrt(fused(HALF_PI, x, 1.0)) * (shifted * inverse) * q
