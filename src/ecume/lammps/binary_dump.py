"""Binary dumps of LAMMPS (`dump custom FILE.bin`), as of its release of 2021 and later."""

from __future__ import annotations

import struct

import numpy as np

from ecume.units import Array

MAGIC, LITTLE_ENDIAN, REVISION = b"DUMPCUSTOM", 1, 2


class _Reader:
    """Reads numbers from bytes. Raises ValueError where they end too early."""

    def __init__(self, content: bytes) -> None:
        self._content, self._at = content, 0

    def numbers(self, kinds: str) -> tuple[int, ...]:
        """The next whole numbers, by the letters of `struct`."""
        return struct.unpack("<" + kinds, self.skip(struct.calcsize("<" + kinds)))

    def skip(self, size: int) -> bytes:
        """The next bytes."""
        part = self._content[self._at : self._at + size]
        if size < 0 or len(part) < size:
            raise ValueError("it ends too early")
        self._at += size
        return part


def read_dump(content: bytes) -> Array:
    """The rows of the only frame of a dump. Raises ValueError for any other content."""
    reader = _Reader(content)
    (length,) = reader.numbers("q")
    if -length != len(MAGIC) or reader.skip(-length) != MAGIC:
        raise ValueError("it is no binary dump of particles")
    endian, revision = reader.numbers("ii")
    if (endian, revision) != (LITTLE_ENDIAN, REVISION):
        raise ValueError(f"got byte order {endian} and revision {revision}; expected {LITTLE_ENDIAN} and {REVISION}")
    _, count = reader.numbers("qq")
    (tilted,) = reader.numbers("i")
    reader.skip(6 * 4 + 6 * 8 + (3 * 8 if tilted else 0))
    (width, units) = reader.numbers("ii")
    reader.skip(units)
    if reader.skip(1) != b"\0":
        reader.skip(8)
    (columns,) = reader.numbers("i")
    reader.skip(columns)
    (parts,) = reader.numbers("i")
    values = [np.frombuffer(reader.skip(8 * reader.numbers("i")[0]), "<f8") for _ in range(parts)]
    table = np.concatenate([np.zeros(0), *values])
    if width < 1 or table.size != count * width:
        raise ValueError(f"got {table.size} numbers; expected {count} rows of {width}")
    return table.reshape(count, width)
