"""Reading scenes from files and from plain data: a scene, or all of its faults; and changes from
the command line.

The table of scenes, the conversion between scenes and plain data, and the units that the schema knows.

>>> scene = from_plain({"model": "floating", "duration": "1 s", "frame_every": "0.1 s",
...     "particles": [{"radius": "1 mm", "density": 600, "contact_angle": "70 deg"}]})
>>> from_plain(to_plain(scene)) == scene
True
"""

from __future__ import annotations

import copy
import dataclasses
import hashlib
import itertools
import json
import re
import tomllib
import typing
from collections.abc import Callable, Iterator, Mapping, MutableMapping, Sequence
from functools import cache
from pathlib import Path as File
from typing import Any, NamedTuple, cast

from pydantic import TypeAdapter, ValidationError

from ecume import _hooks
from ecume.errors import Fault, SceneError
from ecume.scenes.common import Common
from ecume.scenes.faults import (
    MISSING,
    Inconsistent,
    Path,
    as_faults,
    echo,
    faults_of,
    place_of,
    places,
    read_path,
    suggestion,
    value_at,
    written,
)
from ecume.scenes.floating import FloatingScene
from ecume.scenes.floating.sources import RUN as START
from ecume.scenes.floating.sources import SOURCES, rows_from
from ecume.scenes.quantities import Measured
from ecume.scenes.sizes import follow_sizes
from ecume.scenes.soft import SoftScene
from ecume.scenes.sph import SphScene
from ecume.scenes.tables import NotText, text_of
from ecume.scenes.templates import templates
from ecume.scenes.tracers import TracersScene, follow_field
from ecume.units import Unit

Scene = FloatingScene | SoftScene | SphScene | TracersScene
"""Any scene."""


class _Scenes(MutableMapping[str, type[Common]]):
    """A table with the rows of this file, which no model is imported for, and those that other models bring along."""

    def __init__(self, rows: Mapping[str, type[Common]]) -> None:
        self._rows = dict(rows)

    def __getitem__(self, name: str) -> type[Common]:
        return self._rows[name] if name in self._rows else _hooks.scenes_of_models(None)[name]

    def __setitem__(self, name: str, kind: type[Common]) -> None:
        self._rows[name] = kind

    def __delitem__(self, name: str) -> None:
        del self._rows[name]

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys([*self._rows, *_hooks.scenes_of_models(None)]))

    def __len__(self) -> int:
        return len(list(iter(self)))


SCENES = _Scenes({"floating": FloatingScene, "soft": SoftScene, "sph": SphScene, "tracers": TracersScene})
"""The type of the scenes of each model, by its name."""


def from_plain(plain: Mapping[str, Any]) -> Scene:
    """The scene of plain data (tables, lists, text, numbers). Raises SceneError with all faults at once."""
    scene, found = examined(plain)
    if found:
        raise SceneError(as_faults(found))
    return cast(Scene, scene)


def examined(plain: Mapping[str, Any], also: Sequence[str] = ()) -> tuple[Scene | None, list[tuple[Path, str]]]:
    """The scene, or all of its faults; `also` are further keys that its file may have."""
    model = plain.get("model")
    kind = SCENES.get(model) if isinstance(model, str) else None
    if kind is None:
        return None, [(("model",), _no_model(model))]
    try:
        return cast(Scene, _reader(str(model)).validate_python(dict(plain))), []
    except ValidationError as error:
        return None, faults_of(error, kind, plain, also)


def _no_model(model: object) -> str:
    choices = ", ".join(f'"{name}"' for name in SCENES)
    if model is None:
        return f"is missing; expected one of {choices}"
    return f"got {echo(model)}; expected one of {choices}; {suggestion(str(model), SCENES)}"


@cache
def _reader(model: str) -> TypeAdapter[Common]:
    return TypeAdapter(SCENES[model])


def to_plain(scene: Scene) -> dict[str, Any]:
    """Tables, lists, text and numbers with all defaults filled in: valid JSON, which `from_plain` reads."""
    return cast(dict[str, Any], _listed(dataclasses.asdict(scene)))


def _listed(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _listed(item) for key, item in value.items()}
    return [_listed(item) for item in value] if isinstance(value, (list, tuple)) else value


def scene_hash(scene: Scene) -> str:
    """A hash of 64 hexadecimal digits, equal for equal scenes only."""
    return hashlib.sha256(json.dumps(to_plain(scene), sort_keys=True).encode()).hexdigest()


ANGLE = "contact_angle"


def unit_of(plain: Mapping[str, Any], path: Path) -> str:
    """The SI unit that the schema knows for a place in a scene."""
    kind, unit = SCENES[plain["model"]], ""
    for key in path:
        kind = below(kind, key)
        unit = item_unit(kind) or (unit if isinstance(key, int) else "")
    return unit or "1"


def item_unit(kind: Any) -> str:
    """The SI unit in an annotation; empty without one."""
    return next((mark.symbol for mark in _marks(kind) if isinstance(mark, (Unit, Measured))), "")


def below(kind: Any, key: str | int) -> Any:
    """The annotation one key further down."""
    if isinstance(key, int):
        return next((inner for part in _parts(kind) if (inner := _items(part)) is not None), None)
    piece = next((part for part in _parts(kind) if dataclasses.is_dataclass(part)), None)
    return _hints(piece).get(key) if isinstance(piece, type) else None


def _items(kind: Any) -> Any:
    """The annotation of a tuple's items; None of what is no tuple."""
    return typing.get_args(kind)[0] if typing.get_origin(kind) is tuple else None


def _parts(kind: Any) -> Iterator[Any]:
    """An annotation, and those that it is a choice of."""
    yield kind
    if typing.get_origin(kind) is not tuple:
        for part in typing.get_args(kind):
            yield from _parts(part)


@cache
def _hints(piece: type) -> dict[str, Any]:
    return typing.get_type_hints(piece, include_extras=True)


def _marks(kind: Any) -> Iterator[Any]:
    """The marks of an annotation, however deep."""
    for part in typing.get_args(kind):
        yield part
        yield from _marks(part)


KEY = re.compile(r"[A-Za-z0-9_-]{1,60}(?:\[[0-9]{1,9}\])*(?:\.[A-Za-z0-9_-]{1,60}(?:\[[0-9]{1,9}\])*){0,9}")
LONGEST = 10_000


def overridden(raw: dict[str, Any], overrides: Sequence[str]) -> tuple[set[Path], list[tuple[Path, str]]]:
    """Write the overrides into `raw`; return the paths they set, and their faults."""
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
    """Set the value at a path; missing tables on the path are created."""
    for depth, (key, following) in enumerate(itertools.pairwise(path)):
        if isinstance(key, str) and isinstance(raw, dict) and isinstance(following, str):
            raw.setdefault(key, {})
        raw = raw[_fitting(raw, key, path[: depth + 1])]
    raw[_fitting(raw, path[-1], path, new=True)] = value


def _fitting(raw: Any, key: str | int, path: Path, *, new: bool = False) -> Any:
    """The key, if a value exists there."""
    if isinstance(key, str) and isinstance(raw, dict) and (new or key in raw):
        return key
    if isinstance(key, int) and isinstance(raw, list) and key < len(raw):
        return key
    if isinstance(raw, list):
        whole = written(path[:-1])
        held = f"{whole}[0]" if len(raw) == 1 else f"{whole}[0] to {whole}[{len(raw) - 1}]"
        raise ValueError(f"{whole} is a list; expected one of it: {held}" if raw else f"{whole} is an empty list")
    raise ValueError(f"the scene has no {written(path)}")


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
    except SceneError:  # there is no such file
        return list(error.faults)
    faults = [*syntax] if syntax else list(error.faults)
    if syntax:
        faults += _faults_of(text, overrides)
    scene, dropped = valid_part(text, overrides)
    if scene is not None and _placed(scene) <= QUICK:
        try:
            examine(scene)
        except SceneError as more:
            faults += _located(more, text, overrides, dropped)
    unique = {(fault.path, fault.message): fault for fault in faults}.values()
    return sorted(unique, key=lambda fault: (fault.line is None, fault.line or 0, fault.column or 0))


def _placed(scene: Scene) -> int:
    """The number of particles to place."""
    return sum(getattr(species, "count", 0) or 0 for species in getattr(scene, "particles", ()))


def without_bad_lines(source: Source) -> tuple[Source, list[Fault]]:
    """The text with an empty line for each that is not TOML, and the faults of these lines."""
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
    scene, found = examined(raw, also=SOURCES)
    return scene, [*dry, *rows.faults, *found]


def valid_part(source: Source, overrides: Sequence[str]) -> tuple[Scene | None, set[Path]]:
    """The scene with misspelt keys corrected and faulty ones omitted, and the paths of these; None if the rest is no
    scene.
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


BARE = re.compile(r"[^=#]*=\s*([\w.+-][^\"'\[\]{}#=]*[^\W\d_][^\"'\[\]{}#=]*?)\s*(?:#.*)?$")
"""The pattern of a line with words without quotes."""
MOST_BYTES = 2**20
DEEPEST = 64
LONGEST_LINE = 400
"""The length of a line up to which a hint is searched."""
TOKENS = re.compile(
    r'''"""(?:\\.|[^\\])*?(?:"""|\Z)|\'{3}.*?(?:\'{3}|\Z)|"(?:\\.|[^"\\\n])*+"?|\'[^\'\n]*+\'?|\#[^\n]*|[=,{}\[\]\n.]''',
    re.DOTALL,
)
"""The pattern of separators of keys, and of texts and comments that may contain them."""
"""Tables in tables, and parts of a key."""
OVERRIDDEN = " (from --set)"
"""The remark after a fault of an override."""
OF_SWEEPS = {"axes", "sampling", "process", "template"}
"""Keys of sweep files only."""
FROM_ELSEWHERE = {"particles", "rows", "fluid", "cell"}
"""Tables that a start fills in: their faults are not reported if the start itself has faults."""
LONGEST_NAME = 200
"""The longest file name that is looked up."""


class Source(NamedTuple):
    """A scene's text, what messages call it, and the folder in which it looks for tables and runs."""

    text: str
    name: str
    folder: File


def load_scene(path_or_text: str | File, overrides: Sequence[str] = ()) -> Scene:
    """The scene of a file, or of TOML text. Raises SceneError with all faults at once, each with its line and column.

    `overrides` are changes such as `particles[0].count=10` or `dish.radius=4 cm`. Tables and runs that the scene names
    are looked for beside its file (beside nothing but the current folder when it is text).
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
    started = START in raw
    dry = sources_followed(raw, folder)
    rows = rows_from(raw, folder)
    if rows.plain and not rows.faults:
        raw["rows"] = rows.plain
    scene, found = examined(raw, also=SOURCES)
    if started and (dry or rows.faults):
        found = [fault for fault in found if fault[0] and fault[0][0] not in FROM_ELSEWHERE]
    # A scene without its rows has no floats, and a region without its file has no shape: these are not separate faults.
    excused = {path[:-1] or ("fluid",) for path, _ in dry} | ({("particles",)} if rows.faults else set())
    faults = dry + rows.faults + rows.with_origins([fault for fault in found if fault[0] not in excused])
    return (None if faults else scene), faults


def located(error: SceneError, path_or_text: str | File, overrides: Sequence[str] = ()) -> SceneError:
    """The error with the lines and columns of the file, for faults that a model found in a scene."""
    source = source_of(path_or_text)
    raw = parsed(source)
    changed = overridden(raw, overrides)[0]
    name_liquid(raw)
    sources_followed(raw, source.folder)
    rows = rows_from(raw, source.folder)
    faults = rows.with_origins([(read_path(fault.path), fault.message) for fault in error.faults])
    return SceneError(placed(source, faults, changed), source.name)


def name_liquid(raw: dict[str, Any]) -> None:
    """Replace `liquid = "water"` and a `temperature` beside it by the table of these two."""
    name = raw.get("liquid")
    if isinstance(name, str):
        given = {"temperature": raw.pop("temperature")} if "temperature" in raw else {}
        raw["liquid"] = {"name": name, **given}


def sources_followed(raw: dict[str, Any], folder: File) -> list[tuple[Path, str]]:
    """Put the contents of the files that a scene names into `raw`; return the faults of these files."""
    if raw.get("model") == "floating":
        from ecume.scenes.floating.surroundings import follow_current

        return [*follow_sizes(raw, folder), *follow_current(raw, folder)]
    if raw.get("model") == "soft":
        return [*follow_sizes(raw, folder), *_started(raw, folder)]
    if raw.get("model") == "tracers":
        return [*follow_sizes(raw, folder), *follow_field(raw, folder), *_started(raw, folder)]
    if raw.get("model") != "sph":
        return []
    from ecume.scenes.sph.sources import follow_sources

    return follow_sources(raw, folder)


def _started(raw: dict[str, Any], folder: File) -> list[tuple[Path, str]]:
    """Put the particles of another run or program into the species of a scene of soft spheres or tracers."""
    if START not in raw:
        return []
    from ecume.scenes.starts import filled, is_run, of_run, opened

    given = raw.pop(START)
    try:
        start, faults = (of_run(folder, given, raw["model"]), []) if is_run(given) else opened(given, folder)
        if start is not None:
            filled(raw, start)
    except Inconsistent as fault:
        return list(fault.complaints)
    except ValueError as fault:
        return [((START,), f"{echo(given)} {fault}")]
    return faults


def source_of(path_or_text: str | File) -> Source:
    """The source, a file or a text: a text contains a line break or an equals sign, a file exists."""
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
    """A hint for a user who named a missing file."""
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
    """The tables of a TOML text. Python's reader may raise two exceptions beside its own."""
    try:
        return tables_of(source.text)
    except tomllib.TOMLDecodeError as error:
        fault = _syntax_fault(str(error), source.text)
    except RecursionError:
        fault = Fault("", "is nested too deeply")
    except ValueError as error:
        fault = Fault("", f"is not TOML: {error}")
    raise SceneError([fault], source.name)


def tables_of(text: str) -> dict[str, Any]:
    """The tables of a TOML text. Raises ValueError, and RecursionError if it is nested too deeply."""
    require_shallow_keys(text)
    return _shallow(tomllib.loads(text))


def require_shallow_keys(text: str) -> None:
    """Raise RecursionError for a key of too many parts, `a.a.a ...`: Python's reader needs quadratic time for them."""
    parts = 0
    for token in TOKENS.finditer(text):
        mark = token[0]
        if mark == ".":
            parts += 1
            if parts > DEEPEST:
                raise RecursionError
        elif len(mark) == 1 and mark in "=,{}[]\n":
            parts = 0


def _shallow(raw: dict[str, Any]) -> dict[str, Any]:
    """The same tables. Raises RecursionError if they are nested too deeply for later readers."""
    level: list[Any] = [raw]
    for _ in range(DEEPEST):
        level = [item for each in level for item in (each.values() if isinstance(each, dict) else each)]
        level = [item for item in level if isinstance(item, dict | list)]
        if not level:
            return raw
    raise RecursionError


BRACKETED = re.compile(r"\s*[A-Za-z_.]+\[[0-9]+\][A-Za-z0-9_.\[\]]*\s*=")
"""The pattern of a path with an index as a key."""


def _syntax_fault(given: str, text: str) -> Fault:
    """The message of Python's reader as a fault with its position."""
    message, _, place = given.rpartition(" (at ")
    numbers = re.findall(r"\d+", place)
    ending = text.rstrip("\n").split("\n")
    line, column = map(int, numbers) if len(numbers) == 2 else (len(ending), len(ending[-1]) + 1)
    bare = BARE.match(ending[min(line, len(ending)) - 1][:LONGEST_LINE])
    word = bare[1].strip() if bare else ""
    switch = word.lower() if word.lower() in ("true", "false") else {"yes": "true", "no": "false"}.get(word.lower())
    hint = f'; text and numbers with units need quotes: "{word}"' if bare else ""
    hint = f"; write {switch}, in small letters" if switch else hint
    if "twice" in message:
        hint = "; expected each table once: put all its keys under one head"
    elif BRACKETED.match(ending[min(line, len(ending)) - 1][:LONGEST_LINE]):
        hint = '; a path with brackets needs quotes: "particles[0].count" = 30'
    return Fault("", f"is not TOML: {message or given}{hint}", line, column)


def placed(source: Source, faults: Sequence[tuple[Path, str]], changed: set[Path]) -> list[Fault]:
    """Faults with their lines and columns; those of overrides have none."""
    known = places(source.text)
    found = []
    for path, message in faults:
        overridden_here = any(path[: len(start)] == start for start in changed)
        line, column = (None, None) if overridden_here else place_of(path, known)
        found.append(Fault(written(path), message + OVERRIDDEN * overridden_here, line, column))
    return sorted(found, key=lambda fault: (fault.line is None, fault.line or 0, fault.column or 0))
