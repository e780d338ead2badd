"""How the scheme moves liquid and solids together: steps that forces divide, lists that follow solids, momentum."""

import numpy as np
import pytest

from ecume.models.sph.integration.time_stepping import displacement_of_solids, divisions_needed, move, renew
from ecume.models.sph.rates.right_hand_side import evaluate_accelerations
from ecume.models.sph.record import SPH
from ecume.scenes.schema import from_plain
from tests.models.sph.scenes import free_blob
from tests.models.sph.test_rigid_bodies import blob
from tests.models.sph.test_runs import copy_of


def begun(scene):
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    return parameters, state, SPH.workspace(parameters, state, 1.0)


@pytest.mark.parametrize("strength", [0.3, 3.0, 30.0])
def test_no_force_moves_a_particle_farther_than_a_thirtieth_of_a_smoothing_length_in_a_step(strength):
    """Steps of a quarter of sqrt(h/a) are asked for: a particle at rest then goes a t^2/2 = h/32."""
    parameters, state, _ = begun(free_blob())
    h = float(parameters.numbers.smoothing_length)
    state.velocity[...] = 0.0
    state.acceleration[1, 7] = 2.0 * strength * h / parameters.time_step**2
    parts = divisions_needed(parameters, state)
    way = strength * h / parts**2
    assert parts > 1
    # A step is not divided for a tenth of a part.
    assert way < h / 32.0 * 1.11
    assert way * (parts / (parts - 1)) ** 2 > h / 32.0


def test_a_part_of_a_step_moves_the_clock():
    parameters, state, workspace = begun(free_blob())
    move(parameters, state, workspace, 0.4 * parameters.time_step)
    assert state.clock[0] == pytest.approx(0.4 * parameters.time_step, rel=1e-12)


def test_lists_follow_bodies_and_sides():
    """A body that moves by a tenth, while a side moves by two tenths."""
    lid = {"top": {"motion": {"times": [0.0, 1.0], "positions": [0.0, -2.0]}}}
    parameters, state, _ = begun(calm(tank=lid, bodies=[{**BOX, "velocity": [0.0, 0.0]}]))
    state.clock[0] = 0.1
    state.pose[1, 0] -= 0.1
    assert displacement_of_solids(parameters, state) == pytest.approx(0.1 + 0.2, rel=1e-9)


def calm(**more):
    """Water of density 1, a meter deep, at rest under unit gravity in a tank that is half empty."""
    return from_plain(
        {
            "model": "sph",
            "duration": 1.0,
            "frame_every": 0.1,
            "spacing": 0.1,
            "gravity": [0.0, -1.0],
            "liquid": {"density": 1.0, "sound_speed": 20.0, "maximum_speed": 2.0},
            "tank": {"low": [0.0, 0.0], "high": [2.0, 2.0], **more.pop("tank", {})},
            "fluid": [{"low": [0.0, 0.0], "high": [2.0, 1.0]}],
            **more,
        }
    )


BOX = {"low": [0.7, 1.5], "high": [1.3, 1.9], "density": 0.8, "velocity": [0.0, -1.5]}
FALLING_BOX = {"tank": {"top": {"kind": "open"}}, "bodies": [BOX]}
FALLING_LID = {"tank": {"top": {"motion": {"times": [0.0, 1.0], "positions": [0.0, -2.0]}}}}


@pytest.mark.compiled
@pytest.mark.parametrize(("solid", "time"), [(FALLING_BOX, 0.3), (FALLING_LID, 0.48)], ids=["box", "lid"])
def test_a_solid_that_comes_down_on_calm_water_feels_it_as_with_fresh_lists(solid, time):
    """The water moves hardly at all: only the way of the solid says that lists are too old."""
    parameters, state, workspace = begun(calm(**solid))
    alone = begun(calm(tank=FALLING_BOX["tank"]))
    steps = round(time / parameters.time_step)
    SPH.advance(parameters, state, workspace, steps)
    SPH.advance(*alone, round(time / alone[0].time_step))

    fresh, lists = copy_of(state), begun(calm(**solid))[2]
    renew(parameters, fresh, lists)
    for one, scratch in ((state, workspace), (fresh, lists)):
        evaluate_accelerations(parameters, one, scratch, parameters.time_step)
    places = [np.argsort(one.identity) for one in (state, fresh)]
    found, expected = (one.acceleration[:, place] for one, place in zip((state, fresh), places, strict=True))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())
    np.testing.assert_allclose(
        state.body_acceleration,
        fresh.body_acceleration,
        rtol=0.0,
        atol=1e-9 * np.abs(fresh.body_acceleration).max(initial=0.0),
    )
    # And there is something to feel: the surface below is pushed down harder than by its weight.
    at_rest = alone[1].acceleration[1].min()
    assert expected[1].min() < 3.0 * at_rest - 1.0


@pytest.mark.compiled
@pytest.mark.parametrize("integrator", ["symplectic", "verlet"])
def test_a_body_and_the_liquid_around_it_keep_their_momentum(integrator):
    body = {"low": [-0.2, -0.2], "high": [0.2, 0.2], "density": 400.0, "velocity": [1.0, 0.3]}
    method = {"jitter": 0.2}
    liquid = {"density": 1000.0, "sound_speed": 10.0, "maximum_speed": 1.0, "viscosity": 5.0}
    parameters, state, workspace = begun(
        blob(gravity=[0.0, 0.0], bodies=[body], liquid=liquid, method=method, integration={"integrator": integrator})
    )

    def momentum():
        return state.velocity @ state.mass + parameters.bodies.mass[0] * state.motion[:2, 0]

    before = momentum()
    for _ in range(10):
        SPH.advance(parameters, state, workspace, 1)
        np.testing.assert_allclose(momentum(), before, rtol=0.0, atol=1e-10 * np.abs(before).max())
    # The body has been slowed down: there was a momentum to be kept.
    assert state.motion[0, 0] < 0.9
