"""The hydrostatic part of the pressure: added where it is missing, refused where it is there already."""

import numpy as np
import pytest

import ecume
from ecume.errors import SceneError
from ecume.models.sph.record import SPH
from tests.models.sph.scenes import tank


def closed(**method):
    import dataclasses

    scene = tank(jitter=0.0, **method)
    sides = dataclasses.replace(scene.tank, high=(1.0, 1.0), top=scene.tank.bottom)
    return dataclasses.replace(scene, tank=sides)


@pytest.mark.parametrize(("split", "reason"), [("original", "counts it twice"), ("modified", "surface")])
def test_a_split_that_is_wrong_is_refused_with_the_reason(split, reason):
    with pytest.raises(SceneError) as refused:
        SPH.parameters(tank(pressure_split=split))
    (fault,) = refused.value.faults
    assert fault.path == "method.pressure_split"
    assert reason in fault.message


def test_a_full_closed_tank_may_leave_gravity_out_and_reads_the_same_pressure():
    first = next(ecume.simulate(closed(pressure_split="modified")))
    depth = 1.0 - first.arrays["position"][:, 1]
    np.testing.assert_allclose(first.arrays["pressure"], depth, rtol=1e-9)


def test_the_original_reads_twice_the_pressure_when_it_is_let_run():
    scene = tank(jitter=0.0, pressure_split="original", allow_invalid_split=True)
    first = next(ecume.simulate(scene))
    depth = 1.0 - first.arrays["position"][:, 1]
    np.testing.assert_allclose(first.arrays["pressure"], 2.0 * depth, rtol=0.01)
