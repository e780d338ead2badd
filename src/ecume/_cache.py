"""Storage of compiled code: one file per function, whose name contains a digest of everything that its code depends on
(see `_dependencies`), so that an outdated file is never read.

An installed package `ecume_compiled` may contain such files. It is read first and never written.
"""

from __future__ import annotations

import atexit
import contextlib
import hashlib
import json
import os
import re
import shutil
import stat
import sysconfig
import tempfile
import time
import warnings
from collections.abc import Mapping
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).absolute().parent
DAY = 86400.0
UNUSED = 30 * DAY
"""After this time without use a file is thrown away."""
SUFFIX = ".code"
SHIPPED = "ecume_compiled"
MANIFEST = "MANIFEST.json"
CHECKSUM = hashlib.sha256().digest_size

used: list[str] = []
"""Names of the files that this process has read or written, in order."""


@cache
def root() -> Path:
    """The cache folder of the user, or a temporary folder if it cannot be written or if others can write to it."""
    import platformdirs

    asked = os.environ.get("ECUME_CACHE_DIR")
    try:
        place = (Path(asked) if asked else Path(platformdirs.user_cache_dir("ecume"))) / "compiled"
    except RuntimeError:  # for example a user id in a container without a user
        _warn("compiled code is not kept, since this user has no home folder. Set ECUME_CACHE_DIR to a folder")
        return _temporary()
    try:
        # Private to the user, since code that is stored there will be executed.
        place.mkdir(parents=True, exist_ok=True, mode=0o700)
        if fault := open_to_others(place):
            _warn_of(place, fault)
            return _temporary()
        with tempfile.TemporaryFile(dir=place):
            pass
    except OSError:
        return _temporary()
    _prune(place)
    return place


def open_to_others(place: Path) -> str:
    """Other users who can write into a folder; empty if only its owner can, who must be this user or the administrator
    of the machine. On Windows, file modes do not describe this.
    """
    if not hasattr(os, "getuid"):
        return ""
    return writable_for_others(place.stat())


def writable_for_others(status: os.stat_result) -> str:
    """Other users who can write to a file or folder with this status."""
    if not hasattr(os, "getuid"):
        return ""
    if status.st_uid not in (os.getuid(), 0):
        return f"belongs to user {status.st_uid}"
    return "can be written by others" if status.st_mode & (stat.S_IWGRP | stat.S_IWOTH) else ""


def _warn_of(place: Path, fault: str) -> None:
    _warn(
        f"compiled code in {place} is not used: the folder {fault}, which lets them make you run anything. Delete it, "
        "or set ECUME_CACHE_DIR to your folder"
    )


def _warn(text: str) -> None:
    warnings.warn(f"{text}; until then everything is compiled in each process", stacklevel=2)


def _temporary() -> Path:
    """A folder that is deleted when the process ends."""
    place = Path(tempfile.mkdtemp(prefix="ecume-"))
    atexit.register(shutil.rmtree, place, ignore_errors=True)
    return place


class DamagedError(ValueError):
    """A file whose content was changed after writing."""


def read(name: str) -> bytes | None:
    """The data stored under a name, in a package of compiled code or by processes of this user; None if missing."""
    if name in shipped():
        folder, checksum = shipped()[name]
        with contextlib.suppress(OSError, DamagedError):
            whole = (folder / name).read_bytes()
            if hashlib.sha256(whole).hexdigest() == checksum:
                used.append(name)
                return _checked(whole)
    place = root() / name
    try:
        with place.open("rb") as file:
            if writable_for_others(os.fstat(file.fileno())):
                return None  # the file is replaced, not read, since unpickling executes code
            whole = file.read()
    except OSError:
        return None
    with contextlib.suppress(OSError):  # the file belongs to another user
        if time.time() - place.stat().st_mtime > DAY:
            os.utime(place)
    data = _checked(whole)
    used.append(name)
    return data


def write(name: str, data: bytes) -> None:
    """Store data under a name; a reader sees either all data or none."""
    handle, beside = tempfile.mkstemp(dir=root(), prefix=name)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(hashlib.sha256(data).digest() + data)
        Path(beside).replace(root() / name)
    except BaseException:
        Path(beside).unlink(missing_ok=True)
        raise
    used.append(name)


def _checked(whole: bytes) -> bytes:
    """The data of a file without its checksum."""
    data = whole[CHECKSUM:]
    if hashlib.sha256(data).digest() != whole[:CHECKSUM]:
        raise DamagedError("the checksum is another")
    return data


@cache
def shipped() -> Mapping[str, tuple[Path, str]]:
    """The files in packages of compiled code by name: the folder, and the checksum of the whole file."""
    found: dict[str, tuple[Path, str]] = {}
    for above in {PACKAGE.parent: None, Path(sysconfig.get_path("purelib")): None}:
        with contextlib.suppress(OSError, ValueError, KeyError, AttributeError, TypeError):
            manifest = json.loads((above / SHIPPED / MANIFEST).read_text(encoding="utf-8"))
            entries = {str(name): str(checksum) for name, checksum in manifest["files"].items()}
            found |= {name: (above / SHIPPED, one) for name, one in entries.items() if Path(name).name == name}
    return found


def _prune(place: Path) -> None:
    """Delete files that have not been used for long, and folders of earlier versions; checked about once a day."""
    stamp, now = place / "pruned", time.time()
    try:
        if now - stamp.stat().st_mtime < DAY:
            return
    except OSError:  # the folder was never pruned
        pass
    try:
        stamp.touch()
        for old in place.iterdir():
            if re.fullmatch(r".+-[0-9a-f]{16,}(\.code.*)?", old.name) and now - old.stat().st_mtime > UNUSED:
                shutil.rmtree(old, ignore_errors=True) if old.is_dir() else old.unlink()
    except OSError:  # another process prunes, or permission is missing
        pass
