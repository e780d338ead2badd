"""The pressure before an accelerated body is that of a liquid at rest in its frame."""

import dataclasses

import numpy as np
import pytest

import ecume
from ecume.errors import SceneError
from ecume.laws.kernels import kernel
from ecume.models.sph.boundaries.rigid_bodies import apparent_gravity, delay, expel_liquid, with_moved_solids
from ecume.models.sph.rates.right_hand_side import fill
from ecume.models.sph.record import SPH
from ecume.scenes.schema import from_plain, to_plain
from tests.models.sph.scenes import free_blob

pytestmark = pytest.mark.sampled(2)

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
    scene = blob(method={"nonnegative_wall_pressure": False})
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    workspace = SPH.workspace(parameters, state, 1.0)
    state.delayed_body_acceleration[:2, 0] = ACCELERATION
    tait = parameters.equation_of_state
    # The enthalpy of a liquid at rest in that frame is (g - a).x, whatever its law.
    head = (GRAVITY - ACCELERATION) @ state.position
    state.density[...] = tait.density * (1.0 + 6.0 * head / tait.sound_speed**2) ** (1.0 / 6.0)
    now = with_moved_solids(parameters, state)
    fill(now, state, workspace)
    liquid = state.position.shape[1]
    found = workspace.fields.enthalpy[liquid : len(workspace.lists.counts)]
    near = workspace.lists.counts[liquid:] > 0
    expected = (GRAVITY - ACCELERATION) @ now.boundary.dummies.position
    assert near.sum() > 5
    np.testing.assert_allclose(found[near], expected[near], atol=1e-9)


def test_a_dummy_of_a_turning_body_feels_what_turns_it():
    parameters = SPH.parameters(blob())
    state = SPH.start(blob(), parameters)
    state.motion[5, 0], state.delayed_body_acceleration[5, 0] = 3.0, 7.0
    dummies = with_moved_solids(parameters, state).boundary.dummies
    pulls = apparent_gravity(
        parameters.bodies, dummies, (state.pose, state.motion, state.delayed_body_acceleration), parameters.gravity
    )
    x, y = dummies.position - state.pose[:2, :1]
    np.testing.assert_allclose(GRAVITY[:, None] - pulls, [-7.0 * y - 9.0 * x, 7.0 * x - 9.0 * y], atol=1e-12)


@pytest.mark.compiled
@pytest.mark.parametrize("density", [250.0, 1000.0, 4000.0])
def test_liquid_that_falls_with_a_body_does_not_press_it(density):
    body = {"low": [-0.25, -0.25], "high": [0.25, 0.25], "density": density}
    scene = blob(gravity=[0.0, -10.0], bodies=[body], duration=0.3, method={"jitter": 0.0, "initial_pressure": "zero"})
    (*_, last) = ecume.simulate(scene)
    # A quarter of rho g times a side of the body would be 1250 Pa.
    assert np.abs(last.arrays["pressure"]).max() < 200.0
    assert last.numbers["body0_velocity_y"] == pytest.approx(-3.0, rel=0.01)


def tub(density, viscosity=0.0, time_step=None, **method):
    """A disc, four spacings wide, under a liquid of density 1."""
    return from_plain(
        {
            "model": "sph",
            "duration": 0.2,
            "frame_every": 0.02,
            "spacing": 1.0 / 12.0,
            "gravity": [0.0, -1.0],
            "liquid": {"density": 1.0, "sound_speed": 20.0, "maximum_speed": 2.0, "viscosity": viscosity},
            "tank": {"low": [0.0, 0.0], "high": [2.0, 2.5], "top": {"kind": "open"}},
            "fluid": [{"low": [0.0, 0.0], "high": [2.0, 2.0]}],
            "bodies": [{"center": [1.0, 1.0], "radius": 0.17, "density": density}],
            "integration": {"time_step": time_step},
            "method": method,
        }
    )


@pytest.mark.sampled(3)
@pytest.mark.compiled
@pytest.mark.parametrize("density", [0.001, 0.003, 0.01, 0.1])
def test_a_body_much_lighter_than_the_liquid_rises_calmly(density):
    speed = np.array([frame.numbers["body0_velocity_y"] for frame in ecume.simulate(tub(density))])
    assert np.all(np.diff(speed) > 0.0)
    # All of them are as good as weightless: the liquid that goes with a disc is what is left to be moved.
    assert speed[-1] == pytest.approx(0.178 / (1.0 + density), rel=0.1)


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("friction", ["morris", "monaghan"])
def test_a_light_body_in_a_thick_liquid_creeps_upwards(friction):
    def speed(density):
        scene = dataclasses.replace(tub(density, viscosity=3.0, viscosity_model=friction), duration=0.02)
        (*_, last) = ecume.simulate(scene)
        return last.numbers["body0_velocity_y"]

    # In a liquid so thick buoyancy alone counts, 1 - density: nobody is thrown about.
    assert speed(0.15) == pytest.approx(0.85 / 0.7 * speed(0.3), rel=0.03)


def swing(scene):
    """The fastest rate (1/s) at which liquid at rest answers a body that is shifted, from the sums themselves."""
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    dummies, bodies = parameters.boundary.dummies, parameters.bodies
    place = (dummies.position[:, bodies.first :] + bodies.pose[:2]).T
    apart = state.position.T[:, None] - place[None]
    shape = kernel(scene.method.kernel, 2)
    gradient = shape.gradient(apart, parameters.support / shape.support)
    slope = np.einsum("a,iab->ib", dummies.volume[bodies.first :], gradient)
    stiffness = 2.0 * parameters.equation_of_state.sound_speed**2 * np.einsum("i,ia,ib->ab", state.mass, slope, slope)
    return np.sqrt(np.linalg.eigvalsh(stiffness)[-1] / bodies.mass[0]), parameters


@pytest.mark.parametrize("density", [1.0, 0.1, 0.01, 0.001])
def test_steps_follow_the_swing_of_a_light_body_against_the_liquid(density):
    rate, parameters = swing(tub(density))
    assert rate * parameters.time_step < 1.5  # explicit schemes diverge at 2
    assert density > 0.01 or rate * parameters.time_step > 0.5  # and no step is wasted


def test_a_step_too_long_for_a_light_body_is_refused():
    with pytest.raises(SceneError, match=r"integration\.time_step.*lightest body requires"):
        SPH.parameters(tub(0.001, time_step=0.0015))


@pytest.mark.parametrize("mass", [1e-3, 1.0, 1e3])
def test_liquid_that_gets_into_a_body_and_the_body_part_without_gaining_energy(mass):
    scene = blob(bodies=[{"low": [-0.2, -0.2], "high": [0.2, 0.2], "mass": 1.0}])
    parameters = SPH.parameters(scene)
    bodies, pose, motion = parameters.bodies, parameters.bodies.pose.copy(), parameters.bodies.motion.copy()
    position, velocity, weight = np.array([[0.1], [0.19]]), np.array([[0.3], [-2.0]]), np.array([mass])
    before = mass * velocity[:, 0]

    assert expel_liquid(bodies, pose, motion, (position, velocity, weight)).hits == 1
    np.testing.assert_allclose(mass * velocity[:, 0] + motion[:2, 0], before, atol=1e-12 * mass)
    spin = motion[5, 0]
    surface = motion[1, 0] + spin * position[0, 0]
    assert velocity[1, 0] == pytest.approx(surface)
    energy = mass * velocity[:, 0] @ velocity[:, 0] + motion[:2, 0] @ motion[:2, 0] + bodies.inertia[2, 0] * spin**2
    assert energy < before @ before / mass


def test_lighter_bodies_set_their_dummies_later():
    one, two = (
        SPH.parameters(blob(bodies=[{"center": [0.0, 0.0], "radius": 0.2, "density": rho}])) for rho in (1000.0, 10.0)
    )
    assert delay(two.bodies, 1000.0) > delay(one.bodies, 1000.0) > 1.0
