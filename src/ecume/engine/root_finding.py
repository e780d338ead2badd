"""The root of a function between two places, for compiled code and for Python."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

MOST_GUESSES = 200


def root_between(
    function: Callable[[Any, float], float], given: Any, ends: tuple[float, float], tolerance: float
) -> float:
    """The point between two ends where `function(given, x)` changes its sign, by false position. The function value at
    an end that is kept counts half (the Illinois method), and each third guess is the midpoint. The function values at
    the ends have different signs.

    >>> round(root_between(lambda square, x: x * x - square, 2.0, (0.0, 2.0), 1e-14), 12)
    1.414213562373
    """
    low, high = ends
    at_low, at_high = function(given, low), function(given, high)
    for number in range(MOST_GUESSES):
        if high - low <= tolerance:
            break
        guess = (low * at_high - high * at_low) / (at_high - at_low)
        if number % 3 == 2 or not low < guess < high:
            guess = 0.5 * (low + high)
        value = function(given, guess)
        if value == 0.0:
            return guess
        if (value > 0.0) == (at_low > 0.0):
            low, at_low, at_high = guess, value, 0.5 * at_high
        else:
            high, at_high, at_low = guess, value, 0.5 * at_low
    return 0.5 * (low + high)
