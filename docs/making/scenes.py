"""The reference of scenes, from the schema: every table, every key with its unit, default, range, an example, its
meaning and its effect.
"""

from __future__ import annotations

import dataclasses
import inspect
import math
import re
import tomllib
import typing
from collections.abc import Iterator
from functools import cache
from importlib.resources import files
from typing import Any, NamedTuple

import writing
from writing import cell, docstrings, toctree

from ecume.scenes.quantities import ByDimension
from ecume.scenes.schema import SCENES
from ecume.scenes.starts import StartSpec
from ecume.scenes.templates import templates
from ecume.units import example

EFFECT = re.compile(r"\s*\bEffect:\s+")
EXAMPLE = re.compile(r"\s*\bExample:\s+`([^`]*)`\.?")
"""Separates the meaning of a key from the effect of changing it."""
INTRODUCTION = """
Plain numbers are in SI units; text carries its unit, as in `"2 mm"` or `"70 deg"`. A key that a scene omits has the
default in the table; *needed* means that the key is required. `ecume check SCENE` reports all faults of a scene at
once, with their lines, and prints derived quantities.

The [scene vocabulary](../../vocabulary.md) compares the keys of the four models.

Any key can be changed on the command line: `ecume run bowl.toml --set "liquid.viscosity=5 mPa*s"`.
"""
START = """
`start_from = "runs/bowl@-1"` is a frame of another run. A table is a file of another program; see
[starts from other programs](../../how-to/start-from-other-programs.md).
"""
HEAD = "| key | unit | default | range | example | meaning | effect |\n|---|---|---|---|---|---|---|"


class Table(NamedTuple):
    """A table of a scene's file."""

    path: str
    """as its heading stands in the file: `[liquid]`, `[[particles]]`; nothing for the top"""
    kind: type


def pages() -> dict[str, str]:
    """A page for each model, and one that leads to them."""
    rows = [f"| [`{model}`]({model}.md) | {first_line(kind)} |" for model, kind in SCENES.items()]
    index = ["# Scene keys", INTRODUCTION, "| model | scene |", "|---|---|", *rows, "", toctree(SCENES)]
    found = {f"reference/scenes/{model}.md": page(model) for model in SCENES}
    return {"reference/scenes/index.md": "\n".join(index), **found}


def page(model: str) -> str:
    """All tables of a model's scenes."""
    parts = [f"# Scene keys of the model `{model}`\n\n{prose(SCENES[model])}\n"]
    for table in tables(SCENES[model]):
        title, says = (f"## {concept(table)}", prose(table.kind)) if table.path else ("## Top level", "")
        rows = [row(field, example_of(model, table, field)) for field in fields_of(table.kind)]
        parts.append(
            "\n".join(
                [
                    title,
                    "",
                    says,
                    "",
                    HEAD,
                    *rows,
                    "",
                ]
            )
        )
    if model == "floating":
        parts.append("A file may contain `particles_from`: reading converts the table into floats one by one.\n")
    parts.append(starts(model))
    own = [f"- `ecume new {name}`: {says}" for name, says in templates().items() if model_of(name) == model]
    return "\n".join([*parts, "## Templates\n", *own, ""])


def starts(model: str) -> str:
    """The keys of a start from a file of another program."""
    table = Table("[start_from]", StartSpec)
    rows = [row(field, example_of(model, table, field)) for field in fields_of(StartSpec)]
    text = [f"## {concept(table)}", "", START, "", prose(StartSpec), "", HEAD, *rows, ""]
    return "\n".join(text)


def model_of(template: str) -> str:
    """Which model a template is a scene of."""
    return str(tomllib.loads((files("ecume") / "templates" / f"{template}.toml").read_text(encoding="utf-8"))["model"])


def tables(kind: type) -> list[Table]:
    """The tables of a file, each once, in the order in which the schema names them."""
    found: dict[type, Table] = {}

    def look(part: type, path: str) -> None:
        for field in fields_of(part):
            for inner, many in parts_of(field.hint):
                if inner not in found:
                    below = f"{path}.{field.name}" if path else field.name
                    found[inner] = Table(f"[[{below}]]" if many else f"[{below}]", inner)
                    look(inner, below)

    found[kind] = Table("", kind)
    look(kind, "")
    return list(found.values())


def parts_of(hint: Any, *, many: bool = False) -> Iterator[tuple[type, bool]]:
    """The tables that an annotation speaks of, and whether they are lists of tables."""
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        yield hint, many
    origin = typing.get_origin(hint)
    for inner in typing.get_args(hint) if origin is not typing.Literal else ():
        yield from parts_of(inner, many=many or origin is tuple)


class Field(NamedTuple):
    """A key."""

    name: str
    hint: Any
    default: object
    says: str


def fields_of(kind: type) -> list[Field]:
    """The keys of a table."""
    hints, says = typing.get_type_hints(kind, include_extras=True), docstrings(kind)
    return [
        Field(field.name, hints[field.name], default(field), says.get(field.name, ""))
        for field in dataclasses.fields(kind)
    ]


def default(field: dataclasses.Field[Any]) -> object:
    """What a key is when it is left out."""
    return field.default_factory() if field.default_factory is not dataclasses.MISSING else field.default


def concept(table: Table) -> str:
    """The heading of a table: its concept, and how a file writes it."""
    words = table.path.strip("[]").replace(".", ": ").replace("_", " ")
    return f"{words[:1].upper()}{words[1:]} (`{table.path}`)"


def meaning_of(field: Field) -> str:
    """What a key is."""
    return EFFECT.split(EXAMPLE.sub("", field.says))[0].strip()


def effect_of(field: Field) -> str:
    """What changing a key does."""
    text = " ".join(EFFECT.split(EXAMPLE.sub("", field.says))[1:]).strip()
    return text[:1].upper() + text[1:]


@cache
def scenes_of(model: str) -> list[dict[str, Any]]:
    """The templates of a model, as they are written."""
    home = files("ecume") / "templates"
    read = [tomllib.loads((home / f"{name}.toml").read_text(encoding="utf-8")) for name in sorted(templates())]
    return [plain for plain in read if plain["model"] == model]


def example_of(model: str, table: Table, field: Field) -> str:
    """A value of a key: that of a template, or else one that fits its type."""
    path = [*(table.path.strip("[]").split(".") if table.path else []), field.name]
    found = [value for plain in scenes_of(model) for value in values_at(plain, path)]
    known = EXAMPLE.findall(field.says) + [value for value in map(toml, found) if len(value) <= LONGEST_EXAMPLE]
    return next(iter(known), "") or made_up(field)


LONGEST_EXAMPLE = 44


def values_at(plain: Any, path: list[str]) -> Iterator[Any]:
    """The values at a path, whichever item of a list they are in."""
    if isinstance(plain, list) and path and all(isinstance(item, dict) for item in plain):
        for item in plain:
            yield from values_at(item, path)
    elif not path:
        yield plain
    elif isinstance(plain, dict) and path[0] in plain:
        yield from values_at(plain[path[0]], path[1:])


def toml(value: Any) -> str:
    """A value as a file writes it; tables and lists of tables as their brackets."""
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {toml(item)}' for key, item in value.items())} }}"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return f"[{', '.join(map(toml, value))}]"
    return f'"{value}"' if isinstance(value, str) else f"{value!r}"


def made_up(field: Field) -> str:
    """A value that fits the type of a key."""
    words = [word for word in choices(field.hint) if word != field.default]
    named = [word for word in re.findall(r"`([a-z0-9-]+)`", meaning_of(field)) if word != field.default]
    unit = unit_of(field.hint)
    if below := list(parts_of(field.hint)):
        return f"[[{field.name}]]" if below[0][1] else f"[{field.name}]"
    if bool in (field.hint, *typing.get_args(field.hint)) or isinstance(field.default, bool):
        return str(not field.default).lower()
    if words:
        return f'"{words[0]}"'
    if unit:
        return listed(field.hint, f'"{example(unit.partition(";")[0])}"')
    if named and not isinstance(field.default, (int, float)):
        return f'"{named[0]}"'
    if isinstance(field.default, (int, float)) and field.default:
        return toml(field.default)
    if str in typing.get_args(field.hint) or "str" in str(field.hint):
        return f'"{field.name}"'
    ends = allowed(field.hint)
    return listed(field.hint, "1" if not ends.startswith(("0 to 1", "above 0, to 1")) else "0.5")


def listed(hint: Any, item: str) -> str:
    """An example of a list's item as one of the list."""
    text = str(hint)
    if "tuple[" not in text:
        return item
    return f"[[{item}, {item}]]" if text.count("tuple[") > 1 else f"[{item}, {item}]"


def choices(hint: Any) -> list[str]:
    """The words that a key accepts by its type."""
    if typing.get_origin(hint) is typing.Literal:
        return [word for word in typing.get_args(hint) if word != ""]
    return [word for part in typing.get_args(hint) for word in choices(part)]


def row(field: Field, sample: str) -> str:
    """A key as a row."""
    unit = unit_of(field.hint)
    usual = (
        f"{math.degrees(field.default):.4g} deg"
        if unit == "rad" and isinstance(field.default, float)
        else written(field.default)
    )
    cells = (
        f"`{field.name}`", unit or "–", usual, allowed(field.hint) or "–", f"`{sample}`",
        meaning_of(field), effect_of(field) or "–",
    )  # fmt: skip
    return f"| {' | '.join(map(cell, cells))} |"


def parts_below(hint: Any) -> Iterator[Any]:
    """An annotation and all inside of it."""
    yield hint
    for part in typing.get_args(hint):
        yield from parts_below(part)


def unit_of(hint: Any) -> str:
    """The SI unit of a key, or of the numbers in it; both where it depends on the dimension."""
    marks = [mark for part in parts_below(hint) for mark in typing.get_args(part) if isinstance(mark, ByDimension)]
    if marks:
        return f"{marks[0].space}; {marks[0].plane} in 2D"
    found = writing.unit_of(hint)
    return "" if found == "1" else found


def written(value: object) -> str:
    """A default."""
    if value is dataclasses.MISSING:
        return "*needed*"
    if value is None or value in ("", ()):
        return "–"
    if dataclasses.is_dataclass(value):
        return "as below"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return f"[{', '.join(written(item) for item in value)}]"
    return f"`{value}`" if isinstance(value, str) else f"{value:.6g}" if isinstance(value, float) else str(value)


def allowed(hint: Any) -> str:
    """Which values may stand there."""
    if hint is bool:
        return "true, false"
    if typing.get_origin(hint) is typing.Literal:
        return ", ".join(f"`{word}`" for word in typing.get_args(hint) if word != "")
    ends = {
        name: getattr(one, name)
        for extra in getattr(hint, "__metadata__", ())
        for one in (extra, *getattr(extra, "metadata", ()))
        for name in ("gt", "ge", "lt", "le")
        if getattr(one, name, None) is not None
    }
    inner = [] if ends else [found for found in map(allowed, typing.get_args(hint)) if found]
    return span(ends) or (inner[0] if inner else "")


def span(ends: dict[str, Any]) -> str:
    """A range in words."""
    if "gt" in ends:
        return f"above {number(ends['gt'])}" + (f", to {number(ends['le'])}" if "le" in ends else "")
    return " to ".join(number(ends[name]) for name in ("ge", "le") if name in ends)


def number(value: Any) -> str:
    """A bound, short."""
    return re.sub(r"e([+-])0?", r"e\1", f"{value:.4g}").replace("e+", "e")


def prose(kind: type) -> str:
    """What a table is, as the schema says."""
    return inspect.getdoc(kind) or ""


def first_line(kind: type) -> str:
    """Its first sentence."""
    return prose(kind).split("\n", 1)[0]
