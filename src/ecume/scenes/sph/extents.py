"""The refusal of solids that are far too large for the spacing: a drawing in millimeters that is read in meters."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ecume.scenes.faults import Complaints
from ecume.scenes.sph.solids import ObstacleSpec, ShapeSpec
from ecume.units import Length

MOST_POINTS = 2e8
"""The largest number of spacings in the box around a solid: a table of so many takes about 10 GB."""


def size_faults(table: str, shapes: Sequence[ShapeSpec], spacing: Length) -> Complaints:
    """The faults of drawn solids whose points would not fit into memory."""
    found: Complaints = []
    for index, shape in enumerate(shapes):
        sides = _sides(shape)
        count = math.prod(side / spacing for side in sides)
        if count > MOST_POINTS:
            tank = isinstance(shape, ObstacleSpec) and shape.name == "tank"
            size = " × ".join(f"{side:.4g}" for side in sides)
            message = (
                f"is {size} m, which are {count:.2g} points at this spacing; expected at most {MOST_POINTS:g}: "
                'give the unit of the drawing, as in outline_unit = "mm", or a larger spacing'
            )
            found.append((("tank",) if tank else (table, index), message))
    return found


def _sides(shape: ShapeSpec) -> list[float]:
    """The sides of the box around a drawn shape (m); of others none."""
    points = [*shape.vertices, *(corner for triangle in shape.triangles for corner in triangle)]
    return [max(values) - min(values) for values in zip(*points, strict=True)]
