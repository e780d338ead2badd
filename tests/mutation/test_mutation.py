"""The tool for mutation tests, on a package of one file."""

import ast
import subprocess
from pathlib import Path

import pytest

from tests.mutation import results, review
from tests.mutation.__main__ import pending, try_all
from tests.mutation.faults import changed, faults
from tests.mutation.sample import PACKAGES, SEEDS, candidates, drawn
from tests.mutation.tree import ROOT, Tree
from tests.mutation.trial import TESTS, Passes, selected_tests

SOURCE = '''"""A toy."""
from __future__ import annotations

HALF = 0.5


def kinetic(mass: float, speed: float = 2.0) -> float:
    """m v^2/2."""
    return HALF * mass * speed**2


def capped(value: float) -> float:
    """Never above 1."""
    if value > 1.0:
        value = 1.0
    return value
'''
TEST = """
from toy.energy import capped, kinetic

def test_energy():
    assert kinetic(2.0, 3.0) == 9.0

def test_cap():
    assert capped(7.0) == 1.0
    assert capped(0.25) == 0.25
"""


def what(fault):
    return fault.kind, fault.before, fault.after


def test_a_file_has_faults_of_every_kind_and_none_in_text_or_types():
    found = {what(fault) for fault in faults(SOURCE)}
    assert found == {
        ("constant", "0.5", "1.0"),
        ("constant", "2.0", "4.0"),
        ("operator", "*", "/"),
        ("operator", "**", "*"),
        ("term dropped", "HALF * mass", "HALF"),
        ("term dropped", "HALF * mass", "mass"),
        ("term dropped", "HALF * mass * speed**2", "HALF * mass"),
        ("term dropped", "HALF * mass * speed**2", "speed**2"),
        ("constant", "2", "3"),
        ("comparison", ">", ">="),
        ("comparison", ">", "<="),
        ("constant", "1.0", "2.0"),
    }


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("def f(x):\n    x -= 1\n    return -x", "def f(x):\n    pass\n    return -x"),
        ("def f(x):\n    x -= 1\n    return -x", "def f(x):\n    x += 1\n    return -x"),
        ("def f(x):\n    x -= 1\n    return -x", "def f(x):\n    x -= 1\n    return (x)"),
        ("def f(x):\n    x[0] = 2", "def f(x):\n    pass"),
        ("def f(x):\n    g(x)", "def f(x):\n    pass"),
        ("y = (a\n     + (b))", "y = (a\n     - (b))"),
        ("y = a and not b", "y = ((a) or (not b))"),
        ("y = a and not b", "y = a and (b)"),
        ("y = math.sin(x)", "y = math.cos(x)"),
        ('"ä"; y = min(x, z)', '"ä"; y = max(x, z)'),
        ("y = True", "y = False"),
    ],
)
def test_a_fault_changes_what_it_says_and_nothing_else(before, after):
    assert after in [changed(before, fault) for fault in faults(before)]


@pytest.mark.long
def test_every_fault_of_the_package_leaves_a_file_that_can_be_read():
    for path in sorted((ROOT / "src/ecume/models/tracers").glob("*.py")):
        source = path.read_text(encoding="utf-8")
        for fault in faults(source)[::40]:
            assert ast.dump(ast.parse(changed(source, fault))) != ast.dump(ast.parse(source)), fault


def test_a_fault_is_not_put_into_another_text():
    (fault,) = faults("y = True")
    with pytest.raises(ValueError, match="line 1: got b'Fals'; expected 'True'"):
        changed("y = False", fault)


def test_a_hundred_faults_are_drawn_by_three_seeds_and_stay_the_same_when_other_code_changes(tmp_path):
    assert (sum(PACKAGES.values()), len(SEEDS), set(PACKAGES) - set(TESTS)) == (100, 3, set())
    (tmp_path / "part").mkdir()
    file = tmp_path / "part" / "energy.py"
    file.write_text(SOURCE)
    before = drawn(tmp_path, {"part": 6})
    assert len({mutant.name for mutant in before}) == 6
    assert [mutant.seed for mutant in before] == [*SEEDS, *SEEDS]
    file.write_text(SOURCE.replace("HALF = 0.5", "# half of it\nHALF = 0.5"))
    file.rename(tmp_path / "part" / "moved.py")
    assert [mutant.name for mutant in drawn(tmp_path, {"part": 6})] == [mutant.name for mutant in before]


def test_the_faults_of_the_review_differ_from_the_code():
    assert all(fault.before != fault.after for fault in review.FAULTS.values())


@pytest.fixture
def toy(tmp_path):
    """A checkout of a package of one file and its tests, and the copy of it."""
    root = tmp_path / "checkout"
    (root / "src" / "toy").mkdir(parents=True)
    (root / "tests").mkdir()
    (root / "src/toy/__init__.py").touch()
    (root / "src/toy/energy.py").write_text(SOURCE)
    (root / "tests/test_energy.py").write_text(TEST)
    (root / "pytest.ini").write_text("[pytest]\nmarkers = compiled\n")
    subprocess.run(["git", "init", "-q"], cwd=root, check=True)
    tree = Tree(tmp_path / "copy", root, "src/toy")
    tree.update()
    return tree


def named(tree, *wanted):
    every = candidates(tree.package, "")
    return [next(one for one in every if what(one.fault) == each)._replace(package="toy") for each in wanted]


@pytest.mark.long
def test_faults_are_caught_or_survive_and_a_run_goes_on_where_it_ended(toy, tmp_path, monkeypatch):
    monkeypatch.setitem(TESTS, "toy", ("tests",))
    record = tmp_path / "results.jsonl"
    mutants = caught, survivor = named(toy, ("operator", "*", "/"), ("comparison", ">", ">="))
    try_all(toy, mutants[:1], record)
    left = pending(mutants, results.latest(record))
    assert left == [survivor]
    assert try_all(toy, left, record) == 1
    rows = results.latest(record)
    assert [rows[mutant.name]["verdict"] for mutant in mutants] == ["caught", "survived"]
    assert rows[caught.name]["by"] == "tests/test_energy.py::test_energy"
    assert rows[caught.name]["plain"]
    assert pending(mutants, rows) == []
    assert (toy.package / "energy.py").read_text() == SOURCE
    output = results.summary(mutants, rows, {survivor.name: "at 1.0 both give 1.0"})
    assert output.splitlines()[1].split() == ["toy", "2", "2", "1"]
    assert "(equivalent: at 1.0 both give 1.0)" in output
    (lines,) = tmp_path.glob("copy/lines-*")
    assert selected_tests(lines, toy.package / "energy.py", [15]) == ["tests/test_energy.py::test_cap"]


@pytest.mark.long
def test_named_tests_may_catch_a_fault_and_what_they_miss_is_not_recorded(toy, tmp_path, monkeypatch):
    monkeypatch.setitem(TESTS, "toy", ("tests",))
    record, (fault,) = tmp_path / "results.jsonl", named(toy, ("operator", "*", "/"))
    try_all(toy, [fault], record, passes=Passes(tests=["tests/test_energy.py::test_cap"]))
    assert results.latest(record) == {}
    try_all(toy, [fault], record, passes=Passes(tests=["tests/test_energy.py"]))
    assert results.latest(record)[fault.name]["by"] == "tests/test_energy.py::test_energy"
    assert not list(tmp_path.glob("copy/lines-*"))


@pytest.mark.long
def test_a_test_that_fails_anyway_catches_nothing(toy, tmp_path, monkeypatch):
    monkeypatch.setitem(TESTS, "toy", ("tests",))
    (toy.folder / "tests/test_energy.py").write_text("def test_nothing():\n    assert False\n")
    with pytest.raises(SystemExit, match="tests fail without any fault"):
        try_all(toy, named(toy, ("operator", "*", "/")), tmp_path / "results.jsonl")


def test_the_copy_follows_the_checkout_and_not_the_other_way_round(toy, tmp_path):
    root = tmp_path / "checkout"
    (root / "src/toy/energy.py").write_text("HALF = 0.25\n")
    (root / "tests/test_energy.py").unlink()
    toy.update()
    assert (toy.package / "energy.py").read_text() == "HALF = 0.25\n"
    assert not (toy.folder / "tests/test_energy.py").exists()
    toy.write("energy.py", "HALF = 1.0\n")
    assert (root / "src/toy/energy.py").read_text() == "HALF = 0.25\n"
    toy.restore()
    assert (toy.package / "energy.py").read_text() == "HALF = 0.25\n"


def test_recorded_results_are_of_drawn_faults_and_equivalent_ones_have_a_reason():
    rows = results.latest(results.RESULTS)
    assert {row["verdict"] for row in rows.values()} <= {"caught", "no end", "survived"}
    assert all(reason for reason in results.equivalent().values())
    assert Path(results.RESULTS).name == "results.jsonl"
