"""The data types of the scenery on the page."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from ecume.trajectories.frame import Frame
from ecume.units import Array

ROUND = np.linspace(0.0, 2.0 * np.pi, 65)
"""Angles around a circle."""


class Links(Protocol):
    """Contacts of a frame."""

    @property
    def pairs(self) -> Any:
        """(C, 2) the numbers of both particles"""

    @property
    def along(self) -> Array:
        """(C, d) m: from the first to the second, or to its copy that is nearest"""

    @property
    def gap(self) -> Array:
        """(C,) m"""

    @property
    def tension(self) -> Array:
        """(C,) N"""


class Line(NamedTuple):
    """A line that never moves."""

    points: Array
    """(n, d) m"""
    closed: bool = False
    dashed: bool = False
    color: str | None = None
    """of a solid with a color"""


class Surface(NamedTuple):
    """The drawing of the surface's heights."""

    columns: int
    rows: int
    view: tuple[float, float, float, float]
    walls: list[list[float]]
    """the surface is where n.x >= offset (m) for each (n_x, n_y, offset)"""
    round: float
    """and inside this radius (m); 0 for none"""
    map: str
    label: str
    shown: tuple[float, float]
    """the part of the scale that occurs, from 0 to 1"""
    ticks: list[tuple[float, str]]


class Filled(NamedTuple):
    """A tank whose liquid is drawn as a continuous region."""

    spacing: float
    """m"""
    low: list[float]
    """the corners of the tank (m); at open sides, of what is seen"""
    high: list[float]
    periodic: list[bool]


class Stage(NamedTuple):
    """The scenery around the particles of a run."""

    low: Array
    """(d,) m: what is to be seen at first"""
    high: Array
    kinds: Sequence[Any]
    """species, with names and colors"""
    usual: str = "species"
    """what colors mean at first"""
    radius: float = 0.0
    """of particles whose frames say none (m)"""
    lines: Sequence[Line] = ()
    movers: Callable[[Frame], list[Array]] | None = None
    """outlines of what moves, as many points in every frame"""
    mover_colors: Sequence[str | None] = ()
    """of each; None or missing, as walls are"""
    inner: Array | None = None
    """(N,) m: radii of the discs inside the outlines of floats with a shape, which are drawn for them"""
    links: Callable[[Frame], Links] | None = None
    widest: float = 0.0
    """the gap up to which films are drawn (m)"""
    heights: Callable[[Frame], Array] | None = None
    """(rows, columns) of the surface, as parts of its scale from 0 to 1"""
    surface: Surface | None = None
    liquid: Filled | None = None
    derived: Callable[[Frame], Frame] | None = None
    """adds the arrays that are shown and not recorded"""
    curves: Sequence[str] = ()
    """numbers whose curves are shown at first"""
    apart: int | None = None
    """the species from which on particles keep their own colors when others are colored by a quantity"""


def circle(middle: Array, radius: float) -> Array:
    """Points around."""
    points: Array = middle + radius * np.column_stack([np.cos(ROUND), np.sin(ROUND)])
    return points
