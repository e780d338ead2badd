"""Stream functions of random grids: the ways to fit agree, and no liquid crosses walls and land that span a period."""

import numpy as np
import pytest

from ecume.models.gridded_flows import Grid, fitted, stream_velocity
from ecume.models.stream_fits import Edges, Fits, cosine_fit, fit_of, sine_fit, sparse_fit

SEEDS = range(6)


def edges_of(shape, *, closed=False, wrapped=()):
    along, up = np.zeros((shape[0] - 1, shape[1]), bool), np.zeros((shape[0], shape[1] - 1), bool)
    if closed:
        along[:, [0, -1]] = up[[0, -1]] = True
    return Edges(along, up, wrapped)


def changes(rng, shape):
    return rng.normal(size=(shape[0] - 1, shape[1])), rng.normal(size=(shape[0], shape[1] - 1))


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("seed", SEEDS)
def test_transforms_are_the_sparse_fit(seed, closed):
    rng = np.random.default_rng(seed)
    shape = tuple(int(n) for n in rng.integers(3, 20, 2))
    edges = edges_of(shape, closed=closed)
    quick = sine_fit if closed else cosine_fit
    assert fit_of(edges) is quick
    along, up = changes(rng, shape)
    found, expected = quick(along, up), sparse_fit(edges)(along, up)
    assert found - found[0, 0] == pytest.approx(expected - expected[0, 0], abs=1e-12)


def test_grids_too_narrow_for_transforms_are_fitted():
    rng = np.random.default_rng(1)
    assert (fit_of(edges_of((2, 5), closed=True))(*changes(rng, (2, 5))) == 0.0).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_a_fit_has_the_least_squares_of_all_functions_allowed(seed):
    """With walls, land across the sides and periods: those of a dense solver, for the same constraints."""
    rng = np.random.default_rng(seed)
    shape = tuple(int(n) for n in rng.integers(5, 9, 2))
    wrapped = ((0,), (1,), (0, 1))[seed % 3]
    edges = edges_of(shape, wrapped=wrapped)
    land = rng.uniform(size=shape) < 0.4
    for axis in wrapped:
        np.moveaxis(land, axis, 0)[-1] = np.moveaxis(land, axis, 0)[0]
    edges.along[:], edges.up[:] = land[:-1] & land[1:], land[:, :-1] & land[:, 1:]
    along, up = changes(rng, shape)
    place = np.arange(land.size).reshape(shape)
    one = np.concatenate([place[:-1].ravel(), place[:, :-1].ravel()])
    other = np.concatenate([place[1:].ravel(), place[:, 1:].ravel()])
    differences = np.eye(land.size)[other] - np.eye(land.size)[one]
    shut = np.concatenate([edges.along.ravel(), edges.up.ravel()])
    barred = [differences[shut]]
    for axis in wrapped:
        rise = np.eye(land.size)[np.take(place, -1, axis)] - np.eye(land.size)[np.take(place, 0, axis)]
        barred.append(np.diff(rise, axis=0))
    _, sizes, rows = np.linalg.svd(np.concatenate(barred))
    free = rows[int((sizes > 1e-9).sum()) :].T
    values, *_ = np.linalg.lstsq(differences @ free, np.concatenate([along.ravel(), up.ravel()]), rcond=1e-9)
    expected = (free @ values).reshape(shape)
    found = sparse_fit(edges)(along, up)
    assert found - found[0, 0] == pytest.approx(expected - expected[0, 0], abs=1e-9)


def test_a_fit_is_kept_while_the_same_edges_are_shut():
    fits, edges = Fits(), edges_of((5, 6), wrapped=(0,))
    kept = fits.of(edges)
    assert fits.of(edges_of((5, 6), wrapped=(0,))) is kept
    assert fits.of(edges_of((5, 6), wrapped=(1,))) is not kept
    assert fits.of(edges_of((5, 6), closed=True)) is sine_fit


def noisy_channel(rng, noise):
    """Velocities between walls, periodic along x, with divergence."""
    x, z = np.linspace(0.0, 1.0, 11), np.linspace(0.0, 1.0, 9)
    w = 0.1 * np.sin(np.pi * z) * np.ones((len(x), 1)) + noise * rng.normal(size=(len(x), len(z)))
    w[-1] = w[0]
    w[:, [0, -1]] = 0.0
    velocity = np.stack([z * (1.0 - z) * np.ones_like(w), w], axis=-1)
    return Grid((0.0, 0.0), (x[1], z[1]), np.zeros(1), velocity[None])


@pytest.mark.parametrize("noise", [0.0, 0.05])
@pytest.mark.parametrize("axis", [0, 1])
def test_no_liquid_crosses_walls_along_a_period(axis, noise):
    """Nor land that spans it, where the file has divergence."""
    grid = noisy_channel(np.random.default_rng(7), noise)
    grid.velocity[0, :, 4] = np.nan
    if axis == 1:
        turned = np.ascontiguousarray(grid.velocity.transpose(0, 2, 1, 3)[..., ::-1])
        grid = Grid(grid.low, grid.step[::-1], grid.times, turned)
    shape = fitted(grid, "divergence-free", (axis,)).shape
    for along in np.linspace(0.0, 1.0, 41):
        for wall in (0.0, 0.5, 1.0):
            x, z = (along, wall) if axis == 0 else (wall, along)
            assert abs(stream_velocity(shape, x, 0.0, z, 0.0)[2 if axis == 0 else 0]) < 1e-14


def test_no_liquid_crosses_land_across_a_periodic_side_through_which_it_flows():
    """Land that ends within the period, in a flow through the tank as a whole."""
    rng = np.random.default_rng(8)
    velocity = rng.normal(0.3, 0.1, (1, 11, 9, 2))
    velocity[0, [0, 1, 2, 8, 9, 10], 3:6] = np.nan
    velocity[0, -1] = velocity[0, 0]
    shape = fitted(Grid((0.0, 0.0), (0.1, 0.125), np.zeros(1), velocity), "divergence-free", (0,)).shape
    for x in (*np.linspace(0.0, 0.2, 9), *np.linspace(0.8, 1.0, 9)):
        assert abs(stream_velocity(shape, x, 0.0, 0.375, 0.0)[2]) < 1e-14
    through = [stream_velocity(shape, x, 0.0, 0.0, 0.0)[2] for x in np.linspace(0.0, 1.0, 41)]
    assert np.mean(through) > 0.1
