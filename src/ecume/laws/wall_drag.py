"""Drag of a sphere near a plane wall: exact series, and a table of mobilities for compiled code.

The factors are the friction over Stokes's 6 pi eta a, for a sphere that moves along the wall and rotates freely, and
for one that moves toward it. Mobilities are their inverses, and diffusion coefficients those times the one far from
walls.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Literal, NamedTuple

import numpy as np

from ecume.units import Array, Length, Number

DECAY = 30.0
"""Exponents of the last terms of a series."""
CLOSEST, FARTHEST = 1e-5, 1e4
"""Gaps of the table, over the radius."""
NODES = 700
"""Of the table, in equal steps of the logarithm of the gap."""


def perpendicular_factor(gap: Length, radius: Length) -> Number:
    """The drag toward or away from a wall over Stokes's; 1 + 9 a/(8 h) far away, a/gap near contact.

    (4/3) sinh(c) sum_n n(n+1)/[(2n-1)(2n+3)] {[2 sinh((2n+1)c) + (2n+1) sinh(2c)]/[4 sinh^2((n+1/2)c) - (2n+1)^2
    sinh^2(c)] - 1}, cosh(c) = h/a; h: the distance of the center. [brenner1961].

    >>> round(perpendicular_factor(0.5431, 1.0), 4)
    3.036
    """
    c = math.acosh(1.0 + gap / radius)
    n = np.arange(1.0, math.ceil(DECAY / c) + 3.0)
    odd = 2.0 * n + 1.0
    shrunk = np.exp(-odd * c)  # over exp((2n+1) c), which would overflow
    top = 1.0 - shrunk * shrunk + odd * math.sinh(2.0 * c) * shrunk
    bottom = (1.0 - shrunk) ** 2 - (odd * math.sinh(c)) ** 2 * shrunk
    terms = n * (n + 1.0) / ((odd - 2.0) * (odd + 2.0)) * (top / bottom - 1.0)
    return 4.0 / 3.0 * math.sinh(c) * float(terms.sum())


def parallel_factor(gap: Length, radius: Length) -> Number:
    """The drag along a wall over Stokes's, for a sphere that rotates freely: F - (3/4) C^2/T.

    F: the drag of a sphere that does not rotate [oneill1964]; T: the torque on one that rotates, over 8 pi eta a^3 per
    angular velocity; C: the force on it, over 6 pi eta a^2 [dean1963]. Far away it is 1 + 9 a/(16 h) [goldman1967].

    >>> round(parallel_factor(0.5431, 1.0), 4)
    1.5672
    """
    c = math.acosh(1.0 + gap / radius)
    force, coupling = _force(c, "moving"), _force(c, "turning")
    return force - 0.75 * coupling * coupling / _torque(c)


Way = Literal["moving", "turning"]


class Coefficients(NamedTuple):
    """The coefficients of the flow's harmonic functions in bispherical coordinates, for n = 0, 1, ..."""

    n: Array
    a: Array
    b: Array
    c: Array
    d: Array
    e: Array
    f: Array
    g: Array


def _force(c: float, way: Way) -> float:
    """The force along the wall. [oneill1964; dean1963]."""
    found = coefficients(c, way)
    scale = math.sinh(c) if way == "moving" else -(math.sinh(c) ** 2)
    return math.sqrt(2.0) / 6.0 * scale * float((found.e + found.n * (found.n + 1.0) * found.c).sum())


def _torque(c: float) -> float:
    """The torque on a sphere that rotates about an axis parallel to the wall. [dean1963]."""
    k, cotangent = coefficients(c, "turning"), 1.0 / math.tanh(c)
    shrunk, order, odd = np.exp(-(2.0 * k.n + 1.0) * c), k.n * (k.n + 1.0), 2.0 * k.n + 1.0 - cotangent
    terms = (2.0 + shrunk) * (order * (2.0 * k.a + k.c * cotangent) - odd * k.e)
    terms += (2.0 - shrunk) * (order * k.b * cotangent - odd * k.d)
    return (1.0 - float(terms.sum()) * math.sinh(c) ** 3 / (4.0 * math.sqrt(2.0))) / 3.0


def coefficients(c: float, way: Way) -> Coefficients:
    """The solution of O'Neill's tridiagonal equations for a sphere whose center is cosh(c) radii from the wall.

    With x, r and z in units of a sinh(c): pressure eta U Q cos(phi)/a sinh(c), velocities U/2 (r Q + U2 + U0) cos(phi),
    U/2 (U2 - U0) sin(phi) and U/2 (z Q + 2 W) cos(phi), where W, Q, U0 and U2 are sums with the coefficients A; B, C;
    D, E; F, G. [oneill1964].
    """
    from scipy.linalg import solve_banded

    count = math.ceil(DECAY / c) + 10
    n = np.arange(count + 2.0)
    k = (n + 0.5) / np.tanh((n + 0.5) * c) - 1.0 / math.tanh(c)
    m, root = n[1:-1], math.sqrt(2.0)
    before, after = (2.0 * m - 1.0) * k[:-2] - (2.0 * m - 3.0) * k[1:-1], (2.0 * m + 5.0) * k[1:-1]
    after -= (2.0 * m + 3.0) * k[2:]
    right = _drive(m, c, way)
    bands = np.zeros((3, count))
    bands[0, 1:] = (after * (m + 2.0) / (2.0 * m + 3.0))[:-1]
    bands[1] = -(before * m + after * (m + 1.0)) / (2.0 * m + 1.0)
    bands[2, :-1] = (before * (m - 1.0) / (2.0 * m - 1.0))[1:]
    padded = np.zeros(count + 3)
    padded[2:-1] = solve_banded((1, 1), bands, right)
    lower, here, upper, n, k = padded[:-2], padded[1:-1], padded[2:], n[:-1], k[:-1]
    b = (n - 1.0) * lower - (2.0 * n + 1.0) * here + (n + 2.0) * upper
    cs = -2.0 * k * ((n - 1.0) / (2.0 * n - 1.0) * lower - here + (n + 2.0) / (2.0 * n + 3.0) * upper)
    d = 0.5 * ((n + 1.0) * (n + 2.0) * upper - (n - 1.0) * n * lower)
    e = k * (n * (n - 1.0) / (2.0 * n - 1.0) * lower - (n + 1.0) * (n + 2.0) / (2.0 * n + 3.0) * upper)
    f, g = 0.5 * (lower - upper), -k * (lower / (2.0 * n - 1.0) - upper / (2.0 * n + 3.0))
    shrunk, rise = np.exp(-(n + 0.5) * c), 1.0 / np.sinh((n + 0.5) * c)
    if way == "moving":
        e += 2.0 * root * shrunk * rise
    else:
        part = -(np.exp(-(n - 0.5) * c) / (2.0 * n - 1.0) - np.exp(-(n + 1.5) * c) / (2.0 * n + 3.0)) / root
        e += (root * (2.0 * n + 1.0) * shrunk - part / math.sinh(c)) * rise
        cs += 4.0 * part * rise / math.sinh(c)
    b[0], cs[0] = 0.0, 0.0
    return Coefficients(n, here, b, cs, d, e, f, g)


def _drive(m: Array, c: float, way: Way) -> Array:
    """The right-hand side of the tridiagonal equations. [oneill1964; dean1963]."""

    def cotangent(x: Array) -> Array:
        return np.asarray(1.0 / np.tanh(x * c))

    if way == "moving":
        found = 2.0 * cotangent(m + 0.5) - cotangent(m - 0.5) - cotangent(m + 1.5)
        return np.asarray(math.sqrt(2.0) * found)
    both = math.exp(c) / (2.0 * m - 1.0) + math.exp(-c) / (2.0 * m + 3.0)
    found = (2.0 * m + 1.0) ** 2 * both / np.sinh((m + 0.5) * c) - (2.0 * m - 1.0) / np.sinh((m - 0.5) * c)
    found -= (2.0 * m + 3.0) / np.sinh((m + 1.5) * c)
    return np.asarray(-math.sqrt(2.0) * np.exp(-(m + 0.5) * c) / (2.0 * m + 1.0) / math.sinh(c) * found)


@cache
def mobility_table() -> Array:
    """The mobility (NODES, 2) along a wall, and that toward it over gap/(gap + a), which is 1 at contact and far away.

    The gaps are CLOSEST to FARTHEST radii, in equal steps of their logarithm.
    """
    rows = np.empty((NODES, 2))
    for row, gap in zip(rows, np.geomspace(CLOSEST, FARTHEST, NODES).tolist(), strict=True):
        row[:] = 1.0 / parallel_factor(gap, 1.0), (1.0 + gap) / gap / perpendicular_factor(gap, 1.0)
    return rows


def wall_mobilities(gap: Length, radius: Length, table: Array) -> tuple[Number, Number]:
    """Mobilities of a sphere along a wall and toward it, relative to that far from walls, by cubic interpolation in the
    table.

    Below its first gap the friction along the wall grows by (1/2) ln(1/gap), and that toward it as 1/gap
    [goldman1967].
    """
    ratio = max(gap, 1e-300) / radius
    place = math.log(ratio / CLOSEST) * (len(table) - 1) / math.log(FARTHEST / CLOSEST)
    if place >= len(table) - 1:
        return 1.0, 1.0
    if place < 0.0:
        return 1.0 / (1.0 / table[0, 0] - 0.5 * math.log(ratio / CLOSEST)), table[0, 1] * ratio / (1.0 + ratio)
    k = min(max(int(place), 1), len(table) - 3)
    t = place - k
    # Lagrange's cubic through the nodes -1, 0, 1 and 2.
    a, b = -t * (t - 1.0) * (t - 2.0) / 6.0, (t * t - 1.0) * (t - 2.0) / 2.0
    c, d = -t * (t + 1.0) * (t - 2.0) / 2.0, t * (t * t - 1.0) / 6.0
    along = a * table[k - 1, 0] + b * table[k, 0] + c * table[k + 1, 0] + d * table[k + 2, 0]
    toward = a * table[k - 1, 1] + b * table[k, 1] + c * table[k + 1, 1] + d * table[k + 2, 1]
    return along, toward * ratio / (1.0 + ratio)
