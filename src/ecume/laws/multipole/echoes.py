"""What walls send back: mirror images in plane walls, and a round dish's answer to every wave from its middle.

What bodies send out is seen from the middle of a round dish as waves K_p exp(i p theta); the wall answers with I_p, by
-K_p'/I_p' where it keeps the contact angle and -K_p/I_p where it holds the surface [watson1944]. Compiled.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.laws.multipole.graf import Rims, Waves, receive_all
from ecume.laws.multipole.ladders import outgoing_ladder, regular_ladder
from ecume.units import Array

FAINT = math.log(1e-16)
"""Orders whose part is smaller are not felt."""


class Echoes(NamedTuple):
    """Plane walls as mirrors, and a round wall; in capillary lengths."""

    mirrors: Array
    """(T, 5): x' = m_0 x + m_1, y' = m_2 y + m_3, height times m_4; the first is no mirror"""
    brim: float
    """the round wall's radius"""
    answer: Array
    """(P + 1,) of the round wall, over p!^2 (2/brim)^(2p) exp(-2 brim); empty without one"""
    near: Array
    """(P + 1, order + 2) p!/(|p - m|! m!) (brim/2)^(|p - m| - p) (s/2)^m"""
    far: Array
    """(P + 1, order + 2) p!/((p + m)! m!) (brim/2)^m (s/2)^m"""


NO_MIRROR = ((1.0, 0.0, 1.0, 0.0, 1.0),)


def make_echoes(mirrors: Array, orders: int, reference: float) -> Echoes:
    """Mirrors alone."""
    none = np.zeros((0, orders + 1))
    return Echoes(mirrors, 1.0, np.zeros(0), none, none)


def make_round_echoes(brim: float, waves: int, orders: int, reference: float, pinned: bool) -> Echoes:
    """A round wall with its answers to `waves` orders."""
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
def felt(echoes: Echoes, out: float, radius: float, orders: int) -> int:
    """How many of the round wall's orders a body feels, that far from the middle: few, unless it is near the wall."""
    ratio = (out + radius) / echoes.brim
    if ratio >= 1.0:
        return len(echoes.answer)
    return min(len(echoes.answer), int(FAINT / math.log(ratio)) + 2 * orders + 1)


@compiled
def to_the_middle(rims: Rims, echoes: Echoes, j: int, place: Array, amplitudes: Waves, middle: Waves) -> None:
    """Add to `middle` (1, P + 1) what the body j sends, as seen from the middle."""
    out = math.sqrt(place[0] ** 2 + place[1] ** 2)
    orders, waves = len(amplitudes), felt(echoes, out, rims.radius[j], len(amplitudes))
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
    """Add to `waves` of body i what the round wall answers."""
    out = math.sqrt(place[0] ** 2 + place[1] ** 2)
    wanted, most = len(waves), felt(echoes, out, rims.radius[i], len(waves) - 1)
    ladder = np.zeros(most + wanted)
    turn = complex(place[0] / out, place[1] / out) if out > 0.0 else complex(1.0, 0.0)
    regular_ladder(out, echoes.brim, ladder)
    back = complex(math.exp(out + rims.radius[i] - echoes.brim), 0.0)
    for k in range(wanted):
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
    """Fill waves (N, order + 1 or order + 2) with what reaches each body from all others and from the walls."""
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
    """The height (in L) that the round wall's answer adds at each point (P, 2)."""
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
