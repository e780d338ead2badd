"""Which folder holds the compiled code of a module, so that old code never runs and new code is compiled no more often
than it must.

Compiled code contains what it calls, from whichever file. So a folder is named by the text of its module and of every
module of this package that it imports, and these import in turn: an edited law gives new folders to what uses the law,
and to nothing else. Imports are read from the text, those inside functions and those for type checking too; only a name
that is put together at run time is not seen.
"""

from __future__ import annotations

import ast
import atexit
import hashlib
import os
import re
import shutil
import stat
import tempfile
import time
import warnings
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).absolute().parent
DAY = 86400.0
IMPORT = re.compile(r"^[ \t]*((?:from|import)[ \t]+[\w.][^\n(]*(?:\([^)]*\))?[^\n]*)", re.MULTILINE)
HIDDEN = re.compile(r"[;:][ \t]*(?:from|import)[ \t]")
"""An import that does not begin its line."""
FOR_TYPES = re.compile(r"^if TYPE_CHECKING:\n(?:(?:[ \t][^\n]*)?\n)+", re.MULTILINE)
"""Imports that only a type checker makes: nothing of them gets into compiled code."""
UNUSED = 30 * DAY
"""After this time without use a folder is thrown away."""


@cache
def root() -> Path:
    """Where all the folders are; a temporary place where nothing can be written, or where others can write."""
    import platformdirs

    asked = os.environ.get("ECUME_CACHE_DIR")
    place = (Path(asked) if asked else Path(platformdirs.user_cache_dir("ecume"))) / "compiled"
    try:
        # Private to the user, since code that is written there will be run.
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
    """Other users who can write into a folder; empty if only its owner can, which must be this user, or the
    machine's administrator. Windows keeps a user's folders by other means than modes.
    """
    if not hasattr(os, "getuid"):
        return ""
    return writable_for_others(place.stat())


def writable_for_others(status: os.stat_result) -> str:
    """The same of a file or folder with this status."""
    if not hasattr(os, "getuid"):
        return ""
    if status.st_uid not in (os.getuid(), 0):
        return f"belongs to user {status.st_uid}"
    return "can be written by others" if status.st_mode & (stat.S_IWGRP | stat.S_IWOTH) else ""


def closed_to_others(place: Path) -> None:
    """Make a folder that only its owner can write to, whatever the umask, or take that right from others."""
    place.mkdir(parents=True, exist_ok=True, mode=stat.S_IRWXU)
    if open_to_others(place) == "can be written by others":
        place.chmod(place.stat().st_mode & ~(stat.S_IWGRP | stat.S_IWOTH))


def _warn_of(place: Path, fault: str) -> None:
    warnings.warn(
        f"compiled code in {place} is not used: the folder {fault}, which lets them make you run anything. Delete it, "
        "or set ECUME_CACHE_DIR to your folder; until then everything is compiled in each process",
        stacklevel=2,
    )


def _temporary() -> Path:
    """A folder that goes with the process."""
    place = Path(tempfile.mkdtemp(prefix="ecume-"))
    atexit.register(shutil.rmtree, place, ignore_errors=True)
    return place


def folder(path: Path, compiler: str) -> Path:
    """Of the module with this file, compiled by this compiler."""
    found = root() / f"{path.stem}-{digest(path, compiler)}"
    try:
        if time.time() - found.stat().st_mtime > DAY:
            os.utime(found)
    except OSError:  # does not exist yet, or belongs to another user
        pass
    return found


@cache
def digest(path: Path, compiler: str) -> str:
    """Changes with the compiler, and whenever a line changes that can end up in the module's code."""
    whole = hashlib.sha256(compiler.encode())
    for source in sources(path):
        whole.update(source.relative_to(PACKAGE).as_posix().encode() if source != path else path.name.encode())
        whole.update(_text_digest(source))
    return whole.hexdigest()[:16]


def sources(path: Path) -> list[Path]:
    """The module's file, and all files of this package whose code can end up in the module's."""
    found, ahead = {path}, [path, PACKAGE / "_jit.py"]
    while ahead:
        new = set(_imported(ahead.pop())) - found
        found |= new
        ahead += new
    return sorted(found | {PACKAGE / "_jit.py"})


@cache
def _text_digest(path: Path) -> bytes:
    return hashlib.sha256(path.read_bytes()).digest()


@cache
def _imported(path: Path) -> frozenset[Path]:
    """Files of this package that a file imports."""
    found: set[Path] = set()
    for node in _statements(path.read_text(encoding="utf-8")):
        if isinstance(node, ast.Import):
            for name in node.names:
                # `import ecume.laws` binds the package, and with it all that others import.
                found.update(_files(name.name if name.asname else name.name.split(".")[0]))
        elif isinstance(node, ast.ImportFrom):
            module = ".".join([*_above(path, node.level), *([node.module] if node.module else [])])
            for name in node.names:
                found.update(_files(f"{module}.{name.name}", module))
    return frozenset(found)


def _statements(text: str) -> Iterable[ast.AST]:
    """All import statements, and more. Lines that look like one are parsed alone, ten times as fast as the whole;
    where that is not sure to find them all, the whole is.
    """
    text = FOR_TYPES.sub("", text)
    if HIDDEN.search(text) is None:
        try:
            return ast.parse("\n".join(IMPORT.findall(text))).body
        except SyntaxError:  # prose that looks like an import, or one that continues in the next line
            pass
    return ast.walk(ast.parse(text))


def _above(path: Path, level: int) -> Sequence[str]:
    """The package that a relative import of this level starts from."""
    if level == 0 or not path.is_relative_to(PACKAGE):
        return ()
    return PACKAGE.name, *path.relative_to(PACKAGE).parts[:-level]


def _files(*names: str) -> Iterable[Path]:
    """The first of these dotted names that is a module of ecume; the whole package if only the package itself is."""
    for name in names:
        first, *rest = name.split(".")
        if first != PACKAGE.name:
            return ()
        place = PACKAGE.joinpath(*rest)
        if not rest:
            return PACKAGE.rglob("*.py")
        for file in (place.with_suffix(".py"), place / "__init__.py"):
            if file.is_file():
                return (file,)
    return ()


def _prune(place: Path) -> None:
    """Delete folders that have not been used for long; checked about once a day."""
    stamp, now = place / "pruned", time.time()
    try:
        if now - stamp.stat().st_mtime < DAY:
            return
    except OSError:  # never pruned
        pass
    try:
        stamp.touch()
        for old in place.iterdir():
            if re.fullmatch(r".+-[0-9a-f]{16}", old.name) and now - old.stat().st_mtime > UNUSED:
                shutil.rmtree(old, ignore_errors=True)
    except OSError:  # another process prunes, or permission is missing
        pass
