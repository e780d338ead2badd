"""The schema of a sweep's file, and the points of a sweep: every combination of values, drawn samples, repeats.

`PROCESSES` is the table of built-in processes, which generate scenes and return numbers.
"""

from __future__ import annotations

import inspect
import itertools
import json
import math
import re
import typing
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import AfterValidator, Field, PlainValidator, TypeAdapter, ValidationError, model_validator
from pydantic.dataclasses import dataclass

from ecume.errors import BadInput, Fault, SceneError
from ecume.models.model import LAMMPS, LOCAL
from ecume.run.until import NUMBER, read_condition
from ecume.scenes.faults import Complaints, Inconsistent, echo, faults_of, suggestion
from ecume.scenes.load import parsed, placed, source_in
from ecume.scenes.overrides import KEY
from ecume.scenes.quantities import STRICT, Seed, Switch, Text
from ecume.scenes.templates import templates
from ecume.sweep.measures import read_measure


class Process(NamedTuple):
    """A built-in process: a function, its results, and their units."""

    run: Callable[..., Any]
    """the function from arguments to a result"""
    results: tuple[str, ...]
    """the numbers of the result that a table contains"""
    units: Mapping[str, str]
    """of arguments and results, as far as they have one"""


def _t1() -> Process:
    from ecume.models.soft import t1_process

    results = ("duration", "completed", "outcome", "reduced_force", "steps", "rejected")
    return Process(t1_process, results, {"gap": "R", "duration": "ηR²/F$_N$"})


PROCESSES: Mapping[str, Callable[[], Process]] = {"t1": _t1}
"""Functions that return processes, by name; called at the first use."""


def process_of(name: str) -> Process:
    """The process with this name. Raises BadInput for an unknown name."""
    if name not in PROCESSES:
        raise BadInput(f"process: no such process as {name!r}; {suggestion(name, PROCESSES)}")
    return PROCESSES[name]()


def require_arguments(name: str, keys: list[str]) -> None:
    """Raise BadInput unless all keys are arguments of the process and no required one is missing."""
    known = inspect.signature(process_of(name).run).parameters
    for key in keys:
        if key not in known:
            raise BadInput(f"axes: the process {name} has no argument {key!r}; {suggestion(key, known)}")
    for key, argument in known.items():
        if argument.default is argument.empty and key not in keys:
            raise BadInput(f"axes: the process {name} needs {key}; add it to [[axes]] or [fixed]")


def require_settings(name: str, settings: Mapping[str, Any]) -> None:
    """Raise SceneError for settings whose type differs from that of the argument."""
    kinds = typing.get_type_hints(process_of(name).run)
    faults = [
        Fault(key, f"got {echo(value)}; expected {_kind(kinds[key])}")
        for key, value in settings.items()
        if not _is_a(value, kinds[key])
    ]
    if faults:
        raise SceneError(faults)


def _is_a(value: Any, kind: Any) -> bool:
    """Whether a TOML value has the type of an annotation; lists match tuples."""
    try:
        TypeAdapter(kind).validate_json(json.dumps(value), strict=True)
    except ValidationError:
        return False
    return True


WORDS = {float: "a number", str: "text", bool: "true or false"}


def _kind(annotation: Any) -> str:
    """An annotation as a phrase."""
    parts = [part for part in typing.get_args(annotation) or (annotation,) if part is not type(None)]
    return " or ".join(WORDS.get(part, "a list of numbers") for part in parts)


def results_of(name: str, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Run a process and return its result."""
    process = process_of(name)
    arguments = {key: tuple(value) if isinstance(value, list) else value for key, value in settings.items()}
    result = process.run(**arguments)
    return {key: getattr(result, key) for key in process.results}


MOST_POINTS = 1_000_000
SIZE = "size_factor"
"""The column of the factors in `sizes`."""
OWN_COLUMNS = ("state", "repeat")
"""Columns that every table has."""
LONGEST = 100
"""The largest length of a quantity in characters."""
QUANTITY = re.compile(rf"\s*([+-]?{NUMBER})\s+(\S.*)")


def like(pattern: str, words: str) -> Callable[[str], str]:
    """A validator that accepts texts of this form, and otherwise raises an error with the expected form."""
    form = re.compile(pattern)

    def fitting(text: str) -> str:
        if form.fullmatch(text) is None:
            raise ValueError(f"expected {words}")
        return text

    return fitting


def value(got: object) -> object:
    """A value that is valid for some key of a scene."""
    if not isinstance(got, (bool, int, float, str, list)) or (isinstance(got, float) and not math.isfinite(got)):
        raise ValueError("expected a finite number, text, true or false, or a list")
    return got


def measure(text: str) -> str:
    """Validate the text of a measure."""
    read_measure(text)
    return text


def condition(text: str) -> str:
    """Validate the text of a condition."""
    if text:
        try:
            read_condition(text)
        except BadInput as fault:
            raise ValueError(str(fault).rpartition("; ")[2]) from None
    return text


Key = Annotated[str, Field(max_length=600), AfterValidator(like(KEY.pattern, "a key such as liquid.viscosity"))]
Value = Annotated[Any, PlainValidator(value)]
Whole = Annotated[int, Field(strict=True, ge=1, le=MOST_POINTS)]
Finite = Annotated[float, Field(ge=-1e300, le=1e300)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Span:
    """A range of numbers: `start = "1 mm"` and `stop = "9 mm"`, or with a separate unit, `unit = "mm"`."""

    start: Finite
    stop: Finite
    count: Annotated[int, Field(strict=True, ge=2, le=MOST_POINTS)] = 2
    """the number of values, including both ends"""
    log: Switch = False
    """whether ratios between neighbors are equal, instead of differences"""
    whole: Switch = False
    """whether numbers are rounded to integers, as for numbers of particles"""
    unit: Annotated[str, Field(max_length=40)] = ""

    @model_validator(mode="before")
    @classmethod
    def _with_units(cls, raw: Any) -> Any:
        """Move the unit of both ends into `unit`."""
        ends = ("start", "stop")
        found = {end: QUANTITY.fullmatch(raw[end][:LONGEST]) for end in ends if isinstance(_of(raw, end), str)}
        if not found:
            return raw
        units = {match[2].strip() if match else "" for match in found.values()}
        if len(found) < 2 or len(units) > 1 or "" in units or "unit" in raw:
            raise Inconsistent([((), 'expected two numbers, or two with one unit: start = "1 mm", stop = "9 mm"')])
        return raw | {end: float(match[1]) for end, match in found.items() if match} | {"unit": units.pop()}

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.log and not (self.start > 0.0 and self.stop > 0.0):
            raise Inconsistent(
                [(("log",), f"from {self.start:g} to {self.stop:g}: ratios are of positive numbers only")]
            )
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Axis:
    """One varied quantity: a key of the scene, or several linked keys."""

    key: Key | None = None
    """such as `liquid.viscosity` or `particles[0].radius`"""
    values: Annotated[tuple[Value, ...], Field(max_length=MOST_POINTS)] = ()
    """the values, in order"""
    span: Span | None = None
    """or evenly spaced values"""
    keys: tuple[Key, ...] = ()
    """several linked keys, whose values are in `rows`"""
    rows: Annotated[tuple[tuple[Value, ...], ...], Field(max_length=MOST_POINTS)] = ()
    """a value for each of the keys"""
    name: Text = ""
    """the name of the axis in tables; default: its key"""

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        found: Complaints = []
        if (self.key is None) == (not self.keys):
            found.append(((), "expected key, or keys with rows"))
        elif self.key is not None and bool(self.values) == (self.span is not None):
            found.append(((), "expected values, or a span"))
        elif self.keys and not self.rows:
            found.append((("rows",), "is missing; keys want a row of values for each point"))
        found += [
            (("rows", place), f"got {len(row)} values; expected {len(self.keys)}, one for each of the keys")
            for place, row in enumerate(self.rows)
            if self.keys and len(row) != len(self.keys)
        ]
        if found:
            raise Inconsistent(found)
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SampledAxis:
    """One key with random values in an interval."""

    key: Key
    span: Span
    """`count` is ignored"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Sampling:
    """Points drawn at random instead of on a grid."""

    method: Literal["random", "latin-hypercube"] = "latin-hypercube"
    """independent random points, or points of which each of `count` slices of every axis contains one"""
    count: Whole
    seed: Seed = 0
    axes: Annotated[tuple[SampledAxis, ...], Field(min_length=1)]


REQUESTS = (
    "account|begin|clusters|comment|constraint|core-spec|cores-per-socket|cpu-freq|cpus-per-gpu|deadline|dependency|"
    "exclude|exclusive|gpu-bind|gpu-freq|gpus|gpus-per-node|gpus-per-socket|gpus-per-task|gres|gres-flags|hint|job-name|"
    "licenses|mail-type|mail-user|mem-per-cpu|mem-per-gpu|mincpus|nice|nodelist|nodes|ntasks|ntasks-per-node|"
    "oversubscribe|priority|qos|reservation|sockets-per-node|spread-job|switches|threads-per-core|time-min|tmp|wckey"
)
"""Options of sbatch that request resources. Since a sweep may come from anyone, options that name files and programs,
such as `--output` and `--prolog`, are accepted only on the command line of sbatch.
"""
Request = Annotated[
    Text,
    AfterValidator(
        like(
            rf"--({REQUESTS})(=[\w.,:@/*+&|!()\[\]-]+)?",
            'an option of sbatch for resources, such as "--account=me"; others can be given to sbatch itself',
        )
    ),
]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Cluster:
    """The resources of a job on a cluster, for `--slurm` and `--array`."""

    partition: Annotated[Text, AfterValidator(like(r"[\w.,:-]*", "the name of a partition"))] = ""
    walltime: Annotated[
        str, AfterValidator(like(r"[0-9]{1,4}:[0-5][0-9]:[0-5][0-9]", 'hours:minutes:seconds, such as "01:30:00"'))
    ] = "01:00:00"
    """hours:minutes:seconds"""
    memory: Annotated[str, AfterValidator(like(r"[0-9]{1,6}[KMGT]B?", 'a size such as "2GB"'))] = "2GB"
    """of each job"""
    jobs: Annotated[int, Field(strict=True, ge=1, le=10_000)] = 4
    """the largest number of simultaneous jobs; one core each"""
    lines: tuple[Request, ...] = ()
    """further `#SBATCH` options for resources, such as `--account=me`"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SweepSpec:
    """A sweep: a scene or process, the varied keys, the repetitions, and the measures."""

    title: Text = ""
    scene: Text = ""
    """the scene's file, relative to this one"""
    template: Text = ""
    """or a template of `ecume new`"""
    process: Text = ""
    """or a process that generates its scenes, such as `t1`; the axes are its arguments"""
    fixed: dict[Key, Value] = Field(default_factory=dict)
    """keys of the scene that differ from its file in all points; keys of one table may be in a table"""
    axes: tuple[Axis, ...] = ()
    """each combination of their values is a point"""
    sampling: Sampling | None = None
    """random points; combined with axes, each combination of values has all random points"""
    repeats: Annotated[int, Field(strict=True, ge=1, le=100_000)] = 1
    """of each point, with consecutive seeds from that of the scene on"""
    sizes: Annotated[tuple[Annotated[Whole, Field(le=1000)], ...], Field(max_length=100)] = ()
    """factors of the numbers of particles in a periodic cell, which grows with them: each point at each size, which
    shows how results depend on the size of the cell"""
    measures: tuple[Annotated[Text, AfterValidator(measure)], ...] = ()
    """columns of the table: `final kinetic_energy`, `mean pressure`, `max top`, `first top > 0.3` ...; default: the
    last value of every number"""
    until: Annotated[Text, AfterValidator(condition)] = ""
    """a condition that ends each run before its duration: `stationary shear_stress`, `top > 0.3`; see `ecume run
    --until`"""
    engine: Literal["local", "lammps"] = "local"
    """of all runs: see `ecume run --engine`"""
    ranks: Annotated[int, Field(strict=True, ge=1, le=65536)] = 1
    """MPI ranks of LAMMPS in each run"""
    cluster: Cluster = Cluster()

    @model_validator(mode="before")
    @classmethod
    def _flat(cls, raw: Any) -> Any:
        """Flatten nested tables: TOML reads `liquid.viscosity = 1` as a table in a table."""
        fixed = _of(raw, "fixed")
        return raw | {"fixed": dict(_leaves(fixed))} if isinstance(fixed, dict) else raw

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        found: Complaints = [*self._incomplete(), *self._twice()]
        if found:
            raise Inconsistent(found)
        return self

    def _incomplete(self) -> Iterator[tuple[tuple[str, ...], str]]:
        if sum(map(bool, (self.scene, self.template, self.process))) != 1:
            yield (), "expected one of scene, template and process"
        if not (self.axes or self.sizes) and self.sampling is None and self.repeats == 1:
            yield ("axes",), "is missing; nothing varies"
        if self.process and self.repeats > 1:
            yield ("repeats",), "a process has no seed; its repeats would be equal"
        if self.process and self.sizes:
            yield ("sizes",), f"are of the cell of a scene; the process {self.process} has none"
        if len(set(self.sizes)) < len(self.sizes):
            yield ("sizes",), "contain a factor twice"
        if self.process and self.measures:
            yield ("measures",), f"apply to scenes; the process {self.process} has a fixed list of numbers"
        if self.process and self.until:
            yield ("until",), f"applies to scenes; the process {self.process} ends by itself"
        if self.process and self.engine != LOCAL:
            yield ("engine",), f"the process {self.process} integrates its own scenes; expected {LOCAL}"
        if self.ranks > 1 and self.engine == LOCAL:
            yield ("ranks",), f"expected them with engine = {LAMMPS!r} only"

    def _twice(self) -> Iterator[tuple[tuple[str | int, ...], str]]:
        """The faults of keys or names that are given twice."""
        keys = self.keyed
        times = Counter([*keys.values(), *self.fixed])
        yield from ((place, f"{key} is given twice") for place, key in keys.items() if times[key] > 1)
        if self.repeats > 1 and "seed" in keys.values():
            yield ("repeats",), "repeats have consecutive seeds; they cannot be combined with seeds that vary"
        names = Counter([*OWN_COLUMNS, *self.measures, *(self.named(key) for key in dict.fromkeys(keys.values()))])
        for place, axis in enumerate(self.axes):
            if axis.name and names[axis.name] > 1:
                yield ("axes", place, "name"), f"another column of the table is called {axis.name}"

    @property
    def keyed(self) -> dict[tuple[str | int, ...], str]:
        """The varied keys in the order of the table's columns, by their position in this file."""
        axes = [
            (("axes", place, *end), key)
            for place, axis in enumerate(self.axes)
            for end, key in (
                [(("key",), axis.key)] if axis.key else [(("keys", n), k) for n, k in enumerate(axis.keys)]
            )
        ]
        drawn = enumerate(self.sampling.axes if self.sampling is not None else ())
        axes += [(("sizes",), SIZE)] * bool(self.sizes)
        return dict(axes) | {("sampling", "axes", place, "key"): axis.key for place, axis in drawn}

    def named(self, key: str) -> str:
        """The column name of a key."""
        return next((axis.name for axis in self.axes if axis.key == key and axis.name), key)


def _of(raw: Any, key: str) -> Any:
    return raw.get(key) if isinstance(raw, dict) else None


def _leaves(table: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """The keys of nested tables, in the form `a.b`."""
    for key, item in table.items():
        if isinstance(item, dict) and item:
            yield from _leaves(item, f"{above}{key}.")
        else:
            yield f"{above}{key}", item


READER = TypeAdapter(SweepSpec)


MOST_BYTES = 2**22
Settings = dict[str, Any]
"""Values by key."""


class Asked(NamedTuple):
    """The file of a sweep."""

    spec: SweepSpec
    text: str
    folder: Path
    """the folder to which the scene's path is relative"""
    name: str = "sweep"
    """the name of the file in messages"""
    laws: tuple[dict[str, Any], ...] = ()
    """names and digests of user-defined laws, which act in all points"""


def load_sweep(path: Path) -> Asked:
    """Read a sweep's file. Raises SceneError with all its faults, each with its line and column."""
    source = source_in(path, MOST_BYTES)
    raw = parsed(source)
    if "model" in raw:
        message = "is a scene and no sweep; `ecume run` runs it, `ecume new raft-growth` writes a sweep"
        raise SceneError([Fault("", message)], source.name)
    try:
        spec = READER.validate_python(raw)
    except ValidationError as error:
        raise SceneError(placed(source, faults_of(error, SweepSpec, raw), set()), source.name) from error
    if spec.template and spec.template not in templates():
        fault = f"got {echo(spec.template)}; {suggestion(spec.template, templates())}"
        raise SceneError(placed(source, [(("template",), fault)], set()), source.name)
    return Asked(spec, source.text, source.folder, source.name)


class Point(NamedTuple):
    """One combination of values."""

    settings: Settings
    """differences from the scene's file"""
    repeat: int


def points_of(spec: SweepSpec) -> list[Point]:
    """All points in the order of the table: repeats vary first, then the last axis."""
    grids = [list(settings_of(axis)) for axis in spec.axes]
    if spec.sampling is not None:
        grids.append(list(drawn(spec.sampling)))
    if spec.sizes:
        grids.append([{SIZE: factor} for factor in spec.sizes])
    count = math.prod(len(grid) for grid in grids) * spec.repeats
    if count > MOST_POINTS:
        raise BadInput(f"{count} points are more than {MOST_POINTS}; shorten an axis")
    found = []
    for combination in itertools.product(*grids):
        settings = dict(spec.fixed)
        for part in combination:
            settings |= part
        found += [Point(settings, repeat) for repeat in range(spec.repeats)]
    return found


def varied(spec: SweepSpec) -> list[str]:
    """The varied keys in the order of the table's columns."""
    return list(spec.keyed.values())


def settings_of(axis: Axis) -> Iterator[Settings]:
    """The values of one axis, in order."""
    if axis.key is None:
        for row in axis.rows:
            yield dict(zip(axis.keys, row, strict=True))
    else:
        for value in axis.values or spread(axis.span):
            yield {axis.key: value}


def spread(span: Span | None) -> Sequence[Any]:
    """Evenly spaced numbers, including both ends exactly."""
    if span is None:
        return []
    values = between(span, np.linspace(0.0, 1.0, span.count))
    return [with_unit(float(value), span) for value in values]


def between(span: Span, parts: Any) -> Any:
    """The numbers at these fractions of a range."""
    if not span.log:
        return span.start + parts * (span.stop - span.start)
    values = span.start * (span.stop / span.start) ** parts
    return np.where(parts == 1.0, span.stop, values)


def with_unit(value: float, span: Span) -> Any:
    """A value in the notation of a scene file."""
    short = round(value) if span.whole else float(f"{value:.15g}")  # 0.0001 instead of 9.999999999999999e-05
    return f"{short!r} {span.unit}" if span.unit else short


def drawn(sampling: Sampling) -> Iterator[Settings]:
    """Random points; the same seed gives the same points."""
    from scipy.stats import qmc

    dimension = len(sampling.axes)
    if sampling.method == "random":
        parts = np.random.default_rng(sampling.seed).random((sampling.count, dimension))
    else:
        parts = qmc.LatinHypercube(dimension, rng=np.random.default_rng(sampling.seed)).random(sampling.count)
    columns = [between(axis.span, parts[:, place]) for place, axis in enumerate(sampling.axes)]
    for row in zip(*columns, strict=True):
        yield {axis.key: with_unit(float(value), axis.span) for axis, value in zip(sampling.axes, row, strict=True)}
