"""Least squares over simulations, and what the residuals say of how sure the result is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from ecume.units import Array

STEP = 1e-5
"""Of a coordinate, for slopes: simulations are smooth to about 1e-12."""
MOST_ROUNDS = 60
LOOSE = 0.7
"""The standard error of ln(p) beyond which something is called undetermined: a factor of two either way."""
CONFIDENCE = 0.95


class Solution(NamedTuple):
    """Where the squares are least."""

    coordinates: Array
    residuals: Array
    jacobian: Array
    converged: bool
    rounds: int

    @property
    def freedom(self) -> int:
        """Numbers measured less numbers fitted."""
        return max(len(self.residuals) - len(self.coordinates), 1)

    @property
    def noise(self) -> float:
        """The standard deviation of a measured number, in the unit of the residuals."""
        return float(np.sqrt(np.sum(self.residuals**2) / self.freedom))


def solved(residuals: Callable[[Array], Array], start: Array) -> Solution:
    """The least squares near a start, by a trust region; directions that change nothing are left as they are."""

    def slopes(at: Array) -> Array:
        here = residuals(at)
        columns = [(residuals(at + STEP * unit) - here) / STEP for unit in np.eye(len(at))]
        return np.stack(columns, axis=1)

    found: Any = least_squares(
        residuals, start, slopes, method="trf", tr_solver="exact", max_nfev=MOST_ROUNDS, xtol=1e-7, ftol=1e-8
    )
    return Solution(found.x, found.fun, found.jac, bool(found.status > 0), int(found.nfev))


class Certainty(NamedTuple):
    """How sure the first so many coordinates are, whatever the others do.

    `directions` are orthonormal rows in the space of these coordinates, `errors` the standard error along each.
    """

    directions: Array
    errors: Array
    quantile: float
    """of Student's distribution: this many standard errors make an interval"""

    @property
    def determined(self) -> Any:
        """Which directions the tracks determine."""
        return self.errors < LOOSE

    def error_of(self, slope: Array) -> float:
        """The standard error of a quantity with this slope in the coordinates; infinite where it is undetermined."""
        along = self.directions @ slope
        loose = np.linalg.norm(along[~self.determined])
        if loose > MOST_LOOSE * np.linalg.norm(slope):
            return float("inf")
        return float(np.linalg.norm(along[self.determined] * self.errors[self.determined]))


MOST_LOOSE = 0.02
"""The part of a quantity's slope that may lie along what is undetermined."""


def certainty(solution: Solution, first: int) -> Certainty:
    """From the Jacobian and the noise: the errors of the first coordinates, all others being fitted along.

    The singular values of their columns, less what the others' columns can make up for, are noise over error.
    """
    own, others = solution.jacobian[:, :first], solution.jacobian[:, first:]
    if others.shape[1]:
        basis, sizes, _ = np.linalg.svd(others, full_matrices=False)
        basis = basis[:, sizes > 1e-12 * max(float(sizes[0]), 1e-300)]
        own = own - basis @ (basis.T @ own)
    _, sizes, directions = np.linalg.svd(own, full_matrices=False)
    errors = solution.noise / np.maximum(sizes, 1e-300)
    # What is below the accuracy of the slopes is nothing, however little noise there is.
    errors = np.where(sizes < 1e-6 * sizes[0], np.inf, errors)
    return Certainty(directions, errors, float(student.ppf(0.5 + 0.5 * CONFIDENCE, solution.freedom)))
