"""Every script runs in its small size: benchmarks with the installed packages, figures, clips, studies."""

import importlib
import os
import re
import subprocess
import sys

import pytest
from tests.docs.forked_scripts import ROOT, Scripts

from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder

MAIN = 'if __name__ == "__main__":'
PARTS = 8
"""Processes that draw the figures, one after the other."""
SHELL = {
    "audit": None,  # asks the package index
    "demo": "--help",
    "docs": None,  # .ci/run builds the documentation
    "environment.sh": None,  # read by the others
    "lock": None,  # asks the package index
    "mutate": "list",
    "processors": "--help",
    "slurm-trial": "",  # says that there is no SLURM
    "test": None,  # runs this
    "torture": "--help",
    "versions": "--help",
    "web": "--help",
    "wheels": None,  # .ci/run builds one
}
"""What a script is called with; None where it cannot be called here."""


forks = pytest.mark.skipif(not hasattr(os, "fork"), reason="Windows forks no processes")


def is_script(path):
    return MAIN in path.read_text(encoding="utf-8")


PYTHON = sorted(path for folder in ("benchmarks", "docs", "docs/studies") for path in (ROOT / folder).glob("*.py"))
SCRIPTS = {path.relative_to(ROOT).as_posix() for path in PYTHON if is_script(path)}
SOME = {"docs/figures.py": ["equilibrium"], "docs/clips.py": ["t1", "bouncing-tracers"]}
"""What is asked of scripts that have more to do: all figures have tests of their own, and clips take a minute."""
DRAWN = """
import sys
sys.argv = ["figures.py", "--quick"]
sys.path.insert(0, "docs")
import figures
names = list(figures.FIGURES)
figures.main(names[len(names) * {part} // {parts} : len(names) * ({part} + 1) // {parts}])
"""
"""Neighbors, which compile the same, by one process."""


@pytest.fixture(scope="module")
def scripts(tmp_path_factory):
    """A function that runs scripts."""
    started = Scripts(tmp_path_factory.mktemp("scripts"))
    yield started
    started.close()


def ended_well(done):
    assert done.returncode == 0, f"{done.stdout[-2000:]}\n{done.stderr[-4000:]}"


def in_a_shell(*words):
    ended_well(subprocess.run(
        ["sh", *words], cwd=ROOT, capture_output=True, text=True, timeout=280, stdin=subprocess.DEVNULL, check=False
    ))  # fmt: skip


def test_what_is_no_script_is_part_of_one():
    everything = {
        path: path.read_text(encoding="utf-8") for path in (*PYTHON, *(ROOT / "benchmarks/peers").glob("*.py"))
    }
    for path in everything:
        if path.relative_to(ROOT).as_posix() not in SCRIPTS:
            uses = rf'(^(from|import) {path.stem}\b|"{path.name}"|    import {path.stem}$)'
            assert [each for each, text in everything.items() if each != path and re.search(uses, text, re.M)], path


def test_every_shell_script_is_known_and_can_be_read():
    assert {path.name for path in (ROOT / "scripts").iterdir()} == set(SHELL)
    for name in SHELL:
        in_a_shell("-n", f"scripts/{name}")
    for name in ("docs", "test", "wheels"):
        assert f"scripts/{name}" in (ROOT / ".ci" / "run").read_text(encoding="utf-8")


@pytest.mark.long
@pytest.mark.parametrize("name", sorted(name for name, words in SHELL.items() if words is not None))
def test_a_shell_script_runs(name):
    if "environment.sh" in (ROOT / "scripts" / name).read_text(encoding="utf-8") and not (ROOT / ".venv").is_dir():
        pytest.skip("scripts/test has made no environment here")
    in_a_shell(f"scripts/{name}", *SHELL[name].split())


@pytest.mark.parametrize("name", sorted(SCRIPTS))
def test_a_script_has_a_small_size(name):
    assert "parser_of(__doc__)" in (ROOT / name).read_text(encoding="utf-8")


@forks
@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("name", sorted(SCRIPTS))
def test_a_script_runs(scripts, name):
    ended_well(scripts.run(name, "--quick", *SOME.get(name, [])))


@forks
@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("part", range(PARTS))
def test_figures_are_drawn(scripts, part):
    ended_well(scripts.run("-c", DRAWN.format(part=part, parts=PARTS)))


@pytest.fixture
def benchmark(monkeypatch):
    """A function that imports a script of the benchmarks."""
    monkeypatch.syspath_prepend(ROOT / "benchmarks")
    return importlib.import_module


def test_a_peer_that_fails_is_an_error(benchmark, tmp_path, monkeypatch, capsys):
    broken = tmp_path / "lammps" / "bin" / "python"
    broken.parent.mkdir(parents=True)
    broken.write_text("#!/bin/sh\nexit 3\n")
    broken.chmod(0o755)
    peers = benchmark("sph_peers")
    monkeypatch.setattr(peers, "PEERS", [peer._replace(ranks=False) for peer in peers.PEERS if peer.name[0] == "L"])
    monkeypatch.setattr(peers, "require_same_equations", lambda: None)
    monkeypatch.setattr(peers, "peak_of_a_core", lambda: {"float64": 1e9})
    monkeypatch.setattr(sys, "argv", ["sph_peers.py", str(tmp_path), "--edge", "4", "--steps", "5", "--rounds", "1"])
    assert peers.main() == 1
    assert "ended with 3" in capsys.readouterr().out


def test_the_scenes_of_versions_can_be_read(benchmark):
    """Only one of them is run here."""
    for template, changes in benchmark("versions").CASES.values():
        assert load_scene(folder() / f"{template}.toml", changes).model
