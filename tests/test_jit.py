import math
import os
import platform
import subprocess
import sys
import types
from pathlib import Path
from typing import NamedTuple

import llvmlite.binding
import numpy as np
import pytest

from ecume import _jit, _parts

pytestmark = pytest.mark.compiled

MODULE = """
import logging
import numpy as np
from ecume import _jit

logging.basicConfig(format="%(message)s")

@_jit.compiled
def inner(x):
    return 2.0 * x + 1.0

@_jit.compiled
def middle(values):
    for i in range(len(values)):
        values[i] = inner(values[i])

@_jit.compiled
def outer(values):
    middle(values)
    middle(values)

values = np.ones(5)
outer(values)
print(values[0], sum(outer.stats.cache_hits.values()), sum(middle.part.stats.cache_hits.values()))
"""


@pytest.fixture
def nested(tmp_path):
    """Runs three functions that call one another in a fresh process: the result, and how many came from the disk."""
    script = tmp_path / "nested.py"
    script.write_text(MODULE)
    folder = tmp_path / "cache"

    def run():
        places = {"ECUME_CACHE_DIR": str(folder), "PYTHONPATH": str(Path(_jit.__file__).parents[1])}
        return subprocess.run(
            [sys.executable, str(script)], env={**os.environ, **places}, capture_output=True, text=True, check=True
        )

    return run, folder


@pytest.mark.long
def test_a_second_process_finds_the_whole_on_the_disk_and_needs_no_part(nested):
    run, _ = nested
    assert run().stdout.split() == ["7.0", "0", "0"]
    assert run().stdout.split() == ["7.0", "1", "0"]


@pytest.mark.long
def test_a_lost_whole_is_made_again_from_the_parts_on_the_disk(nested):
    run, folder = nested
    run()
    for path in folder.rglob("whole-*.outer-*"):
        path.unlink()
    assert run().stdout.split() == ["7.0", "0", "1"]


LINKED = """
(overload,) = middle.part.overloads.values()
print(type(overload.library).__name__)
"""


@pytest.mark.long
def test_parts_of_the_disk_are_linked_and_never_run_where_they_stand(nested):
    """Code that runs from a part as it was lowered is many times slower than the whole that it is optimized in."""
    run, folder = nested
    (folder.parent / "nested.py").write_text(MODULE + LINKED)
    run()
    for path in folder.rglob("whole-*.outer-*"):
        path.unlink()
    result, library = run().stdout.splitlines()
    assert result.split() == ["7.0", "0", "1"]
    assert library == "PartLibrary"


@pytest.mark.long
def test_truncated_files_are_compiled_again(nested):
    run, folder = nested
    run()
    damaged = list(folder.rglob("*.code"))
    assert {path.name.partition("-")[0] for path in damaged} == {"part", "whole"}
    for path in damaged:
        path.write_bytes(path.read_bytes()[:40])
    healed = run()
    assert healed.stdout.split() == ["7.0", "0", "0"]
    assert "damaged" in healed.stderr
    assert run().stdout.split() == ["7.0", "1", "0"]


THREADED = """
import sys
import types
import numpy as np
from ecume import _jit

@_jit.threaded
def fill(values):
    for i in _jit.prange(len(values)):
        values[i] = 3.0

@_jit.compiled
def one(values):
    fill(values)

@_jit.compiled
def other(values):
    fill(values)

values = np.ones(5)
(one if sys.argv[1] == "one" else other)(values)
print(values.sum(), sum(other.stats.cache_hits.values()), sum(fill.part.stats.cache_hits.values()))
"""


@pytest.mark.long
def test_a_whole_from_the_disk_finds_its_threads_though_its_parts_came_from_there_too(tmp_path):
    script = tmp_path / "in_threads.py"
    script.write_text(THREADED)
    places = {"ECUME_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(Path(_jit.__file__).parents[1])}

    def run(which):
        words = [sys.executable, str(script), which]
        return subprocess.run(words, env={**os.environ, **places}, capture_output=True, text=True, check=True).stdout

    assert [run(which).split() for which in ("one", "other", "other")] == [
        ["15.0", "0", "0"],
        ["15.0", "0", "1"],
        ["15.0", "1", "0"],
    ]


SUMMED = """
import hashlib

import numpy as np
from ecume import _jit

@_jit.summed_inside
def pull(square, weight):
    q = np.sqrt(square) * 0.7
    return weight * (1.0 - 0.5 * q) * (1.0 - 0.5 * q) * (1.0 - 0.5 * q) * (2.0 * q + 1.0)

@_jit.summing
def sums(fields, neighbor, rates):
    for i in _jit.prange(fields.shape[1]):
        x, y = fields[0, i], fields[1, i]
        ax, ay, total = 0.0, 0.0, 0.0
        for k in range(neighbor.shape[1]):
            j = np.uint64(neighbor[i, k])
            dx, dy = fields[0, j] - x, fields[1, j] - y
            force = pull(dx * dx + dy * dy, fields[2, j])
            total += force * (dx * fields[2, j] + dy * fields[0, j])
            ax += force * dx / (1.0 + dx * dx)
            ay += force * dy
        rates[0, i], rates[1, i], rates[2, i] = total, ax, ay

random = np.random.default_rng(1)
fields, neighbor = random.normal(size=(3, 5000)), random.integers(0, 5000, (5000, 48)).astype(np.int32)
rates = np.zeros((3, 5000))
sums(fields, neighbor, rates)
print(hashlib.sha256(rates.tobytes()).hexdigest()[:12], sum(sums.together.stats.cache_hits.values()))
"""


@pytest.mark.long
def test_code_that_was_just_compiled_gives_the_bits_of_code_from_the_disk(tmp_path):
    script = tmp_path / "summed.py"
    script.write_text(SUMMED)
    places = {"ECUME_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(Path(_jit.__file__).parents[1])}

    def run():
        words = [sys.executable, str(script)]
        return subprocess.run(words, env={**os.environ, **places}, capture_output=True, text=True, check=True).stdout

    (compiled, none), (loaded, one) = run().split(), run().split()
    assert (none, one) == ("0", "1")
    assert compiled == loaded


FEATURES = {name for names in _parts.LEVELS.values() for name in names}


def test_processors_of_one_level_of_the_instruction_set_get_the_same_code():
    older = set(_parts.LEVELS["x86-64-v3"])
    assert _parts.instruction_set(dict.fromkeys(FEATURES, True)) == "x86-64-v4"
    assert _parts.instruction_set(dict.fromkeys({*FEATURES, "amx-tile", "avx512vbmi"}, True)) == "x86-64-v4"
    assert _parts.instruction_set(dict.fromkeys(older, True)) == "x86-64-v3"
    assert _parts.instruction_set({**dict.fromkeys(FEATURES, True), "avx512vl": False}) == "x86-64-v3"
    for missing in older:
        assert _parts.instruction_set({**dict.fromkeys(FEATURES, True), missing: False}) is None


TARGET = """
from ecume import _jit
from numba.core.registry import cpu_target
print(*cpu_target.target_context.codegen().magic_tuple()[1:])
"""


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="levels are those of x86-64")
def test_code_is_compiled_for_a_level_unless_the_user_names_a_processor():
    def target(**names):
        places = {"PYTHONPATH": str(Path(_jit.__file__).parents[1])}
        environment = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_CPU")}
        return subprocess.run(
            [sys.executable, "-c", TARGET],
            env={**environment, **places, **names},
            capture_output=True,
            text=True,
            check=True,
        ).stdout.split()

    level = _parts.instruction_set(llvmlite.binding.get_host_cpu_features())
    assert level is None or target() == [level]
    assert target(NUMBA_CPU_NAME="generic") == ["generic"]


@_jit.compiled
def _square(x: float) -> float:
    return x * x


@_jit.compiled
def _squares(values: np.ndarray, many: np.ndarray) -> float:
    for i in range(len(values)):
        many[i] = _square(values[i])
    return _square(many[0])


def test_one_function_serves_python_and_compiled_code():
    many = np.zeros(3)
    assert _squares(np.array([2.0, 3.0, 4.0]), many) == 16.0
    assert many.tolist() == [4.0, 9.0, 16.0]
    assert _square(3.0) == 9.0


def _law(x: float, softening: float = 0.5) -> float:
    return math.sqrt(x * x + SOFTENING) + 0.25 * softening


SOFTENING = 0.125


@_jit.compiled
def _laws(values: np.ndarray) -> float:
    return _law(values[0])


class Twice(NamedTuple):
    x: float


class Thrice(NamedTuple):
    x: float


def twice(given):
    return 2.0 * given.x


def thrice(given):
    return 3.0 * given.x


multiple = _jit.by_type(lambda kind: {Twice: twice, Thrice: thrice}[kind])


@_jit.compiled
def two_multiples(one, other):
    return multiple(one), multiple(other)


def test_the_type_of_an_argument_chooses_the_function_that_is_compiled_in():
    assert two_multiples(Twice(1.0), Thrice(1.0)) == (2.0, 3.0)
    assert two_multiples(Thrice(1.0), Twice(1.0)) == (3.0, 2.0)
    assert multiple(Thrice(1.0)) == 3.0
    with pytest.raises(Exception, match="No implementation of function"):
        two_multiples(1.0, Twice(1.0))


class Rule(NamedTuple):
    add: object
    status: object = None


@_jit.compiled
def add_doubled(part, sums):
    sums[0] += 2.0 * part.x


@_jit.compiled
def add_to_own(part, sums, factor):
    sums[0] += factor * part.x


@_jit.compiled
def status_of(part, sums):
    return 7


RULES = {Twice: Rule(add_doubled, status_of), Thrice: Rule(None)}
add = _jit.selected(RULES, "add")
status = _jit.selected(RULES, "status", 0)
add_each = _jit.each_selected({Twice: Rule(add_to_own), Thrice: Rule(None)}, "add")


@_jit.compiled
def add_both(one, other, sums):
    add(one, sums)
    add(other, sums)
    return status(one, sums), status(other, sums)


@_jit.compiled
def add_all(parts, workspaces, factor):
    add_each(parts, workspaces, factor)


def test_where_a_row_has_no_function_nothing_is_done_and_a_default_returned():
    one, other = Twice(1.5), Thrice(1.0)
    for function in (add_both, add_both.py_func):
        sums = np.zeros(1)
        assert function(one, other, sums) == (7, 0)
        assert sums[0] == 3.0
    for function in (add_all, add_all.py_func):
        workspaces = np.zeros(1), np.zeros(1)
        function((other, one), workspaces, 3.0)
        assert [each[0] for each in workspaces] == [0.0, 4.5]


APART = """
import numpy as np
from ecume import _jit

@_jit.compiled_apart("int64[:]", "float64[:,:]")
def rare(numbers, table):
    if len(numbers) > 2:
        return False
    for row in range(len(numbers)):
        table[row, 1] += numbers[row]
    return True

@_jit.compiled
def caller(numbers, table, often):
    return rare(numbers, table) if often else False

table = np.zeros((3, 2))
done = [caller(np.arange(1, 3), table, False), len(getattr(rare, "signatures", ""))]
done += [caller(np.arange(1, 3), table, True), caller(np.arange(3), table, True), caller(np.arange(0), table, True)]
print(done, table.tolist())
"""


@pytest.mark.long
def test_what_is_compiled_apart_is_compiled_when_it_is_called_and_found_by_code_from_the_disk(tmp_path):
    (tmp_path / "apart.py").write_text(APART)
    places = {"ECUME_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(Path(_jit.__file__).parents[1])}
    told = "[False, 0, True, False, True] [[0.0, 1.0], [0.0, 2.0], [0.0, 0.0]]\n"
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, str(tmp_path / "apart.py")], env={**os.environ, **places}, capture_output=True, text=True
        )
        assert done.stdout == told, done.stderr
    plain = subprocess.run(
        [sys.executable, str(tmp_path / "apart.py")],
        env={**os.environ, **places, "NUMBA_DISABLE_JIT": "1"}, capture_output=True, text=True,
    )  # fmt: skip
    assert plain.stdout == told, plain.stderr


OF_THIS_PROCESS = """
from ecume import _jit

Mine = _jit.of_this_process("Mine", ["x"])

@_jit.compiled
def outer(given):
    return given

print(outer(Mine(2.0)).x, outer((2.0,))[0])
"""


def test_nothing_is_kept_on_disk_for_types_that_no_other_process_knows(tmp_path):
    (tmp_path / "mine.py").write_text(OF_THIS_PROCESS)
    places = {"ECUME_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(Path(_jit.__file__).parents[1])}
    done = subprocess.run(
        [sys.executable, str(tmp_path / "mine.py")], env={**os.environ, **places}, capture_output=True, text=True
    )
    assert done.stdout == "2.0 2.0\n", done.stderr
    assert len(list((tmp_path / "cache").rglob("*.code"))) == 1


def test_a_law_called_in_single_precision_stays_in_it():
    law = types.ModuleType(__name__)
    law._law = _law
    _jit.admit(law)
    single, double = (_laws(np.array([0.3], kind)) for kind in (np.float32, np.float64))
    assert double == _law(0.3)
    kinds = {signature.return_type.name for signature in _laws.nopython_signatures}
    assert kinds == {"float32", "float64"}
    assert 0.0 < abs(single - double) < 1e-7


@_jit.compiled_inside
def called_by_a_sum_first(a, b, c):
    return a * b - c


@_jit.compiled_inside
def called_by_a_sum_last(a, b, c):
    return a * b - c


@_jit.summing
def summed_first(row, one):
    row[0] = called_by_a_sum_first(row[1], one, 1.0)


@_jit.summing
def summed_last(row, one):
    row[0] = called_by_a_sum_last(row[1], one, 1.0)


@_jit.compiled
def exact_after(a, b):
    return called_by_a_sum_first(a, b, 1.0)


@_jit.compiled
def exact_before(a, b):
    return called_by_a_sum_last(a, b, 1.0)


@pytest.mark.compiled
def test_the_bits_of_a_part_do_not_depend_on_who_calls_it_first():
    """Where a sum may contract a product, a - b c is -2^-60 here, and 0 where it may not."""
    row, a, b = np.array([0.0, 1.0 + 2.0**-30]), 1.0 + 2.0**-30, 1.0 - 2.0**-30
    summed_first(row, b)
    assert (exact_after(a, b), exact_before(a, b)) == (0.0, 0.0)
    summed_last(row, b)
    assert row[0] == 0.0
