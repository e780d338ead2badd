"""Arithmetic with explicit rounding: `_jit` compiles these functions exactly as they are written.

A sum therefore has the same bits in every loop into which it is compiled, for any arrangement of the loop by the
compiler.
"""

from __future__ import annotations

from typing import Any

LANES = 8
"""Partial sums of `lane_sum`: a vector of double precision, where processors have the widest."""


def fused(a: float, b: float, c: float) -> float:
    """The sum a b + c, rounded once in compiled code (the multiply-add of the processor) and twice
    in Python.

    >>> fused(2.0, 3.0, 4.0)
    10.0
    """
    return a * b + c


def lane_sum(values: Any, count: Any) -> float:
    """The sum of the first `count` values, a multiple of LANES, in double precision. Every eighth value is added to the
    same lane, since an addition has to wait for the previous one in its lane; then the lanes are added by halves.

    >>> lane_sum([1.0, 2.0] * 8, 16)
    24.0
    """
    lanes = [0.0] * LANES
    for k in range(count):
        lanes[k % LANES] += float(values[k])
    while len(lanes) > 1:
        half = len(lanes) // 2
        lanes = [lanes[k] + lanes[k + half] for k in range(half)]
    return lanes[0]
