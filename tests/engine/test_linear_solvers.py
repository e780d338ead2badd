"""Block systems: each solver gives the dense solution."""

import functools

import numpy as np
import pytest
from scipy.sparse import bsr_array
from scipy.spatial import cKDTree

from ecume.engine.linear_solvers import bicgstab, block_matrix, solvers, sparse_lu
from ecume.errors import BadInput

WIDTHS = {"layer": 2, "space": 3, "spinning": 6}


def links(count):
    """The pairs of a chain that connects all particles, and further random pairs."""
    random = np.random.default_rng(3)
    first = np.concatenate([np.arange(count - 1), random.integers(0, count // 2, 60)])
    second = np.concatenate([np.arange(1, count), random.integers(count // 2, count, 60)])
    return random, first, second


def right_sides(random, count, width, held):
    right = random.normal(size=(3, count, width))
    return right if held else right - right.mean(axis=1, keepdims=True)


def system(width, held, count=30, lean=0.1):
    """A random network of stiff and soft springs, slightly asymmetric, fixed or free; as a block matrix, and dense."""
    random, first, second = links(count)
    root = random.normal(size=(len(first), width, width))
    stiffness = root @ root.swapaxes(1, 2) * np.exp(random.normal(size=(len(first), 1, 1)))
    stiffness[:, 0, 1] += lean * np.abs(stiffness[:, 0, 1])
    matrix = block_matrix.make_matrix(block_matrix.make_pattern(count, first, second), width)
    diagonal = held * np.linspace(0.2, 0.4, count * width).reshape(count, width)
    block_matrix.assemble(matrix, stiffness, diagonal)
    dense = np.diag(diagonal.ravel())
    for i, j, block in zip(first, second, stiffness, strict=True):
        for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
            rows, columns = slice(a * width, (a + 1) * width), slice(b * width, (b + 1) * width)
            dense[rows, columns] += sign * block
    return matrix, dense, right_sides(random, count, width, held)


def test_a_pattern_has_a_block_for_each_pair_once_in_the_order_of_columns():
    """Pairs that are repeated, particles in contact with copies of themselves, and several chunks of rows."""
    random = np.random.default_rng(8)
    count = 2100
    first, second = random.integers(0, count, (2, 4000))
    first, second = np.concatenate([first, first[:50], [7]]), np.concatenate([second, second[:50], [7]])
    order = random.permutation(count)
    pattern = block_matrix.make_pattern(count, first, second, order)
    row, here, there = np.arange(count), pattern.rank[first], pattern.rank[second]
    pairs = {*zip(row, row, strict=True), *zip(here, there, strict=True), *zip(there, here, strict=True)}
    rows = np.repeat(row, np.diff(pattern.start))
    assert [*zip(rows, pattern.column, strict=True)] == sorted(pairs)
    for places, a, b in ((pattern.upper, here, there), (pattern.lower, there, here)):
        assert (rows[places] == a).all()
        assert (pattern.column[places] == b).all()
    assert (pattern.column[pattern.inside[:, 1]] == row).all()
    assert (pattern.diagonal == pattern.inside[pattern.rank, 1]).all()
    chunk = rows // block_matrix.CHUNK
    before, inside = pattern.column // block_matrix.CHUNK < chunk, pattern.column // block_matrix.CHUNK <= chunk
    assert (np.bincount(rows[before], minlength=count) == pattern.inside[:, 0] - pattern.start[:-1]).all()
    assert (np.bincount(rows[inside], minlength=count) == pattern.inside[:, 2] - pattern.start[:-1]).all()
    for i in (0, 7, count - 1):
        links = pattern.link[pattern.first_link[i] : pattern.first_link[i + 1]]
        assert links.tolist() == [2 * c + k for c in range(len(first)) for k in (0, 1) if (first, second)[k][c] == i]


def solved(name, matrix, right, solution, null_space_dimension):
    if name == "cholmod":
        pytest.importorskip("cvxopt")
    kept = solvers.Kept(matrix.pattern, matrix.blocks.shape[1], 2, accuracy=1e-12)
    return solvers.SOLVERS[name](kept, matrix, right, solution, null_space_dimension)


WAYS = {name: functools.partial(solved, name) for name in solvers.SOLVERS}


@pytest.mark.sampled(3)
@pytest.mark.parametrize("way", WAYS.values(), ids=WAYS)
@pytest.mark.parametrize("width", WIDTHS.values(), ids=WIDTHS)
@pytest.mark.parametrize("held", [True, False])
def test_every_way_solves_what_the_dense_matrix_says_for_several_right_sides(way, width, held):
    matrix, dense, right = system(width, held)
    solution = np.zeros_like(right)
    assert way(matrix, right, solution, 0 if held else width)
    for one, wanted in zip(solution, right, strict=True):
        assert dense @ one.ravel() == pytest.approx(wanted.ravel(), abs=1e-9)
        if not held:
            assert one.mean(axis=0) == pytest.approx(np.zeros(width), abs=1e-12)


@pytest.mark.parametrize("way", WAYS.values(), ids=WAYS)
def test_the_four_blocks_of_a_pair_may_differ(way):
    count, width = 30, 6
    random, first, second = links(count)
    pair_blocks = 0.1 * random.normal(size=(len(first), 4, width, width))
    diagonal = random.uniform(20.0, 40.0, size=(count, width))
    matrix = block_matrix.make_matrix(block_matrix.make_pattern(count, first, second), width)
    block_matrix.assemble_pair_blocks(matrix, pair_blocks, diagonal)
    dense = np.diag(diagonal.ravel())
    for i, j, four in zip(first, second, pair_blocks, strict=True):
        for (a, b), place in {
            (i, i): block_matrix.OWN, (i, j): block_matrix.ACROSS, (j, i): block_matrix.BACK, (j, j): block_matrix.OTHER
        }.items():  # fmt: skip
            dense[a * width : (a + 1) * width, b * width : (b + 1) * width] += four[place]
    right = right_sides(random, count, width, held=True)
    solution = np.zeros_like(right)
    assert way(matrix, right, solution, 0)
    for one, wanted in zip(solution, right, strict=True):
        assert dense @ one.ravel() == pytest.approx(wanted.ravel(), abs=1e-9)


@pytest.mark.compiled
@pytest.mark.parametrize("held", [True, False])
@pytest.mark.parametrize("width", WIDTHS.values(), ids=WIDTHS)
def test_a_factorization_of_many_blocks_leaves_no_residual(width, held):
    count = 900
    x, y = np.meshgrid(np.arange(30.0), np.arange(30.0))
    random = np.random.default_rng(5)
    position = np.stack([x.ravel(), y.ravel()], axis=1) + 0.3 * random.uniform(size=(count, 2))
    first, second = cKDTree(position, boxsize=30.3).query_pairs(1.4, output_type="ndarray").T
    matrix = block_matrix.make_matrix(
        block_matrix.make_pattern(count, first, second, block_matrix.near_order(position)), width
    )
    root = random.normal(size=(len(first), width, width))
    block_matrix.assemble(matrix, root @ root.swapaxes(1, 2) + 0.1 * root, np.full((count, width), 0.1 * held))
    right, solution = right_sides(random, count, width, held), np.zeros((3, count, width))
    assert solvers.directly(solvers.Kept(matrix.pattern, width, 2), matrix, right, solution, 0 if held else width)
    pattern = matrix.pattern
    whole = bsr_array((matrix.blocks, pattern.column, pattern.start), shape=(count * width,) * 2)
    for one, wanted in zip(solution, right, strict=True):
        residual = wanted[matrix.pattern.order].ravel() - whole @ one[matrix.pattern.order].ravel()
        assert np.abs(residual).max() < 1e-9


def test_halves_are_connected_only_through_the_separators_that_are_eliminated_after_them():
    _, first, second = links(200)
    pattern = block_matrix.make_pattern(200, first, second)
    level, part, depth = sparse_lu._cut(pattern)
    assert depth > 3
    for row in range(200):
        for column in pattern.column[pattern.start[row] : pattern.start[row + 1]]:
            low, high = sorted((row, column), key=lambda one: level[one])
            assert part[high] >> (level[high] - level[low]) == part[low]
    order = sparse_lu.elimination_order(pattern)
    rank = np.argsort(order)
    assert sorted(order) == list(range(200))
    for row in np.flatnonzero(level < depth):
        inside = part >> np.maximum(level - level[row], 0) == part[row]
        assert (rank[inside & (level > level[row])] < rank[row]).all()


def test_a_singular_matrix_has_no_factorization():
    matrix, _, right = system(2, True)
    matrix.blocks[:] = 0.0
    assert not solvers.directly(solvers.Kept(matrix.pattern, 2, 2), matrix, right, right.copy(), 0)


def test_memory_that_is_not_there_is_reported_with_the_way_out(monkeypatch):
    def none_left(*_, **__):
        raise MemoryError

    matrix, _, right = system(2, True)
    monkeypatch.setattr("scipy.sparse.linalg.splu", none_left)
    with pytest.raises(BadInput, match="60 unknowns needs more memory than there is; choose the solver auto"):
        solvers.directly(solvers.Kept(matrix.pattern, 2, 2), matrix, right, right.copy(), 0)


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("width", [2, 3])
def test_chunks_swept_by_threads_give_the_bits_of_one_after_the_other(width):
    count = 2500
    random, first, second = links(count)
    matrix = block_matrix.make_matrix(block_matrix.make_pattern(count, first, second), width)
    root = random.normal(size=(len(first), width, width))
    block_matrix.assemble(matrix, root @ root.swapaxes(1, 2), np.ones((count, width)))
    right = random.normal(size=(1, count, width))
    assert bicgstab.make_gradients(*right.shape[1:]).sums.shape[0] > 2
    solutions = np.zeros((2, *right.shape))
    for solve, solution in zip((bicgstab.solve_serial, bicgstab.solve_threaded), solutions, strict=True):
        scratch = bicgstab.make_gradients(*right.shape[1:])
        assert solve(matrix, (right, solution), scratch, bicgstab.Tolerance(1e-10, 500)) > 0
    assert solutions[0].tobytes() == solutions[1].tobytes()


def textbook(matrix, right, accuracy):
    """The number of iterations, and the solution, of stabilized biconjugate gradients [vandervorst1992]."""
    residual = right.copy()
    shadow, search, solution, iterations = right.copy(), right.copy(), np.zeros_like(right), 0
    while np.linalg.norm(residual) > accuracy * np.linalg.norm(right):
        iterations += 1
        slope, image = shadow @ residual, matrix @ search
        length = slope / (shadow @ image)
        left = residual - length * image
        damping = (matrix @ left) @ left / ((matrix @ left) @ (matrix @ left))
        solution += length * search + damping * left
        residual = left - damping * (matrix @ left)
        search = residual + (shadow @ residual) / slope * length / damping * (search - damping * image)
    return iterations, solution


@pytest.mark.parametrize("accuracy", [1e-2, 1e-4, 1e-6])
def test_gradients_are_those_of_the_textbook_for_the_preconditioned_matrix(accuracy):
    matrix, dense, right = system(2, True)
    count, width = right.shape[1:]
    below = np.kron(np.tri(count), np.ones((width, width))) * dense
    above = np.kron(np.tri(count).T, np.ones((width, width))) * dense
    own = np.kron(np.eye(count), np.ones((width, width))) * dense
    product = np.linalg.solve(below, dense @ np.linalg.solve(above, own))
    iterations, scaled = textbook(product, np.linalg.solve(below, right[0].ravel()), accuracy)
    solution, scratch = np.zeros((1, count, width)), bicgstab.make_gradients(count, width)
    assert (
        bicgstab.biconjugate_gradients(matrix, right[:1], solution, scratch, bicgstab.Tolerance(accuracy, 99))
        == iterations
    )
    assert solution.ravel() == pytest.approx(np.linalg.solve(above, own @ scaled), rel=1e-6)


def test_an_order_keeps_neighbors_together_and_changes_no_solution():
    matrix, dense, right = system(2, True)
    _, first, second = links(30)
    shuffled = block_matrix.make_pattern(30, first, second, np.random.default_rng(2).permutation(30))
    other = block_matrix.make_matrix(shuffled, 2)
    for i in range(30):
        for place in range(shuffled.start[shuffled.rank[i]], shuffled.start[shuffled.rank[i] + 1]):
            j = shuffled.order[shuffled.column[place]]
            other.blocks[place] = dense[2 * i : 2 * i + 2, 2 * j : 2 * j + 2]
    for name in ("dense", "iterative", "direct"):
        way = WAYS[name]
        one, two = np.zeros_like(right), np.zeros_like(right)
        assert way(matrix, right, one, 0)
        assert way(other, right, two, 0)
        assert two == pytest.approx(one, abs=1e-9)
    x, y = np.meshgrid(np.arange(16.0), np.arange(16.0))
    position = np.stack([x.ravel(), y.ravel()], axis=1)[np.random.default_rng(1).permutation(256)]
    near = position[block_matrix.near_order(position)]
    assert np.linalg.norm(np.diff(near, axis=0), axis=1).mean() < 2.0
    assert np.linalg.norm(np.diff(position, axis=0), axis=1).mean() > 5.0


@pytest.mark.parametrize("width", [2, 3, 5, 6])
def test_the_diagonal_is_inverted_block_by_block(width):
    random = np.random.default_rng(1)
    pattern = block_matrix.make_pattern(4, np.array([0, 1]), np.array([1, 3]))
    matrix = block_matrix.make_matrix(pattern, width)
    matrix.blocks[:] = random.normal(size=matrix.blocks.shape)
    matrix.blocks[pattern.diagonal] += 5.0 * np.eye(width)
    inverse = np.zeros((4, width, width))
    assert block_matrix.invert_diagonal(matrix, inverse)
    assert inverse == pytest.approx(np.linalg.inv(matrix.blocks[pattern.diagonal]), abs=1e-12)


def test_a_block_without_a_pivot_in_place_is_inverted_nevertheless():
    turned = np.eye(6)[::-1].copy()
    inverse = np.zeros((6, 6))
    assert block_matrix.invert(turned, inverse, np.zeros((6, 12)))
    assert inverse == pytest.approx(turned)
    assert not block_matrix.invert(np.zeros((6, 6)), inverse, np.zeros((6, 12)))


def test_a_network_in_two_pieces_that_nothing_holds_has_no_solution():
    matrix = block_matrix.make_matrix(block_matrix.make_pattern(4, np.array([0, 2]), np.array([1, 3])), 2)
    block_matrix.assemble(matrix, np.stack([np.eye(2)] * 2), np.zeros((4, 2)))
    right = np.array([[[1.0, 0.0], [0.0, 0.0], [-1.0, 0.0], [0.0, 0.0]]])
    assert not block_matrix.eliminate(matrix, right, np.zeros((1, 4, 2)), 2)


def test_gradients_need_no_iteration_for_nothing_and_give_up_without_a_diagonal():
    matrix, _, right = system(2, True)
    scratch = bicgstab.make_gradients(*right.shape[1:])
    assert bicgstab.biconjugate_gradients(matrix, 0.0 * right, right, scratch, bicgstab.Tolerance(1e-3, 9)) == 0
    matrix.blocks[:] = 0.0
    assert bicgstab.biconjugate_gradients(matrix, right + 1.0, right, scratch, bicgstab.Tolerance(1e-3, 9)) == -1
