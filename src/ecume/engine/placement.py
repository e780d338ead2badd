"""Initial positions of discs: at random without overlap, on a triangular lattice, on a ring."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.cells import Integers, nearest, no_periods, periods_of
from ecume.engine.walls import Walls, rings, wall_count
from ecume.engine.walls.rings import wall_distance
from ecume.errors import BadInput
from ecume.units import Array

TRIES_PER_DISC = 2000
MANY, TRIES_PER_DISC_OF_MANY = 10_000, 50
"""Above this number of discs, each further disc reduces the number of tries. Random sequential addition approaches
jamming as one over the square root of the tries, so that more tries add few discs and take minutes.
"""
CLEARANCE = 1e-6
"""The gap of discs placed at random, over the smallest radius, so that rounding never makes them overlap."""


JAMMED = 0.547
"""The covered fraction at which random sequential addition of equal discs jams [feder1980]."""
AT_RANDOM = 0.5
"""A lower bound of the covered fraction at which discs placed at random jam."""
SURE = 0.95
"""Safety factor of suggested radii, since another seed may jam earlier."""


class Region(NamedTuple):
    """The rectangle for the placement of discs, with walls or periodic sides."""

    low: tuple[float, float]
    high: tuple[float, float]
    walls: Walls
    periodic: bool = False
    """whether discs at opposite borders are neighbors"""

    @property
    def periods(self) -> Array:
        """The periods of the region: see `ecume.engine.cells`."""
        if not self.periodic:
            return no_periods(2)
        return periods_of([high - low for low, high in zip(self.low, self.high, strict=True)])


class _Grid(NamedTuple):
    """The discs placed so far, in square cells at least as wide as two of them."""

    low: Array
    size: Array
    """(2,) m, of a cell"""
    shape: Integers
    head: Integers
    """(cells,) the last disc of a cell, -1 if none"""
    below: Integers
    """(N,) the next one in the same cell"""
    periods: Array


def place_at_random(radius: Array, region: Region, taken: tuple[Array, Array], seed: int) -> Array:
    """The centers of discs that overlap neither each other, nor the walls, nor existing discs (`taken`: centers,
    radii). The largest discs are placed first, each at uniformly random points of the region until it fits. Raises
    BadInput, with the number that would fit, if that fails: random placement jams when a little more than half of the
    surface is covered.
    """
    centers = np.concatenate([taken[0].reshape(-1, 2), np.zeros((len(radius), 2))])
    radii = np.concatenate([taken[1], np.sort(radius)[::-1]])
    grid = _make_grid(region, radii)
    start = len(taken[1])
    if _covered(radii, region) > _most_covered(radii, start):
        raise BadInput(_overfull(radii, start, region))
    for disc in range(start):
        _put(grid, centers, disc)
    generator = np.random.default_rng(seed)
    low, span = np.array(region.low), np.array(region.high) - np.array(region.low)
    placed, tries = start, 0
    while placed < len(radii):
        points = low + span * generator.random((max(64, 4 * (len(radii) - placed)), 2))
        placed = _fill(points, grid, centers, radii, placed, region.walls)
        tries += len(points)
        if tries > _most_tries(len(radii)):
            raise BadInput(_jammed(radii, start, placed, region))
    order = np.argsort(-radius, kind="stable")
    found = np.empty((len(radius), 2))
    found[order] = centers[start:]
    return found


def _most_covered(radii: Array, start: int) -> float:
    """The covered fraction above which random placement fails; equal discs jam earlier than unequal ones."""
    alike = start == 0 and radii[0] == radii[-1]
    return min(1.0, JAMMED + 1.0 / math.sqrt(len(radii))) if alike else 1.0


def _most_tries(count: int) -> int:
    return TRIES_PER_DISC * min(count, MANY) + TRIES_PER_DISC_OF_MANY * max(count - MANY, 0)


def _covered(radii: Array, region: Region) -> float:
    """The area of the discs over the area of the region."""
    area = (region.high[0] - region.low[0]) * (region.high[1] - region.low[1])
    return math.pi * float((radii**2).sum()) / min(area, rings.area(region.walls))


def _overfull(radii: Array, start: int, region: Region) -> str:
    """The error message for discs whose area exceeds that of the region."""
    covered = _covered(radii, region)
    placed = int(np.searchsorted(np.cumsum(radii**2), AT_RANDOM / covered * float((radii**2).sum())))
    return (
        f"together the floats would cover {covered:.0%} of the surface; random placement covers about {AT_RANDOM:.0%}"
        f"{_advice(radii, start, placed, region)}"
    )


def _jammed(radii: Array, start: int, placed: int, region: Region) -> str:
    """The error message of a failed placement, with a number or radius that would fit."""
    return (
        f"only {placed - start} of {len(radii) - start} floats found a free place at random; together they would cover "
        f"{_covered(radii, region):.0%} of the surface{_advice(radii, start, placed, region)}"
    )


def _advice(radii: Array, start: int, placed: int, region: Region) -> str:
    """The alternatives that fit: the number placed, smaller discs, or a lattice."""
    squares = np.cumsum(radii**2)
    advice, container = [], "cell" if region.periodic else "dish"
    if placed > start:
        smaller = SURE * math.sqrt(squares[placed - 1] / squares[-1])
        smaller = math.floor(100.0 * smaller) / 100.0 or float(f"{0.9 * smaller:.1g}")
        advice.append(f"radii up to {smaller:g} times these; or a {container} {1.0 / smaller:.3g} times as wide")
    if start == 0 and radii.min() == radii.max() and not region.periodic:
        advice += _advice_on_equal_discs(len(radii), float(radii[0]), placed, region)
    return f". What fits: {'; or '.join(advice)}" if advice else f"; a larger {container} would do"


def _advice_on_equal_discs(count: int, radius: float, placed: int, region: Region) -> list[str]:
    """The numbers of discs that fit, at random and on a lattice."""
    advice = [f"at most {math.ceil(SURE**2 * placed)} floats"] if placed else []
    spacing = _rounded_up(2.0 * radius * (1.0 + CLEARANCE))
    room = lattice_room(count, spacing, radius, region)
    if room == count:
        advice.append(f'placement = "lattice" with spacing = "{1e3 * spacing:.6g} mm", on which all of them fit')
    elif room > placed:
        advice.append(f'{room} floats with placement = "lattice" and spacing = "{1e3 * spacing:.6g} mm"')
    return advice


def _rounded_up(length: float) -> float:
    """Round up to four digits."""
    digit = 10.0 ** (math.floor(math.log10(length)) - 3)
    return float(f"{math.ceil(length / digit) * digit:.4g}")


def lattice_room(count: int, spacing: float, radius: float, region: Region) -> int:
    """The number of discs, up to `count`, that fit on a lattice around the center of a region without touching its
    walls.
    """
    middle = (0.5 * (region.low[0] + region.high[0]), 0.5 * (region.low[1] + region.high[1]))
    for number, (x, y) in enumerate(place_on_lattice(count, spacing, middle)):
        if any(distance < radius for distance in rings.clearances(region.walls, (x, y))):
            return number
    return count


def _make_grid(region: Region, radii: Array) -> _Grid:
    span = np.array(region.high) - np.array(region.low)
    size = max(2.0 * float(radii.max()), math.sqrt(float(np.prod(span)) / (4 * len(radii) + 64)))
    counts = np.floor(span / size) if region.periodic else np.ceil(span / size)
    shape = np.maximum(counts, 1.0).astype(np.int64)
    edge = span / shape if region.periodic else np.full(2, size)
    cells = int(np.prod(shape))
    return _Grid(
        np.array(region.low), edge, shape, np.full(cells, -1, np.int64), np.full(len(radii), -1, np.int64),
        region.periods,
    )  # fmt: skip


@compiled
def _cell_along(grid: _Grid, axis: int, coordinate: float) -> int:
    along = int((coordinate - grid.low[axis]) / grid.size[axis])
    return min(max(along, 0), int(grid.shape[axis]) - 1)


@compiled
def _put(grid: _Grid, centers: Array, disc: int) -> None:
    cell = _cell_along(grid, 0, centers[disc, 0]) * grid.shape[1] + _cell_along(grid, 1, centers[disc, 1])
    grid.below[disc] = grid.head[cell]
    grid.head[cell] = disc


@compiled
def _fits(grid: _Grid, centers: Array, radii: Array, disc: int, walls: Walls) -> bool:
    """Whether the disc overlaps no wall and no earlier disc."""
    x, y, radius = centers[disc, 0], centers[disc, 1], radii[disc] * (1.0 + CLEARANCE)
    for number in range(wall_count(walls)):
        if wall_distance(walls, number, x, y)[0] < radius:
            return False
    column, row = _cell_along(grid, 0, x), _cell_along(grid, 1, y)
    periods, columns, rows = grid.periods, grid.shape[0], grid.shape[1]
    periodic = periods[0, 0] > 0.0
    for beside in range(column - 1, column + 2):
        for above in range(row - 1, row + 2):
            if not periodic and not (0 <= beside < columns and 0 <= above < rows):
                continue
            other = grid.head[beside % columns * rows + above % rows]
            while other >= 0:
                along = nearest(centers[other, 0] - x, periods[0, 0], periods[1, 0])
                across = nearest(centers[other, 1] - y, periods[0, 1], periods[1, 1])
                if math.sqrt(along**2 + across**2) < radius + radii[other]:
                    return False
                other = grid.below[other]
    return True


@compiled
def _fill(points: Array, grid: _Grid, centers: Array, radii: Array, placed: int, walls: Walls) -> int:
    """Place the next discs at the first points where they fit. Returns the number placed so far."""
    for k in range(len(points)):
        if placed == len(radii):
            break
        centers[placed, 0], centers[placed, 1] = points[k, 0], points[k, 1]
        if _fits(grid, centers, radii, placed, walls):
            _put(grid, centers, placed)
            placed += 1
    return placed


def place_on_lattice(count: int, spacing: float, center: Sequence[float]) -> Array:
    """The `count` points of a triangular lattice that are nearest to its center.

    >>> place_on_lattice(1, 1.0, (2.0, 3.0)).tolist()
    [[2.0, 3.0]]
    """
    rings = math.ceil(math.sqrt(count)) + 1
    first, second = np.meshgrid(np.arange(-rings, rings + 1), np.arange(-rings, rings + 1))
    points = np.stack([(first + 0.5 * second).ravel(), (math.sqrt(0.75) * second).ravel()], axis=1)
    # Rounded, so that points at equal distances have the same order on every machine.
    distance = np.round(np.hypot(points[:, 0], points[:, 1]), 9)
    angle = np.round(np.arctan2(points[:, 1], points[:, 0]), 9)
    nearest = np.lexsort((angle, distance))[:count]
    placed: Array = np.asarray(center) + spacing * points[nearest]
    return placed


def place_on_ring(count: int, radius: float, center: Sequence[float]) -> Array:
    """Points at equal distances on a circle; the first is to the right of its center.

    >>> place_on_ring(2, 1.0, (0.0, 0.0)).round(9).tolist()
    [[1.0, 0.0], [-1.0, 0.0]]
    """
    angle = 2.0 * np.pi * np.arange(count) / count
    placed: Array = np.asarray(center) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return placed
