"""Nothing of the user's is removed after an error of a kind that may mean anything: each such place was looked at."""

from __future__ import annotations

import ast
import builtins
from pathlib import Path

import ecume
from ecume import errors

PACKAGE = Path(ecume.__file__).parent
DESTRUCTIVE = {"rmtree", "unlink", "remove", "rmdir", "replace", "rename", "take", "truncate", "ftruncate", "clear"}
NARROW = {"FileNotFoundError", "FileExistsError", "PermissionError", "BrokenPipeError", "ProcessLookupError"}
REVIEWED = {
    "_cache.py": ["Path(beside).unlink(missing_ok=True)"],
    "_plain_files.py": ["os.ftruncate(file.fileno(), before)"],
    "run/imports.py": ["shutil.rmtree(beside.path, ignore_errors=True)"],
    "scenes/templates.py": ["path.unlink(missing_ok=True)"],
    "show/movies.py": ["partial.unlink()", "each.unlink(missing_ok=True)"],
    "show/serving.py": ["shutil.rmtree(folder, ignore_errors=True)"],
    "trajectories/exports.py": ["shutil.rmtree(part, ignore_errors=True)"],
    "trajectories/records.py": ["part.unlink()"],
    "trajectories/segments.py": ["self._file.truncate(self.size)"],
}
"""What is removed here was made just before by the same call, under a name that no other process uses; a file that was
added to gets its former length.
"""


def is_broad(handler: ast.ExceptHandler) -> bool:
    """Whether it catches a class that has others below it, or everything."""
    if handler.type is None:
        return True
    kinds = handler.type.elts if isinstance(handler.type, ast.Tuple) else [handler.type]
    return any(_has_subclasses(ast.unparse(kind)) for kind in kinds)


def _has_subclasses(name: str) -> bool:
    found = getattr(builtins, name, getattr(errors, name.rpartition(".")[2], None))
    return name not in NARROW and (not isinstance(found, type) or bool(found.__subclasses__()))


def destructive(nodes: list[ast.stmt]) -> list[str]:
    """The calls among these statements that remove or replace something."""
    return [
        ast.unparse(node)
        for each in nodes
        for node in ast.walk(each)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in DESTRUCTIVE
    ]


def cleaned_up(tree: ast.AST) -> list[str]:
    """What is removed after a broad catch, or whatever happens."""
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Try):
            found += destructive(node.finalbody)
            found += [call for each in node.handlers if is_broad(each) for call in destructive(each.body)]
    return found


def test_each_clean_up_after_a_broad_catch_was_reviewed() -> None:
    found = {
        path.relative_to(PACKAGE).as_posix(): cleaned_up(ast.parse(path.read_text(encoding="utf-8")))
        for path in PACKAGE.rglob("*.py")
    }
    assert {name: calls for name, calls in found.items() if calls} == REVIEWED


def test_a_run_that_is_refused_is_found_by_the_walk() -> None:
    """As `ecume import` once did: `BadInput` includes `RunExists`."""
    text = "try:\n  f()\nexcept BadInput:\n  shutil.rmtree(home)"
    assert cleaned_up(ast.parse(text)) == ["shutil.rmtree(home)"]
    assert cleaned_up(ast.parse(text.replace("BadInput", "FileNotFoundError"))) == []
    assert cleaned_up(ast.parse("try:\n  f()\nfinally:\n  path.unlink()")) == ["path.unlink()"]
