"""No test asserts what cannot fail, and each asserts something, itself or by a helper."""

import ast
import re
from pathlib import Path

import pytest

HERE = Path(__file__).parent


def empty_assertions(tree):
    """Lines of assertions that hold whatever the code does, or whenever a condition does not hold."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Assert):
            parts = [node.test]
            if isinstance(node.test, ast.IfExp):
                parts += [node.test.body, node.test.orelse]
            if isinstance(node.test, ast.BoolOp) and isinstance(node.test.op, ast.Or):
                parts += node.test.values
            if any(map(_holds, parts)):
                yield node.lineno


def _holds(part):
    """Whether an expression is true as it stands."""
    return (isinstance(part, ast.Constant) and bool(part.value)) or (isinstance(part, ast.Tuple) and bool(part.elts))


@pytest.mark.parametrize(
    "text", ["assert x if y else True", "assert True", "assert x or True", "assert (x, 'why')", "assert 1 if y else x"]
)
def test_assertions_that_cannot_fail_are_found(text):
    assert list(empty_assertions(ast.parse(text))) == [1]


def test_no_assertion_of_the_tests_is_empty():
    found = {
        f"{file.relative_to(HERE)}:{line}"
        for file in HERE.rglob("*.py")
        for line in empty_assertions(ast.parse(file.read_text(encoding="utf-8")))
    }
    assert found == set()


ASSERTING = re.compile(r"raises|warns|assert_\w+|require_\w+")
"""Calls that assert: of pytest and NumPy, and functions of the package that raise."""


def evidence(function):
    """Whether a function asserts something by itself, by pytest or NumPy, or by a child process; and what it calls."""
    nodes = list(ast.walk(function))
    calls = [node for node in nodes if isinstance(node, ast.Call)]
    called = {getattr(call.func, "attr", getattr(call.func, "id", "")) for call in calls}
    checked = any(each.arg == "check" for call in calls for each in call.keywords)
    itself = checked or any(isinstance(node, ast.Assert) for node in nodes) or any(map(ASSERTING.fullmatch, called))
    return itself, called


def helpers_among(functions):
    """The names of functions that assert, some of them by others."""
    told = [(each.name, *evidence(each)) for each in functions]
    found, before = set(), None
    while before != found:
        before = set(found)
        found |= {name for name, itself, called in told if itself or called & found}
    return found


def silent_among(functions, helpers):
    """The names of functions that assert nothing, neither by themselves nor by these helpers."""
    told = [(each.name, *evidence(each)) for each in functions]
    return [name for name, itself, called in told if not (itself or called & helpers)]


@pytest.mark.long
def test_each_test_asserts_something():
    trees = {file: ast.parse(file.read_text(encoding="utf-8")) for file in HERE.rglob("*.py")}
    functions = [node for tree in trees.values() for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    helpers = helpers_among([each for each in functions if not each.name.startswith("test_")])
    assert silent_among([each for each in functions if each.name.startswith("test_")], helpers) == []


def test_a_test_that_asserts_nothing_is_found():
    tree = ast.parse(
        "def sure():\n    assert x()\ndef surer():\n    sure()\ndef test_a():\n    surer()\ndef test_b():\n    run(1)\n"
    )
    functions = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
    assert silent_among(functions, helpers_among(functions[:2])) == ["test_b"]
