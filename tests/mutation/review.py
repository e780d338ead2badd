"""The faults that a reviewer put in by hand, most of which no test caught then: all are caught now.

Each is a piece of text that stands once in the package, so that it is found wherever its file has gone.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from tests.mutation.tree import Tree
from tests.mutation.trial import TESTS, Passes, trial


class Written(NamedTuple):
    """A fault put in by hand."""

    what: str
    before: str
    after: str


FAULTS = {
    "M1": Written("thermal noise 5 % too weak", "math.sqrt(2.0 * diffusivity(", "math.sqrt(1.9 * diffusivity("),
    "M2": Written(
        "fast drag without the flow along y",
        "last_y = across + (force[i, 1] - friction * across)",
        "last_y = (force[i, 1] - friction * across)",
    ),
    "M3": Written("the partner's restitution ignored", "least = min(least, of_float[j])", "least = least"),
    "M4": Written("bounces left to the next step", "\nSTEADY = 2.0", "\nSTEADY = 50.0"),
    "M5": Written("the sign of an image's force", "away -= mirrored * tabled", "away += mirrored * tabled"),
    "M6": Written("no skin around pairs that may touch", "radius[j] + skin", "radius[j]"),
    "M7": Written("force limit of the tank's time step", "force_limit(h, force)", "20.0 * force_limit(h, force)"),
    "M8": Written("lists forget moving solids", "+ way_of_solids(parameters, state) >", ">"),
    "M9": Written(
        "the mean force on bodies in Verlet's scheme",
        "    state.motion[...] += 0.5 * time * (state.body_acceleration - bodies_before)\n",
        "",
    ),
    "M10": Written(
        "the central pull on bodies",
        "    state.body_acceleration[:d] -= "
        "parameters.pull_rate**2 * (state.pose[:d] - parameters.pull_center[:, None])\n",
        "",
    ),
    "M11": Written("eddies without the viscosity", "(fields[MU, j] - viscosity)", "fields[MU, j]"),
    "M13": Written("heat of a kick", "- 0.5 * kicked)", "- 1.0 * kicked)"),
    "M15": Written(
        "the sign of an image", "away[pair[:, 0]] - away[pair[:, 1]]", "away[pair[:, 1]] - away[pair[:, 0]]"
    ),
    "M16": Written("a relative error of 1e-9 per order", "= far / (m * (m", "= (1.0 + 1e-9) * far / (m * (m"),
}
"""By the numbers of the review. M12 and M14 change how fast an iteration converges, and nothing else."""


def place_of(root: Path, text: str) -> tuple[str, str]:
    """The package and the file where a piece of text stands. Raises ValueError unless it stands in one file."""
    found = []
    for package in TESTS:
        for path in sorted((root / package).rglob("*.py")):
            if text in path.read_text(encoding="utf-8"):
                found.append((package, path.relative_to(root).as_posix()))
    if len(found) != 1:
        raise ValueError(f"got {len(found)} files with {text!r}; expected one")
    return found[0]


def tried(tree: Tree, names: Sequence[str], passes: Passes) -> int:
    """Zero if all faults of these names were caught; of all names, if there are none."""
    left = 0
    for name in names or FAULTS:
        fault, begin = FAULTS[name], time.monotonic()
        try:
            package, path = place_of(tree.package, fault.before)
        except ValueError as error:
            left += 1
            print(f"{name} {fault.what}: the text is gone: {error}", flush=True)
            continue
        source = (tree.package / path).read_text(encoding="utf-8")
        line = source[: source.index(fault.before.strip())].count("\n") + 1
        text = source.replace(fault.before, fault.after)
        outcome = trial(tree, TESTS[package], path, [line], text, passes)
        left += outcome.verdict == "survived"
        print(f"{outcome.verdict:9} {time.monotonic() - begin:5.0f} s  {name} {fault.what}  {outcome.by}", flush=True)
    return int(left > 0)
