"""Hydrodynamic interaction of many floats by products with the mobility instead of its matrix.

Forces, contacts and noise need only products with the mobility, which is split in two parts (`laws.ewald`). The
short-range part is a sparse matrix of near pairs. For the smooth part, forces are assigned to a grid by splines,
convolved with the flow of a point force by fast Fourier transforms, and velocities are interpolated with the same
splines, so that the product is symmetric. The grid has twice the extent of the floats and no periodic images.
Velocities err by `ERROR` of their r.m.s. value for forces of random sign. All sums have a fixed order, for any number
of threads.

Python runs the time steps and calls compiled parts, because the Fourier transforms are SciPy functions.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._jit import admit, compiled, compiled_inside, prange, threaded
from ecume.engine import interpolation
from ecume.engine.cells import Integers, make_cells, sort_into_cells
from ecume.engine.interpolation import Spread
from ecume.laws import ewald, pair_mobility
from ecume.laws.ewald import smooth_curvature, smooth_flow, spline_correction
from ecume.laws.pair_mobility import rotne_prager
from ecume.units import Array

admit(pair_mobility, ewald)

ERROR = 1e-4
"""R.m.s. error of velocities by forces of random sign, over the r.m.s. velocity."""
ORDER = 6
"""of the splines"""
WIDTH = 2.3
"""Width of the split over the spacing of the grid."""
CUTOFF = 3.2
"""Cutoff of the short-range part over the width."""
WORKERS = 4
"""Threads of a transform on every machine, so that bits do not depend on it."""
MARGIN = 32
"""Points beyond twice the extent, where the correction for splines decays."""
RUNGS = 4
"""Extents are rounded up to a power of 2^(1/4), so that most grids share the same transformed flow."""
PAIR, POINT = 4.0, 60.0
"""ns: work of a near pair and of a grid point, for each product."""
COARSER = 12
"""Number of grids that are compared, each sqrt(2) times coarser than the last."""
FINEST, LEAST = 1.2, 0.5
"""Spacing of the finest grid: over the r.m.s. radius, and over the largest radius at least. Finer grids are less
accurate: the smooth part of large spheres has short waves."""
XX, XY, YY, ALONG, ACROSS = range(5)
"""Fields of the transformed flow: three components, and the two of the divergence."""

Shape = tuple[int, int]


class NearPairs(NamedTuple):
    """The short-range part as a sparse matrix of 2 x 2 blocks, including the block of each float itself."""

    first: Integers
    """(N + 1,)"""
    partner: Integers
    """(pairs,)"""
    block: Array
    """(pairs, 3) xx, xy and yy, times 6 pi eta"""


class FlowGrid(NamedTuple):
    """The data of a product with the mobility at one set of positions."""

    unit: float
    """1/(3 pi eta)"""
    width: float
    """m: of the split"""
    radius: Array
    """(N,) m: hydrodynamic radii"""
    near: NearPairs
    spread: Spread
    weight: Array
    """(P, N) ones, and the squared radii if they differ"""
    flow: Array
    """(P, P, 3, rows, columns/2 + 1) the transformed flow between two of these weights"""
    divergence: Array
    """(P, P, 2, rows, columns/2 + 1) that of the divergence, divided by i; empty without thermal noise"""
    shape: Shape


def place_flow_grid(position: Array, radius: Array, viscosity: float, drifting: bool) -> FlowGrid:
    """Return the grid around all floats; `drifting` if the divergence of the mobility is required."""
    spacing = best_spacing(position, radius)
    width, low = WIDTH * spacing, position.min(axis=0) - ORDER * spacing
    shape = shape_around(np.ptp(position, axis=0), spacing)
    near = near_pairs(position, radius, width)
    spread = interpolation.spread_out(position, low, spacing, shape[0], ORDER)
    equal = float(np.ptp(radius)) == 0.0
    weight = np.ones((1, len(radius))) if equal else np.stack([np.ones(len(radius)), radius * radius])
    square = 2.0 * float(radius[0]) ** 2 if equal else 0.0
    flow = _between_weights(*_transformed(shape, XX, YY), spacing, square, equal)
    divergence = np.zeros((1, 1, 2, 0, 0))
    if drifting:
        single, double = _transformed(shape, ALONG, ACROSS)
        divergence = _between_weights(single / spacing, double / spacing, spacing, square, equal)
    return FlowGrid(1.0 / (3.0 * math.pi * viscosity), width, radius, near, spread, weight, flow, divergence, shape)


def _between_weights(flow: Array, curvature: Array, spacing: float, square: float, equal: bool) -> Array:
    """The weights of the fields, S + (a^2 + b^2) D in SI units: one field for equal floats, otherwise fields between
    the weights 1 and a^2.
    """
    single, double = flow / spacing, curvature / spacing**3
    if equal:
        return np.asarray((single + square * double)[None, None])
    return np.stack([np.stack([single, double]), np.stack([double, np.zeros_like(double)])])


def shape_around(span: Array, spacing: float) -> Shape:
    """The grid, without periodic images, for floats within a rectangle of size `span`."""
    from scipy import fft

    points = np.maximum(span / spacing, 1.0) + 2.0 * ORDER
    rungs = 2.0 ** (np.ceil(RUNGS * np.log2(points)) / RUNGS)
    rows, columns = (math.ceil(2.0 * each) + MARGIN for each in rungs)
    return fft.next_fast_len(rows, real=True), fft.next_fast_len(columns, real=True)


def best_spacing(position: Array, radius: Array) -> float:
    """The spacing with the least work, among powers of sqrt(2) times that of the finest grid."""
    span = np.ptp(position, axis=0)
    finest = max(FINEST * math.sqrt(float(np.mean(radius * radius))), LEAST * float(radius.max()))
    best, least = finest, math.inf
    for number in range(COARSER):
        spacing = finest * math.sqrt(2.0) ** number
        points = math.prod(shape_around(span, spacing)) if float(span.max()) < 1e5 * spacing else math.inf
        work = POINT * points + PAIR * _pairs_within(position, CUTOFF * WIDTH * spacing)
        if work < least:
            best, least = spacing, work
    return best


def _pairs_within(position: Array, reach: float) -> float:
    """The approximate number of ordered pairs within a distance, from the occupation of squares of this size."""
    column = np.floor((position - position.min(axis=0)) / reach).astype(np.int64)
    _, counts = np.unique(column[:, 0] * (int(column[:, 1].max()) + 1) + column[:, 1], return_counts=True)
    return min(math.pi * float(np.sum(counts.astype(np.float64) ** 2)), float(len(position)) ** 2)


@lru_cache(maxsize=4)
def _transformed(shape: Shape, first: int, last: int) -> tuple[Array, Array]:
    """The Fourier transforms of smooth S and D on a grid of spacing 1, for fields from `first` to `last`, corrected for
    splines; odd fields are divided by i.
    """
    from scipy import fft

    sampled = np.empty((2, last - first + 1, *shape))
    sample_flow(sampled, first)
    along, across = (2.0 * np.pi * each for each in (fft.fftfreq(shape[0]), fft.rfftfreq(shape[1])))
    correction = spline_correction(along, ORDER)[:, None] * spline_correction(across, ORDER)[None, :]
    waves = fft.rfft2(sampled, workers=WORKERS)
    single, double = (waves.imag if first == ALONG else waves.real) * correction
    return single, double


@compiled
def sample_flow(sampled: Array, first: int) -> None:
    """Fill the fields with their values at the distances of periodic grid points, in units of the spacing."""
    rows, columns = sampled.shape[2], sampled.shape[3]
    for row in range(rows):
        x = float(row if 2 * row < rows else row - rows)
        for column in range(columns):
            y = float(column if 2 * column < columns else column - columns)
            distance = math.sqrt(x * x + y * y)
            # Odd fields vanish on the edge, whose distance is the same in both directions.
            edge = 2 * row == rows or 2 * column == columns
            for kind in range(2):
                across, along = smooth_parts(kind, distance)
                skew = (along - across) / (distance * distance) if distance > 0.0 else 0.0
                if first == XX:
                    sampled[kind, XX, row, column] = across + skew * x * x
                    sampled[kind, XY, row, column] = 0.0 if edge else skew * x * y
                    sampled[kind, YY, row, column] = across + skew * y * y
                else:
                    sampled[kind, 0, row, column] = 0.0 if edge else skew * x
                    sampled[kind, 1, row, column] = 0.0 if edge else skew * y


@compiled_inside
def smooth_parts(kind: int, distance: float) -> tuple[float, float]:
    """The smooth part S (kind 0) or D (kind 1) at a distance, for the splitting width of this module; lengths in
    spacings.
    """
    if kind == 0:
        across, along = smooth_flow(distance / WIDTH)
        return across / WIDTH, along / WIDTH
    across, along = smooth_curvature(distance / WIDTH)
    return across / WIDTH**3, along / WIDTH**3


def near_pairs(position: Array, radius: Array, width: float) -> NearPairs:
    """The short-range part of all pairs within the cutoff."""
    cells, reach = make_cells(len(position), 2), CUTOFF * width
    sort_into_cells(cells, position, reach)
    first = np.zeros(len(position) + 1, np.int64)
    _count_near(position, reach, (cells.cell, cells.shape, cells.start, cells.order), first)
    np.cumsum(first, out=first)
    near = NearPairs(first, np.empty(first[-1], np.int64), np.empty((first[-1], 3)))
    _list_near(position, reach, (cells.cell, cells.shape, cells.start, cells.order), first, near.partner)
    _fill_near(position, radius, width, first, near.partner, near.block)
    return near


@compiled_inside
def _corner_cells(cell: int, shape: Integers) -> tuple[int, int, int, int]:
    """The rows and columns of the cells around a cell: the first of each, and one after the last."""
    row, column = cell // shape[1], cell % shape[1]
    return max(row - 1, 0), min(row + 2, shape[0]), max(column - 1, 0), min(column + 2, shape[1])


@threaded
def _count_near(
    position: Array, reach: float, cells: tuple[Integers, Integers, Integers, Integers], first: Integers
) -> None:
    """Count the floats near each float, itself included, and write the number after its entry in `first`."""
    of, shape, start, order = cells
    for i in prange(len(position)):
        found = 0
        low, high, left, right = _corner_cells(of[i], shape)
        for row in range(low, high):
            for place in range(start[row * shape[1] + left], start[row * shape[1] + right]):
                j = order[place]
                x, y = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
                found += 1 if x * x + y * y < reach * reach else 0
        first[i + 1] = found


@threaded
def _list_near(
    position: Array,
    reach: float,
    cells: tuple[Integers, Integers, Integers, Integers],
    first: Integers,
    partner: Integers,
) -> None:
    """Write the list of near floats of each float."""
    of, shape, start, order = cells
    for i in prange(len(position)):
        spot = first[i]
        low, high, left, right = _corner_cells(of[i], shape)
        for row in range(low, high):
            for place in range(start[row * shape[1] + left], start[row * shape[1] + right]):
                j = order[place]
                x, y = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
                if x * x + y * y < reach * reach:
                    partner[spot] = j
                    spot += 1


@compiled_inside
def short_parts(distance: float, radius: float, other: float, width: float) -> tuple[float, float]:
    """The mobility of two floats minus its smooth part: across and along the line of centers, times 6 pi eta."""
    across, along = rotne_prager(distance, radius, other)
    single, double = smooth_flow(distance / width), smooth_curvature(distance / width)
    square, cube = radius * radius + other * other, width * width * width
    across -= single[0] / width + square * double[0] / cube
    return across, along - single[1] / width - square * double[1] / cube


@threaded
def _fill_near(position: Array, radius: Array, width: float, first: Integers, partner: Integers, block: Array) -> None:
    """Write the blocks of all near pairs."""
    for i in prange(len(position)):
        for place in range(first[i], first[i + 1]):
            j = partner[place]
            x, y = position[i, 0] - position[j, 0], position[i, 1] - position[j, 1]
            distance = math.sqrt(x * x + y * y)
            across, along = short_parts(distance, radius[i], radius[j], width)
            # At zero distance the mobility is isotropic.
            skew = (along - across) / (distance * distance) if distance > 0.0 else 0.0
            block[place, 0] = across + skew * x * x
            block[place, 1] = skew * x * y
            block[place, 2] = across + skew * y * y


@threaded
def _multiply_near(first: Integers, partner: Integers, block: Array, force: Array, product: Array) -> None:
    """Write the product with the sparse matrix."""
    for i in prange(len(product)):
        along, across = 0.0, 0.0
        for place in range(np.uint64(first[i]), np.uint64(first[i + 1])):
            j = np.uint64(partner[place])
            along += block[place, 0] * force[j, 0] + block[place, 1] * force[j, 1]
            across += block[place, 1] * force[j, 0] + block[place, 2] * force[j, 1]
        product[i, 0], product[i, 1] = along, across


@threaded
def _diverge_near(
    position: Array, radius: Array, width: float, first: Integers, partner: Integers, drift: Array
) -> None:
    """Write the sum over near pairs of the divergence of the short-range part."""
    for i in prange(len(drift)):
        along, across = 0.0, 0.0
        for place in range(first[i], first[i + 1]):
            j = partner[place]
            x, y = position[i, 0] - position[j, 0], position[i, 1] - position[j, 1]
            distance = math.sqrt(x * x + y * y)
            if distance > 0.0:
                sideways, ahead = short_parts(distance, radius[i], radius[j], width)
                along += (ahead - sideways) / (distance * distance) * x
                across += (ahead - sideways) / (distance * distance) * y
        drift[i, 0], drift[i, 1] = along, across


def flow_product(grid: FlowGrid, force: Array) -> Array:
    """The velocities (N, 2) by forces (N, 2): the product with the mobility of all floats."""
    from scipy import fft

    waves = [[_waves_of(grid, weight * force[:, axis]) for axis in range(2)] for weight in grid.weight]
    product = np.empty_like(force)
    _multiply_near(*grid.near, np.ascontiguousarray(force), product)
    for weight, flow in zip(grid.weight, grid.flow, strict=True):
        along, across = np.zeros_like(waves[0][0]), np.zeros_like(waves[0][0])
        for (x, y), part in zip(waves, flow, strict=True):
            along += part[XX] * x + part[XY] * y
            across += part[XY] * x + part[YY] * y
        fields = fft.irfft2(np.stack([along, across]), s=grid.shape, workers=WORKERS)
        product += weight[:, None] * interpolation.fields(grid.spread, fields)
    return grid.unit * product


def flow_divergence(grid: FlowGrid, position: Array) -> Array:
    """The divergence (N, 2) of the mobility of all floats (m/s per J)."""
    from scipy import fft

    waves = [_waves_of(grid, weight) for weight in grid.weight]
    drift = np.empty_like(position)
    _diverge_near(position, grid.radius, grid.width, grid.near.first, grid.near.partner, drift)
    for weight, flow in zip(grid.weight, grid.divergence, strict=True):
        total = sum(1j * part * wave for part, wave in zip(flow, waves, strict=True))
        fields = fft.irfft2(total, s=grid.shape, workers=WORKERS)
        drift += weight[:, None] * interpolation.fields(grid.spread, fields)
    return grid.unit * drift


def _waves_of(grid: FlowGrid, charge: Array) -> NDArray[np.complex128]:
    """The Fourier transform of charges on the grid."""
    from scipy import fft

    waves: NDArray[np.complex128] = fft.rfft2(interpolation.density(grid.spread, charge, grid.shape), workers=WORKERS)
    return waves


MATRIX_UP_TO = 1000
"""The largest number of floats with a matrix: with more, it needs gigabytes for contacts, and more time."""
