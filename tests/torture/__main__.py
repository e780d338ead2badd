"""Runs trials and prints one table: `python -m tests.torture [--scale 0.1] [--record FILE] [NAME ...]`."""

from __future__ import annotations

import argparse
import datetime
import re
import sys
import tempfile
import time
import warnings
from collections.abc import Sequence
from pathlib import Path

from ecume.run.manifest import circumstances

from . import damage, inputs, killing, states
from .trials import Outcome, Trial, leave_nobody

TRIALS: tuple[Trial, ...] = tuple(
    sorted(
        (*killing.TRIALS, *damage.TRIALS, *inputs.TRIALS, *states.TRIALS),
        key=lambda trial: int(re.findall(r"\d+", trial.name)[0]),
    )
)


def main(words: Sequence[str]) -> int:
    """Run those trials whose names contain one of the words, or all; 1 where anything was not survived."""
    asked = argparse.ArgumentParser(prog="torture")
    asked.add_argument("names", nargs="*")
    asked.add_argument("--scale", type=float, default=1.0)
    asked.add_argument("--record", type=Path)
    given = asked.parse_args(words)
    chosen = [
        one
        for one in TRIALS
        if not given.names or any(re.search(rf"\b{re.escape(name)}\b", one.name) for name in given.names)
    ]
    rows, failed = [], 0
    for trial in chosen:
        began = time.monotonic()
        outcome = tried(trial, given.scale)
        failed += outcome.survived < outcome.tried
        rows.append(row(trial, outcome, time.monotonic() - began))
        print(rows[-1], flush=True)
    if given.record is not None:
        given.record.write_text(table(rows), encoding="utf-8")
    return int(failed > 0)


def tried(trial: Trial, scale: float) -> Outcome:
    """One trial in a folder of its own; what breaks it is its outcome."""
    with tempfile.TemporaryDirectory(prefix="torture-", ignore_cleanup_errors=True) as folder:
        try:
            return trial.run(scale, Path(folder))
        except Exception as error:  # whatever it is, the other trials go on
            return Outcome(1, 0, f"{type(error).__name__}: {' '.join(str(error).split())[:100]}")
        finally:
            leave_nobody()


def row(trial: Trial, outcome: Outcome, seconds: float) -> str:
    """A line of the table."""
    word = "" if outcome.survived == outcome.tried else " **NOT**"
    cells = (trial.name, trial.says, outcome.tried, f"{outcome.survived}{word}", outcome.note, f"{seconds:.0f} s")
    return f"| {' | '.join(map(str, cells))} |"


def table(rows: Sequence[str]) -> str:
    """The table with the date and the kind of machine."""
    machine = circumstances()
    date = datetime.datetime.now(datetime.UTC).date().isoformat()
    head = f"{date}, ecume {machine['ecume']}, Python {machine['python']}, {machine['processor']}"
    return "\n".join([head, "", "| test | what | tried | survived | | took |", "|---|---|---|---|---|---|", *rows, ""])


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # numbers that overflow on the way to being found are no news here
    sys.exit(main(sys.argv[1:]))
