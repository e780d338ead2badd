"""Confined flows and drops, short and coarse; `ecume validate` holds the long ones against published numbers."""

import math

import numpy as np
import pytest

import ecume
from ecume.laws import flows
from ecume.scenes.schema import from_plain
from tests.models.sph.scenes import PERIODIC

AROUND = dict.fromkeys(("left", "right", "bottom", "top"), PERIODIC)
VISCOSITY = 0.01


def scene(**changes):
    return from_plain(
        {
            "model": "sph",
            "duration": 0.5,
            "frame_every": 0.5,
            "spacing": 0.05,
            "gravity": [0.0, 0.0],
            "liquid": {"density": 1.0, "sound_speed": 10.0, "fastest": 1.0, "viscosity": VISCOSITY},
            "tank": {"low": [0.0, 0.0], "high": [1.0, 1.0], **AROUND},
            "fluid": [{"low": [0.0, 0.0], "high": [1.0, 1.0]}],
            "method": {"jitter": 0.1, "shifting": "delta-plus"},
            **changes,
        }
    )


def vortices(**method):
    return scene(
        fluid=[{"low": [0.0, 0.0], "high": [1.0, 1.0], "flow": "taylor-green"}],
        method={"jitter": 0.1, **method},
    )


def last_of(case):
    (*_, last) = ecume.simulate(case)
    return last


@pytest.mark.parametrize("method", [{"shifting": "delta-plus"}, {"pressure_force": "transport"}])
def test_vortices_fade_as_they_should(method):
    last = last_of(vortices(**method))
    faded = math.exp(-flows.taylor_green_decay(2.0 * math.pi, 2.0 * math.pi, VISCOSITY) * last.time)
    x, y = 2.0 * math.pi * last.arrays["position"].T
    exact = faded * np.hypot(flows.taylor_green_velocity(x, y, 1.0), flows.taylor_green_velocity(y, x, -1.0))
    speed = np.hypot(*last.arrays["velocity"].T)
    assert np.abs(speed - exact).mean() < 0.03 * exact.mean()
    assert speed.max() == pytest.approx(faded, rel=0.03)
    assert last.numbers["kinetic_energy"] == pytest.approx(0.25 * faded**2, rel=0.04)


def test_vortices_start_with_the_pressure_that_keeps_them():
    first = next(iter(ecume.simulate(vortices())))
    x, y = 2.0 * math.pi * first.arrays["position"].T
    exact = flows.taylor_green_pressure(x, y, 1.0, 1.0, 1.0)
    np.testing.assert_allclose(first.arrays["pressure"], exact, atol=2e-3)


def test_shifting_keeps_the_volume():
    still = last_of(vortices(shifting="delta-plus"))
    assert still.numbers["volume"] == pytest.approx(1.0, abs=2e-3)
    assert np.abs(still.arrays["velocity"].mean(axis=0)).max() < 1e-3
