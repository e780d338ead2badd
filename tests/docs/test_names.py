"""Names in backticks, in the package and on the page about its architecture, are names of something that exists."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest
from tests.sources import source_files

import ecume

PACKAGE = Path(ecume.__file__).parent
ROOT = PACKAGE.parents[1]
DOTTED = re.compile(r"`([a-z_]\w*(?:\.\w+)+)(?:\(\))?`")
SINGLE = re.compile(r"`([a-z]\w*_\w*)(?:\(\))?`")
FILES = re.compile(r"\.(csv|data|dump|jsonl?|lammps|npz|pdf|png|pvd|py|sh|svg|table|toml)$")
ELSEWHERE = ("math.", "mylib.", "numpy.", "typing.")
"""Names of other libraries, and of one in an example."""
EXAMPLES = re.compile(r"a\.b$|gauges\.0\.|name_|top_|stress_squeeze_|kinetic_energy_min$")
"""Names that stand for any of their kind, and names that are put together from parts."""


@cache
def files() -> dict[str, Path]:
    """The file of each module, by its full name."""
    names = {path: path.relative_to(PACKAGE.parent).with_suffix("").parts for path in source_files()}
    return {".".join(parts).removesuffix(".__init__"): path for path, parts in names.items()}


@cache
def trees() -> dict[str, ast.Module]:
    """The syntax tree of each module; not parsed if tests are only collected."""
    return {name: ast.parse(path.read_text(encoding="utf-8")) for name, path in files().items()}


@cache
def defined(module: str) -> frozenset[str]:
    """Functions, classes, variables, fields, arguments and imported names of a module."""
    found: set[str] = set()
    for node in ast.walk(trees()[module]):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
        elif isinstance(node, ast.arg):
            found.add(node.arg)
        elif isinstance(node, ast.alias):
            found.add((node.asname or node.name).split(".")[0])
    return frozenset(found)


@cache
def arguments(module: str) -> frozenset[str]:
    """The names of arguments of a module's functions."""
    return frozenset(node.arg for node in ast.walk(trees()[module]) if isinstance(node, ast.arg))


@cache
def anywhere() -> frozenset[str]:
    """All names of the package, with attributes, keywords and the words of short texts, such as keys of tables."""
    found: set[str] = set().union(*map(defined, trees()))
    for tree in trees().values():
        for node in ast.walk(tree):
            if isinstance(node, ast.Attribute):
                found.add(node.attr)
            elif isinstance(node, ast.keyword) and node.arg:
                found.add(node.arg)
            elif isinstance(node, ast.Constant) and isinstance(node.value, str) and "`" not in node.value:
                found.update(re.findall(r"\w+", node.value))
    return frozenset(found)


@cache
def keys_of_scenes() -> frozenset[str]:
    """The names in the modules of scenes, such as the keys of their tables."""
    return frozenset().union(*(defined(module) for module in trees() if module.startswith("ecume.scenes")))


def is_module_or_part(name: str) -> bool:
    """Whether a name is the end of a module's, or of one followed by something that the module defines."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        modules = [each for each in trees() if f".{each}".endswith("." + ".".join(parts[:count]))]
        if any(count == len(parts) or parts[count] in defined(each) for each in modules):
            return True
    return False


def resolves(name: str, module: str) -> bool:
    """Whether a name with dots refers to something at its place: a module or a part of one, the path of a key in a
    scene, or a field of an argument of the functions of the module.
    """
    if FILES.search(name) or name.startswith(ELSEWHERE) or EXAMPLES.match(name) or is_module_or_part(name):
        return True
    first, *rest = name.split(".")
    return all(part in keys_of_scenes() for part in (first, *rest)) or (
        first in arguments(module) and all(part in anywhere() for part in rest)
    )


def is_known(name: str, module: str) -> bool:
    """Whether a name without dots is one of the package, or a module of the same model or package."""
    package = ".".join(module.split(".")[: 3 if module.startswith("ecume.models.") else 2])
    beside = (each for each in trees() if each.startswith(package))
    return name in anywhere() or any(each.endswith("." + name) for each in beside)


def missing(text: str, module: str) -> list[str]:
    """The names in backticks in a text of a module that refer to nothing."""
    dotted = [name for name in DOTTED.findall(text) if not resolves(name, module)]
    return dotted + [name for name in SINGLE.findall(text) if not EXAMPLES.match(name) and not is_known(name, module)]


@pytest.mark.parametrize("module", sorted(files()))
def test_names_in_docstrings_and_messages_exist(module):
    texts = (node.value for node in ast.walk(trees()[module]) if isinstance(node, ast.Constant))
    assert [name for text in texts if isinstance(text, str) for name in missing(text, module)] == []


def test_a_name_of_a_module_that_is_gone_is_found():
    text = (
        "see `walls.menisci` and `walls.menisci.table_of()`; `dish_outlines`; `dish.shape`, `dishes.heights_and_images`"
    )
    found = missing(text, "ecume.models.floating.parameters")
    assert found == ["walls.menisci", "walls.menisci.table_of", "dish_outlines"]


@pytest.mark.parametrize(
    "page", ["architecture", *sorted(f"decisions/{page.stem}" for page in (ROOT / "docs" / "decisions").glob("*.md"))]
)
def test_files_and_names_on_pages_about_architecture_exist(page):
    text = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")
    files = set(re.findall(r"`([\w./]+\.py)`", text))
    folders = [ROOT / name for name in ("src", "tests", "docs", "benchmarks")]
    there = [path.as_posix() for folder in folders for path in folder.rglob("*.py")]
    assert {name for name in files if not any(path.endswith("/" + name) for path in there)} == set()
    assert [name for name in DOTTED.findall(text) if not resolves(name, "ecume")] == []
