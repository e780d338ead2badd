"""Reports on runs: on one run, on all runs in a folder, and on the differences of two runs."""

from __future__ import annotations

import contextlib
import math
import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ecume._hooks import html_of
from ecume.errors import BadInput, EcumeError, StorageError
from ecume.run.directory import RunDirectory, existing, manifest_of, read
from ecume.run.invariant_monitor import summary_line as watched
from ecume.run.lock import held, is_held
from ecume.run.manifest import circumstances
from ecume.run.verification import repaired
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import Trajectory, open_trajectory
from ecume.trajectories.records import DONE, FAILED, STATUS, manifest_at, scene_at, storing
from ecume.trajectories.segments import Repaired


class RunSummary(NamedTuple):
    """One run of a folder; `state` is as in `Info`, or "damaged"."""

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
    """The fault and how to continue, or an empty text."""


def list_runs(folder: str | os.PathLike[str] = ".") -> list[RunSummary]:
    """All runs in a folder and its subfolders, including those of sweeps, sorted by path. Links are not followed."""
    if not Path(folder).is_dir():
        raise BadInput(f"{folder}: got no folder; expected one that contains runs")
    return [_summary(path) for path in _runs_below(Path(folder))]


def _runs_below(folder: Path) -> Iterator[Path]:
    for root, folders, files in os.walk(folder):
        if "manifest.json" in files and ("resolved.json" in files or "traj" in folders):
            folders.clear()  # runs do not contain other runs
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
    """The title of a run's scene; empty if the scene cannot be read."""
    try:
        return str(scene_at(path, manifest_at(path)).get("title", ""))
    except StorageError:
        return ""


T = TypeVar("T")


class Info(NamedTuple):
    """The state of a run: `state` is running, killed, stopped, interrupted, failed or done."""

    directory: Path
    state: str
    why: str
    """The fault and the remedy, or an empty text."""
    step: int
    """The number of completed time steps."""
    steps: int | None
    """The number of time steps of the whole run; None while it is unknown."""
    time: float
    """The simulated time so far (s)."""
    duration: float
    frames: int
    """The number of frames on disk."""
    checkpoint: int | None
    """The step of the newest checkpoint."""
    size: int
    """The size on disk (bytes)."""
    remaining: float | None
    """The predicted remaining wall time (s) of a running run."""
    manifest: dict[str, Any]
    watch: str = ""
    """A line on the invariants of the run."""
    early: bool = False
    """Whether its condition ended it before its duration."""

    def _repr_html_(self) -> str | None:
        """The notebook view: the player of `ecume view`, in at most 4 MB."""
        return html_of(self.directory)


def info(directory: str | os.PathLike[str]) -> Info:
    """Information about a run, also while it is written, and after it was killed."""
    home = existing(directory)
    unsaid: dict[str, Any] = {}
    status, no_status = _read(lambda: _status(home), unsaid, home)
    watch, no_watch = _read(lambda: watched(home), "", home)
    frames, no_frames = _frames(home)
    state, reason = _state(home, status)
    return Info(
        directory=home.path,
        state=state,
        why="; ".join(part for part in (no_status, no_watch, no_frames, reason) if part),
        step=int(status.get("step", 0)),
        steps=status.get("steps"),
        time=float(status.get("time", 0.0)),
        duration=float(status.get("duration", 0.0)),
        frames=frames,
        checkpoint=_newest_step(home),
        size=_size(home),
        remaining=status.get("remaining") if state == "running" else None,
        manifest=manifest_of(home),
        watch=watch,
        early=state == "done" and _read(lambda: bool(read(home, home.done, DONE).get("early")), False, home)[0],
    )


def repair(directory: str | os.PathLike[str]) -> Repaired:
    """Repair a damaged run: complete frames are kept, damaged ones are listed, other files are
    restored or set aside.
    """
    home = existing(directory)
    with held(home):
        return repaired(home)


def _read(what: Callable[[], T], otherwise: T, home: RunDirectory) -> tuple[T, str]:
    """A part of the records of a run; if this part is damaged, a default and the reason."""
    try:
        return what(), ""
    except StorageError as error:
        return otherwise, f"{error}; `ecume repair {home.path}` sets it aside"


def _state(home: RunDirectory, status: dict[str, Any]) -> tuple[str, str]:
    """The state of the run, and the reason for it."""
    if home.done.exists():
        return "done", ""
    if home.failed.exists():
        return "failed", _why_failed(home)
    state = str(status.get("state", "running"))
    if state == "running":
        state = "running" if is_held(home) else "killed"
    return state, "" if state == "running" else f"to continue: ecume resume {home.path}"


def _why_failed(home: RunDirectory) -> str:
    try:
        return str(read(home, home.failed, FAILED).get("message", ""))
    except StorageError as error:
        return f"{error}; `ecume repair {home.path}` sets it aside"


def _status(home: RunDirectory) -> dict[str, Any]:
    """The contents of the status file; empty for a run that was killed before it wrote one."""
    return read(home, home.status, STATUS) if home.status.exists() else {}


def _frames(home: RunDirectory) -> tuple[int, str]:
    try:
        with Trajectory(home.trajectory) as trajectory:
            return len(trajectory), ""
    except StorageError as error:
        return 0, f"{error}; `ecume repair {home.path}` keeps what is whole"


def _size(home: RunDirectory) -> int:
    """The size of all files; files removed meanwhile count as empty."""
    size = 0
    for path in home.path.rglob("*"):
        with contextlib.suppress(FileNotFoundError):
            size += path.lstat().st_size if path.is_file() else 0
    return size


def _newest_step(home: RunDirectory) -> int | None:
    with storing(home.checkpoints):
        steps = [int(path.stem) for path in home.checkpoints.glob("*.npz") if path.stem.isdecimal()]
    return max(steps, default=None)


SAME_TIME = 1e-9
"""The difference of times, over the duration of the longer run, below which frames are compared."""


class Change(NamedTuple):
    """A value that differs between two runs; None if a run does not have it."""

    name: str
    first: object
    second: object


class QuantityDifference(NamedTuple):
    """The difference of a quantity between the frames of two runs."""

    name: str
    unit: str
    from_time: float
    """of the first frame in which it differs, s"""
    largest: float
    """largest difference in any frame, in the quantity's unit; infinite where shapes or finite values differ"""
    relative: float
    """the same over the quantity's largest value in the first run"""
    rounding: bool = False
    """whether it is explained by rounding: below `ROUNDING` of the largest quantity of the same unit"""
    shapes: str = ""
    """why values cannot be subtracted, for example `60 and 40 particles`"""


ROUNDING = 1e-13
"""The difference, over the largest value of any quantity with the same unit, that rounding explains."""


class Comparison(NamedTuple):
    """All differences of two runs."""

    scene: list[Change]
    programs: list[Change]
    """versions and processor"""
    frames: tuple[int, int]
    common: int
    """the number of frames with the same time in both"""
    quantities: list[QuantityDifference]

    @property
    def same(self) -> bool:
        """Whether all frames are in both runs, bit for bit."""
        return not self.quantities and self.frames == (self.common, self.common)


def compare(first: str | os.PathLike[str], second: str | os.PathLike[str]) -> Comparison:
    """Compare two runs: keys of their scenes, versions, and each quantity in all frames of the same time."""
    homes = existing(first), existing(second)
    manifests = [manifest_of(home) for home in homes]
    scenes = scene_at(homes[0].path, manifests[0]), scene_at(homes[1].path, manifests[1])
    names = circumstances()
    programs = [{name: manifest.get(name) for name in names} for manifest in manifests]
    with open_trajectory(homes[0].path) as one, open_trajectory(homes[1].path) as other:
        pairs = _same_times(one.times, other.times)
        quantities = _differences((one[i], other[j]) for i, j in pairs)
        frames = len(one), len(other)
    return Comparison(
        scene=list(_differing(*scenes)),
        programs=_changes(*programs),
        frames=frames,
        common=len(pairs),
        quantities=quantities,
    )


def _differing(first: object, second: object, path: str = "") -> Iterator[Change]:
    """The values that differ in nested tables, by their paths: `particles[0].radius`. A list without tables is one
    value.
    """
    one, other = _entries(first), _entries(second)
    if one is None and other is None:
        if first != second:
            yield Change(path, first, second)
        return
    # A table without a counterpart: each of its values has no counterpart.
    for name in dict.fromkeys((*(one or {}), *(other or {}))):
        here = f"{path}[{name}]" if isinstance(name, int) else f"{path}.{name}" if path else str(name)
        yield from _differing((one or {}).get(name), (other or {}).get(name), here)


def _entries(value: object) -> Mapping[Any, object] | None:
    """The entries of a table, or of a list of tables; None for anything else."""
    if isinstance(value, dict):
        return value
    if isinstance(value, list) and any(isinstance(each, dict) for each in value):
        return dict(enumerate(value))
    return None


def _changes(first: Mapping[str, object], second: Mapping[str, object]) -> list[Change]:
    names = dict.fromkeys((*first, *second))
    pairs = [Change(name, first.get(name), second.get(name)) for name in names]
    return [pair for pair in pairs if pair.first != pair.second]


def _same_times(first: NDArray[np.float64], second: NDArray[np.float64]) -> list[tuple[int, int]]:
    """Pairs of indices of frames with the same time."""
    if not len(first) or not len(second):
        return []
    limit = SAME_TIME * max(first[-1], second[-1])
    place = np.clip(np.searchsorted(first, second - limit), 0, len(first) - 1)
    return [(int(i), j) for j, i in enumerate(place) if abs(first[i] - second[j]) <= limit]


def _differences(pairs: Iterator[tuple[Frame, Frame]]) -> list[QuantityDifference]:
    """One entry for each quantity that differs in any pair of frames."""
    found: dict[str, QuantityDifference] = {}
    scales: dict[str, float] = {}
    units: dict[str, str] = {}
    for first, second in pairs:
        units |= first.units
        mine, theirs = _quantities(first), _quantities(second)
        for name in dict.fromkeys((*mine, *theirs)):
            one, other = mine.get(name), theirs.get(name)
            if one is not None:
                scales[name] = max(scales.get(name, 0.0), _largest(one))
            if (size := _distance(one, other)) is None:
                continue
            before = found.get(name)
            largest = max(size, before.largest if before else 0.0)
            start = before.from_time if before else first.time
            shapes = before.shapes if before and before.shapes else _unlike(one, other)
            unit = str(first.units.get(name, ""))
            found[name] = QuantityDifference(name, unit, start, largest, math.nan, shapes=shapes)
    around = _scales_of_units(scales, units)
    return [
        one._replace(
            relative=_over(one.largest, scales.get(name, 0.0)),
            rounding=one.largest <= ROUNDING * around.get(one.unit, scales.get(name, 0.0)),
        )
        for name, one in found.items()
    ]


PURE = ("", "1")
"""Units of numbers that are not comparable with one another: counts, angles, fractions."""


def _scales_of_units(scales: Mapping[str, float], units: Mapping[str, str]) -> dict[str, float]:
    """The largest value of all quantities with the same unit; dimensionless numbers are not combined."""
    found: dict[str, float] = {}
    for name, scale in scales.items():
        if (unit := units.get(name, "")) not in PURE:
            found[unit] = max(found.get(unit, 0.0), scale)
    return found


def _unlike(one: NDArray[Any] | None, other: NDArray[Any] | None) -> str:
    """The reason why two arrays cannot be subtracted; empty if they can."""
    if one is None or other is None:
        return f"only in the {'second' if one is None else 'first'} run"
    if one.shape[:1] != other.shape[:1]:
        return f"{len(one)} and {len(other)} particles"
    if (one.shape, one.dtype) != (other.shape, other.dtype):
        return "different shapes"
    return "" if np.array_equal(np.isfinite(one), np.isfinite(other)) else "finite in one run only"


def _quantities(frame: Frame) -> dict[str, NDArray[Any]]:
    return {**frame.arrays, **{name: np.asarray(value, float) for name, value in frame.numbers.items()}}


def _largest(values: NDArray[Any]) -> float:
    finite = values[np.isfinite(values)] if values.dtype.kind in "fi" else np.zeros(0)
    return float(np.abs(finite).max(initial=0.0))


def _distance(one: NDArray[Any] | None, other: NDArray[Any] | None) -> float | None:
    """The largest difference of two arrays; None if they are equal, infinite if they cannot be subtracted."""
    if one is None or other is None or (one.shape, one.dtype) != (other.shape, other.dtype):
        return math.inf
    if one.tobytes() == other.tobytes():
        return None
    if not np.array_equal(np.isfinite(one), np.isfinite(other)):
        return math.inf
    with np.errstate(invalid="ignore"):
        apart = np.abs(one - other)
    return float(np.nanmax(apart, initial=0.0)) or None


def _over(size: float, scale: float) -> float:
    return size / scale if scale > 0.0 else size
