"""The cost of a run: limits of steps and memory, and the cost of frames in time and disk space."""

from __future__ import annotations

import math
import os
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np

from ecume._plain_files import memory_limit
from ecume.errors import Fault, SceneError, StorageError
from ecume.models.model import LONGEST_RUN, Row
from ecume.scenes.common import Common
from ecume.scenes.quantities import MOST_STEPS
from ecume.trajectories.frame import Frame
from ecume.trajectories.samples import STATISTICS
from ecume.trajectories.segments import Recorder
from ecume.units import duration_text, size_text

Parameters = TypeVar("Parameters")


def within_steps(scene: Common, parameters: Parameters) -> Parameters:
    """The parameters, unchanged. Raises SceneError if a run would need too many time steps."""
    step: float = parameters.time_step  # type: ignore[attr-defined]  # every model's have one
    if scene.duration / step > MOST_STEPS:
        message = f"is {scene.duration / step:.3g} steps of {step:.3g} s, more than {MOST_STEPS:.0e}; make it shorter"
        raise SceneError([Fault("duration", message)])
    return parameters


def require_memory(path: str, what: str, needed: float, way_out: str = "use fewer") -> None:
    """Raise SceneError if something needs more memory (bytes) than this process may use."""
    there = memory_limit()
    if needed > there:
        message = f"{what} need about {needed / 1e9:.3g} GB, this process may use {there / 1e9:.3g} GB; {way_out}"
        raise SceneError([Fault(path, message)])


PROBES = 4
"""The number of frames written as a probe, after a first one that opens the file."""
OBSERVING, PER_PARTICLE = 2e-4, 1.1e-6
"""Seconds to make a frame out of a state, and for each of its particles: 0.2 ms for two floats, 3.7 ms for 3,200
particles of a liquid.
"""
INDEX, LINE, FILE = 32.0, 32.0, 17e3
"""Bytes of each quantity in a file's index, and of each number in `scalars.jsonl`; bytes of a file without frames."""
CHECKPOINTS, ARCHIVE = 2, 8e3
"""The number of checkpoints that a run keeps, and the size of one without particles in bytes."""
CELL = 19.0
"""Bytes of a number in `samples.csv`."""
NOTHING_WRITTEN = 5e-3
"""The time of a frame (s) if no file can be written."""
MANY = 60.0
"""The duration of a run (s) above which frames that take most of it are remarked on."""
LARGE = 1e10
"""The size of a run (bytes) that is remarked on."""


class Content(NamedTuple):
    """The amount of data in a frame of a model."""

    particles: int
    arrays: Mapping[str, int]
    """The components of each array that changes; constant arrays are stored once."""
    numbers: int
    state: float = 0.0
    """bytes of a state"""
    constants: float = 0.0
    """bytes of what a run keeps once"""


class SampleCost(NamedTuple):
    """The cost of all samples between frames."""

    samples: float = 0.0
    rows: float = 0.0
    bytes: float = 0.0
    seconds: float = 0.0

    def lines(self) -> list[Row]:
        """The number of samples, and the size of their table."""
        if not self.samples:
            return []
        count = f"{self.samples:.0f} in {self.rows:.0f} rows"
        large = "; larger blocks take less" if self.bytes > LARGE else ""
        return [("samples", count, f"{size_text(self.bytes)} and {duration_text(self.seconds)} in all{large}")]


class FrameCost(NamedTuple):
    """The cost of all frames of a scene, and of samples between them."""

    frames: int
    writing: float
    bytes: float
    sampling: SampleCost = SampleCost()
    kept: float = 0.0
    """bytes of checkpoints and constants"""

    @property
    def seconds(self) -> float:
        """Wall time of frames and samples."""
        return self.writing + self.sampling.seconds

    def rows(self) -> list[Row]:
        """The number of frames, the cost of each, the samples between them, and the total size on disk."""
        each = f"{duration_text(self.writing / self.frames)} and {size_text(self.bytes / self.frames)} each"
        large = "; a larger frame_every takes less" if self.bytes > LARGE else ""
        frames, samples = ("frames", str(self.frames), each), self.sampling.lines()
        of = "frames, samples and checkpoints" if samples else "frames and checkpoints"
        size = size_text(self.bytes + self.sampling.bytes + self.kept)
        return [frames, *samples, ("disk", size, f"roughly, of {of}{large}")]

    def remark(self, stepping: float) -> str:
        """The remedy if the run takes too long, or frames take longer than time steps; otherwise empty."""
        if stepping + self.seconds > LONGEST_RUN:
            return f"; `ecume run` refuses more than {duration_text(LONGEST_RUN)} without --max-days"
        if self.sampling.seconds > max(stepping, self.writing, MANY):
            return "; samples take most of it: a larger output.samples.every takes less"
        dominate = self.writing > max(stepping, MANY)
        return "; frames take most of it: a larger frame_every takes less" if dominate else ""


def frame_cost(scene: Common, content: Content, steps: float) -> FrameCost:
    """The cost of a scene's frames, on the disk of the current folder, and of its samples; `steps` is the number of
    time steps.
    """
    frames, asked = scene.frames + 1, scene.output.quantities
    written = {name: width for name, width in content.arrays.items() if name in (*asked, "position") or not asked}
    content = content._replace(arrays=written)
    seconds, size = probed(content, single=scene.output.precision == "single")
    making = OBSERVING + PER_PARTICLE * content.particles
    quantities = len(content.arrays) + content.numbers
    size += INDEX * quantities + LINE * content.numbers
    kept = CHECKPOINTS * (ARCHIVE + content.state) + content.constants
    samples = sample_cost(scene, content, steps)
    return FrameCost(frames, frames * (seconds + making), FILE + frames * size, samples, kept)


def sample_cost(scene: Common, content: Content, steps: float) -> SampleCost:
    """The cost of the samples between frames; `steps` is the number of time steps."""
    asked = scene.output.samples
    if asked is None:
        return SampleCost()
    intervals = steps / asked.every_steps if asked.every_steps else min(scene.duration / (asked.every or 1.0), steps)
    samples = math.floor(intervals * (1.0 + 1e-9)) + 1
    rows = math.ceil(samples / asked.block)
    columns = (len(asked.numbers) or content.numbers) * (len(STATISTICS) if asked.block > 1 else 1)
    seconds = samples * (OBSERVING + PER_PARTICLE * content.particles)
    return SampleCost(samples, rows, CELL * rows * (columns + 2), seconds)


def probed(content: Content, *, single: bool = False) -> tuple[float, float]:
    """The time (s) and the size (bytes) of a frame, measured with a few frames that are written and then removed."""
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
    except (OSError, StorageError):  # a full or read-only disk: use the size of the arrays
        return NOTHING_WRITTEN, (4.0 if single else 8.0) * content.particles * sum(content.arrays.values())


def _size(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.iterdir())
