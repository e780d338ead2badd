"""The height of the surface around floats that go by multipoles, at any points."""

from __future__ import annotations

import math

import numpy as np

from ecume._jit import compiled
from ecume.laws.multipole.echoes import echo_heights
from ecume.laws.multipole.graf import Rims, Waves, sent
from ecume.laws.multipole.ladders import outgoing_ladder
from ecume.models.floating.interactions import part_of
from ecume.models.floating.many import Crowd, Many, make_crowd, resolve
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.state import make_state
from ecume.trajectories.frame import Frame
from ecume.units import Array


def multipoles_of(parameters: Parameters) -> Many:
    """The part of floats that go by multipoles."""
    many: Many = part_of(parameters, Many)
    return many


def solved(parameters: Parameters, frame: Frame) -> Crowd:
    """The multipoles of a frame's floats, found anew: frames do not keep them."""
    many = multipoles_of(parameters)
    count, orders = many.rims.response.shape
    angle = frame.arrays.get("angle", np.zeros(count))
    turning = np.stack([angle, np.zeros(count)], axis=1)
    position = np.ascontiguousarray(frame.arrays["position"])
    state = make_state(position, np.zeros((count, 2)))
    state = state._replace(amplitudes=np.zeros((count, 2 * orders)), turning=turning)
    crowd = make_crowd(many, parameters, state, None)
    resolve(many, position, crowd)
    return crowd


def heights_at(many: Many, crowd: Crowd, points: Array) -> Array:
    """(P,) m at `points` (P, 2) in m: what floats add to the walls' own meniscus, the walls' answer to them included;
    a float's own part goes on inside its contact line as it is there.
    """
    places = points / many.length
    heights = np.zeros(len(points))
    add_waves(many.rims, many.echoes.mirrors, crowd.at, crowd.amplitudes, places, heights)
    if len(many.echoes.answer):
        heights += echo_heights(many.rims, many.echoes, crowd.at, crowd.amplitudes, places)
    return np.asarray(many.length * heights)


def bends(many: Many, crowd: Crowd) -> Array:
    """(N,) m: how far each float by itself bends the surface, as the root mean square around its edge."""
    squares = np.abs(crowd.amplitudes) ** 2
    return np.asarray(many.length * np.sqrt(squares[:, 0] + 2.0 * squares[:, 1:].sum(axis=1)))


@compiled
def add_waves(rims: Rims, mirrors: Array, at: Array, amplitudes: Waves, places: Array, heights: Array) -> None:
    """Add the sum over bodies and images of A_m K_m(r)/K_m(a) exp(i m phi), m and -m, all in capillary lengths; inside
    a contact line as at it.
    """
    orders = amplitudes.shape[1]
    ladder, turned = np.zeros(orders), np.zeros(orders, np.complex128)
    for t in range(len(mirrors)):
        mirror = mirrors[t]
        for j in range(len(at)):
            sent(amplitudes[j], mirror, turned)
            a = rims.radius[j]
            for k in range(len(places)):
                x = places[k, 0] - mirror[0] * at[j, 0] - mirror[1]
                y = places[k, 1] - mirror[2] * at[j, 1] - mirror[3]
                distance = math.sqrt(x * x + y * y)
                if distance - a > rims.range:
                    continue
                turn = complex(x / distance, y / distance) if distance > 0.0 else complex(1.0, 0.0)
                out = max(distance, a)
                outgoing_ladder(out, rims.reference, ladder)
                own, phase = turned[0].real * rims.inverse[j, 0] * ladder[0], turn
                for m in range(1, orders):
                    own += 2.0 * (turned[m] * phase).real * rims.inverse[j, m] * ladder[m]
                    phase *= turn
                heights[k] += math.exp(a - out) * own
