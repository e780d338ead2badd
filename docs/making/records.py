"""Pages of the recorded validation and benchmarks, each entry with its date, commit, machine and staleness."""

from __future__ import annotations

from typing import Any

from writing import plain

from ecume.cli.comparisons import BENCHES
from ecume.made_from import age_of, recorded
from ecume_validation import CASES


def validation() -> str:
    """A summary of all cases, every number that is missed, then each one's table."""
    reported = recorded("validation")
    rows = [_summary(name, case.summary, reported.get(name)) for name, case in CASES.items()]
    head = ["| case | what is compared | met | recorded |", "|---|---|---|---|", *rows, ""]
    tables = (_case(name, reported[name]) for name in CASES if name in reported)
    return "\n".join([*head, *_misses(reported), *tables])


def _summary(name: str, says: str, entry: dict[str, Any] | None) -> str:
    age = age_of(entry, CASES[name].module, name)
    if entry is None:
        return f"| `{name}` | {says} | – | {age} |"
    met = sum(row["met"] for row in entry["rows"])
    return f"| [`{name}`](#{name}) | {says} | {met} of {len(entry['rows'])} | {age} |"


def _misses(reported: dict[str, Any]) -> list[str]:
    """One table of all numbers outside their tolerance."""
    missed = [(name, row) for name in CASES if name in reported for row in reported[name]["rows"] if not row["met"]]
    rows = [
        f"| [`{name}`](#{name}) | {plain(row['name'])} | {row['computed']} | {plain(row['expected'])} "
        f"| {row['tolerance']} |"
        for name, row in missed
    ]
    total = sum(len(reported[name]["rows"]) for name in CASES if name in reported)
    head = ["| case | number | computed | expected | tolerance |", "|---|---|---|---|---|"]
    return [f"## Misses\n\n{len(missed)} of {total} recorded numbers are outside their tolerance.\n", *head, *rows, ""]


def _case(name: str, entry: dict[str, Any]) -> str:
    rows = "\n".join(map(_row, entry["rows"]))
    said = f"{_when(entry, CASES[name].module, name)} {entry['seconds']:.0f} s of a processor."
    head = "| number | computed | expected | tolerance | |\n|---|---|---|---|---|"
    folded = f"<details><summary>{len(entry['rows'])} numbers</summary>\n\n{head}\n{rows}\n\n</details>\n"
    return f"## {name}\n\n{said}\n\n{folded}"


def _row(row: dict[str, Any]) -> str:
    met = "met" if row["met"] else "**not met**"
    return f"| {plain(row['name'])} | {row['computed']} | {plain(row['expected'])} | {row['tolerance']} | {met} |"


def _when(entry: dict[str, Any], home: str, case: str = "") -> str:
    """The date, the version and the machine; and whether the code has changed since."""
    commit = f" ({entry['commit']})" if "commit" in entry else ""
    load = f", load {entry['load']}" if "load" in entry else ""
    stale = " **Stale: the code behind it has changed since.**" if age_of(entry, home, case) != entry["date"] else ""
    return f"Recorded {entry['date']}, ecume {entry['ecume']}{commit}, {entry['processor']}{load}.{stale}"


def benchmarks() -> str:
    """When each benchmark was recorded, then each one's output."""
    reported = recorded("benchmarks")
    ages = {name: age_of(reported.get(name), _home(name)) for name in BENCHES}
    rows = [f"| `{name}` | {one.summary} | {ages[name]} |" for name, one in BENCHES.items()]
    outputs = (_bench(name, reported[name]) for name in BENCHES if name in reported)
    return "\n".join(["| benchmark | what is measured | recorded |", "|---|---|---|", *rows, "", *outputs])


def _home(name: str) -> str:
    return BENCHES[name].script.removesuffix(".py")


def _bench(name: str, entry: dict[str, Any]) -> str:
    said = f"{entry['summary']}. {_when(entry, _home(name))} It took {entry['seconds']:.0f} s:"
    return f"## {name}\n\n{said} `{entry['command']}`\n\n```text\n{entry['output'].strip()}\n```\n"
