"""Walls: surfaces that reflect particles within a step (`reflect`), and the walls around floating
rafts (`Walls`).

Start with `surfaces`, the common shapes of all models: planes and spheres. Its second part describes plane walls for
floats; soft spheres move its planes (`through`).
"""

from __future__ import annotations

from ecume.engine.walls.event_driven import CAPPED, MOST_EVENTS, STARTED_OUTSIDE, STAYED, reflect_all
from ecume.engine.walls.reflecting import Trace, clearance, gaps, reflect, trace
from ecume.engine.walls.sheets import Sheet, sheet
from ecume.engine.walls.surfaces import (
    Entrance,
    Surfaces,
    Walls,
    box,
    described,
    disc,
    enclosed_by,
    entrance,
    is_circle,
    moved,
    moving,
    nearest_points,
    no_walls,
    opening,
    outside,
    planes,
    polygon,
    polyhedron,
    through,
    together,
    wall_count,
    wall_distance,
    wedge,
)

__all__ = [
    "CAPPED",
    "MOST_EVENTS",
    "STARTED_OUTSIDE",
    "STAYED",
    "Entrance",
    "Sheet",
    "Surfaces",
    "Trace",
    "Walls",
    "box",
    "clearance",
    "described",
    "disc",
    "enclosed_by",
    "entrance",
    "gaps",
    "is_circle",
    "moved",
    "moving",
    "nearest_points",
    "no_walls",
    "opening",
    "outside",
    "planes",
    "polygon",
    "polyhedron",
    "reflect",
    "reflect_all",
    "sheet",
    "through",
    "together",
    "trace",
    "wall_count",
    "wall_distance",
    "wedge",
]
