"""Square lattices that fill a part of space."""

from __future__ import annotations

import numpy as np

from ecume.engine.shapes.parts import Part
from ecume.units import Array


def round_up(length: float, spacing: float) -> int:
    """Into how many pieces a length is cut; rounding must not make one more."""
    return max(1, int(np.ceil(length / spacing - 1e-6)))


def lattice_in(shape: Part, spacing: float) -> Array:
    """(N, d) the centers of the cells of a square lattice that are inside a shape."""
    low, high = shape.bounds()
    anchor = shape.anchor()
    axes = [_cells(a, b, c, spacing) for a, b, c in zip(low, high, anchor, strict=True)]
    grid = np.meshgrid(*axes, indexing="ij")
    points = np.stack([axis.ravel() for axis in grid], axis=1)
    return points[shape.inside(points)]


def _cells(low: float, high: float, anchor: float, spacing: float) -> Array:
    """Centers between two ends, half a spacing off the anchor. Rounding must not cost a row."""
    first = np.floor((low - anchor) / spacing + 1e-6)
    last = np.ceil((high - anchor) / spacing - 1e-6)
    return np.asarray(anchor + spacing * (np.arange(first, last) + 0.5), dtype=np.float64)
