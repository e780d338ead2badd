"""Stream functions on grids from their changes along edges, by least squares.

The normal equations are Poisson's equation. They are solved by cosine transforms in a box whose sides are all open, by
sine transforms in a closed box without land, and otherwise by a sparse factorization, which is computed only once for
all instants with the same shut edges.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume.units import Array

Flags = NDArray[np.bool_]
Indices = NDArray[np.intp]
Fit = Callable[[Array, Array], Array]
"""The function at nodes (n_x, n_z) of its changes along x (n_x - 1, n_z) and along z (n_x, n_z - 1)."""


class Edges(NamedTuple):
    """The edges of a grid along which the function is constant, and its periods."""

    along: Flags
    """(n_x - 1, n_z)"""
    up: Flags
    """(n_x, n_z - 1)"""
    wrapped: tuple[int, ...]
    """the axes along which the function is periodic, up to the flux through a period"""

    def same_as(self, other: Edges) -> bool:
        """Whether both edges lead to the same fit."""
        alike = np.array_equal(self.along, other.along) and np.array_equal(self.up, other.up)
        return alike and self.wrapped == other.wrapped


class Fits:
    """The previous fit, which is reused for the next instant if the shut edges are the same."""

    def __init__(self) -> None:
        self._last: tuple[Edges, Fit] | None = None

    def of(self, edges: Edges) -> Fit:
        """The fit for some shut edges."""
        if self._last is None or not self._last[0].same_as(edges):
            self._last = edges, fit_of(edges)
        return self._last[1]


def fit_of(edges: Edges) -> Fit:
    """The fastest fit for some shut edges."""
    if not (edges.along.any() or edges.up.any() or edges.wrapped):
        return cosine_fit
    return sine_fit if _is_closed(edges) else sparse_fit(edges)


def _is_closed(edges: Edges) -> bool:
    """Whether all sides are walls, without further walls inside or periodic sides."""
    along, up = edges.along, edges.up
    sides = along[:, [0, -1]].all() and up[[0, -1]].all()
    inside = along[:, 1:-1].any() or up[1:-1].any()
    return bool(sides and not inside and not edges.wrapped and along.shape[1] > 2 and up.shape[0] > 2)


def _source(along: Array, up: Array) -> Array:
    """The right side of the normal equations."""
    source = np.zeros((up.shape[0], along.shape[1]))
    source[1:] += along
    source[:-1] -= along
    source[:, 1:] += up
    source[:, :-1] -= up
    return source


def cosine_fit(along: Array, up: Array) -> Array:
    """The fit in a box whose sides are open."""
    from scipy.fft import dctn, idctn

    source = _source(along, up)
    x, z = (2.0 - 2.0 * np.cos(np.pi * np.arange(n) / n) for n in source.shape)
    factor = x[:, None] + z
    factor[0, 0] = 1.0
    spectrum = dctn(source, norm="ortho") / factor
    spectrum[0, 0] = 0.0
    return np.asarray(idctn(spectrum, norm="ortho"))


def sine_fit(along: Array, up: Array) -> Array:
    """The fit in a closed box: zero on its sides."""
    from scipy.fft import dstn, idstn

    value = _source(along, up)
    x, z = (2.0 - 2.0 * np.cos(np.pi * np.arange(1, n - 1) / (n - 1)) for n in value.shape)
    inside = idstn(dstn(value[1:-1, 1:-1], type=1) / (x[:, None] + z), type=1)
    value[:] = 0.0
    value[1:-1, 1:-1] = inside
    return value


def sparse_fit(edges: Edges) -> Fit:
    """The fit with any shut edges and periods.

    All nodes that are connected by shut edges and periods share one unknown value. Further unknowns are the increments
    over periods that shut edges permit: none over a period that a wall or land spans.
    """
    from scipy import sparse
    from scipy.sparse.linalg import splu

    shape = (edges.up.shape[0], edges.along.shape[1])
    number, periods, allowed = _joined(edges)
    count = int(number.max()) + 1
    low, high = _along_edges(number.reshape(shape))
    rows, signs = np.arange(len(low)), np.repeat([-1.0, 1.0], len(low))
    changes = sparse.csr_array((signs, (np.tile(rows, 2), np.concatenate([low, high]))), (len(low), count))
    first, last = _along_edges(np.arange(math.prod(shape)).reshape(shape))
    rises = sparse.csr_array((periods[last] - periods[first]) @ allowed)
    # The function is determined up to a constant: the first value is set to zero.
    fixed = sparse.csr_array(([1.0], ([0], [0])), (1, count + allowed.shape[1]))
    matrix = sparse.vstack([sparse.hstack([changes, rises]), fixed]).tocsr()
    normal = (matrix.T @ matrix).tocsc()
    factors = splu(normal, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    def fit(along: Array, up: Array) -> Array:
        given = np.concatenate([along.ravel(), up.ravel(), [0.0]])
        found = factors.solve(matrix.T @ given)
        value: Array = found[number] + periods @ (allowed @ found[count:])
        return value.reshape(shape)

    return fit


def _along_edges(values: Indices) -> tuple[Indices, Indices]:
    """The values at the nodes at both ends of all edges."""
    low = np.concatenate([values[:-1].ravel(), values[:, :-1].ravel()])
    return low, np.concatenate([values[1:].ravel(), values[:, 1:].ravel()])


def _joined(edges: Edges) -> tuple[Indices, Array, Array]:
    """For each node the group of nodes with the same value up to increments over periods, and the number of periods to
    the first node of the group along both axes; and the permitted increments (columns).
    """
    from scipy import sparse
    from scipy.linalg import null_space
    from scipy.sparse.csgraph import connected_components

    place = np.arange(edges.up.size + edges.up.shape[0]).reshape(edges.up.shape[0], -1)
    one, other = _along_edges(place)
    shut = np.concatenate([edges.along.ravel(), edges.up.ravel()])
    joins = sparse.coo_array((np.ones(int(shut.sum())), (one[shut], other[shut])), (place.size, place.size))
    count, patch = connected_components(joins, directed=False)
    group, periods, loops = _spread(count, _across_periods(patch.reshape(place.shape).astype(np.intp), edges.wrapped))
    loops |= {(int(axis == 0), int(axis == 1)) for axis in (0, 1) if axis not in edges.wrapped}
    barred = np.array(sorted(loops), dtype=np.float64)
    return group[patch], periods[patch], null_space(barred) if loops else np.eye(2)


Neighbors = dict[int, list[tuple[int, int, int]]]
"""The patches that continue each one across periods: patch, axis, and up or down"""


def _spread(count: int, neighbors: Neighbors) -> tuple[Indices, Array, set[tuple[int, int]]]:
    """The group of each patch, its periods from the first patch of the group, and the periods around which groups
    close.
    """
    group, periods, loops = [-1] * count, [(0, 0)] * count, set[tuple[int, int]]()
    groups = 0
    for start in range(count):
        if group[start] >= 0:
            continue
        group[start], reached = groups, [start]
        for here in reached:
            for there, axis, sign in neighbors.get(here, ()):
                x, z = periods[here]
                far = (x + sign, z) if axis == 0 else (x, z + sign)
                if group[there] < 0:
                    group[there], periods[there] = groups, far
                    reached.append(there)
                else:
                    loops.add((far[0] - periods[there][0], far[1] - periods[there][1]))
        groups += 1
    return np.array(group), np.array(periods, dtype=np.float64), loops - {(0, 0)}


def _across_periods(patches: Indices, wrapped: tuple[int, ...]) -> Neighbors:
    found = Neighbors()
    for axis in wrapped:
        for low, high in zip(*(np.take(patches, side, axis).tolist() for side in (0, -1)), strict=True):
            found.setdefault(low, []).append((high, axis, 1))
            found.setdefault(high, []).append((low, axis, -1))
    return found
