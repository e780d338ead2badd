"""Processes that make their own scenes and return their own numbers; `PROCESSES` is the table of them."""

from __future__ import annotations

import inspect
import json
import typing
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from pydantic import TypeAdapter, ValidationError

from ecume.errors import BadInput, Fault, SceneError
from ecume.scenes.faults import echo, suggestion


class Process(NamedTuple):
    """A process."""

    run: Callable[..., Any]
    """from its arguments to what became of it"""
    results: tuple[str, ...]
    """the numbers of that which a table has"""
    units: Mapping[str, str]
    """of arguments and of these numbers, where they have one"""


def _t1() -> Process:
    from ecume.models.soft import t1_process

    results = ("duration", "completed", "outcome", "reduced_force", "steps", "rejected")
    return Process(t1_process, results, {"gap": "R", "duration": "ηR²/F$_N$"})


PROCESSES: Mapping[str, Callable[[], Process]] = {"t1": _t1}
"""By name; called only when one is used."""


def process_of(name: str) -> Process:
    """The process of that name. Raises BadInput for an unknown name."""
    if name not in PROCESSES:
        raise BadInput(f"process: no such process as {name!r}; {suggestion(name, PROCESSES)}")
    return PROCESSES[name]()


def require_arguments(name: str, keys: list[str]) -> None:
    """Raise BadInput unless all keys are arguments of the process, and none that it needs is missing."""
    known = inspect.signature(process_of(name).run).parameters
    for key in keys:
        if key not in known:
            raise BadInput(f"axes: the process {name} has no argument {key!r}; {suggestion(key, known)}")
    for key, argument in known.items():
        if argument.default is argument.empty and key not in keys:
            raise BadInput(f"axes: the process {name} needs {key}; add it to [[axes]] or [fixed]")


def require_settings(name: str, settings: Mapping[str, Any]) -> None:
    """Raise SceneError with the settings that are of another kind than the process takes."""
    kinds = typing.get_type_hints(process_of(name).run)
    faults = [
        Fault(key, f"got {echo(value)}; expected {_kind(kinds[key])}")
        for key, value in settings.items()
        if not _is_a(value, kinds[key])
    ]
    if faults:
        raise SceneError(faults)


def _is_a(value: Any, kind: Any) -> bool:
    """Whether a value of TOML is of an annotation's kind; a list stands for what is to be several."""
    try:
        TypeAdapter(kind).validate_json(json.dumps(value), strict=True)
    except ValidationError:
        return False
    return True


WORDS = {float: "a number", str: "text", bool: "true or false"}


def _kind(annotation: Any) -> str:
    """An annotation in words."""
    parts = [part for part in typing.get_args(annotation) or (annotation,) if part is not type(None)]
    return " or ".join(WORDS.get(part, "a list of numbers") for part in parts)


def results_of(name: str, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Run a process and return its result."""
    process = process_of(name)
    arguments = {key: tuple(value) if isinstance(value, list) else value for key, value in settings.items()}
    result = process.run(**arguments)
    return {key: getattr(result, key) for key in process.results}
