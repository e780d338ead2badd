"""Profiles across a sheared packing: velocity and volume fraction in layers of equal height, means over frames."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecume.analysis.series import Mean, steady_mean
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame
from ecume.units import Array


class Layers(NamedTuple):
    """Layers between the bottom and the top, with means over frames and their standard errors."""

    height: Array
    """(C,) m above the bottom: the middle of each layer"""
    velocity: tuple[Mean, ...]
    """of the spheres along x, weighted by their volumes in the layer (m/s); relative to the bottom of the cell"""
    fraction: tuple[Mean, ...]
    """the part of the layer that is in undeformed spheres, in 2D of its area"""


def part_below(height: Array, radius: Array, dimensions: int) -> Array:
    """The volume of spheres below a plane at this height above their centers (m^3); in 2D the area of discs (m^2).

    >>> float(part_below(np.array(0.0), np.array(1.0), 2)) == 0.5 * math.pi
    True
    """
    u = np.clip(height / radius, -1.0, 1.0)
    if dimensions == 2:
        return np.asarray(radius**2 * (np.arccos(-u) + u * np.sqrt(1.0 - u**2)))
    return np.asarray(math.pi * radius**3 * (2.0 / 3.0 + u - u**3 / 3.0))


def ends_of(frame: Frame) -> tuple[float, float, bool]:
    """The bottom and the top (m), and whether the cell is periodic from one to the other."""
    numbers, edge = frame.numbers, frame.arrays["radius"]
    if "box_width" not in numbers:
        raise BadInput("a profile takes a cell that is periodic along x")
    if "box_height" in numbers:
        return 0.0, numbers["box_height"], True
    y = frame.arrays["position"][:, 1]
    low, high = float((y - edge).min()), float((y + edge).max())
    return numbers.get("bottom_y", low), numbers.get("top_y", high), False


def layers(frames: Sequence[Frame], count: int = 12) -> Layers:
    """The profiles over the height, of frames of a steady flow that are evenly spaced in time.

    Each sphere contributes to a layer by its volume in it, so that the mean over layers is the volume fraction.
    """
    if not frames:
        raise BadInput("a profile takes a frame or more; got none")
    found = np.array([_in_layers(frame, count) for frame in frames])
    filled, moving = found[:, 0], found[:, 1]
    ends = np.array([ends_of(frame)[:2] for frame in frames]).mean(axis=0)
    middle = (np.arange(count) + 0.5) / count * (ends[1] - ends[0])
    fraction = tuple(steady_mean(values) for values in filled.T)
    with np.errstate(invalid="ignore"):
        speed = moving / filled
    return Layers(middle, tuple(steady_mean(one[np.isfinite(one)]) for one in speed.T), fraction)


def _in_layers(frame: Frame, count: int) -> Array:
    """The volume fraction of each layer, and this times the velocity along x, (2, C)."""
    bottom, top, periodic = ends_of(frame)
    position, radius = frame.arrays["position"], frame.arrays["radius"]
    dimensions, height = position.shape[1], top - bottom
    sides = [frame.numbers["box_width"], *([frame.numbers["box_depth"]] if dimensions == 3 else [])]
    edges, filled = bottom + height * np.arange(count + 1) / count, np.zeros((2, count))
    rate = frame.numbers.get("strain_rate", 0.0)
    for image in (-1, 0, 1) if periodic else (0,):
        y = position[:, 1] + image * height
        below = part_below(edges[:, None] - y, radius, dimensions)
        volume = np.diff(below, axis=0) / (math.prod(sides) * height / count)
        speed = frame.arrays["velocity"][:, 0] + image * height * rate
        filled += volume.sum(axis=1), volume @ speed
    return filled
