"""The points of a sweep: every combination of its axes' values, drawn samples, repeats."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pydantic import ValidationError

from ecume.errors import BadInput, Fault, SceneError
from ecume.scenes.faults import echo, faults_of, suggestion
from ecume.scenes.load import parsed, placed, source_in
from ecume.scenes.templates import templates
from ecume.sweep.spec import MOST_POINTS, READER, Axis, Sampling, Span, SweepSpec

MOST_BYTES = 2**22
Settings = dict[str, Any]
"""Values by key."""


class Asked(NamedTuple):
    """A sweep's file."""

    spec: SweepSpec
    text: str
    folder: Path
    """in which it looks for its scene"""
    name: str = "sweep"
    """what messages call it"""


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
    """One combination."""

    settings: Settings
    """what differs from the scene's file"""
    repeat: int


def points_of(spec: SweepSpec) -> list[Point]:
    """All points in the order of the table: the last axis varies first, repeats before it."""
    grids = [list(settings_of(axis)) for axis in spec.axes]
    if spec.sampling is not None:
        grids.append(list(drawn(spec.sampling)))
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
    """The keys that vary, in the order of the table's columns."""
    return list(spec.keyed.values())


def settings_of(axis: Axis) -> Iterator[Settings]:
    """The values of one axis, one after the other."""
    if axis.key is None:
        for row in axis.rows:
            yield dict(zip(axis.keys, row, strict=True))
    else:
        for value in axis.values or spread(axis.span):
            yield {axis.key: value}


def spread(span: Span | None) -> Sequence[Any]:
    """Numbers from one end to the other, both exactly."""
    if span is None:
        return []
    values = between(span, np.linspace(0.0, 1.0, span.count))
    return [with_unit(float(value), span) for value in values]


def between(span: Span, parts: Any) -> Any:
    """Parts of the way from one end to the other."""
    if not span.log:
        return span.start + parts * (span.stop - span.start)
    values = span.start * (span.stop / span.start) ** parts
    return np.where(parts == 1.0, span.stop, values)


def with_unit(value: float, span: Span) -> Any:
    """A value as the scene's file would have it."""
    short = round(value) if span.whole else float(f"{value:.15g}")  # 0.0001, and not 9.999999999999999e-05
    return f"{short!r} {span.unit}" if span.unit else short


def drawn(sampling: Sampling) -> Iterator[Settings]:
    """Points at random; the same seed gives the same points."""
    from scipy.stats import qmc

    dimension = len(sampling.axes)
    if sampling.method == "random":
        parts = np.random.default_rng(sampling.seed).random((sampling.count, dimension))
    else:
        parts = qmc.LatinHypercube(dimension, rng=np.random.default_rng(sampling.seed)).random(sampling.count)
    columns = [between(axis.span, parts[:, place]) for place, axis in enumerate(sampling.axes)]
    for row in zip(*columns, strict=True):
        yield {axis.key: with_unit(float(value), axis.span) for axis, value in zip(sampling.axes, row, strict=True)}
