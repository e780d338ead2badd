"""Bessel functions of the meniscus: scalars that loops can compile, and a fit of K1 for loops that vectorize.

Near zero the functions are computed by power series, whose coefficients are exact. Beyond, sqrt(x) exp(x) K(x) is the
quotient of two polynomials in 1/x (all coefficients positive: nothing cancels), and sqrt(x) exp(-x) I(x) a Chebyshev
series in 16/x - 1. Both interpolate values with 60 digits at Chebyshev nodes. Relative errors stay below 4e-15 wherever
the value itself is a normal number. Arguments are positive; at zero K has no value, and I0 = 1, I1 = 0.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ecume._fused import fused
from ecume.units import Number

EULER = 0.5772156649015329
SERIES = 2.0
"""The largest argument at which K is computed from its power series."""
WIDE_SERIES = 8.0
"""The largest argument at which I is computed from its power series."""


def _harmonic(k: int) -> float:
    return math.fsum(1 / j for j in range(1, k + 1))


I0_SERIES = tuple(1 / math.factorial(k) ** 2 for k in range(25))
I1_SERIES = tuple(1 / (math.factorial(k) * math.factorial(k + 1)) for k in range(25))
K0_SERIES = tuple((_harmonic(k) - EULER) / math.factorial(k) ** 2 for k in range(13))
K1_SERIES = tuple(
    (_harmonic(k) + _harmonic(k + 1) - 2 * EULER) / (math.factorial(k) * math.factorial(k + 1)) for k in range(13)
)
K0_TOP = (
    1.2533141373155003, 20.715542178062584, 127.63666152207661, 373.8985898754134,
    551.0677766429059, 398.33671281529564, 127.11328729427068, 13.923675383597315,
    0.24348398833067866,
)  # fmt: skip
K0_BOTTOM = (
    1.0, 16.65361127253669, 103.85071052995514, 310.2115361285238,
    472.27050469987375, 361.01440106038234, 127.62517993435682, 17.256765671637147,
    0.5507702159212945,
)  # fmt: skip
K1_TOP = (
    1.2533141373155003, 20.46914790418386, 125.63838509988958, 372.488724355623,
    572.1985582397515, 454.78027379515413, 175.8923018691515, 28.235423187449435,
    1.2244857869128343,
)  # fmt: skip
K1_BOTTOM = (
    1.0, 15.957017085538645, 94.37823380832685, 263.578588435845,
    367.2743519159873, 248.368292194127, 73.07271688152593, 7.184764638075435,
    0.10060944145428853,
)  # fmt: skip
I0_TAIL = (
    0.4022452055070544, 0.0033691164782556943, 6.889758346916825e-05, 2.8913705208347567e-06,
    2.0489185894690638e-07, 2.266668990498178e-08, 3.3962320257083865e-09, 4.94060238822497e-10,
    1.1889147107846439e-11, -3.1499165279632416e-11, -1.3215811840447713e-11, -1.7941785315068062e-12,
    7.180124451383666e-13, 3.8527783827421426e-13, 1.54008621752141e-14, -4.150569347287222e-14,
    -9.554846698828307e-15, 3.8116806693526224e-15, 1.7725601330565263e-15, -3.425485619677219e-16,
    -2.8276239805165836e-16, 3.461222867697461e-17, 4.46562142029676e-17, -4.830504485944182e-18,
    -7.233180487874754e-18,
)  # fmt: skip
I1_TAIL = (
    0.38928811750914005, -0.009761097491361469, -0.00011058893876262371, -3.882564808877691e-06,
    -2.512236237870209e-07, -2.6314688468895196e-08, -3.835380385964237e-09, -5.589743462196584e-10,
    -1.8974958123505413e-11, 3.2526035830154884e-11, 1.4125807436613782e-11, 2.0356285441470896e-12,
    -7.198551776245908e-13, -4.0835511110921974e-13, -2.1015418427726643e-14, 4.272440016711951e-14,
    1.0420276984128802e-14, -3.8144030724370075e-15, -1.8803547755107825e-15, 3.3082023109209285e-16,
    2.96262899764595e-16, -3.209525921993424e-17, -4.6503053684893586e-17, 4.414348323071708e-18,
    7.517296310842105e-18,
)  # fmt: skip


def polynomial(coefficients: tuple[float, ...], x: Number) -> Number:
    """Polynomial c_0 + c_1 x + c_2 x^2 + ...

    >>> polynomial((1.0, 2.0, 3.0), 2.0)
    17.0
    """
    value = 0.0
    for k in range(len(coefficients) - 1, -1, -1):
        value = value * x + coefficients[k]
    return value


def chebyshev(coefficients: tuple[float, ...], x: Number) -> Number:
    """Chebyshev series c_0 + c_1 T_1(x) + c_2 T_2(x) + ..., by Clenshaw's recurrence.

    >>> chebyshev((1.0, 2.0, 3.0), 0.5)
    0.5
    """
    ahead = 0.0
    beyond = 0.0
    for k in range(len(coefficients) - 1, 0, -1):
        ahead, beyond = coefficients[k] + 2.0 * x * ahead - beyond, ahead
    return coefficients[0] + x * ahead - beyond


def bessel_i0(x: Number) -> Number:
    """Modified Bessel function of the first kind, order 0; grows like exp(x) and overflows beyond 713.

    >>> round(bessel_i0(1.0), 12)
    1.266065877752
    """
    if x <= WIDE_SERIES:
        return polynomial(I0_SERIES, 0.25 * x * x)
    return math.exp(x) * _i0_tail(x)


def bessel_i1(x: Number) -> Number:
    """Modified Bessel function of the first kind, order 1; the slope of I0.

    >>> round(bessel_i1(1.0), 12)
    0.565159103992
    """
    if x <= WIDE_SERIES:
        return 0.5 * x * polynomial(I1_SERIES, 0.25 * x * x)
    return math.exp(x) * _i1_tail(x)


def scaled_bessel_i0(x: Number) -> Number:
    """Function exp(-x) I0(x), which never overflows.

    >>> round(scaled_bessel_i0(1e4), 12)
    0.003989472675
    """
    if x <= WIDE_SERIES:
        return math.exp(-x) * polynomial(I0_SERIES, 0.25 * x * x)
    return _i0_tail(x)


def scaled_bessel_i1(x: Number) -> Number:
    """Function exp(-x) I1(x), which never overflows.

    >>> round(scaled_bessel_i1(1e4), 12)
    0.003989273196
    """
    if x <= WIDE_SERIES:
        return math.exp(-x) * 0.5 * x * polynomial(I1_SERIES, 0.25 * x * x)
    return _i1_tail(x)


def bessel_k0(x: Number) -> Number:
    """Modified Bessel function of the second kind, order 0: the height around a point-like floater.

    >>> round(bessel_k0(1.0), 12)
    0.421024438241
    """
    if x <= SERIES:
        return _k0_series(x)
    return math.exp(-x) * _k0_tail(x)


def bessel_k1(x: Number) -> Number:
    """Modified Bessel function of the second kind, order 1: minus the slope of K0.

    >>> round(bessel_k1(1.0), 12)
    0.601907230197
    """
    if x <= SERIES:
        return _k1_series(x)
    return math.exp(-x) * _k1_tail(x)


def scaled_bessel_k0(x: Number) -> Number:
    """Function exp(x) K0(x), which never underflows.

    >>> round(scaled_bessel_k0(1e4), 12)
    0.012532984718
    """
    if x <= SERIES:
        return math.exp(x) * _k0_series(x)
    return _k0_tail(x)


def scaled_bessel_k1(x: Number) -> Number:
    """Function exp(x) K1(x), which never underflows.

    >>> round(scaled_bessel_k1(1e4), 12)
    0.012533611351
    """
    if x <= SERIES:
        return math.exp(x) * _k1_series(x)
    return _k1_tail(x)


def _k0_series(x: Number) -> Number:
    square = 0.25 * x * x
    return polynomial(K0_SERIES, square) - math.log(0.5 * x) * polynomial(I0_SERIES, square)


def _k1_series(x: Number) -> Number:
    square = 0.25 * x * x
    growing = math.log(0.5 * x) * polynomial(I1_SERIES, square)
    return 1.0 / x + 0.5 * x * (growing - 0.5 * polynomial(K1_SERIES, square))


def _k0_tail(x: Number) -> Number:
    return polynomial(K0_TOP, 1.0 / x) / (polynomial(K0_BOTTOM, 1.0 / x) * math.sqrt(x))


def _k1_tail(x: Number) -> Number:
    return polynomial(K1_TOP, 1.0 / x) / (polynomial(K1_BOTTOM, 1.0 / x) * math.sqrt(x))


def _i0_tail(x: Number) -> Number:
    return chebyshev(I0_TAIL, 16.0 / x - 1.0) / math.sqrt(x)


def _i1_tail(x: Number) -> Number:
    return chebyshev(I1_TAIL, 16.0 / x - 1.0) / math.sqrt(x)


BESSEL = {
    "I0": bessel_i0,
    "I1": bessel_i1,
    "K0": bessel_k0,
    "K1": bessel_k1,
    "exp(-x) I0": scaled_bessel_i0,
    "exp(-x) I1": scaled_bessel_i1,
    "exp(x) K0": scaled_bessel_k0,
    "exp(x) K1": scaled_bessel_k1,
}


DEGREE = 16
FARTHEST = 25.0
"""The argument up to which `decay` is accurate."""
SHIFTS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.0)
ENOUGH = 1e-12
"""Errors below this are not distinguished: `decay` has as large a one. Rounding, which depends on the processor, would
otherwise choose among fits with very different constants.
"""
HALVINGS = 32.0
HALF_PI = 0.5 * math.pi
"""A constant, since loops in single precision convert only names and literals of this module."""


class ScreenedFit(NamedTuple):
    """Fit of K1 on [lower, upper]: a polynomial of degree 16 in s = slope / (x + shift) - offset, which runs from -1 to
    1.
    """

    lower: float
    upper: float
    shift: float
    slope: float
    offset: float
    origin: float
    """the argument of the exponential whose factor is 1: the weights contain exp(-origin)"""
    weights: tuple[float, ...]
    error: float


def fit_k1(lower: float, upper: float) -> ScreenedFit:
    """Fit K1 on [lower, upper] (in capillary lengths) and measure the fit's largest relative error.

    K1(x) = exp(-x) sqrt(1 + pi x / 2) / x * Q(s), where Q stays between 0.8 and 1.1: 1/x is K1's pole, and the root its
    tail. Q is a polynomial in s, a shifted and scaled 1/(x + c); the best c depends on how close pairs come. The error
    is at most 2e-7 at any distance, and 1e-12 for pairs that are a capillary length apart. If `upper` is above
    25, `decay` adds its error at the distance from the middle of the interval: 1e-5 at the ends for upper = 100.

    >>> fit_k1(0.2, 10.0).error < 1e-9
    True
    """
    return min((_fit(lower, upper, shift) for shift in SHIFTS), key=lambda fit: max(fit.error, ENOUGH))


def _fit(lower: float, upper: float, shift: float) -> ScreenedFit:
    import numpy as np
    from numpy.polynomial import chebyshev, polynomial
    from scipy.special import k1e

    bounds = 1 / (upper + shift), 1 / (lower + shift)
    middle, half = (bounds[0] + bounds[1]) / 2, (bounds[1] - bounds[0]) / 2

    def function(x: np.ndarray) -> np.ndarray:
        ratio: np.ndarray = x * k1e(x) / np.sqrt(1 + np.pi / 2 * x)
        return ratio

    nodes = np.cos(np.pi * (np.arange(120) + 0.5) / 120)
    values = function(1 / (middle + half * nodes) - shift)
    weights = chebyshev.cheb2poly(chebyshev.chebfit(nodes, values, DEGREE, w=1 / values))
    x = np.geomspace(lower, upper, 4001)
    fitted = polynomial.polyval((1 / (x + shift) - middle) / half, weights)
    error = float(np.max(np.abs(fitted / function(x) - 1)))
    origin = 0.5 * (lower + upper) if upper > FARTHEST else 0.0
    scaled = tuple(float(w) for w in weights * math.exp(-origin))
    return ScreenedFit(lower, upper, shift, 1 / half, middle / half, origin, scaled, error)


def decay(x: Number) -> Number:
    """Exponential exp(-x) for |x| <= 25: the 32nd power of a short series. Its relative error is below 1e-12 up to |x|
    = 12, and grows to 1e-8 at 25 and 6e-5 at 50.

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
    """Ratio K1(x) / x from the square of x, within `fit.error` on [fit.lower, fit.upper]; below, the value at
    fit.lower.

    The pair force is proportional to K1(x)/x times the displacement. One division and two roots; the constant value
    below fit.lower bounds the force on overlapping pairs.
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
