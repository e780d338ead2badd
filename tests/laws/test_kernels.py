"""Smoothing kernels: they are normalized, their slopes are their derivatives, and the reference values hold."""

import csv
import math
import warnings
from pathlib import Path

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.laws import kernels
from ecume.laws.kernels import KERNEL_CODES, KERNELS, gaussian_deficit, kernel
from ecume_validation import kernels as validation

DIMENSIONS = (1, 2, 3)
VALUES = Path(validation.__file__).parent / "data" / "kernels" / "reference.csv"
Q = np.linspace(0.013, 3.3, 101)


def quiet(name, dim):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return kernel(name, dim)


EACH = pytest.mark.parametrize("one", [quiet(name, dim) for name in KERNELS for dim in DIMENSIONS],
                               ids=lambda one: f"{one.name}-{one.dim}D")  # fmt: skip


def lost(one):
    """The missing integral of the truncated Gaussian."""
    return gaussian_deficit(one.dim) if one.name == "gaussian-raw" else 0.0


def space(one, h, panels=600):
    """Distances and volumes that fill the support, by an independent integration rule."""
    nodes, weights = np.polynomial.legendre.leggauss(6)
    edges = np.linspace(0.0, one.support, panels + 1)
    r = (edges[:-1, None] + (nodes + 1.0) * one.support / panels / 2).ravel() * h
    shells = {1: 2.0 + 0.0 * r, 2: 2.0 * math.pi * r, 3: 4.0 * math.pi * r * r}[one.dim]
    return r, np.tile(weights, panels) * one.support / panels / 2 * h * shells


@EACH
def test_a_kernel_weighs_one_in_every_dimension_it_claims(one):
    r, volume = space(one, 0.7)
    assert np.sum(one.value(r, 0.7) * volume) == pytest.approx(1.0 - lost(one), abs=1e-10)


@EACH
def test_layers_of_a_kernel_weigh_what_it_weighs_and_lie_as_far_apart(one):
    nodes, weights = np.polynomial.legendre.leggauss(200)
    far, thick = 0.5 * one.support * (nodes + 1.0), 0.5 * one.support * weights
    layers = one.over_plane(far) * thick
    assert 2.0 * layers.sum() == pytest.approx(1.0 - lost(one), abs=1e-5)
    assert 2.0 * (layers * far**2).sum() == pytest.approx(one.standard_deviation**2, rel=1e-3)
    assert one.overlap == pytest.approx((layers * one.over_plane(far)).sum(), rel=1e-4)


@EACH
def test_the_first_moment_of_the_gradient_is_minus_one(one):
    r, volume = space(one, 0.7)
    moment = np.sum(r * one.slope(r, 0.7) * volume) / one.dim
    # A kernel that is cut ends with a step, whose gradient no particle sees.
    end = one.support
    sphere = {1: 2.0, 2: 2.0 * math.pi, 3: 4.0 * math.pi}[one.dim]
    step = sphere / one.dim * end**one.dim * one.value(end * (1 - 1e-15), 1.0)
    assert moment == pytest.approx(step - 1.0 + lost(one), abs=1e-10)
    assert step < 1e-10 or "gaussian" in one.name


@EACH
def test_the_slope_of_a_kernel_is_its_derivative(one):
    h, step = 0.8, 1e-4
    r = Q[(Q / one.support < 0.999) & (np.abs(Q * 2 - np.round(Q * 2)) > 2e-3)] * h
    inward, outward = (one.value(r + sign * step, h) for sign in (-1, 1))
    far_in, far_out = (one.value(r + 2 * sign * step, h) for sign in (-1, 1))
    numerical = (8 * (outward - inward) - (far_out - far_in)) / (12 * step)
    assert one.slope(r, h) == pytest.approx(numerical, abs=1e-9 * abs(one.value(0.0, h)) / h)


@EACH
def test_the_h_derivative_is_the_change_with_h(one):
    r, h, step = 0.31, 0.8, 1e-4
    value = [one.value(r, h + change * step) for change in (-2, -1, 1, 2)]
    numerical = (value[0] - 8 * value[1] + 8 * value[2] - value[3]) / (12 * step)
    assert one.h_derivative(r, h) == pytest.approx(numerical, rel=1e-9)


@EACH
def test_a_gradient_points_to_the_neighbor_and_is_exactly_zero_where_particles_coincide(one):
    dx = np.zeros((3, one.dim))
    dx[1, 0], dx[2, -1] = 0.3, -0.2
    gradient = one.gradient(dx, 0.9)
    assert gradient.shape == dx.shape
    assert np.all(gradient[0] == 0.0)
    assert gradient[1, 0] == pytest.approx(one.slope(0.3, 0.9))
    assert gradient[2, -1] == pytest.approx(-one.slope(0.2, 0.9))
    assert gradient[1, 0] < 0.0 < gradient[2, -1]


@EACH
def test_a_kernel_ends_at_its_support(one):
    beyond = np.array([1.0, 1.0001, 1.5, 40.0]) * one.support
    assert np.all(one.value(beyond, 1.0) == 0.0)
    assert np.all(one.slope(beyond, 1.0) == 0.0)
    assert one.value(0.999 * one.support, 1.0) != 0.0


def tables():
    """The reference values, a list of (q, text) for each kernel, dimension and quantity."""
    found = {}
    with VALUES.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            found.setdefault((row["kernel"], int(row["dim"]), row["what"]), []).append((row["q"], row["value"]))
    return found


@pytest.mark.parametrize(("which", "rows"), tables().items(), ids=str)
def test_values_and_slopes_are_those_of_the_reference_tables(which, rows):
    name, dim, what = which
    for q, text in rows:
        found = getattr(quiet(name, dim), what)(float(q), 1.0)
        expected = float(text)
        last_digit = 10.0 ** (math.floor(math.log10(abs(expected))) - 8) if expected else 0.0
        assert found == pytest.approx(expected, abs=0.51 * last_digit), q


DEVIATIONS = {
    "cubic-spline": 0.562429, "quartic-spline": 0.632216, "quintic-spline": 0.695046, "liu-quartic": 0.553283,
    "lucy": 0.298807, "wendland-c2": 0.527046, "wendland-c4": 0.460566, "wendland-c6": 0.414039,
}  # fmt: skip


@pytest.mark.parametrize(("name", "expected"), DEVIATIONS.items())
def test_standard_deviations_in_a_plane(name, expected):
    assert quiet(name, 2).standard_deviation == pytest.approx(expected, abs=5e-7)


def test_standard_deviations_on_a_line_of_wendlands_own_shapes():
    found = [kernel(f"wendland-c{k}", 1).standard_deviation for k in (2, 4, 6)]
    assert found == pytest.approx([0.617213, 0.516398, 0.452911], abs=5e-7)


def test_liu_liu_and_lam_is_negative_near_its_end_and_says_so():
    with pytest.warns(UserWarning, match="negative for 1.6957 h"):
        one = kernel("liu-quartic", 2)
    q = np.linspace(0.0, 2.0, 200_001)
    negative = q[np.asarray(one.value(q, 1.0)) < 0.0]
    assert (negative[0], negative[-1]) == pytest.approx((1.6957, 2.0), abs=1e-4)
    assert one.shape(1.8) == pytest.approx(-0.0015833, abs=5e-8)
    assert q[np.argmin(one.shape(q))] == pytest.approx(1.8, abs=1e-5)
    assert np.all(np.asarray(one.slope(np.linspace(1.801, 1.999, 50), 1.0)) > 0.0)


@EACH
def test_all_other_kernels_are_positive_and_fall(one):
    if one.name == "liu-quartic":
        return
    inside = np.linspace(0.0, 0.999, 300) * one.support
    assert np.all(np.asarray(one.value(inside, 1.0)) > 0.0)
    assert np.all(np.asarray(one.slope(inside[1:], 1.0)) < 0.0)


def test_a_gaussian_cut_at_three_lengths_loses_this_much():
    assert [gaussian_deficit(dim) for dim in DIMENSIONS] == pytest.approx([2.2090e-5, 1.23410e-4, 4.39850e-4], rel=1e-4)


INNER = {
    "cubic-spline": (lambda q: 2 / 3 - q**2 + q**3 / 2, {1.0: 11 / 14, 2.0: 16 / 7}),
    "quintic-spline": (lambda q: (3 - q) ** 5 - 6 * (2 - q) ** 5 + 15 * (1 - q) ** 5, {1.0: 0.631799, 3.0: -11.6360}),
}


@pytest.mark.parametrize(("name", "inner"), INNER.items())
def test_the_inner_branch_alone_is_no_kernel(name, inner):
    branch, sums = inner
    nodes, weights = np.polynomial.legendre.leggauss(12)
    for end, expected in sums.items():
        q = 0.5 * end * (nodes + 1.0)
        mass = kernel(name, 2).normalization * np.sum(2 * math.pi * q * branch(q) * weights) * 0.5 * end
        assert mass == pytest.approx(expected, rel=5e-6)


def test_numbers_give_numbers_and_arrays_arrays():
    one = kernel("wendland-c2", 3)
    assert type(one.value(0.1, 0.2)) is float
    assert np.shape(one.value(np.zeros((4, 5)), 0.2)) == (4, 5)
    assert np.shape(one.gradient(np.zeros((4, 5, 3)), np.full(5, 0.2))) == (4, 5, 3)


@pytest.mark.parametrize("h", [0.0, -1.0, math.nan, math.inf, np.array([0.1, 0.0])])
def test_a_smoothing_length_is_a_positive_number(h):
    with pytest.raises(BadInput, match=r"smoothing length h is .*expected positive"):
        kernel("lucy", 1).value(0.1, h)


def test_misspelt_kernels_are_guessed():
    with pytest.raises(BadInput, match="did you mean 'wendland-c2'"):
        kernel("wendlandc2", 2)
    with pytest.raises(BadInput, match=r"dim is 4; .* 1, 2 or 3"):
        kernel("lucy", 4)


def test_a_displacement_has_as_many_numbers_as_the_kernel_has_dimensions():
    with pytest.raises(BadInput, match=r"shape \(5, 2\); expected \(..., 3\)"):
        kernel("lucy", 3).gradient(np.zeros((5, 2)), 1.0)


def test_every_kernel_has_a_number_of_its_own():
    assert sorted(KERNEL_CODES.values()) == list(range(len(KERNELS)))


SHAPES = [law for name, law in vars(kernels).items() if name.endswith(("_value", "_slope"))
          and law.__module__ == kernels.__name__]  # fmt: skip


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.__name__)
def test_a_shape_gives_the_same_for_numbers_and_arrays(shape):
    assert [float(shape(float(q))) for q in Q] == list(shape(Q))
