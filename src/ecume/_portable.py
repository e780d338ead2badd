"""Arithmetic of arrays whose rounding does not depend on the processor.

NumPy's elementary functions and BLAS have several versions for different processors, which differ in the last bit.
Values in the state of a run, or in its frames, are computed with the functions of this file instead: elementary
functions call the C library for each number, and products of small matrices add in a fixed order.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

BLOCK = 65536
"""Numbers that are worked on at a time."""


def _elementwise(function: Callable[[float], float]) -> Callable[[ArrayLike], Any]:
    def on_arrays(values: ArrayLike) -> Any:
        """The function of each number; a float for a float."""
        given = np.asarray(values, dtype=np.float64)
        if given.ndim == 0:
            return function(float(given))
        flat, found = given.ravel(), np.empty(given.size)
        for begin in range(0, given.size, BLOCK):  # in blocks, since lists of floats take four times the memory
            found[begin : begin + BLOCK] = [function(value) for value in flat[begin : begin + BLOCK].tolist()]
        return found.reshape(given.shape)

    return on_arrays


def _exponential(value: float) -> float:
    """The exponential function with NumPy's conventions: infinity for overflow, NaN for NaN."""
    return math.exp(value) if value < 709.0 else float(np.exp(value))


def _logarithm(value: float) -> float:
    return math.log(value) if 0.0 < value < math.inf else float(np.log(value))


def _sine(value: float) -> float:
    return math.sin(value) if math.isfinite(value) else math.nan


def _cosine(value: float) -> float:
    return math.cos(value) if math.isfinite(value) else math.nan


exp = _elementwise(_exponential)
log = _elementwise(_logarithm)
sin = _elementwise(_sine)
cos = _elementwise(_cosine)


def power(values: ArrayLike, exponent: float) -> Any:
    """Each number to a power; a float for a float.

    >>> power([2.0, 3.0], 2.0).tolist()
    [4.0, 9.0]
    """

    def raised(value: float) -> float:
        try:
            return math.pow(value, exponent)
        except (OverflowError, ValueError):
            return float(np.power(value, exponent))

    return _elementwise(raised)(values)


def sinc(values: ArrayLike) -> Any:
    """sin(pi x)/(pi x), as `numpy.sinc`.

    >>> float(sinc(0.0)), bool(abs(sinc(1.0)) < 1e-16)
    (1.0, True)
    """
    phase = math.pi * np.where(np.asarray(values) == 0.0, 1e-20, values)
    return sin(phase) / phase


def product(matrix: ArrayLike, vectors: ArrayLike) -> NDArray[np.float64]:
    """The product `matrix @ vectors` for a short inner axis, added from the first to the last element: (m, k) times (k,
    n) or (k,), or (k,) times (k, n).

    >>> product([[1.0, 2.0], [3.0, 4.0]], [1.0, 10.0]).tolist()
    [21.0, 43.0]
    """
    left, right = np.asarray(matrix), np.asarray(vectors)
    if left.shape[-1] != len(right):
        raise ValueError(f"inner axes differ: {left.shape} and {right.shape}")
    spread = (Ellipsis, None) if right.ndim > 1 else (Ellipsis,)
    total = left[..., 0][spread] * right[0]
    for k in range(1, left.shape[-1]):
        total = total + left[..., k][spread] * right[k]
    return np.asarray(total, dtype=np.float64)


def dot(one: ArrayLike, other: ArrayLike) -> float:
    """The sum of products of two vectors of any length.

    >>> dot([1.0, 2.0], [3.0, 4.0])
    11.0
    """
    return float(np.sum(np.multiply(one, other)))


def length(vector: ArrayLike) -> float:
    """The length of a vector.

    >>> length([3.0, 4.0])
    5.0
    """
    return math.sqrt(dot(vector, vector))


def phase_factor(angles: ArrayLike) -> NDArray[np.complex128]:
    """The complex number exp(i angle) of each angle (rad).

    >>> phase_factor([0.0]).tolist()
    [(1+0j)]
    """
    found = np.empty(np.shape(angles), np.complex128)
    found.real, found.imag = cos(angles), sin(angles)
    return found


def dots(ones: ArrayLike, others: ArrayLike) -> NDArray[np.float64]:
    """The dot products of each of some vectors (m, k) with each of others (n, k), as (m, n).

    >>> dots([[1.0, 2.0]], [[3.0, 4.0], [5.0, 6.0]]).tolist()
    [[11.0, 17.0]]
    """
    return np.array([[dot(one, other) for other in np.asarray(others)] for one in np.asarray(ones)])


def solve_definite(matrices: ArrayLike, right: ArrayLike) -> NDArray[np.float64]:
    """The solutions of many small systems, (n, d, d) and (n, d, c), with positive definite matrices.

    >>> solve_definite([[[2.0, 0.0], [0.0, 4.0]]], [[[2.0], [8.0]]]).tolist()
    [[[1.0], [2.0]]]
    """
    rows, known = np.array(matrices, np.float64), np.array(right, np.float64)
    size = rows.shape[1]
    for k in range(size):
        for i in range(k + 1, size):
            share = (rows[:, i, k] / rows[:, k, k])[:, None]
            rows[:, i] -= share * rows[:, k]
            known[:, i] -= share * known[:, k]
    for k in reversed(range(size)):
        for j in range(k + 1, size):
            known[:, k] -= rows[:, k, j, None] * known[:, j]
        known[:, k] /= rows[:, k, k, None]
    return known


def solve(matrix: ArrayLike, right: ArrayLike) -> NDArray[np.float64]:
    """The solution of a few linear equations, by Gaussian elimination with partial pivoting.

    Raises LinAlgError if there is no solution; NaN if a coefficient is NaN.

    >>> solve([[0.0, 2.0], [4.0, 0.0]], [2.0, 8.0]).tolist()
    [2.0, 1.0]
    """
    rows, known = np.array(matrix, np.float64), np.array(right, np.float64)
    count = len(known)
    for k in range(count):
        pivot = k + int(np.argmax(np.abs(rows[k:, k])))
        if rows[pivot, k] == 0.0:
            raise np.linalg.LinAlgError("singular matrix")
        rows[[k, pivot]], known[[k, pivot]] = rows[[pivot, k]], known[[pivot, k]]
        for i in range(k + 1, count):
            share = rows[i, k] / rows[k, k]
            rows[i, k:] -= share * rows[k, k:]
            known[i] -= share * known[k]
    for k in reversed(range(count)):
        known[k] = (known[k] - dot(rows[k, k + 1 :], known[k + 1 :])) / rows[k, k]
    return known
