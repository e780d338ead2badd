"""Menisci by the full Young–Laplace equation: at a straight contact line, and around a floating body.

Lengths are in L. The surface at a straight line is two-dimensional, and its solution is exact.

In lengths of L, with s the arc length, psi the surface's slope angle, z its height: dr/ds = cos psi, dz/ds = sin psi,
dpsi/ds = z - sin(psi)/r [vella2005]. Two changes of variables make the problem smooth. With psi = a K1(r) and z = -b
K0(r) a shallow meniscus has constant a = b, so only the nonlinear part has to be resolved; far away both are the
capillary charge. The second variable q = r + ln r obeys dq/dtau = cos psi, where ds = r/(1+r) dtau, so that one unit of
tau is a factor e in r near the body and one L far away. Chebyshev collocation in tau then gives ten digits with 40
nodes. Newton's method converges from the linear solution, also beyond vertical slopes.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from ecume.units import Angle, Array, Number


def sloping_height(slope_angle: Angle) -> Number:
    """Height of a straight contact line with a slope angle, z = -2 sin(psi/2).

    psi is positive if the surface rises away from the line, whose height is then negative. [landau1987, par. 61].

    >>> round(sloping_height(-math.radians(60.0)), 12)
    1.0
    """
    return -2.0 * math.sin(0.5 * slope_angle)


def sloping_amplitude(slope_angle: Angle) -> Number:
    """Amplitude of exp(-x) far from a straight contact line, with x from that line and the sign of
    the height.

    4 exp(-2 - u + 2 tanh u) with u = arccosh(2/|z|); valid also beyond the vertical, where x first decreases. Derived
    from
    [landau1987, par. 61].

    >>> round(sloping_amplitude(-math.pi / 2), 12)
    0.922317584014
    """
    height = sloping_height(slope_angle)
    if height == 0.0:
        return 0.0
    u = math.acosh(2.0 / abs(height))
    return math.copysign(4.0 * math.exp(-2.0 - u + 2.0 * math.tanh(u)), height)


NODES = 40
REACH = 13.0
"""The distance from the contact line, in L, at which the linear tail begins: slopes are below 1e-6, neglected terms
below 1e-12.
"""
ROOM = 1.0
"""Additional length in tau, for the climb of a steep meniscus."""
NUDGE = 1e-7
CLOSE = 1e-7
"""The last correction of Newton's method at convergence; since errors are squared, the remaining
error is negligible.
"""
TURNS = 25
STEEPEST = 2.8
"""The largest slope angle (160 degrees) for which Newton's method converges; floats sink at smaller ones."""


class OuterMeniscus(NamedTuple):
    """The surface outside a contact line, in capillary lengths; `..._change` is the derivative along the requested
    path.
    """

    height: float
    amplitude: float
    height_change: float
    radii: Array
    amplitudes: Array


@cache
def _collocation(nodes: int) -> tuple[Array, Array]:
    """Chebyshev points from -1 to 1 and their differentiation matrix [trefethen2000]."""
    k = np.arange(nodes + 1)
    x = -np.cos(np.pi * k / nodes)
    ends = np.where((k == 0) | (k == nodes), 2.0, 1.0) * (-1.0) ** k
    matrix = np.outer(ends, 1.0 / ends) / (x[:, None] - x[None, :] + np.eye(nodes + 1))
    return x, matrix - np.diag(matrix.sum(axis=1))


def _growth(unknowns: Array, scale: float) -> Array:
    """The derivatives of (a, b, q) with respect to tau, with a and b in units of `scale`."""
    from scipy.special import k0e, k1e, wrightomega

    a, b, q = unknowns
    r = wrightomega(q)
    k1 = k1e(r)
    ratio = k0e(r) / k1
    psi = a * scale * k1 * np.exp(-r)
    cosine = np.cos(psi)
    sine = a * np.sinc(psi / np.pi)
    pace = r / (1.0 + r)
    growth: Array = np.array(
        [pace * (ratio * (a * cosine - b) + (a * cosine - sine) / r), pace * (b * cosine - sine) / ratio, cosine]
    )
    return growth


def _linearized(unknowns: Array, scale: float, half: float) -> tuple[Array, Array]:
    """The residual of the collocated equations, and their Jacobian. `_growth` acts point by point, so that three finite
    differences suffice.
    """
    n = unknowns.shape[1]
    at = np.arange(n)
    _, derivative = _collocation(n - 1)
    nudges = NUDGE * np.abs(unknowns).max(axis=1)
    nudged = np.repeat(unknowns[:, None, :], 4, axis=1)
    nudged[(0, 1, 2), (1, 2, 3)] += nudges[:, None]
    growths = _growth(nudged, scale)
    residual = unknowns @ derivative.T - half * growths[:, 0]
    jacobian = np.zeros((3, n, 3, n))
    for j in range(3):
        change = (growths[:, j + 1] - growths[:, 0]) / nudges[j]
        jacobian[j, :, j, :] = derivative
        for i in range(3):
            jacobian[i, at, j, at] -= half * change[i]
    # Boundary conditions: a and q at the contact line, a = b in the tail.
    residual[0, 0] = residual[2, 0] = 0.0
    residual[1, -1] = unknowns[0, -1] - unknowns[1, -1]
    jacobian[0, 0] = jacobian[1, -1] = jacobian[2, 0] = 0.0
    jacobian[0, 0, 0, 0] = jacobian[1, -1, 0, -1] = jacobian[2, 0, 2, 0] = 1.0
    jacobian[1, -1, 1, -1] = -1.0
    return residual, jacobian.reshape(3 * n, 3 * n)


def _solved(jacobian: Array, right: Array) -> Array:
    """The linear solution, with q eliminated first.

    LAPACK uses threads from 100 unknowns on; on a busy machine, waiting for them takes a hundred times as long as the
    arithmetic.
    """
    n = len(jacobian) // 3
    ab, q = slice(0, 2 * n), slice(2 * n, 3 * n)
    # dq = known - carried @ d(a, b)
    both = np.linalg.solve(jacobian[q, q], np.hstack([jacobian[q, ab], right[q]]))
    carried, known = both[:, : 2 * n], both[:, 2 * n :]
    diagonals = np.concatenate([np.diagonal(jacobian[:n, q]), np.diagonal(jacobian[n : 2 * n, q])])[:, None]
    reduced = jacobian[ab, ab] - diagonals * np.vstack([carried, carried])
    first = np.linalg.solve(reduced, right[ab] - diagonals * np.vstack([known, known]))
    return np.vstack([first, known - carried @ first])


def _newton(unknowns: Array, change: Array, scale: float, half: float) -> tuple[Array, Array]:
    """The solution with the end values of `unknowns`, and its response to a `change` of these values."""
    shape = unknowns.shape
    for _ in range(TURNS):
        residual, jacobian = _linearized(unknowns, scale, half)
        step, response = _solved(jacobian, np.stack([residual.ravel(), change.ravel()], axis=1)).T
        unknowns = unknowns - step.reshape(shape)
        if np.abs(step[: 2 * shape[1]]).max() <= CLOSE * np.abs(unknowns[:2]).max():
            return unknowns, response.reshape(shape)
    raise ArithmeticError(f"the meniscus of a contact line of radius {scale:g} capillary lengths was not found")


def refined(surface: OuterMeniscus, points: int = 401) -> tuple[Array, Array]:
    """Radii and amplitudes of a meniscus at more points than nodes, with equal accuracy, since both are polynomials in
    tau.
    """
    from numpy.polynomial import chebyshev
    from scipy.special import wrightomega

    x, _ = _collocation(len(surface.radii) - 1)
    q, amplitudes = surface.radii + np.log(surface.radii), surface.amplitudes
    weights = chebyshev.chebfit(x, np.stack([q, amplitudes], axis=1), len(x) - 1)
    finer = chebyshev.chebval(-np.cos(np.linspace(0.0, np.pi, points)), weights)
    return np.asarray(wrightomega(finer[0])), finer[1]


def outer_meniscus(radius: Number, slope_angle: Angle, radius_change: Number = 0.0) -> OuterMeniscus:
    """Surface outside a contact line with this radius and slope angle (not zero); positive if it
    rises outward.

    `radius_change` is d(radius)/d(slope_angle), for the derivative of the height. Slope angles up to `STEEPEST`.

    >>> around = outer_meniscus(0.5, 1e-6)
    >>> round(around.height / around.amplitude, 9)       # shallow: -K0(0.5)
    -0.924419071
    """
    from scipy.special import k0, k1, wrightomega

    x, _ = _collocation(NODES)
    k0_here, k1_here = float(k0(radius)), float(k1(radius))
    start = math.log(radius) + radius
    half = 0.5 * (math.log(radius + REACH) + REACH + radius - start + ROOM)
    first = slope_angle / (radius * k1_here)
    flat = np.array([np.full_like(x, first), np.full_like(x, first), start + half * (1.0 + x)])
    # Along the path both conditions at the contact line change: a K1(r) = psi, and q.
    change = np.zeros_like(flat)
    change[0, 0] = first * (1.0 / slope_angle + radius_change * (k0_here / k1_here + 1.0 / radius))
    change[2, 0] = radius_change * (1.0 + 1.0 / radius)
    solution, response = _newton(flat, change, radius, half)
    amplitudes, radii = solution[1] * radius, np.asarray(wrightomega(solution[2]))
    height_change = amplitudes[0] * k1_here * radius_change - response[1, 0] * radius * k0_here
    return OuterMeniscus(
        -float(amplitudes[0]) * k0_here, float(amplitudes[-1]), float(height_change), radii, amplitudes
    )
