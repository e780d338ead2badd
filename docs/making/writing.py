"""Shared by the makers of pages: escaped text, lists of pages, units."""

from __future__ import annotations

import ast
import inspect
import itertools
import re
import textwrap
import typing
from collections.abc import Iterable
from functools import cache
from typing import Any

from ecume.scenes.quantities import Measured
from ecume.units import Unit

SIGN = re.compile(r"([*_<>\[\]$~|])")
ALREADY = re.compile(r"(`[^`]*`|\[[^\[\]]*\b[a-z]+\d{4}[a-z]?\b[^\[\]]*\])")
"""Code between backticks, and papers between brackets."""


def plain(text: str) -> str:
    """Text in which signs mean themselves, but for code and papers."""
    pieces = ALREADY.split(text)
    return "".join(piece if number % 2 else SIGN.sub(r"\\\1", piece) for number, piece in enumerate(pieces))


def toctree(names: Iterable[str], *, hidden: bool = True) -> str:
    """The pages below a page; hidden ones stand in the margin only."""
    return "\n".join(["```{toctree}", *([":hidden:"] if hidden else []), "", *names, "```", ""])


def unit_of(hint: Any) -> str:
    """The unit somewhere inside an annotation; plain numbers have 1, what is no number has none."""
    symbols = [extra.symbol for extra in getattr(hint, "__metadata__", ()) if isinstance(extra, (Measured, Unit))]
    return next((found for found in [*symbols, *map(unit_of, typing.get_args(hint))] if found), "")


@cache
def docstrings(kind: type) -> dict[str, str]:
    """What stands below each field of a record, its own and what it inherits from records of ours."""
    found: dict[str, str] = {}
    for each in reversed([one for one in kind.__mro__ if one.__module__.startswith("ecume.")]):
        (body,) = ast.parse(textwrap.dedent(inspect.getsource(each))).body
        lines = body.body if isinstance(body, ast.ClassDef) else []
        for key, text in itertools.pairwise(lines):
            if isinstance(key, ast.AnnAssign) and isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant):
                found[str(getattr(key.target, "id", ""))] = inspect.cleandoc(str(text.value.value))
    return found


def cell(text: str) -> str:
    """Text for a table's cell."""
    return text.replace("|", "\\|").replace("\n", " ")
