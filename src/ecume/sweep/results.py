"""The runner of a sweep, and the table of its measures.

All missing points are computed, one after the other or by many workers.
"""

from __future__ import annotations

import contextlib
import functools
import inspect
import io
import math
import os
import re
import signal
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, NamedTuple

from ecume.errors import BadInput, Stopped, StorageError
from ecume.run.lock import handled
from ecume.run.user_code import entries, laws_from
from ecume.scenes.faults import read_path, suggestion
from ecume.scenes.schema import from_plain, unit_of
from ecume.sweep.directory import (
    Job,
    Sweeping,
    distinct,
    existing_sweep,
    json_at,
    open_or_create,
    require_own_run,
    written,
)
from ecume.sweep.executors import ExecutorOptions, engine_of, executor
from ecume.sweep.measures import Measure, measure_of, read_measure, usual_measures
from ecume.sweep.spec import SIZE, Axis, process_of
from ecume.trajectories.reader import open_trajectory
from ecume.trajectories.records import storing, write_whole
from ecume.trajectories.tables import library, write_rows

if TYPE_CHECKING:
    from pandas import DataFrame as PandasFrame
    from polars import DataFrame as PolarsFrame

CACHE = "measures.json"
UNCOVERED = "? "
"""The prefix of the digest of a function that uses objects without a digest."""
TABLE = "table.csv"
Row = dict[str, Any]


def open_sweep(directory: str | os.PathLike[str]) -> Sweep:
    """The sweep in a directory, complete or not."""
    return Sweep(existing_sweep(Path(directory)))


class Sweep:
    """The points of a sweep and their measures."""

    def __init__(self, sweeping: Sweeping) -> None:
        self._sweeping = sweeping
        self.directory = sweeping.path
        self.title = sweeping.spec.title

    def __repr__(self) -> str:
        states = self.states()
        return f"<sweep {self.directory}: {states.count('done')} of {len(states)} points done>"

    @property
    def axes(self) -> list[str]:
        """The columns of the varied keys."""
        columns = [self._sweeping.spec.named(key) for key in self._sweeping.keys]
        return [*columns, *(["repeat"] if self._sweeping.spec.repeats > 1 else [])]

    @property
    def ways(self) -> list[str]:
        """The columns that vary independently; for linked keys, one that represents all."""
        spec = self._sweeping.spec
        axes = [key for axis in spec.axes for key in representing(axis)]
        sampled = [axis.key for axis in spec.sampling.axes] if spec.sampling is not None else []
        return [spec.named(key) for key in [*axes, *sampled, *([SIZE] if spec.sizes else [])]]

    @property
    def drawn(self) -> bool:
        """Whether several parameters were sampled, so that few points have a value in common."""
        sampling = self._sweeping.spec.sampling
        return sampling is not None and len(sampling.axes) > 1

    def units(self, columns: Sequence[str]) -> dict[str, str]:
        """The units of these columns, as far as they have one."""
        spec = self._sweeping.spec
        if spec.process:
            known = process_of(spec.process).units
        else:
            known = units_of_keys(self._sweeping) | units_of_measures(self._sweeping.jobs, columns)
        return {column: known[column] for column in columns if known.get(column, "1") != "1"}

    @property
    def written_units(self) -> dict[str, str]:
        """The units of the varied keys in the sweep file, for keys with a single unit."""
        spec = self._sweeping.spec
        values: dict[str, Sequence[object]] = {axis.key: axis.values for axis in spec.axes if axis.key is not None}
        for axis in spec.axes:
            values |= dict(zip(axis.keys, zip(*axis.rows, strict=True), strict=True))
        sampled = spec.sampling.axes if spec.sampling is not None else ()
        spans = {axis.key: axis.span.unit for axis in spec.axes if axis.key is not None and axis.span is not None}
        spans |= {axis.key: axis.span.unit for axis in sampled}
        found = {key: {_unit_in(value) for value in given} for key, given in values.items() if given}
        units = spans | {key: next(iter(each)) for key, each in found.items() if len(each) == 1}
        return {spec.named(key): unit for key, unit in units.items() if unit}

    @property
    def runs(self) -> list[Path]:
        """The run directory of each point, in the order of the table."""
        return [job.run for job in self._sweeping.jobs]

    def states(self) -> list[str]:
        """The state of each point: `done`, `failed` or `missing`."""
        return [job.state for job in self._sweeping.jobs]

    def table(self, measures: Mapping[str, str | Measure] | None = None) -> list[Row]:
        """One row per point: varied keys, state, and measures of completed runs, otherwise NaN.

        `measures` are texts such as `final kinetic_energy`, or functions of a trajectory, by the name of their column;
        default: those in the sweep's file.
        """
        asked = measures if measures is not None else self._asked()
        rows = [self._row(job, asked) for job in self._sweeping.jobs]
        columns = list(dict.fromkeys(name for row in rows for name in row))
        return [{name: row.get(name, math.nan) for name in columns} for row in rows]

    def polars(self, measures: Mapping[str, str | Measure] | None = None) -> PolarsFrame:
        """The table as a DataFrame of Polars (extra `tables`); missing values are null."""
        rows = self.table(measures)
        return library("polars").DataFrame(_with_nulls(rows), infer_schema_length=None, strict=False)

    def pandas(self, measures: Mapping[str, str | Measure] | None = None) -> PandasFrame:
        """The table as a DataFrame of Pandas, if it is installed; missing values are NaN."""
        return library("pandas").DataFrame(_with_nulls(self.table(measures)))

    def columns(self) -> dict[str, list[Any]]:
        """The table by columns, as in `table.csv`: varied keys in the units of the sweep file, other numbers in SI
        units; the name of each column contains its unit.
        """
        rows, written_ones = self.table(), self.written_units
        units = self.units(list(rows[0]) if rows else []) | written_ones
        keys = {self._sweeping.spec.named(key): key for key in self._sweeping.keys}
        found = {}
        for name in rows[0] if rows else ():
            values = [row.get(name) for row in rows]
            if name in written_ones:
                texts = (str(job.point.settings[keys[name]]) for job in self._sweeping.jobs)
                values = [float(match[1]) if (match := NUMBER_WITH_UNIT.fullmatch(text)) else None for text in texts]
            found[f"{name} ({units[name].replace('$', '')})" if name in units else name] = values
        return found

    def _asked(self) -> dict[str, str | Measure] | None:
        named_ones = self._sweeping.spec.measures
        for text in named_ones:
            measure_of(text)
        return {text: text for text in named_ones} or None

    def _row(self, job: Job, measures: Mapping[str, str | Measure] | None) -> Row:
        spec = self._sweeping.spec
        row: Row = {spec.named(key): job.values.get(key) for key in self._sweeping.keys}
        if spec.repeats > 1:
            row["repeat"] = job.point.repeat
        row["state"] = job.state
        if job.state != "done":
            return row
        if spec.process:
            result: Row = json_at(job.result, dict)
            return row | {name: value for name, value in result.items() if name not in row}
        return row | measured(job, measures)


def _unit_in(value: object) -> str:
    """The unit of a text such as `2 mm`, or nothing."""
    match = NUMBER_WITH_UNIT.fullmatch(value) if isinstance(value, str) else None
    return match[2] if match else ""


NUMBER_WITH_UNIT = re.compile(r"\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)(?:\s*(?=[^0-9.\s/*+(-])|\s+(?=1/))(.*?)\s*")


def representing(axis: Axis) -> Sequence[str]:
    """The key of an axis. For linked keys, the first one whose values are all different, or all of them.

    >>> representing(Axis(keys=("cell.size", "seed"), rows=((1, 1), (1, 2))))
    ('seed',)
    """
    if axis.key is not None:
        return (axis.key,)
    columns = zip(axis.keys, zip(*axis.rows, strict=True), strict=True)
    count = len({repr(row) for row in axis.rows})
    return next(((key,) for key, values in columns if len({repr(value) for value in values}) == count), axis.keys)


def _with_nulls(rows: Sequence[Row]) -> list[Row]:
    """The rows with null for missing values, so that columns of texts and booleans keep their type."""
    return [{name: None if _is_nan(value) else value for name, value in row.items()} for row in rows]


def _is_nan(value: Any) -> bool:
    return isinstance(value, float) and math.isnan(value)


def units_of_keys(sweeping: Sweeping) -> dict[str, str]:
    """The units of the varied keys of a scene, by column."""
    plain = json_at(sweeping.jobs[0].asked, dict)["scene"]
    keys = [key for key in sweeping.keys if key != SIZE]
    return {sweeping.spec.named(key): unit_of(plain, read_path(key)) for key in keys}


def units_of_measures(jobs: Sequence[Job], columns: Sequence[str]) -> dict[str, str]:
    """The units of measures in text form, from the first completed run."""
    done = next((job for job in jobs if job.state == "done"), None)
    if done is None:
        return {}
    with open_trajectory(done.run) as run:
        known = run.units
    found = {}
    for text in columns:
        with contextlib.suppress(ValueError):  # a column that is not a measure in text form
            words = read_measure(text)
            found[text] = "s" if words.way == "first" else known.get(words.number, "1")
    return found


def require_numbers(
    measures: Sequence[str], plan: Mapping[str, Any], laws: Sequence[Callable[..., float]] = ()
) -> None:
    """Raise BadInput if a measure uses a number that runs do not have, or if the engine is not installed.

    This is determined from the first frame of a run before the sweep starts.
    """
    from ecume.simulation import moments

    required = {text: read_measure(text).number for text in measures}
    with engine_of(plan) as engine:
        if not required and not laws:
            return
        begun = moments(from_plain(plan["scene"]), extra_laws=laws, engine=engine)
        numbers = next(moment.frame.numbers for moment in begun if moment.frame is not None)
    for text, name in required.items():
        if name not in numbers:
            raise BadInput(f"measures: {text!r}: no number {name}; {suggestion(name, sorted(numbers))}")


def measured(job: Job, measures: Mapping[str, str | Measure] | None) -> Row:
    """The measures of a completed run, cached if possible."""
    cache = _cached(job)
    if measures is None:
        with open_trajectory(job.run) as run:
            measures = {text: text for text in usual_measures(list(run[0].numbers))}
    texts = {name: _digest(measure) for name, measure in measures.items()}
    missing = {name: measure for name, measure in measures.items() if texts[name] not in cache}
    if missing:
        require_own_run(job)
        with open_trajectory(job.run) as run:
            for name, measure in missing.items():
                call: Callable[[Any], float] = measure_of(measure) if isinstance(measure, str) else measure
                cache[texts[name]] = float(call(run))
        kept = {text: value for text, value in cache.items() if not text.startswith(UNCOVERED)}
        write_whole(job.folder / CACHE, written(kept, job.folder / CACHE), job.folder)
    return {name: cache[texts[name]] for name in measures}


def _cached(job: Job) -> dict[str, float]:
    path = job.folder / CACHE
    if not path.is_file():
        return {}
    try:
        found: dict[str, float] = json_at(path, dict)
    except StorageError:
        return {}
    return {name: value for name, value in found.items() if isinstance(value, float)}


def _digest(measure: str | Measure) -> str:
    """The digest of a measure: of its text, or of the source of a function and of all objects that it uses. Values of
    functions that use objects without a digest are not cached.
    """
    if isinstance(measure, str):
        return measure
    if not inspect.isfunction(measure):
        raise BadInput(f"a measure is a text or a plain function of a trajectory; got {measure!r}")
    (entry,) = entries([measure])
    return f"{UNCOVERED * ('uncovered' in entry)}{entry['name']} {entry['sha256']}"


def write_table(sweeping: Sweeping) -> Path:
    """Write the table as CSV into the directory of the sweep. Returns its path."""
    path = sweeping.path / TABLE
    columns = Sweep(sweeping).columns()
    with storing(path):
        write_whole(path, as_csv(columns), sweeping.path)
    return path


def as_csv(columns: Mapping[str, Sequence[Any]]) -> str:
    """The columns as text, with all digits of numbers."""
    text = io.StringIO()
    write_rows(text, [list(columns), *zip(*columns.values(), strict=True)])
    return text.getvalue()


class Outcome(NamedTuple):
    """The outcome of a sweep."""

    directory: Path
    done: int
    failed: list[tuple[Path, str]]
    """folders and reasons"""
    busy: int
    """points that another process has locked"""
    lost: int = 0
    """points whose worker died in each attempt"""


USUAL = ExecutorOptions()


def sweep(file: str | os.PathLike[str], directory: str | os.PathLike[str], options: ExecutorOptions = USUAL) -> Outcome:
    """Run the missing points of a sweep and write its table.

    Raises Stopped after a signal: the same call continues.
    """
    own = laws_from(options.laws)
    check = functools.partial(require_numbers, laws=own)
    sweeping = open_or_create(Path(file), Path(directory), entries(own), check)
    jobs = distinct(sweeping.jobs)
    missing = [job for job in jobs if job.state != "done"]
    try:
        with handled(_stop):
            words = _worked(options, sweeping, missing)
    except Stopped as stopped:
        done = sum(job.state == "done" for job in jobs)
        why = str(stopped).partition(" at step ")[0].partition(";")[0]
        raise Stopped(f"{why}; {done} of {len(jobs)} points are done; the same command continues") from stopped
    write_table(sweeping)
    return outcome_of(sweeping)._replace(busy=words["busy"], lost=words["lost"])


def _worked(options: ExecutorOptions, sweeping: Sweeping, missing: Sequence[Job]) -> Counter[str]:
    """Run these points and report each. Returns the number of points by outcome."""
    words: Counter[str] = Counter()
    count = len(distinct(sweeping.jobs))
    report = options.progress or (lambda done, of: None)
    with executor(options, sweeping, len(missing)) as results:
        report(count - len(missing), count)
        for job, word in results(missing):
            words[word] += 1
            if word == "failed" and options.failed is not None:
                options.failed(job.folder, job.why)
            report(count - len(missing) + words.total(), count)
    return words


def _stop(number: int, _: FrameType | None) -> None:
    raise Stopped(f"stopped by {signal.Signals(number).name}")


def outcome_of(sweeping: Sweeping) -> Outcome:
    """The outcome that corresponds to the present state of a sweep."""
    jobs = distinct(sweeping.jobs)
    failed = [(job.folder, job.why) for job in jobs if job.state == "failed"]
    return Outcome(sweeping.path, sum(job.state == "done" for job in jobs), failed, 0)
