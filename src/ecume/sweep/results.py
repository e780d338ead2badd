"""The table of a sweep: what varies, and what was measured; measures are kept beside each run."""

from __future__ import annotations

import csv
import inspect
import io
import json
import math
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ecume.errors import BadInput
from ecume.run.lawbook import entries
from ecume.sweep.directory import Job, Sweeping, existing_sweep
from ecume.sweep.measures import Measure, measure_of, usual_measures
from ecume.sweep.points import named
from ecume.trajectories.durable import storing, write_whole
from ecume.trajectories.reader import open_trajectory

CACHE = "measures.json"
TABLE = "table.csv"
Row = dict[str, Any]


def open_sweep(directory: str | os.PathLike[str]) -> Sweep:
    """A sweep that was begun, whether or not it is done."""
    return Sweep(existing_sweep(Path(directory)))


class Sweep:
    """The points of a sweep, and what can be measured in them."""

    def __init__(self, sweeping: Sweeping) -> None:
        self._sweeping = sweeping
        self.directory = sweeping.path
        self.title = sweeping.spec.title

    @property
    def axes(self) -> list[str]:
        """The columns of what varies."""
        columns = [named(self._sweeping.spec, key) for key in self._sweeping.keys]
        return [*columns, *(["repeat"] if self._sweeping.spec.repeats > 1 else [])]

    @property
    def runs(self) -> list[Path]:
        """The directory of each point's run, in the order of the table."""
        return [job.run for job in self._sweeping.jobs]

    def states(self) -> list[str]:
        """`done`, `failed` or `missing`, of each point."""
        return [job.state for job in self._sweeping.jobs]

    def table(self, measures: Mapping[str, str | Measure] | None = None) -> list[Row]:
        """A row a point: what varies, its state, and measures of what is done, NaN elsewhere.

        `measures` are texts such as `final kinetic_energy`, or functions of a trajectory, by the name of their column;
        left out, those that the sweep's file names. `polars.DataFrame(sweep.table())` and pandas take it as it is.
        """
        asked = measures if measures is not None else self._asked()
        rows = [self._row(job, asked) for job in self._sweeping.jobs]
        columns = list(dict.fromkeys(name for row in rows for name in row))
        return [{name: row.get(name, math.nan) for name in columns} for row in rows]

    def _asked(self) -> dict[str, str | Measure] | None:
        named_ones = self._sweeping.spec.measures
        for text in named_ones:
            measure_of(text)
        return {text: text for text in named_ones} or None

    def _row(self, job: Job, measures: Mapping[str, str | Measure] | None) -> Row:
        spec = self._sweeping.spec
        row: Row = {named(spec, key): job.values.get(key) for key in self._sweeping.keys}
        if spec.repeats > 1:
            row["repeat"] = job.point.repeat
        row["state"] = job.state
        if job.state != "done":
            return row
        if spec.process:
            told: Row = json.loads(job.told.read_bytes())
            return row | told
        return row | measured(job, measures)


def measured(job: Job, measures: Mapping[str, str | Measure] | None) -> Row:
    """What is measured in a run that is done, from its cache as far as it is there."""
    cache = _cached(job)
    if measures is None:
        with open_trajectory(job.run) as run:
            measures = {text: text for text in usual_measures(list(run[0].numbers))}
    texts = {name: _digest(measure) for name, measure in measures.items()}
    missing = {name: measure for name, measure in measures.items() if texts[name] not in cache}
    if missing:
        with open_trajectory(job.run) as run:
            for name, measure in missing.items():
                call: Callable[[Any], float] = measure_of(measure) if isinstance(measure, str) else measure
                cache[texts[name]] = float(call(run))
        write_whole(job.folder / CACHE, json.dumps(cache).encode())
    return {name: cache[texts[name]] for name in measures}


def _cached(job: Job) -> dict[str, float]:
    path = job.folder / CACHE
    if not path.is_file():
        return {}
    try:
        found = json.loads(path.read_bytes())
    except ValueError:
        return {}
    return found if isinstance(found, dict) else {}


def _digest(measure: str | Measure) -> str:
    """What a measure is known by: its words, or the text of the function and of what it uses."""
    if isinstance(measure, str):
        return measure
    if not inspect.isfunction(measure):
        raise BadInput(f"a measure is a text or a plain function of a trajectory; came {measure!r}")
    (entry,) = entries([measure])
    return f"{entry['name']} {entry['sha256']}"


def write_table(sweeping: Sweeping) -> Path:
    """The table as CSV, beside the points."""
    path = sweeping.path / TABLE
    rows = Sweep(sweeping).table()
    with storing(path):
        write_whole(path, as_csv(rows))
    return path


def as_csv(rows: Sequence[Row]) -> str:
    """Rows as text; numbers to the last digit."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]) if rows else [], lineterminator="\n")
    writer.writeheader()
    writer.writerows(
        {name: repr(value) if isinstance(value, float) else value for name, value in row.items()} for row in rows
    )
    return text.getvalue()
