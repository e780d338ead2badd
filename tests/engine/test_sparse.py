"""Block systems: each way to solve gives what a dense solution gives."""

import numpy as np
import pytest

from ecume.engine import sparse


def system(dimensions, held, count=30, lean=0.1):
    """A random network of stiff and soft links, not quite symmetric, held or not; as a matrix, and dense."""
    random = np.random.default_rng(3)
    first = np.concatenate([np.arange(count - 1), random.integers(0, count // 2, 60)])
    second = np.concatenate([np.arange(1, count), random.integers(count // 2, count, 60)])
    root = random.normal(size=(len(first), dimensions, dimensions))
    stiffness = root @ root.swapaxes(1, 2) * np.exp(random.normal(size=(len(first), 1, 1)))
    stiffness[:, 0, 1] += lean * np.abs(stiffness[:, 0, 1])
    matrix = sparse.make_matrix(sparse.make_pattern(count, first, second), dimensions)
    diagonal = np.full(count, 0.3 * held)
    sparse.assemble(matrix, stiffness, diagonal)
    dense = np.diag(np.repeat(diagonal, dimensions))
    for i, j, block in zip(first, second, stiffness, strict=True):
        for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
            rows, columns = slice(a * dimensions, (a + 1) * dimensions), slice(b * dimensions, (b + 1) * dimensions)
            dense[rows, columns] += sign * block
    right = random.normal(size=(count, dimensions))
    return matrix, dense, right if held else right - right.mean(axis=0)


def by_gradients(matrix, right, solution, anchored):
    scratch = sparse.make_gradients(*right.shape)
    assert sparse.descend(matrix, right, solution, scratch, 1e-12) > 0
    if anchored:
        sparse.center(solution)
    return True


WAYS = {"eliminate": sparse.eliminate, "factorize": sparse.factorize, "gradients": by_gradients}


@pytest.mark.parametrize("way", WAYS.values(), ids=WAYS)
@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("held", [True, False])
def test_every_way_solves_what_the_dense_matrix_says(way, dimensions, held):
    matrix, dense, right = system(dimensions, held)
    solution = np.zeros_like(right)
    assert way(matrix, right, solution, not held)
    assert dense @ solution.ravel() == pytest.approx(right.ravel(), abs=1e-9)
    if not held:
        assert solution.mean(axis=0) == pytest.approx(np.zeros(dimensions), abs=1e-12)


def test_a_network_in_two_pieces_that_nothing_holds_has_no_solution():
    matrix = sparse.make_matrix(sparse.make_pattern(4, np.array([0, 2]), np.array([1, 3])), 2)
    sparse.assemble(matrix, np.stack([np.eye(2)] * 2), np.zeros(4))
    right = np.array([[1.0, 0.0], [0.0, 0.0], [-1.0, 0.0], [0.0, 0.0]])
    assert not sparse.eliminate(matrix, right, np.zeros((4, 2)), True)


def test_gradients_need_no_iteration_for_nothing_and_give_up_without_a_diagonal():
    matrix, _, right = system(2, True)
    scratch = sparse.make_gradients(*right.shape)
    assert sparse.descend(matrix, 0.0 * right, right, scratch, 1e-3) == 0
    matrix.blocks[:] = 0.0
    assert sparse.descend(matrix, right + 1.0, right, scratch, 1e-3) == -1
