"""Bessel functions of all orders at once, scaled so that none overflows, whatever the order.

K_m(x) grows like (m-1)!/2 (2/x)^m and I_m(x) falls like (x/2)^m/m!. With a reference length s the ladders hold
k_m = exp(x) K_m(x) (s/2)^m / m!  and  i_m = exp(-x) I_m(x) (2/s)^m m!, which are of order one where x is near s.
Plain loops: compiled code calls them as they stand. [watson1944].
"""

from __future__ import annotations

import math

import numpy as np

from ecume.laws.special import scaled_bessel_k0, scaled_bessel_k1
from ecume.units import Array, Number

MOST_TERMS = 4000
TINY = 1e-280


def outgoing_ladder(x: Number, reference: Number, values: Array) -> None:
    """Fill `values` with k_0, k_1, ... at x: K_{m+1} = K_{m-1} + (2 m/x) K_m, which is stable upwards.

    >>> values = np.zeros(3)
    >>> outgoing_ladder(1.0, 2.0, values)
    >>> np.round(values * math.exp(-1.0) * (1.0, 1.0, 2.0), 9).tolist()       # K_0(1), K_1(1), K_2(1)
    [0.421024438, 0.60190723, 1.624838899]
    """
    values[0] = scaled_bessel_k0(x)
    if len(values) > 1:
        values[1] = scaled_bessel_k1(x) * 0.5 * reference
    near, far = reference / x, 0.25 * reference * reference
    for m in range(1, len(values) - 1):
        values[m + 1] = far / (m * (m + 1.0)) * values[m - 1] + near * m / (m + 1.0) * values[m]


def regular_ladder(x: Number, reference: Number, values: Array) -> None:
    """Fill `values` with i_0, i_1, ... at x: the last two by their power series, whose terms are all positive, the
    others by I_{m-1} = I_{m+1} + (2 m/x) I_m, which is stable downwards.

    >>> values = np.zeros(3)
    >>> regular_ladder(1.0, 2.0, values)
    >>> np.round(values * math.exp(1.0) / (1.0, 1.0, 2.0), 9).tolist()        # I_0(1), I_1(1), I_2(1)
    [1.266065878, 0.565159104, 0.13574767]
    """
    last = len(values) - 1
    highest = math.exp(-x) * (x / reference) ** last
    # Where the last is no longer a number of full precision there is nothing to go down from.
    from_top = highest > TINY and last > 1
    for m in range(last - 1 if from_top else 0, last + 1):
        term, total = 1.0, 1.0
        for k in range(1, MOST_TERMS):
            term *= 0.25 * x * x / (k * (m + k))
            total += term
            if term < 1e-17 * total:
                break
        values[m] = math.exp(-x) * (x / reference) ** m * total
    if from_top:
        near, far = reference / x, 0.25 * reference * reference
        for m in range(last - 1, 0, -1):
            values[m - 1] = far / (m * (m + 1.0)) * values[m + 1] + near * values[m]


def log_slopes(x: Number, order: int) -> tuple[Array, Array]:
    """K_m'(x)/K_m(x) and I_m'(x)/I_m(x) for m = 0 ... order.

    >>> outgoing, regular = log_slopes(1e-3, 2)
    >>> np.round(outgoing * 1e-3, 3).tolist()[1:], np.round(regular * 1e-3, 3).tolist()
    ([-1.0, -2.0], [0.0, 1.0, 2.0])
    """
    k, i = np.zeros(order + 2), np.zeros(order + 2)
    outgoing_ladder(x, x, k)
    regular_ladder(x, x, i)
    m = np.arange(order + 1.0)
    outgoing, regular = np.zeros(order + 1), np.zeros(order + 1)
    # K_m' = -K_{m-1} - (m/x) K_m and I_m' = I_{m+1} + (m/x) I_m; K_0' = -K_1.
    outgoing[0] = -k[1] / (0.5 * x * k[0])
    outgoing[1:] = -k[:-2] * 0.5 * x / (m[1:] * k[1:-1]) - m[1:] / x
    regular[:] = i[1:] * 0.5 * x / ((m + 1.0) * i[:-1]) + m / x
    return outgoing, regular
