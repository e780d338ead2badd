"""All that a step of time works with."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume.engine.linear_solvers.block_matrix import Matrix
from ecume.models.soft.borders import (
    Borders,
)
from ecume.models.soft.cell import (
    Cell,
)
from ecume.models.soft.films import Answers, Films, Pairs
from ecume.models.soft.spins import (
    Spins,
)
from ecume.models.soft.walls import (
    Walls,
)
from ecume.units import Array


class Bodies(NamedTuple):
    """The spheres in a step."""

    position: Array
    """(N, d) m, of the stage"""
    before: Array
    """(N, d) at the step's beginning"""
    moved: Array
    """(N, d) m: how far from there, in digits of its own: short steps would drown in those of the places"""
    start: Array
    """(N, d) m: how far from there the stage starts; means something with drag only"""
    slope: Array
    """(S, N, d) m/s of the stages, with drag only"""
    drag: Array
    """(N,) N s/m"""
    force: Array
    """(N, d) N external, at factor 1"""
    weight: Array
    """(N, d) N external, always"""
    right: Array
    """(N, d + s) N that is left on each, and at its equator"""
    change: Array
    """(N, d + s) m, of places and of spins"""
    diagonal: Array
    """(N, d + s) N/m"""


class During(NamedTuple):
    """What a step is to do."""

    length: float
    """s"""
    drives: Array
    """(S, 10) what is imposed at each stage, as the fields of a `Drive`"""
    tolerance: float


class Books(NamedTuple):
    """What the energy's books need of a step; see `booking`."""

    lines: Array
    """(S + 1, 8) a line for each stage, zero for those that do not count; in the last what the step adds to
    `State.books` (J)
    """
    sheared: Array
    """(C + walls', 2) N/m and m^2: of each contact at the last stage, the stiffness along the surface, and the shear
    squared
    """


class Step(NamedTuple):
    """All that a step works with."""

    pairs: Pairs
    films: Films
    answers: Answers
    slope: Array
    """(S, C, 4) of the stages"""
    log_gap: Array
    direction: Array
    """where the contacts are at the step's beginning"""
    bodies: Bodies
    spins: Spins
    walls: Walls | tuple[()]
    """nothing where there are none: what walls do is then not compiled"""
    matrix: Matrix
    cell: Cell
    borders: Borders
    books: Books


def make_books(stages: int, contacts: int) -> Books:
    """Room for so many contacts."""
    return Books(np.zeros((stages + 1, 8)), np.zeros((contacts, 2)))
