"""Conversion of the records of the neighbors of a particle to columns, which `_jit` compiles with vector shuffles.

A loop over neighbors that reads single numbers from scattered positions is limited by the gather instructions of the
processor. Here each neighbor has one record of eight numbers, which is loaded as a whole. As many records as a vector
has elements are transposed in registers, and the loop over neighbors reads contiguous columns from the first cache.
"""

from __future__ import annotations

from typing import Any

RECORD = 8
"""Numbers in a record."""


def fill_columns(columns: Any, records: Any, neighbor: Any, begin: Any, count: Any, first: Any) -> None:
    """Fill columns[c, k] with number c of the record of neighbor k, first <= c < first + 8, for `count` neighbors
    from neighbor[begin] on.

    columns is (8 m, room), records (N, 8 m), both of one precision; neighbors are signed but not negative; `count` is
    a multiple of 8.
    """
    chosen = neighbor[int(begin) : int(begin) + int(count)]
    part = slice(int(first), int(first) + RECORD)
    columns[part, : int(count)] = records[chosen, part].T


def column(columns: Any, k: Any) -> tuple[float, ...]:
    """The first eight numbers of neighbor k, as Python numbers, which are faster in Python."""
    return tuple(columns[:RECORD, int(k)].tolist())


def further_column(columns: Any, k: Any) -> tuple[float, ...]:
    """The next eight numbers of neighbor k."""
    return tuple(columns[RECORD:, int(k)].tolist())
