"""Shapes that enclose nothing, and flows that fit nowhere, are refused with one line."""

import math
import random

import pytest

from ecume.errors import BadInput, SceneError
from ecume.laws.water_waves import standing_wave_velocity
from ecume.models.sph.record import SPH
from ecume.scenes.schema import from_plain
from tests.contracts.effects import merged
from tests.contracts.effects.sph import BASE

WAVE = {"flow": "standing-wave"}
NO_BOX = {"low": None, "high": None}


def body(high):
    """A box from (0.3, 0.6) to this corner."""
    return {"bodies": [{"low": [0.3, 0.6], "high": high, "density": 0.5}]}


@pytest.mark.parametrize(
    ("change", "path"),
    [
        ({"fluid": [{"velocity_gradient": [[1.0, 0.0], [0.0]]}]}, "fluid[0].velocity_gradient"),
        ({"fluid": [{"low": [0.2, 0.2], "high": [0.2, 0.2]}]}, "fluid[0].high"),
        ({"fluid": [{"low": [0.2, 0.5], "high": [0.4, 0.4]}]}, "fluid[0].high"),
        (
            {
                "fluid": [{**WAVE, "high": [1.0, -0.5], "low": [0.0, -0.75]}],
                "liquid": {"sound_speed": None, "maximum_speed": None},
            },
            "fluid.flow",
        ),
        ({"fluid": [{**NO_BOX, "vertices": [[0, 0], [0.5, 0.5], [1, 1]]}]}, "fluid[0].vertices"),
        (body([0.7, 0.6 + 3.6e-7]), "bodies[0]"),
        (body([0.7, 0.6]), "bodies[0].high"),
        ({"obstacles": [{"low": [0.3, 0.2], "high": [0.2, 0.3]}]}, "obstacles[0].high"),
        ({"passive_tracers": [{"count": 3, "low": [0.5, 0.3], "high": [0.2, 0.4]}]}, "passive_tracers[0].high"),
        ({"tank": {"high": [1e-12, 1.0]}}, "tank.high"),
    ],
)
def test_what_encloses_nothing_is_refused(change, path):
    with pytest.raises(SceneError) as refused:
        SPH.parameters(from_plain(merged(BASE, change)))
    assert path in [fault.path for fault in refused.value.faults]


def test_random_boxes_run_or_are_refused():
    """Boxes of any extent, also none or negative, never end in another exception."""
    dice = random.Random(4)
    outcomes = set()
    for _ in range(60):
        low = [dice.uniform(0.0, 0.5) for _ in range(2)]
        high = [a + dice.choice([0.0, -0.1, 1e-9, 1e-3, 0.3]) for a in low]
        table = dice.choice(["fluid", "bodies", "obstacles"])
        change = {table: [{"low": low, "high": high, **({"density": 0.5} if table == "bodies" else {})}]}
        try:
            scene = from_plain(merged(BASE, change))
            SPH.summary(scene)
            SPH.start(scene, SPH.parameters(scene))
            outcomes.add("runs")
        except SceneError:
            outcomes.add("refused")
    assert outcomes == {"runs", "refused"}


def test_a_standing_wave_in_deep_water_falls_off_exponentially():
    depth, k = 500.0, math.pi
    for height in (499.0, 499.9, 500.0):
        along, up = standing_wave_velocity(0.25, height, wavenumber=k, depth=depth, speed=2.0)
        decay = 2.0 * math.exp(k * (height - depth))
        assert along == pytest.approx(-decay * math.sin(0.25 * k), rel=1e-12)
        assert up == pytest.approx(decay * math.cos(0.25 * k), rel=1e-12)
    assert standing_wave_velocity(0.25, 0.0, wavenumber=k, depth=depth, speed=2.0)[1] == 0.0


def test_a_standing_wave_in_shallow_water_is_that_of_hyperbolic_functions():
    along, up = standing_wave_velocity(0.3, 0.2, wavenumber=2.0, depth=0.5, speed=0.1)
    assert along == pytest.approx(-0.1 * math.sin(0.6) * math.cosh(0.4) / math.sinh(1.0), rel=1e-14)
    assert up == pytest.approx(0.1 * math.cos(0.6) * math.sinh(0.4) / math.sinh(1.0), rel=1e-14)


@pytest.mark.parametrize("depth", [0.0, -0.5])
def test_a_wave_needs_depth(depth):
    with pytest.raises(BadInput):
        standing_wave_velocity(0.3, 0.2, wavenumber=2.0, depth=depth, speed=0.1)
