"""Changes of a scene from the command line: `--set key=value`."""

from __future__ import annotations

import itertools
import re
import tomllib
from collections.abc import Sequence
from typing import Any

from ecume.scenes.faults import (
    Path,
    echo,
    read_path,
    written,
)
from ecume.scenes.toml import require_shallow_keys

KEY = re.compile(r"[A-Za-z0-9_-]{1,60}(?:\[[0-9]{1,9}\])*(?:\.[A-Za-z0-9_-]{1,60}(?:\[[0-9]{1,9}\])*){0,9}")
LONGEST = 10_000


def overridden(raw: dict[str, Any], overrides: Sequence[str]) -> tuple[set[Path], list[tuple[Path, str]]]:
    """Write the overrides into `raw`; return the paths that they set, and their faults."""
    changed: set[Path] = set()
    faults: list[tuple[Path, str]] = []
    for override in overrides:
        try:
            path, value = split(override)
            put(raw, path, value)
            changed.add(path)
        except ValueError as fault:
            faults.append(((), f"--set {echo(override)}: {fault}"))
    return changed, faults


def split(override: str) -> tuple[Path, Any]:
    """The path and the value of `key=value`.

    >>> split("particles[0].count=10")
    (('particles', 0, 'count'), 10)
    """
    key, equals, text = override.partition("=")
    if not equals or KEY.fullmatch(key.strip()) is None:
        raise ValueError("expected key=value, such as particles[0].count=10")
    return read_path(key), value_of(text.strip())


def value_of(text: str) -> Any:
    """The value of a TOML text; text that is not TOML is returned unchanged, so that the shell needs no second pair of
    quotes.
    """
    if len(text) > LONGEST:
        raise ValueError(f"a value of {len(text)} characters is too long")
    try:
        require_shallow_keys(text)
        document = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return document["value"] if document.keys() == {"value"} else text


def put(raw: Any, path: Path, value: Any) -> None:
    """Set the value at a path, and create missing tables on the path."""
    for depth, (key, following) in enumerate(itertools.pairwise(path)):
        if isinstance(key, str) and isinstance(raw, dict) and isinstance(following, str):
            raw.setdefault(key, {})
        raw = raw[_fitting(raw, key, path[: depth + 1])]
    raw[_fitting(raw, path[-1], path, new=True)] = value


def _fitting(raw: Any, key: str | int, path: Path, *, new: bool = False) -> Any:
    """The key, if it can be an index or a key of the value there."""
    if isinstance(key, str) and isinstance(raw, dict) and (new or key in raw):
        return key
    if isinstance(key, int) and isinstance(raw, list) and key < len(raw):
        return key
    if isinstance(raw, list):
        whole = written(path[:-1])
        held = f"{whole}[0]" if len(raw) == 1 else f"{whole}[0] to {whole}[{len(raw) - 1}]"
        raise ValueError(f"{whole} is a list; expected one of it: {held}" if raw else f"{whole} is an empty list")
    raise ValueError(f"the scene has no {written(path)}")
