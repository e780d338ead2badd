"""Floats with a shape, in pictures: their outlines as they are turned, and the charges that bend the surface."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection

from ecume.show.picture import Species
from ecume.show.style import INK
from ecume.trajectories.frame import Frame
from ecume.units import Array


class Shapes(NamedTuple):
    """All floats of a scene, each in its own frame."""

    outlines: list[Array]
    """of each float (points, 2)"""
    place: Array
    """(P, 2) of the charges (m)"""
    charge: Array
    """(P,) m"""
    owner: Array
    """(P,) whose charge it is"""
    rise: float
    """the highest that a contact line rises or dips (m)"""


def shapes_of(scene: Any) -> Shapes | None:
    """The shapes of a scene's floats; none where all are round."""
    if not scene.shaped:
        return None
    from ecume.models.floating.setup.kinds import distinct_kinds
    from ecume.models.floating.shaped.figures import charges_of, silhouette

    kinds, number = distinct_kinds(scene)
    outlines = [silhouette(kind.figure.skeleton) for kind in kinds]
    spread = [charges_of(kind.figure) for kind in kinds]
    return Shapes(
        outlines=[outlines[kind] for kind in number],
        place=np.concatenate([spread[kind][0] for kind in number]),
        charge=np.concatenate([spread[kind][1] for kind in number]),
        owner=np.repeat(np.arange(len(number)), [len(spread[kind][1]) for kind in number]),
        rise=max(abs(kind.figure.line.rise) for kind in kinds),
    )


def turned(points: Array, angle: Array) -> Array:
    """Points of a float's own frame as it is turned: one angle for all, or one for each."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * points[:, 0] - s * points[:, 1], s * points[:, 0] + c * points[:, 1]], axis=1)


def outlines_in(frame: Frame, shapes: Shapes) -> list[Array]:
    """Where the outlines are."""
    arrays = frame.arrays
    each = zip(shapes.outlines, arrays["angle"], arrays["position"], strict=True)
    return [turned(outline, angle) + place for outline, angle, place in each]


def charges_in(frame: Frame, shapes: Shapes) -> Array:
    """(P, 2) where the charges are."""
    angle, position = frame.arrays["angle"][shapes.owner], frame.arrays["position"][shapes.owner]
    places: Array = turned(shapes.place, angle) + position
    return places


def polygons(axes: Axes, frame: Frame, shapes: Shapes, kinds: Sequence[Species]) -> PolyCollection:
    """The floats of a frame, to scale."""
    found = PolyCollection(
        outlines_in(frame, shapes),
        facecolors=[kinds[kind].color for kind in frame.arrays["species"]],
        edgecolors=INK,
        linewidths=0.6,
        zorder=2,
    )
    axes.add_collection(found, autolim=False)
    return found
