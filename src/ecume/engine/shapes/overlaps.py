"""How much of a shape other shapes cover."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ecume.engine.shapes.lattices import fitted_axis
from ecume.engine.shapes.parts import Part, apart
from ecume.units import Array

SAMPLES = {2: 500, 3: 64}
"""Points along each axis where no formula gives a volume: good to some 1e-4 of what is covered."""
AT_ONCE = 20_000


def covered_volume(part: Part, others: Sequence[Part]) -> float:
    """The volume of a part of space that is inside any of the others. Exact for boxes in a box, and for polygons and
    whole balls and meshes in a box that touch none of the rest; else by sampling.
    """
    in_box = len(part.faces()) > 0
    boxes = [other for other in others if in_box and len(other.faces())]
    total, earlier = _covered_by_boxes(part, boxes) if boxes else 0.0, [*boxes]
    for other in others:
        if any(other is box for box in boxes):
            continue
        among = [each for each in earlier if bounds_meet(each, other)]
        exact = other.volume_within(*part.bounds()) if in_box and not among else None
        total += _sampled_volume(part, other, among) if exact is None else exact
        earlier.append(other)
    return total


def _covered_by_boxes(part: Part, boxes: Sequence[Part]) -> float:
    """Of a box: all faces cut it into cells that are each covered as a whole or not at all."""
    low, high = part.bounds()
    faces = np.concatenate([np.clip(box.faces(), low, high) for box in boxes])
    axes = [np.unique([low[axis], *faces[:, axis], high[axis]]) for axis in range(len(low))]
    middles = [0.5 * (x[1:] + x[:-1]) for x in axes]
    centers = np.stack([grid.ravel() for grid in np.meshgrid(*middles, indexing="ij")], axis=1)
    widths = np.stack([grid.ravel() for grid in np.meshgrid(*map(np.diff, axes), indexing="ij")], axis=1)
    return float(np.prod(widths, axis=1)[~apart(centers, boxes)].sum())


def bounds_meet(one: Part, other: Part) -> bool:
    """Whether the boxes around two parts of space overlap."""
    low, high = _common_bounds(one, other)
    return bool((low < high).all())


def _common_bounds(one: Part, other: Part) -> tuple[Array, Array]:
    (low, high), (lowest, highest) = one.bounds(), other.bounds()
    return np.maximum(low, lowest), np.minimum(high, highest)


def _sampled_volume(part: Part, other: Part, earlier: Sequence[Part]) -> float:
    """Of the places in both and in none of the earlier ones, by points of a lattice."""
    low, high = _common_bounds(part, other)
    if not (low < high).all():
        return 0.0
    axes = [fitted_axis(a, b, (b - a) / SAMPLES[len(low)])[0] for a, b in zip(low, high, strict=True)]
    points = np.stack([grid.ravel() for grid in np.meshgrid(*axes, indexing="ij")], axis=1)
    found = 0
    for first in range(0, len(points), AT_ONCE):
        some = points[first : first + AT_ONCE]
        some = some[other.inside(some)]
        some = some[apart(some, earlier)]
        found += int(np.count_nonzero(part.inside(some))) if len(some) else 0
    return float(np.prod(high - low)) * found / len(points)
