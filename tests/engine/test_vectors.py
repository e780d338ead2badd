"""Vectors and symmetric matrices for loops, compared with those of NumPy."""

import numpy as np
import pytest
from tests.models.sph.scenes import tank

from ecume.engine import vectors
from ecume.models.sph.record import SPH

EACH = pytest.mark.parametrize("dimension", [2, 3])
PLACES = {2: [(0, 0), (1, 1), (0, 1)], 3: [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]}


def drawn(dimension):
    """Two vectors and a symmetric matrix, for loops and for NumPy."""
    dice = np.random.default_rng(dimension)
    a, b, root = dice.normal(size=dimension), dice.normal(size=dimension), dice.normal(size=(dimension, dimension))
    matrix = root + root.T
    kind, square = type(vectors.VECTORS[dimension]), vectors.zero_matrix(0.0, vectors.VECTORS[dimension])
    return kind(*a), kind(*b), type(square)(*(matrix[place] for place in PLACES[dimension])), a, b, matrix


def whole(matrix, dimension):
    """A symmetric matrix for loops as a NumPy array."""
    found = np.zeros((dimension, dimension))
    for (i, j), value in zip(PLACES[dimension], matrix, strict=True):
        found[i, j] = found[j, i] = value
    return found


@EACH
def test_vectors_are_those_of_numpy(dimension):
    first, second, _, a, b, _ = drawn(dimension)
    assert vectors.dot(first, second) == pytest.approx(a @ b, rel=1e-14)
    np.testing.assert_allclose(vectors.difference(first, second), a - b, rtol=1e-14)
    np.testing.assert_allclose(vectors.axpy(first, 0.7, second), a + 0.7 * b, rtol=1e-14)
    np.testing.assert_allclose(vectors.scaled(0.7, second), 0.7 * b, rtol=1e-14)
    assert vectors.vector_of(*np.append(a, 5.0)[:3], first) == first
    table = np.ones((5, 4))
    vectors.store_vector(table, 1, 2, 3.0, first)
    vectors.add_vector(table, 1, 2, 2.0, second)
    np.testing.assert_allclose(table[1 : 1 + dimension, 2], 3.0 * a + 2.0 * b, rtol=1e-14)
    table[1 : 1 + dimension, 2] = 1.0
    assert np.all(table == 1.0)


@EACH
def test_symmetric_matrices_are_those_of_numpy(dimension):
    first, _, square, a, _, matrix = drawn(dimension)
    np.testing.assert_allclose(vectors.times(square, first), matrix @ a, rtol=1e-13)
    assert vectors.trace(square) == pytest.approx(np.trace(matrix), rel=1e-14)
    np.testing.assert_allclose(
        whole(vectors.plus_square(square, 0.7, first), dimension), matrix + 0.7 * np.outer(a, a), rtol=1e-13
    )
    adjugate, determinant = vectors.adjugate(square)
    assert determinant == pytest.approx(np.linalg.det(matrix), rel=1e-12)
    np.testing.assert_allclose(whole(adjugate, dimension) / determinant, np.linalg.inv(matrix), rtol=1e-11)


@pytest.mark.parametrize(("force", "rows"), [("sum", 0), ("corrected", 6)])
def test_only_completed_gradients_have_matrices(force, rows):
    parameters = SPH.parameters(tank(pressure_force=force))
    workspace = SPH.workspace(parameters, SPH.start(tank(pressure_force=force), parameters), 1.0)
    assert len(workspace.fields.correction) == rows
