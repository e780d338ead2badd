"""Whole runs of the SPH model: the same bits whatever stands between."""

import numpy as np
import pytest

import ecume
from ecume._jit import use_threads
from ecume.models.model import DIVERGED
from ecume.models.sph.boundaries.walls import reflect_particles
from ecume.models.sph.integration import time_stepping
from ecume.models.sph.record import SPH
from ecume.models.sph.state import skin_for
from ecume.simulation import moments
from tests.models.sph.scenes import tank

pytestmark = pytest.mark.compiled


def integrated(scene, steps):
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    SPH.advance(parameters, state, SPH.workspace(parameters, state, 1.0), steps)
    return parameters, state


def copy_of(state):
    return type(state)(*(array.copy() for array in state))


def test_frames_keep_every_particle_at_its_place():
    frames = list(ecume.simulate(tank()))
    first, last = frames[0].arrays, frames[-1].arrays
    assert np.array_equal(first["mass"], last["mass"])
    moved = np.abs(first["position"] - last["position"]).max()
    assert 0.0 < moved < 0.2


def test_threads_change_no_bit():
    scene = tank(deep=72)
    before = use_threads(None)
    try:
        use_threads(1)
        _, one = integrated(scene, 3)
        use_threads(2)
        _, two = integrated(scene, 3)
    finally:
        use_threads(before)
    assert one.position.shape[1] > 4000
    assert np.array_equal(one.velocity, two.velocity)
    assert np.array_equal(one.density, two.density)


@pytest.mark.parametrize(
    ("walls", "integrator"), [("mirror", "symplectic"), ("dummy", "symplectic"), ("mirror", "verlet")]
)
def test_a_tank_at_rest_stays_so(walls, integrator):
    (*_, last) = ecume.simulate(tank(walls=walls, integrator=integrator, jitter=0.0))
    pressure = last.arrays["pressure"]
    depth = 1.0 - last.arrays["position"][:, 1]
    assert np.sqrt(np.mean((pressure - depth) ** 2)) < 0.03
    assert last.numbers["guard_hits"] == 0
    assert last.numbers["largest_speed"] < 0.05


def test_both_integrators_let_sound_die_away():
    rung = []
    for integrator in ("symplectic", "verlet"):
        scene = tank(integrator=integrator, jitter=0.0, initial_pressure="zero", artificial_viscosity=0.0)
        rung.append([frame.numbers["kinetic_energy"] for frame in ecume.simulate(scene)])
    assert rung[1] == pytest.approx(rung[0], rel=0.2, abs=0.1 * max(rung[0]))
    assert rung[1][-1] < 0.5 * max(rung[1])


@pytest.mark.parametrize("broken", ["position", "velocity"])
def test_a_run_that_diverges_says_when_who_and_what_to_do(broken):
    scene = tank()
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    getattr(state, broken)[0, 3] = np.nan
    assert SPH.advance(parameters, state, SPH.workspace(parameters, state, 1.0), 1) == DIVERGED
    said = SPH.diagnosis(parameters, state)
    assert "t = 0 s" in said
    assert "particle 3" in said
    assert "courant" in said


def test_what_the_last_step_breaks_is_seen_before_anyone_draws_it(monkeypatch):
    def burst(parameters, state, workspace, time):
        state.velocity[0, 3] = 1e90

    monkeypatch.setitem(time_stepping.INTEGRATORS, "symplectic", burst)
    scene = tank()
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    assert SPH.advance(parameters, state, SPH.workspace(parameters, state, 1.0), 1) == DIVERGED


def test_a_moment_is_a_whole_state():
    first = next(iter(moments(tank())))
    assert first.state.position.shape == (2, 64)


def test_lists_look_further_where_the_liquid_is_fast():
    scene = tank()
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    state.velocity[...] = 0.001
    slow = skin_for(parameters, state)
    state.velocity[0, 3] = 1.0
    fast = skin_for(parameters, state)
    # A step takes the fastest some percent of the support.
    assert 0.02 < slow / parameters.support < 0.05 < fast / parameters.support <= 0.25
    state.velocity[0, 3] = np.nan
    assert skin_for(parameters, state) == state.skin[0]


@pytest.mark.parametrize("count", [1, 3])
def test_the_guard_turns_velocities_back_with_the_positions(count):
    parameters = SPH.parameters(tank(jitter=0.0))
    position, velocity = np.tile([[0.5], [-0.01]], count), np.tile([[0.2], [-1.0]], count)
    met = reflect_particles(parameters.boundary.guard, position, velocity, np.zeros_like(velocity), 0.02)
    np.testing.assert_allclose(velocity, np.tile([[0.2], [0.5]], count))
    np.testing.assert_allclose(position[1], 0.005, atol=1e-3)
    assert met.hits.sum() == count
    np.testing.assert_allclose(met.change, np.tile([[0.0], [1.5]], count))
