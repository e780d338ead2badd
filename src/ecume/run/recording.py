"""The frames of a run onto disk: the quantities that are selected, the table of numbers, samples, and progress.

Numbers sampled between frames: averaged in blocks, and written to `samples.csv` of a run. A checkpoint contains the
length of the file and the block that is not complete yet. A resumed run cuts the file there and continues the block,
so the bytes are those of a run without interruption.

The frames of a run onto disk, also those of a run that was interrupted. What a killed run wrote after its last
checkpoint is computed again, and compared bit for bit instead of being written again: each crash is a test of
determinism. On another processor or with other versions of the libraries the last bits may differ; then the old
frames are replaced, and the run says by how much they differ.

The progress of a run: for people, for machines (`status.json`), and for later (`log.jsonl`).
"""

from __future__ import annotations

import contextlib
import io
import math
import os
import time
import warnings
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from io import FileIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._plain_files import append, opened, read_at
from ecume.errors import BadInput, Fault, SceneError, StorageError, nearest
from ecume.models.step_counts import BEFORE
from ecume.run.directory import RunDirectory, has_checksums, identity_of, owner_of, write
from ecume.run.manifest import changed, circumstances_of_frame, now, record
from ecume.scenes.common import Kind, colors_of
from ecume.trajectories.frame import Frame, RecordedArrays
from ecume.trajectories.reader import SUMS, Trajectory, heading, read_heading, sum_of
from ecume.trajectories.records import LINE, SUM, clean, line_of, sealed_line, storing, write_whole
from ecume.trajectories.segments import LARGEST, Recorder

if TYPE_CHECKING:
    from ecume.models.model import Model
    from ecume.scenes.common import Common, SamplesSpec
    from ecume.simulation import Moment

SETTLED = 1.0
"""Seconds of integration after which its speed is used to predict the remaining time."""
STATUS_EVERY = 1.0
"""Seconds of wall time between two replacements of `status.json`, at least."""


class Progress(NamedTuple):
    """The progress of a run in time steps, simulated time (s) and frames; `speed` is simulated time per wall time."""

    step: int
    steps: int | None
    """None while the total is unknown, for adaptive time steps."""
    time: float
    duration: float
    frames: int
    speed: float
    steps_per_second: float
    remaining: float | None
    """Predicted seconds of wall time; None while unknown."""

    @property
    def begun(self) -> bool:
        """Whether any step was taken in this session."""
        return self.speed > 0.0

    @property
    def place(self) -> str:
        """The text `at step 25 of 100`, or `at t = 0.5 s (step 25)` if the total is unknown."""
        return f"at step {self.step} of {self.steps}" if self.steps else f"at t = {self.time:.6g} s (step {self.step})"


class Pace:
    """The speed of the integration since the first steps of this process, without compilation."""

    def __init__(self, duration: float) -> None:
        self._duration = duration
        self._start = (0.0, 0, 0.0)
        self._heard = 0
        self.integrating = 0.0
        """Seconds of wall time in time steps, without the first, for which code is read or compiled."""

    def progress(self, moment: Moment, frames: int) -> Progress:
        """The progress at this time."""
        clock = time.monotonic()
        self._heard += 1
        if self._heard <= 2:
            self._start = (moment.done, moment.taken, clock)
        done, step, began = self._start
        self.integrating = spent = clock - began
        rate = (moment.done - done) / spent if moment.done > done and spent > 0.0 else 0.0
        known = rate and spent >= SETTLED
        return Progress(
            step=moment.taken,
            steps=moment.planned,
            time=moment.done * self._duration,
            duration=self._duration,
            frames=frames,
            speed=rate * self._duration,
            steps_per_second=(moment.taken - step) / spent if rate else 0.0,
            remaining=0.0 if moment.ended else (1.0 - moment.done) / rate if known else None,
        )


class StatusFile:
    """The file `status.json`, replaced as a whole, at most once a second except for the last state."""

    def __init__(self, home: RunDirectory) -> None:
        self._home, self._written = home, -STATUS_EVERY
        self.last_checkpoint: int | None = None

    def write(self, state: str, progress: Progress, *, last: bool = False) -> None:
        """Write the progress of the run."""
        clock = time.monotonic()
        if not last and clock - self._written < STATUS_EVERY:
            return
        self._written = clock
        report = {"state": state, **progress._asdict(), "last_checkpoint": self.last_checkpoint, "at": now()}
        try:
            write(self._home, self._home.status, report, settled=False)
        except StorageError as error:  # Windows, while another process reads it: the next second is soon enough
            if os.name != "nt" or not isinstance(error.__cause__, PermissionError):
                raise


def note(home: RunDirectory, event: str, **details: Any) -> None:
    """Add an event to the log."""
    facts = {"at": now(), "event": event, **{name: _cleaned(value) for name, value in details.items()}}
    line = sealed_line(facts, owner_of(home, home.log))
    with storing(home.log), opened(home.log, "a", home.path) as file:
        append(file, line.encode())


def _cleaned(value: Any) -> Any:
    """The details of an event, which may quote a damaged file, without characters that could have an effect."""
    if isinstance(value, list | tuple):
        return [_cleaned(each) for each in value]
    return clean(value) if isinstance(value, str) else value


POSITION = "position"
"""The name of the array that all frames have."""


class Selection(NamedTuple):
    """The arrays that are recorded: all, or those with these names."""

    names: frozenset[str] | None = None
    single: bool = False

    def of(self, frame: Frame) -> Frame:
        """The frame as it will be read from disk."""
        arrays, units = frame.arrays, frame.units
        if self.names is not None:
            omitted = [name for name in arrays if name not in self.names]
            arrays = RecordedArrays({name: arrays[name] for name in arrays if name in self.names}, omitted)
            units = {name: unit for name, unit in units.items() if name not in omitted}
        if self.single:
            rounded = {name: _rounded(array) for name, array in arrays.items()}
            arrays = RecordedArrays(rounded, arrays.omitted) if isinstance(arrays, RecordedArrays) else rounded
        return frame._replace(arrays=arrays, units=units)


def selection_of(scene: Common, model: Model) -> Selection:
    """The selection of a scene: with positions, and with quantities that the model never changes."""
    asked, single = scene.output.quantities, scene.output.precision == "single"
    return Selection(frozenset((*asked, POSITION, *model.constant)) if asked else None, single)


def _rounded(array: NDArray[Any]) -> NDArray[Any]:
    """Floating-point numbers in single precision, as float64."""
    if array.dtype.kind != "f":
        return array
    with np.errstate(over="ignore"):
        return array.astype(np.float32).astype(np.float64)


def names_quantities(scene: Common) -> bool:
    """Whether a scene names quantities that can be checked only in a frame."""
    asked = scene.output
    return bool(asked.quantities or (asked.samples and not scene.numbers.issuperset(asked.samples.numbers)))


def require_known(scene: Common, frame: Frame) -> None:
    """Raise SceneError for names of quantities that the frames of a scene do not have."""
    samples = scene.output.samples
    faults = list(_unknown("output.quantities", scene.output.quantities, frame.arrays))
    faults += _unknown("output.samples.numbers", samples.numbers if samples else (), frame.numbers)
    if faults:
        raise SceneError(faults)


def require_numbers(names: Sequence[str], frame: Frame) -> None:
    """Raise BadInput for names of numbers that a frame does not have."""
    if faults := [fault.message for fault in _unknown("", names, frame.numbers)]:
        raise BadInput(f"numbers of frames: {'; '.join(faults)}")


def _unknown(path: str, names: Sequence[str], known: Iterable[str]) -> Iterator[Fault]:
    """A fault for each name that does not exist."""
    there = list(known)
    for place, name in enumerate(names):
        if name not in there:
            near = nearest(name, there)
            hint = f"; {near}" if near.startswith("did you mean") else ""
            yield Fault(f"{path}[{place}]", f"got {name!r}; expected one of {', '.join(there)}{hint}")


LONGEST = 2**20
"""The largest number of bytes of a line."""


def scalars_line(step: int, frame: Frame, owner: str = "") -> str:
    """The line of a frame; numbers that are not finite are null."""
    return sealed_line({"step": step, "time": frame.time, **_finite(frame.numbers)}, owner)


def _finite(numbers: Mapping[str, float]) -> dict[str, float | None]:
    return {name: float(value) if math.isfinite(value) else None for name, value in numbers.items()}


def lines_of(home: RunDirectory) -> Iterator[dict[str, Any]]:
    """The numbers of the frames. Raises StorageError at the first line that is damaged."""
    if not home.scalars.exists():
        return
    checked, owner = has_checksums(home), owner_of(home, home.scalars)
    for number, content in enumerate(split(home, home.scalars), start=1):
        try:
            yield line_of(content, LINE, checked=checked, owner=owner)
        except ValueError as error:
            raise StorageError(f"{home.scalars}: damaged: line {number}: {error}") from error


def split(home: RunDirectory, path: Path) -> Iterator[bytes]:
    """The lines of a file of a run with their line breaks."""
    with storing(path), io.BufferedReader(opened(path, "r", home.path)) as file:
        while line := file.readline(LONGEST):
            yield line


def good_lines(home: RunDirectory, most: int) -> tuple[int, int]:
    """The number of undamaged lines at the beginning, at most `most`, and their size in bytes."""
    count = size = 0
    owner = owner_of(home, home.scalars)
    try:
        for content in split(home, home.scalars):
            if count == most:
                break
            line_of(content, LINE, checked=True, owner=owner)
            count, size = count + 1, size + len(content)
    except (StorageError, ValueError):
        pass
    return count, size


def continued(home: RunDirectory, former: Trajectory, frames: int) -> FileIO:
    """The table, open for appending, with one line for each of this number of frames. If lines are missing or damaged,
    all are written again from the trajectory.
    """
    with storing(home.scalars):
        count, size = good_lines(home, frames)
        if count == frames:
            file = opened(home.scalars, "a", home.path)
            os.ftruncate(file.fileno(), size)
            return file
    steps, owner = former.steps, owner_of(home, home.scalars)
    lines = (scalars_line(int(steps[number]), former[number], owner) for number in range(frames))
    write_whole(home.scalars, "".join(lines), home.path)
    with storing(home.scalars):
        return opened(home.scalars, "a", home.path)


Kept = Mapping[str, NDArray[np.float64]]
"""The position of the sampling as a checkpoint holds it."""
NOTHING: Kept = {}


class Block:
    """The average of samples that are added one after the other (Welford's algorithm): mean, minimum, maximum and
    standard error, without storing the samples.

    >>> block = Block(1)
    >>> for time in range(4):
    ...     block.add(time, np.array([float(time)]))
    >>> block.cells()
    [1.5, 4, 1.5, 0.0, 3.0, 0.6454972243679028]
    """

    def __init__(self, width: int, kept: Kept = NOTHING) -> None:
        """An empty block, or the block of a checkpoint."""
        self.count = int(kept["count"][0]) if kept else 0
        self.time = float(kept["block_time"][0]) if kept else 0.0
        empty = np.zeros(width)
        self.mean, self.squares = kept.get("mean", empty).copy(), kept.get("squares", empty).copy()
        self.least, self.largest = kept.get("least", empty).copy(), kept.get("largest", empty).copy()

    def add(self, time: float, values: NDArray[np.float64]) -> None:
        """Include a sample."""
        self.count += 1
        self.time += (time - self.time) / self.count
        with np.errstate(invalid="ignore", over="ignore"):
            ahead = values - self.mean
            self.mean = self.mean + ahead / self.count
            self.squares = self.squares + ahead * (values - self.mean)
        first = self.count == 1
        self.least = values if first else np.minimum(self.least, values)
        self.largest = values if first else np.maximum(self.largest, values)

    def cells(self) -> list[float]:
        """The mean time, the number of samples, and the mean, minimum, maximum and standard error of each number."""
        with np.errstate(invalid="ignore"):
            variance = self.squares / (self.count - 1) if self.count > 1 else np.full(len(self.mean), math.nan)
            error = np.sqrt(variance / self.count)
        rows = np.stack([self.mean, self.least, self.largest, error], axis=1)
        return [self.time, self.count, *rows.ravel().tolist()]

    def kept(self) -> dict[str, NDArray[np.float64]]:
        """The block as arrays."""
        numbers = {"count": float(self.count), "block_time": self.time}
        arrays = {"mean": self.mean, "squares": self.squares, "least": self.least, "largest": self.largest}
        return {name: np.array([value]) for name, value in numbers.items()} | arrays


class SampleFile:
    """The open table of samples of a run."""

    def __init__(self, path: Path, asked: SamplesSpec, kept: Kept = NOTHING, run: str = "") -> None:
        """Continue the table from a checkpoint, or start it; `run` is the identity of the run."""
        self._path, self._asked = path, asked
        self._crc = int(kept["crc"][0]) if "crc" in kept else sum_of(b"", run)
        self.last = int(kept["last"][0]) if kept else BEFORE
        """The position of the last sample on the model's clock."""
        self._size = int(kept["bytes"][0]) if kept else 0
        self._names: list[str] = []
        self._pending: list[str] = []
        self._sums = SumFile(path.with_name(SUMS), self._size, run) if run else None  # before what it protects
        with storing(path):
            self._file = opened(path, "a+", path.parent)
            self._file.truncate(self._size)
            if self._size:
                self._names = read_heading(self._file.readline().decode())[0]
            self._file.seek(self._size)
        self._block = Block(len(self._names), kept if self._names else NOTHING)

    def take(self, frame: Frame, step: int, last: int) -> None:
        """Include a sample; `last` is its position on the model's clock."""
        if not self._names:
            self._names = list(self._asked.numbers or frame.numbers)
            self._pending.append(heading(self._names, frame.units, blocks=self._asked.block > 1))
            self._block = Block(len(self._names))
        self.last = last
        values = np.array([frame.numbers.get(name, math.nan) for name in self._names], dtype=np.float64)
        if self._asked.block == 1:
            self._pending.append(_row(step, [frame.time, *values.tolist()]))
            return
        self._block.add(frame.time, values)
        if self._block.count == self._asked.block:
            self.end_block(step)

    def end_block(self, step: int) -> None:
        """Write the average of the samples since the last row, if there are any."""
        if self._block.count:
            self._pending.append(_row(step, self._block.cells()))
            self._block = Block(len(self._names))

    def flush(self) -> None:
        """Write complete rows."""
        left = memoryview("".join(self._pending).encode())
        self._pending = []
        with storing(self._path):
            while left:
                written = self._file.write(left)
                self._size += written
                self._crc = zlib.crc32(left[:written], self._crc)
                left = left[written:]

    def show(self) -> None:
        """Write complete rows and their checksum, which makes them visible to readers."""
        self.flush()
        if self._sums is not None:
            self._sums.add(self._size, self._crc)

    def settle(self) -> None:
        """Write complete rows to the disk, before a checkpoint refers to them."""
        self.flush()
        with storing(self._path):
            os.fsync(self._file.fileno())
        if self._sums is not None:
            self._sums.settle()

    def kept(self) -> Kept:
        """The position of the sampling, after `settle`."""
        position = {"last": np.array([float(self.last)]), "bytes": np.array([float(self._size)])}
        if self._sums is not None:
            position["crc"] = np.array([float(self._crc)])
        return position | (self._block.kept() if self._names else {})

    def close(self) -> None:
        """Close the files; a resumed run computes rows after the last checkpoint again."""
        self._file.close()
        if self._sums is not None:
            self._sums.close()


class SumFile:
    """The open file with the checksums of a table of samples: a line after each frame that has new rows."""

    def __init__(self, path: Path, size: int, run: str) -> None:
        """Continue the file for a table of this size."""
        self._path, self._owner, self._last = path, f"{run} {path.name}", 0
        with storing(path):
            self._file = opened(path, "a+", path.parent)
            content, place = read_at(self._file, 0, os.fstat(self._file.fileno()).st_size), 0
            with contextlib.suppress(ValueError):  # what follows a damaged line is written again
                for line in content.splitlines(keepends=True):
                    entry = line_of(line, SUM, checked=True, owner=self._owner)
                    if entry["bytes"] > size:
                        break
                    self._last, place = entry["bytes"], place + len(line)
            self._file.truncate(place)
            self._file.seek(place)

    def add(self, size: int, crc: int) -> None:
        """Add the checksum of this number of bytes."""
        if size > self._last:
            with storing(self._path):
                append(self._file, sealed_line({"bytes": size, "crc": crc}, self._owner).encode())
            self._last = size

    def settle(self) -> None:
        """Write all lines to the disk."""
        with storing(self._path):
            os.fsync(self._file.fileno())

    def close(self) -> None:
        """Close the file."""
        self._file.close()


SINGLE, BLOCK = ("last", "bytes", "crc", "count"), ("mean", "squares", "least", "largest")
"""The integers of the position of a sampling, and the numbers of an incomplete average."""
LARGEST_COUNT = 2.0**53


def misfit(kept: Kept) -> str:
    """The reason why arrays are not the position of a sampling; empty if they are."""
    names = {*SINGLE[:3], "count", "block_time", *BLOCK} if "count" in kept else set(SINGLE[:3])
    if kept.keys() | {"crc"} != names:
        return "its samples have other parts than a run writes"
    counts = [kept[name] for name in SINGLE if name in kept]
    if any(one.shape != (1,) or not BEFORE <= one[0] <= LARGEST_COUNT or one[0] % 1 for one in counts):
        return "the counts of its samples are not whole numbers"
    if "count" in kept and (kept["block_time"].shape != (1,) or kept["count"][0] < 0.0):
        return "its average of samples has no count or time"
    if len({kept[name].shape for name in BLOCK if name in kept} | {(0,)}) > 2 or any(
        kept[one].ndim != 1 for one in BLOCK if one in kept
    ):
        return "its average of samples has several sizes"
    return ""


def missing_rows(home: RunDirectory, kept: Kept) -> str:
    """The fault of a checkpoint whose samples are missing on disk or damaged; empty otherwise."""
    if not kept:
        return ""
    if fault := misfit(kept):
        return fault
    size = int(kept["bytes"][0])
    if size > (home.samples.stat().st_size if home.samples.exists() else 0):
        return "samples before it are missing"
    if "crc" not in kept or not size:
        return ""
    with storing(home.samples), opened(home.samples, "r", home.path) as file:
        crc, left = sum_of(b"", identity_of(home)), size
        while left > 0 and (part := file.read(min(left, LONGEST))):
            crc, left = zlib.crc32(part, crc), left - len(part)
        if crc != int(kept["crc"][0]):
            return "samples before it are damaged"
        file.seek(0)
        try:
            width = len(read_heading(file.readline().decode())[0])
        except ValueError as error:
            return f"samples before it are damaged: {error}"
    return "" if kept.get("mean", np.zeros(width)).shape == (width,) else "its average of samples has another size"


def _row(step: int, cells: Iterable[float]) -> str:
    return ",".join([str(step), *map(repr, cells)]) + "\n"


EVERYTHING = Selection()
"""All quantities of frames, in double precision."""


class Recording:
    """The open trajectory and the open table of numbers of a run; `frames` is the number of frames
    recorded so far.

    `strict` refuses frames that differ from those on disk, whatever the reason. Without `repeats` frames that are
    computed again have other bits, and replace those on disk.
    """

    def __init__(
        self,
        home: RunDirectory,
        frames: int,
        *,
        kinds: Sequence[Kind] = (),
        largest: int = LARGEST,
        strict: bool = False,
        selection: Selection = EVERYTHING,
        repeats: bool = True,
    ) -> None:
        self._repeats = repeats
        self._home, self.frames, self._strict, self._selection = home, frames, strict, selection
        names = [kind.name for kind in kinds]
        self._owner, run = owner_of(home, home.scalars), identity_of(home)
        self._recorder = Recorder(
            home.trajectory, species=names, colors=colors_of(kinds), largest=largest, single=selection.single, run=run
        )
        self._former = Trajectory(home.trajectory)
        try:
            self._scalars = continued(home, self._former, frames)
        except BaseException:
            self._former.close()
            self._recorder.close()
            raise

    @property
    def on_disk(self) -> int:
        """The number of frames in the trajectory: more than `frames` if a killed run had continued after its last
        checkpoint.
        """
        return self._recorder.frames

    def take(self, frame: Frame, step: int) -> None:
        """Record a frame: compare it with that on disk if it exists, write it otherwise."""
        frame = self._selection.of(frame)
        if self.frames < self._recorder.frames:
            self._compare(frame)
        if self.frames >= self._recorder.frames:
            self._recorder.write(frame, step)
        with storing(self._home.scalars):
            append(self._scalars, scalars_line(step, frame, self._owner).encode())
        self.frames += 1

    def settle(self) -> None:
        """Wait until everything is on disk, before a checkpoint refers to it."""
        with storing(self._home.scalars):
            os.fsync(self._scalars.fileno())

    def close(self) -> None:
        """Close the files."""
        self._former.close()
        self._recorder.close()
        with storing(self._home.scalars):
            self._scalars.close()

    def _compare(self, frame: Frame) -> None:
        if not self._repeats:
            note(self._home, "frames are written again", first=self.frames, why="the engine does not repeat bits")
            self._cut()
            return
        try:
            former = self._former[self.frames]
        except StorageError as error:  # damaged, so there is nothing to compare with
            note(self._home, "frames are written again", first=self.frames, why=str(error))
            self._cut()
            return
        if (found := difference(former, frame)) is not None:
            self._replace(frame, found)

    def _replace(self, frame: Frame, found: Difference) -> None:
        """Remove the frames on disk from this one on. Raises StorageError if they should have been equal."""
        changes = changed(circumstances_of_frame(self._home, self.frames))
        which = f"{self._home.path}: frame {self.frames} (t = {frame.time:g} s)"
        where = f"{which}, computed again, differs from the one on disk"
        if not changes:
            raise StorageError(
                f"{where} in {found}, although the processor and all versions are the same: a fault in memory, on the "
                "disk or in the program; run the scene again with --force"
            )
        if self._strict:
            raise StorageError(
                f"{where} in {found} ({'; '.join(changes)}): resume it where it was begun, or without --strict"
            )
        # Recorded before the frames are removed: frames left by a process that is killed in between are replaced next
        # time.
        replacement = {"frame": self.frames, "time": frame.time, "difference": str(found), "changed": changes}
        record(self._home, replaced=replacement)
        note(self._home, "frames replaced", **replacement)
        self._cut()
        warnings.warn(f"{where} in {found} ({'; '.join(changes)}); it and later ones are replaced", stacklevel=1)

    def _cut(self) -> None:
        """Remove the frames on disk from this one on: the present session writes them again."""
        self._former.close()
        self._recorder.cut(self.frames)
        record(self._home, first_frame=self.frames)


class Difference(NamedTuple):
    """The difference between two frames: the first quantity that differs, and the number of others."""

    quantity: str
    size: float
    """in the quantity's unit; infinite where shapes, types or finite values differ"""
    relative: float
    """over its largest value"""
    unit: str
    others: int

    def __str__(self) -> str:
        """The text `position by 1.1e-17 m (1.3e-16 of its largest value) and 3 more quantities`."""
        unit = f" {self.unit}" if self.unit not in ("", "1") else ""
        size = f" by {self.size:.1e}{unit} ({self.relative:.1e} of its largest value)" if self.size < math.inf else ""
        others = f" and {self.others} more {'quantities' if self.others > 1 else 'quantity'}" if self.others else ""
        return f"{self.quantity}{size}{others}"


def difference(one: Frame, other: Frame) -> Difference | None:
    """The difference between two frames; None if they are the same bit for bit."""
    if list(one.arrays) != list(other.arrays) or list(one.numbers) != list(other.numbers):
        return Difference("the names of its quantities", math.inf, math.inf, "", 0)
    pairs = [("time", np.asarray(one.time), np.asarray(other.time))]
    pairs += [(name, array, other.arrays[name]) for name, array in one.arrays.items()]
    numbers = other.numbers
    pairs += [(name, np.asarray(value, float), np.asarray(numbers[name], float)) for name, value in one.numbers.items()]
    differing = [(name, here, there) for name, here, there in pairs if not _same(here, there)]
    if not differing:
        return None
    name, here, there = differing[0]
    return Difference(name, *_distance(here, there), str(one.units.get(name, "")), len(differing) - 1)


def _same(one: NDArray[Any], other: NDArray[Any]) -> bool:
    return (one.shape, one.dtype) == (other.shape, other.dtype) and one.tobytes() == other.tobytes()


def _distance(one: NDArray[Any], other: NDArray[Any]) -> tuple[float, float]:
    """The largest difference of two arrays, and its ratio to their largest value."""
    if (one.shape, one.dtype) != (other.shape, other.dtype) or one.dtype.kind not in "fc":
        return math.inf, math.inf
    if not np.array_equal(np.isfinite(one), np.isfinite(other)):
        return math.inf, math.inf
    with np.errstate(invalid="ignore", over="ignore"):
        apart = np.abs(np.subtract(one, other, dtype=np.result_type(one, np.float64)))
        largest, scale = float(np.nanmax(apart, initial=0.0)), float(np.nanmax(np.abs(one), initial=0.0))
    return largest, largest / scale if 0.0 < scale < math.inf else largest
