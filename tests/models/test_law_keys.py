"""Code compiled for users' laws is found again exactly as long as nothing changes that the law reads."""

import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from ecume.models.floating import user_laws
from ecume.models.user_laws import compiled_for_laws, key_of

TEXT = """
import numpy as np
import a_helper

SCALE = 2.0
TABLE = np.array([1.0, 2.0])

def push(distance, parameters):
    "Push."
    return SCALE * TABLE[0] * a_helper.power(distance)
"""
HELPER = "def power(x):\n    return x**2\n"


def law(monkeypatch, text=TEXT, helper=HELPER):
    made = ModuleType("a_helper")
    exec(compile(helper, "a_helper.py", "exec"), vars(made))
    monkeypatch.setitem(sys.modules, "a_helper", made)
    mine = ModuleType("mine")
    exec(compile(text, "mine.py", "exec"), vars(mine))
    return mine


def key(module):
    return key_of(compiled_for_laws(module.push))


def test_the_same_law_has_the_same_key_wherever_it_stands(monkeypatch):
    one, other = law(monkeypatch), law(monkeypatch, "# a comment\n" + TEXT.replace("Push.", "A push."))
    assert key(one) == key(other) != None  # noqa: E711  # a chain: it has a key


@pytest.mark.parametrize(
    ("text", "helper"),
    [
        (TEXT.replace("SCALE = 2.0", "SCALE = 3.0"), HELPER),
        (TEXT.replace("[1.0, 2.0]", "[1.5, 2.0]"), HELPER),
        (TEXT.replace("* TABLE[0]", "/ TABLE[0]"), HELPER),
        (TEXT, HELPER.replace("**2", "**3")),
    ],
)
def test_what_a_law_reads_is_part_of_its_key(monkeypatch, text, helper):
    assert key(law(monkeypatch)) != key(law(monkeypatch, text, helper))


def test_an_array_that_changes_between_two_runs_of_a_session_changes_the_key(monkeypatch):
    module = law(monkeypatch)
    before = key(module)
    module.TABLE[0] = 5.0
    after = key(module)
    assert before != after
    module.SCALE = 7.0
    assert key(module) not in (before, after)
    vars(sys.modules["a_helper"])["power"] = lambda x: x
    assert key(module) != after


def test_a_helper_that_reads_something_new_changes_the_key(monkeypatch):
    helper = "LIMIT = 1.0\ndef power(x):\n    return min(x, LIMIT)\n"
    module = law(monkeypatch, helper=helper)
    before = key(module)
    sys.modules["a_helper"].LIMIT = 2.0
    assert key(module) != before


def test_what_cannot_be_described_is_not_kept(monkeypatch):
    module = law(monkeypatch)
    module.SCALE = SimpleNamespace(value=1.0)
    assert key(module) is None


def test_the_class_that_names_the_laws_of_floats_is_found_by_its_name():
    name = f"{user_laws.KEPT}{'0' * 32}"
    made = getattr(user_laws, name)
    assert made is getattr(user_laws, name)
    assert made.__module__ == user_laws.__name__
    assert made._fields == user_laws.FIELDS
    with pytest.raises(AttributeError):
        user_laws.something_else  # noqa: B018
    assert np.all(np.array(made(*range(len(made._fields)))) == np.arange(len(made._fields)))
