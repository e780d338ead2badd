"""What was recorded of validation and benchmarks, as pages: each with its date and the machine."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from writing import plain

from ecume.validation import CASES

DOCS = Path(__file__).parents[1]


def validation() -> str:
    """A summary of all cases, then each one's table."""
    reported = recorded("recorded-validation.json")
    rows = [_summary(name, case.summary, reported.get(name)) for name, case in CASES.items()]
    head = ["| case | what is compared | met | recorded |", "|---|---|---|---|", *rows, ""]
    return "\n".join([*head, *(_case(name, reported[name]) for name in CASES if name in reported)])


def _summary(name: str, says: str, entry: dict[str, Any] | None) -> str:
    if entry is None:
        return f"| `{name}` | {says} | – | not recorded |"
    met = sum(row["met"] for row in entry["rows"])
    return f"| [`{name}`](#{name}) | {says} | {met} of {len(entry['rows'])} | {entry['date']} |"


def _case(name: str, entry: dict[str, Any]) -> str:
    rows = "\n".join(map(_row, entry["rows"]))
    said = f"{entry['date']}, ecume {entry['ecume']}, {entry['seconds']:.0f} s of a processor: {entry['processor']}."
    head = "| number | computed | expected | tolerance | |\n|---|---|---|---|---|"
    folded = f"<details><summary>{len(entry['rows'])} numbers</summary>\n\n{head}\n{rows}\n\n</details>\n"
    return f"## {name}\n\n{said}\n\n{folded}"


def _row(row: dict[str, Any]) -> str:
    met = "met" if row["met"] else "**not met**"
    return f"| {plain(row['name'])} | {row['computed']} | {plain(row['expected'])} | {row['tolerance']} | {met} |"


def benchmarks() -> str:
    """Each benchmark's output."""
    return "\n".join(_bench(name, entry) for name, entry in recorded("recorded-benchmarks.json").items())


def _bench(name: str, entry: dict[str, Any]) -> str:
    said = f"{entry['summary']}. Recorded {entry['date']}, ecume {entry['ecume']}, in {entry['seconds']:.0f} s:"
    return f"## {name}\n\n{said} `{entry['command']}`\n\n```text\n{entry['output'].strip()}\n```\n"


def recorded(name: str) -> dict[str, Any]:
    """What a file of records holds."""
    path = DOCS / name
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    return found
