"""The functions that are compiled again after ten typical edits, and the time that this takes.

    python benchmarks/edits.py [--scenes cereal-bowl t1 sheared-packing dam-break]

Each scene is compiled once, from nothing, in a copy of the package. Then one file of the copy is edited at a time, and
the key of each function that was compiled is derived again: where it differs, the function is compiled again. Beside
it stands what keys from the text of the package gave: everything, after each edit.
"""

from __future__ import annotations

import gc
import json
import os
import pickle
import shutil
import subprocess
import sys
import tempfile
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from timed_runs import machine

from ecume._quick import WORD, parser_of, sized

PACKAGE = Path(__file__).parents[1] / "src" / "ecume"
SCENES = sized(("cereal-bowl", "t1", "sheared-packing", "dam-break"), ("bouncing-particles",))
STEPS = sized(1, 0)


class Edit(NamedTuple):
    """One edit of one file."""

    what: str
    file: str
    old: str
    new: str


FIELD = "    passing: bool = False\n"
EDITS = (
    Edit("a constant of a law: drag", "laws/drag.py", "1.0 + 0.15 * math.pow", "1.0 + 0.1501 * math.pow"),
    Edit("a further constant: capillarity", "laws/capillarity.py", "import math\n", "import math\n\nUNUSED = 1.0\n"),
    Edit("a formula: a film", "laws/soft_pair.py", " * contact_size**2 / gap\n", " / gap * contact_size**2\n"),
    Edit("a formula: kernel of tanks", "laws/kernels.py", "-5.0 * (left * left * left)", "left * left * left * -5.0"),
    Edit("a docstring: contacts", "models/floating/contacts/collisions.py", '"""', '"""Edited. '),
    Edit("a tolerance: contacts", "engine/contact/impulse_solvers.py", "STALLS = 128", "STALLS = 127"),
    Edit("a figure", "show/floating/figures.py", '"""', '"""Edited. '),
    Edit("a message", "scenes/faults.py", '"""', '"""Edited. '),
    Edit("a report: `check`", "models/floating/check_report.py", '"""', '"""Edited. '),
    Edit("a field of the parameters: floats", "models/floating/parameters.py", FIELD, f"    edited: int = 0\n{FIELD}"),
)  # fmt: skip


class Compiled(NamedTuple):
    """A function that was compiled."""

    name: str
    """of its cache: kind and function"""
    module: str
    options: str
    """of its decorator: one function may be compiled in several ways"""
    signature: Any
    key: str
    seconds: float


def record(scene: str, place: str) -> None:
    """Compile a scene to its first step, or frame in the small size, and write what was compiled."""
    import time

    from numba.core import event
    from numba.core.serialize import dumps

    from ecume import _parts
    from ecume.scenes.load import load_scene
    from ecume.simulation import moments

    stack: list[list[float]] = []
    last = [0.0]

    class Listener(event.Listener):  # type: ignore[misc]  # Numba's types are skipped: they are incomplete
        def on_start(self, event: Any) -> None:
            stack.append([time.process_time(), 0.0])

        def on_end(self, event: Any) -> None:
            began, inside = stack.pop()
            whole = time.process_time() - began
            last[0] = whole - inside
            if stack:
                stack[-1][1] += whole

    found: list[Compiled] = []

    def noted(self: Any, signature: Any, result: Any) -> None:
        if (key := self.file_name(signature, result.codegen)) is not None:
            found.append(Compiled(self._name, self._function.__module__, self._options, dumps(signature), key, last[0]))

    event.register("numba:compile", Listener())
    _parts.DiskCache.save_overload = noted  # type: ignore[method-assign]
    run = moments(load_scene(Path(_parts.PACKAGE) / "templates" / f"{scene}.toml"))
    while next(run).step < STEPS:
        pass
    Path(place).write_bytes(pickle.dumps([tuple(one) for one in found]))


def derive(place: str) -> None:
    """Print the keys that the recorded functions have now; null for those that are gone."""
    from numba.core.registry import cpu_target

    from ecume import _parts

    recorded = [Compiled(*one) for one in pickle.loads(Path(place).read_bytes())]  # written by `record`
    for one in recorded:
        import_module(one.module)
    caches = {(each._name, each._options): each for each in gc.get_objects() if isinstance(each, _parts.DiskCache)}
    codegen = cpu_target.target_context.codegen()
    keys = []
    for one in recorded:
        try:
            keys.append(caches[one.name, one.options].file_name(pickle.loads(one.signature), codegen))
        except Exception:  # a type that the edit changed
            keys.append(None)
    print(json.dumps(keys))


def run(copy: Path, *words: str) -> str:
    """The output of this script in a process with another copy of the package."""
    environment = {**os.environ, "PYTHONPATH": str(copy.parent), "ECUME_CACHE_DIR": str(copy.parent / "compiled")}
    words = (*words, *sized((), (WORD,)))
    done = subprocess.run([sys.executable, __file__, *words], env=environment, capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr)
    return done.stdout


def main() -> None:
    """A table for each scene."""
    parser = parser_of(__doc__)
    parser.add_argument("--scenes", nargs="+", default=list(SCENES))
    asked = parser.parse_args()
    print(f"{machine()}\n")
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "ecume"
        shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
        for scene in asked.scenes:
            tabulate(scene, copy)


def tabulate(scene: str, copy: Path) -> None:
    """Compile a scene, then a line for each edit."""
    place = copy.parent / f"{scene}.pickle"
    run(copy, "record", scene, str(place))
    before = [Compiled(*one) for one in pickle.loads(place.read_bytes())]  # written by `record`
    print(
        f"{scene}: {len(before)} functions, {sum(one.seconds for one in before):.1f} s; by text all of them each time"
    )
    for edit in EDITS[: sized(None, 1)]:
        path = copy / edit.file
        text = path.read_text(encoding="utf-8")
        if edit.old not in text:
            sys.exit(f"{edit.file}: no {edit.old!r} to edit")
        path.write_text(text.replace(edit.old, edit.new, 1), encoding="utf-8")
        after = json.loads(run(copy, "derive", str(place)))
        path.write_text(text, encoding="utf-8")
        again = [one for one, key in zip(before, after, strict=True) if one.key != key]
        print(f"  {edit.what:<36}{len(again):>4} functions {sum(one.seconds for one in again):>6.1f} s")


if __name__ == "__main__":
    if sys.argv[1:2] == ["record"]:
        record(*sys.argv[2:4])
    elif sys.argv[1:2] == ["derive"]:
        derive(sys.argv[2])
    else:
        main()
