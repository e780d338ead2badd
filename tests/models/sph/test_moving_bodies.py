"""The pressure before an accelerated body is that of a liquid at rest in its frame."""

import numpy as np
import pytest

import ecume
from ecume.models.sph.bodies import delay, pulls_of
from ecume.models.sph.evaluating import fill
from ecume.models.sph.fields import ENTHALPY
from ecume.models.sph.motions import instant
from ecume.models.sph.record import SPH
from ecume.scenes.schema import from_plain, to_plain
from tests.models.sph.scenes import free_blob

GRAVITY = np.array([0.5, -9.0])
ACCELERATION = np.array([3.0, -1.0])


def blob(**tables):
    """A blob without a motion of its own around a body."""
    plain = to_plain(free_blob())
    plain["fluid"][0].pop("velocity_gradient")
    body = {"low": [-0.2, -0.2], "high": [0.2, 0.2], "density": 1000.0}
    return from_plain({**plain, "gravity": GRAVITY.tolist(), "bodies": [body], **tables})


@pytest.mark.compiled
def test_dummies_of_an_accelerated_body_have_the_hydrostatic_pressure_of_its_frame():
    scene = blob(method={"walls_clip": False})
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    workspace = SPH.workspace(parameters, state, 1.0)
    state.felt[:2, 0] = ACCELERATION
    constants = parameters.constants
    # The enthalpy of a liquid at rest in that frame is (g - a).x, whatever its law.
    head = (GRAVITY - ACCELERATION) @ state.position
    state.density[...] = constants[2] * (1.0 + 6.0 * head / constants[0] ** 2) ** (1.0 / 6.0)
    now = instant(parameters, state)
    fill(now, state, workspace)
    liquid = state.position.shape[1]
    found = workspace.fields[ENTHALPY, liquid : len(workspace.lists.counts)]
    near = workspace.lists.counts[liquid:] > 0
    expected = (GRAVITY - ACCELERATION) @ now.boundary.dummies.position
    assert near.sum() > 5
    np.testing.assert_allclose(found[near], expected[near], atol=1e-9)


def test_a_dummy_of_a_turning_body_feels_what_turns_it():
    parameters = SPH.parameters(blob())
    state = SPH.start(blob(), parameters)
    state.motion[5, 0], state.felt[5, 0] = 3.0, 7.0
    dummies = instant(parameters, state).boundary.dummies
    pulls = pulls_of(parameters.bodies, dummies, (state.pose, state.motion, state.felt), parameters.gravity)
    x, y = dummies.position - state.pose[:2, :1]
    np.testing.assert_allclose(GRAVITY[:, None] - pulls, [-7.0 * y - 9.0 * x, 7.0 * x - 9.0 * y], atol=1e-12)


@pytest.mark.compiled
@pytest.mark.parametrize("density", [250.0, 1000.0, 4000.0])
def test_liquid_that_falls_with_a_body_does_not_press_it(density):
    body = {"low": [-0.25, -0.25], "high": [0.25, 0.25], "density": density}
    scene = blob(gravity=[0.0, -10.0], bodies=[body], duration=0.3, method={"jitter": 0.0, "start": "rest"})
    (*_, last) = ecume.simulate(scene)
    # A quarter of rho g times a side of the body would be 1250 Pa.
    assert np.abs(last.arrays["pressure"]).max() < 200.0
    assert last.numbers["body0_velocity_y"] == pytest.approx(-3.0, rel=0.01)


@pytest.mark.compiled
@pytest.mark.parametrize("density", [0.01, 0.1])
def test_a_body_much_lighter_than_the_liquid_rises_calmly(density):
    scene = from_plain(
        {
            "model": "sph",
            "duration": 0.2,
            "frame_every": 0.02,
            "spacing": 1.0 / 12.0,
            "gravity": [0.0, -1.0],
            "liquid": {"density": 1.0, "sound_speed": 20.0, "fastest": 2.0},
            "tank": {"low": [0.0, 0.0], "high": [2.0, 2.5], "top": {"kind": "open"}},
            "fluid": [{"low": [0.0, 0.0], "high": [2.0, 2.0]}],
            "bodies": [{"center": [1.0, 1.0], "radius": 0.17, "density": density}],
        }
    )
    speed = np.array([frame.numbers["body0_velocity_y"] for frame in ecume.simulate(scene)])
    assert np.all(np.diff(speed) > 0.0)
    assert speed[-1] < 0.2


def test_lighter_bodies_tell_their_dummies_later():
    one, two = (
        SPH.parameters(blob(bodies=[{"center": [0.0, 0.0], "radius": 0.2, "density": rho}])) for rho in (1000.0, 10.0)
    )
    assert delay(two.bodies, 1000.0) > delay(one.bodies, 1000.0) > 1.0
