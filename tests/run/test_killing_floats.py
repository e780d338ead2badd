"""Cereals that are killed at any moment end up where they would have been, to the last bit."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ecume.run import info, resume, run
from ecume.scenes.load import load_scene
from ecume.trajectories.reader import open_trajectory

pytestmark = [
    pytest.mark.compiled,
    pytest.mark.skipif(os.name == "nt", reason="Windows knows no SIGKILL"),
]

BOWL = """
model = "floating"
duration = "20 s"
frame_every = "50 ms"
seed = 4
[liquid]
viscosity = "2 mPa*s"
[[particles]]
count = 40
radius = "1.5 mm"
density = 600
contact_angle = "70 deg"
[dish]
radius = "2.5 cm"
"""
OFTEN = "import sys, ecume.run as r; options = r.RunOptions(checkpoint_every=0.02); "
RUN = OFTEN + "from ecume.scenes.load import load_scene; r.run(load_scene(sys.argv[2]), sys.argv[1], options=options)"
RESUME = OFTEN + "r.resume(sys.argv[1], options=options)"


def killed(program: str, home: Path, after: float) -> None:
    """Start a program that works on a run; kill it that long after it has added something."""
    lines = home / "scalars.jsonl"
    before, patience = lines.read_bytes() if lines.exists() else b"", time.monotonic() + 200
    with subprocess.Popen([sys.executable, "-c", program, str(home), BOWL]) as process:
        while process.poll() is None and time.monotonic() < patience:
            if lines.exists() and lines.read_bytes() not in (b"", before):
                time.sleep(after)
                break
            time.sleep(0.005)
        process.send_signal(signal.SIGKILL)


@pytest.mark.long
def test_floats_killed_twice_at_random_moments_come_to_the_same_bits(
    tmp_path: Path, results: Callable[[Path], dict[str, bytes]]
) -> None:
    # Compiles what the other processes will load.
    run(load_scene(BOWL), tmp_path / "left alone")
    moments = [random.uniform(0.0, 0.4) for _ in range(2)]
    killed(RUN, tmp_path / "killed", moments[0])
    seen = info(tmp_path / "killed")
    assert (seen.state, 0 < seen.frames < 401) == ("killed", True), moments
    killed(RESUME, tmp_path / "killed", moments[1])
    resume(tmp_path / "killed")
    with open_trajectory(tmp_path / "killed") as here, open_trajectory(tmp_path / "left alone") as there:
        assert len(here) == len(there) == 401
        for one, other in zip(here, there, strict=True):
            assert one.numbers == other.numbers, moments
            for name, array in one.arrays.items():
                np.testing.assert_array_equal(array, other.arrays[name], strict=True, err_msg=f"{moments}")
    assert results(tmp_path / "killed") == results(tmp_path / "left alone"), moments
