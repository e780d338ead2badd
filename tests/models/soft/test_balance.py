"""Forces of many spheres balance at every accepted step, not only at the last."""

import numpy as np
import pytest

from ecume.models.soft import SOFT
from ecume.models.soft.contacts.contact_list import update_contact_list
from ecume.models.soft.integration.time_stepping import one_step
from ecume.models.soft.state import FORCE_RESIDUAL
from tests.models import begun

from .test_packings import packing

pytestmark = pytest.mark.compiled


@pytest.mark.long
@pytest.mark.parametrize("drag", [True, False])
def test_what_is_left_on_a_thousand_sheared_spheres_is_below_1e_8_of_the_typical_force(drag):
    scene = packing(count=500, filled=0.8, strain=0.5, hydrodynamics={"drag": "stokes" if drag else "none"})
    parameters, state, scratch = begun(scene)
    left = []
    for _ in range(20):
        assert one_step(parameters, state, scratch) is not None
        force = np.linalg.norm(scratch.step.responses.force, axis=1)
        left.append(np.abs(scratch.step.bodies.right).max() / np.sqrt((force**2).mean()))
        assert state.pace[FORCE_RESIDUAL] == pytest.approx(left[-1], rel=1e-12)
        if update_contact_list(parameters, state):
            scratch = SOFT.workspace(parameters, state, 1.0)
    # Also at the first of them, where contacts have only begun to bear anything.
    assert 0.0 < max(left) < 1e-8
