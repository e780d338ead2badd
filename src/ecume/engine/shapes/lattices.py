"""Lattices of equal cells that fit into shapes: the cells' volumes add up to that of the shape."""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import numpy as np

from ecume.engine.shapes.parts import Cells
from ecume.units import Array

SAME = 1e-9
"""Relative: a fitted width this close to the spacing is the spacing, so that rounding in a scene changes no bit."""
ROUNDING = 1e-13
"""Relative, of a sum of volumes."""
NARROWEST = 0.5
"""In spacings."""


def round_up(length: float, spacing: float) -> int:
    """Number of pieces a length is cut into; rounding must not make one more."""
    return max(1, int(np.ceil(length / spacing - 1e-6)))


def fitted_axis(low: float, high: float, spacing: float) -> tuple[Array, Array]:
    """Centers and widths of equal cells between two ends, as many as make the width nearest to the spacing.

    >>> fitted_axis(0.0, 1.0, 0.3)[1].tolist()
    [0.3333333333333333, 0.3333333333333333, 0.3333333333333333]
    """
    count = max(1, round((high - low) / spacing))
    width = (high - low) / count
    if abs(width - spacing) <= SAME * spacing:
        width = spacing
    return low + width * np.arange(0.5, count), np.full(count, width)


def fitted_cells(low: Array, high: Array, spacing: float, faces: Array | None = None) -> Cells:
    """The cells of a box. Those along each axis end at `faces`, (k, d) coordinates, unless a piece between two of them
    were narrower than half a spacing.
    """
    axes = []
    for axis, (first, last) in enumerate(zip(low, high, strict=True)):
        ends = [first, *(() if faces is None else _apart(faces[:, axis], first, last, NARROWEST * spacing)), last]
        pieces = [fitted_axis(start, end, spacing) for start, end in itertools.pairwise(map(float, ends))]
        axes.append(tuple(np.concatenate(both) for both in zip(*pieces, strict=True)))
    centers, widths = (
        np.stack([grid.ravel() for grid in np.meshgrid(*each, indexing="ij")], axis=1)
        for each in zip(*axes, strict=True)
    )
    return Cells(centers, np.prod(widths, axis=1), widths)


def _apart(faces: Iterable[float], first: float, last: float, least: float) -> list[float]:
    """Those between two ends, sorted, that are not nearer to an end or to the one before than the least distance."""
    found = [first]
    for face in sorted(faces):
        if face - found[-1] >= least and last - face >= least:
            found.append(face)
    return found[1:]


def scaled_to(cells: Cells, volume: float) -> Cells:
    """The same cells, with volumes that add up to this; unchanged where they do so already."""
    total = float(cells.volumes.sum())
    if total == 0.0 or abs(total - volume) <= ROUNDING * volume:
        return cells
    return cells._replace(volumes=cells.volumes * (volume / total))
