"""Opening the files that a scene names. A scene may come from anyone: of what it names, plain text is read."""

from __future__ import annotations

import codecs
import os
from pathlib import Path

from ecume._plain_files import NotPlain, TooLarge, content_of

TRUSTED = "ECUME_SCENE_FOLDERS"
"""The variable of the environment that names folders, parted as in PATH, which scenes from elsewhere may read."""


def beside(folder: Path, name: str) -> Path:
    """The file or folder `name` as seen from `folder`, and inside of it, or of a folder that the user trusts.

    Links are followed before that is judged. Raises ValueError.
    """
    if not name or "\0" in name or len(name) > 1000:
        raise ValueError("expected the path of a file")
    try:
        path = folder / Path(name).expanduser()
    except RuntimeError as error:
        raise ValueError(f"cannot be followed: {error}") from None
    roots = [os.path.realpath(root) for root in (str(folder), *_trusted())]
    there = Path(os.path.realpath(path))
    if not any(there.is_relative_to(root) for root in roots):
        raise ValueError(f"leads out of the scene's folder; copy it there, or name its folder in {TRUSTED}")
    return path


def _trusted() -> list[str]:
    return [place for place in os.environ.get(TRUSTED, "").split(os.pathsep) if place]


def require_there(path: Path, folder: Path) -> None:
    """Raise ValueError, with where it was looked for, unless something is there."""
    # Unlike Path.exists, this takes no offence at names that cannot be.
    if not os.path.exists(path):  # noqa: PTH110
        raise ValueError(f"does not exist; paths are relative to the scene's folder, {folder.resolve()}")


def text_of(path: Path, most_bytes: int) -> str:
    """The text of a plain file in UTF-8, at most so many bytes. Raises ValueError."""
    return decoded(bytes_of(path, most_bytes))


def bytes_of(path: Path, most_bytes: int) -> bytes:
    """The content of a plain file, at most so many bytes. Raises ValueError."""
    try:
        if path.is_dir():
            raise ValueError("is a folder; expected a file")
        return content_of(path, most_bytes)
    except TooLarge:
        raise ValueError(f"is larger than {most_bytes / 2**20:g} MiB") from None
    except NotPlain:
        raise ValueError("is not a regular file") from None
    except OSError as error:
        raise ValueError(f"cannot be read: {error.strerror or error}") from None


class NotText(ValueError):
    """Bytes that are not UTF-8, with the place of the first."""

    def __init__(self, data: bytes, error: UnicodeDecodeError) -> None:
        before = data[: error.start]
        self.line = before.count(b"\n") + 1
        self.column = len(before.rpartition(b"\n")[2].decode()) + 1
        self.message = f"byte {data[error.start]:#04x} is not UTF-8 text"
        super().__init__(f"line {self.line}, column {self.column}: {self.message}")


def decoded(data: bytes) -> str:
    """Strict UTF-8, with or without a byte-order mark. Raises NotText."""
    data = data.removeprefix(codecs.BOM_UTF8)
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        raise NotText(data, error) from None
