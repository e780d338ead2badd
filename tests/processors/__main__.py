"""python -m tests.processors [--all] [--only PROCESSOR ...]: see `sh scripts/processors`."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from .moving import begin, faults, resume
from .settings import PROCESSORS, ROOT, on

SCENES = (
    *sorted(path.stem for path in (ROOT / "examples").glob("*.toml")),
    "cereal-discs",
    "colloids",
    "floating-bodies",
)
SUITES = {
    "golden runs": ("-m", "pytest", "-q", "tests/golden"),
    "gallery's numbers": ("-m", "tests.torture", "R20"),
    "tests": ("-m", "pytest", "-q", "-n", "logical", "--dist", "worksteal"),
    "validation": ("-m", "ecume", "validate", "--all"),
}
"""What `--all` does on each processor besides."""


def moves(processors: list[str], folder: Path) -> Iterator[tuple[str, list[str]]]:
    """Begin the gallery on each processor and resume it on each other; the faults of each pair."""
    for first in processors:
        begin(first, folder / first, SCENES)
        for second in processors:
            found = resume(second, folder / first, folder / f"{first} to {second}", SCENES)
            yield f"{first} -> {second}", faults(first, second, found)


def suites(processors: list[str]) -> Iterator[tuple[str, list[str]]]:
    """All tests, golden runs, recorded numbers and validations on each processor."""
    for processor in processors:
        for name, words in SUITES.items():
            code = on(processor, words).returncode
            yield f"{name} on {processor}", [f"exit code {code}"] if code else []


def main() -> int:
    """Say what was tried, a line each; 1 if anything failed."""
    parser = argparse.ArgumentParser(prog="sh scripts/processors", description=__doc__)
    parser.add_argument("--all", action="store_true", help="also all tests, recorded numbers and validations (hours)")
    parser.add_argument("--only", nargs="+", default=list(PROCESSORS), choices=list(PROCESSORS), metavar="PROCESSOR")
    asked = parser.parse_args()
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        trials = [moves(asked.only, Path(folder)), suites(asked.only) if asked.all else iter(())]
        began = time.monotonic()
        for name, found in (one for each in trials for one in each):
            failed += bool(found)
            print(
                f"{'FAILED' if found else 'passed'}  {name}  {time.monotonic() - began:.0f} s",
                *found,
                sep="\n  ",
                flush=True,
            )
            began = time.monotonic()
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
