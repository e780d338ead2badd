"""Archives of arrays (`.npz`) from unknown sources: each size is compared with the file before memory is allocated.

`numpy.savez` stores arrays without compression. An archive that is compressed, or whose arrays are larger than the
file, has another origin and is refused. `seal` adds a checksum of the whole file, as the comment that the format of
archives provides.
"""

from __future__ import annotations

import io
import math
import os
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from ecume._plain_files import require_memory

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
    """The stored arrays under the present names of the fields; a former name may correspond to several of them."""
    former = {".".join(FORMER_NAMES.get(word, word) for word in name.split(".")): name for name in present}
    return {name if name in present else former.get(name, name): array for name, array in stored.items()}


Stored = dict[str, NDArray[Any]]
