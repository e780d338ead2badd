"""Parts of space: which points are inside, how far it is from there to the boundary, and what solids have besides."""

from __future__ import annotations

from ecume.engine.shapes.balls import Ball
from ecume.engine.shapes.boxes import Box
from ecume.engine.shapes.lattices import lattice_in, round_up
from ecume.engine.shapes.parts import Flags, Part, Shape, apart
from ecume.engine.shapes.polygons import Polygon

__all__ = ["Ball", "Box", "Flags", "Part", "Polygon", "Shape", "apart", "lattice_in", "round_up"]
