"""A frame as the chunks of a GSD file.

HOOMD's own chunks let OVITO and every other reader of GSD show the particles: positions and velocities in single
precision and always three components, diameter, type. ecume's chunks are exact: `log/time`, `log/<number>`,
`log/particles/<array>`, and `ecume/header`, which states once what the arrays are and which unit each has. A
trajectory in single precision has its arrays as `<f4`, and no second copy of HOOMD's chunks; it is read as float64.
Positions in a periodic box have a second copy, since HOOMD's are relative to the middle of the box.
"""

from __future__ import annotations

import json
import math
import zlib
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume.errors import BadInput, StorageError
from ecume.trajectories.frame import Frame, RecordedArrays, omitted_from
from ecume.trajectories.gsd_layout import CHECKSUM

HEADER = "ecume/header"
FORMAT = 1
MOST_FRAMES = 2**40
"""Of a trajectory."""
WIDEST, DEEPEST = 1000, 4
"""Components of an array, and axes of them."""
Chunks = dict[str, NDArray[Any]]
"""What stands in a file under each name: two-dimensional arrays."""


class Header(NamedTuple):
    """The data that all frames of a segment share; `first` is the number of its first frame in the trajectory."""

    first: int
    arrays: Mapping[str, tuple[str, tuple[int, ...]]]
    numbers: tuple[str, ...]
    units: Mapping[str, str]
    species: tuple[str, ...] = ()
    """What the species are called, in the order of their numbers, as far as they have names."""
    omitted: tuple[str, ...] = ()
    """Arrays that the scene omits."""


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
    if single:
        arrays = {name: (SINGLE if kind == "<f8" else kind, shape) for name, (kind, shape) in arrays.items()}
    return Header(first, arrays, tuple(frame.numbers), dict(frame.units), tuple(species), omitted_from(frame))


def written(header: Header) -> NDArray[Any]:
    """The header as a chunk."""
    plain = {"format": FORMAT, **header._asdict()}
    if not header.omitted:
        del plain["omitted"]
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
        header = header._replace(species=species, omitted=omitted)
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
    for kind, shape in header.arrays.values():
        wide = all(type(side) is int and 0 < side <= WIDEST for side in shape)
        if kind not in ("<f8", "<i8", SINGLE) or len(shape) > DEEPEST or not wide:
            raise ValueError("no such array")
    if header.arrays["position"][0] not in ("<f8", SINGLE) or header.arrays["position"][1] not in ((1,), (2,), (3,)):
        raise ValueError("no such positions")


def chunks_of(frame: Frame, step: int, header: Header, colors: Sequence[str] = ()) -> Chunks:
    """All chunks of a frame; its checksum is the last, so that whatever is cut short lacks it. `colors` are those of
    the species, `#rrggbb`.
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
    """The frame of its chunks; it owns its arrays."""
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
    numbers = {name: float(chunks[f"log/{name}"][0, 0]) for name in header.numbers}
    return Frame(float(chunks["log/time"][0, 0]), arrays, numbers, dict(header.units))


def _stored(chunks: Chunks, name: str, width: int) -> NDArray[Any]:
    """The chunk of an array; in single precision it may be HOOMD's, whose vectors have three components."""
    own = chunks.get(f"log/particles/{name}")
    return chunks[f"particles/{name}"][:, :width] if own is None else own


def number_names(header: Header) -> list[str]:
    """The chunks that hold one number each: the step, the time, and the named numbers."""
    return ["configuration/step", "log/time", *(f"log/{name}" for name in header.numbers)]


def checksum(chunks: Mapping[str, NDArray[Any]]) -> int:
    """The CRC-32 over named arrays, but for the checksum itself: names, kinds, shapes and bytes."""
    crc = 0
    for name in sorted(chunks.keys() - {CHECKSUM}):
        chunk = chunks[name]
        crc = zlib.crc32(f"{name} {chunk.dtype.str} {chunk.shape}".encode(), crc)
        crc = zlib.crc32(np.ascontiguousarray(chunk).reshape(-1).view(np.uint8).data, crc)
    return crc


def numbers_checksum(chunks: Chunks, header: Header) -> int:
    """The CRC-32 over the numbers alone, so that their curves are read without the particles."""
    return zlib.crc32(b"".join(chunks[name].tobytes() for name in number_names(header)))


def _shown(frame: Frame, species: Sequence[str]) -> Chunks:
    """The quantities of HOOMD's schema, in single precision."""
    box, position = _boxed(frame)
    shown = {
        "configuration/dimensions": _column(np.array([position.shape[1]], np.uint8)),
        "configuration/box": _column(box),
        "particles/N": _column(np.array([len(position)], np.uint32)),
        "particles/position": _in_space(position),
    }
    if "velocity" in frame.arrays:
        shown["particles/velocity"] = _in_space(frame.arrays["velocity"])
    if "radius" in frame.arrays:
        shown["particles/diameter"] = _column((2.0 * frame.arrays["radius"]).astype(np.float32))
    if "mass" in frame.arrays:
        shown["particles/mass"] = _column(frame.arrays["mass"].astype(np.float32))
    return shown | _types(frame, species)


def _is_periodic(frame: Frame) -> bool:
    """Whether HOOMD's positions are those in a periodic box, which differ from ecume's."""
    return any(frame.numbers.get(name, 0.0) > 0.0 for name in SIDES)


def _types(frame: Frame, named: Sequence[str]) -> Chunks:
    """The species of each particle, and their names: those given, and `species 3` for what has none."""
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
    """The color of each particle, under the name by which OVITO knows it; what never changes is written once."""
    if not colors or "species" not in frame.arrays:
        return {}
    bytes_of = np.array([list(bytes.fromhex(color.removeprefix("#"))) for color in colors], np.float32)
    return {"log/particles/Color": bytes_of[frame.arrays["species"] % len(colors)] / np.float32(255.0)}


def _boxed(frame: Frame) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """HOOMD's box, and the positions in it. A periodic box is exact: its middle is the origin, and all particles are
    inside. Along other axes the box holds all particles, and its sides are powers of two, so that they seldom change.
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
    """HOOMD's tilt factor xy of a sheared box, from -1/2 to 1/2 of its width over its height."""
    if not sides[:2].all() or len(sides) < 2:
        return 0.0
    width, height = (float(side) for side in sides[:2])
    shift = frame.numbers.get("box_tilt", frame.numbers.get("strain", 0.0) * height)
    return (shift - width * round(shift / width)) / height


def _in_space(vectors: NDArray[Any]) -> NDArray[np.float32]:
    """Three components, the missing ones zero."""
    space = np.zeros((len(vectors), 3), np.float32)
    space[:, : vectors.shape[1]] = vectors
    return space


def _column(values: NDArray[Any]) -> NDArray[Any]:
    return values.reshape(-1, 1)


def _table(array: NDArray[Any]) -> NDArray[Any]:
    """A row a particle, whatever other axes the array has."""
    return np.ascontiguousarray(array).reshape(len(array), math.prod(array.shape[1:]))
