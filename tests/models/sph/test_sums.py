"""What the sums over neighbors must keep."""

import math

import numpy as np
import pytest

from ecume.laws.viscous import friction_left
from ecume.models.sph.rates.right_hand_side import evaluate_accelerations, evaluate_density_rate, evaluate_rates, fill
from ecume.models.sph.rates.sum_evaluation import evaluate_sum
from ecume.models.sph.rates.sums import RADIAL_FRICTION
from ecume.models.sph.record import SPH
from ecume.models.sph.state import likely_neighbors
from ecume.scenes.schema import from_plain, to_plain
from tests.models.sph.scenes import free_blob, tank


def at_start(scene):
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    workspace = SPH.workspace(parameters, state, 1.0)
    return parameters, state, workspace


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("reach", [3.0, 3.5, 4.3])
def test_as_many_neighbors_as_a_full_lattice_has_are_likely_and_not_many_more(dimension, reach):
    steps = np.arange(-math.ceil(reach), math.ceil(reach) + 1)
    nodes = np.stack(np.meshgrid(*[steps] * dimension), axis=-1).reshape(-1, dimension)
    neighbors = np.count_nonzero((nodes**2).sum(axis=1) <= reach**2) - 1
    assert likely_neighbors(dimension, reach) == pytest.approx(neighbors + 4.0, rel=0.1, abs=3.0)


@pytest.mark.long
@pytest.mark.parametrize("force", ["sum", "monaghan", "transport"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_forces_between_particles_change_no_momentum(force, dimension):
    # At a free surface there must be no background pressure.
    more = {"background_pressure": 0.0} if force == "transport" else {}
    parameters, state, workspace = at_start(free_blob(dimension, pressure_force=force, **more))
    state.density[...] *= 1.0 + 0.01 * np.sin(7.0 * state.position[0])
    evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    momentum = state.acceleration @ state.mass
    assert np.abs(state.acceleration).max() > 1.0
    np.testing.assert_allclose(momentum, 0.0, atol=1e-12 * np.abs(state.acceleration * state.mass).sum())


@pytest.mark.long
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_central_force_turns_nothing(dimension):
    parameters, state, workspace = at_start(free_blob(dimension))
    state.density[...] *= 1.0 + 0.01 * np.sin(7.0 * state.position[0])
    evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    x, a = state.position, state.acceleration
    torque = np.sum(state.mass * (x[0] * a[1] - x[1] * a[0]))
    assert abs(torque) < 1e-12 * np.sum(state.mass * np.abs(a).max())


@pytest.mark.parametrize("dimension", [2, pytest.param(3, marks=pytest.mark.compiled)])
def test_a_liquid_that_turns_like_a_solid_feels_no_friction_and_one_that_shears_loses_energy(dimension):
    parameters, state, workspace = at_start(free_blob(dimension, viscosity=1.0, acoustic_damping=0.0))
    x, v = state.position, state.velocity
    v[...] = 0.0
    v[0], v[1] = 0.3 - x[1], x[0]
    evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    np.testing.assert_allclose(state.acceleration, 0.0, atol=1e-12)
    v[0] = np.sin(3.0 * x[1])
    evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    push = state.mass * state.acceleration
    assert np.sum(push * v) < -0.1 * np.abs(push * v).sum()
    assert np.abs(push.sum(axis=1)).max() < 1e-12 * np.abs(push).sum()
    assert abs(np.sum(x[0] * push[1] - x[1] * push[0])) < 1e-12 * np.abs(push).sum()


@pytest.mark.parametrize(("dimension", "lattice"), [(2, 1.0392), pytest.param(3, 1.0766, marks=pytest.mark.compiled)])
def test_a_surface_takes_as_much_of_the_friction_as_pairs_reach_through_it(dimension, lattice):
    # `lattice` is what a stretch along the axes costs in an endless lattice.
    count, stretch = 6, np.diag([1.0, -1.0] if dimension == 2 else [1.0, -0.5, -0.5])
    round_one = {"center": [0.0] * dimension, "radius": 1.0, "velocity_gradient": stretch.tolist()}
    plain = to_plain(free_blob(dimension, viscosity=1.0, jitter=0.05))
    scene = from_plain({**plain, "spacing": 1.0 / count, "fluid": [round_one]})
    parameters, state, workspace = at_start(scene)
    fill(parameters, state, workspace)
    workspace.rates.acceleration[:3] = 0.0
    evaluate_sum(RADIAL_FRICTION, parameters, workspace)
    power = -np.sum(state.mass * workspace.rates.acceleration[:dimension] * state.velocity)
    full = lattice * 2.0 * np.sum(stretch**2) * len(state.mass) / count**dimension
    reach = parameters.numbers.smoothing_length * (1.0 if dimension == 2 else 10.0 / 9.0)
    assert power / full == pytest.approx(friction_left(reach, float(dimension), dimension), abs=0.5 / count**2)


def test_friction_is_along_the_line_of_two_where_a_surface_is_free_and_along_their_motion_where_none_is():
    wave = tank(viscosity=0.01)
    closed = from_plain({**to_plain(wave), "tank": {"low": [0.0, 0.0], "high": [1.0, 1.0]}})
    assert [SPH.parameters(scene).friction.radial for scene in (wave, closed)] == [True, False]


def test_an_expanding_lattice_thins_by_its_divergence():
    scene = free_blob(jitter=0.0, density_diffusion="none", kernel="wendland-c2")
    parameters, state, workspace = at_start(scene)
    state.velocity[...] = 0.3 * state.position
    evaluate_density_rate(parameters, state, workspace)
    middle = np.argmin((state.position**2).sum(axis=0))
    # The lattice's own quadrature of the kernel is what differs from -rho div v.
    assert state.density_rate[middle] / (-2.0 * 0.3 * state.density[middle]) == pytest.approx(1.0, abs=0.02)


def test_a_rigid_rotation_thickens_nothing():
    parameters, state, workspace = at_start(free_blob(density_diffusion="none"))
    state.velocity[0], state.velocity[1] = -state.position[1], state.position[0]
    evaluate_density_rate(parameters, state, workspace)
    np.testing.assert_allclose(state.density_rate, 0.0, atol=1e-10)


@pytest.mark.parametrize("walls", ["mirror", "dummy"])
def test_diffusion_leaves_a_tait_column_at_rest_alone(walls):
    parameters, state, workspace = at_start(tank(jitter=0.0, walls=walls))
    state.position[...] += 0.03 * np.sin(37.0 * state.position[::-1])
    depth = 1.0 - state.position[1]
    ratio = 1.0 + 6.0 * depth / 100.0
    state.density[...] = ratio ** (1.0 / 6.0)
    state.reference[...] = state.position
    workspace.take(SPH.workspace(parameters, state, 1.0))
    evaluate_density_rate(parameters, state, workspace)
    # A density error of a hundredth of the whole range would diffuse at a rate of about one.
    assert np.abs(workspace.rates.diffusion).max() < 1e-12
    state.density[5] *= 1.001
    evaluate_density_rate(parameters, state, workspace)
    assert workspace.rates.diffusion[5] < -1e-3


def test_diffusion_moves_density_and_makes_none():
    parameters, state, workspace = at_start(free_blob(density_diffusion="molteni"))
    state.density[...] *= 1.0 + 0.01 * np.sin(7.0 * state.position[0])
    evaluate_density_rate(parameters, state, workspace)
    flow = workspace.rates.diffusion * workspace.fields.volume[: state.position.shape[1]]
    assert abs(flow.sum()) < 1e-12 * np.abs(flow).sum()


def test_antuono_does_not_touch_a_density_that_grows_linearly():
    parameters, state, workspace = at_start(free_blob(density_diffusion="antuono"))
    state.density[...] = 1000.0 + 5.0 * state.position[0] - 3.0 * state.position[1]
    evaluate_density_rate(parameters, state, workspace)
    assert np.abs(workspace.rates.diffusion).max() < 1e-9


@pytest.mark.long
@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize("force", ["sum", "monaghan"])
@pytest.mark.parametrize("diffusion", ["none", "molteni", "antuono", "hydrostatic"])
@pytest.mark.parametrize("scene", [lambda **given: free_blob(3, **given), lambda **given: tank(walls="dummy", **given)])
def test_one_sum_gives_what_two_give(scene, diffusion, force, precision):
    """Also with the damping by a rate of before."""
    scene = scene(density_diffusion=diffusion, pressure_force=force, precision=precision)
    parameters, state, workspace = at_start(scene)
    state.density[...] *= 1.0 + 0.01 * np.sin(7.0 * state.position[0])
    evaluate_density_rate(parameters, state, workspace)
    evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    apart = state.density_rate.copy(), state.acceleration.copy()
    evaluate_rates(parameters, state, workspace, parameters.time_step)
    for found, expected in zip((state.density_rate, state.acceleration), apart, strict=True):
        tolerance = 1e-12 if precision == "double" else 1e-5
        np.testing.assert_allclose(found, expected, rtol=tolerance, atol=tolerance * np.abs(expected).max())
    assert parameters.bulk_viscosity > 0.0


def test_the_sums_are_those_of_the_laws_pair_by_pair():
    parameters, state, workspace = at_start(free_blob(kernel="quintic-spline", density_diffusion="none"))
    state.density[...] *= 1.0 + 0.01 * np.sin(7.0 * state.position[0])
    fill(parameters, state, workspace)
    evaluate_density_rate(parameters, state, workspace)
    evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    from ecume.laws.kernels import kernel

    shape, h, i = kernel("quintic-spline", dim=2), parameters.numbers.smoothing_length, 17
    apart = state.position - state.position[:, i : i + 1]
    distance = np.sqrt((apart**2).sum(axis=0))
    gradient = -shape.slope(distance, h) * apart / np.maximum(distance, 1e-300)
    pressure = workspace.fields.pressure[: len(distance)]
    volume = state.mass / state.density
    difference = state.velocity - state.velocity[:, i : i + 1]
    density_rate = -state.density[i] * np.sum(volume * difference * gradient)
    assert state.density_rate[i] == pytest.approx(density_rate, rel=1e-10)
    approach = np.minimum((difference * apart).sum(axis=0), 0.0) / (distance**2 + 0.01 * h * h)
    damping = -0.02 * 10.0 * h * 1000.0 * approach
    pressure = pressure + parameters.bulk_viscosity * state.density_rate / state.density
    assert parameters.bulk_viscosity == pytest.approx(2.0 * 1000.0 * 10.0 * h)
    force = -np.sum(volume * (pressure + pressure[i] + damping) * gradient, axis=1) / state.density[i]
    np.testing.assert_allclose(state.acceleration[:, i], force, rtol=1e-9)
    assert workspace.rates.continuity[i] != 0.0
    assert workspace.rates.acceleration[0, i] != 0.0
    assert workspace.fields.density[i] == state.density[i]


def with_axes_renamed(scene, take):
    """Vectors of all particles in 3D, and those where x, y and z are renamed y, z and x, named back."""
    found = []
    for turn in (0, 1):
        parameters, state, _ = at_start(scene)
        dice = np.random.default_rng(5)
        state.transport[...] = 0.1 * dice.normal(size=state.transport.shape)
        state.density[...] *= 1.0 + 0.01 * dice.normal(size=state.density.shape)
        for vectors in (state.position, state.velocity, state.transport):
            vectors[...] = np.roll(vectors, turn, axis=0)
        workspace = SPH.workspace(parameters, state, 1.0)
        found.append(np.roll(take(parameters, state, workspace), -turn, axis=0))
    assert np.abs(found[0]).max() > 0.1
    return found


def coarse_blob(**method):
    return from_plain({**to_plain(free_blob(3, **method)), "spacing": 0.3})


@pytest.mark.parametrize("force", ["sum", "monaghan", "transport"])
def test_forces_know_no_axis(force):
    more = {"background_pressure": 0.0} if force == "transport" else {}

    def forces(parameters, state, workspace):
        # The background pressure is what makes the transport velocity count; scenes with open sides may have none.
        evaluate_accelerations(parameters._replace(background=1.0), state, workspace, parameters.time_step)
        return state.acceleration.copy()

    one, other = with_axes_renamed(coarse_blob(pressure_force=force, viscosity=1.0, **more), forces)
    np.testing.assert_allclose(other, one, atol=1e-11 * np.abs(one).max())


def test_density_gradients_know_no_axis():
    def gradients(parameters, state, workspace):
        evaluate_density_rate(parameters, state, workspace)
        return workspace.fields.density_gradient[:, : state.position.shape[1]].copy()

    one, other = with_axes_renamed(coarse_blob(density_diffusion="antuono"), gradients)
    np.testing.assert_allclose(other, one, atol=1e-11 * np.abs(one).max())


def test_a_moving_wall_holds_the_liquid_by_its_velocity():
    """Half of the friction velocities of a particle and its image is that of the lid."""
    plain = to_plain(tank(4, viscosity=0.1))
    lid = {**plain["tank"], "high": [1.0, 1.0], "top": {"velocity": [0.8, 0.0]}}
    parameters, state, workspace = at_start(from_plain({**plain, "tank": lid}))
    state.velocity[...] = np.random.default_rng(2).normal(size=state.velocity.shape)
    fill(parameters, state, workspace)
    images, fields = workspace.images, workspace.fields
    first = len(workspace.lists.counts)
    above = np.flatnonzero(fields.position[1, first : first + len(images.source)] > 1.0)
    sources = images.source[above]
    own = sources < state.position.shape[1]
    assert own.sum() > 3
    mean = 0.5 * (fields.friction_velocity[:2, first + above[own]] + state.velocity[:, sources[own]])
    np.testing.assert_allclose(mean, np.outer([0.8, 0.0], np.ones(own.sum())), atol=1e-12)
