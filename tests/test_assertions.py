"""No test asserts what cannot fail."""

import ast
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
