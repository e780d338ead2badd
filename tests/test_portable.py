"""Arithmetic that does not depend on the processor is still right."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ecume import _portable

NUMBERS = arrays(np.float64, st.integers(0, 30), elements=st.floats(-700.0, 700.0))


@given(values=NUMBERS)
@pytest.mark.parametrize("name", ["exp", "sin", "cos", "sinc"])
def test_elementary_functions_are_those_of_numpy(name, values):
    np.testing.assert_allclose(getattr(_portable, name)(values), getattr(np, name)(values), rtol=1e-14, atol=1e-15)


@given(values=arrays(np.float64, (2, 5), elements=st.floats(1e-300, 1e300)))
def test_logarithms_and_powers_are_those_of_numpy(values):
    np.testing.assert_allclose(_portable.log(values), np.log(values), rtol=1e-14)
    np.testing.assert_allclose(_portable.power(values, 0.3), values**0.3, rtol=1e-14)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_the_ends_of_the_numbers_are_those_of_numpy():
    ends = np.array([np.inf, -np.inf, np.nan, 0.0, 800.0, -800.0, -1.0])
    np.testing.assert_array_equal(_portable.exp(ends), np.exp(ends))
    np.testing.assert_array_equal(_portable.log(ends), np.log(ends))
    for name in ("sin", "cos", "sinc"):
        found = getattr(_portable, name)(ends)
        np.testing.assert_allclose(found, getattr(np, name)(ends), rtol=1e-12, atol=1e-15)
    np.testing.assert_array_equal(_portable.power(ends, 3.0), ends**3.0)
    assert np.isnan(_portable.solve([[np.nan, 0.0], [0.0, 1.0]], [1.0, 1.0])).any()
    assert isinstance(_portable.exp(1.0), float)


def test_long_arrays_are_worked_on_in_blocks():
    values = np.linspace(-1.0, 1.0, _portable.BLOCK + 17)
    np.testing.assert_allclose(_portable.exp(values), np.exp(values), rtol=1e-15)


SMALL = st.integers(1, 4)


@given(rows=SMALL, inner=SMALL, columns=SMALL, seed=st.integers(0, 2**32 - 1))
def test_products_are_those_of_numpy(rows, inner, columns, seed):
    random = np.random.default_rng(seed)
    left, right = random.normal(size=(rows, inner)), random.normal(size=(inner, columns))
    close = {"rtol": 1e-12, "atol": 1e-13}
    np.testing.assert_allclose(_portable.product(left, right), left @ right, **close)
    np.testing.assert_allclose(_portable.product(left, right[:, 0]), left @ right[:, 0], **close)
    np.testing.assert_allclose(_portable.product(left[0], right), left[0] @ right, **close)
    np.testing.assert_allclose(_portable.dots(left, right.T), left @ right, **close)
    assert _portable.dot(left[0], right[:, 0]) == pytest.approx(float(left[0] @ right[:, 0]), rel=1e-12, abs=1e-13)
    assert _portable.length(left[0]) == pytest.approx(float(np.linalg.norm(left[0])), rel=1e-14)


@given(count=st.integers(1, 6), seed=st.integers(0, 2**32 - 1))
def test_solutions_solve(count, seed):
    random = np.random.default_rng(seed)
    matrix, known = random.normal(size=(count, count)) + 3.0 * np.eye(count)[::-1], random.normal(size=count)
    kept = matrix.copy(), known.copy()
    found = _portable.solve(matrix, known)
    scale = np.linalg.cond(matrix)
    np.testing.assert_allclose(found, np.linalg.solve(matrix, known), rtol=1e-13 * scale, atol=1e-13 * scale)
    np.testing.assert_array_equal(matrix, kept[0])
    np.testing.assert_array_equal(known, kept[1])


@given(count=st.integers(0, 5), size=st.integers(1, 3), seed=st.integers(0, 2**32 - 1))
def test_many_definite_systems_are_solved_at_once(count, size, seed):
    random = np.random.default_rng(seed)
    half = random.normal(size=(count, size, size))
    matrices, right = half @ np.swapaxes(half, 1, 2) + np.eye(size), random.normal(size=(count, size, 2))
    np.testing.assert_allclose(_portable.solve_definite(matrices, right), np.linalg.solve(matrices, right), atol=1e-9)


def test_products_of_unequal_inner_axes_are_refused():
    with pytest.raises(ValueError, match="inner axes differ"):
        _portable.product(np.eye(2), np.ones((3, 2)))


def test_equations_without_a_solution_are_refused():
    with pytest.raises(np.linalg.LinAlgError):
        _portable.solve([[1.0, 2.0], [2.0, 4.0]], [1.0, 2.0])
