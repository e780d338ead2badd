"""Which pass of scripts/test runs a test, and coverage in every process that runs tests, however many there are."""

import os
import zlib
from collections import Counter
from pathlib import Path

import coverage
import pytest
from hypothesis import settings

TESTS = Path(__file__).parent
PLAIN = ("laws", "contracts", "engine", "models", "lammps")
"""Folders whose tests can run as plain Python, without the compiler."""
COMPILED_LAWS = "test_multipole.py"
"""Tests of the only laws that are compiled themselves. All others are plain Python in either pass."""

# A busy machine is no fault.
settings.register_profile("ecume", deadline=None)
settings.load_profile("ecume")

# Where scripts/test asks for it. Begins before anything of the package is imported: lines that run at import count.
MEASURED = coverage.Coverage() if "ECUME_TESTS_MEASURED" in os.environ else None
if MEASURED is not None:
    MEASURED.start()
MEASURED_CASES = 4
"""Cases of a test of many cases that are measured. The others run the same lines, but for a few, and Python that is
measured takes twice the time: what the report counts as run has run.
"""
seen: Counter[str] = Counter()


def pytest_itemcollected(item):
    """Mark what the plain pass runs, what it alone need run, and what is left to `--all`, so that `-m` can choose."""
    sampled = item.get_closest_marker("sampled")
    if sampled is not None and zlib.crc32(item.name.encode()) % sampled.args[0]:
        item.add_marker(pytest.mark.long)
    folder = item.path.relative_to(TESTS).parts[0]
    if folder in PLAIN and item.get_closest_marker("compiled") is None:
        item.add_marker(pytest.mark.plain)
        if folder == "lammps" or (folder == "laws" and item.path.name != COMPILED_LAWS):
            item.add_marker(pytest.mark.uncompiled)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    """Nothing is measured after the first cases of a test."""
    test = item.nodeid.partition("[")[0]
    seen[test] += 1
    if MEASURED is None or seen[test] <= MEASURED_CASES:
        return (yield)
    MEASURED.stop()
    try:
        return (yield)
    finally:
        MEASURED.start()


@pytest.fixture(autouse=True)
def same_environment():
    """No test leaves a variable behind: the next test of its process may compile, or start a process, that reads it."""
    before = variables()
    yield
    assert variables() == before


def variables():
    return {name: value for name, value in os.environ.items() if name.startswith(("ECUME_", "NUMBA_"))}


def pytest_unconfigure():
    if MEASURED is not None:
        MEASURED.stop()
        MEASURED.save()
