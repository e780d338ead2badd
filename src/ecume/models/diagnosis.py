"""Diagnosis of a diverged state: the particle and the quantity at fault."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ecume.units import Array

DEEP = 0.1
"""The overlap, in radii, that is reported; larger ones do not occur in a correct run."""


def when(parameters: Any, state: Any) -> str:
    """The time of a state, for models with equal steps."""
    step = int(state.step[0])
    return f"at t = {step * parameters.time_step:.6g} s (step {step})"


class Broken(NamedTuple):
    """A number that is NaN or infinite."""

    particle: int
    term: str


def first_broken(terms: Mapping[str, Array]) -> Broken | None:
    """The particle with NaN or infinity in the first of these terms that contains one; rows are particles.

    >>> first_broken({"position": np.zeros((3, 2)), "velocity": np.array([0.0, 1.0, np.nan])})
    Broken(particle=2, term='velocity')
    """
    for term, numbers in terms.items():
        broken = ~np.isfinite(numbers.reshape(len(numbers), -1)).all(axis=1)
        if broken.any():
            return Broken(int(np.argmax(broken)), term)
    return None
