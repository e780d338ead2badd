"""Periodic rectangles and boxes: the nearest image of a particle.

The periods of a box are an array (2, d): the lengths of its sides, and their inverses; both are zero along an axis
without a period. Positions need not lie inside the box.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ecume._jit import compiled_inside
from ecume.units import Array


def no_periods(dimension: int) -> Array:
    """The periods of a system without periodic axes."""
    return np.zeros((2, dimension))


def periods_of(sides: Sequence[float]) -> Array:
    """The periods of a box with these sides.

    >>> periods_of([4.0, 0.0]).tolist()
    [[4.0, 0.0], [0.25, 0.0]]
    """
    return np.array([[*sides], [1.0 / side if side > 0.0 else 0.0 for side in sides]])


@compiled_inside
def nearest(apart: float, period: float, inverse: float) -> float:
    """The component `apart` of the vector to the nearest image; unchanged if the period is zero.

    >>> float(nearest(3.5, 4.0, 0.25)), float(nearest(3.5, 0.0, 0.0))
    (-0.5, 3.5)
    """
    image: float = apart - period * np.floor(apart * inverse + 0.5)
    return image


def into_box(position: Array, periods: Array) -> Array:
    """The images of these positions that are inside the box, which begins at the origin."""
    home = position - periods[0] * np.floor(position * periods[1])
    # Just below zero the quotient rounds to one whole side.
    return np.where((periods[0] > 0.0) & (home >= periods[0]), 0.0, home)
