"""A moving dish, and the motion of floats in its frame."""

import math

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.models import MODELS
from ecume.simulation import simulate
from tests.models.floating.bowls import HEAVY, WATER, scene_of
from tests.models.floating.test_rafts import end_of

APART = '[interaction]\nlaw = "none"\n'
SWING = 'amplitude = 1e-3\nfrequency = "4 Hz"\ndirection = "30 deg"\n'


def dish(
    moved,
    rest="",
    *,
    hydrodynamics='drag = "none"',
    integration="",
    floats=f"{HEAVY}positions = [[1e-3, 2e-3]]\n",
    **times,
):
    """One float in a moving dish without a meniscus."""
    table = f'[dish]\nradius = 0.02\nlaw = "none"\n[dish.motion]\n{moved}'
    forces = f"[hydrodynamics]\n{hydrodynamics}\n" if hydrodynamics else ""
    steps = f"[integration]\n{integration}\n" if integration else ""
    return scene_of(f"{WATER}[[particles]]\n{floats}{table}{forces}{steps}{APART}{rest}", **times)


@pytest.mark.parametrize("integrator", ["velocity-verlet", "stormer-verlet", "rk4"])
def test_a_float_without_drag_stays_where_it_is_while_the_dish_swings(integrator):
    integration = f'integrator = "{integrator}"\n'
    frames = list(simulate(dish(SWING, integration=integration, duration=0.3, frame_every=0.01)))
    place = [[frame.numbers["dish_x"], frame.numbers["dish_y"]] for frame in frames]
    there = np.array([frame.arrays["position"][0] for frame in frames]) + np.array(place)
    assert np.ptp(place, axis=0) == pytest.approx(2e-3 * np.array([math.cos(math.pi / 6), 0.5]), rel=0.01)
    assert there == pytest.approx(np.tile([1e-3, 2e-3], (len(frames), 1)), abs=2e-6)


def test_the_error_of_a_swing_falls_as_the_square_of_the_step():
    ends = []
    for step in (4e-3, 2e-3, 1e-3):
        *_, last = simulate(dish(SWING, integration=f"time_step = {step}", duration=0.1, frame_every=0.1))
        ends.append(last.arrays["position"][0, 0] + last.numbers["dish_x"] - 1e-3)
    assert ends[0] / ends[1] == pytest.approx(4.0, rel=0.05)
    assert ends[1] / ends[2] == pytest.approx(4.0, rel=0.05)


def test_a_liquid_that_rests_keeps_a_float_at_rest_by_its_drag():
    scene = dish(SWING, hydrodynamics="", integration='integrator = "overdamped"', duration=0.3, frame_every=0.01)
    for frame in simulate(scene):
        x = frame.arrays["position"][0, 0] + frame.numbers["dish_x"]
        assert x == pytest.approx(1e-3, abs=2e-5)


def test_what_is_carried_as_a_whole_feels_nothing():
    floats = f"{HEAVY}positions = [[1e-3, 2e-3], [4e-3, 2e-3]]\n"
    carried = dish(f"{SWING}entrainment = 1.0\n", floats=floats, duration=0.02, frame_every=0.01)
    step = f"time_step = {MODELS['floating'].parameters(carried).time_step!r}"
    at_rest = dish("", floats=floats, duration=0.02, frame_every=0.01, integration=step)
    assert end_of(carried) == end_of(at_rest)


def test_a_frame_that_is_drawn_through_a_liquid_takes_its_floats_along():
    scene = dish(
        "velocity = [0.02, 0.0]\n",
        hydrodynamics="",
        integration='integrator = "overdamped"',
        duration=1.5,
        frame_every=0.1,
    )
    frames = list(simulate(scene))
    assert frames[1].arrays["velocity"][0] == pytest.approx([-0.02, 0.0], rel=1e-9)
    behind = -math.sqrt(0.019**2 - frames[-1].arrays["position"][0, 1] ** 2)
    assert frames[-1].arrays["position"][0, 0] == pytest.approx(behind, rel=1e-3)


@pytest.mark.parametrize("rest", ['[hydrodynamics]\ndrag = "schiller-naumann"'])
def test_what_does_not_go_with_a_dish_in_motion_is_reported(rest):
    with pytest.raises(SceneError, match=r"dish.motion: a dish in motion needs"):
        MODELS["floating"].parameters(dish(SWING, rest, hydrodynamics=""))
