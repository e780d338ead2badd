"""From a table of laws to compiled code, which knows a row by its code: its place in the table."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

Row = TypeVar("Row")


def code_of(table: Mapping[str, object], name: str) -> int:
    """The code of a row. Raises ValueError for a name without a row.

    >>> code_of({"none": None, "coulomb": None}, "coulomb")
    1
    """
    return list(table).index(name)


def codes(table: Mapping[str, Row], part: Callable[[Row], Callable[..., Any]]) -> dict[int, Callable[..., Any]]:
    """A function of each row by the row's code, for `ecume._jit.selection`."""
    return {code: part(row) for code, row in enumerate(table.values())}
