"""One trial: put a fault into the copy and run the tests of its package until one fails.

First the tests that run the faulty line as plain Python, for which nothing is compiled; then, with the compiler, all
tests of the package, those first that are likeliest to fail: those of the package's own folder, then those that run
least besides.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import coverage

from tests.mutation.tree import Tree

TESTS = {
    "engine": ("tests/engine", "tests/contracts", "tests/models"),
    "laws": ("tests/laws", "tests/contracts"),
    "models/floating": ("tests/models/floating", "tests/contracts"),
    "models/soft": ("tests/models/soft", "tests/contracts"),
    "models/sph": ("tests/models/sph", "tests/contracts"),
    "models/tracers": ("tests/models/tracers", "tests/contracts"),
}
"""The tests of each package. The engine is tested by the models that use it as well."""
OPTIONS = ("-q", "--no-header", "-p", "no:cacheprovider", "--timeout", "240", "--timeout-method", "thread")
PLAIN_LIMIT, COMPILED_LIMIT = 600.0, 3600.0
"""Seconds after which a pass counts as one that does not end: such a fault is caught."""
AT_MOST = 400
"""Tests of the plain pass: more run in the compiled pass only."""


class Outcome(NamedTuple):
    """What came of a trial."""

    verdict: str
    """`caught`, `no end` (caught, too: the tests do not come to an end), or `survived`."""
    by: str = ""
    """The test that failed first."""
    plain: bool = False
    """Whether the plain pass decided."""


SURVIVED = Outcome("survived")


class Passes(NamedTuple):
    """Which tests are run."""

    compiled: bool = True
    """Also with the compiler, not as plain Python only."""
    tests: Sequence[str] = ()
    """These alone; otherwise those that run the faulty lines, then all."""


EVERY_TEST = Passes()


def trial(
    tree: Tree, folders: Sequence[str], path: str, lines: Sequence[int], text: str, passes: Passes = EVERY_TEST
) -> Outcome:
    """Whether the tests of some folders catch a changed file, whose changes begin at these lines."""
    folders = [folder for folder in folders if (tree.folder / folder).is_dir()]
    for chosen, plain in _chosen(tree, folders, (path, lines), passes):
        tree.write(path, text)
        try:
            found = _run(tree, chosen, plain)
        finally:
            tree.restore()
        if found.verdict != "survived":
            _require_sound(tree, found, plain)
            return found
    return SURVIVED


def _chosen(
    tree: Tree, folders: Sequence[str], place: tuple[str, Sequence[int]], passes: Passes
) -> list[tuple[Sequence[str], bool]]:
    """The tests of each pass, and whether it runs plain Python."""
    path, lines = place
    if passes.tests:
        return [(passes.tests, True), (passes.tests, False)][: 1 + passes.compiled]
    tests = selected_tests(record_of_lines(tree, folders), tree.package / path, lines)
    tests = sorted(tests, key=lambda test: not test.startswith(f"{folders[0]}/"))
    found: list[tuple[Sequence[str], bool]] = [(tests[:AT_MOST], True)] if tests else []
    if passes.compiled:
        files = list(dict.fromkeys(test.split("::")[0] for test in tests))
        found.append((ordered(tree.folder, files, folders), False))
    return found


def _require_sound(tree: Tree, found: Outcome, plain: bool) -> None:
    """Raise SystemExit if the test that failed fails without a fault as well."""
    if "::" in found.by and _run(tree, [found.by], plain) != SURVIVED:
        raise SystemExit(f"{found.by} fails without any fault")


def ordered(folder: Path, first: Iterable[str], folders: Iterable[str]) -> list[str]:
    """All files of tests in some folders, those of `first` before the others."""
    paths = [path for under in folders for path in sorted((folder / under).rglob("test_*.py"))]
    every = [path.relative_to(folder).as_posix() for path in paths]
    return list(dict.fromkeys([*(name for name in first if name in every), *every]))


def record_of_lines(tree: Tree, folders: Sequence[str]) -> Path:
    """The record of which tests run which lines; made where it is missing or anything has changed."""
    name = "lines-" + "-".join(folders).replace("/", "-")
    path = tree.beside / f"{name}-{tree.digest(folders)}"
    if not path.exists():
        for old in tree.beside.glob(f"{name}-*"):
            old.unlink()
        part = path.with_suffix(".part")
        command = [sys.executable, "-m", "pytest", *OPTIONS, "-p", "line_record", "-m", "not compiled", *folders]
        environment = tree.environment(NUMBA_DISABLE_JIT="1", MUTATION_LINES=str(part))
        done = subprocess.run(command, cwd=tree.folder, env=environment, capture_output=True, text=True)
        if done.returncode != 0:
            raise SystemExit(f"tests fail without any fault:\n{done.stdout[-4000:]}{done.stderr[-2000:]}")
        part.rename(path)
    return path


def selected_tests(record: Path, path: Path, lines: Sequence[int]) -> list[str]:
    """Tests that run one of some lines of a file; those that run least of that file besides come first."""
    data = coverage.CoverageData(basename=str(record))
    data.read()
    by_line = data.contexts_by_lineno(str(path))
    weights = {test: 0 for line in lines for test in by_line.get(line, ()) if test}
    for tests in by_line.values():
        for test in weights.keys() & set(tests):
            weights[test] += 1
    return sorted(weights, key=lambda test: (weights[test], test))


def _run(tree: Tree, tests: Sequence[str], plain: bool) -> Outcome:
    """What came of these tests, up to the first that fails."""
    chosen, report = tree.beside / "chosen.txt", tree.beside / "report.txt"
    chosen.write_text("\n".join(tests), encoding="utf-8")
    marks, switch = (["-m", "not compiled"], {"NUMBA_DISABLE_JIT": "1"}) if plain else ([], {})
    command = [sys.executable, "-m", "pytest", "-x", *OPTIONS, *marks, f"@{chosen}"]
    with report.open("w") as out:
        # In a session of its own: a test that hangs may have started processes, which must end with it.
        process = subprocess.Popen(
            command, cwd=tree.folder, env=tree.environment(**switch), stdout=out, stderr=out, start_new_session=True
        )
        try:
            code = process.wait(PLAIN_LIMIT if plain else COMPILED_LIMIT)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            return Outcome("no end", "", plain)
        except BaseException:
            os.killpg(process.pid, signal.SIGKILL)
            raise
    if code in (0, 5):  # all passed; or none was left after the marks
        return SURVIVED
    text = report.read_text(encoding="utf-8", errors="replace")
    failed = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", text, re.MULTILINE)
    if failed is None and "+ Timeout +" in text:
        return Outcome("no end", "", plain)
    return Outcome("caught", failed[1] if failed else f"exit code {code}", plain)
