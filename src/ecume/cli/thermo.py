"""The table of numbers that `--thermo` prints during a run."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer
import typer.core

if TYPE_CHECKING:
    from ecume.trajectories.frame import Frame
from ecume.cli.options import option
from ecume.cli.output import echo

LEAST_WIDTH = 12
"""The least width of a column in characters: six digits with sign, point and exponent."""
LEAD = {"step": "", "time": "s"}
"""The first columns, and their units."""
Thermo = Annotated[bool, typer.Option("--thermo", help="Print a table of numbers with one line per frame.")]
Columns = Annotated[
    str | None,
    option(
        "--thermo-columns",
        metavar="NAMES",
        help="Columns of --thermo, separated by commas; default: the main numbers of the model.",
    ),
]
ThermoEvery = Annotated[
    int | None, option("--thermo-every", metavar="N", min=1, help="Frames per line of --thermo; default: 1.")
]


class ThermoTable:
    """A table that prints the chosen numbers of every N-th frame, with a heading at the first."""

    def __init__(self, names: Sequence[str], every: int) -> None:
        """`names` are the columns; default: the main numbers of the model."""
        self.names, self._every = tuple(names), every
        self._widths: list[int] = []
        self._columns: list[str] = []
        self._frames = 0

    def __call__(self, model: str, frame: Frame, step: int) -> None:
        """Print the line of a frame if it is due."""
        due, self._frames = self._frames % self._every == 0, self._frames + 1
        if not self._columns:
            self._columns = list(self.names) or main_numbers(model, frame)
            units = {**LEAD, **{name: frame.units.get(name, "1") for name in self._columns}}
            self._widths = [max(LEAST_WIDTH, len(name), len(unit)) for name, unit in units.items()]
            self._print(list(units))
            self._print(["" if unit == "1" else unit for unit in units.values()])
        if due:
            numbers = [frame.numbers.get(name) for name in self._columns]
            cells = ["-" if number is None else f"{number:.6g}" for number in numbers]
            self._print([str(step), f"{frame.time:.6g}", *cells])

    def _print(self, cells: Sequence[str]) -> None:
        """Print a line, above the progress bar if that is on the same terminal."""
        row = " ".join(f"{cell:>{width}}" for cell, width in zip(cells, self._widths, strict=True))
        echo(row.rstrip())
        sys.stdout.flush()


def thermo_table(enabled: bool, columns: str | None, every: int | None) -> ThermoTable | None:
    """The table for the given options; None if no option requires it."""
    if not enabled and columns is None and every is None:
        return None
    names = [name.strip() for name in (columns or "").split(",") if name.strip()]
    return ThermoTable(names, every or 1)


def main_numbers(model: str, frame: Frame) -> list[str]:
    """The main numbers of a model that a frame has."""
    from ecume.models import MODELS

    return [name for name in MODELS[model].main_numbers if name in frame.numbers]
