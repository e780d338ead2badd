"""What the liquid carries along."""

import dataclasses

import numpy as np
import pytest

import ecume
from ecume.errors import SceneError
from ecume.models.sph.integration.passive_particles import move_passive_particles, surroundings
from ecume.models.sph.rates.right_hand_side import evaluate_accelerations, fill
from ecume.models.sph.record import SPH
from ecume.models.sph.setup.choices import kernel_of, smoothing_of
from ecume.scenes.schema import from_plain, to_plain
from ecume.scenes.sph import PassiveTracerSpec
from tests.models.sph.scenes import free_blob

STILL = {"density": 1000.0, "viscosity": 1e-3, "sound_speed": 2.0, "maximum_speed": 0.2}


def cup(*tracers, **method):
    """A still cup of water, some centimeters high."""
    return from_plain(
        {
            "model": "sph",
            "duration": 0.05,
            "frame_every": 0.05,
            "spacing": 5e-3,
            "liquid": STILL,
            "tank": {"low": [0.0, 0.0], "high": [0.03, 0.05], "top": {"kind": "open"}},
            "fluid": [{"low": [0.0, 0.0], "high": [0.03, 0.04]}],
            "passive_tracers": list(tracers),
            "method": method,
        }
    )


@pytest.mark.long
def test_a_tracer_in_a_rigid_rotation_keeps_its_radius():
    place = {"positions": ((0.25, 0.0), (0.0, -0.1))}
    scene = dataclasses.replace(free_blob(jitter=0.0), passive_tracers=(PassiveTracerSpec(**place),))
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    state.velocity[...] = np.array([[0.0, -2.0], [2.0, 0.0]]) @ state.position
    workspace = SPH.workspace(parameters, state, 1.0)
    fill(parameters, state, workspace)
    before = np.linalg.norm(state.passive_position, axis=0)
    for _ in range(1000):
        move_passive_particles(parameters, state, workspace, np.pi / 1000)
    np.testing.assert_allclose(np.linalg.norm(state.passive_position, axis=0), before, rtol=0.02)
    np.testing.assert_allclose(state.passive_position[:, 0], [0.25, 0.0], atol=0.05)


def test_a_grain_settles_at_its_terminal_speed():
    scene = cup({"positions": [[0.015, 0.03]], "radius": "100 um", "density": 2500.0})
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    workspace = SPH.workspace(parameters, state, 1.0)
    fill(parameters, state, workspace)
    for _ in range(400):
        move_passive_particles(parameters, state, workspace, 2.5e-4)
    # Schiller and Naumann's drag on quartz of 200 um in water, worked out independently of the code.
    assert -state.passive_velocity[1, 0] == pytest.approx(2.291683e-2, rel=1e-4)


@pytest.mark.long
@pytest.mark.compiled
def test_a_light_grain_rises_and_a_grain_stays_above_the_bottom():
    light = {"positions": [[0.015, 0.01]], "radius": "0.2 mm", "density": 500.0}
    heavy = {"positions": [[0.015, 0.001]], "radius": "0.5 mm", "density": 8000.0}
    *_, last = ecume.simulate(cup(light, heavy))
    place = last.arrays["position"][-2:]
    assert place[0, 1] > 0.011
    assert place[1, 1] >= 0.5e-3
    assert last.arrays["species"][-2:].tolist() == [1, 2]
    assert last.arrays["mass"][-2:].tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    "spec",
    [
        {"positions": [[9.0, 0.0]]},
        {"count": 3},
        {"positions": [[0.01, 0.01]], "radius": 1e-4},
        {"count": 1, "low": [0.0, 0.0], "high": [0.01, 0.01], "turbulent_dispersion": True},
    ],
)
def test_what_cannot_be_carried_is_refused(spec):
    with pytest.raises(SceneError):
        cup(spec)


@pytest.mark.long
@pytest.mark.parametrize("dimension", [2, 3])
def test_looking_into_the_cells_around_finds_what_looking_at_all_does(dimension):
    low, high = [0.0] * dimension, [0.1] * dimension
    sides = {side: {"kind": "periodic"} for side in ("left", "right")}
    scene = from_plain(
        {
            "model": "sph",
            "duration": 0.05,
            "frame_every": 0.05,
            "spacing": 0.1 / (16 if dimension == 2 else 8),
            "liquid": STILL,
            "tank": {"low": low, "high": [0.1, 0.2, 0.1][:dimension], "top": {"kind": "open"}, **sides},
            "fluid": [{"low": low, "high": high}],
            "passive_tracers": [{"count": 200, "low": low, "high": high}],
            "method": {"jitter": 0.2},
        }
    )
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    state.velocity[...] = np.sin(30.0 * state.position)
    workspace = SPH.workspace(parameters, state, 1.0)
    fill(parameters, state, workspace)
    found = surroundings(parameters, workspace, state.passive_position)
    fields = workspace.fields
    place = fields.position[:dimension] + parameters.origin[:, None]
    away = place[:, :, None] - state.passive_position[:, None, :]
    shape = kernel_of(scene)
    weight = shape.value(np.sqrt((away**2).sum(axis=0)), smoothing_of(scene)) * (fields.volume * fields.liquid)[:, None]
    np.testing.assert_allclose(found.fraction, weight.sum(axis=0), rtol=1e-12)
    np.testing.assert_allclose(
        found.velocity[0], fields.velocity[0] @ weight / weight.sum(axis=0), rtol=1e-9, atol=1e-12
    )
    np.testing.assert_allclose(found.pressure, fields.pressure @ weight / weight.sum(axis=0), rtol=1e-9, atol=1e-9)


@pytest.mark.compiled
def test_a_carried_particle_has_the_pressure_of_the_liquid_around_it():
    *_, last = ecume.simulate(cup({"positions": [[0.015, 0.02], [0.015, 0.01]]}))
    np.testing.assert_allclose(last.arrays["pressure"][-2:], 1000.0 * 9.81 * np.array([0.02, 0.03]), rtol=0.05)


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("viscosity", [0.0, 40.0])
def test_eddies_alone_scatter_tracers_and_not_the_viscosity_of_the_liquid(viscosity):
    strain, schmidt, count, time = 3.0, 0.5, 20_000, 1e-3
    spec = {
        "count": count,
        "low": [-0.2, -0.2],
        "high": [0.2, 0.2],
        "turbulent_dispersion": True,
        "schmidt_number": schmidt,
    }
    plain = to_plain(free_blob(viscosity=viscosity, turbulence="smagorinsky", jitter=0.0))
    scene = from_plain({**plain, "passive_tracers": [spec]})
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    workspace = SPH.workspace(parameters, state, 1.0)

    def scattered(gradient):
        """Where a step brings tracers beside where the flow carries them."""
        state.velocity[...] = np.array(gradient) @ state.position
        state.density[...] = parameters.material.density
        evaluate_accelerations(parameters, state, workspace, time)
        before = state.passive_position.copy()
        around = surroundings(parameters, workspace, before)
        move_passive_particles(parameters, state, workspace, time)
        return state.passive_position - before - time * around.velocity[:2], around.eddy_viscosity

    # Smagorinsky's viscosity, (0.12 spacing)^2 |S|, over the Schmidt number.
    eddies = (0.12 * scene.spacing) ** 2 * strain
    away, seen = scattered([[0.0, strain], [0.0, 0.0]])
    np.testing.assert_allclose(seen, eddies, rtol=1e-6)
    np.testing.assert_allclose((away**2).mean(axis=1), 2.0 * eddies / schmidt * time, rtol=0.04)
    # Without strain there are no eddies, and nothing scatters.
    away, seen = scattered([[0.0, -strain], [strain, 0.0]])
    assert np.abs(away).max() < 1e-3 * np.sqrt(2.0 * eddies / schmidt * time)
    assert seen.max() < 1e-5 * eddies
