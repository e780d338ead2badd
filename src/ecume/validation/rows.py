"""The rows of a comparison: one for each number, and the ways to judge it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple


class Row(NamedTuple):
    """One number beside what it should be."""

    name: str
    computed: float
    expected: float
    """for a bound: the bound"""
    tolerance: float
    """absolute; for a bound: zero"""
    kind: str
    """a key of `KINDS`"""

    @property
    def met(self) -> bool:
        """Whether the computed number is as expected; what is no number never is."""
        return bool(KINDS[self.kind](self))


KINDS: dict[str, Callable[[Row], bool]] = {
    "within": lambda row: abs(row.computed - row.expected) <= row.tolerance,
    "below": lambda row: row.computed < row.expected,
    "above": lambda row: row.computed > row.expected,
}


def within(name: str, computed: float, expected: float, tolerance: float) -> Row:
    """A row that wants a number, give or take an absolute tolerance."""
    return Row(name, computed, expected, tolerance, "within")


def below(name: str, computed: float, bound: float) -> Row:
    """A row that wants less than a bound."""
    return Row(name, computed, bound, 0.0, "below")


def above(name: str, computed: float, bound: float) -> Row:
    """A row that wants more than a bound."""
    return Row(name, computed, bound, 0.0, "above")


def as_text(row: Row) -> tuple[str, str, str, str]:
    """Name, computed, expected, tolerance, with as many digits as the tolerance needs to be seen."""
    if row.kind == "within":
        digits = _digits(row)
        return row.name, f"{row.computed:.{digits}g}", f"{row.expected:.{digits}g}", f"{row.tolerance:.2g}"
    sign = {"below": "<", "above": ">"}[row.kind]
    return row.name, f"{row.computed:.4g}", f"{sign} {row.expected:g}", "bound"


def _digits(row: Row) -> int:
    if not row.tolerance or not row.expected:
        return 6
    return min(max(math.ceil(math.log10(abs(row.expected) / row.tolerance)) + 2, 4), 15)
