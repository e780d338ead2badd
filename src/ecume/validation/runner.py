"""The scenes, tables and runs of validation cases; scenes and tables are in `data/CASE`."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path

from ecume.scenes.floating import FloatingScene
from ecume.scenes.load import load_scene
from ecume.scenes.schema import Scene
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
