"""The reference of the Python API: every public function and class with its units and its docstring."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import pkgutil
import re
import types
import typing
from collections.abc import Iterator
from typing import Any, NamedTuple

from titles import title_of
from writing import cell, docstrings, plain, toctree, unit_of


class Chapter(NamedTuple):
    """A page, or one for each module of a package."""

    title: str
    says: str
    roots: tuple[str, ...]


CHAPTERS = {
    "scenes": Chapter("Scenes, runs, trajectories", "Scene files, simulations, run directories and stored frames.", (
        "ecume.scenes.load", "ecume.scenes.schema", "ecume.simulation", "ecume.run", "ecume.trajectories.frame",
        "ecume.trajectories.reader", "ecume.trajectories.exports", "ecume.sweep", "ecume.fitting", "ecume.citing",
        "ecume.errors", "ecume.units",
    )),
    "laws": Chapter("Laws", "The formulas of the physics with their references.", ("ecume.laws",)),
    "analysis": Chapter("Analysis", "Quantities computed from frames.", ("ecume.analysis",)),
    "walls": Chapter("Walls", "Reflecting walls and event-driven motion.", ("ecume.engine.walls",)),
    "models": Chapter("Models", "The interface of models, and the functions of the soft model.", (
        "ecume.models.model", "ecume.models.soft",
    )),
    "show": Chapter("Pictures", "Figures, movies and the interactive page.", (
        "ecume.show.figures", "ecume.show.movies", "ecume.show.view.page", "ecume.show.style",
    )),
}  # fmt: skip


def pages() -> dict[str, str]:
    """A page for each module, one for each chapter that leads to them, and one that leads to those."""
    found: dict[str, str] = {}
    for name, chapter in CHAPTERS.items():
        modules = {module.__name__: module for root in chapter.roots for module in modules_of(root)}
        texts = {module: text for module in modules if (text := page(modules[module]))}
        listed = [f"- [{title_of(modules[one])}]({one}.md) (`{one}`): {first_line(modules[one])}" for one in texts]
        text = "\n".join([f"# {chapter.title}", "", chapter.says, "", *listed, "", toctree(texts)])
        found |= {f"reference/python/{module}.md": text for module, text in {**texts, name: text}.items()}
    rows = [f"- [{chapter.title}]({name}.md): {chapter.says}" for name, chapter in CHAPTERS.items()]
    index = "\n".join(["# Python reference", INTRODUCTION, *rows, "", toctree(CHAPTERS)])
    return {"reference/python/index.md": index, **found}


INTRODUCTION = """
`import ecume` provides the most common names: `load_scene`, `simulate`, `open_trajectory`, `open_sweep`, `resume`, the
parts of scenes, and the errors. Import everything else from its module. Arguments are in SI units; each entry lists
the units of its arguments. A positive force is repulsive.
"""


def modules_of(root: str) -> Iterator[types.ModuleType]:
    """A module, and those below it if it is a package."""
    module = importlib.import_module(root)
    yield module
    for below in pkgutil.walk_packages(getattr(module, "__path__", []), f"{root}."):
        if not any(part.startswith("_") for part in below.name.split(".")):
            yield importlib.import_module(below.name)


def page(module: types.ModuleType) -> str:
    """A module's public names; nothing where it has none of its own."""
    names = [name for name, value in vars(module).items() if own(module, name, value)]
    if not names:
        return ""
    parts = [f"# {title_of(module)}\n", f"Module `{module.__name__}`\n", text_of(module), ""]
    for name in names:
        parts += [entry(name, vars(module)[name]), ""]
    return "\n".join(parts)


def own(module: types.ModuleType, name: str, value: Any) -> bool:
    """Whether a name is public and stands in this module."""
    here = getattr(value, "__module__", "") == module.__name__ and hasattr(value, "__name__")
    return here and not name.startswith("_") and callable(value) and bool(inspect.getdoc(value))


def entry(name: str, value: Any) -> str:
    """One name."""
    parts = [f"## {name}\n"]
    if inspect.isclass(value):
        parts += [text_of(value), "", *members(value)]
    else:
        parts += ["```text", signature(name, value), "```", *units(value), "", text_of(value)]
    return "\n".join(parts)


def members(kind: type) -> list[str]:
    """The fields of a record, and the methods of a class."""
    hints = hints_of(kind)
    says = docstrings(kind)
    rows = [
        f"| `{name}` | {unit_of(hints.get(name)) or '–'} | {cell(plain(says.get(name, '')))} |"
        for name in fields_of(kind)
        if not name.startswith("_")
    ]
    table = ["| field | unit | |", "|---|---|---|", *rows, ""] if rows else []
    methods = []
    for name, value in vars(kind).items():
        called = value.fget if isinstance(value, property) else value
        if not name.startswith("_") and inspect.isfunction(called) and inspect.getdoc(called):
            output = name if isinstance(value, property) else signature(name, called)
            methods += [f"`{output}`", f": {first_paragraph(called)}", ""]
    return [*table, *methods]


def fields_of(kind: Any) -> tuple[str, ...]:
    """The names of a record's fields; a plain class has none."""
    if dataclasses.is_dataclass(kind):
        return tuple(field.name for field in dataclasses.fields(kind))
    return tuple(getattr(kind, "_fields", ()))


def signature(name: str, value: Any) -> str:
    """How it is called, without the units: those stand in a table."""
    try:
        asked = inspect.signature(inspect.unwrap(getattr(value, "py_func", value)))
    except (TypeError, ValueError):
        return name
    arguments = [one for one in asked.parameters.values() if one.name != "self"]
    output, starred = [], False
    for one in arguments:
        if one.kind is one.KEYWORD_ONLY and not starred:
            output.append("*")
            starred = True
        shown = f"{'*' if one.kind is one.VAR_POSITIONAL else ''}{one.name}"
        output.append(shown if one.default is one.empty else f"{shown}={brief(one.default)}")
        starred = starred or one.kind is one.VAR_POSITIONAL
    return f"{name}({', '.join(output)})"


def brief(value: object) -> str:
    """A default, if it is short."""
    text = repr(value)
    return text if len(text) < 40 and " at 0x" not in text else "..."


def units(value: Any) -> list[str]:
    """The units of arguments that have some, and of what comes back."""
    hints = hints_of(inspect.unwrap(getattr(value, "py_func", value)))
    output = [
        f"{'*returns*' if name == 'return' else f'`{name}`'} {unit}"
        for name, hint in hints.items()
        if (unit := unit_of(hint))
    ]
    return ["", "Units: " + ", ".join(output) + "."] if output else []


def hints_of(value: Any) -> dict[str, Any]:
    """The annotations, as far as they can be read."""
    try:
        return typing.get_type_hints(value, include_extras=True)
    except (NameError, TypeError):  # names that only type checkers import
        return {}


def text_of(value: Any) -> str:
    """A docstring as Markdown: formulas stay as they were typed, examples are code."""
    blocks = re.split(r"\n\s*\n", inspect.getdoc(value) or "")
    return "\n\n".join(map(block_of, blocks))


def block_of(block: str) -> str:
    """A paragraph."""
    if block.lstrip().startswith(">>>"):
        return f"```pycon\n{inspect.cleandoc(block)}\n```"
    if block.startswith("    ") or "\n    " in block:
        head, *rest = re.split(r"\n(?=    )", block, maxsplit=1) if not block.startswith("    ") else ["", block]
        code = inspect.cleandoc("\n" + rest[0])
        return f"{plain(head)}\n\n```text\n{code}\n```" if head else f"```text\n{code}\n```"
    return plain(block)


def first_paragraph(value: Any) -> str:
    """The first paragraph of a docstring, in one line."""
    return " ".join(plain((inspect.getdoc(value) or "").split("\n\n")[0]).split())


def first_line(value: Any) -> str:
    """The first line of a docstring."""
    return plain((inspect.getdoc(value) or "").split("\n", 1)[0])
