"""Wendland's kernels on a line: in one dimension positive definite functions of the same smoothness have a lower
degree, and so a shape of their own [wendland1995, dehnen2012].
"""

from __future__ import annotations

from ecume.laws.kernels.shapes import Pure, positive
from ecume.units import Value


def wendland_c2_line_value(q: Pure[Value]) -> Pure[Value]:
    """(1-q/2)^3 (1+3q/2), support 2. [dehnen2012].

    >>> wendland_c2_line_value(1.0)
    0.3125
    """
    left = positive(1.0 - 0.5 * q)
    return (left * left * left) * (1.0 + 1.5 * q)


def wendland_c2_line_slope(q: Pure[Value]) -> Pure[Value]:
    """f'(q)/q of Wendland's C2 on a line, -3 (1-q/2)^2. [dehnen2012].

    >>> wendland_c2_line_slope(1.0)
    -0.75
    """
    left = positive(1.0 - 0.5 * q)
    return -3.0 * (left * left)


def wendland_c4_line_value(q: Pure[Value]) -> Pure[Value]:
    """(1-q/2)^5 (1 + 5q/2 + 2q^2), support 2. [dehnen2012].

    >>> wendland_c4_line_value(0.0)
    1.0
    """
    left = positive(1.0 - 0.5 * q)
    return (left * left) * (left * left) * left * (1.0 + q * (2.5 + 2.0 * q))


def wendland_c4_line_slope(q: Pure[Value]) -> Pure[Value]:
    """f'(q)/q of Wendland's C4 on a line, -(7/2)(1+2q)(1-q/2)^4. [dehnen2012].

    >>> wendland_c4_line_slope(0.0)
    -3.5
    """
    left = positive(1.0 - 0.5 * q)
    return -3.5 * (1.0 + 2.0 * q) * (left * left) * (left * left)


def wendland_c6_line_value(q: Pure[Value]) -> Pure[Value]:
    """(1-q/2)^7 (1 + 7q/2 + 19q^2/4 + 21q^3/8), support 2. [dehnen2012].

    >>> wendland_c6_line_value(0.0)
    1.0
    """
    left = positive(1.0 - 0.5 * q)
    cube = left * left * left
    return (cube * cube) * left * (1.0 + q * (3.5 + q * (4.75 + 2.625 * q)))


def wendland_c6_line_slope(q: Pure[Value]) -> Pure[Value]:
    """f'(q)/q of Wendland's C6 on a line, -(9/2 + 27q/2 + 105q^2/8)(1-q/2)^6. [dehnen2012].

    >>> wendland_c6_line_slope(0.0)
    -4.5
    """
    left = positive(1.0 - 0.5 * q)
    cube = left * left * left
    return -(4.5 + q * (13.5 + 13.125 * q)) * (cube * cube)
