"""Selection of tests for the passes of scripts/test, and coverage in every process that runs tests."""

import contextlib
import gc
import os
import signal
import threading
import zlib
from collections import Counter, defaultdict
from pathlib import Path

import coverage
import pytest
from hypothesis import settings
from numba.core import event

TESTS = Path(__file__).parent
PLAIN = ("laws", "contracts", "engine", "models", "lammps")
"""Folders whose tests can run as plain Python, without the compiler."""
COMPILED_LAWS = "test_multipole.py"
"""Tests of the only laws that are compiled themselves. All others are plain Python in either pass."""
FEW = 3
"""Cases of a test that are not `further`."""

# A busy machine is no fault.
settings.register_profile("ecume", deadline=None)
settings.load_profile("ecume")

PLAIN_PASS = os.environ.get("NUMBA_DISABLE_JIT") == "1"
MEASURED_CASES = 4
"""Cases of a test of many cases that are measured. The others run the same lines, but for a few, and Python that is
measured takes twice the time: what the report counts as run has run.
"""
MEASURED_SECONDS = 0.5
"""Processor time of a test that is measured, without compilations. A loop that takes longer repeats its lines."""
MEASURED_COMPILATIONS = 60
"""Functions whose compilation is measured in a process. All others run the same lines of the compiler, too."""


class Measuring:
    """Coverage of this process. Begins before anything of the package is imported: lines that run at import count."""

    def __init__(self):
        self.coverage, self.paused = coverage.Coverage(), set()
        self.coverage.start()
        signal.signal(signal.SIGVTALRM, lambda *_: self.pause("its time is over"))
        signal.siginterrupt(signal.SIGVTALRM, False)
        if not PLAIN_PASS:
            event.register("numba:compile", Compilations(self))

    def pause(self, reason):
        if not self.paused:
            self.coverage.stop()
        self.paused.add(reason)

    def resume(self, reason):
        if self.paused == {reason}:
            self.coverage.start()
        self.paused.discard(reason)

    @contextlib.contextmanager
    def of_a_test(self, item, number):
        """Whether the test is the case with this number of a test."""
        if number > MEASURED_CASES:
            self.pause("enough cases")
        elif item.get_closest_marker("plain") is not None and not PLAIN_PASS:
            self.pause("measured in the plain pass")
        self.tick()
        yield
        self.tick(0.0)
        for reason in (*self.paused,):
            self.resume(reason)

    def tick(self, seconds=MEASURED_SECONDS):
        """Measure for this time, counted from now; for 0 without an end."""
        if not self.paused:
            signal.setitimer(signal.ITIMER_VIRTUAL, seconds)

    def save(self):
        self.coverage.stop()
        self.coverage.save()


class Compilations(event.Listener):
    """Pauses while Numba compiles in the thread of the tests, after the first functions."""

    def __init__(self, measuring):
        self.measuring, self.begun, self.depth = measuring, 0, 0

    def on_start(self, event):
        if threading.current_thread() is threading.main_thread():
            self.begun += 1
            self.depth += 1
            if self.depth == 1:
                self.measuring.tick(0.0)
                if self.begun > MEASURED_COMPILATIONS:
                    self.measuring.pause("a compilation")

    def on_end(self, event):
        if threading.current_thread() is threading.main_thread():
            self.depth -= 1
            if self.depth == 0:
                self.measuring.resume("a compilation")
                self.measuring.tick()


# Where scripts/test asks for it.
MEASURED = Measuring() if "ECUME_TESTS_MEASURED" in os.environ else None
seen: Counter[str] = Counter()


def pytest_itemcollected(item):
    """Mark the tests of the plain pass, those that only it needs to run, and those of `--all`, so that `-m` can select
    them.
    """
    sampled = item.get_closest_marker("sampled")
    if sampled is not None and zlib.crc32(item.name.encode()) % sampled.args[0]:
        item.add_marker(pytest.mark.long)
    folder = item.path.relative_to(TESTS).parts[0]
    if folder in PLAIN and item.get_closest_marker("compiled") is None:
        item.add_marker(pytest.mark.plain)
        if folder == "lammps" or (folder == "laws" and item.path.name != COMPILED_LAWS):
            item.add_marker(pytest.mark.uncompiled)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Mark all but a few cases of each test: by their names, so that they are spread, and are always the same ones."""
    cases = defaultdict(list)
    for item in items:
        cases[item.nodeid.partition("[")[0]].append(item)
    for each in cases.values():
        each.sort(key=lambda item: (item.get_closest_marker("long") is not None, zlib.crc32(item.name.encode())))
        for item in each[FEW:]:
            item.add_marker(pytest.mark.further)


def pytest_collection_finish():
    """Freeze tests and modules, which live until the end, so that garbage collection ignores them."""
    gc.collect()
    gc.freeze()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    """Stop measuring after the first cases of a test."""
    test = item.nodeid.partition("[")[0]
    seen[test] += 1
    with contextlib.nullcontext() if MEASURED is None else MEASURED.of_a_test(item, seen[test]):
        return (yield)


@pytest.fixture(autouse=True)
def same_environment():
    """Restore environment variables, since the next test of the process may compile, or start a process that reads
    them.
    """
    before = variables()
    yield
    assert variables() == before


def variables():
    return {name: value for name, value in os.environ.items() if name.startswith(("ECUME_", "NUMBA_"))}


def pytest_unconfigure():
    if MEASURED is not None:
        MEASURED.save()
