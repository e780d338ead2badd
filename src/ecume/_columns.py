"""Records of the neighbors of one particle, turned into columns: `_jit` compiles these functions with vector shuffles.

A loop over neighbors that reads one number of each from scattered places waits for the processor's gathers. Here each
neighbor is one record of eight numbers, which is loaded whole; as many records as a vector holds are transposed in
registers, and the loop over neighbors reads columns, which lie side by side in the first cache.
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
    """The first eight numbers of neighbor k; as Python's own, which are faster there."""
    return tuple(columns[:RECORD, int(k)].tolist())


def further_column(columns: Any, k: Any) -> tuple[float, ...]:
    """The next eight."""
    return tuple(columns[RECORD:, int(k)].tolist())
