"""Comparison of a state from a file with the parameters of a scene: sizes and indices, on which compiled loops rely."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np


class Layout(NamedTuple):
    """The arrays of a state of a scene."""

    blank: Any
    """a state with as many particles and as much room; its values do not matter"""
    indices: Mapping[str, tuple[float, float]] = {}
    """lowest and highest value of the fields whose values are counts or indices"""
    sets: Mapping[str, int] = {}
    """fields that contain each number below this one once"""


def misfit(state: Any, layout: Layout) -> str:
    """The first fault of a state, with its field; empty if it fits."""
    return next(_faults(state, layout), "")


def _faults(state: Any, layout: Layout) -> Iterator[str]:
    for name, expected in layout.blank._asdict().items():
        got = getattr(state, name)
        if got.shape != expected.shape or got.dtype != expected.dtype:
            yield f"{name} is {got.dtype}{list(got.shape)}; expected {expected.dtype}{list(expected.shape)}"
    for name, (low, high) in layout.indices.items():
        values = getattr(state, name)
        wrong = values[(values < low) | (values > high)]
        if len(wrong):
            yield f"{name} contains {wrong.flat[0]:g}; expected {low:g} to {high:g}"
    for name, count in layout.sets.items():
        if not np.array_equal(np.sort(getattr(state, name)), np.arange(count)):
            yield f"{name} does not number the particles; expected each number below {count} once"
