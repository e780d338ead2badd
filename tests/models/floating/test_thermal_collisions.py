"""Collisions of Brownian floats on the paths of a step: elastic, in the order of time, and as in equilibrium."""

import math

import numpy as np
import pytest
from scipy.stats import norm

from ecume.engine.contact import contacts as touching
from ecume.laws.brownian_motion import reflected_gap
from ecume.models import MODELS
from ecume.models.floating.contacts.collisions import contact_bodies, free_shares, require_gaps
from ecume.models.floating.contacts.thermal_collisions import Flow, collide_on_paths
from ecume.scenes.load import load_scene
from ecume.simulation import simulate
from tests.models.floating.test_noise_at_contact import DISCS, RADIUS

ALONE = Flow(np.zeros(0), 0.0)
pytestmark = pytest.mark.filterwarnings("ignore:overflow encountered")  # philox, by design


@pytest.mark.parametrize("drift", [-3.0, -0.3, 0.0, 0.1, 0.4])
@pytest.mark.parametrize("start", [0.0, 0.2, 1.0])
def test_a_step_in_front_of_a_wall_has_the_exact_distribution(start, drift):
    dice, count = np.random.default_rng(1), 40_000
    free = start + drift + dice.normal(size=count)
    ends = [
        one if one > 0.0 else reflected_gap(-one, start + drift - one, drift, 1.0, draw)
        for one, draw in zip(free, dice.random(count), strict=True)
    ]
    place = np.array([0.05, 0.2, 0.6, 1.5])
    exact = norm.cdf(place - start - drift) - np.exp(2.0 * drift * place) * norm.cdf(-place - start - drift)
    found = (np.array(ends)[:, None] < place).mean(axis=0)
    assert found == pytest.approx(exact, abs=4.0 * np.sqrt(0.25 / count))


def scene_of(places, radii, around, more="", duration=1.0):
    """Hard discs without attraction, some of another size, and thermal noise."""
    text = DISCS.format(around=around, duration=duration, every=duration, places="[]")
    particles = "".join(
        f'[[particles]]\nname = "s{k}"\nradius = {radius * RADIUS}\ndensity = 1000.0\ncontact_angle = "90 deg"\n'
        f"positions = {[[float(x) * RADIUS for x in place]]}\n"
        for k, (place, radius) in enumerate(zip(places, radii, strict=True))
    )
    begin, end = text.index("[[particles]]"), text.index(around) if around else text.index("[interaction]")
    return load_scene(text[:begin] + particles + text[end:] + more)


def contacts_at(scene):
    """The parameters, the state, all contacts of the first step, and the shares of both floats in each."""
    model = MODELS["floating"]
    parameters = model.parameters(scene)
    state = model.start(scene, parameters)
    workspace = model.workspace(parameters, state, 1.0)
    touching.gather(workspace.contacts, workspace.candidates, state.position, contact_bodies(parameters), RADIUS)
    require_gaps(False, parameters, workspace.contacts)
    return parameters, state, workspace.contacts, free_shares(parameters, workspace.contacts)


@pytest.mark.parametrize("seed", range(8))
def test_collisions_exert_opposite_forces_and_leave_no_overlap(seed):
    dice = np.random.default_rng(seed)
    spots = np.array([[x, y] for x in range(4) for y in range(3)]) * 2.04 + 0.03 * dice.random((12, 2))
    radii = dice.choice([1.0, 0.8], 12)
    scene = scene_of(spots - spots.mean(axis=0), radii, "")
    parameters, state, contacts, share = contacts_at(scene)
    time, mass = parameters.time_step, 1.0 / parameters.kick.gain
    speed = 0.3 * RADIUS / time
    velocity = speed * dice.normal(size=(12, 2)) / np.sqrt(mass / mass.max())[:, None]
    still = np.zeros_like(velocity)
    bounces = collide_on_paths(parameters, state, contacts, (velocity, still), share, ALONE)
    assert len(bounces.impulse) > 0
    assert not bounces.lasting.any()
    assert bounces.impulse.sum(axis=0) == pytest.approx(np.zeros(2), abs=1e-12 * np.abs(bounces.impulse).max())
    after = state.position + time * (velocity + parameters.kick.gain[:, None] * bounces.impulse)
    apart = after[:, None] - after[None]
    gap = np.hypot(apart[..., 0], apart[..., 1]) - (parameters.floats.radius[:, None] + parameters.floats.radius)
    assert gap[np.triu_indices(12, 1)].min() > -1e-9 * RADIUS


def test_a_collision_without_forces_is_elastic_for_masses_that_are_inverse_to_the_mobilities():
    scene = scene_of([[-1.01, 0.0], [0.81, 0.0]], [1.0, 0.8], "")
    parameters, state, contacts, share = contacts_at(scene)
    time, gain = parameters.time_step, parameters.kick.gain
    velocity = np.array([[0.05, 0.0], [-0.03, 0.0]]) * RADIUS / time
    bounces = collide_on_paths(parameters, state, contacts, (velocity, np.zeros((2, 2))), share, ALONE)
    left = 1.0 - 0.02 / 0.08
    after = velocity + gain[:, None] * bounces.impulse / left
    assert (velocity[:, 0] ** 2 / gain).sum() == pytest.approx((after[:, 0] ** 2 / gain).sum())
    assert after[1, 0] - after[0, 0] == pytest.approx(velocity[0, 0] - velocity[1, 0])


def test_lasting_contacts_are_left_to_the_solver():
    scene = scene_of([[-1.001, 0.0], [1.001, 0.0]], [1.0, 1.0], "")
    parameters, state, contacts, share = contacts_at(scene)
    spread = math.sqrt(2.0 * parameters.drift.thermal * share[0].sum() * parameters.time_step)
    fast = spread / parameters.time_step
    for driven, lasting in ((0.4 * fast, 0), (0.6 * fast, 1)):
        velocity = np.array([[driven, 0.0], [-driven, 0.0]])
        bounces = collide_on_paths(parameters, state, contacts, (velocity, velocity), share, ALONE)
        assert bounces.lasting.tolist() == [lasting, lasting]
        assert (np.abs(bounces.impulse).max() > 0.0) == (not lasting)


@pytest.mark.parametrize(("around", "more"), [
    ("[dish]\nradius = 5.5e-6\ncontact_angle = 1.5707963267948966\nlaw = \"none\"", ""),
    ("[dish]\nsize = [9.4e-6, 9e-6]\ncontact_angle = 1.5707963267948966\nlaw = \"none\"", ""),
    ("[dish]\nradius = 5.5e-6\ncontact_angle = 1.5707963267948966\nlaw = \"none\"", 'interaction = "rotne-prager"\n'),
])  # fmt: skip
def test_dense_discs_end_their_steps_apart_and_inside(around, more):
    spots = [[2.1 * x, 2.1 * y] for x in (-1, 0, 1) for y in (-1, 0, 1)]
    scene = scene_of(spots, [1.0] * 9, around, more, duration=0.15)
    for frame in simulate(scene):
        assert frame.numbers["deepest_overlap"] < 1e-4 * RADIUS
        assert frame.numbers["unconverged_steps"] == 0.0
