"""Checkpoints: states on disk, sufficient to resume a run bit for bit, in archives of arrays that are checked before
they are read.

Archives of arrays (`.npz`) that may come from anyone: each size is compared with the file before it is allocated.
`numpy.savez` stores arrays as they are. An archive that is compressed, or whose arrays are larger than the file, was
not written by it and is refused. `seal` adds a checksum of the whole file, as the comment that the format of archives
provides.

The constants of a run are what its model derived from the scene when the run began.

Charges, tables, fits and the time step come from solvers and special functions of libraries, whose last digits depend
on the processor and on their versions. They are kept in `constants.npz` and read back when the run is resumed, so that
no constant changes in the middle of a run.

Only numbers are read back, into parameters that were derived again from the scene: floating-point numbers and arrays
of the same shape and type, and the number of steps per frame. Everything else (counts, indices, choices) must be what
the scene gives, or nothing is read back at all, and the run warns. So this file can change numbers, and nothing else.
"""

from __future__ import annotations

import hashlib
import io
import math
import os
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._plain_files import opened, place_of, require_memory
from ecume.errors import StorageError
from ecume.run.directory import RunDirectory, identity_of, manifest_of
from ecume.run.recording import NOTHING, Kept, missing_rows
from ecume.trajectories.gsd import checksum
from ecume.trajectories.records import replacing, storing

KINDS = "fiubc"
"""The kinds of arrays in archives: numbers only."""
MARK = b"ecume crc32 "
COMMENT = len(MARK) + 8
END = struct.Struct("<4s4H2LH")
"""The layout of the last record of an archive without a comment."""
TOO_DEEP = (RecursionError, MemoryError, tokenize.TokenError)
DAMAGED = (*TOO_DEEP, zipfile.BadZipFile, NotImplementedError, EOFError, struct.error, SyntaxError, KeyError)
"""The exceptions of readers of damaged archives and headers, apart from ValueError."""
AT_ONCE = 2**22
"""The number of bytes read at once."""


def arrays_of(file: IO[bytes] | io.RawIOBase, path: Path) -> dict[str, NDArray[Any]]:
    """The arrays of an open archive. Raises ValueError if it is damaged, or was not written by `numpy.savez`."""
    size = _size(file)
    require_memory(size, path)
    try:
        with zipfile.ZipFile(io.BufferedReader(_Unclosable(file))) as archive:
            members = archive.infolist()
            if any(member.compress_type != zipfile.ZIP_STORED or member.flag_bits & 1 for member in members):
                raise ValueError("its arrays are compressed; expected stored ones")
            if sum(member.file_size for member in members) > size:
                raise ValueError("its arrays are larger than the file")
            return {member.filename.removesuffix(".npy"): _array(archive.read(member)) for member in members}
    except DAMAGED as error:
        raise ValueError(f"{type(error).__name__}: {error}") from error


def _array(content: bytes) -> NDArray[Any]:
    """The array of a member. Raises ValueError if its header does not fit its size."""
    stream = io.BytesIO(content)
    version = np.lib.format.read_magic(stream)
    readers = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
    if version not in readers:
        raise ValueError(f"its arrays are of version {version}")
    shape, columns_first, kind = readers[version](stream)
    data = memoryview(content)[stream.tell() :]
    if not _is_numeric(kind) or math.prod(shape) * kind.itemsize != len(data):
        raise ValueError("the header of an array does not fit its data")
    order: Any = "F" if columns_first else "C"
    return np.frombuffer(data, kind).reshape(shape, order=order).copy(order=order)


def _is_numeric(kind: np.dtype[Any]) -> bool:
    """Whether items are numbers, or records of numbers."""
    if kind.fields is None:
        return kind.kind in KINDS
    return all(_is_numeric(kind[name]) for name in kind.fields)


class _Unclosable(io.RawIOBase):
    """An open file that its reader cannot close."""

    def __init__(self, file: Any) -> None:
        self._file = file

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        read: int = self._file.readinto(buffer)
        return read

    def seek(self, place: int, whence: int = 0) -> int:
        found: int = self._file.seek(place, whence)
        return found

    def tell(self) -> int:
        found: int = self._file.tell()
        return found


def _size(file: Any) -> int:
    return os.fstat(file.fileno()).st_size


def seal(file: Any) -> None:
    """Add the checksum of an archive that was just written, as its comment."""
    file.seek(-2, os.SEEK_END)
    file.write(struct.pack("<H", COMMENT))
    file.flush()
    file.write(MARK + f"{_crc(file, _size(file)):08x}".encode())


def require_sealed(file: Any) -> None:
    """Raise ValueError if the checksum of an archive does not fit it. Archives of earlier versions have no checksum."""
    size = _size(file)
    file.seek(max(0, size - END.size))
    if (last := file.read(END.size))[:4] == b"PK\x05\x06" and last[-2:] == b"\0\0":
        return
    file.seek(max(0, size - COMMENT))
    expected = MARK + f"{_crc(file, max(0, size - COMMENT)):08x}".encode()
    file.seek(max(0, size - COMMENT))
    if file.read(COMMENT) != expected:
        raise ValueError("its checksum does not fit its data")


def _crc(file: Any, size: int) -> int:
    """The CRC-32 of the first bytes of a file; the file is then positioned behind them."""
    file.seek(0)
    crc, left = 0, size
    while left > 0 and (part := file.read(min(left, AT_ONCE))):
        crc = zlib.crc32(part, crc)
        left -= len(part)
    file.seek(size)
    return crc


KEPT = 2
"""The number of checkpoints that are kept: if the newest is damaged, the other one is used."""
FIELD, SAMPLES = "state.", "samples."
RUN, STEP = "run", "step"


class Checkpoint(NamedTuple):
    """A state, the number of frames before it, and the number of time steps."""

    state: Any
    frames: int
    step: int = 0
    samples: Kept = NOTHING
    """The position of the sampling, see `ecume.run.recording`; empty without samples."""


def save(home: RunDirectory, checkpoint: Checkpoint) -> Path:
    """Write a checkpoint, and remove those that are too old."""
    arrays: dict[str, NDArray[Any]] = {"frames": np.array([checkpoint.frames])}
    if run := identity_of(home):
        arrays |= {STEP: np.array([checkpoint.step]), RUN: np.frombuffer(run.encode(), np.uint8)}
    arrays |= {FIELD + name: np.asarray(array) for name, array in checkpoint.state._asdict().items()}
    arrays |= {SAMPLES + name: array for name, array in checkpoint.samples.items()}
    path = home.checkpoints / f"{checkpoint.step:012d}.npz"
    with storing(path):
        home.checkpoints.mkdir(exist_ok=True)
    with replacing(path, home.path) as file:
        np.savez(file, allow_pickle=False, crc32=np.array([checksum(arrays)]), **arrays)
        seal(file)
    for old in newest_first(home)[KEPT:]:
        with storing(old):
            old.unlink()
    return path


def sound_arrays(home: RunDirectory, path: Path) -> dict[str, NDArray[Any]]:
    """The arrays of a checkpoint. Raises ValueError if any byte was changed."""
    with opened(path, "r", home.path) as file:
        require_sealed(file)
        file.seek(0)
        return arrays_of(file, path)


def require_sound(home: RunDirectory, path: Path) -> None:
    """Raise ValueError where a checkpoint is damaged."""
    if fault := missing_rows(home, _own_arrays(home, path)[1]):
        raise ValueError(fault)


def _own_arrays(home: RunDirectory, path: Path) -> tuple[dict[str, NDArray[Any]], Kept]:
    """The arrays of the state and those of the sampling in a checkpoint. Raises ValueError if it is damaged, or belongs
    to another run or step.
    """
    arrays = sound_arrays(home, path)
    if int(arrays.pop("crc32")[0]) != checksum(arrays):
        raise ValueError("its checksum does not fit its data")
    run, step = arrays.pop(RUN, np.zeros(0, np.uint8)), arrays.pop(STEP, None)
    if run.tobytes() != identity_of(home).encode() or (step is not None and int(step[0]) != int(path.stem)):
        raise ValueError("it belongs to another run or step")
    sampling = {name: array for name, array in arrays.items() if name.startswith(SAMPLES)}
    rest = {name: array for name, array in arrays.items() if name not in sampling}
    return rest, {name.removeprefix(SAMPLES): array for name, array in sampling.items()}


def set_aside(home: RunDirectory, path: Path) -> None:
    """Rename a damaged file of a run, so that it is not read again."""
    with storing(path), place_of(path, home.path) as place:
        place.beside(f"{place.name}.damaged").take(place)
        place.settle()


def newest_first(home: RunDirectory) -> list[Path]:
    """The checkpoints of a run, the newest first."""
    return sorted((path for path in home.checkpoints.glob("*.npz") if path.stem.isdecimal()), reverse=True)


def newest(home: RunDirectory, kind: type, frames: int, note: Callable[[Path, str], None]) -> Checkpoint | None:
    """The newest undamaged checkpoint before which all frames are on disk; others are set aside,
    and noted.

    `kind` is the model's State; `frames` is the number of frames on disk.
    """
    for path in newest_first(home):
        checkpoint, fault = _examined(home, path, kind)
        if checkpoint is not None and checkpoint.frames > frames:
            fault = f"{checkpoint.frames - frames} frames before it are missing or damaged"
        if checkpoint is not None and not fault:
            fault = missing_rows(home, checkpoint.samples)
        if checkpoint is not None and not fault:
            return checkpoint
        set_aside(home, path)
        note(path, fault)
    return None


def _examined(home: RunDirectory, path: Path, kind: type) -> tuple[Checkpoint | None, str]:
    """The checkpoint of a file, or a description of its fault."""
    try:
        return _loaded(home, path, kind)._replace(step=int(path.stem)), ""
    except Exception as error:  # a damaged archive may raise any exception; in each case the file is not used
        return None, f"{type(error).__name__}: {error}"


FORMER_NAMES = {
    "body_acceleration": "push",
    "contact_impulse": "push",
    "delayed_body_acceleration": "felt",
    "density_rate": "thickening",
    "friction_impulse": "rub",
    "open_boundaries": "gates",
    "raft_mobility": "collective",
    "shortest_time": "quickest",
    "spin_mobility": "ease",
    "stiffness_factor": "stiffer",
}
"""The names that fields of states and parameters had in former versions, as keys of their files."""


def with_present_names(stored: Stored, present: Iterable[str]) -> Stored:
    """The stored arrays under the present names of the fields, which may be paths of several names."""
    former = {".".join(FORMER_NAMES.get(word, word) for word in name.split(".")): name for name in present}
    return {name if name in present else former.get(name, name): array for name, array in stored.items()}


def _loaded(home: RunDirectory, path: Path, kind: type) -> Checkpoint:
    arrays, samples = _own_arrays(home, path)
    frames = int(arrays.pop("frames")[0])
    kept = {name.removeprefix(FIELD): array for name, array in arrays.items() if name.startswith(FIELD)}
    kept = with_present_names(kept, getattr(kind, "_fields", ()))
    for name, array in kept.items():
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            raise ValueError(f"its {name} contains numbers that are not finite")
    return Checkpoint(kind(**{**_unknown_then(kind), **kept}), frames, samples=samples)


def _unknown_then(kind: type) -> dict[str, NDArray[Any]]:
    """The defaults of fields that states of former versions lack, as copies to write to."""
    defaults: dict[str, NDArray[Any]] = getattr(kind, "_field_defaults", {})
    return {name: array.copy() for name, array in defaults.items()}


STEPS = "steps_per_frame"
"""The only integer that may differ: it follows from the time step."""

Stored = dict[str, NDArray[Any]]


class Restored(NamedTuple):
    """Parameters with the constants of a run, and a remark for its log."""

    parameters: Any
    remark: str
    kept: bool
    """Whether these are the stored constants of the run, and not derived again."""


def save_constants(home: RunDirectory, parameters: Any) -> str:
    """Write the constants of a run; return their digest."""
    with replacing(home.constants, home.path) as file:
        np.savez(file, allow_pickle=False, **_numbers(parameters))
    return digest(home)


def digest(home: RunDirectory) -> str:
    """The SHA-256 of the file of constants."""
    with storing(home.constants), opened(home.constants, "r", home.path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def is_sound(home: RunDirectory) -> bool:
    """Whether the file of constants is unchanged; true for runs of former versions, which have no such file."""
    expected = manifest_of(home).get("constants_sha256")
    if expected is None:
        return True
    return home.constants.is_file() and digest(home) == expected


def require_sound_constants(home: RunDirectory) -> None:
    """Raise StorageError where the file is damaged or missing."""
    if not is_sound(home):
        raise StorageError(
            f"{home.constants}: damaged: it is not what the run began with; `ecume repair {home.path}` sets it aside, "
            "and the run then derives its constants again"
        )


def restored(home: RunDirectory, parameters: Any) -> Restored:
    """The parameters of a resumed run with the stored constants, given those derived from its scene. Raises
    StorageError if the file is damaged.
    """
    if manifest_of(home).get("constants_sha256") is None:
        return Restored(parameters, "derived again, since none are stored with the run", False)
    require_sound_constants(home)
    derived = _numbers(parameters)
    stored = with_present_names(_load(home), derived)
    if misfit := _misfit(stored, derived):
        return Restored(parameters, f"derived again: {misfit}", False)
    return Restored(_with(parameters, stored, ""), _drift(stored, derived), True)


def _load(home: RunDirectory) -> Stored:
    try:
        with opened(home.constants, "r", home.path) as file:
            return arrays_of(file, home.constants)
    except (OSError, ValueError) as error:
        raise StorageError(f"{home.constants}: damaged: {error}") from error


def _leaves(tree: Any, path: str) -> Iterator[tuple[str, Any]]:
    """The leaves of a tree of (named) tuples, each with its path: `floats.charge`, `gauges.0.reach`."""
    if not isinstance(tree, tuple):
        yield path, tree
        return
    for name, part in _parts(tree):
        yield from _leaves(part, f"{path}.{name}" if path else name)


def _parts(tree: tuple[Any, ...]) -> Iterator[tuple[str, Any]]:
    return zip(getattr(tree, "_fields", map(str, range(len(tree)))), tree, strict=True)


def _numbers(parameters: Any) -> Stored:
    """The numbers among the parameters, by their paths. Names and choices follow from the scene."""
    kinds = (np.ndarray, np.generic, bool, int, float, complex)
    return {path: np.asarray(leaf) for path, leaf in _leaves(parameters, "") if isinstance(leaf, kinds)}


def _misfit(stored: Mapping[str, NDArray[Any]], derived: Mapping[str, NDArray[Any]]) -> str:
    """The reason why stored constants do not fit this scene in this version; empty if they do."""
    for path in sorted({*stored, *derived}):
        if path not in stored or path not in derived:
            return f"{path} is {'not stored' if path not in stored else 'no constant of this version'}"
        one, other = stored[path], derived[path]
        if one.shape != other.shape or one.dtype != other.dtype:
            return f"{path} was stored as {one.dtype}{list(one.shape)} and is now {other.dtype}{list(other.shape)}"
        if not (_is_near(one, other) if _may_differ(path, one) else np.array_equal(one, other)):
            return f"{path} was stored with other values"
    positive = stored["time_step"] > 0.0 and stored[STEPS] >= 1
    return "" if positive else "the stored time step is not a positive number"


FARTHEST, ROUNDING = 0.5, 1e-3
"""The largest difference between a stored and a derived constant, relative to its value and to the largest of its
array. Other processors change last digits, and fits of them up to 3e-5; larger differences mean another scene.
"""


def _is_near(stored: NDArray[Any], derived: NDArray[Any]) -> bool:
    """Whether constants may be those of another processor: finite in the same places, and of similar size."""
    finite = np.isfinite(derived)
    if not np.array_equal(np.isfinite(stored), finite) or not np.array_equal(stored[~finite], derived[~finite], True):
        return False
    with np.errstate(over="ignore"):
        own = np.abs(derived[finite])
        far = np.abs(stored[finite] - derived[finite]) > FARTHEST * own + ROUNDING * own.max(initial=0.0)
    return not far.any()


def _may_differ(path: str, stored: NDArray[Any]) -> bool:
    return stored.dtype.kind in "fc" or path == STEPS


def _with(tree: Any, stored: Stored, path: str) -> Any:
    """The tree with its numbers replaced by the stored ones."""
    if isinstance(tree, tuple):
        parts = [_with(part, stored, f"{path}.{name}" if path else name) for name, part in _parts(tree)]
        return type(tree)(*parts) if hasattr(tree, "_fields") else tuple(parts)
    if path not in stored or not _may_differ(path, stored[path]):
        return tree
    return _laid_out_as(tree, stored[path]) if isinstance(tree, np.ndarray) else type(tree)(stored[path][()])


def _laid_out_as(model: NDArray[Any], values: NDArray[Any]) -> NDArray[Any]:
    """The values in an array of the model's memory layout: compiled code distinguishes layouts as it does types."""
    if model.flags.c_contiguous or model.flags.f_contiguous:
        made = np.array(values, order="C" if model.flags.c_contiguous else "F")
    else:
        made = np.empty((*model.shape, 2), model.dtype)[..., 0]
        made[...] = values
    made.flags.writeable = model.flags.writeable
    return made


def _drift(stored: Stored, derived: Stored) -> str:
    """The difference between constants derived here and those of the run, in words; empty without a difference."""
    differing = [path for path in stored if stored[path].tobytes() != derived[path].tobytes()]
    if not differing:
        return ""
    size, path = max((_relative(stored[path], derived[path]), path) for path in differing)
    share = f"{len(differing)} of {len(stored)}"
    return f"kept; derived here, {share} would differ, {path} most: by {size:.1e} of its largest value"


def _relative(one: NDArray[Any], other: NDArray[Any]) -> float:
    """The largest difference of two arrays over their largest value; values that are not finite in both are ignored."""
    finite = np.isfinite(one) & np.isfinite(other)
    scale = float(np.abs(one[finite]).max(initial=0.0))
    with np.errstate(over="ignore"):
        largest = float(np.abs(one[finite] - other[finite]).max(initial=0.0))
    return largest / scale if scale > 0.0 else largest
