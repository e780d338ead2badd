"""A plugin of pytest that records which tests run which lines of a package as plain Python.

Loaded by `-p line_record`, with the folder of the package in MUTATION_PACKAGE and the file of data in MUTATION_LINES.
"""

from __future__ import annotations

import os

import coverage
import pytest

LINES = coverage.Coverage(
    data_file=os.environ["MUTATION_LINES"],
    include=[os.environ["MUTATION_PACKAGE"] + "/*"],
    config_file=False,
    messages=False,
)
LINES.start()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    LINES.switch_context(item.nodeid)
    try:
        return (yield)
    finally:
        LINES.switch_context("")


def pytest_unconfigure():
    LINES.stop()
    LINES.save()
