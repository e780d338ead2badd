"""Eddies smaller than particles."""

import numpy as np
import pytest

from ecume.models.sph.rates.right_hand_side import evaluate_accelerations, fill
from ecume.models.sph.record import SPH
from tests.models.sph.scenes import free_blob


def stirred(gradient):
    """The liquid's viscosities and accelerations in a flow of this gradient, in surroundings without a wall."""
    return in_a_flow(free_blob(2, turbulence="smagorinsky", artificial_viscosity=0.0), gradient)


def in_a_flow(scene, gradient):
    """The viscosities of a scene's liquid in a flow of this gradient, and its state with accelerations."""
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    state.velocity[...] = np.array(gradient) @ state.position
    state.density[...] = parameters.material.density
    workspace = SPH.workspace(parameters, state, 1.0)
    fill(parameters, state, workspace)
    evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    return workspace.fields.viscosity[: state.position.shape[1]], state


def test_a_rigid_rotation_has_no_eddies():
    viscosity, state = stirred([[0.0, -2.0], [2.0, 0.0]])
    assert viscosity.max() < 1e-9
    assert np.abs(state.acceleration).max() < 1e-9


@pytest.mark.parametrize(("gradient", "strain"), [([[0.0, 3.0], [0.0, 0.0]], 3.0), ([[1.5, 0.0], [0.0, -1.5]], 3.0)])
def test_a_strain_makes_eddies_by_the_square_of_the_spacing(gradient, strain):
    viscosity, state = stirred(gradient)
    np.testing.assert_allclose(viscosity, 1000.0 * (0.12 * 0.125) ** 2 * strain, rtol=1e-9)
    middle = np.argmin((state.position**2).sum(axis=0))
    assert np.isfinite(state.acceleration[:, middle]).all()


def test_eddies_slow_a_strain_down():
    _, state = stirred([[1.5, 0.0], [0.0, -1.5]])
    assert np.sum(state.mass * (state.velocity * state.acceleration).sum(axis=0)) < 0.0
