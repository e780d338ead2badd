"""The coupled equations of the multipole amplitudes of bodies and walls, and their solution.

Fields of bodies: the multipoles of one body are expanded around another by Graf's addition theorem [watson1944].
K_m(r_j) exp(i m phi_j) = sum over n of (-1)^n K_{m-n}(d) exp(i (m-n) beta) I_n(r_i) exp(i n phi_i), with (d, beta) the
position of i relative to j. In the frame of the pair real and imaginary parts separate, and the coefficients are real.
Amplitudes are values at the contact lines, alpha_m = A_m K_m(a) and c_m = C_m I_m(a), m >= 0 (-m has the conjugate):
coefficients are then of equal magnitude, and the exponentials of the scaled functions combine to exp(-gap). Mirror
images in plane walls are further sources. Positions are in capillary lengths.

The fields of walls are mirror images in plane walls, and the reflection by a round dish. The field of the bodies,
expanded around the center of the dish as K_p exp(i p theta), is reflected as I_p, with the factor -K_p'/I_p' for a
constant contact angle and -K_p/I_p for a pinned contact line [watson1944].

The amplitudes, alpha = S + T c(alpha), are solved for by elimination for few bodies, by GMRES for many. The response of
a body to itself is in T, so that the matrix is 1 minus the coupling to others: GMRES [saad1986] needs few iterations
unless rims nearly touch, and fewer when it starts from the solution of the previous step. Its criterion is the true
residual, so that a converged solution is not changed at all.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume import _jit
from ecume._jit import compiled
from ecume.laws import special
from ecume.laws.multipole import closures
from ecume.laws.multipole.closures import Closure, outgoing_ladder, regular_ladder
from ecume.units import Array

_jit.admit(special, closures)

Waves = NDArray[np.complex128]
"""(N, order + 1) amplitudes."""
NEGLIGIBLE = math.log(1e-17)
"""Pairs of orders whose product is below this fraction (as a logarithm) are ignored, equally for
both bodies of a pair.
"""


class Rims(NamedTuple):
    """The constants of bodies for sums over them."""

    radius: Array
    """(N,)"""
    response: Array
    """(N, order + 1)"""
    source: Waves
    regular: Array
    """(N, order + 2) ladder of I at the contact line"""
    inverse: Array
    """(N, order + 1) one over the ladder of K at the contact line"""
    straight: Array
    """(order + 2, order + 1) (n + m)!/(n! m!)"""
    crossed: Array
    """(order + 2, order + 1) |n - m|!/(n! m!) (s/2)^(2 min(n, m))"""
    reference: float
    """s"""
    range: float
    """gaps above which interactions are ignored"""


def make_rims(closures: list[Closure], reach: float, number: NDArray[np.int64] | None = None) -> Rims:
    """Combine the closures of all bodies, which have the same order; `number` is the closure of each body, if several
    share one.
    """
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
    """Add to `waves` (of body i) the field of the body j at place = (x_i - x_j, y_i - y_j).

    `turned` are the amplitudes of j; they are overwritten by those in the frame of the pair.
    """
    i, j = pair
    x, y = place[0], place[1]
    distance = math.sqrt(x * x + y * y)
    gap = distance - rims.radius[i] - rims.radius[j]
    if gap > rims.range:
        return
    orders, received = len(turned), len(waves)
    # Also zero for a gap within rounding, for which no order is negligible.
    falls = math.log((rims.radius[i] + rims.radius[j]) / distance)
    most = int(NEGLIGIBLE / falls) if falls < 0.0 else 2 * orders
    most = max(4, min(most, 2 * orders))
    outgoing_ladder(distance, rims.reference, scratch[: min(most, received + orders) + 1])
    turn = complex(x / distance, y / distance)
    phase = complex(1.0, 0.0)
    inverse, straight, crossed, regular = rims.inverse[j], rims.straight, rims.crossed, rims.regular[i]
    for m in range(orders):
        turned[m] *= phase * inverse[m]
        phase *= turn
    strength = math.exp(-gap)
    phase = complex(strength, 0.0)
    for n in range(min(received, most + 1)):
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
    """The amplitudes of the image of a body: phi -> pi - phi and phi -> -phi conjugate them, the former with (-1)^m."""
    across, along = mirror[0] < 0.0, mirror[2] < 0.0
    for m in range(len(amplitudes)):
        wave = amplitudes[m] if across == along else amplitudes[m].conjugate()
        turned[m] = mirror[4] * (-wave if across and m % 2 == 1 else wave)


@compiled
def receive_all(rims: Rims, mirrors: Array, position: Array, amplitudes: Waves, waves: Waves) -> None:
    """Fill waves (N, order + 1 or order + 2) with the field of all other bodies and of all images at each body."""
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
    """Set the forces F_x + i F_y = 2 pi sum over m of A_m C_{-m-1}, m from -order to order, in gamma L: exact, from the
    contour integral of the stress of the surface around a body. `waves` has order + 2 columns.
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
        # The factors exp(a) of K and exp(-a) of I in the ladders cancel in the product.
        force[i, 0], force[i, 1] = 2.0 * math.pi * total.real, 2.0 * math.pi * total.imag


@compiled
def torques(rims: Rims, amplitudes: Waves, waves: Waves, torque: Array) -> None:
    """Set the torques about the vertical axis, in gamma L^2: 4 pi sum over m of m Im(A_m C_m*); zero for round bodies
    without a source.
    """
    for i in range(len(torque)):
        total = 0.0
        for m in range(1, amplitudes.shape[1]):
            share = rims.inverse[i, m] / rims.regular[i, m] * m
            total += share * (amplitudes[i, m] * waves[i, m].conjugate()).imag
        torque[i] = 4.0 * math.pi * total


@compiled
def energy(rims: Rims, amplitudes: Waves, waves: Waves, outer: Waves) -> float:
    """Energy of interaction of the bodies, -pi sum over i and m of Re(S_m* C_m + A_m* C_m^outer).

    m from -order to order. `outer` is the part of the waves that comes from the walls' own menisci.
    """
    total = 0.0
    for i in range(len(amplitudes)):
        for m in range(amplitudes.shape[1]):
            share = (1.0 if m == 0 else 2.0) * rims.inverse[i, m] / rims.regular[i, m]
            both = rims.source[i, m].conjugate() * waves[i, m] + amplitudes[i, m].conjugate() * outer[i, m]
            total += share * both.real
    return -math.pi * total


FAINT = math.log(1e-16)
"""Orders whose contribution is below this fraction (as a logarithm) are ignored."""


class Echoes(NamedTuple):
    """Plane walls as mirrors, and a round wall; in capillary lengths."""

    mirrors: Array
    """(T, 5): x' = m_0 x + m_1, y' = m_2 y + m_3, height times m_4; the first is the identity"""
    brim: float
    """the radius of the round wall"""
    answer: Array
    """(P + 1,) reflection coefficients of the round wall, over p!^2 (2/brim)^(2p) exp(-2 brim); empty without one"""
    near: Array
    """(P + 1, order + 2) p!/(|p - m|! m!) (brim/2)^(|p - m| - p) (s/2)^m"""
    far: Array
    """(P + 1, order + 2) p!/((p + m)! m!) (brim/2)^m (s/2)^m"""


NO_MIRROR = ((1.0, 0.0, 1.0, 0.0, 1.0),)


def make_echoes(mirrors: Array, orders: int, reference: float) -> Echoes:
    """The reflections by plane walls."""
    none = np.zeros((0, orders + 1))
    return Echoes(mirrors, 1.0, np.zeros(0), none, none)


def make_round_echoes(brim: float, waves: int, orders: int, reference: float, pinned: bool) -> Echoes:
    """The reflections by a round wall, up to `waves` orders."""
    k, i = np.zeros(waves + 2), np.zeros(waves + 2)
    outgoing_ladder(brim, brim, k)
    regular_ladder(brim, brim, i)
    p = np.arange(waves + 1.0)
    answer = -k[:-1] / i[:-1]
    if not pinned:
        # K_p' = -K_{p+1} + (p/x) K_p and I_p' = I_{p+1} + (p/x) I_p, in ladders
        rising = 0.5 * brim * i[1:] / (p + 1.0) + p / brim * i[:-1]
        falling = -(p + 1.0) * 2.0 / brim * k[1:] + p / brim * k[:-1]
        answer = -falling / rising
    m = np.arange(orders + 1)
    order, multipole = np.meshgrid(np.arange(waves + 1), m, indexing="ij")
    logs = np.array([math.lgamma(n + 1.0) for n in range(waves + orders + 2)])
    apart = np.abs(order - multipole)
    half, own = math.log(0.5 * brim), multipole * math.log(0.5 * reference)
    near = logs[order] - logs[apart] - logs[multipole] + (apart - order) * half + own
    far = logs[order] - logs[order + multipole] - logs[multipole] + multipole * half + own
    mirrors = np.array(NO_MIRROR)
    return Echoes(mirrors, brim, answer, np.exp(np.maximum(near, -700.0)), np.exp(np.maximum(far, -700.0)))


@compiled
def waves_needed(echoes: Echoes, out: float, radius: float, orders: int) -> int:
    """The number of orders of the round wall that contribute at this distance from the center; it is small except near
    the wall.
    """
    ratio = (out + radius) / echoes.brim
    if ratio >= 1.0:
        return len(echoes.answer)
    return min(len(echoes.answer), int(FAINT / math.log(ratio)) + 2 * orders + 1)


@compiled
def to_the_middle(rims: Rims, echoes: Echoes, j: int, place: Array, amplitudes: Waves, middle: Waves) -> None:
    """Add to `middle` (1, P + 1) the field of the body j, expanded around the center."""
    out = math.sqrt(place[0] ** 2 + place[1] ** 2)
    orders, waves = len(amplitudes), waves_needed(echoes, out, rims.radius[j], len(amplitudes))
    ladder, turned = np.zeros(waves + orders), np.zeros(orders, np.complex128)
    turn = complex(place[0] / out, place[1] / out) if out > 0.0 else complex(1.0, 0.0)
    regular_ladder(out, echoes.brim, ladder)
    phase = complex(math.exp(out + rims.radius[j] - echoes.brim), 0.0)
    for m in range(orders):
        turned[m] = amplitudes[m] * rims.inverse[j, m] * phase
        phase *= turn
    phase = complex(1.0, 0.0)
    for p in range(waves):
        total = turned[0] * ladder[p]
        for m in range(1, orders):
            total += turned[m] * echoes.near[p, m] * ladder[abs(p - m)]
            total += turned[m].conjugate() * echoes.far[p, m] * ladder[p + m]
        middle[0, p] += phase * total
        phase *= turn.conjugate()


@compiled
def from_the_middle(rims: Rims, echoes: Echoes, i: int, place: Array, middle: Waves, waves: Waves) -> None:
    """Add to `waves` of body i the field reflected by the round wall."""
    out = math.sqrt(place[0] ** 2 + place[1] ** 2)
    received, most = len(waves), waves_needed(echoes, out, rims.radius[i], len(waves) - 1)
    ladder = np.zeros(most + received)
    turn = complex(place[0] / out, place[1] / out) if out > 0.0 else complex(1.0, 0.0)
    regular_ladder(out, echoes.brim, ladder)
    back = complex(math.exp(out + rims.radius[i] - echoes.brim), 0.0)
    for k in range(received):
        total, phase = complex(0.0, 0.0), complex(1.0, 0.0)
        for p in range(most):
            wave = echoes.answer[p] * middle[0, p] * phase
            total += wave * echoes.near[p, k] * ladder[abs(p - k)]
            if p > 0:
                total += wave.conjugate() * echoes.far[p, k] * ladder[p + k]
            phase *= turn
        waves[k] += back * rims.regular[i, k] * total
        back *= turn.conjugate()


@compiled
def incoming(rims: Rims, echoes: Echoes, position: Array, amplitudes: Waves, waves: Waves) -> None:
    """Fill waves (N, order + 1 or order + 2) with the field of all other bodies and of the walls at each body."""
    receive_all(rims, echoes.mirrors, position, amplitudes, waves)
    if len(echoes.answer) == 0:
        return
    middle = np.zeros((1, len(echoes.answer)), np.complex128)
    for j in range(len(position)):
        to_the_middle(rims, echoes, j, position[j], amplitudes[j], middle)
    for i in range(len(position)):
        from_the_middle(rims, echoes, i, position[i], middle, waves[i])


@compiled
def echo_heights(rims: Rims, echoes: Echoes, position: Array, amplitudes: Waves, points: Array) -> Array:
    """Add the height (in L) of the field reflected by the round wall at each point (P, 2)."""
    heights, ladder = np.zeros(len(points)), np.zeros(len(echoes.answer))
    middle = np.zeros((1, len(echoes.answer)), np.complex128)
    for j in range(len(position)):
        to_the_middle(rims, echoes, j, position[j], amplitudes[j], middle)
    for k in range(len(points)):
        out = math.sqrt(points[k, 0] ** 2 + points[k, 1] ** 2)
        turn = complex(points[k, 0] / out, points[k, 1] / out) if out > 0.0 else complex(1.0, 0.0)
        regular_ladder(out, echoes.brim, ladder)
        total, phase = 0.0, complex(1.0, 0.0)
        for p in range(len(ladder)):
            wave = echoes.answer[p] * middle[0, p] * phase * ladder[p]
            total += wave.real if p == 0 else 2.0 * wave.real
            phase *= turn
        heights[k] = math.exp(out - echoes.brim) * total
    return heights


TURNS = 40
"""The number of directions that GMRES stores before a restart."""
MOST_ROUNDS = 25


class Krylov(NamedTuple):
    """Scratch arrays of GMRES."""

    basis: Waves
    """(TURNS + 1, N, order + 1)"""
    waves: Waves
    """(N, order + 1)"""
    matrix: Array
    """(TURNS + 1, TURNS), upper triangular after the rotations"""
    rotations: Array
    """(TURNS, 2)"""
    right: Array
    """(TURNS + 1,)"""


def make_krylov(count: int, orders: int) -> Krylov:
    """Scratch arrays for this number of bodies and of amplitudes each."""
    return Krylov(
        np.zeros((TURNS + 1, count, orders), np.complex128),
        np.zeros((count, orders), np.complex128),
        np.zeros((TURNS + 1, TURNS)),
        np.zeros((TURNS, 2)),
        np.zeros(TURNS + 1),
    )


@compiled
def product(a: Waves, b: Waves) -> float:
    """The scalar product of amplitudes, over real and imaginary parts."""
    total = 0.0
    for i in range(a.shape[0]):
        for m in range(a.shape[1]):
            total += a[i, m].real * b[i, m].real + a[i, m].imag * b[i, m].imag
    return total


@compiled
def add(target: Waves, factor: float, other: Waves) -> None:
    """Add a multiple of other amplitudes."""
    for i in range(target.shape[0]):
        for m in range(target.shape[1]):
            target[i, m] += factor * other[i, m]


@compiled
def residual(
    rims: Rims, echoes: Echoes, position: Array, right: Waves, amplitudes: Waves, result: tuple[Waves, Waves]
) -> float:
    """Fill the first of `result` with right - (alpha - T c(alpha)), and return its norm."""
    left, waves = result
    incoming(rims, echoes, position, amplitudes, waves)
    for i in range(left.shape[0]):
        for m in range(left.shape[1]):
            left[i, m] = right[i, m] - amplitudes[i, m] + rims.response[i, m] * waves[i, m]
    return math.sqrt(product(left, left))


@compiled
def rotate(krylov: Krylov, k: int) -> None:
    """Make column k of the small matrix triangular by a Givens rotation, also applied to the right-hand side."""
    matrix, rotations, right = krylov.matrix, krylov.rotations, krylov.right
    for row in range(k):
        upper, lower = matrix[row, k], matrix[row + 1, k]
        matrix[row, k] = rotations[row, 0] * upper + rotations[row, 1] * lower
        matrix[row + 1, k] = rotations[row, 0] * lower - rotations[row, 1] * upper
    length = math.hypot(matrix[k, k], matrix[k + 1, k])
    rotations[k, 0], rotations[k, 1] = matrix[k, k] / length, matrix[k + 1, k] / length
    matrix[k, k], matrix[k + 1, k] = length, 0.0
    right[k + 1] = -rotations[k, 1] * right[k]
    right[k] = rotations[k, 0] * right[k]


@compiled
def combine(krylov: Krylov, used: int, amplitudes: Waves) -> None:
    """Add the least-squares combination of the directions to the amplitudes."""
    matrix, right = krylov.matrix, krylov.right
    for row in range(used - 1, -1, -1):
        for column in range(row + 1, used):
            right[row] -= matrix[row, column] * right[column]
        right[row] /= matrix[row, row]
    for k in range(used):
        add(amplitudes, right[k], krylov.basis[k])


@compiled
def expand(rims: Rims, echoes: Echoes, position: Array, krylov: Krylov, k: int) -> float:
    """Add a direction to the Krylov space: the product of the matrix with the last one, orthogonalized. Returns its
    norm.
    """
    basis, matrix = krylov.basis, krylov.matrix
    incoming(rims, echoes, position, basis[k], krylov.waves)
    for i in range(basis.shape[1]):
        for m in range(basis.shape[2]):
            basis[k + 1, i, m] = basis[k, i, m] - rims.response[i, m] * krylov.waves[i, m]
    for row in range(k + 1):
        matrix[row, k] = product(basis[k + 1], basis[row])
        add(basis[k + 1], -matrix[row, k], basis[row])
    matrix[k + 1, k] = math.sqrt(product(basis[k + 1], basis[k + 1]))
    if matrix[k + 1, k] > 0.0:
        add(basis[k + 1], 1.0 / matrix[k + 1, k] - 1.0, basis[k + 1])
    return float(matrix[k + 1, k])


@compiled
def iterate(
    rims: Rims, echoes: Echoes, position: Array, right: Waves, amplitudes: Waves, krylov: Krylov, tolerance: float
) -> int:
    """Improve `amplitudes` until the residual is below `tolerance` of the right-hand side. Returns the number of
    directions used, or -1 without convergence.
    """
    bound = tolerance * math.sqrt(product(right, right))
    taken, basis = 0, krylov.basis
    for _ in range(MOST_ROUNDS):
        length = residual(rims, echoes, position, right, amplitudes, (basis[0], krylov.waves))
        if length <= bound:
            return taken
        add(basis[0], 1.0 / length - 1.0, basis[0])
        krylov.right[:] = 0.0
        krylov.right[0] = length
        used = 0
        while used < TURNS and abs(krylov.right[used]) > 0.5 * bound:
            more = expand(rims, echoes, position, krylov, used)
            rotate(krylov, used)
            used += 1
            if more <= 0.0:
                break
        combine(krylov, used, amplitudes)
        taken += used
    return -1


@compiled
def fill_matrix(rims: Rims, echoes: Echoes, position: Array, matrix: Array) -> None:
    """Fill the matrix 1 - T G over real unknowns: alpha_0, then real and imaginary parts, body by body."""
    count, orders = rims.response.shape
    unknowns = 2 * orders - 1
    turned, unit = np.zeros(orders, np.complex128), np.zeros(orders, np.complex128)
    scratch, place, waves = np.zeros(2 * orders + 3), np.zeros(2), np.zeros(orders, np.complex128)
    middle = np.zeros((1, len(echoes.answer)), np.complex128)
    for j in range(count):
        for k in range(unknowns):
            m = (k + 1) // 2
            unit[:] = 0.0
            unit[m] = complex(1.0, 0.0) if k == 0 or k % 2 == 1 else complex(0.0, 1.0)
            middle[:] = 0.0
            if len(echoes.answer) > 0:
                to_the_middle(rims, echoes, j, position[j], unit, middle)
            for i in range(count):
                waves[:] = 0.0
                for t in range(len(echoes.mirrors)):
                    mirror = echoes.mirrors[t]
                    if t == 0 and j == i:
                        continue
                    place[0] = position[i, 0] - mirror[0] * position[j, 0] - mirror[1]
                    place[1] = position[i, 1] - mirror[2] * position[j, 1] - mirror[3]
                    sent(unit, mirror, turned)
                    receive(rims, (i, j), place, turned, scratch, waves)
                if len(echoes.answer) > 0:
                    from_the_middle(rims, echoes, i, position[i], middle, waves)
                row = i * unknowns
                matrix[row, j * unknowns + k] = -rims.response[i, 0] * waves[0].real
                for n in range(1, orders):
                    matrix[row + 2 * n - 1, j * unknowns + k] = -rims.response[i, n] * waves[n].real
                    matrix[row + 2 * n, j * unknowns + k] = -rims.response[i, n] * waves[n].imag
            matrix[j * unknowns + k, j * unknowns + k] += 1.0


def eliminate(rims: Rims, echoes: Echoes, position: Array, right: Waves) -> Waves:
    """Compute the amplitudes by LAPACK."""
    count, orders = right.shape
    unknowns = 2 * orders - 1
    matrix = np.zeros((count * unknowns, count * unknowns))
    fill_matrix(rims, echoes, position, matrix)
    parts = np.stack([right.real, right.imag], axis=2).reshape(count, 2 * orders)
    known = np.delete(parts, 1, axis=1).ravel()
    solved = np.linalg.solve(matrix, known).reshape(count, unknowns)
    both = np.insert(solved, 1, 0.0, axis=1).reshape(count, orders, 2)
    found: Waves = both[:, :, 0] + 1j * both[:, :, 1]
    return found
