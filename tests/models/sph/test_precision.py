"""Single precision: what it costs in digits, wherever the tank stands."""

import numpy as np
import pytest

from ecume.models.sph.rates.right_hand_side import evaluate_accelerations, evaluate_density_rate
from tests.models.sph.scenes import free_blob, tank
from tests.models.sph.test_sums import at_start

AWAY = 900.0
"""m: single precision resolves 6e-5 m there, a thousandth of the spacing."""


def rates(scene):
    parameters, state, workspace = at_start(scene)
    x, y, *_ = state.position - np.array(scene.tank.low)[:, None]
    state.velocity[0], state.velocity[1] = 0.3 * np.sin(5.0 * y), 0.2 * np.cos(7.0 * x)
    state.density[...] *= 1.0 + 0.003 * np.sin(7.0 * x)
    evaluate_density_rate(parameters, state, workspace)
    evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    return workspace, state.density_rate, state.acceleration


def off_by(single, double):
    return np.sqrt(np.mean((single - double) ** 2) / np.mean(double**2))


@pytest.mark.parametrize("walls", ["mirror", "dummy"])
def test_single_precision_keeps_six_digits_wherever_the_tank_stands(walls):
    _, density_rate, acceleration = rates(tank(walls=walls))
    workspace, *single = rates(tank(walls=walls, precision="single", away=AWAY))
    assert workspace.fields.table.dtype == workspace.rates.table.dtype == np.float32
    assert 1e-9 < off_by(single[0], density_rate) < 2e-6
    assert 1e-9 < off_by(single[1], acceleration) < 2e-6


@pytest.mark.compiled
def test_in_three_dimensions_too():
    _, density_rate, acceleration = rates(free_blob(3, density_diffusion="none"))
    _, *single = rates(free_blob(3, density_diffusion="none", precision="single"))
    assert 1e-9 < off_by(single[0], density_rate) < 2e-6
    assert 1e-9 < off_by(single[1], acceleration) < 2e-6
