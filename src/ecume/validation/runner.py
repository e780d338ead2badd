"""The scenes, tables and runs of validation cases; scenes and tables are in `data/CASE`.

Long cases keep the numbers of each finished run, a piece, in a folder of the working directory. A piece is named by
the digest of its scene: an interrupted case continues with the pieces that are missing.
"""

from __future__ import annotations

import csv
import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from ecume.scenes.floating import FloatingScene
from ecume.scenes.load import load_scene
from ecume.scenes.schema import Scene, to_plain
from ecume.scenes.sph import SphScene
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame

DATA = Path(__file__).parent / "data"


def read_table(case: str, name: str = "published") -> list[dict[str, str]]:
    """The rows of a CSV file of a case, each as a dictionary of its columns."""
    with (DATA / case / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def case_scene(case: str, changes: Sequence[str] = (), name: str = "scene") -> Scene:
    """The scene of a case, with some of its values changed as by `--set`."""
    return load_scene(DATA / case / f"{name}.toml", changes)


def floating_scene(case: str, changes: Sequence[str] = (), name: str = "scene") -> FloatingScene:
    """The scene of a case of the floating model."""
    scene = case_scene(case, changes, name)
    assert isinstance(scene, FloatingScene)  # noqa: S101  # the scenes of these cases are
    return scene


def sph_scene(case: str, changes: Sequence[str] = ()) -> SphScene:
    """The scene of a case of the SPH model."""
    scene = case_scene(case, changes)
    assert isinstance(scene, SphScene)  # noqa: S101  # the scenes of these cases are
    return scene


def frames_of(case: str, changes: Sequence[str] = ()) -> Iterator[Frame]:
    """The frames of the scene of a case, with some of its values changed."""
    return simulate(case_scene(case, changes))


def kept_values(scene: Scene, folder: Path, compute: Callable[[], Sequence[Any]]) -> list[Any]:
    """What was computed from a scene and is kept, as JSON contains it; else it is computed now."""
    path = folder / f"{digest(scene)}.json"
    if not path.is_file():
        text = json.dumps(compute())
        folder.mkdir(parents=True, exist_ok=True)
        # Complete or absent: the file takes its name when all of it is written.
        partial = path.with_suffix(".part")
        partial.write_text(text, encoding="utf-8")
        partial.replace(path)
    found: list[Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def digest(scene: Scene) -> str:
    """The name of a piece: a digest of its complete scene."""
    return hashlib.sha256(json.dumps(to_plain(scene), sort_keys=True).encode()).hexdigest()[:16]
