"""Files that are whole or absent, whenever the process dies."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import secrets
import time
from collections.abc import Iterator
from io import BufferedRandom
from pathlib import Path

import psutil

from ecume._plain_files import NotPlain, place_of
from ecume.errors import StorageError

ABANDONED = 600.0
"""Seconds after which a partial file that is not written any more is removed, if its process does not exist: another
machine may write it.
"""
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
    if isinstance(error, NotPlain):
        return f"{error.path}: {error.strerror}"
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


def partial_of(path: Path) -> Path:
    """The name under which this process writes a file until it is complete: no other process writes under it."""
    return path.with_name(f".{path.stem}.{os.getpid()}-{secrets.token_hex(4)}.partial{path.suffix}")


def remove_abandoned(path: Path) -> None:
    """Remove what killed processes left of a file: partial files of processes that ended some time ago."""
    name = re.compile(rf"\.{re.escape(path.stem)}\.([0-9]{{1,9}})-[0-9a-f]{{8}}\.partial{re.escape(path.suffix)}")
    for other in path.parent.glob(".*.partial*"):
        with contextlib.suppress(OSError):
            old = time.time() - other.lstat().st_mtime > ABANDONED
            if old and (found := name.fullmatch(other.name)) and not psutil.pid_exists(int(found[1])):
                other.unlink()


@contextlib.contextmanager
def replacing(path: Path, root: Path | None = None, *, settled: bool = True) -> Iterator[BufferedRandom]:
    """A new content of a file: it takes the place of the old one in one instant, and only if the block ends well.

    Below `root`, a run directory, no link is followed. `settled` waits until the content is on the disk.
    """
    named = path
    with storing(named), place_of(path if root else replaceable(path), root) as place:
        # A run has one writer; of a file of the user's there may be several.
        part = place.beside(f"{place.name}.part" if root else partial_of(place.path).name)
        if root is None:
            remove_abandoned(place.path)
        try:
            part.unlink()  # of a process that was killed, or a link that another user made
            with BufferedRandom(part.open("w+")) as file:
                yield file
                file.flush()
                if settled:
                    os.fsync(file.fileno())
            place.take(part)
            if settled:
                place.settle()
        except BaseException:
            with contextlib.suppress(OSError):
                part.unlink()
            raise


def write_whole(path: Path, content: bytes | str, root: Path | None = None, *, settled: bool = True) -> None:
    """Put this content into the file, or leave the old one; `root` and `settled` as in `replacing`."""
    with replacing(path, root, settled=settled) as file:
        file.write(content.encode() if isinstance(content, str) else content)


def settle(folder: Path) -> None:
    """Let the names in a folder survive a loss of power."""
    with place_of(folder / "any") as place:
        place.settle()
