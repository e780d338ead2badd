"""Codes of laws: the numbers by which compiled code chooses a row of a table."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

LawRow = TypeVar("LawRow")


def code_of(table: Mapping[str, object], name: str) -> int:
    """The code of a row. Raises ValueError for a name that is not in the table.

    >>> code_of({"none": None, "coulomb": None}, "coulomb")
    1
    """
    return list(table).index(name)


def codes(table: Mapping[str, LawRow], part: Callable[[LawRow], Callable[..., Any]]) -> dict[int, Callable[..., Any]]:
    """A function of each row, by the code of the row, for `ecume._jit.selection`."""
    return {code: part(row) for code, row in enumerate(table.values())}
