"""Compiled code is found again exactly as long as nothing changes that it was made from."""

import importlib
import importlib.util
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from numba.core.registry import CPUDispatcher

from ecume import _cache, _dependencies, _jit, _parts

pytestmark = pytest.mark.compiled

FILES = {
    "edited_laws": '''
"""Laws."""
import enum
import numpy as np

SCALE = 2.0
UNUSED = 1.0
TABLE = np.array([1.0, 2.0])

class Side(enum.IntEnum):
    LEFT = 0
    RIGHT = 1

def pull(distance, softening=0.5):
    """Pull."""
    # a comment
    return SCALE * distance + softening + TABLE[0]

def push(distance):
    return -distance

def report(distance):
    return f"{distance} m"
''',
    "edited_table": """
from typing import NamedTuple
import edited_laws

class Spring(NamedTuple):
    stiffness: float
    length: float = 1.0

class Film(NamedTuple):
    tension: float

class Row(NamedTuple):
    force: object
    sign: float

def spring_force(distance, own):
    return own.stiffness * edited_laws.pull(distance)

def film_force(distance, own):
    return own.tension * edited_laws.push(distance)

ROWS = {Spring: Row(spring_force, 1.0), Film: Row(film_force, -1.0)}
PAIRS = edited_laws.Side.LEFT, 3
""",
    "edited_step": """
from typing import NamedTuple
from ecume import _jit
import edited_laws
import edited_table

force = _jit.by_type(lambda kind: edited_table.ROWS[kind].force)
@_jit.compiled
def spring_start(own):
    return 0.5 * own.stiffness

@_jit.compiled
def film_start(own):
    return own.tension

class Start(NamedTuple):
    start: object

starts = {edited_table.Spring: Start(spring_start), edited_table.Film: Start(film_start)}
chosen = _jit.selected(starts, "start")

@_jit.compiled_inside
def moved(position, speed):
    return position + speed * edited_table.PAIRS[1]

@_jit.where_there(0.0)
def wall(subject, position):
    return subject.place - position

@_jit.compiled
def step(position, own, walls):
    for k in range(len(position)):
        position[k] = moved(position[k], force(position[k], own)) + chosen(own) + wall(walls, 1.0)

def drawn(position):
    return position + 1.0
""",
}


def key(monkeypatch, tmp_path, edits=(), kind="Spring"):
    """Of a step for a spring, from files with some edits."""
    made = {}
    for name, text in FILES.items():
        for file, old, new in edits:
            if file == name:
                assert text.count(old) == 1, old
                text = text.replace(old, new)
        path = tmp_path / f"{name}.py"
        path.write_text(text)
        spec = importlib.util.spec_from_file_location(name, path)
        module = importlib.util.module_from_spec(spec)
        monkeypatch.setitem(sys.modules, name, module)
        exec(compile(text, str(path), "exec"), vars(module))
        made[name] = module
    own = getattr(made["edited_table"], kind)
    return _dependencies.digest(made["edited_step"].step, [own], "")


COUNTS = {
    "a law": ("edited_laws", "SCALE * distance + softening", "SCALE * distance - softening"),
    "a number in a law": ("edited_step", "0.5 * own.stiffness", "0.25 * own.stiffness"),
    "a constant of a law": ("edited_laws", "SCALE = 2.0", "SCALE = 3.0"),
    "a bit of a constant": ("edited_laws", "SCALE = 2.0", "SCALE = 2.0000000000000004"),
    "the sign of a zero": ("edited_step", "where_there(0.0)", "where_there(-0.0)"),
    "the type of a constant": ("edited_laws", "SCALE = 2.0", "SCALE = 2"),
    "an array": ("edited_laws", "[1.0, 2.0]", "[1.0, 3.0]"),
    "the type of an array": ("edited_laws", "np.array([1.0, 2.0])", "np.array([1.0, 2.0], np.float32)"),
    "a default": ("edited_laws", "softening=0.5", "softening=0.25"),
    "a row of a table": ("edited_table", "Row(spring_force,", "Row(film_force,"),
    "a value in a tuple": ("edited_table", "Side.LEFT, 3", "Side.LEFT, 4"),
    "a member of an enumeration": ("edited_laws", "LEFT = 0", "LEFT = 2"),
    "a choice": ("edited_step", "edited_table.Spring: Start(spring_start)", "edited_table.Spring: Start(film_start)"),
    "whose type chooses": ("edited_step", "[kind].force)", "[kind].force, 1)"),
    "a field": (
        "edited_table",
        "stiffness: float\n",
        "stiffness: float\n    damping: float\n",
    ),
    "the order of fields": (
        "edited_table",
        "stiffness: float\n    length: float = 1.0",
        "length: float\n    stiffness: float = 1.0",
    ),
    "the default of a field": ("edited_table", "length: float = 1.0", "length: float = 2.0"),
    "an option of a decorator": ("edited_step", "@_jit.compiled_inside\ndef moved", "@_jit.compiled\ndef moved"),
    "arithmetic of a decorator": ("edited_step", "@_jit.compiled_inside\ndef moved", "@_jit.summed_inside\ndef moved"),
    "what a name stands for": ("edited_step", "import edited_laws\n", "import edited_laws\nlen = abs\n"),
    "what is done where something is there": ("edited_step", "subject.place - position", "subject.place + position"),
    "the function itself": ("edited_step", "+ chosen(own)", "- chosen(own)"),
}

SPARES = {
    "a comment": ("edited_laws", "# a comment", "# another comment,\n    # of two lines"),
    "a docstring": ("edited_laws", '"""Pull."""', '"""Pull along the line of centers."""'),
    "the text of a module": ("edited_laws", '"""Laws."""', '"""All laws."""\nimport math\n'),
    "a constant that nothing reads": ("edited_laws", "UNUSED = 1.0", "UNUSED = 2.0"),
    "a report": ("edited_laws", '{distance} m"', '{distance} meters"'),
    "a function beside": ("edited_step", "return position + 1.0", "return position - 1.0"),
    "a law of a row that is not chosen": ("edited_laws", "return -distance", "return distance"),
    "a row that is not chosen": ("edited_table", "Row(film_force,", "Row(spring_force,"),
    "what Python alone reads in a row": ("edited_table", "Row(spring_force, 1.0)", "Row(spring_force, 5.0)"),
    "a choice for another type": ("edited_step", "Film: Start(film_start)", "Film: Start(spring_start)"),
}


@pytest.mark.parametrize("edit", COUNTS)
def test_an_edit_of_what_is_compiled_counts(monkeypatch, tmp_path, edit):
    assert key(monkeypatch, tmp_path) != key(monkeypatch, tmp_path, [COUNTS[edit]])


@pytest.mark.parametrize("edit", SPARES)
def test_an_edit_beside_what_is_compiled_does_not_count(monkeypatch, tmp_path, edit):
    assert key(monkeypatch, tmp_path) == key(monkeypatch, tmp_path, [SPARES[edit]])


def test_another_type_of_argument_reaches_other_rows(monkeypatch, tmp_path):
    edit = SPARES["a law of a row that is not chosen"]
    assert key(monkeypatch, tmp_path, kind="Film") != key(monkeypatch, tmp_path, [edit], "Film")


def test_what_cannot_be_described_makes_the_text_of_the_package_count(monkeypatch):
    unknown = SimpleNamespace(value=1.0)

    def reading():
        return unknown.value

    with pytest.raises(_dependencies.UnknownThingError):
        list(_dependencies._lines(reading, []))
    before = _dependencies.digest(reading, [], "")
    monkeypatch.setattr(_dependencies, "package_digest", lambda: "another text")
    assert _dependencies.digest(reading, [], "") != before


def test_no_compiled_function_of_the_package_needs_its_text():
    from ecume.models.floating.time_integration import integration
    from ecume.models.soft.t1 import paper_scheme
    from ecume.models.sph.rates import sums
    from ecume.models.tracers import time_stepping

    reached = set()
    for module in (integration, paper_scheme, sums, time_stepping):
        found = [getattr(one, "loop", one) for one in vars(module).values()]
        for made in [one for one in found if isinstance(one, CPUDispatcher | _jit.Spread)]:
            for one in [made.alone, made.together] if isinstance(made, _jit.Spread) else [made]:
                if one not in _dependencies.CHOICES:
                    reached.update(_dependencies._lines(one.py_func, []))
    assert len(reached) > 300


@_jit.compiled
def added(values):
    total = 0.0
    for value in values:
        total += value
    return total


SIGNATURE = _parts.types.Array(_parts.types.float64, 1, "C")


def test_the_key_changes_with_the_types_the_target_and_the_compiler(monkeypatch):
    disk, target = added._cache, added.targetctx.codegen()
    name = disk.file_name((SIGNATURE,), target)
    assert name == disk.file_name((SIGNATURE,), target)
    other = SimpleNamespace(magic_tuple=lambda: ("another", "processor", ""))
    assert name != disk.file_name((SIGNATURE,), other)
    assert name != disk.file_name((SIGNATURE.copy(dtype=_parts.types.float32),), target)
    assert name != added.part._cache.file_name((SIGNATURE,), target)
    monkeypatch.setattr(_parts, "COMPILER", "another compiler")
    assert name != disk.file_name((SIGNATURE,), target)


def test_each_way_to_compile_a_function_has_its_own_code():
    """Also one that calls nothing: its own options count, not only those of what it calls."""
    function, target = added.py_func, added.targetctx.codegen()
    spread, summing = _jit.spread(function), _jit.summing(function)
    shared = _jit.shared(lambda values: len(values))(function)
    made = [
        added, _jit.compiled_inside(function), _jit.summed_inside(function),
        spread.together, summing.alone, summing.together, shared.together,
    ]  # fmt: skip
    names = [one.file_name((SIGNATURE,), target) for each in made for one in (each._cache, each.part._cache)]
    assert None not in names
    assert len(set(names)) == 2 * len(made)
    assert spread.alone._cache.file_name((SIGNATURE,), target) == names[0]  # compiled in the same way


def test_functions_among_the_arguments_keep_code_from_the_disk():
    assert added._cache.file_name((_parts.types.Dispatcher(added),), added.targetctx.codegen()) is None


def test_all_patches_of_a_python_share_their_code():
    assert f"cpython-3{sys.version_info.minor}" in _parts.COMPILER
    assert f"3.{sys.version_info.minor}.{sys.version_info.micro}" not in _parts.COMPILER.replace(_cache.SHIPPED, "")


def test_a_whole_is_stored_without_the_code_that_only_a_part_needs():
    alone = _jit.compiled_once(added.py_func)
    assert alone(np.ones(3)) == 3.0
    (result,) = alone.overloads.values()
    (name, form, (code, bitcode)), *_ = added._cache.reduced(result)
    full = result.library.serialize_using_object_code()
    assert (name, form, code) == (*full[:2], full[2][0])
    assert len(bitcode) < 0.5 * len(full[2][1])


@pytest.mark.parametrize(
    "entry",
    [
        "ecume.models.floating.forces.pair_forces:sum_of_wall_energies",
        "ecume.models.floating.time_integration.integration:integrate",
        "ecume.models.floating.time_integration.integration:build_all",
    ],
)
def test_what_floats_compile_is_described_without_the_text_of_the_package(entry):
    """A function with the name of a field that compiled code reads would lead to code that is never compiled."""
    module, name = entry.split(":")
    assert list(_dependencies._lines(getattr(importlib.import_module(module), name), ()))
