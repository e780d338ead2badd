"""The memory that `check` says of a tank is what its run takes."""

import subprocess
import sys
from pathlib import Path

import pytest

import ecume
from ecume.models.sph.record import bytes_per_particle

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


@pytest.mark.compiled
@pytest.mark.long
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the largest memory is read from /proc")
@pytest.mark.parametrize("template", SIZES)
def test_memory_per_particle_is_measured(template, tmp_path):
    """The difference of two sizes, within 15 %: what Python and compiled code take is the same in both."""
    overrides = ['duration="1 ms"', 'frame_every="1 ms"']
    points = []
    for spacing in SIZES[template]:
        words = [str(TEMPLATES / f"{template}.toml"), str(tmp_path / "run"), *overrides, f'spacing="{spacing}"']
        for _ in range(2):  # the first may compile: many particles have loops of their own
            done = subprocess.run([sys.executable, "-c", PEAK, *words], capture_output=True, text=True, check=True)
        points.append([int(word) for word in done.stdout.split()])
    (few, less), (many, more) = points
    expected = bytes_per_particle(ecume.load_scene(TEMPLATES / f"{template}.toml"))
    assert (more - less) / (many - few) == pytest.approx(expected, rel=0.15)
