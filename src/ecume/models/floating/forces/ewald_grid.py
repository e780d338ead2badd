"""Pair forces of large systems whose menisci reach over thousands of floats: neighbor lists and an Ewald grid.

K0 is split in two parts (`laws.ewald`). The short-range part is summed over neighbor lists. For the other one,
charges are assigned to a grid by splines, transformed, multiplied by the waves of the smooth part, and the field is
interpolated with the same splines: therefore the forces between two floats cancel to rounding, and no float exerts a
force on itself. The grid covers the reference positions of the neighbor lists, which are part of the state. Python
runs the time steps around compiled parts, since the transforms are SciPy's; this costs little for a large system.

The first part of this file chooses the split: as the scene specifies, or by an estimate of the work. The second part
computes forces and energies.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy import fft

from ecume._jit import compiled
from ecume._portable import exp, log, power, sinc
from ecume.engine import grid_splines
from ecume.engine.cells import Integers
from ecume.engine.neighbors import NeighborLists, Slots
from ecume.engine.walls import enclosures
from ecume.errors import BadInput, Fault, SceneError
from ecume.laws import ewald
from ecume.laws.ewald import SplitFit, smooth_self_energy, smooth_wave, smooth_wave_within
from ecume.laws.pair_laws import Short, short_constants
from ecume.models.floating.parameters import CAPILLARY_LENGTH, CUTOFF, INVERSE_SQUARE, STRENGTH, Parameters
from ecume.models.floating.state import State, Workspace
from ecume.models.floating.time_integration.step_size import PACKED
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene


DEEPEST_TOUCH = 0.9
"""Pair laws are fitted down to this part of the smallest touching distance."""

SHARE = 0.6
"""Of the error, for the cut and for the grid: they add up as squares, and chance has its part."""

ORDERS = (4, 6, 8, 10, 12)
LOOSEST, FINEST = 1e-1, 1e-10
"""Accuracies that a grid can be asked for."""

PAIR, POINT, SPLINE = 1.0, 7.0, 0.6
"""Work, over that of a pair in a list: a point of the grid, all transforms included; a float's share of a point."""

STEPS = 60
"""Places at which the work is looked at between the closest pairs and the cutoff."""

WORTH = 2000
"""Fewer floats are summed by cells: a step in Python would cost more than it saves."""

GAIN = 2.0
"""By how much a grid must be less work to be taken unasked: a march in Python has costs that are not counted."""

MOST_POINTS = 2**28
WIDEST = 0.1
"""Eta above which waves as long as the capillary length would count, which the error of a grid leaves aside."""


class Split(NamedTuple):
    """How the sum is split: the part of a scene that wants it."""

    eta: float
    """in squares of the capillary length"""
    spacing: float
    """m, of the grid"""
    order: int
    """of the splines"""
    far: float
    """m: farther than this floats need not feel each other"""
    margin: float
    """m: who is that near to the others' rectangle is still on the grid"""
    work: tuple[float, float]
    """what a step is reckoned to cost, in pairs: with cells alone, and with the grid"""
    points: float
    """of the grid, about"""
    short: Short
    """constants of what is summed pair by pair"""


def initial_area(parameters: Parameters, scene: FloatingScene) -> float:
    """The surface (m^2) that the crowd starts on."""
    from ecume.models.floating.setup.initial_state import given_places, region_of

    region = region_of(parameters)
    area = (region.high[0] - region.low[0]) * (region.high[1] - region.low[1])
    area = min(area, enclosures.area(parameters.walls))
    places = given_places(scene).position
    if np.isnan(places).any():
        return area
    spans = np.ptp(places, axis=0) + 2.0 * float(parameters.floats.radius.max())
    return float(np.prod(spans))


@lru_cache(maxsize=32)
def _coarsest(order: int, error: float) -> float:
    """The largest spacing, over sqrt(eta), at which a grid errs by no more."""
    low, high = 0.02, 3.0
    for _ in range(12):
        middle = math.sqrt(low * high)
        low, high = (low, middle) if ewald.grid_error(middle, order) > error else (middle, high)
    return low


@lru_cache(maxsize=32)
def _farthest(error: float) -> float:
    """Where the short part may be cut off: w = x^2/(4 eta)."""
    low, high = 1.0, ewald.FARTHEST
    while high - low > 1e-3:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if ewald.short_error(middle) > error else (low, middle)
    return high


class FloatStatistics(NamedTuple):
    """What the work depends on; lengths over the capillary length."""

    floats: int
    density: float
    """floats in a square of that side: between that of the start and that of a raft"""
    side: float
    touching: float
    skin: float
    cutoff: float
    """of cells alone"""

    def neighbors(self, reach: float) -> float:
        """How many a float has within a reach."""
        return min(float(self.floats), math.pi * self.density * (reach + self.skin) ** 2)


def statistics_of(parameters: Parameters, scene: FloatingScene) -> FloatStatistics:
    """The crowd of a scene."""
    length, radius = float(parameters.pair[CAPILLARY_LENGTH]), parameters.floats.radius
    area, count = initial_area(parameters, scene) / length**2, len(radius)
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
    """A way to split the sum."""

    work: float
    """of a step, in pairs"""
    eta: float
    spacing: float
    order: int
    cutoff: float
    points: float


def best_split(statistics: FloatStatistics, accuracy: float) -> tuple[Choice, SplitFit]:
    """The cheapest split of that accuracy, r.m.s. error of forces over their r.m.s. with charges of random sign; and
    its short law, which errs by a tenth of that at most.
    """
    for choice in sorted(_splits(statistics, accuracy)):
        fit = ewald.fit_short(choice.eta, DEEPEST_TOUCH * statistics.touching, choice.cutoff)
        if fit.error < 0.1 * accuracy:
            return choice, fit
    raise BadInput("a grid cannot be that accurate here; take 'cells'")


def _splits(statistics: FloatStatistics, accuracy: float) -> list[Choice]:
    """All that are looked at."""
    error = SHARE * accuracy * ewald.crowd_force(statistics.touching)
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


def split_of(parameters: Parameters, scene: FloatingScene, *, eligible: bool) -> tuple[Split, float] | None:
    """A grid where it is asked for, or cheaper where nobody asked and it is `eligible`, and the cutoff (m) of what is
    left to lists; None without a grid. Raises SceneError where there can be none.
    """
    requested, accuracy = scene.interaction.sum, scene.interaction.accuracy
    fits = FINEST <= accuracy <= LOOSEST
    if requested == "grid" and not fits:
        raise _fault(f"a grid is not finer than an accuracy of {FINEST:g}; take 'cells'")
    if requested == "cells" or (requested == "auto" and not (eligible and fits)):
        return None
    statistics = statistics_of(parameters, scene)
    if requested == "auto" and statistics.floats < WORTH:
        return None
    cells = statistics.floats * PAIR * statistics.neighbors(statistics.cutoff)
    try:
        choice, fit = best_split(statistics, accuracy)
    except BadInput as error:
        if requested == "auto":
            return None
        raise _fault(str(error)) from None
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
    """The parameters with another cutoff of the pair law."""
    pair, widest = parameters.pair.copy(), 2.0 * float(parameters.floats.radius.max())
    pair[CUTOFF] = cutoff
    return parameters._replace(pair=pair, cutoff=cutoff, reach=max(cutoff, widest) + parameters.skin)


def split_lines(split: Split, parameters: Parameters) -> list[tuple[str, str, str]]:
    """What `ecume check` says of a grid."""
    cells, work = split.work
    remark = (
        f"splines of order {split.order}; pairs up to {parameters.cutoff * 1e6:.3g} um one by one; "
        f"{work / cells:.2g} of the work of cells alone"
    )
    return [("pair forces", f"a grid of {split.spacing * 1e6:.3g} um", remark)]


def _fault(message: str) -> SceneError:
    return SceneError([Fault("interaction.sum", message)])


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
    share = np.asarray(ewald.spline_share(phase, order))
    kept: Array = share * share / power(sinc(phase / (2.0 * np.pi)), 2 * order)
    return kept


def transformed(split: Split, position: Array, charge: Array, grid: Grid, length: float) -> tuple[Any, Any, Waves]:
    """Where everyone is on the grid, the transform of the smooth potential, and the waves."""
    spread = grid_splines.spread_out(position, grid.low, split.spacing, grid.shape[0], split.order)
    waves = waves_of(grid.shape, split.spacing / length, split.eta, split.order, grid.reach)
    spectrum = fft.rfft2(grid_splines.density(spread, charge, grid.shape), workers=WORKERS)
    spectrum *= waves.potential
    return spread, spectrum, waves


def add_smooth_forces(parameters: Parameters, split: Split, position: Array, grid: Grid, force: Array) -> None:
    """The smooth part's forces: S A grad(sum of A T), S = 2 pi gamma; towards where the potential is higher."""
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
    return ends, np.asarray(ewald.short_energy(x, eta))


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
