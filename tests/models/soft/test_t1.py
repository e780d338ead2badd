"""The T1 process: durations, outcomes, invariances."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ecume.errors import BadInput
from ecume.models.soft.t1.process import follow, t1_process, t1_scene

from .clusters import Referee

pytestmark = pytest.mark.compiled

PULL = (0.0, math.sqrt(3.0) * 1e-3)


@pytest.mark.parametrize(("gap", "kappa"), [(0.1, 1e-2), (1e-2, 1e-3)])
def test_the_solver_times_the_swap_as_a_referee_with_nothing_in_common_does(gap, kappa):
    referee = Referee(gap, kappa)

    def hit(time, y):
        return referee.missing(time, y)

    hit.terminal = True
    given = {"method": "Radau", "rtol": 1e-8, "atol": 1e-9}
    first = solve_ivp(referee.rate, (0, 0.01), referee.begin, **given, first_step=1e-5)
    rest = solve_ivp(referee.rate, (0.01, 1e3), first.y[:, -1], **given, events=hit)
    assert t1_process(gap=gap, reduced_force=kappa).duration == pytest.approx(rest.t[-1], rel=2e-6)


@pytest.mark.parametrize(
    ("gap", "kappa", "half", "most", "nearly_all"),
    [
        (1e-1, 1e-6, 15.90252, 22.6395, 29.28121),
        (1e-2, 1e-3, 42.42681, 48.461523, 54.98724),
        (1e-3, 1e-4, 76.55292, 82.306622, 88.02111),
        (1e-4, 1e-6, 68.99517, 74.83532, 80.70461),
        (1e-5, 1e-2, 5.191984e7, 5.192077e7, 5.192135e7),
    ],
)
def test_durations_over_the_whole_range_are_those_of_an_independent_solution(gap, kappa, half, most, nearly_all):
    found = t1_process(gap=gap, reduced_force=kappa, threshold=(0.5, 0.9, 0.99))
    assert found.outcome == "t1"
    assert list(found.durations.values()) == pytest.approx([half, most, nearly_all], rel=1e-5)


@pytest.mark.parametrize(
    ("forces", "outcome"),
    [
        ((0.0, 1e-3), "t1"), ((-1e-3, 0.0), "t1"), ((5e-4, 1e-3), "t1"), ((-2e-3, -2.5e-4), "t1"),
        ((1e-3, 1e-3), "blocked"), ((5e-4, 0.0), "blocked"), ((6.5e-4, 1e-3), "blocked"),
        ((0.0, -1e-3), "dissociated"), ((-1e-3, -5e-4), "dissociated"), ((1e-3, -2.5e-4), "dissociated"),
    ],
)  # fmt: skip
def test_each_region_of_the_phase_diagram_has_its_outcome(forces, outcome):
    assert t1_process(gap=1e-2, forces=forces, rtol=1e-6).outcome == outcome


def turned(scene, angle):
    """The scene with all places and forces turned."""
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    spheres = tuple(
        dataclasses.replace(one, positions=(tuple(turn @ one.positions[0]),), force=tuple(turn @ one.force))
        for one in scene.particles
    )
    return dataclasses.replace(scene, particles=spheres)


def test_rounding_does_not_turn_a_cluster_over_however_long_it_is_pressed():
    found = t1_process(gap=1e-4, reduced_force=0.005623413251903491, rtol=1e-6)
    assert found.outcome == "t1"
    assert found.duration == pytest.approx(242698.6, rel=1e-3)


def test_turning_the_cluster_changes_nothing():
    scene = t1_scene(1e-2, PULL, "paper", 0.01, 1e-8)
    times = [follow(turned(scene, angle), PULL, (0.9,)).duration for angle in (0.0, 0.3, 2.0)]
    assert times == pytest.approx([times[0]] * 3, rel=1e-9)


def test_naming_the_spheres_otherwise_changes_nothing():
    scene = t1_scene(1e-2, PULL, "paper", 0.01, 1e-8)
    left, right, top, bottom = scene.particles
    swapped = dataclasses.replace(scene, particles=(right, left, bottom, top))
    times = [follow(one, PULL, (0.9,)).duration for one in (scene, swapped)]
    assert times[1] == pytest.approx(times[0], rel=1e-9)


def in_units(scene, length, force):
    """The scene with every length and force multiplied; times stay."""
    spheres = tuple(
        dataclasses.replace(
            one,
            radius=one.radius * length,
            modulus=one.modulus * force / length**2,
            positions=(tuple(length * x for x in one.positions[0]),),
            force=tuple(force * f for f in one.force),
        )
        for one in scene.particles
    )
    thick = dataclasses.replace(scene.liquid, viscosity=scene.liquid.viscosity * force / length**2)
    return dataclasses.replace(scene, particles=spheres, liquid=thick)


def test_other_units_change_nothing():
    scene = t1_scene(1e-2, PULL, "paper", 0.01, 1e-8)
    other = in_units(scene, 1.7e-3, 3.1e-6)
    times = [follow(scene, PULL, (0.9,)), follow(other, PULL, (0.9,), units=(1.7e-3, 3.1e-6))]
    assert times[1].duration == pytest.approx(times[0].duration, rel=1e-9)


def test_the_series_contains_the_stages_of_a_swap():
    found = t1_process(gap=1e-3, reduced_force=1e-3)
    angle, sliding = np.degrees(found.curve("angle")), found.curve("sliding_force")
    assert angle[0] == pytest.approx(60.0)
    assert angle[-1] < 31.0
    tension = found.curve("tension_horizontal")
    assert np.interp([10.1, 390.0], found.time, tension) == pytest.approx([1.013, 0.059], abs=1e-3)
    assert np.interp(360.0, found.time, sliding) == pytest.approx(0.519, abs=1e-3)
    assert np.interp(300.0, found.time, angle) > 59.0
    assert found.curve("gap_diagonal").min() > 0.0


def test_early_sliding_is_less_than_pulling_by_gap_over_radius():
    found = t1_process(gap=1e-2, reduced_force=1e-6, rtol=1e-6)
    early = np.interp(0.05, found.time, found.curve("sliding_force"))
    assert early == pytest.approx(4 / (3 * math.sqrt(3)) * 1e-2, rel=0.03)


def test_pulling_narrow_gaps_harder_takes_longer():
    eased, strained = (t1_process(gap=1e-4, reduced_force=kappa, rtol=1e-6).duration / kappa for kappa in (1e-4, 1e-2))
    assert strained > eased


@pytest.mark.parametrize(("method", "order", "error"), [("paper", 2, 3e-3), ("rk2", 2, 2e-3), ("rk4", 4, 1e-4)])
def test_the_papers_own_way_converges_with_its_order_and_leaves_the_balance(method, order, error):
    steps = (2.5e-3, 1.25e-3) if method == "paper" else (5e-3, 2.5e-3)
    given = {"gap": 1e-2, "reduced_force": 1e-3}
    exact = t1_process(**given).duration
    coarse, fine = (t1_process(**given, method=method, time_step=step) for step in steps)
    errors = [abs(one.duration / exact - 1) for one in (coarse, fine)]
    assert errors[0] < error
    assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.4)
    assert coarse.imbalance > 1e-5 > 1e-9 > t1_process(**given).imbalance


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"reduced_force": 1e-3, "forces": (0.0, 1e-3)}, "got both"),
        ({}, "got neither"),
        ({"forces": (0.0, 0.0)}, "different"),
        ({"reduced_force": -1.0}, "reduced_force"),
        ({"reduced_force": 1e-3, "gap": 0.0}, "gap"),
        ({"reduced_force": 3e-8}, "lost in rounding"),
        ({"forces": (0.0, 1e-7)}, "expected 1e-07 or more"),
        ({"reduced_force": 1e-3, "method": "magic"}, "no method"),
        ({"reduced_force": 1e-3, "prefactors": "magic"}, "prefactors"),
        ({"reduced_force": 1e-3, "rtol": 0.0}, "rtol is 0.0; expected 1e-11 to 0.01"),
        ({"reduced_force": 1e-3, "rtol": float("nan")}, "rtol is nan"),
    ],
)
def test_a_swap_that_cannot_be_is_refused(given, says):
    with pytest.raises(BadInput, match=says):
        t1_process(**({"gap": 1e-2} | given))
