"""Random scenes run to their end or are refused with the reason: see `tests.models.soft.random_scenes`."""

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.models.soft import SOFT
from ecume.scenes.schema import from_plain
from tests.models.soft.random_scenes import (
    draw,
    drawn,
    error_of_scene,
    explicit,
    outcome,
    reordered,
    run,
    turned,
    unlike,
)

pytestmark = [pytest.mark.compiled]


@pytest.mark.long
@pytest.mark.parametrize("seed", [275, 1010, 2005, 2007, 2009])
def test_a_random_scene_keeps_what_every_run_keeps(seed):
    """Balance, imposed stresses, symmetry and energy; and, with its spheres in another order, rotated, or continued
    from its middle, it is the same.
    """
    assert outcome(seed) == ("done", {})


@pytest.mark.long
@pytest.mark.parametrize("seed", [40, 48])
def test_a_film_that_opens_costs_no_work_that_nothing_does(seed):
    """In the step after it, forces relax within a time far below the step: its work was wrong by half, its gaps not."""
    assert outcome(seed) == ("done", {})


@pytest.mark.long
def test_films_that_open_one_after_another_leave_stresses_as_accurate_as_the_tolerance_says():
    """In a loose packing under a pressure: stresses differed by 5 to 9 % from those of a finer tolerance, since a step
    was only shortened if it passed half of the reach of films. Those in another order of the spheres differed by 1e-3,
    and by a seventh where the rounding of a budget chose the lengths of steps.
    """
    dice = np.random.default_rng(250)
    plain = explicit(from_plain(draw(dice)))
    other, order = reordered(plain, dice)

    def at(given, tolerance):
        return from_plain({**given, "integration": {**given["integration"], "tolerance": tolerance}})

    fine = run(at(plain, 1e-6))[0]
    for tolerance in (1e-5, 1e-4):
        scene = at(plain, tolerance)
        frames = run(scene)[0]
        assert unlike(scene, fine, frames) < error_of_scene(scene)
        assert unlike(scene, frames, run(at(other, tolerance))[0], order=order) < tolerance


def test_rounding_does_not_decide_when_films_open():
    """One film that makes a loose network rigid opened within a step, or in the next one: stresses and work of
    positions that differed by 1e-12 radii differed by 17 %.
    """
    plain, dice = explicit(from_plain(drawn(np.random.default_rng(38)))), np.random.default_rng(3)
    radius = max(max(one["radius"]) for one in plain["particles"])
    moved = [
        one | {"positions": (one["positions"] + 1e-12 * radius * dice.normal(size=np.shape(one["positions"]))).tolist()}
        for one in plain["particles"]
    ]
    scene = from_plain(plain)
    assert unlike(scene, run(scene)[0], run(from_plain(plain | {"particles": moved}))[0]) < error_of_scene(scene)


def test_rounding_does_not_decide_where_a_sphere_with_a_single_film_rolls():
    """Nothing resists its rolling: positions that differed by 1e-12 radii were balanced at others that differed by
    2e-6, and the rest of the run followed.
    """
    plain = explicit(from_plain(drawn(np.random.default_rng(25))))
    radius, dice = max(max(one["radius"]) for one in plain["particles"]), np.random.default_rng(3)
    moved = [
        one | {"positions": (one["positions"] + 1e-12 * radius * dice.normal(size=np.shape(one["positions"]))).tolist()}
        for one in plain["particles"]
    ]
    scenes = [from_plain(plain), from_plain(plain | {"particles": moved})]
    here, there = (SOFT.start(scene, SOFT.parameters(scene)).position for scene in scenes)
    assert np.abs(here - there).max() < 1e-11 * radius


def test_pressed_walls_of_a_floppy_packing_are_refused_with_the_reason_and_the_key():
    """The message blamed the size of the forces, at a pressure of 1e-5 of the modulus."""
    word, found = outcome(189, drawn)
    assert word == "refused"
    assert found["reason"].startswith("scene: walls: the films bear no stress, however small")


@pytest.mark.parametrize("seed", [97, 109])
def test_what_rounding_of_positions_leaves_is_no_imbalance(seed):
    """Deflections of 1e-12 radii are known to a part in 1e4."""
    assert outcome(seed) == ("done", {})


def test_walls_that_nothing_presses_leave_no_imbalance_but_rounding():
    """The forces of a packing at rest are rounding: the largest was reported as four times the typical one."""
    assert outcome(1001) == ("done", {})


LOOSE = {
    "model": "soft", "duration": 1.0, "frame_every": 0.5, "rotation": True, "liquid": {"viscosity": 1.0},
    "particles": [{"radius": radius, "modulus": 5e4, "count": 8} for radius in (1e-3, 1.4e-3)],
    "long_range_forces": {"law": "steric", "steric_strength": 5e-5, "steric_length": 1e-5},
    "hydrodynamics": {"drag": "stokes"}, "protocol": [{"time": 0.0, "pressure": 0.1}],
    "cell": {"size": [1.0, 1.0], "volume_fraction": 0.6, "minimum_gap": 2e-5},
    "integration": {"integrator": "tr-bdf2", "tolerance": 1e-3},
}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("change", [reordered, lambda plain, dice: turned(plain, dice, 2)])
def test_a_pressed_loose_packing_depends_neither_on_the_order_of_spheres_nor_on_the_axes(change):
    plain = explicit(from_plain(LOOSE))
    scene = from_plain(plain)
    again = change(plain, np.random.default_rng(1))[0]
    assert unlike(scene, run(scene)[0], run(from_plain(again))[0]) < 1e-5


def test_spheres_that_roll_into_one_another_at_once_are_refused_with_what_resists_rolling():
    heavy = {
        "model": "soft", "duration": 0.02, "frame_every": 0.01, "seed": 3, "rotation": True, "gravity": 1.0,
        "liquid": {"viscosity": 1e-3, "density": 1.0}, "walls": [{"side": "bottom"}],
        "particles": [{"radius": radius, "modulus": 1.0, "count": 4, "density": 1.001} for radius in (1.0, 1.3)],
        "cell": {"size": [1.0, 1.0], "volume_fraction": 0.6},
    }  # fmt: skip
    scene = from_plain(heavy)
    with pytest.raises(SceneError, match=r"forces roll spheres around their films at once.*drag = 'stokes'"):
        SOFT.start(scene, SOFT.parameters(scene))
    carried = from_plain(heavy | {"hydrodynamics": {"drag": "stokes"}})
    assert max(frame.numbers["imbalance"] for frame in run(carried)[0]) < 1e-7
