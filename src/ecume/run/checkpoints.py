"""States on disk, enough to go on bit for bit, in archives of arrays that are checked before they are read.

Archives of arrays (`.npz`) that may come from anyone: each size is compared with the file before it is allocated.
`numpy.savez` stores arrays as they are. An archive that is compressed, or whose arrays are larger than the file, was
not written by it and is refused. `seal` adds a checksum of the whole file, as the comment that the format of archives
provides.
"""

from __future__ import annotations

import io
import math
import os
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._plain_files import opened, place_of, require_memory
from ecume.run.directory import RunDirectory
from ecume.run.recording import NOTHING, Kept, missing_rows
from ecume.trajectories.gsd import checksum
from ecume.trajectories.records import replacing, storing

KINDS = "fiubc"
"""Of arrays: numbers, and nothing else."""
MARK = b"ecume crc32 "
COMMENT = len(MARK) + 8
END = struct.Struct("<4s4H2LH")
"""The last record of an archive without a comment."""
TOO_DEEP = (RecursionError, MemoryError, tokenize.TokenError)
DAMAGED = (*TOO_DEEP, zipfile.BadZipFile, NotImplementedError, EOFError, struct.error, SyntaxError, KeyError)
"""What the readers of archives and of headers raise, apart from ValueError."""
AT_ONCE = 2**22
"""Bytes that are read at once."""


def arrays_of(file: IO[bytes] | io.RawIOBase, path: Path) -> dict[str, NDArray[Any]]:
    """The arrays of an open archive. Raises ValueError where it is damaged, or not one that `numpy.savez` wrote."""
    size = _size(file)
    require_memory(size, path)
    try:
        with zipfile.ZipFile(io.BufferedReader(_Lent(file))) as archive:
            members = archive.infolist()
            if any(member.compress_type != zipfile.ZIP_STORED or member.flag_bits & 1 for member in members):
                raise ValueError("its arrays are compressed; expected stored ones")
            if sum(member.file_size for member in members) > size:
                raise ValueError("its arrays are larger than the file")
            return {member.filename.removesuffix(".npy"): _array(archive.read(member)) for member in members}
    except DAMAGED as error:
        raise ValueError(f"{type(error).__name__}: {error}") from error


def _array(content: bytes) -> NDArray[Any]:
    """The array of a member. Raises ValueError where its header does not fit its size."""
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


class _Lent(io.RawIOBase):
    """An open file for a reader that closes what it is given."""

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
    """Raise ValueError where the checksum of an archive does not fit it. One of an earlier version has none."""
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
    """The CRC-32 of the first bytes of a file, which is left behind them."""
    file.seek(0)
    crc, left = 0, size
    while left > 0 and (part := file.read(min(left, AT_ONCE))):
        crc = zlib.crc32(part, crc)
        left -= len(part)
    file.seek(size)
    return crc


KEPT = 2
"""How many checkpoints stay: if the newest is damaged, there is another."""
FIELD, SAMPLES = "state.", "samples."


class Checkpoint(NamedTuple):
    """A state, how many frames there were before it, and how many time steps."""

    state: Any
    frames: int
    step: int = 0
    samples: Kept = NOTHING
    """The position of the sampling, see `ecume.run.recording`; empty without samples."""


def save(home: RunDirectory, checkpoint: Checkpoint) -> Path:
    """Write a checkpoint, and remove those that are too old."""
    arrays: dict[str, NDArray[Any]] = {"frames": np.array([checkpoint.frames])}
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
    """The arrays of a checkpoint. Raises ValueError where a byte is not as it was written."""
    with opened(path, "r", home.path) as file:
        require_sealed(file)
        file.seek(0)
        return arrays_of(file, path)


def require_sound(home: RunDirectory, path: Path) -> None:
    """Raise ValueError where a checkpoint is damaged."""
    arrays = sound_arrays(home, path)
    if int(arrays.pop("crc32")[0]) != checksum(arrays):
        raise ValueError("its checksum does not fit its data")


def set_aside(home: RunDirectory, path: Path) -> None:
    """Rename a damaged file of a run, so that it is not read again."""
    with storing(path), place_of(path, home.path) as place:
        place.beside(f"{place.name}.damaged").take(place)
        place.settle()


def newest_first(home: RunDirectory) -> list[Path]:
    """The checkpoints of a run."""
    return sorted((path for path in home.checkpoints.glob("*.npz") if path.stem.isdecimal()), reverse=True)


def newest(home: RunDirectory, kind: type, frames: int, note: Callable[[Path, str], None]) -> Checkpoint | None:
    """The newest good checkpoint for which all frames before it are on disk; others are set aside, and noted.

    `kind` is the model's State; `frames` is how many frames are on disk.
    """
    for path in newest_first(home):
        checkpoint, fault = _examined(home, path, kind)
        if checkpoint is not None and checkpoint.frames > frames:
            fault = f"{checkpoint.frames - frames} frames before it are missing or damaged"
        if checkpoint is not None and not fault:
            fault = missing_rows(home.samples, checkpoint.samples)
        if checkpoint is not None and not fault:
            return checkpoint
        set_aside(home, path)
        note(path, fault)
    return None


def _examined(home: RunDirectory, path: Path, kind: type) -> tuple[Checkpoint | None, str]:
    """The checkpoint of a file, or what is wrong with it."""
    try:
        return _loaded(home, path, kind)._replace(step=int(path.stem)), ""
    except Exception as error:  # a damaged archive raises nearly anything; whatever it is, the file is not used
        return None, f"{type(error).__name__}: {error}"


def _loaded(home: RunDirectory, path: Path, kind: type) -> Checkpoint:
    arrays = sound_arrays(home, path)
    if int(arrays.pop("crc32")[0]) != checksum(arrays):
        raise ValueError("its checksum does not fit its data")
    frames = int(arrays.pop("frames")[0])
    kept = {name.removeprefix(FIELD): array for name, array in arrays.items() if name.startswith(FIELD)}
    samples = {name.removeprefix(SAMPLES): array for name, array in arrays.items() if name.startswith(SAMPLES)}
    return Checkpoint(kind(**{**_unknown_then(kind), **kept}), frames, samples=samples)


def _unknown_then(kind: type) -> dict[str, NDArray[Any]]:
    """The defaults of fields that states of former versions lack, as copies to write to."""
    defaults: dict[str, NDArray[Any]] = getattr(kind, "_field_defaults", {})
    return {name: array.copy() for name, array in defaults.items()}
