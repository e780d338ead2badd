"""What draws drops together."""

import numpy as np
import pytest

from ecume.models.sph.evaluating import fill
from ecume.models.sph.record import SPH
from ecume.models.sph.tension import pull
from ecume.scenes.schema import from_plain
from tests.models.sph.scenes import OPEN

SIDES = ("left", "right", "bottom", "top")


def drop(model, fluid, bottom=OPEN, low=-3.0, jitter=0.0):
    return from_plain(
        {
            "model": "sph",
            "duration": 1.0,
            "frame_every": 0.1,
            "spacing": 0.1,
            "gravity": [0.0, 0.0],
            "liquid": {"density": 1.0, "surface_tension": 1.0},
            "tank": {"low": [-3.0, low], "high": [3.0, 3.0], **dict.fromkeys(SIDES, OPEN), "bottom": bottom},
            "fluid": [fluid],
            "method": {"surface_tension_model": model, "jitter": jitter},
        }
    )


def pulled(scene):
    """Positions, masses and the acceleration by surface tension alone."""
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    workspace = SPH.workspace(parameters, state, 1.0)
    fill(parameters, state, workspace)
    pull(parameters, state, workspace)
    return state.position, state.mass, state.acceleration


DISC = {"center": [0.0, 0.0], "radius": 1.0}


def test_the_curvature_force_presses_a_disc_with_sigma_over_its_radius():
    x, mass, a = pulled(drop("csf", DISC))
    # A pressure p on the boundary of an area A has the virial -2 p A.
    assert np.sum(mass * (x * a).sum(axis=0)) == pytest.approx(-2.0 * np.pi, rel=0.06)


def test_cohesion_draws_a_disc_together_and_changes_no_momentum():
    x, mass, a = pulled(drop("cohesion", DISC, jitter=0.2))
    outside = (x**2).sum(axis=0) > 0.8
    assert (x * a).sum(axis=0)[outside].max() < 0.0
    np.testing.assert_allclose(a @ mass, 0.0, atol=1e-12 * np.abs(a * mass).sum())


@pytest.mark.parametrize("model", ["csf", "cohesion"])
def test_a_mirror_meets_the_surface_at_a_right_angle(model):
    x, _, a = pulled(drop(model, {"low": [-1.0, -1.0], "high": [1.0, 1.0]}))
    y, _, b = pulled(drop(model, {"low": [-1.0, 0.0], "high": [1.0, 1.0]}, bottom={"kind": "wall"}, low=0.0))
    upper = x[1] > 0.0
    order, other = np.lexsort(np.round(x[:, upper], 6)), np.lexsort(np.round(y, 6))
    np.testing.assert_allclose(a[:, upper][:, order], b[:, other], atol=1e-9 * np.abs(a).max())
