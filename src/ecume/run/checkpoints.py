"""States on disk: enough to go on bit for bit."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._plain_files import opened, place_of
from ecume.run.archives import arrays_of, require_sealed, seal
from ecume.run.directory import RunDirectory
from ecume.run.sampling import NOTHING, Kept, missing_rows
from ecume.trajectories.durable_files import replacing, storing
from ecume.trajectories.gsd_schema import checksum

KEPT = 2
"""How many checkpoints stay: if the newest is damaged, there is another."""
FIELD, SAMPLES = "state.", "samples."


class Checkpoint(NamedTuple):
    """A state, how many frames there were before it, and how many time steps."""

    state: Any
    frames: int
    step: int = 0
    samples: Kept = NOTHING
    """The position of the sampling, see `ecume.run.sampling`; empty without samples."""


def save(home: RunDirectory, checkpoint: Checkpoint) -> Path:
    """Write a checkpoint, and remove those that are too old."""
    arrays: dict[str, NDArray[Any]] = {"frames": np.array([checkpoint.frames])}
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
    """The arrays of a checkpoint. Raises ValueError where a byte is not as it was written."""
    with opened(path, "r", home.path) as file:
        require_sealed(file)
        file.seek(0)
        return arrays_of(file, path)


def require_sound(home: RunDirectory, path: Path) -> None:
    """Raise ValueError where a checkpoint is damaged."""
    arrays = sound_arrays(home, path)
    if int(arrays.pop("crc32")[0]) != checksum(arrays):
        raise ValueError("its checksum does not fit its data")


def set_aside(home: RunDirectory, path: Path) -> None:
    """Rename a damaged file of a run, so that it is not read again."""
    with storing(path), place_of(path, home.path) as place:
        place.beside(f"{place.name}.damaged").take(place)
        place.settle()


def newest_first(home: RunDirectory) -> list[Path]:
    """The checkpoints of a run."""
    return sorted((path for path in home.checkpoints.glob("*.npz") if path.stem.isdecimal()), reverse=True)


def newest(home: RunDirectory, kind: type, frames: int, note: Callable[[Path, str], None]) -> Checkpoint | None:
    """The newest good checkpoint for which all frames before it are on disk; others are set aside, and noted.

    `kind` is the model's State; `frames` is how many frames are on disk.
    """
    for path in newest_first(home):
        checkpoint, fault = _examined(home, path, kind)
        if checkpoint is not None and checkpoint.frames > frames:
            fault = f"{checkpoint.frames - frames} frames before it are missing or damaged"
        if checkpoint is not None and not fault:
            fault = missing_rows(home.samples, checkpoint.samples)
        if checkpoint is not None and not fault:
            return checkpoint
        set_aside(home, path)
        note(path, fault)
    return None


def _examined(home: RunDirectory, path: Path, kind: type) -> tuple[Checkpoint | None, str]:
    """The checkpoint of a file, or what is wrong with it."""
    try:
        return _loaded(home, path, kind)._replace(step=int(path.stem)), ""
    except Exception as error:  # a damaged archive raises nearly anything; whatever it is, the file is not used
        return None, f"{type(error).__name__}: {error}"


def _loaded(home: RunDirectory, path: Path, kind: type) -> Checkpoint:
    arrays = sound_arrays(home, path)
    if int(arrays.pop("crc32")[0]) != checksum(arrays):
        raise ValueError("its checksum does not fit its data")
    frames = int(arrays.pop("frames")[0])
    kept = {name.removeprefix(FIELD): array for name, array in arrays.items() if name.startswith(FIELD)}
    samples = {name.removeprefix(SAMPLES): array for name, array in arrays.items() if name.startswith(SAMPLES)}
    return Checkpoint(kind(**{**_unknown_then(kind), **kept}), frames, samples=samples)


def _unknown_then(kind: type) -> dict[str, NDArray[Any]]:
    """The defaults of fields that states of former versions lack, as copies to write to."""
    defaults: dict[str, NDArray[Any]] = getattr(kind, "_field_defaults", {})
    return {name: array.copy() for name, array in defaults.items()}
