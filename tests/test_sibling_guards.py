"""A guard stands on each path, not on one of two: the places that decode what others wrote, or let others in."""

from __future__ import annotations

import ast
import os
from collections.abc import Callable
from pathlib import Path

import pytest

import ecume
from ecume.errors import SceneError
from ecume.scenes.load import load_scene
from ecume.scenes.schema import from_plain
from ecume.scenes.valid_part import load_and_examine
from ecume.sweep.spec import load_sweep
from tests.sources import source_files

PACKAGE = Path(ecume.__file__).parent
DECODERS = {"tomllib.loads", "json.loads", "pickle.loads", "marshal.loads", "np.load", "np.fromfile"}
DOORS = {"LocalCluster", "Client", "SLURMCluster", "ThreadingHTTPServer", "HTTPServer"}
REVIEWED = {
    "_cache.py": {"json.loads": "the manifest of shipped code, which the owner of the installation wrote"},
    "_parts.py": {"pickle.loads": "compiled code whose file and folders belong to the user alone"},
    "../ecume_lammps/rank.py": {"json.loads": "a scene that the starting process wrote into its own folder"},
    "models/field_files.py": {"np.load": "a user's archive of velocities, without pickles, after its kind"},
    "scenes/faults.py": {"tomllib.loads": "one value after `--set`, its keys bounded before"},
    "scenes/overrides.py": {"tomllib.loads": "one value of `--set`, its length and keys bounded before"},
    "scenes/toml.py": {"tomllib.loads": "all texts of scenes: depth and keys are bounded before"},
    "show/play/pages.py": {"json.loads": "a request with a token, of bounded size"},
    "trajectories/gsd.py": {"json.loads": "a chunk with a checksum, of bounded size"},
    "trajectories/records.py": {"json.loads": "all records of runs and sweeps, of bounded size"},
    "made_from.py": {"json.loads": "our own records", "tomllib.loads": "our own scenes"},
    "../ecume_validation/runner.py": {"json.loads": "our own records"},
}
"""Where bytes that somebody else may have written are decoded, and why it is safe there."""


def calls(tree: ast.AST, wanted: set[str]) -> set[str]:
    """The names among these that are called."""
    called = (node.func for node in ast.walk(tree) if isinstance(node, ast.Call))
    return {ast.unparse(function) for function in called if isinstance(function, ast.Name | ast.Attribute)} & wanted


def found_in(wanted: set[str]) -> dict[str, set[str]]:
    """Of each file, or folder of our own records, what it calls."""
    found: dict[str, set[str]] = {}
    for path in source_files():
        name = Path(os.path.relpath(path, PACKAGE)).as_posix()
        found[name] = calls(ast.parse(path.read_text(encoding="utf-8")), wanted)
    return {name: used for name, used in found.items() if used}


def test_each_place_that_decodes_was_reviewed() -> None:
    assert found_in(DECODERS) == {name: set(reasons) for name, reasons in REVIEWED.items()}


def test_each_door_is_opened_in_one_place() -> None:
    """Workers of this machine and of a cluster, pages and games: encryption and tokens are theirs to ask for there."""
    doors = {name for name, _ in found_in({f"distributed.{door}" for door in DOORS} | DOORS).items()}
    assert doors <= {"sweep/executors.py", "show/serving.py", "show/play/pages.py"}


def test_the_walk_finds_a_decoder() -> None:
    assert calls(ast.parse("def f(x):\n  return [json.loads(y) for y in x]"), DECODERS) == {"json.loads"}


DEEP = ".".join("a" * 500) + " = 1\n"
SCENE = 'model = "floating"\nduration = "1 s"\nframe_every = "0.1 s"\n'
READERS: dict[str, Callable[[Path], object]] = {
    "a scene": lambda folder: load_scene(SCENE + DEEP),
    "a scene that is examined": lambda folder: load_and_examine(SCENE + DEEP, [], lambda scene: None),
    "an override": lambda folder: load_scene(SCENE, [DEEP.strip()]),
    "a plain scene": lambda folder: from_plain(nested(500)),
    "an override of a scene that is examined": lambda folder: load_and_examine(
        SCENE, [DEEP.strip()], lambda scene: None
    ),
    "a sweep": lambda folder: load_sweep(written(folder, f'scene = "a.toml"\n{DEEP}')),
}


def nested(depth: int) -> dict[str, object]:
    """Tables in tables, beside the keys of a scene."""
    table: dict[str, object] = {"a": 1}
    for _ in range(depth):
        table = {"a": table}
    return {"model": "floating", "duration": 1.0, "frame_every": 0.1, **table}


def written(folder: Path, text: str) -> Path:
    """A sweep's file."""
    (folder / "sweep.toml").write_text(text, encoding="utf-8")
    return folder / "sweep.toml"


@pytest.mark.parametrize("way", READERS)
def test_a_deep_key_is_refused_whichever_way_it_comes(way: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError):
        READERS[way](tmp_path)
