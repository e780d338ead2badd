"""Small JSON files, written with a checksum and read as validated data or an error; and files that are either complete
or missing.

The last key of a record, `crc32`, is the CRC-32 of the text without it. A record is valid only if its text is that
which `write_record` would write for its content, so that a change of any byte is detected. Runs whose manifest has no
`format` were written by earlier versions; their records have no checksum.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import json
import math
import os
import re
import secrets
import time
import zlib
from collections.abc import Callable, Iterator, Mapping
from io import BufferedRandom
from pathlib import Path
from typing import Any

import psutil

from ecume._plain_files import NotPlain, content_of, place_of, require_memory
from ecume.errors import StorageError

ABANDONED = 600.0
"""Seconds after which a partial file that is not written any more is removed, if its process does not exist: another
machine may write it.
"""
MOST_STEM_BYTES = 180
"""Bytes of the name of a file that the name of its partial file repeats."""
FULL = {errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC)}
"""The error codes for a lack of space: of the disk, the largest allowed file, the user's quota."""


@contextlib.contextmanager
def storing(path: Path) -> Iterator[None]:
    """Convert any error of the operating system during access to this file into a StorageError with a message of one
    line.
    """
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


PARTS_OF_RUNS = {
    "scene.toml", "resolved.json", "constants.npz", "manifest.json", "lock", "scalars.jsonl", "samples.csv",
    "samples-checksums.jsonl", "log.jsonl", "status.json", "watch.json", "DONE.json", "FAILED.json",
    "ro-crate-metadata.json",
}  # fmt: skip
"""The names of the files of a run beside its folders."""
FOLDERS_OF_RUNS = {"traj": ".gsd", "ckpt": ".npz"}
"""The endings of the files in each folder of a run."""


def _is_part_of_a_run(path: Path) -> bool:
    """Whether a file is a part of a run: it has the name of one of its files, or is in one of its folders."""
    inside = FOLDERS_OF_RUNS.get(path.parent.name, "") == path.suffix != ""
    home = path.parent.parent if inside else path.parent
    is_run = (home / "traj").is_dir() and any((home / name).is_file() for name in ("resolved.json", "manifest.json"))
    return (inside or path.name in PARTS_OF_RUNS) and is_run


def replaceable(path: Path) -> Path:
    """The plain file to which `path` refers, with links followed. Raises StorageError for a folder, for a file of a
    run, and for a device or a pipe: replacing `/dev/stdout` by a file would damage the system.
    """
    there = Path(os.path.realpath(path))
    if there.is_dir():
        raise StorageError(f"{path}: is a folder; expected a file, or a name that is free")
    if there.exists() and not there.is_file():
        raise StorageError(f"{path}: is not a plain file, and is not changed")
    if there.exists() and _is_part_of_a_run(there):
        raise StorageError(f"{path}: is a file of a run, and is not replaced; expected another name")
    return there


def partial_of(path: Path) -> Path:
    """The name under which this process writes a file until it is complete, and which no other process uses."""
    return path.with_name(f".{_shortened(path.stem)}.{os.getpid()}-{secrets.token_hex(4)}.partial{path.suffix}")


def _shortened(stem: str) -> str:
    """The beginning of a name, shortened so that a suffix can be added: names may have up to 255 bytes."""
    return os.fsencode(stem)[:MOST_STEM_BYTES].decode(errors="ignore")


def remove_abandoned(path: Path) -> None:
    """Remove partial files of processes that ended some time ago."""
    name = re.compile(
        rf"\.{re.escape(_shortened(path.stem))}\.([0-9]{{1,9}})-[0-9a-f]{{8}}\.partial{re.escape(path.suffix)}"
    )
    for other in path.parent.glob(".*.partial*"):
        with contextlib.suppress(OSError):
            old = time.time() - other.lstat().st_mtime > ABANDONED
            if old and (found := name.fullmatch(other.name)) and not psutil.pid_exists(int(found[1])):
                other.unlink()


@contextlib.contextmanager
def replacing(path: Path, root: Path | None = None, *, settled: bool = True) -> Iterator[BufferedRandom]:
    """A context for the new content of a file, which atomically replaces the old one if the block succeeds.

    Below `root`, a run directory, links are not followed. With `settled`, the content is on the disk when the context
    ends.
    """
    named = path
    with storing(named), place_of(path if root else replaceable(path), root) as place:
        # A run has one writer; a file of the user may have several.
        part = place.beside(f"{place.name}.part" if root else partial_of(place.path).name)
        if root is None:
            remove_abandoned(place.path)
        try:
            part.unlink()  # a partial file of a killed process, or a link by another user
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
    """Replace the content of a file, or leave the old one after a failure; `root` and `settled` as in `replacing`."""
    with replacing(path, root, settled=settled) as file:
        file.write(content.encode() if isinstance(content, str) else content)


def settle(folder: Path) -> None:
    """Write the entries of a folder to disk, so that they survive a power failure."""
    with place_of(folder / "any") as place:
        place.settle()


CRC = "crc32"
MOST_BYTES = 16 * 2**20
"""The largest size of a record."""
MOST_SCENE_BYTES = 2**31
"""The largest size of a resolved scene, which may contain tables and meshes."""
READ = 32
"""The largest ratio of memory to bytes of JSON: for single-digit numbers and nested lists."""
MOST_CHARACTERS = 10_000
"""The largest length of a text in a record."""
WORDS = re.compile(r"[^\x00-\x1f\x7f-\x9f$`\"\\]*")
"""A pattern of text that may be copied into another file, since it contains no characters that start commands."""

Check = Callable[[object, str], None]
"""A function of a value and its path in the file that raises ValueError unless the value is of one kind."""


def _check(expected: str, holds: Callable[[Any], bool]) -> Check:
    def check(value: object, path: str) -> None:
        if not holds(value):
            raise ValueError(f"{path}: got {_echo(value)}; expected {expected}")

    return check


def _echo(value: object) -> str:
    text = ascii(value) if isinstance(value, str | float | bool | None) else type(value).__name__
    return text if len(text) <= 60 else f"{text[:57]}..."


def _is_whole(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 2**63


def _is_number(value: object) -> bool:
    if isinstance(value, int):
        return not isinstance(value, bool) and abs(value) < 2**63
    return isinstance(value, float) and math.isfinite(value)


def _is_text(value: object) -> bool:
    return isinstance(value, str) and len(value) <= MOST_CHARACTERS


anything = _check("anything", lambda value: True)
whole = _check("a whole number", _is_whole)
process = _check("the number of a process", lambda value: _is_whole(value) and 0 < value < 2**31)
number = _check("a finite number", _is_number)
text = _check("text", _is_text)
words = _check(
    'text without control characters, ", \\, $ and `', lambda value: _is_text(value) and bool(WORDS.fullmatch(value))
)
digest = _check("a SHA-256", lambda value: isinstance(value, str) and bool(re.fullmatch("[0-9a-f]{64}", value)))
key = _check("a digest", lambda value: isinstance(value, str) and bool(re.fullmatch("[0-9a-f]{1,64}", value)))
switch = _check("true or false", lambda value: isinstance(value, bool))


def optional(check: Check) -> Check:
    """A check for a value of this kind, or null."""

    def either(value: object, path: str) -> None:
        if value is not None:
            check(value, path)

    return either


def listed(check: Check) -> Check:
    """A check for a list of values of this kind."""

    def each(value: object, path: str) -> None:
        if not isinstance(value, list):
            raise ValueError(f"{path}: got {_echo(value)}; expected a list")
        for place, item in enumerate(value):
            check(item, f"{path}[{place}]")

    return each


def named(check: Check) -> Check:
    """A check for a table of values of this kind, with any names."""

    def each(value: object, path: str) -> None:
        if not isinstance(value, dict):
            raise ValueError(f"{path}: got {_echo(value)}; expected a table")
        for name, item in value.items():
            words(name, path)
            check(item, f"{path}.{name}")

    return each


def table(required: Mapping[str, Check], others: Mapping[str, Check] | None = None, rest: Check = anything) -> Check:
    """A check for a table with the required keys, those of `others` if present, and `rest` for any other key."""
    known = {**required, **(others or {})}

    def check(value: object, path: str) -> None:
        if not isinstance(value, dict):
            raise ValueError(f"{path}: got {_echo(value)}; expected a table")
        if missing := [name for name in required if name not in value]:
            raise ValueError(f"{path}: {missing[0]} is missing")
        for name, item in value.items():
            known.get(name, rest)(item, f"{path}.{name}" if path else name)

    return check


CIRCUMSTANCES = named(optional(words))
SESSION = table(
    {},
    {
        "pid": whole, "host": words, "threads": whole, "began": words, "from_step": whole, "first_frame": whole,
        "circumstances": CIRCUMSTANCES, "ended": words, "to_step": whole, "seconds": number, "outcome": words,
        "replaced": table(
            {"frame": whole, "time": number, "difference": words, "changed": listed(words)},
        ),
        "lammps": words, "ranks": whole,
    },
)  # fmt: skip
MANIFEST = table(
    {},
    {
        "format": whole, "model": words, "scene_sha256": digest, "source_sha256": digest, "constants_sha256": digest,
        "sessions": listed(SESSION),
        "extra_laws": listed(table({"name": words, "sha256": digest}, {"uncovered": listed(words)})),
        "actions": listed(
            table({"name": words, "sha256": digest, "every": named(number)}, {"uncovered": listed(words)})
        ),
        "on_violation": words, "until": words, "engine": words, "cores": optional(whole), "seed": optional(number),
    },
    rest=optional(words),
)  # fmt: skip
STATUS = table(
    {},
    {
        "state": words, "step": whole, "steps": optional(whole), "time": number, "duration": number, "frames": whole,
        "remaining": optional(number), "last_checkpoint": optional(whole), "at": words,
    },
)  # fmt: skip
WATCH = table(
    {},
    {
        "until": number, "policy": words, "energy_unit": words, "energy": named(optional(number)),
        "invariants": listed(
            table({"name": words, "limit": number, "worst": optional(number), "held": switch}, {"says": text}),
        ),
    },
)  # fmt: skip
DONE = table(
    {"step": whole, "time": number, "frames": whole},
    {"sha256": named(digest), "steps": optional(whole), "early": switch},
)
FAILED = table({}, {"message": text, "sha256": named(digest)})
OWNER = table({"pid": process, "host": text, "began": number}, rest=text)
SUM = table({"bytes": whole, "crc": whole})
"""The check of a line of `samples-checksums.jsonl`: the size and the checksum of the table of samples."""
LINE = table({"step": whole, "time": number}, rest=optional(number))
"""The check of a line of `scalars.jsonl`."""


def as_json(plain: Any) -> str:
    """Plain data as readable JSON text, from which floats can be restored exactly."""
    return json.dumps(plain, indent=2) + "\n"


def plain_of(content: bytes) -> object:
    """The data of a JSON text. Raises ValueError for any error of Python's reader."""
    try:
        return json.loads(content)
    except UnicodeDecodeError:
        raise ValueError("is not text in UTF-8") from None
    except RecursionError:
        raise ValueError("is nested too deeply") from None


def write_json(path: Path, plain: Any) -> None:
    """Replace a user's file by plain data."""
    write_whole(path, as_json(plain))


def json_of(path: Path, root: Path | None = None) -> dict[str, Any]:
    """The plain data of a file. Raises StorageError for anything else. Below `root`, links are not followed."""
    with storing(path):
        content = content_of(path, MOST_BYTES, root)
    return _table_of(content, path)


def _table_of(content: bytes, path: Path) -> dict[str, Any]:
    try:
        plain = plain_of(content)
    except ValueError as error:
        raise StorageError(f"{path}: damaged: {error}") from error
    if not isinstance(plain, dict):
        raise StorageError(f"{path}: damaged: expected a table")
    return plain


def sealed(plain: Mapping[str, Any], owner: str = "") -> str:
    """The text of a record: its data and their checksum, which includes the `owner`, that is, the run and the name of
    the file. In another run, or under another name, the checksum does not match.
    """
    return as_json({**plain, CRC: _crc(as_json(plain), owner)})


def sealed_line(plain: Mapping[str, Any], owner: str = "") -> str:
    """A sealed record as one line."""
    return json.dumps({**plain, CRC: _crc(json.dumps(plain), owner)}) + "\n"


def _crc(content: str, owner: str) -> str:
    return f"{zlib.crc32(content.encode(), zlib.crc32(owner.encode())):08x}"


def identity(manifest: Mapping[str, Any]) -> str:
    """The identity of a run, which is included in the checksums of its files: a digest of scene and code. Runs of equal
    scenes with equal code have the same identity and the same files.
    """
    parts = [manifest.get(name) for name in ("scene_sha256", "extra_laws", "actions", "engine", "imported")]
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]


def write_record(path: Path, plain: Mapping[str, Any], root: Path, *, owner: str = "", settled: bool = True) -> None:
    """Replace a record of a run."""
    write_whole(path, sealed(plain, owner), root, settled=settled)


def record_at(path: Path, check: Check, root: Path, *, checked: bool | None, owner: str = "") -> dict[str, Any]:
    """The data of a record of a run. Raises StorageError if they were changed after writing, or are of another kind.

    `checked` is whether a checksum is required; None if the record itself contains the format of the run.
    """
    with storing(path):
        content = content_of(path, MOST_BYTES, root)
    plain = _table_of(content, path)
    try:
        if CRC in plain or checked or (checked is None and "format" in plain):
            plain = unsealed(plain, content, owner)
        check(plain, "")
    except ValueError as error:
        raise StorageError(f"{path}: damaged: {error}") from error
    return plain


def line_of(content: bytes, check: Check, *, checked: bool, owner: str = "") -> dict[str, Any]:
    """The data of a line with its line break. Raises ValueError if they were changed after writing."""
    plain = plain_of(content)
    if not isinstance(plain, dict) or not content.endswith(b"\n"):
        raise ValueError("expected a table in a line")
    if CRC in plain or checked:
        plain = unsealed(plain, content, owner, sealed_line)
    check(plain, "")
    return plain


def unsealed(
    plain: dict[str, Any], content: bytes, owner: str = "", seal: Callable[[Mapping[str, Any], str], str] = sealed
) -> dict[str, Any]:
    """The data without their checksum. Raises ValueError if it does not match the data and their owner."""
    bare = {name: value for name, value in plain.items() if name != CRC}
    try:
        written = seal(bare, owner).encode()
    except RecursionError:
        raise ValueError("is nested too deeply") from None
    if written != content:
        raise ValueError("its checksum does not fit its data, or it belongs to another run or file")
    return bare


def clean(content: object) -> str:
    """The text in which each character that `words` refuses is replaced by a question mark.

    >>> clean('a $(b) "c"')
    'a ?(b) ?c?'
    """
    kept = str(content)[: MOST_CHARACTERS - 3]
    return "".join(each if WORDS.fullmatch(each) else "?" for each in kept)


def manifest_at(root: Path) -> dict[str, Any]:
    """The manifest of a run."""
    path = root / "manifest.json"
    manifest = record_at(path, MANIFEST, root, checked=None)
    if manifest.get("run", "") not in ("", identity(manifest)):
        raise StorageError(f"{path}: damaged: it is not that of its scene and its code")
    return manifest


def resolved_at(root: Path, manifest: Mapping[str, Any]) -> bytes:
    """The resolved scene of a run. Raises StorageError unless it is that with which the run started: with another
    scene, continued runs and pictures would be wrong.
    """
    path = root / "resolved.json"
    with storing(path):
        content = content_of(path, MOST_SCENE_BYTES, root)
    if manifest.get("scene_sha256") not in (None, hashlib.sha256(content).hexdigest()):
        way_out = f"`ecume repair {root}` makes it again from scene.toml"
        raise StorageError(f"{path}: damaged: it is not what the run began with; {way_out}")
    return content


def scene_at(root: Path, manifest: Mapping[str, Any]) -> dict[str, Any]:
    """The plain data of the resolved scene of a run."""
    path, content = root / "resolved.json", resolved_at(root, manifest)
    with storing(path):
        require_memory(READ * len(content), path)
    return _table_of(content, path)
