"""Pair forces of crowds whose menisci reach over thousands: neighbors in lists, all the others on a grid.

K0 is split in two (`laws.split`). The short part is summed over neighbor lists as ever. Charges are spread over a grid
by splines, transformed, multiplied by the smooth part's waves, and the field is read back with the same splines: so
what two floats do to each other cancels to rounding, and nobody pushes itself. The grid lies around where everyone was
when the lists were made, which is a part of the state. The march is Python around compiled parts, since transforms are
SciPy's, imported where it is needed only; a crowd's step takes long enough.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume._portable import exp, log, power, sinc
from ecume.engine import grid_splines
from ecume.engine.cells import Integers
from ecume.engine.neighbors import NeighborLists, Slots
from ecume.laws import ewald as splitting
from ecume.laws.ewald import smooth_self_energy, smooth_wave, smooth_wave_within
from ecume.laws.pair_laws import Short
from ecume.models.floating.parameters import (
    CAPILLARY_LENGTH,
    CUTOFF,
    INVERSE_SQUARE,
    STRENGTH,
    Parameters,
)
from ecume.models.floating.state import State, Workspace
from ecume.models.floating.summing import Split
from ecume.units import Array

WORKERS = 4
"""Parts that a transform is done in, whatever the machine: so that bits do not depend on it."""
RUNGS = 4
"""A crowd's extent is rounded up to a power of 2^(1/4), so that most new lists find the waves of the old."""
TABLE = 16384
"""Places at which the short part's energy is tabled, over the logarithm of the distance."""


class Grid(NamedTuple):
    """A grid around a crowd."""

    low: Array
    """(2,) m: its first point"""
    shape: tuple[int, int]
    reach: float
    """in capillary lengths: where K0 is cut off before it is smoothed; infinite where copies are far enough"""


def grid_around(split: Split, reference: Array, length: float) -> Grid:
    """Room for the crowd, for splines beyond its edges, and for as much nothing as keeps its copies apart."""
    low = reference.min(axis=0) - split.margin
    span = reference.max(axis=0) + split.margin - low
    rungs = np.ceil(RUNGS * log(span / split.spacing) / math.log(2.0))
    from scipy import fft

    extent = split.spacing * exp(math.log(2.0) * rungs / RUNGS)
    diagonal = float(np.hypot(*extent))
    soft = 2.0 * math.sqrt(splitting.FARTHEST * split.eta) * length
    near = diagonal + soft < split.far
    apart = diagonal + 2.0 * soft if near else split.far
    rows, columns = (math.ceil(each / split.spacing) + 2 * split.order for each in extent + apart)
    shape = fft.next_fast_len(rows, real=True), fft.next_fast_len(columns, real=True)
    reach = (diagonal + soft) / length if near else math.inf
    return Grid(low - split.order * split.spacing, shape, reach)


class Waves(NamedTuple):
    """What the transform of the charges is multiplied by."""

    potential: Array
    """(rows, columns/2 + 1)"""
    along: Array
    """(rows, 1) wavenumbers along x, over the capillary length"""
    across: Array
    """(1, columns/2 + 1) and along y"""


@lru_cache(maxsize=2)
def waves_of(shape: tuple[int, int], spacing: float, eta: float, order: int, reach: float) -> Waves:
    """The smooth part on a grid of that spacing (capillary lengths), and what undoes the splines, twice.

    [hockney1988, eq. 8-22]: the factor for which forces err least, U^2/(sum U^2)^2 for each axis.
    """
    from scipy import fft

    along = 2.0 * np.pi / spacing * fft.fftfreq(shape[0])[:, None]
    across = 2.0 * np.pi / spacing * fft.rfftfreq(shape[1])[None, :]
    squared = along**2 + across**2
    smooth = smooth_wave(squared, eta) if math.isinf(reach) else smooth_wave_within(squared, eta, reach)
    # The highest wave of an even grid has no slope.
    odd = along.copy(), across.copy()
    if shape[0] % 2 == 0:
        odd[0][shape[0] // 2] = 0.0
    if shape[1] % 2 == 0:
        odd[1][:, -1] = 0.0
    undone = _undone(along[:, 0] * spacing, order)[:, None] * _undone(across[0] * spacing, order)[None, :]
    return Waves(smooth * undone / spacing**2, *odd)


def _undone(phase: Array, order: int) -> Array:
    """U^2/(sum U^2)^2 of one axis."""
    share = np.asarray(splitting.spline_share(phase, order))
    kept: Array = share * share / power(sinc(phase / (2.0 * np.pi)), 2 * order)
    return kept


def transformed(split: Split, position: Array, charge: Array, grid: Grid, length: float) -> tuple[Any, Any, Waves]:
    """Where everyone is on the grid, the transform of the smooth potential, and the waves."""
    from scipy import fft

    spread = grid_splines.spread_out(position, grid.low, split.spacing, grid.shape[0], split.order)
    waves = waves_of(grid.shape, split.spacing / length, split.eta, split.order, grid.reach)
    spectrum = fft.rfft2(grid_splines.density(spread, charge, grid.shape), workers=WORKERS)
    spectrum *= waves.potential
    return spread, spectrum, waves


def add_smooth_forces(parameters: Parameters, split: Split, position: Array, grid: Grid, force: Array) -> None:
    """The smooth part's forces: S A grad(sum of A T), S = 2 pi gamma; towards where the potential is higher."""
    from scipy import fft

    charge, length = parameters.floats.charge, float(parameters.pair[CAPILLARY_LENGTH])
    spread, spectrum, waves = transformed(split, position, charge, grid, length)
    slopes = np.stack([
        fft.irfft2(1j * wavenumber * spectrum, s=grid.shape, workers=WORKERS)
        for wavenumber in (waves.along, waves.across)
    ])  # fmt: skip
    force += float(parameters.pair[STRENGTH]) / length * charge[:, None] * grid_splines.fields(spread, slopes)


def split_energy(
    part: Split, own: Any, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """The energy of all pairs (J), those of the short part included: zero when all are far apart."""
    from scipy import fft

    split, pair, charge = part, parameters.pair, parameters.floats.charge
    length, rows = float(pair[CAPILLARY_LENGTH]), workspace.lists.rows
    grid = grid_around(split, state.reference, length)
    spread, spectrum, _ = transformed(split, state.position, charge, grid, length)
    potential = fft.irfft2(spectrum, s=grid.shape, workers=WORKERS)[None]
    alone = smooth_self_energy(split.eta) * charge
    smooth = 0.5 * float(np.sum(charge * (grid_splines.fields(spread, potential)[:, 0] - alone)))
    listed = rows.first, rows.neighbor, workspace.lists.cells.order
    short = sum_of_short_energies(state.position, charge, listed, *_short_table(pair, split.short, split.eta))
    return -float(pair[STRENGTH]) * (smooth + short), 0.0


def _short_table(pair: Array, short: Short, eta: float) -> tuple[Array, Array]:
    """The short part over the logarithm of the squared distance (m^2); and from where to where."""
    ends = log(np.array([(0.1 * short.lower * pair[CAPILLARY_LENGTH]) ** 2, pair[CUTOFF] ** 2]))
    x = np.sqrt(exp(np.linspace(float(ends[0]), float(ends[1]), TABLE)) * pair[INVERSE_SQUARE])
    return ends, np.asarray(splitting.short_energy(x, eta))


@compiled
def sum_of_short_energies(
    position: Array, charge: Array, listed: tuple[Integers, Slots, Integers], ends: Array, table: Array
) -> float:
    """The short part's energies of all pairs, over S."""
    first, neighbor, order = listed
    total, scale, farthest = 0.0, (len(table) - 1) / (ends[1] - ends[0]), math.exp(ends[1])
    for slot in range(len(order)):
        i, own = order[slot], 0.0
        for place in range(first[slot], first[slot + 1]):
            j = order[neighbor[place]]
            x, y = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
            square = x * x + y * y
            if i < j and square < farthest:
                at = max((math.log(square) - ends[0]) * scale, 0.0)
                node = min(int(at), len(table) - 2)
                own += charge[j] * (table[node] + (at - node) * (table[node + 1] - table[node]))
        total += own * charge[i]
    return total


class Reference(NamedTuple):
    """Scratch: where everyone was when the lists were made, around which the grid lies."""

    position: Array
    """(N, 2) that of the state"""


def make_reference(part: Split, parameters: Parameters, state: State, workspace: Workspace) -> Reference:
    """Scratch."""
    return Reference(state.reference)


def smooth_forces(
    part: Split, own: Reference, parameters: Parameters, position: Array, lists: NeighborLists, force: Array
) -> None:
    """Add the forces of the smooth part. In Python, since SciPy transforms."""
    length = float(parameters.pair[CAPILLARY_LENGTH])
    add_smooth_forces(parameters, part, position, grid_around(part, own.position, length), force)
