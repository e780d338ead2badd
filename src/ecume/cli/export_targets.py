"""Where an export goes: a file in a folder that exists, or the standard output."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from ecume.errors import BadInput

TEXT = ("csv", "numbers", "samples", "xyz")
"""Formats that can be read on a terminal and piped."""


def to_stdout(directory: Path, kind: str) -> None:
    """Write the frames of a run to the standard output."""
    from ecume.trajectories.exports import export

    if kind not in TEXT:
        raise BadInput(f"-o -: {kind} is a binary format; expected one of {', '.join(TEXT)}, or the name of a file")
    with tempfile.TemporaryDirectory() as folder, export(directory, kind, Path(folder) / "frames").open("rb") as file:
        for part in iter(lambda: file.read(2**20), b""):
            sys.stdout.buffer.write(part)
        sys.stdout.buffer.flush()


def require_folder(file: Path) -> None:
    """Raise BadInput where a file would be in a folder that does not exist."""
    if not file.parent.is_dir():
        raise BadInput(f"-o {file}: the folder {file.parent} does not exist")
