"""Collisions of Brownian floats on the paths of a step: elastic, in temporal order, and as in equilibrium."""

import math

import numpy as np
import pytest
from scipy.stats import norm

from ecume.engine.contact import contacts as touching
from ecume.laws.brownian_motion import reflected_gap
from ecume.laws.pair_mobility import rotne_prager, surface_mobility
from ecume.models import MODELS
from ecume.models.floating.contacts.collisions import contact_bodies, free_shares, require_gaps
from ecume.models.floating.contacts.thermal_collisions import (
    MOST_INTERVALS,
    SOFTLY,
    Flow,
    collide_on_paths,
    intervals_of,
    noise_of_intervals,
)
from ecume.models.floating.forces.pair_forces import law_of, row_of, two_floats
from ecume.scenes.load import load_scene
from ecume.simulation import simulate
from tests.models.floating.brownian_discs import RADIUS, discs_at

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
    scene = discs_at(spots - spots.mean(axis=0), radii=radii.tolist())
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
    scene = discs_at([[-1.01, 0.0], [0.81, 0.0]], radii=[1.0, 0.8])
    parameters, state, contacts, share = contacts_at(scene)
    time, gain = parameters.time_step, parameters.kick.gain
    velocity = np.array([[0.05, 0.0], [-0.03, 0.0]]) * RADIUS / time
    bounces = collide_on_paths(parameters, state, contacts, (velocity, np.zeros((2, 2))), share, ALONE)
    left = 1.0 - 0.02 / 0.08
    after = velocity + gain[:, None] * bounces.impulse / left
    assert (velocity[:, 0] ** 2 / gain).sum() == pytest.approx((after[:, 0] ** 2 / gain).sum())
    assert after[1, 0] - after[0, 0] == pytest.approx(velocity[0, 0] - velocity[1, 0])


def test_lasting_contacts_are_left_to_the_solver():
    scene = discs_at([[-1.001, 0.0], [1.001, 0.0]])
    parameters, state, contacts, share = contacts_at(scene)
    spread = math.sqrt(2.0 * parameters.drift.thermal * share[0].sum() * parameters.time_step)
    fast = spread / parameters.time_step
    # The approach is twice as fast; eight intervals hold contacts up to the root of eight.
    for driven, lasting in ((0.4 * fast, 0), (1.3 * fast, 0), (1.5 * fast, 1)):
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
    scene = discs_at(spots, around, more=more, duration=0.15)
    for frame in simulate(scene):
        assert frame.numbers["deepest_overlap"] < 1e-4 * RADIUS
        assert frame.numbers["unconverged_steps"] == 0.0


@pytest.mark.parametrize("seed", range(4))
def test_collisions_that_move_all_floats_by_the_flow_leave_no_overlap(seed):
    """Also beside walls, and far from a collision: if it moves near floats only, others end 5 % of R inside a wall."""
    dice = np.random.default_rng(seed)
    spots = np.array([[x, y] for x in range(4) for y in range(3)]) * 2.04 + 0.03 * dice.random((12, 2))
    around = '[dish]\nsize = [8.3e-6, 6.3e-6]\ncontact_angle = 1.5707963267948966\nlaw = "none"'
    spots -= 0.5 * (spots.max(axis=0) + spots.min(axis=0))
    scene = discs_at(spots, around, more='interaction = "rotne-prager"\n')
    parameters, state, contacts, _ = contacts_at(scene)
    mobility = surface_mobility(state.position, np.full(12, RADIUS), 1e-3)
    directions = np.zeros((contacts.total[0], 12, 2))
    for row, direction in enumerate(directions):
        direction[contacts.first[row]] = -contacts.normal[row]
        if contacts.second[row] < 12:
            direction[contacts.second[row]] = contacts.normal[row]
    moved = (directions.reshape(-1, 24) @ mobility).reshape(-1, 12, 2)
    share = np.zeros((contacts.total[0], 2))
    for row in range(len(share)):
        for place, body in enumerate((contacts.first[row], contacts.second[row])):
            share[row, place] = abs(moved[row, body] @ contacts.normal[row]) if body < 12 else 0.0
    velocity = 0.05 * RADIUS / parameters.time_step * dice.normal(size=(12, 2))
    flow = Flow(np.full(12, RADIUS), 1.0 / (3.0 * math.pi * 1e-3))
    found = collide_on_paths(parameters, state, contacts, (velocity, 0.0 * velocity), share, flow)
    impulse = found.impulse
    assert not found.lasting.any(), found.lasting
    after = state.position + parameters.time_step * (velocity + (mobility @ impulse.ravel()).reshape(12, 2))
    apart = after[:, None] - after[None]
    gap = np.hypot(apart[..., 0], apart[..., 1])[np.triu_indices(12, 1)] - 2.0 * RADIUS
    inside = 0.5 * np.array([8.3e-6, 6.3e-6]) - np.abs(after) - RADIUS
    assert min(gap.min(), inside.min()) > -2e-3 * RADIUS


def test_a_float_that_a_wall_repels_carries_its_neighbor_along():
    """The first float hits the wall and comes back; the flow of this moves the second one out of its way."""
    around = '[dish]\nradius = 5e-6\ncontact_angle = 1.5707963267948966\nlaw = "none"'
    scene = discs_at([[3.99, 0.0], [1.975, 0.0]], around, more='interaction = "rotne-prager"\n')
    parameters, state, contacts, _ = contacts_at(scene)
    unit = float(parameters.kick.gain[0]) * RADIUS
    flow = Flow(np.full(2, RADIUS), unit)
    along = unit * rotne_prager(2.015 * RADIUS, RADIUS, RADIUS)[1]
    share = np.tile([unit / RADIUS, 0.0], (contacts.total[0], 1))
    share[0] = unit / RADIUS - along
    assert contacts.second[0] == 1
    velocity = np.array([[0.04, 0.0], [0.0, 0.0]]) * RADIUS / parameters.time_step
    paths = velocity, np.zeros_like(velocity)
    assert collide_on_paths(parameters, state, contacts, paths, share, ALONE).impulse[1, 0] < 0.0
    impulse = collide_on_paths(parameters, state, contacts, paths, share, flow).impulse
    assert impulse[1].tolist() == [0.0, 0.0]
    assert parameters.time_step * unit / RADIUS * impulse[0, 0] == pytest.approx(-2.0 * 0.03 * RADIUS)


def test_a_step_has_more_intervals_the_stronger_forces_press():
    parameters, _, contacts, share = contacts_at(discs_at([[-1.001, 0.0], [1.001, 0.0]]))
    fast = math.sqrt(2.0 * parameters.drift.thermal * share[0].sum() / parameters.time_step)
    for ratio, number in ((0.0, 1), (0.9 * SOFTLY, 1), (1.9 * SOFTLY, 4), (2.7, MOST_INTERVALS), (2.9, 1)):
        driven = 0.5 * ratio * fast * np.array([[1.0, 0.0], [-1.0, 0.0]])
        assert intervals_of(parameters, contacts, driven, share) == number


def test_the_noise_of_intervals_leaves_that_of_the_step_and_has_their_variance():
    parameters, state, contacts, _ = contacts_at(discs_at([[-1.001, 0.0], [1.001, 0.0], [9.0, 0.0]]))
    found, time = [], parameters.time_step
    for step in range(800):
        state.step[0] = step
        noise = noise_of_intervals(parameters, state, contacts, 4)
        assert np.abs(noise.sum(axis=0)).max() < 1e-12 * np.abs(noise).max()
        assert (noise[:, 2] == 0.0).all()
        found.append(noise[:, :2])
    # Of four numbers less their mean the variance is three quarters of that of an interval.
    variance = 2.0 * parameters.drift.thermal * parameters.kick.gain[0] / (time / 4)
    assert np.var(found) == pytest.approx(0.75 * variance, rel=0.05)


BOUND = """\
model = "floating"
duration = 200.0
frame_every = 100.0
[[particles]]
radius = 20e-6
density = 2000.0
contact_angle = "90 deg"
positions = [[-20.02e-6, 0.0], [20.02e-6, 0.0], [0.0, 34.7e-6]]
[contacts]
restitution = 0.0
[integration]
integrator = "overdamped"
[hydrodynamics]
brownian = true
"""


def shares_of_three(parameters, edges, count=400_000):
    """The length kT over the force at contact (m), and the shares of gaps below so many of it in equilibrium: gaps are
    drawn from exponential distributions, weighted by their energy and by the area that belongs to them.
    """
    radius, charge, thermal = parameters.floats.radius[0], parameters.floats.charge[0], parameters.drift.thermal
    own = two_floats(parameters, (radius, radius), (charge, charge))
    gaps = np.linspace(0.0, radius, 4001)
    energy = np.array([row_of(parameters).energy(2.0 * radius + gap, own, law_of(parameters)) for gap in gaps])
    length = thermal * gaps[1] / (energy[1] - energy[0])
    gap = np.random.default_rng(1).exponential(length, (count, 3))
    sides = 2.0 * radius + gap
    half = 0.5 * sides.sum(axis=1)
    area = np.sqrt(half * (half[:, None] - sides).prod(axis=1))
    above = (np.interp(gap, gaps, energy) - energy[0]).sum(axis=1) / thermal
    weight = np.exp(gap.sum(axis=1) / length - above) * sides.prod(axis=1) / area
    return length, np.array([np.average((gap < edge * length).mean(axis=1), weights=weight) for edge in edges])


@pytest.mark.long
@pytest.mark.compiled
def test_gaps_in_a_cluster_of_three_are_those_of_equilibrium():
    """Bound by 570 kT: solved as impulses, those below kT over the force were 10 % too frequent, and those below a
    tenth of it 29 %.
    """
    model, scene, edges, found = MODELS["floating"], load_scene(BOUND), np.array([0.1, 0.3, 1.0, 2.0]), []
    parameters = model.parameters(scene)
    state = model.start(scene, parameters)
    workspace = model.workspace(parameters, state, 1.0)
    length, exact = shares_of_three(parameters, edges)
    for _ in range(30_000):
        model.advance(parameters, state, workspace, 4)
        apart = state.position[[0, 0, 1]] - state.position[[1, 2, 2]]
        found.append((np.hypot(*apart.T) - 40e-6)[:, None] < edges * length)
    assert np.mean(found, axis=(0, 1))[2:] == pytest.approx(exact[2:], rel=0.02)
    assert np.mean(found, axis=(0, 1))[:2] == pytest.approx(exact[:2], rel=0.1)
