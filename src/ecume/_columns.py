"""Records of the neighbors of one particle, turned into columns: `_jit` compiles this function with vector shuffles.

A loop over neighbors that reads one number of each from scattered places waits for the processor's gathers. Here each
neighbor is one record of eight numbers, which is loaded whole; as many records as a vector holds are transposed in
registers, and the loop over neighbors reads columns, which lie side by side in the first cache.
"""

from __future__ import annotations

from typing import Any

RECORD = 8
"""Numbers in a record."""


def fill_columns(columns: Any, records: Any, neighbor: Any, place: Any, count: Any) -> None:
    """Fill columns[c, k] with number c of the record of neighbor k, for the first `count` of neighbor[place].

    columns is (8, room), records (N, 8), both of one precision; neighbor is (n, room), signed but not negative; `count`
    is a multiple of 8.
    """
    chosen = neighbor[int(place), : int(count)]
    columns[:, : int(count)] = records[chosen].T
