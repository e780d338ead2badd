"""The faults of a scene in terms of the user's file, with line and column of each."""

from __future__ import annotations

import dataclasses
import re
import tomllib
import types
import typing
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, Literal

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from ecume.errors import Fault, nearest

if TYPE_CHECKING:
    from tree_sitter import Node


Place = tuple[int, int]
"""Line and column, both from 1, in characters."""

KEYS = ("bare_key", "quoted_key", "dotted_key")
TABLES = ("table", "table_array_element")


def places(text: str) -> dict[Path, Place]:
    """The place of every table, key and list item of a TOML text that parses."""
    import tree_sitter
    import tree_sitter_toml

    language = tree_sitter.Language(tree_sitter_toml.language())
    root = tree_sitter.Parser(language).parse(text.encode()).root_node
    lines = text.encode().split(b"\n")
    return {
        path: (
            node.start_point[0] + 1,
            len(lines[node.start_point[0]][: node.start_point[1]].decode(errors="replace")) + 1,
        )
        for path, node in _entries(root)
    }


def place_of(path: Path, known: dict[Path, Place]) -> Place | tuple[None, None]:
    """The position of a path, or of the nearest piece around it; for a missing key, the beginning of the file.

    The position of a list of tables is that of its first table.
    """
    if path not in known and (*path, 0) in known:
        return known[*path, 0]
    around = (known[path[:end]] for end in range(len(path), 0, -1) if path[:end] in known)
    return next(around, (1, 1) if path else (None, None))


def _entries(root: Node) -> Iterator[tuple[Path, Node]]:
    """Yield each path with the node at which it is defined."""
    counts: dict[Path, int] = {}
    for child in root.named_children:
        if child.type == "pair":
            yield from _values((), child)
        if child.type in TABLES:
            yield from _table(child, counts)


def _table(node: Node, counts: dict[Path, int]) -> Iterator[tuple[Path, Node]]:
    """Yield the entries of a `[table]`, or of one more `[[table]]` of a list; `counts` contains the number of tables of
    each list so far.
    """
    head: Path = ()
    names = _key(node.named_children[0])
    for depth, name in enumerate(names, 1):
        head += (name,)
        if node.type == "table_array_element" and depth == len(names):
            counts[head] = counts.get(head, 0) + 1
        if head in counts:
            head += (counts[head] - 1,)
    yield head, node
    for pair in node.named_children[1:]:
        if pair.type == "pair":
            yield from _values(head, pair)


def _values(head: Path, top: Node) -> Iterator[tuple[Path, Node]]:
    """Yield a pair and all values in it, without recursion, since a file may be nested arbitrarily deep."""
    waiting = [(head, top)]
    while waiting:
        path, node = waiting.pop()
        if node.type == "pair":
            path, value = path + _key(node.named_children[0]), node.named_children[-1]
            yield path, node
        else:
            value = node
        if value.type == "inline_table":
            waiting += [(path, pair) for pair in value.named_children if pair.type == "pair"]
        if value.type == "array":
            items = [item for item in value.named_children if item.type != "comment"]
            yield from (((*path, index), item) for index, item in enumerate(items))
            waiting += [((*path, index), item) for index, item in enumerate(items)]


def _key(node: Node) -> Path:
    """The parts of a key: two for `dish.radius`. The grammar nests dotted keys to the left."""
    if node.type == "dotted_key":
        return tuple(name for part in node.named_children if part.type in KEYS for name in _key(part))
    text = (node.text or b"").decode(errors="replace")
    if node.type == "quoted_key":
        text = str(tomllib.loads(f"key = {text}")["key"])
    return (text,)


Key = str | int
Path = tuple[Key, ...]
Complaints = list[tuple[Path, str]]
"""Inconsistencies, each with its path relative to the piece that reports it."""

BARE = re.compile(r"[A-Za-z0-9_-]{1,60}")
LONGEST_ECHO = 60
MOST_FAULTS = 500


class Inconsistent(ValueError):
    """Values that are valid separately but inconsistent with one another; each with its path relative to the checked
    object.
    """

    def __init__(self, complaints: Sequence[tuple[Path, str]]) -> None:
        self.complaints = tuple(complaints)
        super().__init__("; ".join(message for _, message in complaints))


def written(path: Path) -> str:
    """The text `particles[0].radius` for the path `("particles", 0, "radius")`."""
    parts = (f"[{key}]" if isinstance(key, int) else "." + (key if BARE.fullmatch(key) else echo(key)) for key in path)
    return "".join(parts).removeprefix(".")


def read_path(text: str) -> Path:
    """The path `("particles", 0, "radius")` for the text `particles[0].radius`.

    >>> read_path("particles[0].radius")
    ('particles', 0, 'radius')
    """
    parts = re.findall(r"\[([0-9]+)\]|([A-Za-z0-9_-]+)", text)
    return tuple(int(index) if index else name for index, name in parts)


def echo(value: object) -> str:
    """The given value as short text that is safe to print."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, (list, tuple)):
        return f"a list of {len(value)}"
    if isinstance(value, int) and value.bit_length() > 100:
        return f"a whole number of {value.bit_length()} bits"
    text = ascii(value) if isinstance(value, str) and not value.isprintable() else repr(value)
    return text if len(text) <= LONGEST_ECHO else text[: LONGEST_ECHO - 3] + "..."


SYNONYMS: dict[str, tuple[str, ...]] = {
    "floats": ("particles",),
    "spheres": ("particles",),
    "grains": ("particles",),
    "tracers": ("particles", "passive_tracers"),
    "carried": ("passive_tracers",),
    "box": ("cell",),
    "wendland": ("wendland-c2",),
    "dt": ("time_step",),
    "timestep": ("time_step",),
    "stepping": ("integration",),
    "time_stepping": ("integration",),
    "scheme": ("integrator",),
    "motion": ("hydrodynamics",),
    "films": ("lubrication",),
    "courant": ("courant_number",),
    "fastest": ("maximum_speed",),
    "shake": ("base_excitation",),
    "central_pull": ("central_force",),
    "remote": ("long_range_forces",),
    "reach": ("cutoff",),
    "place": ("position",),
    "measures": ("quantities",),
    "base": ("scene",),
    "eddy_dispersion": ("turbulent_dispersion",),
    "hamaker": ("hamaker_constant",),
}
"""Other words for keys whose spelling is too different to be recognized."""
MOVED = "bodies.motion: a solid that moves is one of [[bodies]], with a path instead of a density"
PATH_WORDS = (
    "motion",
    "velocity",
    "speed",
    "spin",
    "rotation",
    "angular_velocity",
    "angle_amplitude",
    "angles",
    "pivot",
)
"""Words for the path of a solid, which users expect in other tables than that of bodies."""
TURNING_WORDS = "angle", "angle_amplitude", "roll", "rotation", "tilt"
ROLLS = "roll: a tank that turns about a pivot has the table [roll]"
TURNED = "vertices: a solid at an angle is given by its corners, or by a drawing in outline_from"
ELSEWHERE = {
    **{f"obstacles.{word}": MOVED for word in PATH_WORDS},
    **{f"tank.{word}": MOVED for word in PATH_WORDS},
    **{f"base_excitation.{word}": MOVED for word in PATH_WORDS},
    **{f"{table}.{word}": ROLLS for table in ("tank", "base_excitation") for word in TURNING_WORDS},
    **{
        f"{table}.{word}": TURNED
        for table in ("obstacles", "bodies", "fluid")
        for word in ("angle", "tilt", "orientation")
    },
    **{f"bodies.{word}": "bodies.motion" for word in ("rotation", "angle_amplitude", "angles", "pivot")},
    "dish.periodic": "the table [cell]",
    "liquid.gravity": "gravity, at the top of the scene",
    "liquid.flow": "the table [flow]",
    "liquid.shear_rate": "flow.shear_rate",
    "liquid.drag": "hydrodynamics.drag",
    "method.time_step": "integration.time_step",
    "method.integrator": "integration.integrator",
    "method.courant": "integration.courant_number",
    "tank.size": "tank.low and tank.high",
    **{f"{table}.length_unit": "outline_unit" for table in ("fluid", "obstacles", "bodies", "tank")},
}
"""Keys that users expect in a table, and where they are instead."""


DRAWN = ("outline_from", "outline_unit")
IN_FILES = {
    "ecume.scenes.sph.scene.RegionSpec": ("particles_from", *DRAWN),
    "ecume.scenes.sph.solids.ObstacleSpec": DRAWN,
    "ecume.scenes.sph.solids.BodySpec": DRAWN,
    "ecume.scenes.sph.tank.TankSpec": DRAWN,
}
"""Further keys of tables in a file; the contents of the named files replace them in the scene."""


def suggestion(word: str, choices: Iterable[str]) -> str:
    """The text `did you mean radius?`, or all choices if none is similar."""
    known = list(choices)
    for same in SYNONYMS.get(word, ()):
        if same in known:
            return f"did you mean {same}?"
    return nearest(word[:LONGEST_ECHO], known)


def faults_of(error: ValidationError, kind: type, raw: object, also: Sequence[str] = ()) -> list[tuple[Path, str]]:
    """The faults that pydantic found in `raw` as a value of type `kind`; `also` are further keys at the top."""
    details = error.errors(include_url=False)
    details = [detail for detail in details if not _emptied(detail, details)]
    found = list(
        dict.fromkeys(each for detail in details[:MOST_FAULTS] for each in _described(detail, kind, raw, also))
    )
    mistyped = {(*path[:-1], near) for path, message in found if (near := _meant(message)) is not None}
    listed = [(path, message) for path, message in found if not (path in mistyped and message.startswith(MISSING))]
    left = len(details) - MOST_FAULTS
    return listed + ([((), f"and {left} more faults")] if left > 0 else [])


MISSING = "is missing"


def _emptied(detail: ErrorDetails, details: Sequence[ErrorDetails]) -> bool:
    """Whether a list is too short only because of wrong items; this is not a separate fault."""
    path = detail["loc"]
    below = (other["loc"] for other in details if len(other["loc"]) > len(path))
    return detail["type"] == "too_short" and any(other[: len(path)] == path for other in below)


def _meant(message: str) -> str | None:
    match = re.fullmatch(r"no such key; did you mean (\w+)\?", message)
    return match[1] if match else None


def _described(detail: ErrorDetails, kind: type, raw: object, also: Sequence[str]) -> list[tuple[Path, str]]:
    """The paths and messages of one of the faults that pydantic found."""
    path = tuple(detail["loc"])
    if (label := _label_in(kind, path)) is not None:
        # A number or a list: only the faults of the given kind are reported, and pydantic's label is not a key.
        meant = isinstance(value_at(raw, path[:label], detail["input"]), list | tuple)
        if meant != str(path[label]).startswith("tuple["):
            return []
        path = path[:label] + path[label + 1 :]
    if detail["type"] == "unexpected_keyword_argument":
        if (place := ELSEWHERE.get(written(tuple(part for part in path if isinstance(part, str))))) is not None:
            return [(path, f"no such key; did you mean {place}?")]
        known = _keys(kind, path[:-1], also)
        other = len(path) > 1 or set(SYNONYMS.get(str(path[0]), ())) & set(known)
        below = [] if other else _paths_to(kind, str(path[0]))
        if len(below) == 1:
            return [(path, f"no such key; did you mean {below[0]}?")]
        return [(path, f"no such key; {suggestion(str(path[-1]), known)}")]
    if detail["type"] == "missing" and isinstance(path[-1], int):
        pair = value_at(raw, path[:-1], detail["input"])
        return [(path[:-1], f"got {echo(pair)}; expected a list of {len(_items(_kind_at(kind, path[:-1])))}")]
    if detail["type"] == "missing":
        return [(path, f"{MISSING}{_hint(kind, path)}")]
    cause = detail.get("ctx", {}).get("error")
    if isinstance(cause, Inconsistent):
        return [(path + below, message) for below, message in cause.complaints]
    got = f"got {_echo_of_list(value_at(raw, path, detail['input']), cause)}"
    return [(path, f"{got}; {cause if cause is not None else _expected(detail)}{_as_table(detail, kind, path)}")]


def _echo_of_list(value: object, cause: object) -> str:
    """The given value as text; a short list that a function refused as a whole with its items."""
    if cause is None or not isinstance(value, list) or not 0 < len(value) <= FEW_ITEMS:
        return echo(value)
    return f"[{', '.join(map(echo, value))}]"


FEW_ITEMS = 4
"""The largest number of items of a list that are printed."""


def _as_table(detail: ErrorDetails, kind: type, path: Path) -> str:
    """A hint on how to write a table whose kind was given as text: `left = { kind = "outflow" }`."""
    word = detail["input"]
    if detail["type"] == "tuple_type" and isinstance(word, dict):
        return f"; write [[{'.'.join(str(key) for key in path if isinstance(key, str))}]] with two brackets"
    if detail["type"] == "dataclass_type" and isinstance(word, list) and word and isinstance(word[0], dict):
        return f"; write [{'.'.join(str(key) for key in path if isinstance(key, str))}] with one pair of brackets"
    if detail["type"] != "dataclass_type" or not isinstance(word, str):
        return ""
    hints = _hints(_kind_at(kind, path))
    keys = [key for key, hint in hints.items() if typing.get_origin(hint) is Literal and word in typing.get_args(hint)]
    return f"; write {path[-1]} = {{ {keys[0]} = {echo(word)} }}".replace("'", '"') if keys else ""


def _label_in(kind: type, path: Path) -> int | None:
    """The index in a path of pydantic's label for one of several kinds (`tuple[...]`); a key may have the same name."""
    for place, key in enumerate(path):
        if isinstance(key, str) and "[" in key and typing.get_origin(_kind_at(kind, path[:place])) is typing.Union:
            return place
    return None


def _items(kind: Any) -> tuple[Any, ...]:
    """The kinds of the items of a list; if one of several kinds is a list, of that list."""
    if typing.get_origin(kind) is typing.Union:
        return next(items for part in typing.get_args(kind) if (items := typing.get_args(part)))
    return typing.get_args(kind)


def _expected(detail: ErrorDetails) -> str:
    """The expected value, from the kind of the fault and its bounds."""
    bounds = detail.get("ctx", {})
    if detail["type"] == "literal_error":
        choices = [word for word in re.findall(r"'([^']*)'", str(bounds["expected"])) if word]
        near = suggestion(str(detail["input"]), choices)
        return f"expected one of {', '.join(choices)}" + ("" if near.startswith("known") else f"; {near}")
    if str(bounds.get("pattern", "")).lstrip("^(").startswith("[A-Za-z]["):
        return "expected a letter of A to Z or a to z, then such letters, digits and _"
    wording = WORDING.get(detail["type"], detail["msg"][:1].lower() + detail["msg"][1:])
    return wording.format_map({key: _number(value) for key, value in bounds.items()})


WORDING = {
    "greater_than": "expected more than {gt}",
    "greater_than_equal": "expected {ge} or more",
    "less_than": "expected less than {lt}",
    "less_than_equal": "expected {le} or less",
    "finite_number": "expected a finite number",
    "int_type": "expected a whole number",
    "int_from_float": "expected a whole number",
    "bool_type": "expected true or false",
    "string_type": "expected text",
    "string_too_long": "expected at most {max_length} characters",
    "string_too_short": "expected some text",
    "string_pattern_mismatch": "contains characters that are not allowed",
    "dataclass_type": "expected a table of keys and values",
    "tuple_type": "expected a list",
    "too_long": "expected a list of {max_length}",
    "too_short": "expected a list of {min_length} or more",
}


def _number(value: object) -> object:
    return f"{value:g}" if isinstance(value, float) else value


def value_at(raw: object, path: Path, otherwise: object) -> object:
    """The original value at a path."""
    for key in path:
        try:
            raw = raw[key]  # type: ignore[index]  # whatever cannot be indexed so ends the search
        except (KeyError, IndexError, TypeError):
            return otherwise
    return raw


def _keys(kind: type, path: Path, also: Sequence[str]) -> list[str]:
    """The valid keys in the piece at a path."""
    piece = _kind_at(kind, path)
    known = [field.name for field in dataclasses.fields(piece)] if dataclasses.is_dataclass(piece) else []
    in_files = IN_FILES.get(f"{piece.__module__}.{piece.__name__}", ()) if known else ()
    return [*known, *in_files, *(also if not path else ())]


def _paths_to(kind: type, word: str) -> list[str]:
    """The keys of this name in the tables of a scene, such as `hydrodynamics.brownian`."""
    tables = [(key, _kind_at(kind, (key,))) for key in _keys(kind, (), ())]
    return [f"{key}.{word}" for key, table in tables if word in _keys(table, (), ())]


def _hint(kind: type, path: Path) -> str:
    """An example of a missing value."""
    from ecume.units import Unit, example

    hints = typing.get_type_hints(_kind_at(kind, path[:-1]), include_extras=True)
    marks = typing.get_args(hints.get(str(path[-1])))
    units = [mark for mark in marks if isinstance(mark, Unit)]
    return f"; expected for example {example(units[0].symbol)!r}" if units else ""


@cache
def _hints(kind: Any) -> dict[str, Any]:
    """The types of the keys of a table without their units, whose evaluation is slow."""
    return typing.get_type_hints(kind)


def _kind_at(kind: Any, path: Path) -> Any:
    """The type of the piece at `path` of a `kind`."""
    for key in path:
        kind = _items(kind)[0] if isinstance(key, int) else _hints(kind)[key]
        if isinstance(kind, types.UnionType):
            kind = next(part for part in typing.get_args(kind) if part is not type(None))
    return kind


def as_faults(found: Iterable[tuple[Path, str]]) -> list[Fault]:
    """Faults without a position in a file."""
    return [Fault(written(path), message) for path, message in found]
