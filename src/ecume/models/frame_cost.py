"""The cost of frames in time and on the disk: measured by writing a few to a disk."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ecume.errors import StorageError
from ecume.models.check_report import Row, told_duration
from ecume.scenes.common import Common
from ecume.trajectories.frame import Frame
from ecume.trajectories.recorder import Recorder

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
    arrays: Mapping[str, int]
    """The components of each array that changes; constant arrays are stored once."""
    numbers: int


class FrameCost(NamedTuple):
    """Of all frames of a scene."""

    frames: int
    seconds: float
    bytes: float

    def rows(self) -> list[Row]:
        """The number of frames, what each costs, and the size of all on the disk."""
        each = f"{told_duration(self.seconds / self.frames)} and {told_size(self.bytes / self.frames)} each"
        large = "; a larger frame_every takes less" if self.bytes > LARGE else ""
        return [("frames", str(self.frames), each), ("disk", told_size(self.bytes), f"roughly, of frames{large}")]

    def remark(self, stepping: float) -> str:
        """What to do where frames take longer than time steps do, and long; otherwise empty."""
        dominate = self.seconds > max(stepping, MANY)
        return "; frames take most of it: a larger frame_every takes less" if dominate else ""


def frame_cost(scene: Common, content: Content) -> FrameCost:
    """What the frames of a scene cost on the disk of the current folder."""
    frames, asked = scene.frames + 1, scene.output.quantities
    written = {name: width for name, width in content.arrays.items() if name in (*asked, "position") or not asked}
    content = content._replace(arrays=written)
    seconds, size = probed(content, single=scene.output.precision == "single")
    making = OBSERVING + PER_PARTICLE * content.particles
    quantities = len(content.arrays) + content.numbers
    size += INDEX * quantities + LINE * content.numbers
    return FrameCost(frames, frames * (seconds + making), FILE + frames * size)


def probed(content: Content, *, single: bool = False) -> tuple[float, float]:
    """Seconds and bytes of a frame, from a few that are written and removed again."""
    random = np.random.default_rng(0)
    probes = [
        Frame(
            float(number),
            {name: random.normal(size=(content.particles, width)) for name, width in content.arrays.items()},
            {f"number_{k}": float(random.normal()) for k in range(content.numbers)},
            {},
        )
        for number in range(PROBES + 1)
    ]
    place = Path.cwd() if os.access(Path.cwd(), os.W_OK) else None
    try:
        with (
            tempfile.TemporaryDirectory(prefix=".ecume-", dir=place) as folder,
            Recorder(Path(folder), single=single) as recorder,
        ):
            recorder.write(probes[0], 0)
            before, began = _size(Path(folder)), time.perf_counter()
            for probe in probes[1:]:
                recorder.write(probe, 0)
            seconds = (time.perf_counter() - began) / PROBES
            return seconds, (_size(Path(folder)) - before) / PROBES
    except (OSError, StorageError):  # a full disk, or one that cannot be written: the arrays' own size
        return NOTHING_WRITTEN, (4.0 if single else 8.0) * content.particles * sum(content.arrays.values())


def _size(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.iterdir())


def told_size(size: float) -> str:
    """A size in the unit that fits.

    >>> told_size(950.0), told_size(2.35e5), told_size(3.2e9), told_size(4e13)
    ('950 B', '235 kB', '3.2 GB', '40 TB')
    """
    for unit, power in (("B", 0), ("kB", 3), ("MB", 6), ("GB", 9)):
        if size < 0.9995 * 10.0 ** (power + 3):
            return f"{size / 10.0**power:.3g} {unit}"
    return f"{size / 1e12:.3g} TB"
