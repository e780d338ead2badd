"""The numbers of the dam break with an obstacle, without its run."""

import numpy as np
import pytest

from ecume_validation import dam_break_obstacle as case
from ecume_validation.runner import sph_scene

instants = np.arange(0.0, 2.5, 1e-3)
"""s"""


def made(factor=1.0, late=0.0):
    """A run with the published peaks, arrivals and impulses, times a factor; later than in the experiment."""
    pressures = {}
    for name in (*case.FRONT, *case.TOP):
        pressure = np.where(instants > case.LATER[0], case.published("mean", name)[0, 1], 0.0)
        if name in case.FRONT:
            peak, arrival, impulse = (case.published(table, name)[0, 1] for table in ("peak", "arrival", "impulse"))
            hit = (instants >= arrival + late) & (instants < arrival + late + 0.01)
            rest = (instants >= arrival + late + 0.01) & (instants < case.IMPACT[1])
            pressure = pressure + peak * hit + (impulse - 0.01 * peak) / max(rest.sum() * 1e-3, 1e-3) * rest
        pressures[name] = factor * pressure
    levels = {name: np.interp(instants, *case.published("level", name).T) for name in case.LEVELS}
    return case.Struck(instants, pressures, instants, levels, 1.0)


def test_the_experiment_meets_itself():
    run = made()
    found = [*case.impact(run), *case.returning(run), *case.levels(run)]
    assert len(found) == 4 * 4 + 6 + 4
    assert [row.name for row in found if not row.met] == []


@pytest.mark.parametrize(("change", "what"), [({"factor": 1.6}, "peak"), ({"late": 0.05}, "arrival")])
def test_higher_peaks_and_later_fronts_are_seen(change, what):
    missed = {row.name[:2] for row in case.impact(made(**change)) if what in row.name and not row.met}
    assert missed == set(case.FRONT)


def test_the_scene_is_the_tank_of_the_experiment():
    scene = sph_scene(case.CASE)
    assert tuple(scene.tank.high) == (3.22, 1.0, 1.0)
    assert scene.fluid[0].high[1] == case.DEPTH
    assert {gauge.name for gauge in scene.gauges} == {*case.FRONT, *case.TOP, *case.LEVELS}
