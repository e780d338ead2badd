"""The layout of GSD files, and the conversion of frames to their chunks.

A GSD file (version 2) consists of a header, a block of index entries, a list of names, and chunks of data. A block that
is full is copied to the end of the file with twice its size, and the old block remains. A file whose end is lost
therefore still contains an older index, so that damaged and growing files can be read. A frame is complete when its
last chunk, the checksum, is in the index.

HOOMD's chunks allow OVITO and other readers of GSD to show the particles: positions and velocities in single precision
with three components, diameter, type. ecume's chunks are exact: `log/time`, `log/<number>`, `log/particles/<array>`,
and `ecume/header`, which describes the arrays and their units once. The arrays of a trajectory in single precision are
`<f4`, without copies of arrays that are in HOOMD's chunks; it is read as float64. Positions in a periodic box have a
second copy, since HOOMD's are relative to the middle of the box.
"""

from __future__ import annotations

import json
import math
import os
import re
import zlib
from collections.abc import Mapping, Sequence
from io import FileIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._plain_files import read_at, require_memory
from ecume.errors import BadInput, StorageError
from ecume.trajectories.frame import Frame, RecordedArrays, omitted_from

MAGIC = 0x65DF65DF65DF65DF
FILE_HEADER = np.dtype(
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
"""The increment in bytes of the list of names."""
CHECKSUM = "ecume/crc32"
"""The name of the chunk that completes a frame."""

UNKNOWN = Path("a file of frames")

_SIZES = np.array([TYPES[code].itemsize if code in TYPES else 0 for code in range(256)], dtype=np.int64)


class Index(NamedTuple):
    """The index of a file: its names, the entries of its frames in order, and the position of the block of entries."""

    names: tuple[str, ...]
    entries: NDArray[Any]
    frames: int
    """Up to the last whole frame; one in between may be damaged."""
    location: int
    room: int
    names_end: int


def read_index(file: FileIO, path: Path) -> Index:
    """The index of an open file. Raises StorageError if no frame can be found."""
    header, size = _steady_header(file, path), _size(file)
    names, names_end = _names(file, header)
    location, room = int(header["index_location"]), int(header["index_room"])
    index = _walked(file, names, names_end, location, room)
    if location + room * ENTRY.itemsize > size or index.frames == 0:
        index = max((index, _older(file, names, names_end, index)), key=lambda one: one.frames)
    if index.frames == 0:
        raise StorageError(f"{path}: damaged: no whole frame is left in it")
    return index


def _steady_header(file: FileIO, path: Path) -> Any:
    """The header; it is read until two readings agree, since a run may be replacing it."""
    before, now = b"", _bytes(file, 0, FILE_HEADER.itemsize)
    while now != before:
        before, now = now, _bytes(file, 0, FILE_HEADER.itemsize)
    if len(now) < FILE_HEADER.itemsize or (header := np.frombuffer(now, FILE_HEADER)[0])["magic"] != MAGIC:
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
    """The index at this place, without impossible entries and without incomplete frames."""
    raw = _bytes(file, location, room * ENTRY.itemsize)
    entries = np.frombuffer(raw[: len(raw) // ENTRY.itemsize * ENTRY.itemsize], ENTRY)
    entries = entries[_credible(entries, len(names), _size(file))]
    entries = entries[np.argsort(entries["frame"], kind="stable")]
    last = entries["frame"][entries["name"] == names.index(CHECKSUM)] if CHECKSUM in names else entries["frame"][:0]
    frames = int(last[-1]) + 1 if len(last) else 0
    return Index(names, entries[entries["frame"] < frames], frames, location, room, names_end)


def _credible(entries: NDArray[Any], names: int, size: int) -> NDArray[np.bool_]:
    """Flags of the entries that are possible: of a known name and type, inside the file."""
    most = np.uint64(size)
    cells = np.minimum(entries["rows"], most) * np.minimum(entries["columns"].astype("u8"), most)
    ends = entries["location"].astype("u8") + np.minimum(cells, most) * _SIZES[entries["type"]].astype("u8")
    known = (_SIZES[entries["type"]] > 0) & (entries["name"] < names) & (entries["flags"] == 0)
    credible: NDArray[np.bool_] = known & (entries["location"] >= FILE_HEADER.itemsize) & (ends <= most)
    return credible & (entries["frame"] <= np.uint64(size // ENTRY.itemsize))


def sizes(entries: NDArray[Any]) -> NDArray[np.int64]:
    """The data sizes of these entries in bytes. Raises an error for implausible ones."""
    cells = entries["rows"].astype(np.int64) * entries["columns"].astype(np.int64)
    found: NDArray[np.int64] = cells * _SIZES[entries["type"]]
    return found


def size_of(entries: NDArray[Any]) -> int:
    """The total size (bytes) of the data of these entries."""
    return sum(sizes(entries).tolist())


def overlap(entries: NDArray[Any]) -> bool:
    """Whether some of these entries refer to the same bytes. No writer produces this, and it could exhaust the memory
    when reading a small file.
    """
    order = np.argsort(entries["location"], kind="stable")
    starts, ends = entries["location"][order], (entries["location"] + sizes(entries))[order]
    return bool(np.any(starts[1:] < np.maximum.accumulate(ends)[:-1])) if len(entries) > 1 else False


MOST_BLOCKS = 64
"""The largest number of blocks of an index, each twice as large as the previous one."""
FIRST_LOOK = 64
"""The number of entries that are read first to find the end of a block."""


def _older(file: FileIO, names: tuple[str, ...], names_end: int, none: Index) -> Index:
    """The best of the earlier blocks of the index, which remain in the file when the index grows and begin with the
    same entry.
    """
    size = _size(file)
    first = _bytes(file, FILE_HEADER.itemsize, ENTRY.itemsize)
    if not any(first):
        return none
    whole, start, best = _bytes(file, 0, size), 0, none
    for _ in range(MOST_BLOCKS):
        if (start := whole.find(first, start)) < 0:
            break
        count = _run_of_entries(whole, start, len(names))
        best = max((best, _walked(file, names, names_end, start, count)), key=lambda one: one.frames)
        start += max(count, 1) * ENTRY.itemsize
    return best


def _run_of_entries(whole: bytes, start: int, names: int) -> int:
    """The number of consecutive entries here; an older block ends at its last entry, and data follow."""
    most, found, look = (len(whole) - start) // ENTRY.itemsize, 0, FIRST_LOOK
    while found < most:
        count = min(look, most - found)
        raw = np.frombuffer(whole, ENTRY, count=count, offset=start + found * ENTRY.itemsize)
        credible = _credible(raw, names, len(whole))
        if not credible.all():
            return found + int(np.argmin(credible))
        found, look = found + count, 2 * look
    return found


def _size(file: FileIO) -> int:
    return os.fstat(file.fileno()).st_size


def _bytes(file: FileIO, start: int, count: int, path: Path = UNKNOWN) -> bytes:
    """The bytes of the file at a position, or fewer at the end of the file."""
    size = _size(file)
    if start >= size:
        return b""
    require_memory(min(count, size - start), path)
    return read_at(file, start, min(count, size - start))


def read_whole_index(file: FileIO, path: Path) -> Index:
    """The index of a complete file of any program, whose frames have no checksum."""
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


HEADER = "ecume/header"
FORMAT = 1
MOST_FRAMES = 2**40
"""The largest number of frames of a trajectory."""
WIDEST, DEEPEST = 1000, 4
"""The largest numbers of components of an array, and of its axes."""
NAME, LABEL = re.compile(r"[A-Za-z0-9_]{1,200}"), re.compile(r"[^\x00-\x1f\x7f-\x9f\u2028\u2029]{0,200}")
"""Patterns of valid names of arrays and numbers, of units, and of names of species."""
Chunks = dict[str, NDArray[Any]]
"""The two-dimensional arrays of a file by name."""


class Header(NamedTuple):
    """The data that all frames of a segment share; `first` is the number of its first frame in the trajectory."""

    first: int
    arrays: Mapping[str, tuple[str, tuple[int, ...]]]
    numbers: tuple[str, ...]
    units: Mapping[str, str]
    species: tuple[str, ...] = ()
    """The names of the species in the order of their numbers, as far as they have names."""
    omitted: tuple[str, ...] = ()
    """The names of the arrays that the scene omits."""
    run: str = ""
    """The identity of the run, see `records.identity`; every frame's checksum covers it."""


FORMER_NUMBERS = {"came": "particles_entered", "left": "particles_left", "lost": "particles_lost"}
"""The present names of numbers by their names in files of former versions."""
FORMER_BEGINNINGS = {"came_through_opening_": "entered_through_opening_"}
"""The same for the beginnings of numbered names."""


def present_name(number: str) -> str:
    """The present name of a number that frames contain, which may have had another name.

    >>> present_name("came_through_opening_1"), present_name("hits")
    ('entered_through_opening_1', 'hits')
    """
    for former, present in FORMER_BEGINNINGS.items():
        if number.startswith(former):
            return present + number.removeprefix(former)
    return FORMER_NUMBERS.get(number, number)


SINGLE = "<f4"
SIDES = ("box_width", "box_height", "box_depth")
"""The numbers of a frame that are the sides of a periodic box; zero or missing along other axes."""


def header_of(frame: Frame, first: int, species: Sequence[str] = (), *, single: bool = False) -> Header:
    """The header of a segment that begins with this frame; `single` is the precision of its arrays."""
    arrays = {name: (array.dtype.str, array.shape[1:]) for name, array in frame.arrays.items()}
    for name, (kind, shape) in arrays.items():
        if kind not in ("<f8", "<i8") or 0 in shape:
            raise BadInput(f"the array {name} of a frame is {np.dtype(kind)} {shape}; expected float64 or int64")
    if "time" in frame.numbers:
        raise BadInput("a number of a frame is called time; the time is what a frame has besides")
    for name in (*arrays, *frame.numbers):
        if not NAME.fullmatch(name):
            raise BadInput(f"the name {name!r} of a frame: expected at most 200 letters, digits and underscores")
    if single:
        arrays = {name: (SINGLE if kind == "<f8" else kind, shape) for name, (kind, shape) in arrays.items()}
    return Header(first, arrays, tuple(frame.numbers), dict(frame.units), tuple(species), omitted_from(frame))


def written(header: Header) -> NDArray[Any]:
    """The header as a chunk."""
    plain = {"format": FORMAT, **header._asdict()}
    for name in ("omitted", "run"):
        if not plain[name]:
            del plain[name]
    return _column(np.frombuffer(json.dumps(plain, separators=(",", ":")).encode(), np.uint8))


def read(chunks: Chunks, source: object) -> Header:
    """The header among the chunks of a segment's first frame. Raises StorageError if it is not readable."""
    try:
        plain = json.loads(chunks[HEADER].tobytes())
        found = plain["format"]
        arrays = {str(name): (str(kind), tuple(shape)) for name, (kind, shape) in plain["arrays"].items()}
        units = {str(name): str(unit) for name, unit in plain["units"].items()}
        header = Header(int(plain["first"]), arrays, tuple(map(str, plain["numbers"])), units)
        species, omitted = (tuple(map(str, plain.get(name, ()))) for name in ("species", "omitted"))
        header = header._replace(species=species, omitted=omitted, run=str(plain.get("run", "")))
        _require_possible(header)
    except (KeyError, ValueError, TypeError, AttributeError, RecursionError, OverflowError) as error:
        raise StorageError(f"{source}: not written by ecume, or its header is damaged") from error
    if found != FORMAT:
        raise StorageError(f"{source}: a trajectory of format {found}; this version of ecume reads format {FORMAT}")
    return header


def _require_possible(header: Header) -> None:
    """Raise ValueError for a header that no run writes."""
    if not 0 <= header.first < MOST_FRAMES or "position" not in header.arrays:
        raise ValueError("no such frames")
    if not all(map(NAME.fullmatch, (*header.arrays, *header.numbers, *header.units, *header.omitted))):
        raise ValueError("no such names")
    if not all(map(LABEL.fullmatch, (*header.units.values(), *header.species))):
        raise ValueError("no such units or species")
    for kind, shape in header.arrays.values():
        wide = all(type(side) is int and 0 < side <= WIDEST for side in shape)
        if kind not in ("<f8", "<i8", SINGLE) or len(shape) > DEEPEST or not wide:
            raise ValueError("no such array")
    if header.arrays["position"][0] not in ("<f8", SINGLE) or header.arrays["position"][1] not in ((1,), (2,), (3,)):
        raise ValueError("no such positions")


def chunks_of(frame: Frame, step: int, header: Header, colors: Sequence[str] = ()) -> Chunks:
    """All chunks of a frame; its checksum is the last, so that an incomplete frame lacks it. `colors` are those of the
    species, `#rrggbb`.
    """
    chunks = {HEADER: written(header), "configuration/step": _column(np.array([step], np.uint64))}
    chunks |= _shown(frame, header.species) | _colored(frame, colors)
    for name, (kind, _) in header.arrays.items():
        if kind != SINGLE or f"particles/{name}" not in chunks or (name == "position" and _is_periodic(frame)):
            chunks[f"log/particles/{name}"] = _table(frame.arrays[name].astype(kind, copy=False))
    for name, value in (("time", frame.time), *frame.numbers.items()):
        chunks[f"log/{name}"] = _column(np.array([value], np.float64))
    chunks[CHECKSUM] = _column(np.array([checksum(chunks), numbers_checksum(chunks, header)], np.uint32))
    return chunks


def frame_of(chunks: Chunks, header: Header) -> Frame:
    """The frame with these chunks; it owns its arrays."""
    arrays: Mapping[str, NDArray[Any]] = {
        name: _stored(chunks, name, math.prod(shape))
        .reshape(-1, *shape)
        .astype("<f8" if kind == SINGLE else kind, copy=True)
        for name, (kind, shape) in header.arrays.items()
    }
    if len({len(array) for array in arrays.values()}) > 1:
        raise ValueError("arrays of several lengths")
    if header.omitted:
        arrays = RecordedArrays(arrays, header.omitted)
    numbers = {present_name(name): float(chunks[f"log/{name}"][0, 0]) for name in header.numbers}
    return Frame(float(chunks["log/time"][0, 0]), arrays, numbers, units_of(header))


def units_of(header: Header) -> dict[str, str]:
    """The unit of each array and number, by their present names."""
    renamed = set(header.numbers) - set(header.arrays)
    return {present_name(name) if name in renamed else name: unit for name, unit in header.units.items()}


def _stored(chunks: Chunks, name: str, width: int) -> NDArray[Any]:
    """The chunk of an array; in single precision it may be HOOMD's chunk, whose vectors have three components."""
    own = chunks.get(f"log/particles/{name}")
    return chunks[f"particles/{name}"][:, :width] if own is None else own


def number_names(header: Header) -> list[str]:
    """The chunks that hold one number each: the step, the time, and the named numbers."""
    return ["configuration/step", "log/time", *(f"log/{name}" for name in header.numbers)]


def checksum(chunks: Mapping[str, NDArray[Any]]) -> int:
    """The CRC-32 of named arrays without the checksum itself: names, kinds, shapes and bytes."""
    crc = 0
    for name in sorted(chunks.keys() - {CHECKSUM}):
        chunk = chunks[name]
        crc = zlib.crc32(f"{name} {chunk.dtype.str} {chunk.shape}".encode(), crc)
        crc = zlib.crc32(np.ascontiguousarray(chunk).reshape(-1).view(np.uint8).data, crc)
    return crc


def numbers_checksum(chunks: Chunks, header: Header) -> int:
    """The CRC-32 of the numbers alone, so that their curves can be read without the particles."""
    return zlib.crc32(b"".join(chunks[name].tobytes() for name in number_names(header)))


def _shown(frame: Frame, species: Sequence[str]) -> Chunks:
    """The quantities of HOOMD's schema, in single precision, for viewers."""
    box, position = _boxed(frame)
    shown = {
        "configuration/dimensions": _column(np.array([position.shape[1]], np.uint8)),
        "configuration/box": _column(box),
        "particles/N": _column(np.array([len(position)], np.uint32)),
        "particles/position": _in_space(position),
    }
    if "image" in frame.arrays:
        shown["particles/image"] = _hoomd_images(frame)
    if "velocity" in frame.arrays:
        shown["particles/velocity"] = _in_space(frame.arrays["velocity"])
    if "radius" in frame.arrays:
        shown["particles/diameter"] = _column((2.0 * frame.arrays["radius"]).astype(np.float32))
    if "mass" in frame.arrays:
        shown["particles/mass"] = _column(frame.arrays["mass"].astype(np.float32))
    return shown | _types(frame, species)


def _is_periodic(frame: Frame) -> bool:
    """Whether positions in HOOMD's chunks are those in a periodic box, and therefore differ from ecume's."""
    return any(frame.numbers.get(name, 0.0) > 0.0 for name in SIDES)


def _types(frame: Frame, named: Sequence[str]) -> Chunks:
    """The species of each particle, and the names of species: the given ones, and `species 3` for others."""
    if "species" not in frame.arrays or not len(frame.arrays["species"]):
        return {}
    species = frame.arrays["species"]
    unnamed = range(len(named), int(species.max()) + 1)
    names = [name.encode() for name in (*named, *(f"species {kind}" for kind in unnamed))]
    wide = np.array(names, dtype=f"S{max(map(len, names)) + 1}")
    return {
        "particles/typeid": _column(species.astype(np.uint32)),
        "particles/types": wide.view(np.int8).reshape(len(names), -1),
    }


def _colored(frame: Frame, colors: Sequence[str]) -> Chunks:
    """The color of each particle under the name that OVITO reads; colors that never change are written once."""
    if not colors or "species" not in frame.arrays:
        return {}
    bytes_of = np.array([list(bytes.fromhex(color.removeprefix("#"))) for color in colors], np.float32)
    return {"log/particles/Color": bytes_of[frame.arrays["species"] % len(colors)] / np.float32(255.0)}


def _boxed(frame: Frame) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """HOOMD's box, and the positions in it. A periodic box is exact: its center is the origin, and all particles are
    inside. Along other axes the box contains all particles, and its sides are powers of two, so that they rarely
    change.
    """
    position = frame.arrays["position"]
    sides = np.array([frame.numbers.get(name, 0.0) for name in SIDES[: position.shape[1]]])
    reach = float(np.abs(position).max(initial=0.0)) + float(frame.arrays.get("radius", np.zeros(1)).max(initial=0.0))
    around = 2.0 * 2.0 ** math.ceil(math.log2(reach)) if 0.0 < reach < math.inf else 1.0
    lengths = np.append(np.where(sides > 0.0, sides, around), np.ones(3 - len(sides)))
    tilt = _tilt(frame, sides)
    if sides.any():
        inside = position.copy()
        if tilt:
            inside[:, 0] -= tilt * position[:, 1]
        for axis in np.flatnonzero(sides):
            inside[:, axis] -= sides[axis] * (np.floor(inside[:, axis] / sides[axis]) + 0.5)
        if tilt:
            inside[:, 0] += tilt * inside[:, 1]
        position = inside
    return np.array([*lengths, tilt, 0.0, 0.0], np.float32), position


def _tilt(frame: Frame, sides: NDArray[np.float64]) -> float:
    """HOOMD's tilt factor xy of a sheared box: shift over height, from -1/2 to 1/2 of the width."""
    if not sides[:2].all() or len(sides) < 2:
        return 0.0
    width, height = (float(side) for side in sides[:2])
    shift = frame.numbers.get("box_tilt", frame.numbers.get("strain", 0.0) * height)
    return (shift - width * round(shift / width)) / height


def _hoomd_images(frame: Frame) -> NDArray[np.int32]:
    """HOOMD's image numbers (N, 3) of the positions that `_boxed` makes. A box that is sheared by whole widths is
    represented with the smallest tilt.
    """
    position, image = frame.arrays["position"], frame.arrays["image"].copy()
    sides = np.array([frame.numbers.get(name, 0.0) for name in SIDES[: position.shape[1]]])
    place = position.copy()
    if tilt := _tilt(frame, sides):
        place[:, 0] -= tilt * position[:, 1]
    if sides[:2].all() and len(sides) > 1:
        shift = frame.numbers.get("box_tilt", frame.numbers.get("strain", 0.0) * float(sides[1]))
        image[:, 0] += round(shift / float(sides[0])) * image[:, 1]
    for axis in np.flatnonzero(sides):
        image[:, axis] += np.floor(place[:, axis] / sides[axis]).astype(np.int64)
    return np.pad(image, ((0, 0), (0, 3 - image.shape[1]))).astype(np.int32)


def _in_space(vectors: NDArray[Any]) -> NDArray[np.float32]:
    """The vectors with three components; missing ones are zero."""
    space = np.zeros((len(vectors), 3), np.float32)
    space[:, : vectors.shape[1]] = vectors
    return space


def _column(values: NDArray[Any]) -> NDArray[Any]:
    return values.reshape(-1, 1)


def _table(array: NDArray[Any]) -> NDArray[Any]:
    """The array as a table with one row per particle."""
    return np.ascontiguousarray(array).reshape(len(array), math.prod(array.shape[1:]))
