"""Implicit Runge-Kutta schemes: L-stable, with an explicit first stage, and with the last stage at the end of the step.

Forces therefore balance exactly at the end of a step. All stages have the same coefficient on the diagonal.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ecume.units import Array


class Scheme(NamedTuple):
    """A Butcher tableau. A stage is the start plus the slopes of earlier stages, weighted by its row, plus `diagonal`
    times its slope.
    """

    rows: Array
    """(S, S) coefficients below the diagonal; the last row gives the end of the step"""
    diagonal: float
    times: Array
    """(S,) times of the stages, in steps"""
    error: Array
    """(S,) weights of the slopes in the difference from the embedded scheme"""
    weights: Array
    """(2, S) weights of the slopes in a step; and weights for the time mean of a quantity over a step, by the more
    accurate of the scheme and the embedded one
    """
    order: int
    """order of the scheme; that of the embedded one is lower by one"""


def _scheme(rows: list[list[float]], diagonal: float, embedded: list[float], order: int) -> Scheme:
    count = len(rows)
    lower = np.zeros((count, count))
    for stage, row in enumerate(rows):
        lower[stage, : len(row)] = row
    whole = lower + diagonal * np.diag([0.0] + [1.0] * (count - 1))
    times, pair = whole.sum(axis=1), (whole[-1], np.array(embedded))
    # Of the two solutions, use the one with the smaller error for quadratics and cubics.
    mean = min(pair, key=lambda weights: abs(weights @ times**3 - 1 / 4) + abs(weights @ times**2 - 1 / 3))
    return Scheme(lower, diagonal, times, pair[0] - pair[1], np.array([pair[0], mean]), order)


def esdirk4() -> Scheme:
    """ESDIRK4(3)6L[2]SA, the implicit half of ARK4(3)6L[2]SA [kennedy2003]."""
    rows = [
        [],
        [1 / 4],
        [8611 / 62500, -1743 / 31250],
        [5012029 / 34652500, -654441 / 2922500, 174375 / 388108],
        [15267082809 / 155376265600, -71443401 / 120774400, 730878875 / 902184768, 2285395 / 8070912],
        [82889 / 524892, 0.0, 15625 / 83664, 69875 / 102672, -2260 / 8211],
    ]
    embedded = [
        4586570599 / 29645900160, 0.0, 178811875 / 945068544, 814220225 / 1159782912, -3700637 / 11593932,
        61727 / 225920,
    ]  # fmt: skip
    return _scheme(rows, 1 / 4, embedded, 4)


def tr_bdf2() -> Scheme:
    """TR-BDF2 as a Runge-Kutta scheme with an embedded one of order 3 [hosea1996]."""
    d = 1.0 - math.sqrt(0.5)
    w = math.sqrt(2.0) / 4.0
    return _scheme([[], [d], [w, w]], d, [(1.0 - w) / 3.0, (3.0 * w + 1.0) / 3.0, d / 3.0], 2)


@dataclass(frozen=True)
class TimeScheme:
    """A row of the table: a scheme, and its measured costs; see `cost`."""

    tableau: Scheme
    paper: Callable[[], Scheme]
    """the function whose docstring contains the reference"""
    relaxing: float
    """number of steps of a T1 process of four spheres, at a tolerance of 1e-3"""
    straining: float
    """number of steps per unit of strain of many spheres, at a tolerance of 1e-3"""
    refinement: float
    """exponent of the number of steps in 1/tolerance"""
    seconds: float
    """of a step per film, with failed attempts: `tr-bdf2` solves 13 systems in a step, `esdirk4` 29, in 25 to 65
    iterations each
    """


SCHEMES = {
    "esdirk4": TimeScheme(esdirk4(), esdirk4, relaxing=31.0, straining=1500.0, refinement=0.14, seconds=5.5e-5),
    "tr-bdf2": TimeScheme(tr_bdf2(), tr_bdf2, relaxing=35.0, straining=3300.0, refinement=0.25, seconds=1.9e-5),
}
"""Schemes for `integration.integrator`."""

LOOSE = 5.0
"""The permitted error of a run, over the error that follows from the order of the scheme and the tolerance."""
ROUNDED = 1e-8
"""The relative energy error at any tolerance, by residual forces and rounding."""


def error_of_run(scheme: str, tolerance: float) -> float:
    """The largest expected relative error of stresses and work in a run.

    A step errs by the tolerance e, in proportion to the power p + 1 of its length, where p is the order of the scheme.
    All steps together then err by e^(p/(p+1)).
    """
    order = SCHEMES[scheme].tableau.order
    return float(LOOSE * tolerance ** (order / (order + 1.0)) + ROUNDED)
