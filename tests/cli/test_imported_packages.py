"""The packages that a verb imports. Where no step is integrated, it starts without the compiler."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ecume.scenes.templates import copy_template

PACKAGES = ("numba", "llvmlite", "scipy", "pint", "matplotlib", "gsd")
VERB = """
import sys
from ecume.cli import main
sys.argv = ["ecume", *sys.argv[1:]]
try:
    main()
finally:
    print("imported:", *[name for name in {packages} if name in sys.modules], file=sys.stderr)
"""
SHORT = {
    "cereal-bowl": ("duration=0.05", "frame_every=0.05"),
    "bouncing-particles": ("duration=0.1",),
    "small-tank": ("duration=0.002", "frame_every=0.001"),
    "t1": ("duration=0.02", "frame_every=0.01"),
}
"""A template of each model, and changes that make it end at once."""


def imported(folder: Path, *words: str) -> set[str]:
    """The packages that a verb has imported when it ends."""
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_DISABLE_JIT"}
    code = VERB.format(packages=PACKAGES)
    done = subprocess.run(
        [sys.executable, "-c", code, *words], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return set(done.stderr.rpartition("imported:")[2].split())


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a run of each model, made in plain Python."""
    folder = tmp_path_factory.mktemp("runs")
    for name, changes in SHORT.items():
        copy_template(name, folder / f"{name}.toml")
        words = [word for change in changes for word in ("--set", change)]
        command = [sys.executable, "-m", "ecume", "run", f"{name}.toml", "-o", name, *words]
        plain = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
        subprocess.run(command, cwd=folder, env=plain, check=True, capture_output=True, timeout=300)
    return folder


@pytest.mark.parametrize("name", SHORT)
def test_scenes_are_checked_without_the_compiler(name: str, runs: Path) -> None:
    assert imported(runs, "check", f"{name}.toml") <= {"scipy"}


@pytest.mark.parametrize("name", SHORT)
def test_a_run_is_printed_without_scipy(name: str, runs: Path) -> None:
    assert imported(runs, "info", name) <= {"gsd"}


def test_runs_are_listed_and_compared_without_the_compiler(runs: Path) -> None:
    assert imported(runs, "list") <= {"gsd"}
    assert not imported(runs, "compare", "cereal-bowl", "cereal-bowl") & {"numba", "matplotlib"}


def test_runs_are_exported_without_the_compiler(runs: Path) -> None:
    assert imported(runs, "export", "cereal-bowl", "--to", "csv", "-o", str(runs / "frames")) <= {"gsd"}


FIGURES = [("cereal-bowl", "energies"), ("bouncing-particles", "energies"), ("t1", "gaps")]


@pytest.mark.parametrize(("name", "figure"), FIGURES)
def test_runs_of_few_particles_are_drawn_without_the_compiler(name: str, figure: str, runs: Path) -> None:
    """Pictures of tanks are sums over all particles."""
    assert not imported(runs, "plot", name, "--what", figure, "-o", f"{name}.png") & {"numba", "pint"}
    assert not imported(runs, "movie", name, "-o", f"{name}.gif") & {"numba", "pint"}
    assert not imported(runs, "view", name, "--save", f"{name}.html") & {"numba", "pint"}
