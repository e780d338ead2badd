"""Gradients that are completed at the free surface: exact there, and still those of a Hamiltonian."""

import math

import numpy as np
import pytest

from ecume.laws.water_waves import viscous_decay
from ecume.models.sph.rates.right_hand_side import evaluate_accelerations, evaluate_density_rate, fill
from ecume.models.sph.rates.sum_evaluation import evaluate_sum
from ecume.models.sph.record import SPH
from ecume.models.sph.report.energy_budget import energies, spreading_energy
from ecume.models.sph.setup.choices import USUAL_DAMPING, acoustic_damping_of
from ecume.scenes.schema import from_plain, to_plain
from ecume.simulation import simulate
from ecume_validation import standing_wave
from tests.models.sph.random_closed_tanks import gained
from tests.models.sph.scenes import OPEN, free_blob, tank
from tests.models.sph.test_sums import at_start

CORRECTED = {"pressure_force": "corrected", "density_diffusion": "none"}


def rate_of_density(force):
    """How the density of a tank changes by rows from the surface down, in a flow without divergence."""
    parameters, state, workspace = at_start(tank(12, **{**CORRECTED, "jitter": 0.0, "pressure_force": force}))
    state.density[...] = 1.0
    x, y = state.position
    state.velocity[...] = x, -y
    middle = np.abs(x - 0.5) < 0.1
    evaluate_density_rate(parameters, state, workspace)
    rows = np.round((1.0 - y) * 12 - 0.5)
    return [float(np.abs(state.density_rate[middle & (rows == row)]).max()) for row in range(12)]


def test_a_flow_without_divergence_changes_no_density_in_the_two_rows_at_a_surface():
    usual, corrected = rate_of_density("sum"), rate_of_density("corrected")
    assert min(usual[0], usual[1]) > 0.15
    assert max(corrected[:2]) < 1e-12
    # Deeper rows lack few neighbors, and are corrected in part.
    assert max(corrected) < 0.08
    assert corrected[4:8] == pytest.approx(usual[4:8], abs=1e-12)


def disordered(dimension=2, **method):
    parameters, state, workspace = at_start(
        free_blob(dimension, **{**CORRECTED, "artificial_viscosity": 0.0, **method})
    )
    state.density[...] *= 1.0 + 0.01 * np.sin(7.0 * state.position[0])
    state.velocity[...] = np.sin(5.0 * state.position[::-1])
    evaluate_density_rate(parameters, state, workspace)
    evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    return parameters, state, workspace


@pytest.mark.parametrize("dimension", [2, pytest.param(3, marks=pytest.mark.compiled)])
def test_the_force_is_adjoint_to_the_divergence(dimension):
    _, state, workspace = disordered(dimension)
    liquid = len(state.density)
    assert np.abs(workspace.fields.correction[3, :liquid]).max() > 0.05
    kinetic = float(np.sum(state.mass * (state.velocity * state.acceleration).sum(axis=0)))
    pressure = workspace.fields.pressure[:liquid]
    elastic = float(np.sum(state.mass * pressure / state.density**2 * state.density_rate))
    assert abs(kinetic) > 1.0
    assert kinetic == pytest.approx(-elastic, rel=1e-9)
    np.testing.assert_allclose(state.acceleration @ state.mass, 0.0, atol=1e-9 * np.abs(state.acceleration).max())


def test_matrices_of_images_are_mirrored():
    """At a corner of a tank and its surface, a matrix of an image is that which the image itself would have."""
    parameters, state, workspace = at_start(tank(8, **CORRECTED))
    fill(parameters, state, workspace)
    fields, images, real = workspace.fields, workspace.images, len(workspace.lists.counts)
    tilted = np.abs(fields.correction[3, images.source]) > 1e-3
    left = (fields.position[0, real:] < 0.0) & (fields.position[1, real:] > 0.0) & tilted
    assert left.any()
    own, mirrored = fields.correction[:, images.source[left]], fields.correction[:, real:][:, left]
    np.testing.assert_array_equal(mirrored[:3], own[:3])
    np.testing.assert_array_equal(mirrored[3], -own[3])


def fastest_rates(positions):
    """The largest eigenvalues of D D* and of it with relieved damping, over that of a lattice: the squared frequency of
    the fastest sound, and the rate at which it is damped. D is the divergence of these particles, in spacings.
    """
    plain, count, spacing = to_plain(free_blob(**{**CORRECTED, "jitter": 0.0})), len(positions), 0.125
    places = (spacing * (positions - positions.mean(axis=0))).tolist()
    plain["fluid"], plain["liquid"]["maximum_speed"] = [{"particles": {"positions": places}}], 1.0
    parameters, state, workspace = at_start(from_plain(plain))
    state.density[...] = 1000.0
    divergence = np.zeros((count, 2 * count))
    for column in range(2 * count):
        state.velocity[...] = 0.0
        state.velocity[column % 2, column // 2] = 1.0
        evaluate_density_rate(parameters, state, workspace)
        divergence[:, column] = state.density_rate / 1000.0
    shares = parameters.pressure_force.damping_shares(workspace.fields, count)
    rates = [divergence, np.sqrt(shares)[:, None] * divergence]
    return [float(np.linalg.eigvalsh(each @ each.T)[-1]) * spacing**2 for each in rates]


LATTICE = np.stack(np.meshgrid(np.arange(12.0), np.arange(12.0)), axis=-1).reshape(-1, 2)
INTERIOR = 0.32
"""Of a lattice with h of two spacings: (1.13/2)^2, the quickest oscillation."""


@pytest.mark.compiled
@pytest.mark.parametrize("seed", range(12))
def test_the_usual_step_resolves_completed_gradients_of_any_drop(seed):
    """Without both limits these would be up to 25 times as large as in a lattice."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 16))
    drop = 1.2 * math.sqrt(count) * rng.uniform(0.0, 1.0, (count, 2)) + [4.0, 13.5]
    shaken = LATTICE + rng.uniform(-0.15, 0.15, LATTICE.shape)
    for positions in (drop, np.concatenate([shaken, drop])):
        stiffness, damping = fastest_rates(positions)
        assert stiffness < 4.5 * INTERIOR
        assert damping < 1.4 * INTERIOR


def test_the_spreading_pressure_has_an_energy_whose_slope_is_its_force():
    """Beside mirrors: what it adds to the power of the pressure is taken from that energy."""
    scene = tank(8, **{**CORRECTED, "artificial_viscosity": 0.0, "jitter": 0.2})
    parameters, state, workspace = at_start(scene)
    assert parameters.spreading_pressure == pytest.approx(1.0 / 8.0)
    state.density[...] = 1.0
    state.velocity[...] = np.random.default_rng(0).normal(size=state.velocity.shape)
    evaluate_density_rate(parameters, state, workspace)
    rate = state.density_rate.copy()

    def power(spreading):
        now = parameters._replace(spreading_pressure=spreading)
        evaluate_accelerations(now, state, workspace, parameters.time_step)
        return float(np.sum(state.mass * (state.velocity * state.acceleration).sum(axis=0)))

    def energy(time):
        moved = state._replace(position=state.position + time * state.velocity, density=state.density + time * rate)
        fill(parameters, moved, workspace)
        return spreading_energy(parameters, moved, workspace)

    stored = (energy(1e-5) - energy(-1e-5)) / 2e-5
    assert abs(stored) > 0.01
    # Volumes of images differ a little from those of rest.
    assert power(parameters.spreading_pressure) - power(0.0) == pytest.approx(-stored, rel=3e-3)


def test_the_spreading_pressure_is_that_of_one_spacing_under_the_strongest_pull():
    """A drop without gravity is pulled by w^2 R at its edge."""
    plain = to_plain(free_blob(2, **CORRECTED)) | {"central_force": {"angular_frequency": 2.0, "center": [0.1, 0.0]}}
    assert SPH.parameters(from_plain(plain)).spreading_pressure == pytest.approx(1000.0 * 4.0 * 0.6 * 0.125)
    pulled = plain | {"gravity": [0.0, -3.0]}
    assert SPH.parameters(from_plain(pulled)).spreading_pressure == pytest.approx(1000.0 * (3.0 + 4.0 * 0.6) * 0.125)


@pytest.mark.long
@pytest.mark.compiled
def test_disordered_still_water_settles_with_completed_gradients():
    """Without a spreading pressure its speed grows from 0.003 to 0.04 and more, and the liquid sinks by 0.6 %."""
    scene = tank(12, pressure_force="corrected")
    plain = to_plain(scene) | {"duration": 20.0, "frame_every": 5.0}
    plain["liquid"]["sound_speed"], plain["liquid"]["maximum_speed"] = None, 1.4
    frames = list(simulate(from_plain(plain)))
    speeds = [math.sqrt(2.0 * frame.numbers["kinetic_energy"]) for frame in frames]
    assert speeds[4] < 0.5 * speeds[1] < 0.005
    assert frames[4].numbers["center_y"] > frames[1].numbers["center_y"] - 1e-3
    energy = [frame.numbers["total_energy"] - frame.numbers["injected_work"] for frame in frames]
    assert np.diff(energy).max() < 1e-5


def test_drops_of_few_particles_are_not_completed():
    four = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    stiffness, _ = fastest_rates(four)
    assert stiffness < INTERIOR


def splashing(seed):
    """Drops that fall on a pool or beside a column, some of few particles."""
    rng = np.random.default_rng([5, seed])
    spacing = 1.0 / int(rng.integers(12, 20))
    block = [1.0, rng.uniform(0.1, 0.4)] if rng.uniform() < 0.5 else [rng.uniform(0.2, 0.5), rng.uniform(0.4, 0.8)]
    fluid = [{"low": [0.0, 0.0], "high": block}]
    for number in range(int(rng.integers(1, 4))):
        radius = spacing * rng.uniform(0.8, 4.0)
        height = block[1] + radius + spacing * (2 + 10 * number)
        velocity = [rng.uniform(-0.5, 0.5), -rng.uniform(0.0, 2.0)]
        fluid.append({"center": [rng.uniform(0.25, 0.75), height], "radius": radius, "velocity": velocity})
    return from_plain(
        {
            "model": "sph", "duration": 1.5, "frame_every": 0.05, "spacing": spacing, "gravity": [0.0, -1.0],
            "liquid": {"density": 1.0}, "tank": {"high": [1.0, 4.0], "top": OPEN}, "fluid": fluid,
            "method": {"pressure_force": "corrected", "jitter": float(rng.choice([0.0, 0.1]))},
        }
    )  # fmt: skip


@pytest.mark.compiled
@pytest.mark.parametrize("seed", range(6))
def test_splashes_hold_with_completed_gradients_and_the_usual_damping(seed):
    scene = splashing(seed)
    assert acoustic_damping_of(scene) == USUAL_DAMPING
    assert gained(list(simulate(scene))) < 1e-4


def stretched(model, region=None):
    """The dissipation of a region that is stretched along one axis and squeezed along the other, over the exact one."""
    plain = to_plain(
        free_blob(viscosity=1.0, viscosity_model=model, jitter=0.0, artificial_viscosity=0.0, density_diffusion="none")
    )
    plain["liquid"]["maximum_speed"] = 1.0
    plain["fluid"] = [region] if region else plain["fluid"]
    parameters, state, workspace = at_start(from_plain(plain))
    state.density[...] = 1000.0
    state.velocity[...] = state.position * np.array([[1.0], [-1.0]])
    fill(parameters, state, workspace)
    workspace.rates.acceleration[...] = 0.0
    evaluate_sum(parameters.friction.sum, parameters, workspace)
    power = np.sum(state.mass * (state.velocity * workspace.rates.acceleration[:2]).sum(axis=0))
    return -float(power) * 1000.0 / (4.0 * float(np.sum(state.mass)))


def test_friction_is_complete_up_to_a_surface():
    """In a square of area one, 8 particles wide, the exact dissipation 2 mu D:D is 4. Without correction a quarter is
    missing; edges and corners together then have a tenth too much.
    """
    assert stretched("monaghan") < 0.8
    assert stretched("corrected") == pytest.approx(1.0, abs=0.12)


def test_friction_is_complete_in_a_disc():
    """With a radius of eight spacings; along a lattice the interior has four percent too much."""
    disc = {"center": [0.0, 0.0], "radius": 1.0}
    assert stretched("monaghan", disc) < 0.9
    assert stretched("corrected", disc) == pytest.approx(1.0, abs=0.06)


def test_completed_friction_does_not_brake_a_rigid_rotation():
    parameters, state, workspace = at_start(free_blob(viscosity=1.0, viscosity_model="corrected"))
    x, y = state.position
    state.velocity[...] = -y, x
    fill(parameters, state, workspace)
    workspace.rates.acceleration[...] = 0.0
    evaluate_sum(parameters.friction.sum, parameters, workspace)
    assert np.abs(workspace.rates.acceleration).max() < 1e-12


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("reynolds", [500.0, pytest.param(50.0, marks=pytest.mark.long)])
def test_a_wave_in_a_thin_liquid_decays_by_its_viscosity(reynolds):
    exact = viscous_decay(math.pi, 1.0, 1.0, 1.0 / reynolds)
    found = standing_wave.fitted(*standing_wave.heights(reynolds, 16, standing_wave.CORRECTED))
    assert found.rate == pytest.approx(exact.rate, rel=0.05)
    assert found.frequency == pytest.approx(exact.frequency, rel=0.01)


def test_a_jet_of_single_particles_is_not_corrected():
    """Particles with few neighbors have the unit matrix, and their energy stays finite."""
    parameters, state, workspace = at_start(free_blob(**CORRECTED))
    state.position[...] = 0.3 * np.arange(state.position.shape[1]) * np.array([[1.0], [0.0]])
    workspace.take(SPH.workspace(parameters, state, 1.0))
    fill(parameters, state, workspace)
    np.testing.assert_array_equal(workspace.fields.correction[:3, : state.position.shape[1]], 1.0)
    assert np.isfinite(energies(parameters, state, 0.0, 0.0)["total_energy"])
