"""The files of a trajectory: reading frames, appending complete frames, verification and repair.

Verification reports every byte that was changed after writing; repair preserves complete frames.

The checksum of a frame covers its chunks: their names, shapes and data. The remaining bytes of a file follow from the
index: the header, the list of names, former blocks of the index, and zeros in between. Data that a killed process wrote
after the last complete frame belong to no frame, and are reported as a remark.
"""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import os
import struct
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from io import FileIO
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from ecume._plain_files import AT_ONCE, opened, place_of, read_at, require_memory
from ecume.errors import StorageError
from ecume.trajectories import gsd
from ecume.trajectories.frame import Frame
from ecume.trajectories.gsd import CHECKSUM, CODES, ENTRY, FILE_HEADER, NAME_UNIT, TYPES, Chunks
from ecume.trajectories.records import replacing, storing

Piece = bytes | memoryview
FIRST_ROOM = 512
"""The number of entries in the first block of an index."""
NAMES_LOCATION = gsd.FILE_HEADER.itemsize + FIRST_ROOM * ENTRY.itemsize
"""The place of the list of names."""


class Segment:
    """An open file of a trajectory, for reading; `frames` is the number of its complete frames."""

    def __init__(self, path: Path) -> None:
        self.path = path
        with storing(path):
            self._file = opened(path, "r", root_of(path))  # unbuffered, since a buffer would hide what a run writes
        try:
            self._base = 0
            self.refresh()
            self.first = self._at(0)
            self.header = gsd.read(self.first, path)
            self._base = self.header.first
        except BaseException:
            self._file.close()
            raise

    def refresh(self) -> None:
        """Read the index again, for new frames of a running run."""
        self.index = gsd.read_index(self._file, self.path)
        self.frames = self.index.frames
        self._starts = np.searchsorted(self.index.entries["frame"], np.arange(self.frames + 1))

    def chunks(self, frame: int) -> Chunks:
        """The chunks of a frame; those that never change are in the first frame. Raises StorageError if the frame is
        damaged.
        """
        chunks = {**self.first, **self._at(frame)}
        if CHECKSUM not in chunks or chunks[CHECKSUM].shape != (2, 1):
            raise StorageError(self.damage(frame, "its checksum is missing"))
        if any(name not in chunks for name in gsd.number_names(self.header)):
            raise StorageError(self.damage(frame, "a number is missing"))
        expected = [gsd.checksum(chunks), gsd.numbers_checksum(chunks, self.header)]
        if chunks[CHECKSUM][:, 0].tolist() != expected:
            raise StorageError(self.damage(frame))
        return chunks

    def unproven(self) -> Iterator[int]:
        """Yield the frames whose checksums do not match, reading the bytes piece by piece without an array for each
        chunk.
        """
        first: dict[int, tuple[bytes, int, int]] = {}
        entries = self.index.entries
        fields = (entries[name].tolist() for name in ("name", "rows", "columns", "location"))
        rows = list(zip(*fields, entries["type"].tolist(), gsd.sizes(entries).tolist(), strict=True))
        names = self.index.names
        order = sorted((name, number) for number, name in enumerate(names) if name != CHECKSUM)
        numbers = [names.index(name) for name in gsd.number_names(self.header) if name in names]
        seal = names.index(CHECKSUM)
        oversized = gsd.size_of(entries) > self.size()
        for frame in range(self.frames):
            found = dict(first)
            if oversized and gsd.overlap(entries[self._starts[frame] : self._starts[frame + 1]]):
                yield frame
                continue
            for name, count, wide, start, kind, size in rows[self._starts[frame] : self._starts[frame + 1]]:
                head = f"{names[name]} {TYPES[kind].str} {(count, wide)}".encode()
                found[name] = (head, start, start + size)
            if not frame:
                first = found
            if not _fits(self._file, found, [number for _, number in order], numbers, seal):
                yield frame

    def frame(self, number: int) -> Frame:
        """A frame by its number. Raises StorageError if it is damaged."""
        try:
            return gsd.frame_of(self.chunks(number), self.header)
        except (KeyError, ValueError, IndexError) as error:
            raise StorageError(self.damage(number, f"its data do not fit its header: {error}")) from error

    def damage(self, frame: int, why: str = "its checksum does not fit its data") -> str:
        """The message on a frame whose bytes were changed after writing."""
        return f"{self.path}: frame {self._base + frame} is damaged: {why}"

    def numbers(self) -> NDArray[np.void]:
        """The numbers of all frames, with a row per frame: the step as uint64, the time and the named numbers as
        float64.
        """
        names = gsd.number_names(self.header)
        places = np.stack([self._places(name) for name in (*names, CHECKSUM)], axis=1)
        cells = _gathered(self._file, places)
        raw, sums = cells[:, :-1].reshape(self.frames, NUMBER * len(names)), cells[:, -1, 4:].copy().view("<u4")[:, 0]
        for frame, (row, checksum) in enumerate(zip(raw, sums, strict=True)):
            if zlib.crc32(row.tobytes()) != checksum:
                raise StorageError(self.damage(frame))
        return raw.view([(name, "<u8" if row == 0 else "<f8") for row, name in enumerate(names)])[:, 0]

    def _places(self, name: str) -> NDArray[np.int64]:
        """The position in the file of the number with this name for each frame; constant numbers are stored only in the
        first frame.
        """
        if name not in self.index.names:
            raise StorageError(self.damage(0))
        entries = self.index.entries[self.index.entries["name"] == self.index.names.index(name)]
        if not len(entries) or entries["frame"][0] != 0:
            raise StorageError(self.damage(0))
        places = np.full(self.frames, entries["location"][0], np.int64)
        places[entries["frame"].astype(np.int64)] = entries["location"]
        return places

    def _at(self, frame: int) -> Chunks:
        entries = self.index.entries[self._starts[frame] : self._starts[frame + 1]]
        if gsd.overlap(entries):
            raise StorageError(self.damage(frame, "its data overlap"))
        with storing(self.path):
            require_memory(gsd.size_of(entries), self.path)
            return {self.index.names[entry["name"]]: self._chunk(entry) for entry in entries}

    def _chunk(self, entry: Any) -> NDArray[Any]:
        kind = TYPES[int(entry["type"])]
        size = int(entry["rows"]) * int(entry["columns"]) * kind.itemsize
        raw = read_at(self._file, int(entry["location"]), size)
        if len(raw) != size:
            raise OSError(f"{self.path}: ends too early")
        return np.frombuffer(raw, kind).reshape(int(entry["rows"]), int(entry["columns"]))

    def bytes_at(self, start: int, count: int) -> bytes:
        """The bytes of the file at a position, or fewer at its end."""
        with storing(self.path):
            require_memory(count, self.path)
            return read_at(self._file, start, count)

    def size(self) -> int:
        """The size of the file."""
        return os.fstat(self._file.fileno()).st_size

    def close(self) -> None:
        """Close the file."""
        self._file.close()


NUMBER = 8
"""Bytes of a number, and of the checksums of a frame."""
NEAR = 256
"""The largest distance in bytes of two numbers that are read together."""


def _gathered(file: FileIO, places: NDArray[np.int64]) -> NDArray[np.uint8]:
    """The eight bytes at each of these positions, zeros beyond the end of the file. They are copied, since a mapped
    file that another process truncates would end this process.
    """
    once, inverse = np.unique(places, return_inverse=True)
    begins = np.append(True, np.diff(once) > NEAR)
    parts, shift = [], np.zeros(len(once), np.int64)
    bounds, size = [*np.flatnonzero(begins).tolist(), len(once)], 0
    for first, last in itertools.pairwise(bounds):
        start, count = int(once[first]), int(once[last - 1] - once[first]) + NUMBER
        parts.append(read_at(file, start, count).ljust(count, b"\0"))
        shift[first:last] = size - start
        size += count
    data = np.frombuffer(b"".join(parts), np.uint8)
    cells: NDArray[np.uint8] = data[(once + shift)[inverse.reshape(places.shape)][..., None] + np.arange(NUMBER)]
    return cells


def _fits(
    file: FileIO,
    found: Mapping[int, tuple[bytes, int, int]],
    order: Sequence[int],
    numbers: Sequence[int],
    seal: int,
) -> bool:
    """Whether the checksums of a frame match its chunks, given the description, start and end of each."""
    crc = 0
    for name in order:
        if name in found:
            head, start, end = found[name]
            crc = zlib.crc32(head, crc)
            for at in range(start, end, AT_ONCE):
                crc = zlib.crc32(read_at(file, at, min(end - at, AT_ONCE)), crc)
    if seal not in found or any(name not in found for name in numbers):
        return False
    own = zlib.crc32(b"".join(read_at(file, found[name][1], found[name][2] - found[name][1]) for name in numbers))
    return read_at(file, found[seal][1], found[seal][2] - found[seal][1]) == struct.pack("<2I", crc, own)


class GrowingSegment:
    """An open file of a trajectory, for appending. When `append` returns, the frame is on the disk; a frame is either
    complete or missing.

    `size` (bytes) depends only on the frames, not on interruptions of the run.

    The GSD library is not used for writing: on a full disk it can lose frames that were committed, since it continues
    after an index that could not grow.
    """

    size: int

    def __init__(self, path: Path, frames: int) -> None:
        """Continue after this number of frames; any further data is removed."""
        with contextlib.closing(Segment(path)) as segment:
            self.path, self.header = path, segment.header
            self._first = {name: Fingerprint.of(chunk) for name, chunk in segment.first.items()}
            index = segment.index
        self.frames, self._names, self._location, self._room = frames, index.names, index.location, index.room
        with storing(path):
            self._file = opened(path, "r+", root_of(path))
        self._truncate(index.entries[index.entries["frame"] < frames], index.names_end)

    def takes(self, chunks: Chunks) -> bool:
        """Whether the frame has the same arrays and numbers as the previous frames."""
        return chunks.keys() == self._first.keys() and self._first[gsd.HEADER].fits(chunks[gsd.HEADER])

    def append(self, chunks: Chunks) -> None:
        """Commit one frame: those of its chunks that differ from the first frame."""
        own = {name: chunk for name, chunk in chunks.items() if name == CHECKSUM or not self._first[name].fits(chunk)}
        if self._used + len(own) > self._room:
            self._grow()
        entries, pieces = _packed(own, self._names, self.frames, self.size)
        end = self.size
        for piece in pieces:
            self._write(piece, end)
            end += len(piece)
        # a single wait for the disk is sufficient: after a power failure between the writes, the checksum differs
        self._put(entries.tobytes(), self._location + self._used * ENTRY.itemsize)
        self.size = end
        self._used += len(entries)
        self.frames += 1

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _grow(self) -> None:
        """Allocate a larger block of entries at the end of the file; the header refers to it once it is on disk."""
        room = 2 * max(self._room, FIRST_ROOM)
        self._file.seek(self._location)
        block = self._file.read(self._used * ENTRY.itemsize).ljust(room * ENTRY.itemsize, b"\0")
        self._put(block, self.size)
        self._put(header_of(self.size, room, self._names), 0)
        self._location, self._room = self.size, room
        self.size += len(block)

    def _truncate(self, entries: NDArray[Any], names_end: int) -> None:
        """Truncate the file to the frames that remain, after an interruption or damage."""
        block = entries.tobytes().ljust(self._room * ENTRY.itemsize, b"\0")
        self._used = len(entries)
        self.size = max(names_end, self._location + len(block), _data_end(entries))
        self._put(header_of(self._location, self._room, self._names), 0)
        self._put(block, self._location)
        if (gap := self._location - max(names_end, _data_end(entries))) > 0:  # clear the names of removed frames
            self._put(bytes(gap), self._location - gap)
        with storing(self.path):
            self._file.truncate(self.size)
            os.fsync(self._file.fileno())

    def _put(self, data: bytes, place: int) -> None:
        """Write all data at a position, and wait until it is on disk."""
        self._write(data, place)
        with storing(self.path):
            os.fsync(self._file.fileno())

    def _write(self, data: Piece, place: int) -> None:
        """Write all data at a position; after an error, release the allocated space."""
        with storing(self.path):
            try:
                self._file.seek(place)
                left = memoryview(data)
                while left:
                    left = left[self._file.write(left) :]
            except OSError:
                with contextlib.suppress(OSError):  # a failure is reported in any case
                    self._file.truncate(self.size)
                raise


def create(path: Path, chunks: Chunks) -> None:
    """Create a file with its first frame, either completely or not at all."""
    names = tuple(chunks)
    names_after = listed(names)
    entries, pieces = _packed(chunks, names, 0, NAMES_LOCATION + len(names_after))
    header = header_of(gsd.FILE_HEADER.itemsize, FIRST_ROOM, names)
    block = entries.tobytes().ljust(FIRST_ROOM * ENTRY.itemsize, b"\0")
    with replacing(path, root_of(path)) as file:
        file.write(header + block + names_after)
        for piece in pieces:
            file.write(piece)


def listed(names: Sequence[str]) -> bytes:
    """The list of names in the format of a file."""
    content = b"".join(name.encode() + b"\0" for name in names) + b"\0"
    return content + b"\0" * (-len(content) % NAME_UNIT)


def header_of(location: int, room: int, names: Sequence[str]) -> bytes:
    """The header of a file with these names and this block of entries."""
    header = np.zeros(1, gsd.FILE_HEADER)
    header["magic"], header["schema"], header["application"] = gsd.MAGIC, b"hoomd", b"ecume"
    header["schema_version"], header["gsd_version"] = 1 << 16 | 4, 2 << 16
    header["index_location"], header["index_room"] = location, room
    header["names_location"], header["names_room"] = NAMES_LOCATION, len(listed(names)) // NAME_UNIT
    return header.tobytes()


def cut(path: Path, frames: int) -> None:
    """Truncate a file to its first frames; remove a file without frames."""
    if frames:
        GrowingSegment(path, frames).close()
        return
    with storing(path), place_of(path, root_of(path)) as place:
        place.unlink()
        place.settle()


def root_of(path: Path) -> Path:
    """The folder of a segment below which links are not followed: the run directory, or the folder of a trajectory."""
    folder = path.parent
    return folder.parent if folder.name == "traj" else folder


def _packed(chunks: Chunks, names: Sequence[str], frame: int, start: int) -> tuple[NDArray[Any], Iterator[Piece]]:
    """The entries of a frame in the order of its names, and its data in pieces, for the position `start`."""
    numbers = {name: number for number, name in enumerate(names)}
    entries = np.zeros(len(chunks), ENTRY)
    for entry, name in zip(entries, sorted(chunks, key=numbers.__getitem__), strict=True):
        chunk = chunks[name]
        entry["frame"], entry["location"], entry["name"] = frame, start, numbers[name]
        entry["rows"], entry["columns"], entry["type"] = *chunk.shape, CODES[chunk.dtype]
        start += chunk.nbytes
    return entries, _pieces(chunks[names[entry["name"]]] for entry in entries)


def _pieces(chunks: Iterable[NDArray[Any]]) -> Iterator[Piece]:
    """The bytes of chunks one after the other: small chunks together, large ones without a copy."""
    small: list[Piece] = []
    for chunk in chunks:
        small.append(_bytes_of(chunk))
        if len(small[-1]) >= AT_ONCE:
            large = small.pop()
            yield b"".join(small)
            yield large
            small.clear()
    yield b"".join(small)


def _bytes_of(chunk: NDArray[Any]) -> memoryview:
    """The bytes of an array, without a copy if it is contiguous."""
    return np.ascontiguousarray(chunk).reshape(-1).view(np.uint8).data


def _data_end(entries: NDArray[Any]) -> int:
    return int((entries["location"] + gsd.sizes(entries)).max(initial=0))


HEAD = 4096


class Fingerprint(NamedTuple):
    """What identifies the bits of an array without keeping them: of large trajectories, the first frame would take a
    tenth of the memory of a run.
    """

    kind: np.dtype[Any]
    shape: tuple[int, ...]
    head: bytes
    """the first bytes, which differ in most arrays that change"""
    digest: bytes

    @classmethod
    def of(cls, chunk: NDArray[Any]) -> Self:
        """The fingerprint of an array."""
        data = _bytes_of(chunk)
        return cls(chunk.dtype, chunk.shape, bytes(data[:HEAD]), hashlib.sha256(data).digest())

    def fits(self, chunk: NDArray[Any]) -> bool:
        """Whether an array has the same bits: a NaN equals itself, and minus zero differs from zero."""
        data = _bytes_of(chunk)
        alike = (chunk.dtype, chunk.shape) == (self.kind, self.shape) and data[:HEAD] == self.head
        return alike and hashlib.sha256(data).digest() == self.digest


LARGEST = 512 * 2**20
"""The size in bytes after which a new segment is started."""


def segment_files(folder: Path) -> list[Path]:
    """The segments of a trajectory, in order."""
    return sorted(path for path in folder.glob("*.gsd") if path.stem.isdecimal())


class Recorder:
    """An open trajectory, a folder with `0000.gsd`, `0001.gsd` and so on, to which frames are appended.

    New frames continue those in an existing folder. When `write` returns, the complete frame is on the disk.
    """

    def __init__(
        self,
        folder: Path,
        *,
        species: Sequence[str] = (),
        colors: Sequence[str] = (),
        largest: int = LARGEST,
        single: bool = False,
        run: str = "",
    ) -> None:
        """Open or create a trajectory. `species` are the names of species in the order of their numbers, and `colors`
        their colors, `#rrggbb`, for viewers of the files. `single` is the precision of arrays, `run` the identity of
        the run.
        """
        self.folder, self._species, self._colors, self._largest = folder, tuple(species), tuple(colors), largest
        self._single, self._run = single, run
        with storing(folder):
            folder.mkdir(parents=True, exist_ok=True)
        self._segment: GrowingSegment | None = None
        self._attach()

    def write(self, frame: Frame, step: int) -> None:
        """Commit one frame, recorded at this time step."""
        if self._segment is None or not self._appended(self._segment, frame, step):
            self._begin(frame, step)
        self.frames += 1

    def cut(self, frames: int) -> None:
        """Remove all but the first frames."""
        self.close()
        for path in reversed(segment_files(self.folder)):
            with contextlib.closing(Segment(path)) as segment:
                first, held = segment.header.first, segment.frames
            if first + held > frames:
                cut(path, max(0, frames - first))
        self._attach()

    def close(self) -> None:
        """Close the file."""
        if self._segment is not None:
            self._segment.close()
        self._segment = None

    def __enter__(self) -> Self:
        """The recorder itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the file."""
        self.close()

    def _attach(self) -> None:
        """Continue the last segment, truncated to its complete frames."""
        files = segment_files(self.folder)
        self._number, self.frames = int(files[-1].stem) + 1 if files else 0, 0
        if files:
            with contextlib.closing(Segment(files[-1])) as segment:
                held = segment.frames
            self._segment = GrowingSegment(files[-1], held)
            self.frames = self._segment.header.first + held

    def _appended(self, segment: GrowingSegment, frame: Frame, step: int) -> bool:
        """Append the frame to this segment; return False if it has no room."""
        header = self._header(frame, segment.header.first)
        chunks = gsd.chunks_of(frame, step, header, self._colors)
        if not segment.takes(chunks) or segment.size + sum(chunk.nbytes for chunk in chunks.values()) > self._largest:
            return False
        segment.append(chunks)
        return True

    def _header(self, frame: Frame, first: int) -> gsd.Header:
        return gsd.header_of(frame, first, self._species, single=self._single)._replace(run=self._run)

    def _begin(self, frame: Frame, step: int) -> None:
        """Start a new segment with this frame."""
        self.close()
        path = self.folder / f"{self._number:04d}.gsd"
        create(path, gsd.chunks_of(frame, step, self._header(frame, self.frames), self._colors))
        self._segment = GrowingSegment(path, 1)
        self._number += 1


class Checked(NamedTuple):
    """The number of frames of a trajectory, the number before the first missing or damaged one, and the faults."""

    frames: int
    good: int
    faults: tuple[str, ...]
    remarks: tuple[str, ...]


def require_own(segment: Segment, run: str) -> None:
    """Raise StorageError if the segment belongs to a run with another identity."""
    if segment.header.run != run:
        raise StorageError(f"{segment.path}: is of another run")


def set_foreign_aside(folder: Path, run: str) -> list[str]:
    """Rename the segments of other runs. Returns a list of the actions."""
    found = []
    for path in segment_files(folder):
        with contextlib.suppress(StorageError), contextlib.closing(Segment(path)) as segment:
            if segment.header.run != run:
                found.append(f"{path}: is of another run; set aside as {_set_aside(path).name}")
    return found


def check(folder: Path, *, trusted: frozenset[str] = frozenset(), run: str = "") -> Checked:
    """Verify the segments of a folder, except the `trusted` ones, whose digests have already been compared. All must
    belong to the run with this identity.
    """
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
            if segment.header.run != run:
                faults.append(f"{path}: is of another run")
                good = frames if good is None else good
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
    """The number of frames before the first missing or damaged one, after reading them."""
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
    """The damaged frames of a segment: their numbers in it, and a message for each."""
    for frame in segment.unproven():
        try:
            segment.chunks(frame)
        except StorageError as error:
            yield frame, str(error)


def misplaced(segment: Segment) -> tuple[list[str], list[str]]:
    """The faults of bytes of a segment that belong to no frame, and remarks on data after the frames."""
    index, path = segment.index, segment.path
    faults, remarks = [], []
    expected = header_of(index.location, index.room, index.names)
    if segment.bytes_at(0, FILE_HEADER.itemsize) != expected:
        faults.append(f"{path}: damaged: its header is not what was written")
    names = listed(index.names)
    if segment.bytes_at(NAMES_LOCATION, len(names)) != names:
        faults.append(f"{path}: damaged: its list of names is not what was written")
    written = index.entries.tobytes()
    block = segment.bytes_at(index.location, index.room * ENTRY.itemsize)
    if not block.startswith(written):
        faults.append(f"{path}: damaged: its index is not what was written")
    elif any(block[len(written) :]):
        remarks.append(f"{path}: an incomplete frame follows frame {segment.header.first + segment.frames - 1}")
    end, gaps = _gaps(segment, len(names))
    for start, stop in gaps:
        if not _was_block(segment.bytes_at(start, stop - start), written):
            faults.append(f"{path}: damaged: bytes {start} to {stop}, which are of no frame, are not what was written")
    if (size := segment.size()) > end:
        remarks.append(f"{path}: {size - end} bytes follow the last whole frame")
    return faults, remarks


def _gaps(segment: Segment, names: int) -> tuple[int, list[tuple[int, int]]]:
    """The end of the data of a segment, and the ranges before it that are neither index, names nor chunks."""
    index = segment.index
    starts = index.entries["location"].astype(np.int64)
    sizes = gsd.sizes(index.entries)
    fixed = [(0, FILE_HEADER.itemsize), (index.location, index.room * ENTRY.itemsize), (NAMES_LOCATION, names)]
    starts = np.concatenate([starts, np.array([start for start, _ in fixed], np.int64)])
    ends = starts + np.concatenate([sizes, np.array([size for _, size in fixed], np.int64)])
    order = np.argsort(starts, kind="stable")
    reached = np.maximum.accumulate(ends[order])
    found = np.flatnonzero(starts[order][1:] > reached[:-1])
    return int(reached[-1]), [(int(reached[k]), int(starts[order][k + 1])) for k in found]


def _was_block(content: bytes, entries: bytes) -> bool:
    """Whether this is a former block of the index: its first entries followed by zeros."""
    filled = content.rstrip(b"\0")
    whole = -(-len(filled) // ENTRY.itemsize) * ENTRY.itemsize
    return content[:whole] == entries[:whole] or not filled


class Repaired(NamedTuple):
    """The number of undamaged frames, the faults of the others (a line each), and the files without any undamaged
    frame.
    """

    good: int
    faults: tuple[str, ...]
    unusable: tuple[Path, ...]


def repair(folder: Path) -> Repaired:
    """Repair the segments of a folder: complete frames remain, incomplete ones are removed.

    Each damaged frame is reported. A file without any complete frame is renamed with the ending `.damaged`.
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
        cut(path, segment.frames)
        good += segment.frames - len(found)
        faults += found
    return Repaired(good, tuple(faults), tuple(unusable))


def _set_aside(path: Path) -> Path:
    aside = path.with_suffix(".gsd.damaged")
    with storing(path), place_of(path, root_of(path)) as place:
        place.beside(aside.name).take(place)
    return aside
