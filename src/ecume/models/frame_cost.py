"""The cost of frames in time and on the disk: measured by writing a few to a disk."""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ecume.errors import StorageError
from ecume.models.check_report import Row
from ecume.scenes.common import Common
from ecume.trajectories.frame import Frame
from ecume.trajectories.recorder import Recorder
from ecume.value_texts import duration_text, size_text

PROBES = 4
"""Frames that are written, besides a first one that opens the file."""
OBSERVING, PER_PARTICLE = 2e-4, 1.1e-6
"""Seconds to make a frame out of a state, and for each of its particles: 0.2 ms for two floats, 3.7 ms for 3,200
particles of a liquid.
"""
INDEX, LINE, FILE = 32.0, 32.0, 17e3
"""Bytes of each quantity in a file's index, and of each number in `scalars.jsonl`; bytes of a file without frames."""
NOTHING_WRITTEN = 5e-3
"""Seconds of a frame where nothing can be written."""
MANY = 60.0
"""Seconds of a run from which on it is worth a remark that frames take most of it."""
LARGE = 1e10
"""Bytes of a run that are worth a remark."""


class Content(NamedTuple):
    """What a frame of a model holds."""

    particles: int
    widths: tuple[int, ...]
    """Components of each of its arrays."""
    numbers: int


class FrameCost(NamedTuple):
    """Of all frames of a scene."""

    frames: int
    seconds: float
    bytes: float

    def rows(self) -> list[Row]:
        """The number of frames, what each costs, and the size of all on the disk."""
        each = f"{duration_text(self.seconds / self.frames)} and {size_text(self.bytes / self.frames)} each"
        large = "; a larger frame_every takes less" if self.bytes > LARGE else ""
        return [("frames", str(self.frames), each), ("disk", size_text(self.bytes), f"roughly, of frames{large}")]

    def remark(self, stepping: float) -> str:
        """What to do where frames take longer than time steps do, and long; otherwise empty."""
        dominate = self.seconds > max(stepping, MANY)
        return "; frames take most of it: a larger frame_every takes less" if dominate else ""


def frame_cost(scene: Common, content: Content) -> FrameCost:
    """What the frames of a scene cost on the disk of the current folder."""
    frames = scene.frames + 1
    seconds, size = probed(content)
    making = OBSERVING + PER_PARTICLE * content.particles
    quantities = len(content.widths) + content.numbers
    size += INDEX * quantities + LINE * content.numbers
    return FrameCost(frames, frames * (seconds + making), FILE + frames * size)


def probed(content: Content) -> tuple[float, float]:
    """Seconds and bytes of a frame, from a few that are written and removed again."""
    random = np.random.default_rng(0)
    probes = [
        Frame(
            float(number),
            {f"array_{k}": random.normal(size=(content.particles, width)) for k, width in enumerate(content.widths)}
            | {"position": random.normal(size=(content.particles, 3))},
            {f"number_{k}": float(random.normal()) for k in range(content.numbers)},
            {},
        )
        for number in range(PROBES + 1)
    ]
    place = Path.cwd() if os.access(Path.cwd(), os.W_OK) else None
    try:
        with tempfile.TemporaryDirectory(prefix=".ecume-", dir=place) as folder, Recorder(Path(folder)) as recorder:
            recorder.write(probes[0], 0)
            before, began = _size(Path(folder)), time.perf_counter()
            for probe in probes[1:]:
                recorder.write(probe, 0)
            seconds = (time.perf_counter() - began) / PROBES
            return seconds, (_size(Path(folder)) - before) / PROBES
    except (OSError, StorageError):  # a full disk, or one that cannot be written: the arrays' own size
        return NOTHING_WRITTEN, 8.0 * content.particles * sum(content.widths)


def _size(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.iterdir())
