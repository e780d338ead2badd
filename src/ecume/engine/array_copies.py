"""Copies of arrays in compiled code: short loops, since an assignment to a slice brings in the formatting of its error
message, and every kind of slice another one.
"""

from __future__ import annotations

from ecume._jit import compiled
from ecume.units import Array


@compiled
def copy_line(to: Array, source: Array) -> None:
    """Copy as many numbers as fit."""
    for i in range(to.shape[0]):
        to[i] = source[i]


@compiled
def copy_rows(to: Array, source: Array) -> None:
    """The same of rows of numbers."""
    for i in range(to.shape[0]):
        for k in range(to.shape[1]):
            to[i, k] = source[i, k]


@compiled
def clear_rows(to: Array) -> None:
    """Zeros."""
    for i in range(to.shape[0]):
        for k in range(to.shape[1]):
            to[i, k] = 0.0
