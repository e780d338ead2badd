"""Runs trials and prints one table: `python -m tests.torture [--scale 0.1] [--record FILE] [NAME ...]`.

A record keeps the rows of trials that were not run again, so that trials can be run one by one.
"""

from __future__ import annotations

import argparse
import datetime
import math
import os
import re
import sys
import tempfile
import time
import warnings
from collections.abc import Sequence
from pathlib import Path

from ecume.run.manifest import circumstances

from . import (
    compiled,
    damage,
    hostile,
    inputs,
    killing,
    outputs,
    regression,
    states,
    strangers,
    sweeping,
    trials,
    values,
)
from .trials import Outcome, Trial, leave_nobody

MODULES = killing, damage, inputs, states, strangers, sweeping, compiled, regression, hostile, values, outputs
TRIALS: tuple[Trial, ...] = tuple(
    sorted(
        (one for module in MODULES for one in module.TRIALS),
        key=lambda trial: int(re.findall(r"\d+", trial.name)[0]),
    )
)


def main(words: Sequence[str]) -> int:
    """Run those trials whose names contain one of the words, or all; 1 where anything was not survived."""
    given = asked(words)
    trials.COUNT = given.count
    chosen = [one for one in TRIALS if not given.names or any(named(one, name) for name in given.names)]
    rows, failed = [], 0
    for trial in chosen:
        began = time.monotonic()
        outcome = tried(trial, given.scale)
        failed += outcome.survived < outcome.tried
        rows.append(row(trial, outcome, time.monotonic() - began))
        print(rows[-1], flush=True)
        if given.record is not None:
            keep(given.record, rows, given.scale)
    return int(failed > 0)


def asked(words: Sequence[str]) -> argparse.Namespace:
    """What the command line says. Ends with code 2 where a name is that of no trial."""
    known = "\n".join(f"  {trial.name:32} {trial.says}" for trial in TRIALS)
    about = (
        "Hard times for runs, files and scenes: how often each was tried, and survived. Ends with 1 where one was not."
    )
    parser = argparse.ArgumentParser(
        "torture", description=about, epilog=f"trials:\n{known}", formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help="run these alone, such as R1, floating or sweeps")
    parser.add_argument(
        "--scale", type=_scale, default=1.0, help="what part of each is tried: 0.1 takes a minute or two"
    )
    parser.add_argument("--count", type=int, metavar="N", help="try so many of each, whatever the scale")
    parser.add_argument("--record", type=Path, metavar="FILE", help="keep the table there; rows of other trials stay")
    given = parser.parse_args(words)
    for name in given.names:
        if not any(named(trial, name) for trial in TRIALS):
            parser.error(f"no trial is called {name}; --help lists them")
    return given


def _scale(text: str) -> float:
    """A positive number."""
    if not 0.0 < float(text) < math.inf:
        raise ValueError
    return float(text)


def named(trial: Trial, name: str) -> bool:
    """Whether a word of a trial's name is this."""
    return re.search(rf"\b{re.escape(name)}\b", trial.name, re.IGNORECASE) is not None


def keep(path: Path, rows: Sequence[str], scale: float) -> None:
    """Put rows into a record, in place of those of the same trials. Ends where that is of other circumstances."""
    head, former = circumstances_of(scale), path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    if former and former[0].split(", ", 1)[1] != head.split(", ", 1)[1]:
        sys.exit(f"{path} is a record of other circumstances: {former[0]}; name another file")
    kept = {name_of(row): row for row in (*former, *rows)}
    path.write_text(table(head, [kept[one.name] for one in TRIALS if one.name in kept]), encoding="utf-8")


def name_of(row: str) -> str:
    """The trial whose row this is."""
    return row.split(" | ")[0].removeprefix("| ")


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


def circumstances_of(scale: float) -> str:
    """The date, and the kind of machine."""
    machine, date = circumstances(), datetime.datetime.now(datetime.UTC).date().isoformat()
    of_all = f"scale {scale:g}, ecume {machine['ecume']}, Python {machine['python']}"
    return f"{date}, {of_all}, {machine['processor']}, {os.cpu_count()} cores"


def table(head: str, rows: Sequence[str]) -> str:
    """The table below a line that says when and where."""
    return "\n".join([head, "", "| test | what | tried | survived | | took |", "|---|---|---|---|---|---|", *rows, ""])


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # numbers that overflow on the way to being found are no news here
    sys.exit(main(sys.argv[1:]))
