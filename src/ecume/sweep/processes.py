"""Processes that make their own scenes, and are told by numbers of their own; `PROCESSES`, the table of them."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from ecume.errors import BadInput
from ecume.scenes.faults import suggestion


class Process(NamedTuple):
    """A process."""

    run: Callable[..., Any]
    """from its arguments to what became of it"""
    told: tuple[str, ...]
    """the numbers of that which a table has"""


def _t1() -> Process:
    from ecume.models.soft import t1_process

    return Process(t1_process, ("duration", "completed", "outcome", "reduced_force", "steps", "rejected"))


PROCESSES: Mapping[str, Callable[[], Process]] = {"t1": _t1}
"""By name; called only when one is used."""


def process_of(name: str) -> Process:
    """The process of that name. Raises BadInput where there is none."""
    if name not in PROCESSES:
        raise BadInput(f"process: no such process as {name!r}; {suggestion(name, PROCESSES)}")
    return PROCESSES[name]()


def require_arguments(name: str, keys: list[str]) -> None:
    """Raise BadInput unless all keys are arguments of the process."""
    known = list(inspect.signature(process_of(name).run).parameters)
    for key in keys:
        if key not in known:
            raise BadInput(f"axes: the process {name} has no argument {key!r}; {suggestion(key, known)}")


def told_by(name: str, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Run a process, and what is told of it."""
    process = process_of(name)
    arguments = {key: tuple(value) if isinstance(value, list) else value for key, value in settings.items()}
    result = process.run(**arguments)
    return {key: getattr(result, key) for key in process.told}
