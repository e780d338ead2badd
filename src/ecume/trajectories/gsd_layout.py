"""The layout of a GSD file, and the reading of its index, also that of a damaged or a growing file.

A GSD file (version 2) is a header, a block of index entries, a list of names, and chunks of data; a block that is full
is copied to the end of the file at twice its size, and the old one stays where it was. So a file that lost its end
still holds an older index. A frame is whole when its last chunk, the checksum, is in the index.
"""

from __future__ import annotations

from io import FileIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._plain_files import require_memory
from ecume.errors import StorageError

MAGIC = 0x65DF65DF65DF65DF
HEADER = np.dtype(
    [
        ("magic", "<u8"),
        ("index_location", "<u8"),
        ("index_room", "<u8"),
        ("names_location", "<u8"),
        ("names_room", "<u8"),
        ("schema_version", "<u4"),
        ("gsd_version", "<u4"),
        ("application", "S64"),
        ("schema", "S64"),
        ("reserved", "S80"),
    ]
)
ENTRY = np.dtype(
    [
        ("frame", "<u8"),
        ("rows", "<u8"),
        ("location", "<i8"),
        ("columns", "<u4"),
        ("name", "<u2"),
        ("type", "u1"),
        ("flags", "u1"),
    ]
)
TYPES = {
    code: np.dtype(kind)
    for code, kind in enumerate(("u1", "<u2", "<u4", "<u8", "i1", "<i2", "<i4", "<i8", "<f4", "<f8"), start=1)
}
CODES = {kind: code for code, kind in TYPES.items()}
NAME_UNIT = 64
"""The room of the list of names is counted in these."""
CHECKSUM = "ecume/crc32"
"""The chunk that makes a frame whole."""

UNKNOWN = Path("a file of frames")

_SIZES = np.array([TYPES[code].itemsize if code in TYPES else 0 for code in range(256)], dtype=np.int64)


class Index(NamedTuple):
    """The index of a file: its names, the entries of its frames in order, and the place of the block of entries."""

    names: tuple[str, ...]
    entries: NDArray[Any]
    frames: int
    """Up to the last whole frame; one in between may be damaged."""
    location: int
    room: int
    names_end: int


def read_index(file: FileIO, path: Path) -> Index:
    """The index of an open file. Raises StorageError where no frame can be found."""
    header, size = _steady_header(file, path), _size(file)
    names, names_end = _names(file, header)
    location, room = int(header["index_location"]), int(header["index_room"])
    index = _walked(file, names, names_end, location, room)
    if location + room * ENTRY.itemsize > size or index.frames == 0:
        index = max((index, *_older(file, names, names_end)), key=lambda one: one.frames)
    if index.frames == 0:
        raise StorageError(f"{path}: damaged: no whole frame is left in it")
    return index


def _steady_header(file: FileIO, path: Path) -> Any:
    """A run may be replacing the header: read until two readings agree."""
    before, now = b"", _bytes(file, 0, HEADER.itemsize)
    while now != before:
        before, now = now, _bytes(file, 0, HEADER.itemsize)
    if len(now) < HEADER.itemsize or (header := np.frombuffer(now, HEADER)[0])["magic"] != MAGIC:
        raise StorageError(f"{path}: not a GSD file, or its beginning is damaged")
    if header["gsd_version"] >> 16 != 2:
        raise StorageError(f"{path}: a GSD file of version {header['gsd_version'] >> 16}; expected version 2")
    return header


def _names(file: FileIO, header: Any) -> tuple[tuple[str, ...], int]:
    start = int(header["names_location"])
    raw = _bytes(file, start, int(header["names_room"]) * NAME_UNIT)
    listed = raw.split(b"\0\0", 1)[0]
    return tuple(name.decode(errors="replace") for name in listed.split(b"\0") if name), start + len(raw)


def _walked(file: FileIO, names: tuple[str, ...], names_end: int, location: int, room: int) -> Index:
    """The index at this place, without entries that cannot be true and without frames that never became whole."""
    raw = _bytes(file, location, room * ENTRY.itemsize)
    entries = np.frombuffer(raw[: len(raw) // ENTRY.itemsize * ENTRY.itemsize], ENTRY)
    entries = entries[_credible(entries, len(names), _size(file))]
    entries = entries[np.argsort(entries["frame"], kind="stable")]
    last = entries["frame"][entries["name"] == names.index(CHECKSUM)] if CHECKSUM in names else entries["frame"][:0]
    frames = int(last[-1]) + 1 if len(last) else 0
    return Index(names, entries[entries["frame"] < frames], frames, location, room, names_end)


def _credible(entries: NDArray[Any], names: int, size: int) -> NDArray[np.bool_]:
    """The entries that may be true: of a known name and type, inside the file."""
    most = np.uint64(size)
    cells = np.minimum(entries["rows"], most) * np.minimum(entries["columns"].astype("u8"), most)
    ends = entries["location"].astype("u8") + np.minimum(cells, most) * _SIZES[entries["type"]].astype("u8")
    known = (_SIZES[entries["type"]] > 0) & (entries["name"] < names) & (entries["flags"] == 0)
    credible: NDArray[np.bool_] = known & (entries["location"] >= HEADER.itemsize) & (ends <= most)
    return credible & (entries["frame"] <= np.uint64(len(entries)))


def sizes(entries: NDArray[Any]) -> NDArray[np.int64]:
    """The bytes of the data of each of these entries, all of which are credible."""
    cells = entries["rows"].astype(np.int64) * entries["columns"].astype(np.int64)
    found: NDArray[np.int64] = cells * _SIZES[entries["type"]]
    return found


def size_of(entries: NDArray[Any]) -> int:
    """The bytes of the data of all of these entries."""
    return sum(sizes(entries).tolist())


def overlap(entries: NDArray[Any]) -> bool:
    """Whether some of these entries refer to the same bytes: no writer does that, and a small file could fill the
    memory.
    """
    order = np.argsort(entries["location"], kind="stable")
    starts, ends = entries["location"][order], (entries["location"] + sizes(entries))[order]
    return bool(np.any(starts[1:] < np.maximum.accumulate(ends)[:-1])) if len(entries) > 1 else False


def _older(file: FileIO, names: tuple[str, ...], names_end: int) -> list[Index]:
    """Earlier blocks of the index, that growing left behind: all begin with the same entry."""
    size = _size(file)
    first = _bytes(file, HEADER.itemsize, ENTRY.itemsize)
    if not any(first):
        return []
    whole, start, found = _bytes(file, 0, size), 0, []
    while (start := whole.find(first, start)) >= 0:
        found.append(_walked(file, names, names_end, start, _run_of_entries(whole, start, len(names))))
        start += ENTRY.itemsize
    return found


def _run_of_entries(whole: bytes, start: int, names: int) -> int:
    """The number of entries here in a row: an older block ends where its entries end, and what follows is data."""
    raw = np.frombuffer(whole, ENTRY, count=(len(whole) - start) // ENTRY.itemsize, offset=start)
    credible = _credible(raw, names, len(whole))
    return len(raw) if credible.all() else int(np.argmin(credible))


def _size(file: FileIO) -> int:
    return file.seek(0, 2)


def _bytes(file: FileIO, start: int, count: int, path: Path = UNKNOWN) -> bytes:
    """The bytes of the file there; fewer at the end of the file, whatever a damaged header requests."""
    size = _size(file)
    if start >= size:
        return b""
    require_memory(min(count, size - start), path)
    file.seek(start)
    return file.read(min(count, size - start))


def read_whole_index(file: FileIO, path: Path) -> Index:
    """The index of an open file that any program has written and closed: its frames have no checksum."""
    header = _steady_header(file, path)
    names, names_end = _names(file, header)
    location, room = int(header["index_location"]), int(header["index_room"])
    raw = _bytes(file, location, room * ENTRY.itemsize)
    entries = np.frombuffer(raw[: len(raw) // ENTRY.itemsize * ENTRY.itemsize], ENTRY)
    entries = entries[_credible(entries, len(names), _size(file))]
    frames = int(entries["frame"].max(initial=0)) + 1 if len(entries) else 0
    if frames == 0:
        raise StorageError(f"{path}: no frame is in it")
    return Index(names, entries, frames, location, room, names_end)
