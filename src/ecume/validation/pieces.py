"""Pieces of long cases: numbers that were computed from a scene and are kept.

Finished pieces are in a folder of the working directory, each named by the digest of its scene: an interrupted case
continues with the pieces that are missing.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ecume.scenes.schema import Scene, to_plain


def kept_values(scene: Scene, folder: Path, compute: Callable[[], Sequence[Any]]) -> list[Any]:
    """What was computed from a scene and is kept, as JSON contains it; else it is computed now."""
    path = folder / f"{digest(scene)}.json"
    if not path.is_file():
        text = json.dumps(compute())
        folder.mkdir(parents=True, exist_ok=True)
        # Complete or absent: the file takes its name when all of it is written.
        partial = path.with_suffix(".part")
        partial.write_text(text, encoding="utf-8")
        partial.replace(path)
    found: list[Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def digest(scene: Scene) -> str:
    """The name of a piece: a digest of its complete scene."""
    return hashlib.sha256(json.dumps(to_plain(scene), sort_keys=True).encode()).hexdigest()[:16]
