"""A grid of bins over a mesh, which finds the triangle or the tetrahedron around a point."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.units import Array


class Bins(NamedTuple):
    """Bins of equal size, and the elements of the mesh whose bounding boxes overlap each bin."""

    step: tuple[float, ...]
    """m: the sides of a bin"""
    first: Integers
    """(bins along each axis) where the elements of a bin begin in `near`"""
    many: Integers
    """(bins along each axis) how many they are"""
    near: Integers


def bins_of(corners: Array, low: tuple[float, ...], high: tuple[float, ...], along: float) -> Bins:
    """The bins of elements with corners (T, d + 1, d), about `along` of them along the longest side of the box."""
    sides = np.array(high) - np.array(low)
    shape = np.maximum(1, np.ceil(sides / sides.max() * max(4, round(along)))).astype(np.int64)
    step = sides / shape
    start = np.clip(((corners.min(axis=1) - low) / step - 1e-9).astype(np.int64), 0, shape - 1)
    end = np.clip(((corners.max(axis=1) - low) / step + 1e-9).astype(np.int64), 0, shape - 1)
    span = end - start + 1
    element = np.repeat(np.arange(len(corners)), span.prod(axis=1))
    rest = np.arange(len(element)) - np.repeat(np.cumsum(span.prod(axis=1)) - span.prod(axis=1), span.prod(axis=1))
    number = np.zeros(len(element), np.int64)
    for axis in range(len(sides)):
        after = span[element, axis + 1 :].prod(axis=1)
        number = number * shape[axis] + start[element, axis] + rest // after
        rest = rest % after
    count = np.bincount(number, minlength=int(shape.prod()))
    grid = tuple(shape.tolist())
    near = element[np.argsort(number, kind="stable")].astype(np.int64)
    first = (np.cumsum(count) - count).astype(np.int64)
    return Bins(tuple(step.tolist()), first.reshape(grid), count.astype(np.int64).reshape(grid), near)
