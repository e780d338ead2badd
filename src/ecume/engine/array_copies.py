"""Copies of arrays in compiled code, as loops: assignments to slices would compile their error messages each time."""

from __future__ import annotations

from ecume._jit import compiled
from ecume.units import Array


@compiled
def copy_line(to: Array, source: Array) -> None:
    """Copy the elements of a 1D array, as many as both arrays have."""
    for i in range(to.shape[0]):
        to[i] = source[i]


@compiled
def copy_rows(to: Array, source: Array) -> None:
    """Copy the rows of a 2D array."""
    for i in range(to.shape[0]):
        for k in range(to.shape[1]):
            to[i, k] = source[i, k]


@compiled
def clear_rows(to: Array) -> None:
    """Set all elements to zero."""
    for i in range(to.shape[0]):
        for k in range(to.shape[1]):
            to[i, k] = 0.0
