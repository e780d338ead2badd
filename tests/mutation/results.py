"""What came of the trials: a line of JSON for each, appended and never changed."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from tests.mutation.sample import Mutant

RESULTS = Path(__file__).parent / "results.jsonl"
EQUIVALENT = Path(__file__).parent / "equivalent.txt"
"""Faults that change nothing that anybody could see, each with the reason. They count as survivors."""


def append(path: Path, mutant: Mutant, verdict: dict[str, Any]) -> None:
    """Add what came of one trial."""
    fault = mutant.fault
    row = {
        "mutant": mutant.name,
        "seed": mutant.seed,
        "package": mutant.package,
        "path": mutant.path,
        "line": fault.line,
        "function": fault.function,
        "kind": fault.kind,
        "before": fault.before,
        "after": fault.after,
        **verdict,
    }
    with path.open("a", encoding="utf-8") as file:
        file.write(json.dumps(row, ensure_ascii=False) + "\n")


def latest(path: Path) -> dict[str, dict[str, Any]]:
    """The last result of each mutant."""
    if not path.exists():
        return {}
    rows = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines() if line]
    return {row["mutant"]: row for row in rows}


def equivalent(path: Path = EQUIVALENT) -> dict[str, str]:
    """The reasons by the names of the mutants: lines of `NAME reason`."""
    if not path.exists():
        return {}
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")]
    return {line.split()[0]: line.split(maxsplit=1)[1] for line in lines}


def summary(mutants: Sequence[Mutant], rows: dict[str, dict[str, Any]], reasons: dict[str, str]) -> str:
    """A table of what was caught in each package, and a line for each survivor."""
    lines = [f"{'package':16} {'drawn':>6} {'tried':>6} {'caught':>6}"]
    packages = dict.fromkeys(mutant.package for mutant in mutants)
    for package in [*packages, "all"]:
        mine = [mutant for mutant in mutants if package in ("all", mutant.package)]
        tried = [mutant for mutant in mine if mutant.name in rows]
        caught = sum(rows[mutant.name]["verdict"] != "survived" for mutant in tried)
        lines.append(f"{package:16} {len(mine):6} {len(tried):6} {caught:6}")
    return "\n".join([*lines, *_survivors(mutants, rows, reasons)])


def _survivors(mutants: Iterable[Mutant], rows: dict[str, dict[str, Any]], reasons: dict[str, str]) -> list[str]:
    found = [mutant for mutant in mutants if rows.get(mutant.name, {}).get("verdict") == "survived"]
    notes = {name: f"  (equivalent: {reason})" for name, reason in reasons.items()}
    return [f"survived: {mutant}{notes.get(mutant.name, '')}" for mutant in found]
