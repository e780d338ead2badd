"""Safe access to regular files, also in folders that other users may have written.

A run directory may contain symbolic links, hard links, named pipes and devices. `require_plain` refuses everything
except plain files and folders. `opened` and `Place` open the components of a path one after the other, relative to the
descriptor of the folder, and do not follow links; a file with several hard links is not opened for writing. On Windows,
which has no such calls, each component is examined before it is opened, and the opened file is compared with the
examined one.
"""

from __future__ import annotations

import contextlib
import errno
import os
import stat
import threading
from collections.abc import Iterator
from io import FileIO
from pathlib import Path
from typing import NamedTuple, cast

RELATIVE = {os.open, os.stat, os.unlink, os.rename} <= os.supports_dir_fd and hasattr(os, "O_NOFOLLOW")
"""Whether the system opens files relative to the descriptor of a folder."""
QUIET = getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
"""Flags of every file: a named pipe does not block."""
BARE = getattr(os, "O_NOFOLLOW", 0)
FLAGS = {
    "r": os.O_RDONLY,
    "r+": os.O_RDWR,
    "w+": os.O_RDWR | os.O_CREAT | os.O_EXCL,
    "a": os.O_WRONLY | os.O_CREAT | os.O_APPEND,
    "a+": os.O_RDWR | os.O_CREAT,
}
"""Flags of each mode: `w+` makes a new file, `a+` opens a file for reading and writing, or makes it."""
SPARSE = 100
"""The ratio of size to data on disk from which a large file counts as sparse."""
AT_ONCE = 2**20
"""Bytes that are read at once."""
ENOUGH = 2**30
"""Bytes that any machine may allocate; above it, the memory of this one decides."""


class NotPlain(OSError):
    """Something other than a plain file or folder, or a link on the way to it."""

    def __init__(self, path: Path, what: str) -> None:
        super().__init__(errno.ELOOP, what, str(path))
        self.path = path


class TooLarge(NotPlain):
    """A file larger than expected, or than the memory of the machine."""


def require_plain(root: Path) -> None:
    """Raise NotPlain unless everything below a folder is a plain file or a folder. The folder itself may be a link."""
    left = [root]
    while left:
        with os.scandir(left.pop()) as entries:
            for entry in entries:
                if _is_folder(entry):
                    left.append(Path(entry.path))
                else:
                    _require_plain_file(Path(entry.path))


def _require_plain_file(path: Path) -> None:
    try:
        found = os.lstat(path)
    except FileNotFoundError:  # removed in the meantime by the process that writes the run
        return
    if not stat.S_ISREG(found.st_mode):
        raise NotPlain(path, _kind(found))
    held = 512 * getattr(found, "st_blocks", found.st_size)
    if found.st_size > ENOUGH and SPARSE * held < found.st_size:
        raise TooLarge(path, f"is sparse: it holds {held} bytes of {found.st_size}, and would be read without end")


def _is_folder(entry: os.DirEntry[str]) -> bool:
    """Whether it is a folder, and not a junction of Windows."""
    return entry.is_dir(follow_symlinks=False) and not getattr(entry.stat(follow_symlinks=False), "st_reparse_tag", 0)


def _kind(found: os.stat_result) -> str:
    """The message about an object that is not a regular file, with the remedy."""
    kinds = {stat.S_ISLNK: "a link", stat.S_ISFIFO: "a named pipe", stat.S_ISSOCK: "a socket", stat.S_ISDIR: "a folder"}
    name = next((name for is_kind, name in kinds.items() if is_kind(found.st_mode)), "a device")
    return f"is {name}; expected a plain file. Remove it, or do not use what contains it"


class Place(NamedTuple):
    """A file name in an open folder. Operations apply to this folder even if its path changes in the meantime."""

    folder: Path
    name: str
    descriptor: int | None
    bare: bool
    """Whether the file itself must not be a link."""

    @property
    def path(self) -> Path:
        """The path of the file."""
        return self.folder / self.name

    def beside(self, name: str) -> Place:
        """Another file in the same folder."""
        return self._replace(name=name)

    def found(self) -> os.stat_result | None:
        """The status of the file, or None if it does not exist."""
        try:
            return os.stat(self._named, dir_fd=self.descriptor, follow_symlinks=not self.bare)
        except FileNotFoundError:
            return None

    def open(self, mode: str) -> FileIO:
        """Open the file without a buffer. Raises NotPlain for anything but a plain file."""
        before = self.found()
        if before is not None and not stat.S_ISREG(before.st_mode):
            raise NotPlain(self.path, _kind(before))
        if before is not None and mode != "r" and before.st_nlink > 1:
            raise NotPlain(self.path, "has a second name (a hard link), and is not written; use a copy of the folder")
        handle = os.open(self._named, FLAGS[mode] | QUIET | BARE * self.bare, 0o666, dir_fd=self.descriptor)
        after = os.fstat(handle)
        if not stat.S_ISREG(after.st_mode) or (before is not None and not os.path.samestat(before, after)):
            os.close(handle)
            raise NotPlain(self.path, "was replaced while it was opened")
        return cast(FileIO, os.fdopen(handle, f"{mode.replace('a+', 'r+')}b", buffering=0))

    def unlink(self) -> None:
        """Remove the file if it exists."""
        with contextlib.suppress(FileNotFoundError):
            os.unlink(self._named, dir_fd=self.descriptor)  # relative to the open folder

    def take(self, other: Place) -> None:
        """Replace this file by another one of the same folder."""
        if self.descriptor is None:
            os.replace(other.path, self.path)  # noqa: PTH105  # Windows renames over nothing otherwise
        else:
            os.rename(other.name, self.name, src_dir_fd=self.descriptor, dst_dir_fd=self.descriptor)

    def settle(self) -> None:
        """Flush the folder to disk. On Windows folders cannot be opened and need no flush."""
        if self.descriptor is not None:
            os.fsync(self.descriptor)

    @property
    def _named(self) -> str | Path:
        return self.path if self.descriptor is None else self.name


@contextlib.contextmanager
def place_of(path: Path, root: Path | None = None) -> Iterator[Place]:
    """A context with the place of a file. Below `root` no component may be a link; without `root`, links are
    followed.
    """
    parts = path.parts[-1:] if root is None else path.relative_to(root).parts
    folder = path.parent if root is None else root
    if ".." in parts or not parts:
        raise NotPlain(path, "leads out of its folder")
    if not RELATIVE:
        for part in parts[:-1]:
            folder = folder / part
            if not stat.S_ISDIR((found := os.lstat(folder)).st_mode):
                raise NotPlain(folder, _kind(found))
        yield Place(folder, parts[-1], None, root is not None)
        return
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | QUIET)
    try:
        for part in parts[:-1]:
            folder = folder / part
            handle = _entered(handle, part, folder)
        yield Place(folder, parts[-1], handle, root is not None)
    finally:
        os.close(handle)


def _entered(handle: int, part: str, folder: Path) -> int:
    """The descriptor of a folder in an open folder, whose descriptor is closed."""
    found = os.stat(part, dir_fd=handle, follow_symlinks=False)
    if not stat.S_ISDIR(found.st_mode):
        raise NotPlain(folder, "is no folder; expected one. Remove it, or do not use what contains it")
    below = os.open(part, os.O_RDONLY | os.O_DIRECTORY | QUIET | BARE, dir_fd=handle)
    os.close(handle)
    return below


def opened(path: Path, mode: str, root: Path | None = None) -> FileIO:
    """A plain file, opened without a buffer; modes as in `FLAGS`. Below `root`, links are not followed."""
    with place_of(path, root) as place:
        return place.open(mode)


def append(file: FileIO, content: bytes) -> None:
    """Append content to a file completely. After a failure, the part that was written is removed."""
    before = os.fstat(file.fileno()).st_size
    left = memoryview(content)
    try:
        while left:
            left = left[file.write(left) :]
    except OSError:
        with contextlib.suppress(OSError):  # the file is refused in either case
            os.ftruncate(file.fileno(), before)
        raise


def content_of(path: Path, most: int, root: Path | None = None) -> bytes:
    """The content of a plain file with at most `most` bytes."""
    with opened(path, "r", root) as file:
        size = os.fstat(file.fileno()).st_size
        if size > most:
            raise TooLarge(path, f"has {size / 2**20:.6g} MiB; expected at most {most / 2**20:g}")
        require_memory(size, path)
        parts, left = [], most + 1
        while left > 0 and (part := file.read(min(left, AT_ONCE))):
            parts.append(part)
            left -= len(part)
        if left <= 0:
            raise TooLarge(path, f"is larger than {most / 2**20:g} MiB")
        return b"".join(parts)


def require_memory(size: int, path: Path) -> None:
    """Raise NotPlain if a file states more bytes than the machine has memory for."""
    if size <= ENOUGH:
        return
    total = memory_limit()
    if size > total // 2:
        raise TooLarge(path, f"needs {size / 2**30:.3g} GiB; this process may use {total / 2**30:.3g} GiB")


GROUPS = Path("/proc/self/cgroup")
"""The control groups of this process on Linux."""
GROUP_LIMITS = {"": (Path("/sys/fs/cgroup"), "memory.max"),
                "memory": (Path("/sys/fs/cgroup/memory"), "memory.limit_in_bytes")}  # fmt: skip
"""The files with the memory limit of a control group: version 2 has one unnamed hierarchy, version 1 one named
`memory`.
"""


def memory_limit() -> int:
    """The memory that this process may use (bytes): that of the machine, or less in a container or a batch job, whose
    control group or resource limit ends a process that uses more.
    """
    import psutil

    return min([int(psutil.virtual_memory().total), *_group_limits(), *_address_space()])


def _group_limits() -> Iterator[int]:
    """The limits of the control groups of this process, and of those around them."""
    with contextlib.suppress(OSError):
        for line in GROUPS.read_text().splitlines():
            _, controllers, place = line.split(":", 2)
            for kind in {"", "memory"} & set(controllers.split(",")):
                root, name = GROUP_LIMITS[kind]
                group = Path(place.lstrip("/"))
                # In a container the path of the group may not be mounted; the root of the mount is then the group.
                for folder in (group, *group.parents):
                    with contextlib.suppress(OSError, ValueError):
                        yield int((root / folder / name).read_text())


def _address_space() -> Iterator[int]:
    """The limit of `ulimit -v`, which batch systems set."""
    with contextlib.suppress(ImportError):
        import resource

        limit = resource.getrlimit(resource.RLIMIT_AS)[0]
        if limit != resource.RLIM_INFINITY:
            yield limit


def read_at(file: FileIO, start: int, count: int) -> bytes:
    """A number of bytes at an offset, or fewer at the end of the file. Threads may read one file at the same time,
    since the file position is not used if the system supports this.
    """
    if not hasattr(os, "pread"):
        with _ONE_AT_A_TIME:
            file.seek(start)
            return file.read(count)
    parts: list[bytes] = []
    while count > 0 and (part := os.pread(file.fileno(), min(count, MOST_AT_ONCE), start)):
        parts.append(part)
        start, count = start + len(part), count - len(part)
    return parts[0] if len(parts) == 1 else b"".join(parts)


_ONE_AT_A_TIME = threading.Lock()
MOST_AT_ONCE = 2**30
"""Bytes that systems read in one call."""
