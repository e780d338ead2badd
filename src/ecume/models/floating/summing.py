"""How a crowd's pair forces are summed, cells alone or a grid beside them: as is asked for, or by counted work."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecume.engine.walls import enclosures
from ecume.errors import BadInput, Fault, SceneError
from ecume.laws import ewald as splitting
from ecume.laws.ewald import SplitFit
from ecume.laws.pair_laws import Short, short_constants
from ecume.models.floating.pace import PACKED
from ecume.models.floating.parameters import (
    CAPILLARY_LENGTH,
    CUTOFF,
    STRENGTH,
    Parameters,
)

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


def crowd_area(parameters: Parameters, scene: FloatingScene) -> float:
    """The surface (m^2) that the crowd starts on."""
    from ecume.models.floating.starting import given_places, region_of

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
        low, high = (low, middle) if splitting.grid_error(middle, order) > error else (middle, high)
    return low


@lru_cache(maxsize=32)
def _farthest(error: float) -> float:
    """Where the short part may be cut off: w = x^2/(4 eta)."""
    low, high = 1.0, splitting.FARTHEST
    while high - low > 1e-3:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if splitting.short_error(middle) > error else (low, middle)
    return high


class Crowd(NamedTuple):
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


def crowd_of(parameters: Parameters, scene: FloatingScene) -> Crowd:
    """The crowd of a scene."""
    length, radius = float(parameters.pair[CAPILLARY_LENGTH]), parameters.floats.radius
    area, count = crowd_area(parameters, scene) / length**2, len(radius)
    packed = PACKED * count / (math.pi * float(np.sum((radius / length) ** 2)))
    return Crowd(
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


def best_split(crowd: Crowd, accuracy: float) -> tuple[Choice, SplitFit]:
    """The cheapest split of that accuracy, r.m.s. error of forces over their r.m.s. with charges of random sign; and
    its short law, which errs by a tenth of that at most.
    """
    for choice in sorted(_splits(crowd, accuracy)):
        fit = splitting.fit_short(choice.eta, DEEPEST_TOUCH * crowd.touching, choice.cutoff)
        if fit.error < 0.1 * accuracy:
            return choice, fit
    raise BadInput("a grid cannot be that accurate here; take 'cells'")


def _splits(crowd: Crowd, accuracy: float) -> list[Choice]:
    """All that are looked at."""
    error = SHARE * accuracy * splitting.crowd_force(crowd.touching)
    farthest = _farthest(error)
    choices = []
    for order in ORDERS:
        coarsest = _coarsest(order, error)
        for cutoff in np.geomspace(1.5 * crowd.touching, crowd.cutoff, STEPS).tolist():
            eta = cutoff**2 / (4.0 * farthest)
            spacing = coarsest * math.sqrt(eta)
            side = crowd.side + min(crowd.cutoff, math.sqrt(2.0) * crowd.side)
            points = (side / spacing + 2.0 * order) ** 2
            work = crowd.floats * (PAIR * crowd.neighbors(cutoff) + SPLINE * order * (3.0 * order + 20.0))
            if points <= MOST_POINTS and eta <= WIDEST:
                choices.append(Choice(work + POINT * points, eta, spacing, order, cutoff, points))
    return choices


def split_of(parameters: Parameters, scene: FloatingScene, *, eligible: bool) -> tuple[Split, float] | None:
    """A grid where it is asked for, or cheaper where nobody asked and it is `eligible`, and the cutoff (m) of what is
    left to lists; None without a grid. Raises SceneError where there can be none.
    """
    asked, accuracy = scene.interaction.summation, scene.interaction.accuracy
    fits = FINEST <= accuracy <= LOOSEST
    if asked == "grid" and not fits:
        raise _fault(f"a grid is not finer than an accuracy of {FINEST:g}; take 'cells'")
    if asked == "cells" or (asked == "auto" and not (eligible and fits)):
        return None
    crowd = crowd_of(parameters, scene)
    if asked == "auto" and crowd.floats < WORTH:
        return None
    cells = crowd.floats * PAIR * crowd.neighbors(crowd.cutoff)
    try:
        choice, fit = best_split(crowd, accuracy)
    except BadInput as error:
        if asked == "auto":
            return None
        raise _fault(str(error)) from None
    return None if asked == "auto" and cells <= GAIN * choice.work else _made(parameters, choice, fit, cells)


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
    return SceneError([Fault("interaction.summation", message)])
