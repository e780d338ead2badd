"""The runs in a folder."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from ecume.errors import BadInput, EcumeError, StorageError
from ecume.run.reports import info
from ecume.trajectories.records import manifest_at, scene_at


class RunSummary(NamedTuple):
    """One run of a folder; `state` is as in `Info`, or damaged."""

    directory: Path
    model: str
    title: str
    state: str
    time: float
    """simulated so far, s"""
    duration: float
    frames: int
    size: int
    """bytes on disk"""
    why: str
    """What is wrong with it, and how to continue; or nothing."""


def list_runs(folder: str | os.PathLike[str] = ".") -> list[RunSummary]:
    """All runs in a folder and the folders in it, those of sweeps too, by their paths. Links are not followed."""
    if not Path(folder).is_dir():
        raise BadInput(f"{folder}: got no folder; expected one that contains runs")
    return [_summary(path) for path in _runs_below(Path(folder))]


def _runs_below(folder: Path) -> Iterator[Path]:
    for root, folders, files in os.walk(folder):
        if "manifest.json" in files and ("resolved.json" in files or "traj" in folders):
            folders.clear()  # runs are not nested
            yield Path(root)
        folders.sort()


def _summary(path: Path) -> RunSummary:
    try:
        found = info(path)
    except EcumeError as error:
        return RunSummary(path, "", "", "damaged", 0.0, 0.0, 0, 0, str(error))
    model = str(found.manifest.get("model", ""))
    return RunSummary(
        path, model, _title(path), found.state, found.time, found.duration, found.frames, found.size, found.why
    )


def _title(path: Path) -> str:
    """The title in a run's scene; nothing where the scene cannot be read."""
    try:
        return str(scene_at(path, manifest_at(path)).get("title", ""))
    except StorageError:
        return ""
