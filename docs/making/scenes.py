"""The reference of scenes, from the schema: every table, every key with its unit, default, range and meaning."""

from __future__ import annotations

import dataclasses
import inspect
import math
import re
import types
import typing
from collections.abc import Iterator
from typing import Any, NamedTuple

import writing
from writing import cell, docstrings, toctree

from ecume.scenes.floating.sources import SOURCES
from ecume.scenes.schema import SCENES
from ecume.scenes.templates import templates

INTRODUCTION = """
Plain numbers are in SI units; text carries its unit, as in `"2 mm"` or `"70 deg"`. What is not asked for has the
default in the table; *needed* means that there is none. `ecume check SCENE` tells all faults of a scene at once, with
their lines, and what follows from it.

The [scene vocabulary](../../vocabulary.md) compares the keys of the four models.

Any key can be changed on the command line: `ecume run bowl.toml --set "liquid.viscosity=5 mPa*s"`.
"""


class Table(NamedTuple):
    """A table of a scene's file."""

    path: str
    """as its heading stands in the file: `[liquid]`, `[[particles]]`; nothing for the top"""
    kind: type


def pages() -> dict[str, str]:
    """A page for each model, and one that leads to them."""
    rows = [f"| [`{model}`]({model}.md) | {first_line(kind)} |" for model, kind in SCENES.items()]
    index = ["# Scenes, key by key", INTRODUCTION, "| model | its scene |", "|---|---|", *rows, "", toctree(SCENES)]
    found = {f"reference/scenes/{model}.md": page(model) for model in SCENES}
    return {"reference/scenes/index.md": "\n".join(index), **found}


def page(model: str) -> str:
    """All tables of a model's scenes."""
    parts = [f"# The model `{model}`\n\n{prose(SCENES[model])}\n"]
    for table in tables(SCENES[model]):
        title, says = (f"## `{table.path}`", prose(table.kind)) if table.path else ("## The scene itself", "")
        rows = [row(field) for field in fields_of(table.kind)]
        parts.append(
            "\n".join(
                [
                    title,
                    "",
                    says,
                    "",
                    "| key | unit | default | allowed | meaning |",
                    "|---|---|---|---|---|",
                    *rows,
                    "",
                ]
            )
        )
    starts = [f"`{source}`" for source in SOURCES] if model == "floating" else []
    if starts:
        parts.append(f"A file may say {', '.join(starts)} as well: reading turns it into floats one by one.\n")
    own = [f"- `ecume new {name}`: {says}" for name, says in templates().items() if model_of(name) == model]
    return "\n".join([*parts, "## Templates\n", *own, ""])


def model_of(template: str) -> str:
    """Which model a template is a scene of."""
    import tomllib
    from importlib.resources import files

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


def row(field: Field) -> str:
    """A key as a row."""
    unit = unit_of(field.hint)
    usual = (
        f"{math.degrees(field.default):.4g} deg"
        if unit == "rad" and isinstance(field.default, float)
        else written(field.default)
    )
    cells = (f"`{field.name}`", unit or "–", usual, allowed(field.hint), field.says)
    return f"| {' | '.join(map(cell, cells))} |"


def unit_of(hint: Any) -> str:
    """The SI unit of a key, or of the numbers in it."""
    found = unit_read_by(hint) or writing.unit_of(hint)
    return "" if found == "1" else found


def unit_read_by(hint: Any) -> str:
    """The unit of what a reader makes a value of, wherever in the annotation it stands."""
    readers = [getattr(extra, "func", None) for extra in getattr(hint, "__metadata__", ())]
    symbols = [unit_read(reader) for reader in readers if reader is not None]
    return next((found for found in [*symbols, *map(unit_read_by, typing.get_args(hint))] if found), "")


def unit_read(read: Any) -> str:
    """The unit of a function that reads quantities: a vector's is in its closure, an angle's its name says."""
    names = inspect.getclosurevars(read).nonlocals if isinstance(read, types.FunctionType) else {}
    if isinstance(names.get("symbol"), str):
        return str(names["symbol"])
    return next(
        (unit for word, unit in (("angle", "rad"), ("temperature", "K")) if word in getattr(read, "__name__", "")), ""
    )


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
