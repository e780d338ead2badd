"""Verification of a trajectory: each byte is what was written, or is reported; and repair, which keeps whole frames.

The checksum of a frame covers its chunks: their names, shapes and data. All else in a file follows from the index:
the header, the list of names, blocks of the index that were left behind when it grew, and zeros in between. What a
killed process wrote after the last whole frame belongs to no frame; it is reported as a remark.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ecume._plain_files import place_of
from ecume.errors import StorageError
from ecume.trajectories import gsd, segments
from ecume.trajectories.gsd import ENTRY, FILE_HEADER
from ecume.trajectories.records import storing
from ecume.trajectories.segments import Segment, segment_files


class Checked(NamedTuple):
    """The number of frames of a trajectory, those before the first that is missing or damaged, and what is wrong."""

    frames: int
    good: int
    faults: tuple[str, ...]
    remarks: tuple[str, ...]


def check(folder: Path, *, trusted: frozenset[str] = frozenset()) -> Checked:
    """Verify the segments of a folder, except those whose names are `trusted`: their digests have been compared."""
    frames, good = 0, None
    faults: list[str] = []
    remarks: list[str] = []
    for path in segment_files(folder):
        try:
            segment = Segment(path)
        except StorageError as error:
            faults.append(str(error))
            good = frames if good is None else good
            continue
        with contextlib.closing(segment):
            if segment.header.first != frames:
                faults.append(f"{path}: begins with frame {segment.header.first}; expected frame {frames}")
                good = min(frames, segment.header.first) if good is None else good
            if path.name not in trusted:
                damaged = dict(damages(segment))
                if damaged and good is None:
                    good = segment.header.first + min(damaged)
                strange, after = misplaced(segment)
                faults += [*damaged.values(), *strange]
                remarks += after
            frames = segment.header.first + segment.frames
    return Checked(frames, frames if good is None else good, tuple(faults), tuple(remarks))


def good_frames(folder: Path) -> int:
    """The number of frames before the first that is missing or damaged; each of them is read."""
    frames = 0
    for path in segment_files(folder):
        with contextlib.closing(Segment(path)) as segment:
            if segment.header.first != frames:
                return frames
            if (first := next(damages(segment), None)) is not None:
                return frames + first[0]
            frames += segment.frames
    return frames


def damages(segment: Segment) -> Iterator[tuple[int, str]]:
    """The damaged frames of a segment: their numbers in it, and a line each."""
    for frame in segment.unproven():
        try:
            segment.chunks(frame)
        except StorageError as error:
            yield frame, str(error)


def misplaced(segment: Segment) -> tuple[list[str], list[str]]:
    """What is wrong with the bytes of a segment that belong to no frame, and remarks on what follows the frames."""
    index, path = segment.index, segment.path
    faults, remarks = [], []
    expected = segments.header_of(index.location, index.room, index.names)
    if segment.bytes_at(0, FILE_HEADER.itemsize) != expected:
        faults.append(f"{path}: damaged: its header is not what was written")
    listed = segments.listed(index.names)
    if segment.bytes_at(segments.NAMES_LOCATION, len(listed)) != listed:
        faults.append(f"{path}: damaged: its list of names is not what was written")
    written = index.entries.tobytes()
    block = segment.bytes_at(index.location, index.room * ENTRY.itemsize)
    if not block.startswith(written):
        faults.append(f"{path}: damaged: its index is not what was written")
    elif any(block[len(written) :]):
        remarks.append(f"{path}: an incomplete frame follows frame {segment.header.first + segment.frames - 1}")
    end, gaps = _gaps(segment, len(listed))
    for start, stop in gaps:
        if not _was_block(segment.bytes_at(start, stop - start), written):
            faults.append(f"{path}: damaged: bytes {start} to {stop}, which are of no frame, are not what was written")
    if (size := segment.size()) > end:
        remarks.append(f"{path}: {size - end} bytes follow the last whole frame")
    return faults, remarks


def _gaps(segment: Segment, names: int) -> tuple[int, list[tuple[int, int]]]:
    """The end of the data of a segment, and the stretches before it that are neither index, names nor chunks."""
    index = segment.index
    starts = index.entries["location"].astype(np.int64)
    sizes = gsd.sizes(index.entries)
    fixed = [(0, FILE_HEADER.itemsize), (index.location, index.room * ENTRY.itemsize), (segments.NAMES_LOCATION, names)]
    starts = np.concatenate([starts, np.array([start for start, _ in fixed], np.int64)])
    ends = starts + np.concatenate([sizes, np.array([size for _, size in fixed], np.int64)])
    order = np.argsort(starts, kind="stable")
    reached = np.maximum.accumulate(ends[order])
    found = np.flatnonzero(starts[order][1:] > reached[:-1])
    return int(reached[-1]), [(int(reached[k]), int(starts[order][k + 1])) for k in found]


def _was_block(content: bytes, entries: bytes) -> bool:
    """Whether this is a former block of the index: its first entries, then zeros; or nothing but zeros."""
    filled = content.rstrip(b"\0")
    whole = -(-len(filled) // ENTRY.itemsize) * ENTRY.itemsize
    return content[:whole] == entries[:whole] or not filled


class Repaired(NamedTuple):
    """The number of good frames, the faults of the others (a line each), and the files without any."""

    good: int
    faults: tuple[str, ...]
    unusable: tuple[Path, ...]


def repair(folder: Path) -> Repaired:
    """Make the segments of a folder readable again: whole frames stay, what was half written goes.

    Each damaged frame is named. A file without any whole frame is set aside, under a name that ends in `.damaged`.
    """
    good, faults, unusable = 0, [], []
    for path in segment_files(folder):
        try:
            segment = Segment(path)
        except StorageError as error:
            faults.append(str(error))
            unusable.append(_set_aside(path))
            continue
        with contextlib.closing(segment):
            found = [fault for _, fault in damages(segment)]
        segments.cut(path, segment.frames)
        good += segment.frames - len(found)
        faults += found
    return Repaired(good, tuple(faults), tuple(unusable))


def _set_aside(path: Path) -> Path:
    aside = path.with_suffix(".gsd.damaged")
    with storing(path), place_of(path, segments.root_of(path)) as place:
        place.beside(aside.name).take(place)
    return aside
