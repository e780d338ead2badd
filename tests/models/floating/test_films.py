"""Films between floats: they slow down approaches, and conserve momentum."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import quad

from ecume.errors import SceneError
from ecume.laws import capillarity
from ecume.laws.drag import pair_factor
from ecume.models import MODELS
from ecume.models.floating.coupled.mobility import MobilityOfEach
from ecume.models.floating.forces.films import CLOSEST, film_excess, find_films, make_films, solve_with_films
from tests.models import begun
from tests.models.floating.bowls import WATER, scene_of

FLOATING = MODELS["floating"]
BEAD = "radius = 3e-4\ndensity = 1050.0\ncontact_angle = 1.3089969\n"
RADIUS = 3e-4


def beads(places, *, films="{ roughness = 1e-6 }", integrator="overdamped", more="", **times):
    listed = [list(place) for place in places]
    motion = f'[integration]\nintegrator = "{integrator}"\n[hydrodynamics]\nlubrication = {films}\n{more}'
    return scene_of(f"{WATER}[[particles]]\n{BEAD}positions = {listed}\n{motion}", **times)


def test_the_table_is_the_law_level_where_it_is_rough_and_zero_in_the_end():
    films = make_films(1e-3, 4.0)
    far = pair_factor(4.0)
    for gap in (1e-3, 0.02, 0.3, 1.7):
        assert film_excess(films, gap) == pytest.approx(pair_factor(2.0 + gap) - far, rel=1e-4)
    assert film_excess(films, 0.0) == film_excess(films, -1e-3) == film_excess(films, 1e-3)
    assert film_excess(films, 2.0) == film_excess(films, 5.0) == 0.0
    assert make_films(0.0, 4.0).ends[0] == np.log(CLOSEST)


def test_two_that_are_pushed_together_go_slower_by_lambda():
    parameters, state, workspace = begun(beads([(0.0, 0.0), (2.1 * RADIUS, 0.0)]))
    pairs = find_films(parameters.parts.resistances[0], parameters, state.position, workspace.lists)
    velocity = np.array([[1e-3, 2e-4], [-1e-3, 5e-4]])
    solve_with_films(MobilityOfEach(parameters.kick.gain), pairs, velocity.reshape(-1), np.zeros(4))
    excess = pair_factor(2.1) - pair_factor(4.0)
    wanted = np.array([[1e-3 / (1 + excess), 2e-4], [-1e-3 / (1 + excess), 5e-4]])
    assert velocity == pytest.approx(wanted, rel=1e-5)


@pytest.mark.parametrize("integrator", ["velocity-verlet", "explicit-euler", "semi-implicit-euler"])
def test_two_that_run_into_each_other_stop_as_their_inertia_and_the_film_say(integrator):
    """Each has the speed v exp(-lambda t/tau), where lambda is that of the film while the gap hardly changes."""
    speed, time = 1e-4, 2e-4
    floats = "".join(
        f"[[particles]]\n{BEAD}positions = [[{x}, 0.0]]\nvelocity = [{v}, 0.0]\n"
        for x, v in ((0.0, speed), (2.1 * RADIUS, -speed))
    )
    motion = f'[integration]\nintegrator = "{integrator}"\ntime_step = {time}\n[interaction]\nlaw = "none"\n'
    films = '[hydrodynamics]\ndrag = "stokes"\nlubrication = { roughness = 1e-6 }\n'
    parameters, state, workspace = begun(scene_of(f"{WATER}{floats}{motion}{films}", duration=0.1, frame_every=0.1))
    assert FLOATING.advance(parameters, state, workspace, 20) == 0
    resistance = 1.0 + pair_factor(2.1) - pair_factor(4.0)
    kept = math.exp(-resistance * 20 * time / parameters.floats.relaxation_time[0])
    assert 0.2 < kept < 0.8
    assert state.velocity[0, 0] == pytest.approx(kept * speed, rel=0.01)
    assert state.velocity.sum(axis=0) == pytest.approx([0.0, 0.0], abs=1e-15)


def test_films_leave_the_distance_of_floats_that_rotate_with_the_surface():
    """In 200 steps of 1/500 rad. Without the change of the current until the middle of each step: 0.04 % more."""
    floats = "radius = 2e-5\ndensity = 1500.0\ncontact_angle = 1.2\n"
    floats = f"[[particles]]\n{floats}positions = [[1e-3, 0.0], [1.05e-3, 0.0]]\nvelocity = [0.0, 1e-3]\n"
    rest = '[integration]\ntime_step = 0.002\n[interaction]\nlaw = "none"\n[flow]\nrotation_rate = 1.0\n'
    films = '[hydrodynamics]\ndrag = "stokes"\nlubrication = { roughness = 1e-6 }\n'
    parameters, state, workspace = begun(scene_of(f"{WATER}{floats}{rest}{films}", duration=6.0, frame_every=6.0))
    assert len(find_films(parameters.parts.resistances[0], parameters, state.position, workspace.lists).friction) == 1
    assert FLOATING.advance(parameters, state, workspace, 200) == 0
    assert np.hypot(*state.position.T) == pytest.approx([1e-3, 1.05e-3], rel=2e-5)


def test_the_roughness_is_a_length_whatever_the_sizes_of_the_floats():
    rough, small = 1e-5, 0.1 * RADIUS
    places = [(0.0, 0.0), (2.001 * RADIUS, 0.0)]
    scene = beads(places, films=f"{{ roughness = {rough} }}")
    speck = dataclasses.replace(scene.particles[0], radius=small, positions=((0.01, 0.0),), count=1, name="speck")
    friction = []
    for particles in (scene.particles, (*scene.particles, speck)):
        parameters, state, workspace = begun(dataclasses.replace(scene, particles=particles))
        pairs = find_films(parameters.parts.resistances[0], parameters, state.position, workspace.lists)
        friction += pairs.friction.tolist()
    alone, beside_a_speck = friction
    zeta = 2.0 * alone / (pair_factor(2.0 + rough / RADIUS) - pair_factor(4.0))
    gain = float(parameters.kick.gain[0])
    assert zeta == pytest.approx(1.0 / gain, rel=1e-4)
    assert beside_a_speck == pytest.approx(alone, rel=1e-4)


def test_films_do_not_slow_floats_of_one_velocity_and_keep_momentum():
    rng = np.random.default_rng(1)
    places = 2.3 * RADIUS * np.array([(i, j) for i in range(4) for j in range(4)])
    parameters, state, workspace = begun(beads(places.tolist()))
    pairs = find_films(parameters.parts.resistances[0], parameters, state.position, workspace.lists)
    assert len(pairs.friction) > 40
    mobility, together = MobilityOfEach(parameters.kick.gain), np.full(32, 3e-3)
    solve_with_films(mobility, pairs, together, np.zeros(32))
    assert together == pytest.approx(np.full(32, 3e-3), rel=1e-12)
    given = 1e-3 * rng.normal(size=(16, 2))
    slowed, force = given.copy(), np.zeros((16, 2))
    assert 0 < solve_with_films(mobility, pairs, slowed.reshape(-1), force.reshape(-1)) < 100
    assert slowed.sum(axis=0) == pytest.approx(given.sum(axis=0), abs=1e-15)
    assert slowed == pytest.approx(given + parameters.kick.gain[:, None] * force, abs=1e-12)
    for (i, j), along, friction in zip(
        np.stack([pairs.first, pairs.second], 1), pairs.along, pairs.friction, strict=True
    ):
        force[i] -= friction * ((slowed[j] - slowed[i]) @ along) * along
        force[j] += friction * ((slowed[j] - slowed[i]) @ along) * along
    assert np.abs(force).max() < 1e-8 * friction * np.abs(slowed).max()
    assert np.sum(slowed**2) < np.sum(given**2)


@pytest.mark.long
@pytest.mark.compiled
def test_two_beads_meet_when_the_law_says():
    """The time from 4 R to 2.02 R, against the integral of zeta lambda / 2F."""
    start, near = 4.0 * RADIUS, 2.02 * RADIUS
    films = "{ roughness = 1e-6, cutoff = 50.0 }"
    scene = beads([(-0.5 * start, 0.0), (0.5 * start, 0.0)], films=films, duration=20.0, frame_every=0.01)
    parameters, state, workspace = begun(scene)
    length, charge = parameters.pair[1], parameters.floats.charge[0]
    strength = capillarity.pair_strength(0.0728, charge, charge)
    far = pair_factor(50.0)

    def slowness(distance, film):
        drag = (1.0 + pair_factor(distance / RADIUS) - far) if film else 1.0
        return drag / (2.0 * parameters.kick.gain[0] * -capillarity.pair_force(distance, strength, length))

    wanted, without = (quad(slowness, near, start, args=(film,))[0] for film in (True, False))
    while np.ptp(state.position[:, 0]) > near:
        assert FLOATING.advance(parameters, state, workspace, 1) == 0
    found = int(state.step[0]) * parameters.time_step
    assert found == pytest.approx(wanted, rel=5e-3)
    assert found > 1.3 * without


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"integrator": "rk4"}, "it must act on a whole kick"),
        ({"more": "brownian = true\n"}, "moved by noise that is correlated"),
        ({"more": '[contacts]\nlaw = "spring-dashpot"\nstiffness = 1.0\n'}, "contacts that stop floats at once"),
    ],
)
def test_what_films_do_not_go_with_is_reported(changes, message):
    with pytest.raises(SceneError, match=message):
        FLOATING.parameters(beads([(0.0, 0.0), (1e-3, 0.0)], **changes))
