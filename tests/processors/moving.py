"""Runs that are begun on one processor and resumed on another, and what must hold for them."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .settings import on, same_code

WORKER = ("-m", "tests.processors.worker")
CLOSE = 1e-9
"""How far apart the ends of short runs may be, over the largest coordinate."""


def begin(processor: str, folder: Path, scenes: Sequence[str]) -> None:
    """Begin runs of these scenes on a processor, and leave them as if they had been killed."""
    folder.mkdir(parents=True)
    on(processor, [*WORKER, "begin", str(folder), *scenes]).check_returncode()


def resume(processor: str, folder: Path, copy: Path, scenes: Sequence[str]) -> list[dict[str, Any]]:
    """Resume copies of the runs in a folder on a processor."""
    done = on(processor, [*WORKER, "resume", str(folder), str(copy), *scenes], stdout=subprocess.PIPE)
    done.check_returncode()
    return [json.loads(line) for line in done.stdout.splitlines()]


def faults(first: str, second: str, runs: Sequence[dict[str, Any]]) -> list[str]:
    """What is wrong with runs that moved from one processor to another; nothing if all is well."""
    return [f"{run['scene']}, {first} -> {second}: {fault}" for run in runs for fault in _faults(first, second, run)]


def _faults(first: str, second: str, run: dict[str, Any]) -> list[str]:
    found = []
    if not run["done"]:
        found.append("did not reach its end")
    if not run["apart"] <= CLOSE:
        found.append(f"ended {run['apart']:.1e} of its size away")
    if len(run["warnings"]) != (run["replaced"] is not None):
        found.append(f"{len(run['warnings'])} warnings, and frames were {'' if run['replaced'] else 'not '}replaced")
    if run["replaced"] and same_code(first, second):
        found.append(f"came out with other bits, though its code is the same: {run['replaced']['difference']}")
    return found
