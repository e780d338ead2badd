"""What a sweep's file may say."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, TypeAdapter, model_validator
from pydantic.dataclasses import dataclass

from ecume.scenes.faults import Complaints, Inconsistent
from ecume.scenes.overrides import KEY
from ecume.scenes.quantities import STRICT, Seed, Switch, Text

MOST_POINTS = 1_000_000

Key = Annotated[str, Field(max_length=600, pattern=rf"^(?:{KEY.pattern})$")]
Value = int | float | str | bool | list[Any]
Whole = Annotated[int, Field(strict=True, ge=1, le=MOST_POINTS)]
Finite = Annotated[float, Field(ge=-1e300, le=1e300)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Span:
    """From one number to another; the unit, if any, is written behind each: `unit = "mm"`."""

    start: Finite
    stop: Finite
    count: Whole = 2
    """how many, both ends among them"""
    log: Switch = False
    """whether ratios between neighbors are equal, and not differences"""
    unit: Annotated[str, Field(max_length=40)] = ""

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.log and not (self.start > 0.0 and self.stop > 0.0):
            raise Inconsistent(
                [(("log",), f"from {self.start:g} to {self.stop:g}: ratios are of positive numbers only")]
            )
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Axis:
    """One thing that varies: a key of the scene, or several keys that go together."""

    key: Key | None = None
    """such as `liquid.viscosity` or `floats[0].radius`"""
    values: Annotated[tuple[Value, ...], Field(max_length=MOST_POINTS)] = ()
    """one after the other"""
    span: Span | None = None
    """or evenly from one to another"""
    keys: tuple[Key, ...] = ()
    """several keys, whose values stand in `rows`"""
    rows: Annotated[tuple[tuple[Value, ...], ...], Field(max_length=MOST_POINTS)] = ()
    """a value for each of the keys"""
    name: Text = ""
    """what the axis is called in tables; left out, its key"""

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        found: Complaints = []
        if (self.key is None) == (not self.keys):
            found.append(((), "wanted key, or keys with rows"))
        elif self.key is not None and bool(self.values) == (self.span is not None):
            found.append(((), "wanted values, or a span"))
        elif self.keys and not self.rows:
            found.append((("rows",), "is missing; keys want a row of values for each point"))
        found += [
            (("rows", place), f"came {len(row)} values; wanted {len(self.keys)}, one for each of the keys")
            for place, row in enumerate(self.rows)
            if len(row) != len(self.keys)
        ]
        if found:
            raise Inconsistent(found)
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SampledAxis:
    """One key, whose values are drawn between two ends."""

    key: Key
    span: Span
    """`count` means nothing here"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Sampling:
    """Points drawn at random instead of on a grid."""

    method: Literal["random", "latin-hypercube"] = "latin-hypercube"
    """each on its own, or so that each of `count` slices of every axis holds one"""
    count: Whole
    seed: Seed = 0
    axes: Annotated[tuple[SampledAxis, ...], Field(min_length=1)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Cluster:
    """What a job of a cluster may use; for `--slurm` and `--array`."""

    partition: Text = ""
    walltime: Annotated[str, Field(pattern=r"^[0-9]{1,4}:[0-5][0-9]:[0-5][0-9]$")] = "01:00:00"
    """hours:minutes:seconds"""
    memory: Annotated[str, Field(pattern=r"^[0-9]{1,6}[KMGT]B?$")] = "2GB"
    """of each job"""
    jobs: Annotated[int, Field(strict=True, ge=1, le=10_000)] = 4
    """at once, at most; one core each"""
    lines: tuple[Text, ...] = ()
    """further `#SBATCH` options, such as `--account=me`"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SweepSpec:
    """A sweep: a scene or a process, what varies, how often, and what is measured."""

    title: Text = ""
    scene: Text = ""
    """the scene's file, beside this one"""
    template: Text = ""
    """or one of `ecume new`"""
    process: Text = ""
    """or a process that makes its own scenes, such as `t1`; the axes are its arguments"""
    fixed: dict[Key, Value] = Field(default_factory=dict)
    """keys of the scene that differ from its file in all points"""
    axes: tuple[Axis, ...] = ()
    """each combination of their values is a point"""
    sampling: Sampling | None = None
    """with axes as well, each combination is drawn anew"""
    repeats: Annotated[int, Field(strict=True, ge=1, le=100_000)] = 1
    """of each point, with a seed of its own: the scene's, and on from there"""
    measures: tuple[Text, ...] = ()
    """what the table has of each run: `final kinetic_energy`, `mean pressure`, `max top`, `first top > 0.3` ...; left
    out, the last value of every number"""
    cluster: Cluster = Cluster()

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        found: Complaints = []
        if sum(map(bool, (self.scene, self.template, self.process))) != 1:
            found.append(((), "wanted one of scene, template and process"))
        if not self.axes and self.sampling is None and self.repeats == 1:
            found.append((("axes",), "is missing; nothing varies"))
        if self.process and self.repeats > 1:
            found.append((("repeats",), "a process has no seed; its repeats would be equal"))
        if found:
            raise Inconsistent(found)
        return self


READER = TypeAdapter(SweepSpec)
