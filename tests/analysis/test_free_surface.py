"""Grids, outlines, fronts and profiles of a block of liquid with known results."""

import numpy as np
import pytest

from ecume.analysis.energies import energy_budget
from ecume.analysis.free_surface import (
    Walls,
    free_surface,
    front_position,
    level_by_column,
    mirrored,
    top_by_column,
    walls_of,
)
from ecume.analysis.grids import grid_over, linear_on_grid, on_grid, profile_along, velocity_profile
from ecume.errors import BadInput
from ecume.scenes.schema import from_plain
from ecume.trajectories.frame import Frame

SPACING = 0.05
REACH = 4 * SPACING


def block(length=2.0, depth=1.0, jitter=0.2, away=0.0):
    """Liquid over 0 < x < length, 0 < y < depth; the pressure equals the depth, and the flow is a shear."""
    axes = [SPACING * (np.arange(round(side / SPACING)) + 0.5) for side in (length, depth)]
    position = np.stack([grid.ravel() for grid in np.meshgrid(*axes, indexing="ij")], axis=1) + away
    position = position + jitter * SPACING * np.random.default_rng(1).uniform(-1, 1, position.shape)
    count = len(position)
    arrays = {
        "position": position,
        "velocity": np.column_stack([3.0 * position[:, 1], np.zeros(count)]),
        "pressure": depth - position[:, 1],
        "density": np.full(count, 1000.0),
        "mass": np.full(count, 1000.0 * SPACING**2),
    }
    return Frame(0.0, arrays, {}, {})


def with_drop(frame, place):
    """The block with a separate particle."""
    extra = {name: np.concatenate([array, array[:1]]) for name, array in frame.arrays.items()}
    extra["position"][-1] = place
    return frame._replace(arrays=extra)


def test_what_grows_linearly_is_exact_on_a_grid_up_to_the_walls():
    grid = grid_over((0.0, 0.0), (2.0, 1.0), 0.1)
    x, y = grid.points.T.reshape(2, *grid.shape)
    assert linear_on_grid(block(), "pressure", grid, REACH) == pytest.approx(1.0 - y, abs=1e-12)
    inner = on_grid(block(), "velocity", grid, REACH)[3:-3, 3:-3]
    assert inner[..., 0] == pytest.approx(3.0 * y[3:-3, 3:-3], abs=0.02)
    assert x[5, 0] == pytest.approx(0.5)


def test_a_grid_says_nothing_where_there_is_no_liquid():
    grid = grid_over((0.0, 0.0), (2.0, 2.0), 0.25)
    values = linear_on_grid(block(), "pressure", grid, REACH)
    assert np.isnan(values[:, -2:]).all()
    assert np.isfinite(values[:, :4]).all()
    with pytest.raises(BadInput, match="no nodes"):
        grid_over((0.0, 0.0), (0.0, 2.0), 0.25)


def test_an_outline_without_walls_goes_around_the_liquid():
    (line,) = free_surface(block(), SPACING)
    assert line[0] == pytest.approx(line[-1])
    assert line.min(axis=0) == pytest.approx([0.0, 0.0], abs=0.2 * SPACING)
    assert line.max(axis=0) == pytest.approx([2.0, 1.0], abs=0.2 * SPACING)


def test_an_outline_in_a_tank_is_the_free_surface_alone():
    walls = Walls(np.zeros(2), np.array([2.0, np.inf]))
    (line,) = free_surface(block(), SPACING, walls)
    assert line[:, 1] == pytest.approx(1.0, abs=0.2 * SPACING)
    assert (line[:, 0].min(), line[:, 0].max()) == pytest.approx((0.0, 2.0))


def test_a_corner_has_images_in_all_three_quarters_beyond_it():
    images = mirrored(block(), Walls(np.zeros(2), np.full(2, np.inf)), REACH)
    far = images.arrays["position"]
    own = far[:, None, :] * [[1, 1]]
    assert ((own[:, 0] < 0).all(axis=1).sum(), (own[:, 0, 0] < 0).sum()) == (16, 4 * 20 + 16)
    assert images.arrays["pressure"][(far < 0).all(axis=1)].min() > 0.75


def test_a_front_is_the_edge_of_the_liquid_and_not_a_drop():
    frame = with_drop(block(jitter=0.0), (2.7, 0.1))
    assert front_position(frame, SPACING) == pytest.approx(2.0)
    assert front_position(block(jitter=0.0, depth=0.5), SPACING, below=0.2) == pytest.approx(2.0)
    with pytest.raises(BadInput, match="no liquid below"):
        front_position(frame, SPACING, below=0.01)


def test_levels_are_volumes_over_ground_and_tops_are_the_highest():
    edges = np.linspace(0.0, 4.0, 9)
    frame = with_drop(block(jitter=0.0), (0.3, 2.0))
    level, top = level_by_column(frame, edges), top_by_column(frame, edges, SPACING)
    assert level[1:4] == pytest.approx(1.0)
    assert level[4:] == pytest.approx(0.0)
    assert (top[0], top[1]) == pytest.approx((2.0 + SPACING / 2, 1.0))
    assert np.isnan(top[4:]).all()


def test_fronts_and_tops_follow_the_axis_that_points_up():
    frame = with_drop(block(jitter=0.0), (0.3, 2.0))
    position = frame.arrays["position"]
    turned = frame.with_arrays(
        {"position": np.column_stack([position[:, 0], np.full(len(position), 9.0), position[:, 1]])}
    )
    edges = np.linspace(0.0, 4.0, 9)
    np.testing.assert_array_equal(top_by_column(turned, edges, SPACING, "z"), top_by_column(frame, edges, SPACING))
    assert front_position(turned, SPACING, below=0.2, up="z") == front_position(frame, SPACING, below=0.2)
    with pytest.raises(BadInput, match="no liquid below"):
        front_position(turned, SPACING, below=0.01, up="z")


def test_walls_follow_the_axis_that_points_up():
    tank = {"high": [1.0, 2.0, 3.0], "top": {"kind": "open"}, "front": {"kind": "open"}}
    fluid = [{"low": [0.0, 0.0, 0.0], "high": [0.5, 0.5, 0.5]}]
    scene = from_plain(
        {"model": "sph", "duration": 1.0, "frame_every": 1.0, "spacing": 0.1, "up": "z", "tank": tank, "fluid": fluid}
    )
    walls = walls_of(scene.tank, scene.up)
    np.testing.assert_array_equal(walls.low, [0.0, -np.inf, 0.0])
    np.testing.assert_array_equal(walls.high, [1.0, 2.0, np.inf])
    np.testing.assert_array_equal(walls_of(scene.tank).high, [1.0, np.inf, 3.0])


def test_a_profile_of_shear_is_a_straight_line():
    profile = velocity_profile(block(), ((1.0, 0.0), (1.0, 1.0)), 11, REACH)
    assert profile.along == pytest.approx(np.linspace(0.0, 1.0, 11))
    assert profile.values[:, 0] == pytest.approx(3.0 * profile.along, abs=1e-12)
    assert profile_along(block(), "pressure", ((0.0, 0.5), (2.0, 0.5)), 5, REACH).values == pytest.approx(0.5)


def test_what_a_run_loses_is_what_it_had_less_what_it_has():
    units = {"kinetic_energy": "J", "total_energy": "J", "front": "m"}
    numbers = [{"kinetic_energy": 1.0, "total_energy": 5.0 - n, "front": 0.0} for n in range(3)]
    budget = energy_budget(Frame(float(n), {}, numbers[n], units) for n in range(3))
    assert set(budget) == {"time", "kinetic_energy", "total_energy", "lost", "dissipated"}
    assert budget["lost"].tolist() == budget["dissipated"].tolist() == [0.0, 1.0, 2.0]


def test_what_was_done_to_it_and_is_not_there_was_dissipated():
    numbers = [{"total_energy": 5.0 + n, "injected_work": 1.0 + 3.0 * n} for n in range(3)]
    units = {"total_energy": "J", "injected_work": "J"}
    budget = energy_budget(Frame(float(n), {}, numbers[n], units) for n in range(3))
    assert budget["lost"].tolist() == [0.0, -1.0, -2.0]
    assert budget["dissipated"].tolist() == [0.0, 2.0, 4.0]
