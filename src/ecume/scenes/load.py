"""Reading scenes from files: the text, the tables and files that it names, and the lines of its faults."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path as File
from typing import Any, NamedTuple

from ecume.errors import Fault, SceneError
from ecume.scenes.faults import (
    Inconsistent,
    Path,
    echo,
    place_of,
    places,
    read_path,
    written,
)
from ecume.scenes.fields import follow_field
from ecume.scenes.floating.sources import RUN as START
from ecume.scenes.floating.sources import SOURCES, TABLE, rows_from
from ecume.scenes.overrides import overridden
from ecume.scenes.schema import Scene, examined
from ecume.scenes.sizes import follow_sizes
from ecume.scenes.tables import NotText, followed, text_of
from ecume.scenes.templates import templates
from ecume.scenes.toml import syntax_fault, tables_of

MOST_BYTES = 2**20
OVERRIDDEN = " (from --set)"
"""The remark after a fault of an override."""
OF_SWEEPS = {"axes", "sampling", "process", "template"}
"""Keys of sweep files only."""
FROM_ELSEWHERE = {"particles", "rows", "fluid", "cell"}
"""Tables that a start fills in: their faults are not reported if the start itself has faults."""
LONGEST_NAME = 200
"""The longest file name that is looked up."""


class Source(NamedTuple):
    """The text of a scene, its name in messages, and the folder of its tables and runs."""

    text: str
    name: str
    folder: File


def load_scene(path_or_text: str | File, overrides: Sequence[str] = ()) -> Scene:
    """The scene of a file, or of TOML text. Raises SceneError with all faults at once, each with its line and column.

    `overrides` are changes such as `particles[0].count=10` or `dish.radius=4 cm`. Paths of tables and runs are relative
    to the folder of the file, or to the current folder if the scene is text.
    """
    source = source_of(path_or_text)
    raw = parsed(source)
    if "model" not in raw and OF_SWEEPS & raw.keys():
        raise SceneError([Fault("", f"is a sweep and no scene: ecume sweep {source.name}")], source.name)
    changed, faults = overridden(raw, overrides)
    scene, found = assembled(raw, source.folder)
    faults += found
    if scene is None or faults:
        raise SceneError(placed(source, faults, changed), source.name)
    return scene


def assembled(raw: dict[str, Any], folder: File) -> tuple[Scene | None, list[tuple[Path, str]]]:
    """The scene of plain data with the contents of its files, and all faults."""
    name_liquid(raw)
    started = any(key in raw for key in SOURCES)
    tank = raw.get("tank")
    drawn = isinstance(tank, dict) and OUTLINE in tank
    dry = sources_followed(raw, folder)
    rows = rows_from(raw, folder)
    if rows.plain and not rows.faults:
        raw["rows"] = rows.plain
    scene, found = examined(raw, also=sources_of(raw))
    if started and (dry or rows.faults):
        found = [fault for fault in found if fault[0] and fault[0][0] not in FROM_ELSEWHERE]
    # A scene without its rows has no floats, and a region without its file has no shape: these count as faults of the
    # files only.
    excused = {path[:-1] or ("fluid",) for path, _ in dry} | ({("particles",)} if rows.faults else set())
    if drawn:
        excused |= {("tank", "high")} if any(path[0] == "tank" for path, _ in dry if path) else set()
        found = [(_in_tank(path, raw), message) for path, message in found]
    faults = dry + rows.faults + rows.with_origins([fault for fault in found if fault[0] not in excused])
    return (None if faults else scene), faults


OUTLINE = "outline_from"


def _in_tank(path: Path, raw: Mapping[str, Any]) -> Path:
    """The path of a fault; those of the solid that a drawn tank is, the last obstacle, are faults of its drawing."""
    last = len(raw.get("obstacles", [])) - 1
    return ("tank", OUTLINE) if path[:2] == ("obstacles", last) else path


def located(error: SceneError, path_or_text: str | File, overrides: Sequence[str] = ()) -> SceneError:
    """The error with lines and columns in the file, for faults that a model found in a scene."""
    source = source_of(path_or_text)
    raw = parsed(source)
    changed = overridden(raw, overrides)[0]
    name_liquid(raw)
    sources_followed(raw, source.folder)
    rows = rows_from(raw, source.folder)
    faults = rows.with_origins([(read_path(fault.path), fault.message) for fault in error.faults])
    return SceneError(placed(source, faults, changed), source.name)


def name_liquid(raw: dict[str, Any]) -> None:
    """Replace `liquid = "water"`, and a `temperature` next to it, by a table of the two."""
    name = raw.get("liquid")
    if isinstance(name, str):
        given = {"temperature": raw.pop("temperature")} if "temperature" in raw else {}
        raw["liquid"] = {"name": name, **given}


def sources_followed(raw: dict[str, Any], folder: File) -> list[tuple[Path, str]]:
    """Insert the contents of the files that a scene names into `raw`. Returns the faults of these files."""
    if raw.get("model") == "floating":
        from ecume.scenes.floating.surroundings import follow_current

        return [*follow_sizes(raw, folder), *follow_current(raw, folder), *follow_field(raw, folder)]
    if raw.get("model") == "soft":
        return [*follow_sizes(raw, folder), *_started(raw, folder)]
    if raw.get("model") == "tracers":
        return [*follow_sizes(raw, folder), *follow_field(raw, folder), *_started(raw, folder)]
    if raw.get("model") != "sph":
        return []
    from ecume.scenes.sph.sources import follow_sources

    return follow_sources(raw, folder)


def sources_of(raw: dict[str, Any]) -> tuple[str, ...]:
    """The keys that specify particles by other files; a scene as data does not have them."""
    return (START,) if raw.get("model") == "sph" else SOURCES


def _started(raw: dict[str, Any], folder: File) -> list[tuple[Path, str]]:
    """Insert the particles of a table, or of another run or program, into the species of a scene of soft spheres or
    tracers.
    """
    given = {key: raw.pop(key) for key in SOURCES if key in raw}
    if not given:
        return []
    if len(given) > 1:
        return [((TABLE,), "of particles_from and start_from only one can stand in a scene")]
    if TABLE in given:
        return followed((TABLE,), _from_table, raw, given[TABLE], folder)
    from ecume.scenes.starts import filled, is_run, of_run, opened

    given = given[START]
    try:
        start, faults = (of_run(folder, given, raw["model"]), []) if is_run(given) else opened(given, folder)
        if start is not None:
            filled(raw, start)
    except Inconsistent as fault:
        return list(fault.complaints)
    except ValueError as fault:
        return [((START,), f"{echo(given)} {fault}")]
    return faults


def _from_table(raw: dict[str, Any], name: str, folder: File) -> None:
    """Insert the particles of a table. Raises ValueError, and Inconsistent."""
    from ecume.scenes.starts import filled, of_table

    filled(raw, of_table(folder, name, raw["model"]))


def source_of(path_or_text: str | File) -> Source:
    """The source, a file or a text. A text contains a line break or an equals sign; otherwise the source must be an
    existing file.
    """
    if isinstance(path_or_text, str) and (not path_or_text.strip() or re.search(r"[\n=]", path_or_text)):
        file = File(path_or_text) if "=" in path_or_text and "\n" not in path_or_text else None
        if file is None or len(path_or_text) > 255 or not file.is_file():
            return Source(_bounded(path_or_text), "scene", File())
    return source_in(File(path_or_text))


def source_in(path: File, most_bytes: int = MOST_BYTES) -> Source:
    """The text of a file. Raises SceneError if it cannot be read."""
    try:
        return Source(text_of(path, most_bytes), str(path), path.parent)
    except NotText as fault:
        raise SceneError([Fault("", fault.message, fault.line, fault.column)], str(path)) from None
    except ValueError as fault:
        raise SceneError([Fault("", f"{fault}{_meant(path)}")], str(path)) from None


def _meant(path: File) -> str:
    """A hint for a missing file: a similar name."""
    if len(path.name) > LONGEST_NAME:
        return ""
    if path.is_dir():
        return f"; the scene of that run is {path / 'scene.toml'}" if (path / "scene.toml").is_file() else ""
    if not path.suffix and path.with_suffix(".toml").is_file():
        return f"; did you mean {path.with_suffix('.toml')}?"
    return f"; `ecume new {path.stem}` writes it" if not path.exists() and path.stem in templates() else ""


def _bounded(text: str) -> str:
    if len(text) > MOST_BYTES:
        raise SceneError([Fault("", f"is longer than {MOST_BYTES / 2**20:g} MiB")])
    return text


def parsed(source: Source) -> dict[str, Any]:
    """The tables of a TOML text. Raises SceneError with the fault of its syntax."""
    try:
        return tables_of(source.text)
    except tomllib.TOMLDecodeError as error:
        fault = syntax_fault(str(error), source.text)
    except RecursionError:
        fault = Fault("", "is nested too deeply")
    except ValueError as error:
        fault = Fault("", f"is not TOML: {error}")
    raise SceneError([fault], source.name)


def placed(source: Source, faults: Sequence[tuple[Path, str]], changed: set[Path]) -> list[Fault]:
    """Faults with their lines and columns; those of overrides have none."""
    known = places(source.text)
    found = []
    for path, message in faults:
        overridden_here = any(path[: len(start)] == start for start in changed)
        line, column = (None, None) if overridden_here else place_of(path, known)
        found.append(Fault(written(path), message + OVERRIDDEN * overridden_here, line, column))
    return sorted(found, key=lambda fault: (fault.line is None, fault.line or 0, fault.column or 0))
