"""The numbers of the tank that rolls, without its run."""

import numpy as np

from ecume_validation import rolling_tank as case
from ecume_validation.runner import read_table, sph_scene

instants = np.arange(0.0, 7.5, 5e-4)
"""s"""


def made(factor=1.0, period=case.PERIOD):
    """A run with the measured mean peaks, times a factor, 5 ms long each."""
    pressure = np.zeros_like(instants)
    for number, line in enumerate(read_table(case.CASE)):
        hit = np.abs(instants - 2.3 - number * period) < 2.5e-3
        pressure[hit] = factor * float(line["mean"])
    return case.Struck(instants, pressure, 1.0)


def missed(run):
    return [row.name for row in case.rows_of(run) if not row.met]


def test_the_experiment_meets_itself_and_other_runs_miss():
    assert missed(made()) == []
    assert len([name for name in missed(made(1.9)) if "peak" in name]) == 4
    assert missed(made(period=1.7)) == ["time between impacts (s)"]
    assert missed(made()._replace(left=0.99)) == ["particles left"]


def test_the_scene_is_the_tank_of_the_experiment():
    scene = sph_scene(case.CASE)
    assert tuple(scene.tank.high) == (0.9, 0.508)
    assert scene.fluid[0].high[1] == scene.gauges[0].position[1] == 0.093
    assert abs(scene.roll.frequency * case.PERIOD - 1.0) < 1e-3
    assert abs(np.degrees(scene.roll.amplitude) - 4.0) < 1e-12
