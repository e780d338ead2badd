"""Checkpoints: states on disk, sufficient to resume a run bit for bit."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._plain_files import opened, place_of
from ecume.run.archives import arrays_of, require_sealed, seal, with_present_names
from ecume.run.directory import RunDirectory, identity_of
from ecume.run.samples import NOTHING, Kept, missing_rows
from ecume.trajectories.gsd import checksum
from ecume.trajectories.records import replacing, storing

KEPT = 2
"""The number of checkpoints that are kept: if the newest is damaged, the other one is used."""
FIELD, SAMPLES = "state.", "samples."
RUN, STEP = "run", "step"


class Checkpoint(NamedTuple):
    """A state, the number of frames before it, and the number of time steps."""

    state: Any
    frames: int
    step: int = 0
    samples: Kept = NOTHING
    """The position of the sampling, see `ecume.run.recording`; empty without samples."""


def save(home: RunDirectory, checkpoint: Checkpoint) -> Path:
    """Write a checkpoint, and remove older ones beyond the newest two."""
    arrays: dict[str, NDArray[Any]] = {"frames": np.array([checkpoint.frames])}
    if run := identity_of(home):
        arrays |= {STEP: np.array([checkpoint.step]), RUN: np.frombuffer(run.encode(), np.uint8)}
    arrays |= {FIELD + name: np.asarray(array) for name, array in checkpoint.state._asdict().items()}
    arrays |= {SAMPLES + name: array for name, array in checkpoint.samples.items()}
    path = home.checkpoints / f"{checkpoint.step:012d}.npz"
    with storing(path):
        home.checkpoints.mkdir(exist_ok=True)
    with replacing(path, home.path) as file:
        np.savez(file, allow_pickle=False, crc32=np.array([checksum(arrays)]), **arrays)
        seal(file)
    for old in newest_first(home)[KEPT:]:
        with storing(old):
            old.unlink()
    return path


def sound_arrays(home: RunDirectory, path: Path) -> dict[str, NDArray[Any]]:
    """The arrays of a checkpoint. Raises ValueError if any byte was changed."""
    with opened(path, "r", home.path) as file:
        require_sealed(file)
        file.seek(0)
        return arrays_of(file, path)


def require_sound(home: RunDirectory, path: Path) -> None:
    """Raise ValueError if a checkpoint is damaged."""
    if fault := missing_rows(home, _own_arrays(home, path)[1]):
        raise ValueError(fault)


def _own_arrays(home: RunDirectory, path: Path) -> tuple[dict[str, NDArray[Any]], Kept]:
    """The arrays of the state and those of the sampling in a checkpoint. Raises ValueError if it is damaged, or belongs
    to another run or step.
    """
    arrays = sound_arrays(home, path)
    if int(arrays.pop("crc32")[0]) != checksum(arrays):
        raise ValueError("its checksum does not fit its data")
    run, step = arrays.pop(RUN, np.zeros(0, np.uint8)), arrays.pop(STEP, None)
    if run.tobytes() != identity_of(home).encode() or (step is not None and int(step[0]) != int(path.stem)):
        raise ValueError("it belongs to another run or step")
    sampling = {name: array for name, array in arrays.items() if name.startswith(SAMPLES)}
    rest = {name: array for name, array in arrays.items() if name not in sampling}
    return rest, {name.removeprefix(SAMPLES): array for name, array in sampling.items()}


def set_aside(home: RunDirectory, path: Path) -> None:
    """Rename a damaged file of a run, so that it is not read again."""
    with storing(path), place_of(path, home.path) as place:
        place.beside(f"{place.name}.damaged").take(place)
        place.settle()


def newest_first(home: RunDirectory) -> list[Path]:
    """The checkpoints of a run, the newest first."""
    return sorted((path for path in home.checkpoints.glob("*.npz") if path.stem.isdecimal()), reverse=True)


def newest(home: RunDirectory, kind: type, frames: int, note: Callable[[Path, str], None]) -> Checkpoint | None:
    """The newest undamaged checkpoint whose preceding frames are all on disk; damaged ones are renamed and logged.

    `kind` is the model's State; `frames` is the number of frames on disk.
    """
    for path in newest_first(home):
        checkpoint, fault = _examined(home, path, kind)
        if checkpoint is not None and checkpoint.frames > frames:
            fault = f"{checkpoint.frames - frames} frames before it are missing or damaged"
        if checkpoint is not None and not fault:
            fault = missing_rows(home, checkpoint.samples)
        if checkpoint is not None and not fault:
            return checkpoint
        set_aside(home, path)
        note(path, fault)
    return None


def _examined(home: RunDirectory, path: Path, kind: type) -> tuple[Checkpoint | None, str]:
    """The checkpoint of a file, or a description of its fault."""
    try:
        return _loaded(home, path, kind)._replace(step=int(path.stem)), ""
    except Exception as error:  # a damaged archive may raise any exception, and is not used in any case
        return None, f"{type(error).__name__}: {error}"


def _loaded(home: RunDirectory, path: Path, kind: type) -> Checkpoint:
    arrays, samples = _own_arrays(home, path)
    frames = int(arrays.pop("frames")[0])
    kept = {name.removeprefix(FIELD): array for name, array in arrays.items() if name.startswith(FIELD)}
    kept = with_present_names(kept, getattr(kind, "_fields", ()))
    for name, array in kept.items():
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            raise ValueError(f"its {name} contains numbers that are not finite")
    return Checkpoint(kind(**{**_unknown_then(kind), **kept}), frames, samples=samples)


def _unknown_then(kind: type) -> dict[str, NDArray[Any]]:
    """The defaults of fields that are missing in states of former versions, as writable copies."""
    defaults: dict[str, NDArray[Any]] = getattr(kind, "_field_defaults", {})
    return {name: array.copy() for name, array in defaults.items()}
