"""The packages that a verb imports. Where no step is integrated, it starts without the compiler."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ecume.scenes.templates import copy_template

PACKAGES = ("numba", "llvmlite", "scipy", "pint", "matplotlib", "gsd")
VERB = """
import json, sys
from ecume.cli import main
for words in json.loads(sys.argv[1]):
    sys.argv = ["ecume", *words]
    try:
        main()
    except SystemExit as end:
        assert not end.code, (words, end.code)
    print("imported:", *[name for name in {packages} if name in sys.modules], file=sys.stderr)
"""
SHORT = {
    "cereal-bowl": ("duration=0.05", "frame_every=0.05"),
    "bouncing-particles": ("duration=0.1",),
    "small-tank": ("duration=0.002", "frame_every=0.001"),
    "t1": ("duration=0.02", "frame_every=0.01"),
}
"""A template of each model, and changes that make it end at once."""


def imported(folder: Path, *commands: tuple[str, ...], **variables: str) -> set[str]:
    """The packages that verbs have imported when the last of them ends, in a single process."""
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_DISABLE_JIT"} | variables
    code = VERB.format(packages=PACKAGES)
    done = subprocess.run(
        [sys.executable, "-c", code, json.dumps(commands)],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return set(done.stderr.rpartition("imported:")[2].split())


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a run of each model, made in plain Python."""
    folder = tmp_path_factory.mktemp("runs")
    commands = []
    for name, changes in SHORT.items():
        copy_template(name, folder / f"{name}.toml")
        words = [word for change in changes for word in ("--set", change)]
        commands.append(("run", f"{name}.toml", "-o", name, *words))
    imported(folder, *commands, NUMBA_DISABLE_JIT="1")
    return folder


@pytest.mark.long
def test_scenes_are_checked_without_the_compiler(runs: Path) -> None:
    assert imported(runs, *(("check", f"{name}.toml") for name in SHORT)) <= {"scipy"}


@pytest.mark.long
def test_runs_are_printed_listed_and_exported_without_scipy(runs: Path) -> None:
    export = "export", "cereal-bowl", "--to", "csv", "-o", str(runs / "frames")
    assert imported(runs, *(("info", name) for name in SHORT), ("list",), export) <= {"gsd"}


def test_runs_are_compared_without_the_compiler(runs: Path) -> None:
    assert not imported(runs, ("compare", "cereal-bowl", "cereal-bowl")) & {"numba", "matplotlib"}


FIGURES = {"cereal-bowl": "energies", "bouncing-particles": "energies", "t1": "gaps"}


@pytest.mark.long
def test_runs_of_few_particles_are_drawn_without_the_compiler(runs: Path) -> None:
    """Pictures of tanks are sums over all particles."""
    commands = [
        words
        for name, figure in FIGURES.items()
        for words in (
            ("plot", name, "--what", figure, "-o", f"{name}.png"),
            ("movie", name, "-o", f"{name}.gif"),
            ("view", name, "--save", f"{name}.html"),
        )
    ]
    assert not imported(runs, *commands) & {"numba", "pint"}
