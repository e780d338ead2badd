"""What walls do that no formula says: exact menisci and mirror images, as tables over the distance from the wall.

A table holds heights and mirror energies of a unit charge with their slopes, at distances evenly spaced in their
logarithm; between them a cubic through both. Forces are the slopes of that cubic, so that energy is kept.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import admit, compiled_inside
from ecume.laws import flotation, images, meniscus, special
from ecume.units import Array

admit(special)

NODES = 600
HEIGHT, IMAGE = 2, 4
"""Rows of a table: each of these two, and its slope over ln(d) below it. Row 0 starts with ln(d) of the first node and
the step; row 1 holds the distances.
"""
FAR = 30.0
"""In L: plane walls are not felt from farther away."""
HUGGING = 0.01
"""Share of a dish's radius from its wall, nearer than which the image's force is that of a plane wall: 1 % of it."""


class WallKind(NamedTuple):
    """What is tabled."""

    contact_angle: float
    profile: str
    """a law of `dish.law` that is not legacy"""
    image: str
    """a key of `images.WALLS`, or `none`"""
    radius: float | None
    """of a round dish (m); None for plane walls"""


def wall_table(kind: WallKind, liquid: flotation.Liquid, nearest: float) -> Array:
    """Heights over L in dishes, over the amplitude at plane walls; mirror energies over 2 pi gamma A^2. `nearest`: the
    first distance (m).
    """
    length = liquid.capillary_length
    farthest = kind.radius if kind.radius is not None else FAR * length
    logarithms = np.linspace(math.log(nearest), math.log(farthest), NODES)
    distance = np.exp(logarithms)
    distance[-1] = farthest
    table = np.zeros((6, NODES))
    table[0, :2] = logarithms[0], logarithms[1] - logarithms[0]
    table[1] = distance
    for row, values in ((HEIGHT, _heights(kind, liquid, distance)), (IMAGE, _images(kind, liquid, distance))):
        table[row], table[row + 1] = values, _slopes(logarithms, values)
    return table


def _slopes(logarithms: Array, values: Array) -> Array:
    from scipy.interpolate import CubicSpline

    slopes: Array = CubicSpline(logarithms, values)(logarithms, 1)
    return slopes


def _heights(kind: WallKind, liquid: flotation.Liquid, distance: Array) -> Array:
    if kind.profile == "none":
        return np.zeros_like(distance)
    length = liquid.capillary_length
    if kind.radius is not None:
        theory = {"meniscus": "amplitude", "linear": "linear", "profile": "nonlinear"}[kind.profile]
        r = np.maximum(kind.radius - distance, 0.0)
        return np.asarray(meniscus.dish_height(r, kind.radius, kind.contact_angle, liquid, theory)) / length
    if kind.profile != "profile":
        return np.exp(-distance / length)
    amplitude = meniscus.wall_amplitude(kind.contact_angle, liquid)
    if amplitude == 0.0:
        return np.zeros_like(distance)
    return np.asarray(meniscus.plane_height(distance, kind.contact_angle, liquid)) / amplitude


def _images(kind: WallKind, liquid: flotation.Liquid, distance: Array) -> Array:
    """E over 2 pi gamma A^2: -(1/2) sum_m c_m I_m^2 in a dish, -(1/2) K0(2 d/L) at a plane wall, with its sign."""
    from scipy.special import k0

    if kind.image == "none":
        return np.zeros_like(distance)
    sign, length = images.WALLS[kind.image], liquid.capillary_length
    plane: Array = -0.5 * sign * k0(2.0 * distance / length)
    if kind.radius is None:
        return plane
    away = distance >= HUGGING * kind.radius
    energy = -0.5 * images.dish_sums((kind.radius - distance[away]) / length, kind.radius / length, sign).height
    # Nearer, the plane wall's energy and what was last seen beside it.
    beside = energy[0] - plane[away][0]
    return np.concatenate([plane[~away] + beside, energy])


@compiled_inside
def tabled(table: Array, row: int, distance: float) -> tuple[float, float]:
    """A tabled quantity and its slope over the distance; beyond the ends as at the ends."""
    start, step = table[0, 0], table[0, 1]
    last = table.shape[1] - 1
    within = min(max(distance, table[1, 0]), table[1, last])
    place = min(max((math.log(within) - start) / step, 0.0), float(last))
    left = min(int(place), last - 1)
    t = place - left
    u = 1.0 - t
    rise = table[row, left + 1] - table[row, left]
    before, after = step * table[row + 1, left] - rise, rise - step * table[row + 1, left + 1]
    value = u * table[row, left] + t * table[row, left + 1] + t * u * (u * before + t * after)
    slope = rise + (1.0 - 2.0 * t) * (u * before + t * after) + t * u * (after - before)
    return value, slope / (step * within)
