"""Every form of the equations that a tank may choose acts on solids as on liquid, and none is a default for others."""

import numpy as np
import pytest
from tests.models.sph.scenes import free_blob
from tests.models.sph.test_rigid_bodies import blob

from ecume.models.sph.integration.time_stepping import INTEGRATORS
from ecume.models.sph.rates.methods import FRICTIONS, PRESSURE_FORCES
from ecume.models.sph.rates.right_hand_side import evaluate_accelerations
from ecume.models.sph.rates.shifting import SHIFTINGS
from ecume.models.sph.rates.surface_tension import TENSIONS, surface_energy
from ecume.models.sph.record import SPH


def at_start(scene):
    """Parameters, state and workspace of a scene whose liquid moves and has pressure."""
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    state.density[...] *= 1.0 + 0.01 * np.sin(7.0 * state.position[0])
    state.velocity[...] = np.sin(5.0 * state.position[::-1])
    state.transport[...] = 0.1 * np.cos(4.0 * state.position)
    return parameters, state, SPH.workspace(parameters, state, 1.0)


@pytest.mark.compiled
@pytest.mark.parametrize("friction", FRICTIONS)
@pytest.mark.parametrize("force", PRESSURE_FORCES)
def test_a_body_gets_the_momentum_that_the_liquid_loses(force, friction):
    # At a free surface there must be no background pressure.
    more = {"background_pressure": 0.0} if force == "transport" else {}
    method = {"jitter": 0.2, "pressure_force": force, "viscosity_model": friction, **more}
    liquid = {"density": 1000.0, "sound_speed": 10.0, "maximum_speed": 1.0, "viscosity": 20.0}
    scene = blob(gravity=[0.0, 0.0], liquid=liquid, method=method)
    parameters, state, workspace = at_start(scene)
    evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    on_liquid = state.acceleration @ state.mass
    on_body = state.body_acceleration[:2, 0] * parameters.bodies.mass[0]
    assert np.abs(on_body).max() > 1.0
    np.testing.assert_allclose(on_body, -on_liquid, rtol=1e-9)


@pytest.mark.parametrize("choice", ["integrator", "shifting", "tension"])
def test_a_name_without_a_row_is_refused(choice):
    parameters, state, workspace = at_start(free_blob())
    assert "mine" not in {**INTEGRATORS, **SHIFTINGS, **TENSIONS}
    wrong = parameters._replace(**{choice: "mine"})
    with pytest.raises(KeyError, match="mine"):
        SPH.advance(wrong, state, workspace, 1)


def test_an_energy_of_an_unknown_surface_tension_is_refused():
    parameters, _, workspace = at_start(free_blob())
    with pytest.raises(KeyError, match="mine"):
        surface_energy(parameters._replace(tension="mine"), workspace)
