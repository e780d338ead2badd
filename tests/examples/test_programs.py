"""The programs of the gallery run."""

import os
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"

pytestmark = pytest.mark.compiled


def printed(name, capsys):
    """The lines that a program prints."""
    runpy.run_path(str(EXAMPLES / name), run_name="__main__")
    return capsys.readouterr().out.splitlines()


def test_a_fountain_lifts_grains_and_injects_work(capsys):
    work = [float(line.rpartition("work ")[2].split()[0]) for line in printed("actions.py", capsys)]
    assert len(work) == 7
    assert work[1] < 0.0 < work[2] < work[4] < work[6]


@pytest.mark.long
def test_laws_for_two_models_in_one_program():
    """As plain Python: the models' own tests compile a user's laws."""
    plain = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    words = [sys.executable, str(EXAMPLES / "own_laws.py")]
    lines = subprocess.run(words, env=plain, capture_output=True, text=True, check=True).stdout.splitlines()
    assert [line.split(":")[0] for line in lines] == ["repulsion"] * 5 + ["trap"] * 5
    energies = [float(line.partition("energy ")[2].split()[0]) for line in lines[:5]]
    assert energies == sorted(energies, reverse=True)
