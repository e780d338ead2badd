"""Digests of the code and data behind recorded numbers, which show whether a record is stale.

A digest covers the source of every module that a case or a script reaches by imports, its data, and the templates that
it names. Only the models that it uses, and their scenes, are included. Comments, docstrings, blank lines and error
messages do not count, since they do not change numbers. For a case, code that only draws, prints or stores is excluded.
"""

from __future__ import annotations

import ast
import hashlib
import json
import re
import tomllib
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from ecume.errors import BESIDE

PACKAGE = Path(__file__).absolute().parent
CASES = "ecume_validation."
RUNNER = f"{CASES}runner"
"""The module that every case imports; models that it names are ignored."""
NOT_TIMED = re.compile(r"ecume(\.(cli(\..*)?|_version|made_from))?$|ecume_validation$")
"""Modules without influence on numbers and times, apart from that of their imports."""
NO_NUMBERS = re.compile(
    r"ecume_lammps(\..*)?$|ecume\.(?:_cache|(citing|run|show|trajectories)(\..*)?|models\.(costs|expected_events|gravity|size_report)|scenes\.(faults|starts|templates)|.*\.(check_report|first_contact|motion_rows))$"
)
"""Modules without influence on the numbers of cases: they draw, store, print, copy scenes, say what is wrong, or read
files of other programs, which no case does.
"""
OF_A_MODEL = re.compile(r"ecume\.(?:models|scenes)\.(floating|soft|sph|tracers)(?:\..*)?$")
MODELS = frozenset({"floating", "soft", "sph", "tracers"})
QUOTED = re.compile(r"\"([\w-]+)\"")
NAMED = re.compile(r"ecume(?:_validation|_lammps)?(?:\.\w+)+(?=:\w+$|$)")
"""Text that names a module, or something in one, for a late import."""


class Source(NamedTuple):
    """The digest of a module, and the names that it contains."""

    digest: str
    imports: frozenset[str]
    """names of modules, or of things in them"""
    texts: frozenset[str]
    arguments: frozenset[str]
    """text that a call begins with"""


@cache
def digest_of(home: str, case: str = "", package: Path = PACKAGE) -> str:
    """The digest of everything behind the numbers of a case or the times of a script; `home` is its module."""
    whole = hashlib.sha256()
    for name in sorted(modules_of(home, case, package)):
        whole.update(f"{name} {_source(_path(name, package)).digest}\0".encode())
    for path in (*_data(home, case, package), *_templates(home, package)):
        whole.update(path.relative_to(package.parent).as_posix().encode() + _content(path))
    return whole.hexdigest()[:32]


@cache
def modules_of(home: str, case: str = "", package: Path = PACKAGE) -> frozenset[str]:
    """All modules that a case or a script reaches."""
    models = models_of(home, case, package)
    ahead, found = [home, *(f"ecume.models.{model}" for model in models)], set[str]()
    while ahead:
        name = ahead.pop()
        unused = (of := OF_A_MODEL.match(name)) is not None and of[1] not in models
        if name in found or unused or NOT_TIMED.match(name) or (home.startswith(CASES) and NO_NUMBERS.match(name)):
            continue
        found.add(name)
        ahead += _imported(name, package)
    return frozenset(found)


@cache
def models_of(home: str, case: str = "", package: Path = PACKAGE) -> frozenset[str]:
    """The models that a case or a script names: in its code, in its scenes, and in the templates that it runs."""
    imports = [OF_A_MODEL.match(each) for name in _own(home, package) for each in _imported(name, package)]
    scenes = [path for path in (*_data(home, case, package), *_templates(home, package)) if path.suffix == ".toml"]
    named = {tomllib.loads(path.read_text(encoding="utf-8")).get("model", "floating") for path in scenes}
    return MODELS & {*_texts(home, package), *named, *(each[1] for each in imports if each)}


@cache
def _own(home: str, package: Path) -> tuple[str, ...]:
    """The module of a case or script, and the modules in the same folder that it imports."""
    found, ahead = dict[str, None](), [home]
    while ahead:
        name = ahead.pop()
        if name not in found and name != RUNNER and (name.startswith(CASES) or not name.startswith("ecume.")):
            found[name] = None
            ahead += _imported(name, package)
    return tuple(found)


@cache
def _texts(home: str, package: Path) -> frozenset[str]:
    """All text in the code of a case or a script, and all words in quotes there."""
    found = [text for name in _own(home, package) for text in _source(_path(name, package)).texts]
    return frozenset([*found, *(word for text in found for word in QUOTED.findall(text))])


@cache
def _data(home: str, case: str, package: Path) -> tuple[Path, ...]:
    """The scenes and tables of a case, and those of other cases that its code names."""
    own = package.parent / "ecume_validation" / "data" / case.replace("-", "_")
    if not case or not own.is_dir():
        return ()
    named = set[str]().union(*(_source(_path(name, package)).arguments for name in _own(home, package)))
    names = {own.name, *named - {path.stem for path in own.iterdir()}}
    folders = [path for path in own.parent.iterdir() if path.name in names]
    return tuple(sorted(path for folder in folders for path in folder.iterdir() if path.suffix in (".csv", ".toml")))


@cache
def _templates(home: str, package: Path) -> tuple[Path, ...]:
    """The templates that the code names."""
    every = sorted((package / "templates").glob("*.toml"))
    return tuple(path for path in every if {path.stem, path.name} & _texts(home, package))


def _content(path: Path) -> bytes:
    """The content of a table, or the parsed content of a scene."""
    text = path.read_text(encoding="utf-8")
    return (repr(tomllib.loads(text)) if path.suffix == ".toml" else text).encode()


@cache
def _imported(name: str, package: Path) -> tuple[str, ...]:
    """The modules that a module imports, and their packages."""
    found: set[str] = set()
    for named in _source(_path(name, package)).imports:
        module = named if _path(named, package).is_file() else named.rpartition(".")[0]
        if module and _path(module, package).is_file():
            parts = module.split(".")
            found |= {".".join(parts[:end]) for end in range(min(2, len(parts)), len(parts) + 1)}
    return tuple(sorted(found))


@cache
def _path(name: str, package: Path) -> Path:
    """The file of a module of the package, or of a script; it may not exist."""
    first, *rest = name.split(".")
    if first not in ("ecume", *BESIDE):
        folder = scripts_of(package)
        here, with_others = folder / f"{name}.py", folder / "peers" / f"{name}.py"
        return here if here.is_file() else with_others
    place = package.with_name(first).joinpath(*rest)
    return place / "__init__.py" if place.is_dir() else place.with_suffix(".py")


def recorded(name: str) -> dict[str, Any]:
    """The records of a file in the folder `docs` of a checkout; empty for an installed package."""
    path = PACKAGE.parents[1] / "docs" / f"recorded-{name}.json"
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    return found


def age_of(entry: dict[str, Any] | None, home: str, case: str = "") -> str:
    """The date of a record, marked as stale if its digest is missing or has changed."""
    if entry is None:
        return "not recorded"
    return entry["date"] if entry.get("made_from") == digest_of(home, case) else f"stale: {entry['date']}"


def scripts_of(package: Path = PACKAGE) -> Path:
    """The folder of the benchmarks: in the installed package, or beside `src` in a checkout."""
    inside = package / "benchmarks"
    return inside if inside.is_dir() else package.parents[1] / "benchmarks"


@cache
def _source(path: Path) -> Source:
    return _source_of(path.read_text(encoding="utf-8"))


@cache
def _source_of(text: str) -> Source:
    found = Reading([], set(), set(), set())
    _read(ast.parse(text), found)
    texts = found.texts
    late = [text.removesuffix(".py").partition(":")[0] for text in texts if NAMED.match(text) or text.endswith(".py")]
    whole = hashlib.sha256("\n".join(found.said).encode()).hexdigest()
    return Source(whole, frozenset([*found.imports, *late]), frozenset(texts), frozenset(found.arguments))


class Reading(NamedTuple):
    """The names and texts that are collected from a syntax tree."""

    said: list[str]
    """the tree as text that is equal for all versions of Python, without what changes no number"""
    imports: set[str]
    texts: set[str]
    arguments: set[str]


def _read(node: Any, found: Reading) -> None:
    if isinstance(node, list):
        for each in node:
            if not (isinstance(each, ast.Expr) and isinstance(each.value, ast.Constant)):
                _read(each, found)
    elif isinstance(node, ast.Raise):
        found.said.append("raise")
    elif isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
        pass
    elif isinstance(node, ast.AST):
        found.said.append(type(node).__name__)
        if isinstance(node, ast.Import):
            found.imports.update(each.name for each in node.names)
        elif isinstance(node, ast.ImportFrom):
            found.imports.update(f"{node.module}.{each.name}" for each in node.names)
        elif isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
            found.arguments.add(str(node.args[0].value))
        elif isinstance(node, ast.Constant) and type(node.value) is str:
            found.texts.add(node.value)
        for field in node._fields:
            value = getattr(node, field, None)
            if value is not None and value != [] and field not in ("ctx", "kind", "type_comment"):
                found.said.append(field)
                _read(value, found)
        found.said.append("end")
    else:
        found.said.append(repr(node))
