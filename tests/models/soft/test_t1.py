"""The T1 process: durations, outcomes, invariances."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ecume.errors import BadInput
from ecume.laws.soft_pair import SoftPair, passage_time
from ecume.models.soft.t1.cluster import Instant, follow_symmetric
from ecume.models.soft.t1.process import follow, t1_process, t1_scene

from .clusters import Referee

pytestmark = [pytest.mark.compiled, pytest.mark.sampled(2)]

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


@pytest.mark.parametrize(("gap", "kappa"), [(1e-8, 1e-3), (1e-6, 0.1)])
def test_the_longest_processes_take_what_parting_two_spheres_takes(gap, kappa):
    found = t1_process(gap=gap, reduced_force=kappa, rtol=1e-4)
    parting = passage_time(SoftPair(1.0, 1.0, kappa), kappa, gap, 1.0)
    assert found.outcome == "t1"
    # Deflected by kappa^(2/3), the diagonals stand less steep, and pull harder.
    assert found.duration == pytest.approx(parting, rel=0.03 if kappa < 0.05 else 0.3)


@pytest.mark.parametrize(("gap", "constant"), [(0.1, 2.5), (1e-2, 2.325)])
def test_the_faintest_forces_part_rigid_spheres(gap, constant):
    found = t1_process(gap=gap, reduced_force=1e-12, rtol=1e-6)
    assert (found.duration - 0.005) / (1.5 * math.pi) + math.log(gap) == pytest.approx(constant, abs=1e-4)
    assert found.imbalance < 1e-12


@pytest.mark.long
def test_deflections_as_unknowns_give_what_positions_give():
    given = 1e-3, (-2e-4, 1e-3), (0.5, 0.9)
    ours = follow_symmetric(*given, ("physical", 0.01, 1e-7))
    theirs = follow(t1_scene(1e-3, given[1], "physical", 0.01, 1e-7), *given[1:])
    assert list(ours.durations.values()) == pytest.approx(list(theirs.durations.values()), rel=2e-6)
    times = np.array([1.0, 10.0, 30.0, 100.0])
    for name in Instant._fields:
        values = [np.interp(times, one.time, one.curve(name)) for one in (ours, theirs)]
        assert values[0] == pytest.approx(values[1], rel=5e-3, abs=2e-3), name


def test_forces_too_faint_for_positions_differ_little_from_the_least_that_are_not():
    below, above = (t1_process(gap=1e-2, reduced_force=kappa, rtol=1e-6) for kappa in (4.99e-7, 5.01e-7))
    assert below.duration == pytest.approx(above.duration, rel=1e-4)
    assert below.rejected == below.turned == 0


def test_a_threshold_is_carried_from_its_time_on_even_before_the_vertical_pair_is_the_closer_one():
    found = t1_process(gap=1e-3, reduced_force=1e-3, threshold=[0.9, 0.01, 0.1])
    # Reference values of an independent solution.
    assert found.durations == pytest.approx({0.9: 395.743, 0.01: 316.60, 0.1: 371.36}, rel=1e-5)
    assert list(found.durations) == [0.9, 0.01, 0.1]
    assert found.duration == found.durations[0.1]


def test_sliding_friction_takes_a_third_of_a_process():
    scene = t1_scene(1e-2, PULL, "paper", 0.01, 1e-6)
    slippery = dataclasses.replace(scene, films=dataclasses.replace(scene.films, shear=math.pi / 100.0))
    assert follow(slippery, PULL, (0.9,)).duration == pytest.approx(30.51, abs=0.01)


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
    times = [follow(scene, PULL, (0.9,)), follow(other, PULL, (0.9,), units=(1.7e-3, 3.1e-6, 1.0))]
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


@pytest.mark.long
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
        ({"forces": (1e-3,)}, "expected two numbers, F_h and F_v"),
        ({"forces": (0.0, 1e-3, 0.0)}, "expected two numbers, F_h and F_v"),
        ({"forces": 1e-3}, "expected two numbers, F_h and F_v"),
        ({"forces": ("a", 1e-3)}, "F_h of forces is 'a'; expected a number"),
        ({"forces": (0.0, 1e-3), "force_ratio": 0.1}, "force_ratio is 0.1, but forces give both"),
        ({"reduced_force": 1e-3, "force_ratio": float("nan")}, "force_ratio is nan; expected a finite"),
        ({"reduced_force": 1e-3, "force_ratio": 1 / math.sqrt(3)}, "nothing pulls"),
        ({"reduced_force": "x"}, "reduced_force is 'x'; expected a number"),
        ({"reduced_force": 3.0}, "deflected by more than a radius"),
        ({"reduced_force": 1e-3, "time_step": 1e-3}, "the implicit method chooses its steps"),
        ({"reduced_force": 1e-3, "threshold": ()}, "threshold is empty"),
        ({"reduced_force": 1e-3, "threshold": "0.9"}, "threshold is '0.9'; expected a number"),
        ({"reduced_force": 1e-3, "threshold": (0.5, 1.0)}, "threshold is 1.0; expected a part"),
        ({"reduced_force": 1e-3, "threshold": (0.5, 0.5)}, "expected different numbers"),
        ({"reduced_force": 1e-3, "rotation": "yes"}, "rotation is 'yes'; expected True or False"),
        ({"reduced_force": 1e-3, "prefactors": 3}, "prefactors is 3; expected a name"),
        ({"reduced_force": 1e-3, "gap": "1e-2"}, "gap is '1e-2'; expected a number"),
        ({"reduced_force": 1e-3, "gap": None}, "gap is None; expected a number"),
        ({"reduced_force": 1e-3, "gap": 1.0}, "gap is 1.0; expected at least 1e-10 and below 1, in radii"),
        ({"reduced_force": 0.1, "gap": 1e-10}, "no clock resolves the sliding"),
        ({"reduced_force": 1e-3, "ramp": None}, "ramp is None; expected a number"),
        ({"reduced_force": 1e-8, "method": "rk2"}, "loses the deflections"),
        ({"reduced_force": -1.0}, "reduced_force"),
        ({"reduced_force": True}, "reduced_force is True; expected a number"),
        ({"reduced_force": 10**400}, "reduced_force is an integer of 401 digits"),
        ({"reduced_force": np.ones(2)}, "reduced_force is array"),
        ({"forces": np.array(3.0)}, "expected two numbers"),
        ({"forces": [[0.0, 1.0], [1.0, 2.0]]}, "F_h of forces is .*; expected a number"),
        ({"reduced_force": 1e-3, "threshold": {0.5}}, "threshold is {0.5}; expected a number"),
        ({"reduced_force": 1e-3, "threshold": [[0.5], [0.9]]}, "threshold is .0.5.; expected a number"),
        ({"reduced_force": 1e-3, "gap": 0.0}, "gap"),
        ({"reduced_force": 3e-13}, "spheres are rigid below"),
        ({"forces": (0.0, 1e-12)}, "expected 1e-12 or more"),
        ({"reduced_force": 1e-3, "method": "magic"}, "no method"),
        ({"reduced_force": 1e-3, "prefactors": "magic"}, "prefactors"),
        ({"reduced_force": 1e-3, "rtol": 0.0}, "rtol is 0.0; expected 1e-11 to 0.01"),
        ({"reduced_force": 1e-3, "rtol": float("nan")}, "rtol is nan"),
    ],
)
def test_a_swap_that_cannot_be_is_refused(given, says):
    with pytest.raises(BadInput, match=says):
        t1_process(**({"gap": 1e-2} | given))
