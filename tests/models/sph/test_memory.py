"""The memory that `check` says of a tank is what its run takes."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import ecume
from ecume.models.sph.rates.right_hand_side import fill
from ecume.models.sph.record import SPH, WHILE_OBSERVED, bytes_of_arrays, bytes_per_particle
from ecume.models.sph.state import FIRST_SKIN

TEMPLATES = Path(ecume.__file__).parent / "templates"
PEAK = """
import sys
from pathlib import Path
import ecume
from ecume.run import RunOptions, run
scene = ecume.load_scene(sys.argv[1], sys.argv[3:])
run(scene, sys.argv[2], force=True, options=RunOptions(threads=1))
frame = ecume.open_trajectory(sys.argv[2])[0]
largest = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
print(len(frame.arrays["position"]), 1024 * int(largest.split()[1]))
"""
"""Not `ru_maxrss`: it counts the process that started this one, whose memory it had until it was replaced."""
SIZES = {"dam-break": ("4 mm", "1.4 mm"), "dam-break-3d": ("20 mm", "6 mm")}


def in_use(array):
    """The bytes of the rows of an array that are not zero: zeros that were never written take no memory."""
    return sum(row.nbytes for row in np.atleast_2d(array) if row.any())


@pytest.mark.compiled
@pytest.mark.parametrize(("template", "spacing"), [("dam-break", "7.5 mm"), ("dam-break-3d", "20 mm")])
def test_check_counts_the_arrays_of_a_tank(template, spacing):
    """State, tables and lists after the first evaluation, positions while lists are made, and the frame."""
    scene = ecume.load_scene(TEMPLATES / f"{template}.toml", [f'spacing="{spacing}"'])
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    state.velocity[...] = state.acceleration[...] = state.density_rate[...] = 1.0
    state.skin[0] = FIRST_SKIN * parameters.support
    tank = SPH.workspace(parameters, state, 1.0)
    fill(parameters, state, tank)
    of_state = sum(in_use(array) for array in state if array.size >= len(state.mass))
    of_sums = len(state.mass) * 8 * (parameters.dimension + 2) + tank.records.nbytes
    row = np.quantile(np.diff(tank.lists.start), 0.9)  # in the interior; rows at the surface are shorter
    lists = tank.lists.counts.nbytes + tank.lists.start.nbytes + 4.0 * row * len(state.mass)
    made = (2 * 8 * parameters.dimension + 2 * 4) * tank.fields.shape[1]
    frame = SPH.observe(parameters, state, tank)
    recorded = sum(array.nbytes for array in frame.arrays.values()) + 8 * WHILE_OBSERVED * len(state.mass)
    found = of_state + in_use(tank.fields.table) + of_sums + lists + made + recorded
    assert found / len(state.mass) == pytest.approx(bytes_of_arrays(scene), rel=0.1)


@pytest.mark.compiled
@pytest.mark.long
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the largest memory is read from /proc")
@pytest.mark.parametrize("template", SIZES)
def test_memory_per_particle_is_measured(template, tmp_path):
    """The difference of two sizes, within 15 %: what Python and compiled code take is the same in both."""
    overrides = ['duration="1 ms"', 'frame_every="1 ms"']
    points, expected = [], []
    for spacing in SIZES[template]:
        words = [str(TEMPLATES / f"{template}.toml"), str(tmp_path / "run"), *overrides, f'spacing="{spacing}"']
        for _ in range(2):  # the first may compile: many particles have loops of their own
            done = subprocess.run([sys.executable, "-c", PEAK, *words], capture_output=True, text=True, check=True)
        points.append([int(word) for word in done.stdout.split()])
        expected.append(points[-1][0] * bytes_per_particle(ecume.load_scene(words[0], [words[-1]])))
    (_, less), (_, more) = points
    assert more - less == pytest.approx(expected[1] - expected[0], rel=0.15)
