"""The verb validate."""

from __future__ import annotations

import subprocess
import sys

import pytest
from typer.testing import CliRunner

from ecume.cli import app
from ecume.errors import Diverged
from ecume.laws import meniscus
from ecume_validation import CASES, Case, float_forces
from ecume_validation.runner import Row, below, within

cli = CliRunner()


def stand_ins(monkeypatch: pytest.MonkeyPatch, *cases: Case) -> None:
    monkeypatch.setattr("ecume_validation.CASES", {case.name: case for case in cases})


HOME = "ecume_validation.kernels"


def case(name: str, *rows: Row, long: bool = False) -> Case:
    return Case(name, f"about {name}", long, lambda: list(rows), HOME)


GOOD = within("height", 1.0004, 1.0, 1e-3)
BAD = below("speed", 2.0, 1.0)


@pytest.mark.long
def test_left_to_itself_it_lists_the_cases() -> None:
    done = cli.invoke(app, ["validate"])
    assert done.exit_code == 0
    assert [line.split()[0] for line in done.stdout.splitlines()[1:]] == list(CASES)
    assert "takes minutes" in done.stdout


def test_without_the_package_of_the_cases_a_message_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ecume_validation", None)
    done = cli.invoke(app, ["validate", "floating"])
    assert done.exit_code == 2
    assert "pip install ./packaging/validation" in done.stderr


def test_a_case_that_is_met_ends_with_zero() -> None:
    done = cli.invoke(app, ["validate", "kernels"])
    assert done.exit_code == 0, done.stdout
    assert "502 of 502 met" in done.stdout
    assert "NOT MET" not in done.stdout


def test_a_law_that_is_broken_ends_with_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only walls are computed for this case, since tests/validation tests all of it."""
    right, whole = meniscus.wall_height, float_forces.read_table

    def walls(*place: str) -> list[dict[str, str]]:
        return [row for row in whole(*place) if row.get("table") == "wall"]

    monkeypatch.setattr(float_forces, "read_table", walls)
    assert cli.invoke(app, ["validate", "floating"]).exit_code == 0
    monkeypatch.setattr(meniscus, "wall_height", lambda *given: right(*given) + 1e-9)
    done = cli.invoke(app, ["validate", "floating"])
    assert done.exit_code == 1
    assert "NOT MET" in done.stdout


def test_computed_expected_and_tolerance_are_printed(monkeypatch: pytest.MonkeyPatch) -> None:
    stand_ins(monkeypatch, case("one", GOOD, BAD))
    done = cli.invoke(app, ["validate", "one"])
    assert [line.split() for line in done.stdout.splitlines()[:3]] == [
        ["one", "computed", "expected", "tolerance"],
        ["height", "1.0004", "1", "0.001", "met"],
        ["speed", "2", "<", "1", "bound", "NOT", "MET"],
    ]
    assert "one: 1 of 2 met" in done.stdout
    assert done.exit_code == 1


@pytest.mark.parametrize(
    ("words", "output", "code"),
    [
        (["--all"], ["good", "slow"], 1),
        (["--all", "--quick"], ["good"], 0),
        (["--quick"], ["good"], 0),
        (["slow", "good", "slow"], ["slow", "good"], 1),
    ],
)
def test_cases_are_chosen(words: list[str], output: list[str], code: int, monkeypatch: pytest.MonkeyPatch) -> None:
    stand_ins(monkeypatch, case("good", GOOD), case("slow", BAD, long=True))
    done = cli.invoke(app, ["validate", *words])
    assert [line.split(":")[0] for line in done.stdout.splitlines() if " met, " in line] == output
    assert done.exit_code == code


def test_a_case_that_breaks_off_is_not_met_and_the_others_go_on(monkeypatch: pytest.MonkeyPatch) -> None:
    def breaks_off() -> list[Row]:
        raise Diverged("float 3 left at 1.2 s")

    stand_ins(monkeypatch, Case("bad", "", False, breaks_off, HOME), case("good", GOOD))
    done = cli.invoke(app, ["validate", "--all"])
    assert done.exit_code == 1
    assert done.stderr == "ecume: bad: NOT MET: float 3 left at 1.2 s\n"
    assert "good: 1 of 1 met" in done.stdout


def test_a_case_without_rows_is_not_met(monkeypatch: pytest.MonkeyPatch) -> None:
    stand_ins(monkeypatch, case("empty"))
    assert cli.invoke(app, ["validate", "empty"]).exit_code == 1


def test_an_unknown_case_ends_with_two_before_anything_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    stand_ins(monkeypatch, case("floating", GOOD))
    done = cli.invoke(app, ["validate", "floating", "floatnig"])
    assert done.exit_code == 2
    assert done.stdout == ""
    assert done.stderr == "ecume: no case 'floatnig'; did you mean floating?\n"
    assert cli.invoke(app, ["validate", "floating", "--all"]).exit_code == 2


@pytest.mark.long
def test_the_list_of_cases_waits_for_no_compiler() -> None:
    asked = "import sys; from ecume.cli import app; app(['validate'], standalone_mode=False); "
    tells = "print([name for name in ('numba', 'scipy', 'matplotlib') if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", asked + tells], capture_output=True, text=True, timeout=200)
    assert done.stdout.splitlines()[-1] == "[]", done.stderr
