"""Random scenes whose time step is the default one run to their end: see `tests.models.floating.random_scenes`."""

import math

import numpy as np
import pytest

from ecume.models.floating.parameters import make_state
from ecume.models.floating.record import FLOATING
from ecume.models.floating.time_integration.integration import USED, WIDEST, skin_for
from ecume.models.floating.time_integration.step_size import NOISE_DEVIATIONS
from ecume.models.invariants import ENERGY, NumberHistory, with_own
from ecume.models.model import DIVERGED, DONE
from ecume.simulation import simulate
from tests.models.floating.bowls import WATER, scene_of
from tests.models.floating.random_scenes import drawn, outcome

BEAD = 'radius = "100 um"\ndensity = 2500.0\ncontact_angle = "60 deg"\n'
SMALL = 'radius = "5 um"\ndensity = 1050.0\ncontact_angle = "90 deg"\n'
OVERDAMPED = '[integration]\nintegrator = "overdamped"\n'
NOISE = f"[hydrodynamics]\nbrownian = true\n{OVERDAMPED}"
pytestmark = pytest.mark.filterwarnings("ignore:overflow encountered")  # philox, by design


PLAIN = pytest.mark.uncompiled
"""Combinations that nothing else compiles, for ten seconds each."""


@pytest.mark.parametrize(
    "seed", [1, 34, 61, 63, 78, 140, 186, *(pytest.param(seed, marks=PLAIN) for seed in (91, 95, 222))]
)
def test_a_random_scene_runs_to_its_end(seed):
    """Two thousand seeds did so for twenty steps, and 136 of two hundred for their whole durations. These are some that
    needed lists with a wider skin.
    """
    assert outcome(seed, 60, 0) == "done"


@PLAIN
@pytest.mark.parametrize("seed", [7, 8, 26, 27, 36, 78, 110, 124, 269, 519, 935, 1251])
def test_a_random_scene_with_further_options_runs_to_its_end(seed):
    """Oil, memory, polygons, barriers, wells, discs, waves, fields, films, methods, flows at nodes and sizes; far
    quadrupoles, whose energy rounding changes, a rotation that changes no energy, and waves that press Brownian floats
    past one another.
    """
    assert outcome(seed, 12) == "done"


@PLAIN
@pytest.mark.parametrize("seed", [994, 1021, 1155, 1676, 1900])
def test_the_work_on_floats_is_that_of_the_forces_in_the_energy(seed):
    """Of currents beside hydrodynamic interaction, from tables beside noise, and of waves much longer than floats; and
    small discs in the meniscus of a wall, which ended at their first step.
    """
    assert outcome(seed, 20) == "done"


@pytest.mark.long
@PLAIN
@pytest.mark.parametrize(("share", "reported"), [(1e-7, False), (1e-4, True)])
def test_energy_of_far_quadrupoles_may_rise_by_rounding_only(share, reported):
    """The first frames of seed 269: its energy rises and falls by 4e-8 of itself."""
    scene, _ = drawn(269, 20, 2)
    parameters = FLOATING.parameters(scene)
    state = FLOATING.start(scene, parameters)
    first = FLOATING.observe(parameters, state, FLOATING.workspace(parameters, state, 1.0)).numbers
    risen = {"total_energy": first["total_energy"] + share * abs(first["total_energy"])}
    before, now = with_own(first), with_own(first | risen)
    rule = next(rule for rule in FLOATING.invariants(scene, parameters) if rule.name == ENERGY)
    assert (rule.value(NumberHistory(before, now, before, now)) > rule.limit) == reported


def rows(text, *places):
    return "".join(f"[[rows]]\n{text}x = {x}\ny = {y}\n" for x, y in places)


DRIFTING = {
    "inertia at a wall": (f'[[particles]]\n{BEAD}count = 6\n[dish]\nradius = "5 mm"\n', 0.05),
    "rows in shear": (rows(BEAD, (0.0, 0.02), (0.001, 0.02)) + f"[flow]\nshear_rate = 1.0\n{OVERDAMPED}", 0.5),
    "noise in a current": (f'[[particles]]\n{SMALL}count = 4\n[flow]\nvelocity = ["3 um/s", "0 um/s"]\n{NOISE}', 20.0),
    "noise and propulsion": (f'[[particles]]\n{SMALL}count = 4\n[activity]\npropulsion = "1 pN"\n{NOISE}', 20.0),
    "a flow that carries away": (f"[[particles]]\n{BEAD}count = 2\n[flow]\nextension_rate = 2.0\n{OVERDAMPED}", 1.0),
}


PROPELLED = "noise and propulsion"


@pytest.mark.long
@pytest.mark.parametrize("name", [pytest.param(name, marks=[PLAIN] * (name == PROPELLED)) for name in DRIFTING])
def test_floats_that_something_carries_reach_the_end(name):
    body, duration = DRIFTING[name]
    frames = list(simulate(scene_of(WATER + body, duration=duration, frame_every=duration / 2)))
    assert len(frames) == 3


def test_lists_of_fast_floats_have_a_wider_skin_and_a_resumed_run_has_the_same():
    body, duration = DRIFTING["inertia at a wall"]
    scene = scene_of(WATER + body, duration=duration, frame_every=duration / 2)
    parameters = FLOATING.parameters(scene)
    state = FLOATING.start(scene, parameters)
    scratch, widest = FLOATING.workspace(parameters, state, 1.0), 0.0
    for _ in range(10):
        FLOATING.advance(parameters, state, scratch, 1)
        widest = max(widest, float(state.skin[0]) / parameters.skin)
    assert 1.0 < widest <= WIDEST
    again = FLOATING.workspace(parameters, state, 1.0)
    other = state._replace(**{name: array.copy() for name, array in state._asdict().items()})
    FLOATING.advance(parameters, other, again, 5)
    FLOATING.advance(parameters, state, scratch, 5)
    assert all(np.array_equal(one, two) for one, two in zip(state, other, strict=True))


def test_a_tail_of_the_random_force_is_no_divergence():
    # The force exceeds nine standard deviations once in 1e19 steps; five, once in two million.
    body = f"[[particles]]\n{BEAD}count = 3\n[activity]\nforce = 1e-9\npersistence = 0.2\n{OVERDAMPED}"
    scene = scene_of(WATER + body, duration=1.0, frame_every=0.5)
    parameters = FLOATING.parameters(scene)
    for tail in (5.0, 9.0, 30.0, 100.0):
        state = FLOATING.start(scene, parameters)
        state.active[0, 0] = tail
        assert FLOATING.advance(parameters, state, FLOATING.workspace(parameters, state, 1.0), 20) == DONE


def test_the_largest_number_of_the_generator_moves_no_float_out_of_its_lists():
    largest = math.sqrt(-2.0 * math.log(0.5 / 2.0**53))
    assert 8.6 < largest < 8.7
    assert USED * largest / NOISE_DEVIATIONS < 0.5


def test_the_skin_holds_two_steps_of_fast_floats():
    scene = scene_of(f"{WATER}[[particles]]\n{BEAD}")
    parameters = FLOATING.parameters(scene)
    for travel in (0.1, 0.25, 0.26, 1.0, 7.0):
        skin = skin_for(parameters.skin, travel * parameters.skin)
        assert skin == parameters.skin if travel <= 0.25 else 2.0 * travel * parameters.skin <= 0.25 * skin


def test_the_step_that_a_diverged_run_suggests_is_accepted():
    floats = f"[[particles]]\n{BEAD}positions = [[0.0, 0.0], [0.0004, 0.0]]\n"
    body = f'{WATER}{floats}[hydrodynamics]\ndrag = "none"\n[integration]\n'
    scene = scene_of(body, duration=0.21, frame_every=0.07)
    parameters = FLOATING.parameters(scene)
    state = FLOATING.start(scene, parameters)
    state.velocity[0] = WIDEST * parameters.skin / parameters.time_step
    assert FLOATING.advance(parameters, state, FLOATING.workspace(parameters, state, 1.0), 1) == DIVERGED
    suggested = FLOATING.diagnosis(parameters, state).split("time_step = ")[1].split(",")[0]
    better = scene_of(f"{body}time_step = {suggested}\n", duration=0.21, frame_every=0.07)
    assert FLOATING.parameters(better).time_step < parameters.time_step / WIDEST


def test_the_speed_that_a_diverged_run_names_is_that_of_the_force():
    scene = scene_of(
        f"{WATER}[[particles]]\n{BEAD}positions = [[0.0, 0.0]]\n[flow]\nvelocity = [0.1, 0.0]\n{OVERDAMPED}"
    )
    parameters = FLOATING.parameters(scene)
    state = make_state(np.zeros((1, 2)), np.zeros((1, 2)))
    assert "float 0 moves at 100 mm/s" in FLOATING.diagnosis(parameters, state)
