"""The measured peak of one core: multiply-adds of numbers in registers.

python peak.py
"""

from __future__ import annotations

import json
import sys
import time

import numba
import numpy as np

CHAIN = 32
"""The number of consecutive multiply-adds of one number."""
WIDTH = 1024
"""The number of numbers: they fit into the first cache."""
REPEATS = 500
TRIES = 10 if "--quick" in sys.argv else 200
"""The number of short tries, some of which no other process interrupts."""


@numba.njit(fastmath={"contract"}, error_model="numpy")
def _multiply_and_add(x: np.ndarray, factor: float, add: float, repeats: int) -> None:
    for _ in range(repeats):
        for k in range(x.shape[0]):
            y = x[k]
            for _ in range(CHAIN):
                y = y * factor + add
            x[k] = y


def peak(dtype: type) -> float:
    """Floating-point operations a second of one core: the best of many tries."""
    x, factor, add = np.ones(WIDTH, dtype), dtype(0.5), dtype(0.25)
    _multiply_and_add(x, factor, add, 10)
    best = float("inf")
    for _ in range(TRIES):
        began = time.perf_counter()
        _multiply_and_add(x, factor, add, REPEATS)
        best = min(best, time.perf_counter() - began)
    return 2.0 * CHAIN * WIDTH * REPEATS / best


if __name__ == "__main__":
    print("RESULT " + json.dumps({dtype.__name__: peak(dtype) for dtype in (np.float64, np.float32)}))
