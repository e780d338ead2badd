"""Tables of alternatives; compiled code selects a row by the type of its constants."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypeVar

Row = TypeVar("Row", bound=Any)


def by_constants(rows: Iterable[Row], chosen: frozenset[str]) -> dict[type, Row]:
    """The rows by the type of their constants, the field `constants`. Rows may have the same type if they differ only
    in the fields `chosen`, which are read from the row that a scene chooses. Raises TypeError if they differ in other
    fields, since a scene with one row would then run the functions of the other.
    """
    found: dict[type, Row] = {}
    for row in rows:
        first = found.setdefault(row.constants, row)
        names = getattr(row, "_fields", None) or row.__dataclass_fields__
        differing = [name for name in names if name not in chosen and getattr(first, name) != getattr(row, name)]
        if differing:
            raise TypeError(
                f"{_described(first)} and {_described(row)} both have constants of the type {row.constants.__name__}, "
                f"but differ in {', '.join(differing)}; expected a separate type of constants for each"
            )
    return found


def _described(row: Any) -> str:
    """A row in messages: its name, or that of its first function."""
    return str(getattr(row, "name", None) or f"the row of {getattr(row, 'force', row)!r}")
