"""Each wall and obstacle has its own coefficients of restitution."""

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.models.tracers.parameters import parameters_of
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

FREE = {"drag": "none", "added_mass": False}


def thrown(velocity, tank=None, obstacles=(), time=1.0):
    """The velocity of a sphere that starts in the middle of a box of 1 m, without gravity and drag."""
    scene = from_plain(
        {
            "model": "tracers", "duration": time, "frame_every": time, "gravity": 0.0, "hydrodynamics": FREE,
            "integration": {"time_step": time}, "tank": {"high": [1.0, 1.0], **(tank or {})},
            "obstacles": list(obstacles),
            "particles": [{"radius": 1e-3, "density": 2000.0, "positions": [[0.5, 0.5]], "velocity": list(velocity)}],
        }
    )  # fmt: skip
    return list(simulate(scene))[-1].arrays["velocity"][0]


@pytest.mark.parametrize("seed", range(12))
def test_a_hit_multiplies_both_components_by_the_coefficients_of_its_wall(seed):
    """Left, bottom, right, top, each with random coefficients; the others have those of the tank."""
    dice = np.random.default_rng(seed)
    normal, tangential = dice.uniform(0.2, 1.0, 2)
    for wall, (axis, way) in enumerate([(0, -1.0), (1, -1.0), (0, 1.0), (1, 1.0)]):
        velocity = dice.uniform(-0.1, 0.1, 2)
        velocity[axis] = 0.8 * way
        own = {"wall": wall, "restitution": normal, "tangential_restitution": tangential}
        found = thrown(velocity, {"walls": [own], "restitution": 0.1, "tangential_restitution": 0.1})
        assert found[axis] == pytest.approx(-normal * velocity[axis], rel=1e-12)
        assert found[1 - axis] == pytest.approx(tangential * velocity[1 - axis], rel=1e-12)
        other = thrown(velocity, {"walls": [{**own, "wall": (wall + 1) % 4}], "restitution": 0.3})
        assert other[axis] == pytest.approx(-0.3 * velocity[axis], rel=1e-12)
        assert other[1 - axis] == pytest.approx(velocity[1 - axis], rel=1e-12)


@pytest.mark.parametrize(
    "shape", [{"low": [0.7, 0.0], "high": [0.8, 1.0]}, {"center": [0.8, 0.5], "radius": 0.1},
              {"vertices": [[0.7, 0.0], [0.8, 0.0], [0.8, 1.0], [0.7, 1.0]]}]
)  # fmt: skip
def test_an_obstacle_has_its_own_coefficients(shape):
    own = {**shape, "restitution": 0.25, "tangential_restitution": 0.5}
    found = thrown([0.4, 0.0], {"restitution": 0.9}, [own])
    assert found == pytest.approx([-0.1, 0.0], rel=1e-12)
    assert thrown([0.4, 0.0], {"restitution": 0.9}, [shape]) == pytest.approx([-0.36, 0.0], rel=1e-12)


def test_a_wall_that_the_tank_does_not_have_is_refused():
    with pytest.raises(SceneError, match="has 4 walls"):
        thrown([0.1, 0.0], {"walls": [{"wall": 4, "restitution": 0.5}]})


def test_each_side_of_a_tank_of_liquid_has_its_own_coefficients():
    from ecume.models.sph.setup.walls_and_bodies import guard_of

    scene = from_plain(
        {
            "model": "sph", "duration": 0.1, "frame_every": 0.1, "spacing": 0.25,
            "tank": {"high": [1.0, 1.0], "restitution": 0.4, "tangential_restitution": 0.9,
                     "left": {"restitution": 0.1}, "top": {"tangential_restitution": 0.2}},
            "fluid": [{"low": [0.0, 0.0], "high": [1.0, 0.5]}],
            "obstacles": [{"low": [0.4, 0.6], "high": [0.6, 0.8], "tangential_restitution": 0.3}],
        }
    )  # fmt: skip
    number = guard_of(scene, support=0.5).sheet.number
    assert number[:, 7].tolist() == [0.1, 0.4, 0.4, 0.4] + [0.4] * 4
    assert number[:, 8].tolist() == [0.9, 0.9, 0.9, 0.2] + [0.3] * 4


def test_a_coefficient_of_an_open_side_is_refused():
    open_side = {"model": "sph", "duration": 0.1, "frame_every": 0.1, "spacing": 0.25,
                 "tank": {"high": [1.0, 1.0], "top": {"kind": "open", "restitution": 0.5}},
                 "fluid": [{"low": [0.0, 0.0], "high": [1.0, 0.5]}]}  # fmt: skip
    with pytest.raises(SceneError, match="is of a wall"):
        from_plain(open_side)


def test_parameters_keep_the_order_of_surfaces():
    scene = from_plain(
        {
            "model": "tracers", "duration": 1.0, "frame_every": 1.0,
            "tank": {"high": [1.0, 1.0], "restitution": 0.8, "walls": [{"wall": 3, "restitution": 0.7}]},
            "obstacles": [{"low": [0.2, 0.2], "high": [0.3, 0.3], "restitution": 0.6}],
            "particles": [{"radius": 1e-3, "density": 2000.0, "positions": [[0.5, 0.5]]}],
        }
    )  # fmt: skip
    assert parameters_of(scene).bouncing.number[:, 7].tolist() == [0.8, 0.8, 0.8, 0.7] + [0.6] * 4
