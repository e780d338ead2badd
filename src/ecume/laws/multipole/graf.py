"""What bodies send to one another: multipoles of one, seen around another, by Graf's addition theorem [watson1944].

K_m(r_j) exp(i m phi_j) = sum over n of (-1)^n K_{m-n}(d) exp(i (m-n) beta) I_n(r_i) exp(i n phi_i), with (d, beta) the
place of i as seen from j. In the frame of the pair real and imaginary parts part, and all is real. Amplitudes are
rings' values, alpha_m = A_m K_m(a) and c_m = C_m I_m(a), m >= 0 (-m has the conjugate): matrices are then of
one size, and the exponentials of the scaled functions combine to exp(-gap). Mirror images in plane walls are further
sources. Positions are in capillary lengths. Compiled.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume import _jit
from ecume._jit import compiled
from ecume.laws import special
from ecume.laws.multipole import ladders
from ecume.laws.multipole.closures import Closure
from ecume.laws.multipole.ladders import outgoing_ladder, regular_ladder
from ecume.units import Array

_jit.admit(special, ladders)

Waves = NDArray[np.complex128]
"""(N, order + 1) amplitudes."""
NEGLIGIBLE = math.log(1e-17)
"""Pairs of orders whose product is below this fraction are ignored, the same for both of a pair of bodies."""


class Rims(NamedTuple):
    """Bodies, as sums over them want it; nothing here changes while they move."""

    radius: Array
    """(N,)"""
    response: Array
    """(N, order + 1)"""
    source: Waves
    regular: Array
    """(N, order + 2) ladder of I at the ring"""
    inverse: Array
    """(N, order + 1) one over the ladder of K at the ring"""
    straight: Array
    """(order + 2, order + 1) (n + m)!/(n! m!)"""
    crossed: Array
    """(order + 2, order + 1) |n - m|!/(n! m!) (s/2)^(2 min(n, m))"""
    reference: float
    """s"""
    range: float
    """gaps farther than this are not felt"""


def make_rims(closures: list[Closure], reach: float, number: NDArray[np.int64] | None = None) -> Rims:
    """Stack the closures of all bodies, all of one order; `number`: that of each body, when many have the same."""
    radius = np.array([closure.radius for closure in closures])
    chosen = np.arange(len(radius)) if number is None else np.asarray(number)
    order = len(closures[0].response) - 1
    reference = float(np.exp(np.mean(np.log(radius[chosen]))))
    regular, outgoing = np.zeros((len(radius), order + 2)), np.zeros((len(radius), order + 2))
    for i, a in enumerate(radius):
        regular_ladder(float(a), reference, regular[i])
        outgoing_ladder(float(a), reference, outgoing[i])
    n, m = np.meshgrid(np.arange(order + 2), np.arange(order + 1), indexing="ij")
    logs = np.array([math.lgamma(k + 1.0) for k in range(2 * order + 3)])
    straight = np.exp(logs[n + m] - logs[n] - logs[m])
    power = 2.0 * np.minimum(n, m) * math.log(0.5 * reference)
    crossed = np.exp(np.maximum(logs[np.abs(n - m)] - logs[n] - logs[m] + power, -700.0))
    return Rims(
        radius=radius[chosen],
        response=np.array([closure.response for closure in closures])[chosen],
        source=np.array([closure.source for closure in closures])[chosen],
        regular=regular[chosen],
        inverse=(1.0 / outgoing[:, : order + 1])[chosen],
        straight=straight,
        crossed=crossed,
        reference=reference,
        range=reach,
    )


@compiled
def receive(rims: Rims, pair: tuple[int, int], place: Array, turned: Waves, scratch: Array, waves: Waves) -> None:
    """Add to `waves` (of body i) what the body j sends, which is seen at place = (x_i - x_j, y_i - y_j).

    `turned` are the amplitudes of j (scratch: they are turned into the frame of the pair).
    """
    i, j = pair
    x, y = place[0], place[1]
    distance = math.sqrt(x * x + y * y)
    gap = distance - rims.radius[i] - rims.radius[j]
    if gap > rims.range:
        return
    orders, wanted = len(turned), len(waves)
    # Zero, too, where the gap is that of rounding: then no order is negligible.
    falls = math.log((rims.radius[i] + rims.radius[j]) / distance)
    most = int(NEGLIGIBLE / falls) if falls < 0.0 else 2 * orders
    most = max(4, min(most, 2 * orders))
    outgoing_ladder(distance, rims.reference, scratch[: min(most, wanted + orders) + 1])
    turn = complex(x / distance, y / distance)
    phase = complex(1.0, 0.0)
    inverse, straight, crossed, regular = rims.inverse[j], rims.straight, rims.crossed, rims.regular[i]
    for m in range(orders):
        turned[m] *= phase * inverse[m]
        phase *= turn
    strength = math.exp(-gap)
    phase = complex(strength, 0.0)
    for n in range(min(wanted, most + 1)):
        real, imaginary = turned[0].real * scratch[n], 0.0
        for m in range(1, min(orders, most - n + 1)):
            along = straight[n, m] * scratch[n + m]
            against = crossed[n, m] * scratch[abs(n - m)]
            real += turned[m].real * (against + along)
            imaginary += turned[m].imag * (against - along)
        waves[n] += phase * regular[n] * complex(real, imaginary)
        # (-1)^n exp(-i n beta)
        phase *= -turn.conjugate()


@compiled
def sent(amplitudes: Waves, mirror: Array, turned: Waves) -> None:
    """The amplitudes of a body's image: phi -> pi - phi and phi -> -phi conjugate them, the former with (-1)^m."""
    across, along = mirror[0] < 0.0, mirror[2] < 0.0
    for m in range(len(amplitudes)):
        wave = amplitudes[m] if across == along else amplitudes[m].conjugate()
        turned[m] = mirror[4] * (-wave if across and m % 2 == 1 else wave)


@compiled
def receive_all(rims: Rims, mirrors: Array, position: Array, amplitudes: Waves, waves: Waves) -> None:
    """Fill waves (N, order + 1 or order + 2) with what reaches each body from all others and all images."""
    count, orders = amplitudes.shape
    turned, scratch, place = np.zeros(orders, np.complex128), np.zeros(2 * orders + 3), np.zeros(2)
    waves[:] = 0.0
    for i in range(count):
        for t in range(len(mirrors)):
            mirror = mirrors[t]
            for j in range(count):
                if t == 0 and j == i:
                    continue
                place[0] = position[i, 0] - mirror[0] * position[j, 0] - mirror[1]
                place[1] = position[i, 1] - mirror[2] * position[j, 1] - mirror[3]
                sent(amplitudes[j], mirror, turned)
                receive(rims, (i, j), place, turned, scratch, waves[i])


@compiled
def forces(rims: Rims, amplitudes: Waves, waves: Waves, force: Array) -> None:
    """F_x + i F_y = 2 pi sum over m of A_m C_{-m-1}, m from -order to order, in gamma L: exact, from the contour
    integral of the surface's stress around a body. `waves` has order + 2 columns.
    """
    orders = amplitudes.shape[1]
    inverse, regular = rims.inverse, rims.regular
    for i in range(len(force)):
        total = complex(0.0, 0.0)
        for m in range(orders):
            # A_m C_{m+1}*, with the ladders' factors (s/2)^m/m! and (2/s)^(m+1) (m+1)!
            share = inverse[i, m] / regular[i, m + 1] * 2.0 / rims.reference * (m + 1.0)
            total += share * amplitudes[i, m] * waves[i, m + 1].conjugate()
        for m in range(1, orders):
            share = inverse[i, m] / regular[i, m - 1] * 0.5 * rims.reference / m
            total += share * amplitudes[i, m].conjugate() * waves[i, m - 1]
        # The ladders hold exp(a) K and exp(-a) I: their product is as it stands.
        force[i, 0], force[i, 1] = 2.0 * math.pi * total.real, 2.0 * math.pi * total.imag


@compiled
def torques(rims: Rims, amplitudes: Waves, waves: Waves, torque: Array) -> None:
    """About the vertical axis, in gamma L^2: 4 pi sum over m of m Im(A_m C_m*); none on a round body without source."""
    for i in range(len(torque)):
        total = 0.0
        for m in range(1, amplitudes.shape[1]):
            share = rims.inverse[i, m] / rims.regular[i, m] * m
            total += share * (amplitudes[i, m] * waves[i, m].conjugate()).imag
        torque[i] = 4.0 * math.pi * total


@compiled
def energy(rims: Rims, amplitudes: Waves, waves: Waves, outer: Waves) -> float:
    """-pi sum over i and m of Re(S_m* C_m + A_m* C_m^outer): what the bodies have beyond their energies alone.

    m from -order to order. `outer` is the part of the waves that comes from the walls' own menisci.
    """
    total = 0.0
    for i in range(len(amplitudes)):
        for m in range(amplitudes.shape[1]):
            share = (1.0 if m == 0 else 2.0) * rims.inverse[i, m] / rims.regular[i, m]
            both = rims.source[i, m].conjugate() * waves[i, m] + amplitudes[i, m].conjugate() * outer[i, m]
            total += share * both.real
    return -math.pi * total
