"""Further faults of a faulty scene, found in its valid part."""

from __future__ import annotations

import copy
import re
from collections.abc import Callable, Collection, Sequence
from pathlib import Path as File
from typing import Any

from ecume.errors import Fault, SceneError
from ecume.scenes.faults import (
    MISSING,
    Path,
    read_path,
    value_at,
)
from ecume.scenes.floating.sources import rows_from
from ecume.scenes.load import Source, load_scene, name_liquid, parsed, placed, source_of, sources_followed, sources_of
from ecume.scenes.overrides import overridden
from ecume.scenes.schema import Scene, examined
from ecume.scenes.toml import tables_of

ROUNDS = 8
"""The largest numbers of corrections, and of omitted lines."""
QUICK = 20_000
"""The number of particles above which placement would delay the report of known faults."""
MEANT = re.compile(r"no such key; did you mean (\w+)\?")
"""The pattern of the message on a misspelt key."""


def load_and_examine(file: File, overrides: Sequence[str], examine: Callable[[Scene], Any]) -> Scene:
    """The scene of a file. Raises SceneError with its faults, and with those that `examine` finds in its valid part."""
    try:
        return load_scene(file, overrides)
    except SceneError as error:
        raise SceneError(merged(error, file, overrides, examine), error.source) from None


def merged(error: SceneError, file: File, overrides: Sequence[str], examine: Callable[[Scene], Any]) -> list[Fault]:
    """The faults of a scene, and those of its valid part, in the order of the file."""
    try:
        text, syntax = without_bad_lines(source_of(file))
    except SceneError:  # the file does not exist
        return list(error.faults)
    if any("twice" in fault.message for fault in syntax):
        return syntax  # the keys of the second table would be faults of the first table
    faults = list(error.faults)
    if syntax:
        lines = source_of(file).text.split("\n")
        if mixed := _mixed_heads(syntax, lines):
            return mixed  # the keys of the second table would be faults of the first table
        faults = _without_results(syntax, _faults_of(text, overrides), lines)
    scene, dropped = valid_part(text, overrides)
    if scene is not None and _placed(scene) <= QUICK:
        try:
            examine(scene)
        except SceneError as more:
            faults += _located(more, text, overrides, dropped)
    unique = {(fault.path, fault.message): fault for fault in faults}.values()
    return sorted(unique, key=lambda fault: (fault.line is None, fault.line or 0, fault.column or 0))


KEY_OF_LINE = re.compile(r"\s*(?:[\w-]+\s*\.\s*)*([\w-]+)")
"""The last word of the key with which a line begins."""
SECOND_HEAD = re.compile(r"\s*\[\[\s*([\w.-]+)\s*\]\]")


def _mixed_heads(syntax: Sequence[Fault], lines: Sequence[str]) -> list[Fault]:
    """The fault of a head `[[particles]]` after `[particles]`."""
    for fault in syntax:
        head = SECOND_HEAD.match(lines[fault.line - 1]) if fault.line else None
        if head and "overwrite" in fault.message:
            message = f"stands above as [{head[1]}]; write [[{head[1]}]] with two brackets there, too"
            return [fault._replace(path=head[1], message=message)]
    return []


def _without_results(syntax: Sequence[Fault], found: Sequence[Fault], lines: Sequence[str]) -> list[Fault]:
    """The faults of lines that are not TOML, and those of the others without keys that are missing because of them."""
    begins = [KEY_OF_LINE.match(lines[fault.line - 1]) for fault in syntax if fault.line]
    lost = {match[1] for match in begins if match}
    return [*syntax, *(fault for fault in found if not _is_lost(fault, lost))]


def _is_lost(fault: Fault, keys: Collection[str]) -> bool:
    return fault.message.startswith(MISSING) and fault.path.rpartition(".")[2] in keys


def _placed(scene: Scene) -> int:
    """The number of particles to place."""
    return sum(getattr(species, "count", 0) or 0 for species in getattr(scene, "particles", ()))


def without_bad_lines(source: Source) -> tuple[Source, list[Fault]]:
    """The text in which lines that are not TOML are empty, and the faults of these lines."""
    faults: list[Fault] = []
    for _ in range(ROUNDS):
        try:
            parsed(source)
        except SceneError as error:
            (fault,) = error.faults
            lines = source.text.split("\n")
            if fault.line is None or fault.line > len(lines) or not lines[fault.line - 1].strip():
                break
            faults.append(fault)
            lines[fault.line - 1] = ""
            source = source._replace(text="\n".join(lines))
            if "twice" in fault.message:
                break  # otherwise the keys of the second table would be faults of the first one
        else:
            break
    return source, faults


def _faults_of(source: Source, overrides: Sequence[str]) -> list[Fault]:
    """The faults of the keys of a text; empty if it is not TOML."""
    try:
        raw = tables_of(source.text)
    except (ValueError, RecursionError):
        return []
    changed, faults = overridden(raw, overrides)
    _, found = _examined(raw, source)
    return placed(source, [*faults, *found], changed)


def _examined(raw: dict[str, Any], source: Source) -> tuple[Scene | None, list[tuple[Path, str]]]:
    """The scene of plain data with the contents of its tables and files, or its faults."""
    name_liquid(raw)
    dry = sources_followed(raw, source.folder)
    rows = rows_from(raw, source.folder)
    if rows.plain and not rows.faults:
        raw["rows"] = rows.plain
    scene, found = examined(raw, also=sources_of(raw))
    return scene, [*dry, *rows.faults, *found]


def valid_part(source: Source, overrides: Sequence[str]) -> tuple[Scene | None, set[Path]]:
    """The scene with misspelt keys corrected and faulty ones omitted, and the paths of both; None if the remainder is
    not a scene.
    """
    try:
        raw = tables_of(source.text)
    except (ValueError, RecursionError):
        return None, set()
    overridden(raw, overrides)
    dropped: set[Path] = set()
    for _ in range(ROUNDS):
        scene, found = _examined(copy.deepcopy(raw), source)
        if not found:
            return scene, dropped
        if any(message.startswith(MISSING) for _, message in found) or not _corrected(raw, found, dropped):
            misspelt = [one for one in found if MEANT.match(one[1])]
            if not misspelt or not _corrected(raw, misspelt, dropped):
                return None, dropped
    return None, dropped


def _corrected(raw: dict[str, Any], found: Sequence[tuple[Path, str]], dropped: set[Path]) -> bool:
    """Rename misspelt keys and remove faulty ones; return whether any was changed."""
    done = False
    for path, message in found:
        table = value_at(raw, path[:-1], None) if path else None
        if not isinstance(table, dict) or path[-1] not in table:
            continue
        value, meant = table.pop(path[-1]), MEANT.match(message)
        if meant and meant[1] not in table:
            table[meant[1]] = value
        else:
            dropped.add(path)
        done = True
    return done


def _located(error: SceneError, source: Source, overrides: Sequence[str], dropped: set[Path]) -> list[Fault]:
    """Faults of the valid part with their lines, without those of omitted keys."""
    raw = tables_of(source.text)
    changed = overridden(raw, overrides)[0]
    name_liquid(raw)
    sources_followed(raw, source.folder)
    rows = rows_from(raw, source.folder)
    faults = rows.with_origins([(read_path(fault.path), fault.message) for fault in error.faults])
    return placed(source, [one for one in faults if one[0] not in dropped], changed)
