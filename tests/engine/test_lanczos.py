"""Square roots of matrices times vectors."""

import numpy as np
import pytest

from ecume.engine.linear_solvers import lanczos
from ecume.engine.linear_solvers.lanczos import (
    cholesky_product,
    krylov_root,
    root_by_products,
    root_column,
    root_product,
)


def definite(size, seed=0):
    """A random positive definite matrix, with a diagonal of very unequal numbers."""
    dice = np.random.default_rng(seed)
    rows, scale = dice.normal(size=(size, size)), np.exp(dice.normal(size=size))
    return (rows @ rows.T / size + 0.1 * np.eye(size)) * np.outer(scale, scale)


def columns(product, matrix):
    """B, column by column."""
    found = np.empty_like(matrix)
    for k, unit in enumerate(np.eye(len(matrix))):
        result = np.empty(len(matrix))
        product(matrix, unit, result)
        found[:, k] = result
    return found


@pytest.mark.parametrize("product", [cholesky_product, krylov_root])
@pytest.mark.parametrize("size", [1, 2, 7, 12])
def test_the_product_has_the_covariance_of_the_matrix(product, size):
    matrix = definite(size)
    factor = columns(product, matrix)
    scale = np.sqrt(np.diag(matrix))
    assert (factor @ factor.T) / np.outer(scale, scale) == pytest.approx(matrix / np.outer(scale, scale), abs=1e-5)


def test_lanczos_is_the_symmetric_root_of_the_scaled_matrix_and_ends_early():
    matrix, vector = definite(60, 3), np.random.default_rng(4).normal(size=60)
    # A diagonal of which few numbers differ: as many iterations.
    few = np.diag(np.repeat([1.0, 4.0, 9.0], 20)) + 0.0
    few += 0.1 * np.outer(np.ones(60), np.ones(60))
    found = np.empty(60)
    for case in (matrix, few):
        iterations = krylov_root(case, vector, found)
        scale = np.sqrt(np.diag(case))
        values, vectors = np.linalg.eigh(case / np.outer(scale, scale))
        expected = scale * (vectors @ (np.sqrt(values) * (vectors.T @ vector)))
        assert found == pytest.approx(expected, abs=1e-5 * np.abs(expected).max())
    assert iterations < 15


def test_the_change_that_ends_iterations_is_relative():
    share, before = np.array([3.0, -1.0, 2.0]), np.array([2.9, -1.1, 2.2])
    expected = np.linalg.norm(share - before) / np.linalg.norm(share)
    assert lanczos._changed(share, before, 3) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("product", [cholesky_product, krylov_root])
def test_floats_at_one_place_move_together(product):
    """A matrix that is only semidefinite."""
    matrix, result = np.ones((3, 3)), np.empty(3)
    matrix[2] = matrix[:, 2] = [0.5, 0.5, 1.0]
    product(matrix, np.array([0.3, -1.2, 0.4]), result)
    assert result[0] == pytest.approx(result[1], abs=1e-7)  # the root of a rounded zero
    assert np.all(np.isfinite(result))


def test_large_and_small_matrices_take_their_methods():
    vector = np.random.default_rng(1).normal(size=120)
    for size, method in ((20, cholesky_product), (120, krylov_root)):
        matrix, one, other = definite(size) + 0.5 * np.eye(size), np.empty(size), np.empty(size)
        root_product(matrix, vector[:size], one)
        method(matrix, vector[:size], other)
        assert np.array_equal(one, other)


def test_the_root_of_a_tridiagonal_matrix():
    diagonal, beside = np.array([2.0, 3.0, 1.5, 4.0]), np.array([0.5, -0.7, 0.9])
    matrix, column = np.diag(diagonal) + np.diag(beside, 1) + np.diag(beside, -1), np.empty(4)
    root_column(diagonal, beside, column)
    values, vectors = np.linalg.eigh(matrix)
    assert column == pytest.approx((vectors * np.sqrt(values)) @ vectors[0], rel=1e-12)


@pytest.mark.long
def test_a_matrix_that_is_known_by_its_products_has_the_same_root():
    matrix, vector = definite(40, 8), np.random.default_rng(9).normal(size=40)
    expected = np.empty(40)
    krylov_root(matrix, vector, expected)
    found = root_by_products(lambda given: matrix @ given, np.sqrt(np.diag(matrix)), vector, 1e-6)
    assert found == pytest.approx(expected, abs=1e-5 * np.abs(expected).max())
    coarse = root_by_products(lambda given: matrix @ given, np.sqrt(np.diag(matrix)), vector, 0.3)
    assert 1e-5 < np.abs(coarse - expected).max() / np.abs(expected).max() < 0.3
