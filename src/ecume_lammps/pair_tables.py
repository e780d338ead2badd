"""Pair laws as tables of distance, energy and force for LAMMPS, dense enough for the stated accuracy."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from ecume.models.floating.forces.pair_forces import law_of, row_of, two_floats
from ecume.models.floating.parameters import PairParameters, Parameters
from ecume.units import Array

if TYPE_CHECKING:
    pass
from ecume_lammps.numbers import FEWEST, MOST, DeckNumbers

ACCURACY = 1e-7
"""Error of the force of a table over the force at the same distance."""
OVERLAP = 0.1
"""Overlap over the sum of two radii at which tables begin. LAMMPS stops at shorter distances."""
BEYOND = 1.1
"""The end of the tables over the cutoff: LAMMPS estimates the slopes at both ends, which affects only a few rows."""
PER_NEAREST = 100
"""Values of a table in memory from r^2 = 0 to that of the nearest pair: LAMMPS's spline between them has an error of
1e-8.
"""
MOST_VALUES = 100_000
"""The largest number of values of a table in memory. Tables over a wider range are spaced by octaves."""
BITS_PER_OCTAVE = 11
"""LAMMPS interpolates linearly between 2^11 values from one r^2 to twice that value, with an error below 1e-7."""


class PairTable(NamedTuple):
    """The table of a pair of kinds of floats."""

    kinds: tuple[int, int]
    name: str
    distance: Array
    energy: Array
    force: Array
    """N, positive if repulsive"""


def lookup_of(parameters: Parameters) -> str:
    """The table lookup of LAMMPS: a spline over r^2, or the bits of r^2 if the widest table spans too many decades."""
    nearest = 2.0 * (1.0 - OVERLAP) * float(parameters.floats.radius.min())
    ratio = (BEYOND * max(parameters.cutoff, nearest) / nearest) ** 2
    if PER_NEAREST * ratio <= MOST_VALUES:
        return f"spline {math.ceil(PER_NEAREST * ratio)}"
    return f"bitmap {BITS_PER_OCTAVE + math.ceil(math.log2(math.log2(ratio))) + 1}"


def pair_tables(deck: DeckNumbers) -> Iterator[PairTable]:
    """A table for each pair of kinds; empty if the pair law has no force."""
    if not row_of(deck.parameters).has_force:
        return
    for i, j in itertools.combinations_with_replacement(range(len(deck.kinds)), 2):
        yield pair_table(deck, i, j)


def pair_table(deck: DeckNumbers, i: int, j: int) -> PairTable:
    """The table of two kinds, at distances that are evenly spaced in their logarithm."""
    count = FEWEST
    while True:
        nodes = _nodes(deck, i, j, count)
        force = _forces(deck, i, j, nodes)
        between = np.sqrt(nodes[1:] * nodes[:-1])
        exact = _forces(deck, i, j, between)
        error = np.abs(CubicSpline(nodes, force)(between) - exact)
        used = (between > (1.0 - 0.5 * OVERLAP) / (1.0 - OVERLAP) * nodes[0]) & (between <= deck.parameters.cutoff)
        if count >= MOST or np.all(error[used] <= 0.5 * ACCURACY * np.abs(exact[used])):
            return PairTable((i, j), f"K{i + 1}_K{j + 1}", nodes, _energies(deck, i, j, nodes, force), force)
        count *= 2


def _nodes(deck: DeckNumbers, i: int, j: int, count: int) -> Array:
    radius = deck.parameters.floats.radius[deck.first]
    near = (1.0 - OVERLAP) * float(radius[i] + radius[j])
    return np.geomspace(near, BEYOND * max(deck.parameters.cutoff, near), count)


def _forces(deck: DeckNumbers, i: int, j: int, distance: Array) -> Array:
    """The law of the scene at these distances."""
    row, law, own = row_of(deck.parameters), law_of(deck.parameters), _two(deck, i, j)
    return np.array([float(row.force(each, own, law)) for each in distance.tolist()])


def _energies(deck: DeckNumbers, i: int, j: int, distance: Array, force: Array) -> Array:
    """The energy of the law, zero at the cutoff; the integral of the force if the law has none."""
    row, law, own, cutoff = row_of(deck.parameters), law_of(deck.parameters), _two(deck, i, j), deck.parameters.cutoff
    if row.energy is None:
        integral = CubicSpline(distance, force).antiderivative()
        return np.asarray(integral(cutoff) - integral(distance))
    at_cutoff = float(row.energy(cutoff, own, law))
    return np.array([float(row.energy(each, own, law)) - at_cutoff for each in distance.tolist()])


def _two(deck: DeckNumbers, i: int, j: int) -> PairParameters:
    floats, (a, b) = deck.parameters.floats, deck.first[[i, j]]
    radius, charge = floats.radius.tolist(), floats.charge.tolist()
    return two_floats(deck.parameters, (radius[a], radius[b]), (charge[a], charge[b]))


def text_of(table: PairTable) -> str:
    """The section of a table in a file of LAMMPS."""
    columns = zip(table.distance.tolist(), table.energy.tolist(), table.force.tolist(), strict=True)
    rows = [f"{number} {r!r} {energy!r} {force!r}" for number, (r, energy, force) in enumerate(columns, 1)]
    return "\n".join([table.name, f"N {len(rows)}", "", *rows, "", ""])
