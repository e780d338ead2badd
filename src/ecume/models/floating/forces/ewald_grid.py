"""Pair forces of large systems whose menisci reach over thousands of floats: neighbor lists and an Ewald grid.

K0 is split in two parts (`laws.ewald`). The short-range part is summed over neighbor lists. For the other one, charges
are assigned to a grid by splines, transformed, multiplied by the waves of the smooth part, and the field is
interpolated with the same splines: therefore the forces between two floats cancel to rounding, and no float exerts a
force on itself. The grid covers the reference positions of the neighbor lists, which are part of the state. Python runs
the time steps and calls compiled parts, because the Fourier transforms are SciPy functions; this costs little for a
large system.

The first part of this file chooses the split: as the scene specifies, or by an estimate of the work. The second part
computes forces and energies.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume._portable import exp, log
from ecume.engine import interpolation
from ecume.engine.cells import Integers
from ecume.engine.neighbors import NeighborLists, Slots
from ecume.errors import BadInput
from ecume.laws import ewald
from ecume.laws.ewald import SplitFit, smooth_self_energy, smooth_wave, smooth_wave_within
from ecume.laws.pair_laws import Short, short_constants
from ecume.models.floating.options import scene_error
from ecume.models.floating.parameters import (
    CAPILLARY_LENGTH,
    CUTOFF,
    INVERSE_SQUARE,
    STRENGTH,
    Parameters,
    State,
    Workspace,
)
from ecume.models.floating.time_integration.step_size import PACKED
from ecume.units import Array, with_prefix

if TYPE_CHECKING:
    from ecume.scenes.floating import InteractionSpec


DEEPEST_TOUCH = 0.9
"""Pair laws are fitted down to this fraction of the smallest touching distance."""

SHARE = 0.6
"""Fractions of the error for the cutoff and for the grid: their squares add up."""

ORDERS = (4, 6, 8, 10, 12)
LOOSEST, FINEST = 1e-1, 1e-10
"""The range of accuracies of a grid."""

PAIR, POINT, SPLINE = 1.0, 7.0, 0.6
"""Work relative to that of a listed pair: of a grid point, including all transforms; of assigning a float to a point.
"""

STEPS = 60
"""Number of trial cutoffs between the touching distance and the cutoff."""

WORTH = 2000
"""Fewer floats are summed by cells: a time step in Python would cost more than it saves."""

GAIN = 2.0
"""A grid is chosen automatically if it reduces the work by this factor: time steps in Python have further costs."""

MOST_POINTS = 2**28
WIDEST = 0.1
"""Largest eta: above it, waves as long as the capillary length matter, which the error of the grid ignores."""


class Split(NamedTuple):
    """The constants of the split of the sum in a scene with a grid."""

    eta: float
    """in squares of the capillary length"""
    spacing: float
    """m, of the grid"""
    order: int
    """of the splines"""
    far: float
    """m: the cutoff without a grid"""
    margin: float
    """m: distance around the rectangle of the floats that the grid covers"""
    work: tuple[float, float]
    """estimated work of a time step, in pairs: with cells alone, and with the grid"""
    points: float
    """approximate number of grid points"""
    short: Short
    """constants of the short-range part, which is summed over pairs"""


@lru_cache(maxsize=32)
def _coarsest(order: int, error: float) -> float:
    """The largest spacing, over sqrt(eta), with an error below `error`."""
    low, high = 0.02, 3.0
    for _ in range(12):
        middle = math.sqrt(low * high)
        low, high = (low, middle) if ewald.grid_error(middle, order) > error else (middle, high)
    return low


@lru_cache(maxsize=32)
def _farthest(error: float) -> float:
    """The cutoff of the short-range part, as w = x^2/(4 eta)."""
    low, high = 1.0, ewald.FARTHEST
    while high - low > 1e-3:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if ewald.short_error(middle) > error else (low, middle)
    return high


class FloatStatistics(NamedTuple):
    """The statistics of the floats that determine the cost of a grid; lengths over the capillary length."""

    floats: int
    density: float
    """floats per squared capillary length: the geometric mean of the start and a raft"""
    side: float
    touching: float
    skin: float
    cutoff: float
    """with cells alone"""

    def neighbors(self, reach: float) -> float:
        """The number of neighbors of a float within a distance."""
        return min(float(self.floats), math.pi * self.density * (reach + self.skin) ** 2)


def statistics_of(parameters: Parameters, area: float) -> FloatStatistics:
    """The statistics of floats that cover this area (m^2) at the start."""
    length, radius = float(parameters.pair[CAPILLARY_LENGTH]), parameters.floats.radius
    area, count = area / length**2, len(radius)
    packed = PACKED * count / (math.pi * float(np.sum((radius / length) ** 2)))
    return FloatStatistics(
        floats=count,
        density=math.sqrt(packed * min(count / area, packed)),
        side=math.sqrt(area),
        touching=2.0 * float(radius.min()) / length,
        skin=parameters.skin / length,
        cutoff=parameters.cutoff / length,
    )


class Choice(NamedTuple):
    """One choice of the parameters of the split."""

    work: float
    """of a time step, in pairs"""
    eta: float
    spacing: float
    order: int
    cutoff: float
    points: float


_fit_short = lru_cache(maxsize=64)(ewald.fit_short)


def best_split(statistics: FloatStatistics, accuracy: float) -> tuple[Choice, SplitFit]:
    """The cheapest split of this accuracy (r.m.s. error of forces over their r.m.s. with charges of random sign), and
    its short-range law, whose error is at most a tenth of it.
    """
    for choice in sorted(_splits(statistics, accuracy)):
        fit = _fit_short(choice.eta, DEEPEST_TOUCH * statistics.touching, choice.cutoff)
        if fit.error < 0.1 * accuracy:
            return choice, fit
    raise BadInput("a grid cannot reach this accuracy here; use 'cells'")


def _splits(statistics: FloatStatistics, accuracy: float) -> list[Choice]:
    """All candidates for the split."""
    error = SHARE * accuracy * ewald.random_charge_force(statistics.touching)
    farthest = _farthest(error)
    choices = []
    for order in ORDERS:
        coarsest = _coarsest(order, error)
        for cutoff in np.geomspace(1.5 * statistics.touching, statistics.cutoff, STEPS).tolist():
            eta = cutoff**2 / (4.0 * farthest)
            spacing = coarsest * math.sqrt(eta)
            side = statistics.side + min(statistics.cutoff, math.sqrt(2.0) * statistics.side)
            points = (side / spacing + 2.0 * order) ** 2
            work = statistics.floats * (PAIR * statistics.neighbors(cutoff) + SPLINE * order * (3.0 * order + 20.0))
            if points <= MOST_POINTS and eta <= WIDEST:
                choices.append(Choice(work + POINT * points, eta, spacing, order, cutoff, points))
    return choices


def split_of(
    parameters: Parameters, interaction: InteractionSpec, area: Callable[[], float], *, eligible: bool
) -> tuple[Split, float] | None:
    """A grid if the scene requests it, or if it is cheaper and `eligible`, and the cutoff (m) of the short-range
    part; None without a grid. `area()` is what the floats cover at the start (m^2). Raises SceneError if a requested
    grid is impossible.
    """
    requested, accuracy = interaction.summation, interaction.accuracy
    fits = FINEST <= accuracy <= LOOSEST
    if requested == "grid" and not fits:
        raise scene_error(
            "interaction.summation",
            f"got an accuracy of {accuracy:g}; expected {FINEST:g} to {LOOSEST:g} with a grid, or 'cells'",
        )
    if requested == "cells" or (requested == "auto" and not (eligible and fits)):
        return None
    statistics = statistics_of(parameters, area())
    if requested == "auto" and statistics.floats < WORTH:
        return None
    cells = statistics.floats * PAIR * statistics.neighbors(statistics.cutoff)
    try:
        choice, fit = best_split(statistics, accuracy)
    except BadInput as error:
        if requested == "auto":
            return None
        raise scene_error("interaction.summation", str(error)) from None
    return None if requested == "auto" and cells <= GAIN * choice.work else _made(parameters, choice, fit, cells)


def _made(parameters: Parameters, choice: Choice, fit: SplitFit, cells: float) -> tuple[Split, float]:
    length = float(parameters.pair[CAPILLARY_LENGTH])
    split = Split(
        eta=choice.eta,
        spacing=choice.spacing * length,
        order=choice.order,
        far=parameters.cutoff,
        margin=parameters.skin,
        work=(cells, choice.work),
        points=choice.points,
        short=short_constants(float(parameters.pair[STRENGTH]), length, fit),
    )
    return split, choice.cutoff * length


def cut_off(parameters: Parameters, cutoff: float) -> Parameters:
    """Return the parameters with another cutoff of the pair law."""
    pair, widest = parameters.pair.copy(), 2.0 * float(parameters.floats.radius.max())
    pair[CUTOFF] = cutoff
    return parameters._replace(pair=pair, cutoff=cutoff, reach=max(cutoff, widest) + parameters.skin)


def split_lines(split: Split, parameters: Parameters) -> list[tuple[str, str, str]]:
    """The lines of `ecume check` about a grid."""
    cells, work = split.work
    remark = (
        f"splines of order {split.order}; neighbor lists up to {with_prefix(parameters.cutoff, 'm', 3)}; "
        f"{work / cells:.2g} of the work with cells alone"
    )
    return [("pair forces", f"a grid of {with_prefix(split.spacing, 'm', 3)}", remark)]


WORKERS = 4
"""Threads of a transform on every machine, so that bits do not depend on it."""

RUNGS = 4
"""The extent is rounded up to a power of 2^(1/4), so that most new lists use the same waves."""

TABLE = 16384
"""Number of nodes of the table of the short-range energy, over the logarithm of the distance."""


class Grid(NamedTuple):
    """A grid that covers all floats."""

    low: Array
    """(2,) m: its first point"""
    shape: tuple[int, int]
    reach: float
    """in capillary lengths: where K0 is cut off before it is smoothed; infinite if images are far enough"""


def grid_around(split: Split, reference: Array, length: float) -> Grid:
    """Return a grid with room for all floats, for splines beyond the edges, and for a margin that separates periodic
    images.
    """
    from scipy import fft

    low = reference.min(axis=0) - split.margin
    span = reference.max(axis=0) + split.margin - low
    rungs = np.ceil(RUNGS * log(span / split.spacing) / math.log(2.0))
    extent = split.spacing * exp(math.log(2.0) * rungs / RUNGS)
    diagonal = float(np.hypot(*extent))
    soft = 2.0 * math.sqrt(ewald.FARTHEST * split.eta) * length
    near = diagonal + soft < split.far
    apart = diagonal + 2.0 * soft if near else split.far
    rows, columns = (math.ceil(each / split.spacing) + 2 * split.order for each in extent + apart)
    shape = fft.next_fast_len(rows, real=True), fft.next_fast_len(columns, real=True)
    reach = (diagonal + soft) / length if near else math.inf
    return Grid(low - split.order * split.spacing, shape, reach)


class Waves(NamedTuple):
    """The factors that multiply the transform of the charges."""

    potential: Array
    """(rows, columns/2 + 1)"""
    along: Array
    """(rows, 1) wavenumbers along x, over the capillary length"""
    across: Array
    """(1, columns/2 + 1) and along y"""


@lru_cache(maxsize=2)
def waves_of(shape: tuple[int, int], spacing: float, eta: float, order: int, reach: float) -> Waves:
    """The Fourier transform of the smooth part on a grid of this spacing (capillary lengths), divided by the square of
    the transform of the splines. See `laws.ewald.spline_correction`.
    """
    from scipy import fft

    along = 2.0 * np.pi / spacing * fft.fftfreq(shape[0])[:, None]
    across = 2.0 * np.pi / spacing * fft.rfftfreq(shape[1])[None, :]
    squared = along**2 + across**2
    smooth = smooth_wave(squared, eta) if math.isinf(reach) else smooth_wave_within(squared, eta, reach)
    # The highest wavenumber of an even grid has no slope.
    odd = along.copy(), across.copy()
    if shape[0] % 2 == 0:
        odd[0][shape[0] // 2] = 0.0
    if shape[1] % 2 == 0:
        odd[1][:, -1] = 0.0
    undone = ewald.spline_correction(along[:, 0] * spacing, order)[:, None]
    undone = undone * ewald.spline_correction(across[0] * spacing, order)[None, :]
    return Waves(smooth * undone / spacing**2, *odd)


def transformed(split: Split, position: Array, charge: Array, grid: Grid, length: float) -> tuple[Any, Any, Waves]:
    """Return the spline weights of all floats, the transform of the smooth potential, and the waves."""
    from scipy import fft

    spread = interpolation.spread_out(position, grid.low, split.spacing, grid.shape[0], split.order)
    waves = waves_of(grid.shape, split.spacing / length, split.eta, split.order, grid.reach)
    spectrum = fft.rfft2(interpolation.density(spread, charge, grid.shape), workers=WORKERS)
    spectrum *= waves.potential
    return spread, spectrum, waves


def add_smooth_forces(parameters: Parameters, split: Split, position: Array, grid: Grid, force: Array) -> None:
    """Add the forces of the smooth part, S A grad(sum of A T) with S = 2 pi gamma; they point toward higher
    potential.
    """
    from scipy import fft

    charge, length = parameters.floats.charge, float(parameters.pair[CAPILLARY_LENGTH])
    spread, spectrum, waves = transformed(split, position, charge, grid, length)
    slopes = np.stack([
        fft.irfft2(1j * wavenumber * spectrum, s=grid.shape, workers=WORKERS)
        for wavenumber in (waves.along, waves.across)
    ])  # fmt: skip
    force += float(parameters.pair[STRENGTH]) / length * charge[:, None] * interpolation.fields(spread, slopes)


def split_energy(
    part: Split, scratch: Any, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """The energy of all pairs (J), including the short-range part: zero at infinite distance."""
    from scipy import fft

    split, pair, charge = part, parameters.pair, parameters.floats.charge
    length, rows = float(pair[CAPILLARY_LENGTH]), workspace.lists.rows
    grid = grid_around(split, state.reference, length)
    spread, spectrum, _ = transformed(split, state.position, charge, grid, length)
    potential = fft.irfft2(spectrum, s=grid.shape, workers=WORKERS)[None]
    alone = smooth_self_energy(split.eta) * charge
    smooth = 0.5 * float(np.sum(charge * (interpolation.fields(spread, potential)[:, 0] - alone)))
    listed = rows.first, rows.neighbor, workspace.lists.cells.order
    closest, cutoff = 0.1 * split.short.lower * length, float(pair[CUTOFF])
    table = _short_table((closest, cutoff), float(pair[INVERSE_SQUARE]), split.eta)
    short = sum_of_short_energies(state.position, charge, listed, *table)
    return -float(pair[STRENGTH]) * (smooth + short), 0.0


@lru_cache(maxsize=8)
def _short_table(span: tuple[float, float], inverse_square: float, eta: float) -> tuple[Array, Array]:
    """The ends and the values of the table of the short-range energy between two distances (m), over the logarithm of
    the squared distance (m^2). It is the same for all frames of a run.
    """
    ends = log(np.array([span[0] ** 2, span[1] ** 2]))
    x = np.sqrt(exp(np.linspace(float(ends[0]), float(ends[1]), TABLE)) * inverse_square)
    return ends, np.asarray(ewald.short_energy(x, eta))


@compiled
def sum_of_short_energies(
    position: Array, charge: Array, listed: tuple[Integers, Slots, Integers], ends: Array, table: Array
) -> float:
    """The short-range energies of all pairs, over S."""
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
    """Workspace: the reference positions of the neighbor lists, and the grid around them."""

    position: Array
    """(N, 2) those of the state"""
    grid: list[Grid]
    """one grid, placed after each new list"""


def make_reference(part: Split, parameters: Parameters, state: State, workspace: Workspace) -> Reference:
    """Return the workspace."""
    return Reference(state.reference, [])


def place_grid(part: Split, scratch: Reference, parameters: Parameters, lists: NeighborLists) -> None:
    """Place the grid around the reference positions, after each rebuild of the neighbor lists."""
    scratch.grid[:] = [grid_around(part, scratch.position, float(parameters.pair[CAPILLARY_LENGTH]))]


def smooth_forces(
    part: Split, scratch: Reference, parameters: Parameters, position: Array, lists: NeighborLists, force: Array
) -> None:
    """Add the forces of the smooth part. This runs in Python, because the Fourier transforms are SciPy functions."""
    add_smooth_forces(parameters, part, position, scratch.grid[0], force)
