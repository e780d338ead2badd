"""Files that are whole or absent, whenever the process dies."""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from ecume.errors import StorageError

FULL = {errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC)}
"""What a system says when there is no room: the disk, the largest allowed file, the user's quota."""


@contextlib.contextmanager
def storing(path: Path) -> Iterator[None]:
    """Whatever the system refuses while this file is written or read becomes a StorageError of one line."""
    try:
        yield
    except OSError as error:
        raise StorageError(_explanation(error, path)) from error


def _explanation(error: OSError, path: Path) -> str:
    if error.errno in FULL:
        return f"{path}: no room left ({error.strerror}); what was committed before is whole: make room, then try again"
    return f"{path}: {error.strerror or error}"


def replaceable(path: Path) -> Path:
    """The plain file that `path` means, links followed. Raises StorageError for a device or a pipe: to put a file in
    the place of `/dev/stdout` would break the machine.
    """
    there = Path(os.path.realpath(path))
    if there.exists() and not there.is_file() and not there.is_dir():
        raise StorageError(f"{path}: is not a plain file, and is not changed")
    return there


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """A new content of a file: it takes the place of the old one in one instant, and only if the block ends well."""
    named, path = path, replaceable(path)
    part = path.with_name(f"{path.name}.part")
    try:
        with storing(named):
            with part.open("w+b") as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            part.replace(path)
            settle(path.parent)
    except BaseException:
        with contextlib.suppress(OSError):
            part.unlink(missing_ok=True)
        raise


def write_whole(path: Path, content: bytes | str) -> None:
    """Put this content into the file, or leave the old one."""
    with replacing(path) as file:
        file.write(content.encode() if isinstance(content, str) else content)


def settle(folder: Path) -> None:
    """Let the names in a folder survive a loss of power. Windows opens no folders, and needs none of this."""
    if os.name == "nt":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
