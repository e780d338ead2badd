"""A run on many ranks is the run of one, byte for byte, however it is interrupted."""

from __future__ import annotations

import importlib.util
import os
import signal
import subprocess
import sys
import time
from importlib.resources import files
from pathlib import Path

import psutil
import pytest

LAUNCHER = Path(sys.executable).parent / "mpiexec.gforker"
with_ranks = pytest.mark.skipif(
    importlib.util.find_spec("mpi4py") is None or not LAUNCHER.exists(), reason="needs the extra `mpi`"
)

BOWL = """
model = "floating"
duration = "{duration}"
frame_every = "10 ms"
seed = 3
[liquid]
viscosity = "1 mPa*s"
[integration]
time_step = "2 ms"
[interaction]
accuracy = 1e-2
[[particles]]
count = 8
radius = "1 mm"
density = 1200
contact_angle = "90 deg"
[dish]
radius = "1.5 cm"
"""
# Interpreted: the same loops, and nothing to compile in each process.
PLAIN = {**os.environ, "NUMBA_DISABLE_JIT": "1"}


def words(*verb: str) -> list[str]:
    """A command line."""
    return [sys.executable, "-m", "ecume", *verb]


def ended(folder: Path, *verb: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """What became of a command."""
    return subprocess.run(
        words(*verb),
        cwd=folder,
        env={**PLAIN, **environment},
        capture_output=True,
        text=True,
        timeout=200,
        check=False,
    )


def bits(home: Path) -> dict[str, bytes]:
    """What a run has computed."""
    return {path.name: path.read_bytes() for path in [*(home / "traj").iterdir(), home / "scalars.jsonl"]}


@pytest.mark.long
@with_ranks
@pytest.mark.compiled
def test_a_run_stopped_on_two_ranks_and_resumed_on_one_is_that_of_one_process(tmp_path: Path) -> None:
    (tmp_path / "bowl.toml").write_text(BOWL.format(duration="0.2 s"), encoding="utf-8")
    assert ended(tmp_path, "run", "bowl.toml", "-o", "one").returncode == 0
    with subprocess.Popen(
        words("run", "bowl.toml", "-o", "many", "--engine", "mpi", "--ranks", "2"), cwd=tmp_path, env=PLAIN
    ) as run:
        lines, patience = tmp_path / "many" / "scalars.jsonl", time.monotonic() + 100
        while run.poll() is None and time.monotonic() < patience and not (lines.exists() and lines.read_bytes()):
            time.sleep(0.01)
        ranks = [each for each in psutil.Process(run.pid).children(recursive=True) if "python" in each.name()]
        assert len(ranks) == 2
        heard = [line for each in ranks for line in each.net_connections(kind="inet")]
        assert not heard, "ranks of one machine listen on no network"
        run.send_signal(signal.SIGINT)
        assert run.wait(100) == 75
    again = ended(tmp_path, "resume", "many", "--engine", "mpi", "--ranks", "1")
    assert again.returncode == 0, again.stderr
    assert bits(tmp_path / "many") == bits(tmp_path / "one")


@with_ranks
@pytest.mark.compiled
def test_a_model_that_is_not_spread_is_refused_once_by_all_ranks(tmp_path: Path) -> None:
    scene = str(files("ecume") / "templates" / "t1.toml")
    output = ended(tmp_path, "run", scene, "--engine", "mpi")
    assert output.returncode == 2
    assert output.stderr == "ecume: --engine mpi: goes with the models 'floating' and 'sph', and not with 'soft'\n"
    assert not (tmp_path / "runs").exists()


def test_the_extra_is_asked_for_where_it_is_missing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from ecume.cli import mpi_launcher
    from ecume.errors import BadInput

    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    with pytest.raises(BadInput, match=r"pip install 'mpi4py.* 'mpich"):
        mpi_launcher.launcher()


@pytest.mark.parametrize(
    ("asked", "output"), [(("many", None), "expected one of local, mpi"), (("local", 3), "goes with --engine mpi")]
)
def test_engines_that_are_not_there_are_refused(asked: tuple[str, int | None], output: str) -> None:
    from ecume.cli.mpi_launcher import integrating
    from ecume.errors import BadInput

    with pytest.raises(BadInput, match=output), integrating(*asked):
        pass
