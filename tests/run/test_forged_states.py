"""Checkpoints that anyone may have written, with every checksum right: a message, at once, and no traceback."""

from __future__ import annotations

import math
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import toy

from ecume.errors import EcumeError
from ecume.run import RunDirectory, RunOptions, archives, checkpoints, resume, run, verify
from ecume.trajectories.gsd import checksum
from ecume.trajectories.segments import Segment

Scenes = Callable[..., toy.ToyScene]
pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")
VALUES = (math.nan, math.inf, -math.inf, -1.0, 0.0, 0.5, 1e300, -1e300, 2.0**62)
SAMPLED: dict[str, Any] = {"duration": 0.05, "output": {"samples": {"every_steps": 2, "block": 3}}}


@pytest.fixture
def killed(tmp_path: Path, scene: Scenes) -> RunDirectory:
    """A run that looks killed in the middle of a block of samples."""
    home = RunDirectory(tmp_path / "run")
    run(scene(**SAMPLED), home.path, options=RunOptions(checkpoint_every=0.0))
    home.done.unlink()
    first, *others = checkpoints.newest_first(home)
    for other in others:
        other.unlink()
    assert first.exists()
    return home


def forge(home: RunDirectory, name: str, change: Callable[[np.ndarray], np.ndarray]) -> None:
    """Change an array of the checkpoint, and all checksums."""
    (path,), arrays = checkpoints.newest_first(home), arrays_of(home)
    arrays[name] = np.ascontiguousarray(change(arrays[name]))
    with path.open("w+b") as file:
        np.savez(file, allow_pickle=False, crc32=np.array([checksum(arrays)]), **arrays)
        archives.seal(file)


def filled(value: float) -> Callable[[np.ndarray], np.ndarray]:
    """Makes an array of this value, or of the nearest that its kind has."""

    def change(array: np.ndarray) -> np.ndarray:
        if array.dtype.kind == "f":
            return np.full_like(array, value)
        limits = np.iinfo(array.dtype)
        nearest = 0 if math.isnan(value) else int(max(min(value, 2.0**62), -(2.0**62)))
        return np.full_like(array, min(max(nearest, limits.min), limits.max))

    return change


CHANGES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    **{f"{value:g}": filled(value) for value in VALUES},
    "nothing": lambda array: array[:0],
    "twice": lambda array: np.concatenate([array, array]),
    "single": lambda array: array.astype(np.float32),
}


def arrays_of(home: RunDirectory) -> dict[str, np.ndarray]:
    (path,) = checkpoints.newest_first(home)
    with path.open("rb") as file:
        return {name: array.copy() for name, array in archives.arrays_of(file, path).items() if name != "crc32"}


@pytest.mark.long
def test_no_forged_checkpoint_surprises(killed: RunDirectory, tmp_path: Path) -> None:
    """Each array with each value; what is refused is computed again."""
    refused, tried = 0, set()
    for name, array in arrays_of(killed).items():
        for what, change in CHANGES.items():
            changed = change(array)
            if (same := (name, changed.dtype.str, changed.shape, changed.tobytes())) in tried:
                continue  # whole numbers have fewer values
            tried.add(same)
            shutil.copytree(killed.path, tmp_path / "copy")
            home = RunDirectory(tmp_path / "copy")
            forge(home, name, change)
            try:
                resume(home.path)
            except EcumeError:
                refused += 1
            else:
                assert verify(home.path).sound, (name, what)
            shutil.rmtree(home.path)
    assert refused > 5


@pytest.mark.long
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_state_that_is_not_finite_is_set_aside(killed: RunDirectory, value: float) -> None:
    forge(killed, "state.position", filled(value))
    resume(killed.path)
    assert "not finite" in killed.log.read_text()
    assert verify(killed.path).sound


@pytest.mark.skipif(not hasattr(os, "fork"), reason="Windows forks no processes")
def test_a_reader_survives_a_file_that_another_process_cuts(killed: RunDirectory) -> None:
    """A file that is mapped into memory would end the reader by SIGBUS."""
    path = killed.trajectory / "0000.gsd"
    segment = Segment(path)
    with path.open("r+b") as file:
        file.truncate(9000)
    assert list(segment.unproven())
    with pytest.raises(EcumeError, match="damaged"):
        segment.numbers()
    segment.close()
