"""Parts of space: which points are inside, how far it is from there to the boundary, and what solids have besides."""

from __future__ import annotations

from ecume.engine.shapes.balls import Ball
from ecume.engine.shapes.boxes import Box
from ecume.engine.shapes.lattices import fitted_axis, fitted_cells, round_up, scaled_to
from ecume.engine.shapes.overlaps import bounds_meet, covered_volume
from ecume.engine.shapes.parts import Cells, Flags, Part, Shape, apart
from ecume.engine.shapes.polygons import Polygon

__all__ = [
    "Ball",
    "Box",
    "Cells",
    "Flags",
    "Part",
    "Polygon",
    "Shape",
    "apart",
    "bounds_meet",
    "covered_volume",
    "fitted_axis",
    "fitted_cells",
    "round_up",
    "scaled_to",
]
