"""The examples in docstrings are true; those of laws are tried in `tests/contracts/test_laws.py`."""

import doctest
import importlib

import pytest
from tests.sources import CORE, source_files

SOURCES = CORE.parent
NAMES = [
    ".".join(path.relative_to(SOURCES).with_suffix("").parts).removesuffix(".__init__")
    for path in source_files()
    if ">>> " in path.read_text(encoding="utf-8") and CORE / "laws" not in path.parents
]


@pytest.mark.parametrize("name", NAMES)
def test_the_examples_of_a_module_are_true(name: str) -> None:
    tried = doctest.testmod(importlib.import_module(name))
    assert tried.attempted > 0
    assert tried.failed == 0
