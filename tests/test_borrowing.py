"""References to arrays: those from arguments are not counted, all others are, and no array leaks or ends early."""

import gc
from typing import NamedTuple

import numpy as np
import pytest
from numba.core.runtime import _nrt_python, rtsys

from ecume._borrowing import borrowed_variables
from ecume._jit import compiled_once

pytestmark = [pytest.mark.compiled, pytest.mark.sampled(2)]


class Pair(NamedTuple):
    first: np.ndarray
    second: np.ndarray


class Both(NamedTuple):
    pair: Pair
    scale: float


def sum_of(pair):
    return pair.first.sum() + pair.second.sum()


def swapped(both):
    """Builds a new pair from what it got."""
    return Pair(both.pair.second, both.pair.first)


def one_of(both, large):
    """Either a field of its argument or an array of its own."""
    chosen = both.pair.first
    if large:
        chosen = both.pair.second * both.scale
    return chosen


def rotated(both, times):
    """A name that is assigned again in a loop, and begins with what it got."""
    held = both.pair
    for _ in range(times):
        held = Pair(held.second, held.first + 1.0)
    return held


def passed_on(both):
    """What it calls borrows from what it made itself."""
    made = np.full(7, both.scale)
    pair = Pair(made, both.pair.first)
    again = swapped(Both(pair, 2.0))
    return sum_of(again) + sum_of(swapped(both))


def row_of(both):
    """A view of what it got."""
    first, second = both.pair
    return (first[1:], second[:2])


compiled_sum, compiled_swap = compiled_once(sum_of), compiled_once(swapped)


@pytest.fixture(scope="module")
def left_alone():
    """What other tests made is not searched for garbage with each balance."""
    gc.collect()
    gc.freeze()


@pytest.fixture
def counting(left_alone):
    """Numba counts the arrays that it makes and ends."""
    _nrt_python.memsys_enable_stats()
    yield
    _nrt_python.memsys_disable_stats()


def balance():
    gc.collect()
    stats = rtsys.get_allocation_stats()
    return stats.alloc - stats.free, stats.mi_alloc - stats.mi_free


def asked():
    return Both(Pair(np.arange(5.0), np.linspace(1.0, 2.0, 9)), 3.0)


def flat(answer):
    return [np.asarray(part).tolist() for part in answer] if isinstance(answer, tuple) else np.asarray(answer).tolist()


@pytest.mark.long
@pytest.mark.usefixtures("counting")
@pytest.mark.parametrize(
    ("function", "more"),
    [
        (swapped, ()),
        (one_of, (False,)),
        (one_of, (True,)),
        (rotated, (0,)),
        (rotated, (5,)),
        (row_of, ()),
        (passed_on, ()),
    ],
    ids=lambda value: getattr(value, "__name__", str(value)),
)
def test_answers_are_those_of_python_and_every_array_ends(monkeypatch, function, more):
    monkeypatch.setitem(globals(), "sum_of", compiled_sum)
    monkeypatch.setitem(globals(), "swapped", compiled_swap)
    fast = compiled_once(function)
    fast(asked(), *more)  # compiled
    before = balance()
    expected = flat(function(asked(), *more))
    for _ in range(50):
        answer = fast(asked(), *more)
        # Memory that was given back too early is written over here.
        junk = [np.full(size, np.nan) for size in (5, 7, 9)]
        assert flat(answer) == expected
        del answer, junk
    assert balance() == before


def variables_of(monkeypatch, function, *arguments):
    """The names that are borrowed when the function is compiled, without those that Numba makes."""
    found = []

    def watch(representation, kinds):
        names = borrowed_variables(representation, kinds)
        found.append({name for name in names if not name.startswith(("$", "arg."))})
        return names

    monkeypatch.setattr("ecume._borrowing.borrowed_variables", watch)
    compiled_once(function)(*arguments)
    return found[0]


def test_names_of_fields_of_arguments_are_borrowed(monkeypatch):
    assert variables_of(monkeypatch, row_of, asked()) >= {"both", "first", "second"}


def test_what_a_function_makes_itself_is_counted(monkeypatch):
    names = variables_of(monkeypatch, one_of, asked(), True)
    assert "chosen.1" not in names
    assert "chosen.2" not in names  # either


def test_a_name_that_a_loop_assigns_again_is_counted(monkeypatch):
    assert not {name for name in variables_of(monkeypatch, rotated, asked(), 2) if name.startswith("held.")}
