"""No modules import one another, and no layer imports a higher one by a string, where import-linter cannot see it."""

import ast
import re
import subprocess
import sys
import tomllib
from collections.abc import Collection, Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import ecume
from ecume._hooks import Hook
from tests.sources import source_files

PACKAGE = Path(ecume.__file__).parent
ROOT = PACKAGE.parents[1]
IMPORTERS = ("import_module", "__import__")


@cache
def layers() -> dict[str, int]:
    """The floor of each module that pyproject.toml names, the highest with the lowest number."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    floors = contracts[0]["layers"]
    return {name.strip(): number for number, floor in enumerate(floors) for name in floor.split("|")}


def floor_of(module: str, floors: dict[str, int]) -> int:
    """The floor of a module, or of the package that it is in."""
    parts = module.split(".")
    return next(floors[name] for n in range(len(parts), 0, -1) if (name := ".".join(parts[:n])) in floors)


def strings_in(text: str) -> Iterator[str]:
    """The names, or their beginnings, of our modules that a file imports by a string."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Call) and getattr(node.func, "attr", getattr(node.func, "id", "")) in IMPORTERS:
            named = node.args[0]
            first = named.values[0] if isinstance(named, ast.JoinedStr) else named
            value = first.value if isinstance(first, ast.Constant) else ""
            if str(value).startswith("ecume."):
                yield str(value).rstrip(".")


def upward(path: Path) -> list[str]:
    """The modules of higher layers, or of other packages in the same one, that a file imports by a string."""
    floors = layers()
    module = ".".join(("ecume", *path.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(".__init__")
    if module == "ecume":  # the top, which hands out everything
        return []
    here, package = floor_of(module, floors), module.split(".")[1]
    return [
        name
        for name in strings_in(path.read_text(encoding="utf-8"))
        if floor_of(name, floors) <= here and name.split(".")[1] != package
    ]


@cache
def files() -> dict[str, Path]:
    """The file of each module of our packages, by its full name."""
    names = {path: path.relative_to(PACKAGE.parent).with_suffix("").parts for path in source_files()}
    return {".".join(parts).removesuffix(".__init__"): path for path, parts in names.items()}


def imports_in(text: str, module: str, known: Collection[str]) -> set[str]:
    """The modules that a module imports anywhere: at its top, inside functions, and for type checking only."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found |= {each.name for each in node.names}
        if isinstance(node, ast.ImportFrom) and node.module:
            below = {each.name: f"{node.module}.{each.name}" for each in node.names}
            found |= {full if full in known else node.module for full in below.values()}
    return (found & set(known)) - {module}


def circle_in(graph: dict[str, set[str]]) -> list[str]:
    """Modules of which each imports the next, the last the first; none without such a circle."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_no_modules_import_one_another_not_even_lazily_or_for_type_checking():
    texts = {name: path.read_text(encoding="utf-8") for name, path in files().items()}
    assert not [name for name, text in texts.items() if "from ." in text], "relative imports are not followed here"
    assert circle_in({name: imports_in(text, name, texts.keys()) for name, text in texts.items()}) == []


@pytest.mark.parametrize(
    "line",
    [
        "from ecume.b import x",
        "from ecume import b",
        "import ecume.b",
        "def f():\n    from ecume.b import x",
        "if TYPE_CHECKING:\n    from ecume.b import X",
    ],
)
def test_circles_are_found_wherever_the_import_stands(line):
    back = imports_in("from ecume.a import y", "ecume.b", ["ecume.a", "ecume.b"])
    graph = {"ecume.a": imports_in(line, "ecume.a", ["ecume.a", "ecume.b"]), "ecume.b": back}
    assert set(circle_in(graph)) == {"ecume.a", "ecume.b"}
    assert circle_in({**graph, "ecume.b": set()}) == []


def trees_on_the_page() -> dict[str, list[str]]:
    """The modules of each tree on the page about the architecture, by their package and in their order."""
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```\n([a-z/]+)/\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return {
        f"ecume.{folder.replace('/', '.')}": [line.split()[0].replace("/", ".") for line in lines.splitlines()]
        for folder, lines in blocks
        if folder.startswith(("models/", "scenes"))
    }


def imports_below(package: str, order: list[str]) -> list[str]:
    """The imports of a package's modules of others that do not come earlier in this order."""
    places = {f"{package}.{name}": place for place, name in enumerate(order)}
    texts = {name: files()[name].read_text(encoding="utf-8") for name in places}
    return [
        f"{name} imports {other}"
        for name, text in texts.items()
        for other in sorted(imports_in(text, name, files().keys()))
        if places.get(other, -1) > places[name]
    ]


@pytest.mark.parametrize("package", ["models.floating", "models.sph", "models.soft", "models.tracers", "scenes"])
def test_the_tree_of_a_package_on_the_page_has_its_files_in_the_order_of_imports(package):
    order = trees_on_the_page()[f"ecume.{package}"]
    modules = {
        name.removeprefix(f"ecume.{package}.")
        for name, path in files().items()
        if name.startswith(f"ecume.{package}.") and path.name != "__init__.py"
    }
    assert sorted(order) == sorted(modules), "docs/architecture.md has a line for each file of the package"
    assert imports_below(f"ecume.{package}", order) == []


def test_an_import_of_a_later_line_is_found():
    assert imports_below("ecume.models.floating", ["record", "parameters"]) == [
        "ecume.models.floating.record imports ecume.models.floating.parameters"
    ]


def test_no_module_imports_a_higher_layer_by_a_string():
    found = {path.relative_to(PACKAGE).as_posix(): names for path in PACKAGE.rglob("*.py") if (names := upward(path))}
    assert found == {}


@pytest.mark.parametrize("line", ['importlib.import_module("ecume.show.x")', 'import_module(f"ecume.show.{name}")'])
def test_such_imports_are_found(line):
    assert [name.split(".")[1] for name in strings_in(f"def f(name):\n    return {line}.shown(1)\n")] == ["show"]


def test_a_hook_without_a_function_says_so():
    with pytest.raises(LookupError, match="registered"):
        Hook()(1)


def test_a_trajectory_knows_its_scene_and_its_picture_whatever_was_imported():
    script = "from ecume.trajectories import frame, reader\nfrom ecume import _hooks\n"
    script += "import sys\nassert 'ecume.show' not in sys.modules and 'ecume.scenes' not in sys.modules\n"
    script += "assert _hooks.html_of._function and _hooks.scene_of._function\n"
    subprocess.run([sys.executable, "-c", script], check=True)


def test_laws_but_those_of_multipoles_run_no_compiled_code():
    """Their tests are not repeated in the compiled pass: see conftest.py."""
    names = [
        path.stem for path in (PACKAGE / "laws").glob("*") if path.stem not in ("multipole", "__init__", "__pycache__")
    ]
    script = "import importlib, sys\n"
    script += f"for name in {sorted(names)}:\n    importlib.import_module(f'ecume.laws.{{name}}')\n"
    script += "assert not {'numba', 'ecume._jit', 'ecume.models'} & set(sys.modules)\n"
    subprocess.run([sys.executable, "-c", script], check=True)
    for path in (ROOT / "tests" / "laws").glob("test_*.py"):
        used = re.findall(r"ecume[.\w]*", path.read_text(encoding="utf-8"))
        compiles = {name for name in used if name.startswith(("ecume.models", "ecume.engine", "ecume._jit"))}
        assert path.name == "test_multipole.py" or (not compiles and "ecume.laws.multipole" not in used), path.name
