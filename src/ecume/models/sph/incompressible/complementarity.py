"""The linear complementarity problem A x >= b, x >= 0, (A x - b) x = 0 with a symmetric A that is not negative.

The solver is MPRGP, modified proportioning with reduced gradient projections [dostal2005]: conjugate gradients among
the x that are positive, a projected step of fixed length where one reaches zero, and a release of those at zero whose
constraint is violated most. The number of iterations grows like that of conjugate gradients, with the square root of
the condition number. Without bounds it is the method of conjugate gradients.

It was applied to liquids that may separate by [gerszewski2013].
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ecume._portable import dot
from ecume.units import Array

PROPORTION = 1.0
"""Gamma: how large the gradients at zero may be, relative to the others, before they are released."""


class Problem(NamedTuple):
    """A problem with bounds, in scaled unknowns."""

    apply: Callable[[Array], Array]
    """A x"""
    right: Array
    """b"""
    bounded: bool
    """whether x >= 0"""
    step: float
    """the length of projected steps: up to twice the inverse of the largest eigenvalue"""
    error: Callable[[Array], float]
    """the error of a projected gradient, compared with the tolerance"""


class Solution(NamedTuple):
    """What the solver found."""

    x: Array
    gradient: Array
    """the projected gradient, zero at the solution"""
    error: float
    iterations: int


def solve(problem: Problem, guess: Array, tolerance: float, most: int) -> Solution:
    """The solution within the tolerance, or what was reached in so many applications of A."""
    x = np.maximum(guess, 0.0) if problem.bounded else guess.copy()
    gradient = problem.apply(x) - problem.right
    free, chopped = _split(problem, x, gradient)
    direction, count = free.copy(), 1
    error = problem.error(free + chopped)
    while error > tolerance and count < most:
        reduced = np.minimum(x / problem.step, free) if problem.bounded else free
        if dot(chopped, chopped) <= PROPORTION**2 * dot(reduced, free):
            ahead = problem.apply(direction)
            curvature = dot(direction, ahead)
            if curvature <= 0.0:  # nothing but rounding is left along this direction
                break
            length = dot(gradient, direction) / curvature
            farthest = _farthest(x, direction) if problem.bounded else np.inf
            if length <= farthest:
                x = x - length * direction
                gradient = gradient - length * ahead
                free, chopped = _split(problem, x, gradient)
                direction = free - dot(free, ahead) / curvature * direction
            else:
                x = x - farthest * direction
                gradient = gradient - farthest * ahead
                free, _ = _split(problem, x, gradient)
                x = np.maximum(x - problem.step * free, 0.0)
                gradient = problem.apply(x) - problem.right
                free, chopped = _split(problem, x, gradient)
                direction, count = free.copy(), count + 1
        else:
            ahead = problem.apply(chopped)
            curvature = dot(chopped, ahead)
            if curvature <= 0.0:
                break
            length = dot(gradient, chopped) / curvature
            x = x - length * chopped
            gradient = gradient - length * ahead
            free, chopped = _split(problem, x, gradient)
            direction = free.copy()
        count += 1
        error = problem.error(free + chopped)
    return Solution(x, free + chopped, error, count)


def _split(problem: Problem, x: Array, gradient: Array) -> tuple[Array, Array]:
    """The gradient of the x above zero, and the part of the others that would raise them."""
    if not problem.bounded:
        return gradient, np.zeros_like(gradient)
    inside = x > 0.0
    return np.where(inside, gradient, 0.0), np.where(inside, 0.0, np.minimum(gradient, 0.0))


def _farthest(x: Array, direction: Array) -> float:
    """How far along minus the direction no x becomes negative."""
    falling = direction > 0.0
    return float((x[falling] / direction[falling]).min(initial=np.inf))
