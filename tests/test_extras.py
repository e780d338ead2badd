"""Hints to install something name packages that exist, whether ecume is published or not."""

import re
import tomllib
from pathlib import Path

import pytest

from ecume import errors

ROOT = Path(__file__).parents[1]
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]


@pytest.mark.parametrize("extra", sorted(EXTRAS))
def test_a_hint_names_each_package_of_the_extra(extra: str) -> None:
    hint = errors.install(extra)
    named = re.findall(r"'([^']+)'", hint)
    assert hint.startswith("pip install ")
    assert sorted(named) == sorted(requirement.partition(";")[0].strip() for requirement in EXTRAS[extra])


def test_an_unknown_extra_refers_to_the_sources() -> None:
    assert errors.install("nosuch") == "pip install '.[nosuch]' in the sources"


def test_no_text_refers_to_an_index_that_does_not_have_the_package() -> None:
    folders = [ROOT / "src", ROOT / "docs", ROOT / "benchmarks"]
    files = [path for folder in folders for path in folder.rglob("*") if path.suffix in (".py", ".md", ".toml")]
    found = [path for path in [*files, ROOT / "README.md"] if re.search(r"pip install .?ecume", path.read_text())]
    assert found == []
