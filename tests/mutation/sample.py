"""Which 100 faults are tried: drawn by three seeds that were fixed before the first trial, so many in each package."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from tests.mutation.faults import Fault, faults

SEEDS = (20261122, 16, 314159)
PACKAGES = {"engine": 24, "models/floating": 26, "models/soft": 22, "models/sph": 23, "models/tracers": 5}
"""How many faults each package gets: in proportion to its lines, fixed before the first trial."""


class Mutant(NamedTuple):
    """A fault in a file."""

    name: str
    """A digest of what changes and where. It stays the same when the file moves or other functions of it change."""
    seed: int
    package: str
    path: str
    """Of the file, relative to the package."""
    fault: Fault

    def __str__(self) -> str:
        fault = self.fault
        what = " ".join(fault.before.split())
        return f"{self.name} {self.path}:{fault.line} {fault.function}: {fault.kind}: {what} -> {fault.after}"


def drawn(root: Path, packages: Mapping[str, int] = PACKAGES, seeds: tuple[int, ...] = SEEDS) -> list[Mutant]:
    """The faults to be tried in the package at `root`: each seed draws a third of each package's share.

    All faults are put in the order of a digest of the seed and the fault's surroundings, and the first ones are taken.
    So a later change of the source replaces few of them.
    """
    found: list[Mutant] = []
    for package, count in packages.items():
        everything = candidates(root, package)
        orders = [iter(sorted(everything, key=lambda mutant, seed=seed: _digest(seed, mutant.name))) for seed in seeds]
        taken: set[str] = set()
        for k in range(min(count, len(everything))):
            which = k % len(seeds)
            chosen = next(mutant for mutant in orders[which] if mutant.name not in taken)
            taken.add(chosen.name)
            found.append(chosen._replace(seed=seeds[which]))
    return found


def candidates(root: Path, package: str) -> list[Mutant]:
    """All faults of a package, no two with the same name."""
    found: dict[str, Mutant] = {}
    for path in sorted((root / package).rglob("*.py")):
        source = path.read_text(encoding="utf-8")
        lines = source.splitlines()
        for fault in faults(source):
            text = " ".join(lines[fault.line - 1].split())
            for again in range(1000):
                name = _digest(package, fault.function, text, fault.kind, fault.before, fault.after, again)[:10]
                if name not in found:
                    break
            found[name] = Mutant(name, 0, package, path.relative_to(root).as_posix(), fault)
    return list(found.values())


def _digest(*words: object) -> str:
    return hashlib.sha256("\0".join(map(str, words)).encode()).hexdigest()
