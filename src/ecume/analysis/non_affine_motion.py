"""Non-affine motion: the departure from an even deformation of the whole box, and around each particle."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ecume.analysis.boxes import Box, Integers, box_of, copies, nearest
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame
from ecume.units import Array, Length


class LocalDeformation(NamedTuple):
    """The deformation of the neighborhood of each particle between two frames."""

    gradient: Array
    """(N, d, d): the even deformation F that maps old ways to neighbors onto new ones best; d x_k / d X_m"""
    rest: Array
    """(N,) m^2: what it leaves, the mean square over neighbors; D^2_min"""
    neighbors: Integers
    """(N,) how many there were; below d the fit means nothing, and both others are not numbers"""


def local_deformation(
    before: Frame, after: Frame, reach: Length, boxes: tuple[Box, Box] | None = None
) -> LocalDeformation:
    """The best local deformation and what it leaves, D^2_min, for neighbors within `reach` of each particle's center.

    D^2_min is divided by the number of neighbors, unlike in [falk1998]. Ways to neighbors are the shortest,
    before and after: the reach should be well below half a box, and particles must be the same ones in both frames.
    """
    start, end = _boxes(before, after, boxes)
    position = before.arrays["position"]
    around = copies(position, start, reach)
    near = cKDTree(around.position).query_pairs(reach, output_type="ndarray")
    near = np.concatenate([near, near[:, ::-1]])
    near = near[near[:, 0] < len(position)]
    first, second = near[:, 0], around.owner[near[:, 1]]
    old = around.position[near[:, 1]] - around.position[first]
    then = after.arrays["position"]
    new = nearest(then[second] - then[first], end)
    return _fitted(len(position), first, old, new)


def _fitted(count: int, first: Integers, old: Array, new: Array) -> LocalDeformation:
    """Least squares for each particle at once."""
    dimensions = old.shape[1]
    onto, square = np.zeros((2, count, dimensions, dimensions))
    np.add.at(onto, first, new[:, :, None] * old[:, None, :])
    np.add.at(square, first, old[:, :, None] * old[:, None, :])
    number = np.bincount(first, minlength=count)
    spread = np.linalg.eigvalsh(square)
    solvable = spread[:, 0] > 1e-9 * spread[:, -1]
    gradient = np.full((count, dimensions, dimensions), np.nan)
    gradient[solvable] = onto[solvable] @ np.linalg.inv(square[solvable])
    left = new - np.einsum("nkm,nm->nk", gradient[first], old)
    rest = np.bincount(first, (left**2).sum(axis=1), minlength=count)
    return LocalDeformation(gradient, np.where(solvable, rest / np.maximum(number, 1), np.nan), number)


def nonaffine_displacement(before: Frame, after: Frame, boxes: tuple[Box, Box] | None = None) -> Array:
    """The displacement of each particle beyond the deformation of the box, (N, d) m, with a mean of zero.

    For a periodic box, sheared or squeezed; no particle may have moved further than half of it relative to that motion.
    """
    start, end = _boxes(before, after, boxes)
    if start is None or end is None or not (start.closed and end.closed):
        raise BadInput("an even deformation is that of a periodic box; these frames have none: see local_deformation")
    position = before.arrays["position"]
    even = position @ (end.tilt @ np.linalg.inv(start.tilt)).T
    moved = nearest(after.arrays["position"] - even, end)
    # A mean that depends on which copies were taken would shift with them: twice, around what most have in common.
    moved = nearest(moved - np.median(moved, axis=0), end)
    return np.asarray(moved - moved.mean(axis=0))


def nonaffine_velocity(before: Frame, after: Frame, boxes: tuple[Box, Box] | None = None) -> Array:
    """The same over the time between the two frames, (N, d) m/s."""
    if not after.time > before.time:
        raise BadInput(f"a velocity takes time: the frames are at {before.time:g} s and {after.time:g} s")
    return nonaffine_displacement(before, after, boxes) / (after.time - before.time)


def _boxes(before: Frame, after: Frame, boxes: tuple[Box, Box] | None) -> tuple[Box | None, Box | None]:
    if before.arrays["position"].shape != after.arrays["position"].shape:
        raise BadInput("the frames contain different particles; expected the same ones in both")
    return boxes or (box_of(before), box_of(after))
