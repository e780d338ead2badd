"""The progress of a run: the first line with the expected time, and the table of numbers of `--thermo`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import ecume.run
from ecume.cli import app
from ecume.cli.progress import WithExpectation
from ecume.cli.thermo import ThermoTable, thermo_table
from ecume.run import Progress, RunResult
from ecume.scenes.templates import copy_template
from ecume.trajectories.frame import Frame


def test_the_expected_time_is_the_first_line_and_is_said_once(capsys):
    heard = []
    reporter = WithExpectation(heard.append)
    first = Progress(10, 30000, 0.1, 10.0, 1, 0.0, 0.0, None)
    for progress in (first, first._replace(remaining=240.0), first._replace(remaining=200.0)):
        reporter(progress)
    assert capsys.readouterr().err == "30000 steps, about 4 min\n"
    assert len(heard) == 3
    WithExpectation(heard.append)(first._replace(steps=None, remaining=3.0))
    assert capsys.readouterr().err == "adaptive steps, about 3 s\n"


NUMBERS = {"kinetic_energy": 1.5e-9, "clusters": 7.0, "momentum_x": -0.25}
UNITS = {"kinetic_energy": "J", "clusters": "1", "momentum_x": "kg*m/s"}


def frame(time: float) -> Frame:
    return Frame(time, {}, NUMBERS, UNITS)


def printed(table: ThermoTable, capsys: pytest.CaptureFixture[str], frames: int = 5) -> list[list[str]]:
    for number in range(frames):
        table("floating", frame(0.1 * number), 10 * number)
    return [line.split() for line in capsys.readouterr().out.splitlines()]


def test_columns_have_names_and_units(capsys: pytest.CaptureFixture[str]) -> None:
    heading, units, first, *_ = printed(ThermoTable(["momentum_x", "clusters"], 1), capsys)
    assert heading == ["step", "time", "momentum_x", "clusters"]
    assert units == ["s", "kg*m/s"]
    assert first == ["0", "0", "-0.25", "7"]


def test_the_default_columns_are_the_main_numbers_that_there_are(capsys: pytest.CaptureFixture[str]) -> None:
    heading, _, *rows = printed(ThermoTable([], 1), capsys)
    assert heading == ["step", "time", "kinetic_energy", "clusters"]
    assert rows[-1] == ["40", "0.4", "1.5e-09", "7"]


def test_lines_are_aligned(capsys: pytest.CaptureFixture[str]) -> None:
    table = ThermoTable(["kinetic_energy", "momentum_x", "clusters"], 1)
    for number in range(3):
        table("floating", frame(0.1 * number), 10**number)
    heading, units, *rows = capsys.readouterr().out.splitlines()
    assert len(units) <= len(heading)
    assert {len(row) for row in rows} == {len(heading)}


def test_every_nth_frame_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    _, _, *rows = printed(ThermoTable(["clusters"], 2), capsys)
    assert [row[0] for row in rows] == ["0", "20", "40"]


def test_a_number_that_a_frame_lacks_is_a_dash(capsys: pytest.CaptureFixture[str]) -> None:
    _, _, first, *_ = printed(ThermoTable(["front"], 1), capsys)
    assert first == ["0", "0", "-"]


def test_no_option_is_no_table() -> None:
    assert thermo_table(False, None, None) is None
    assert thermo_table(True, None, None) is not None
    chosen = thermo_table(False, "clusters, kinetic_energy", None)
    assert chosen is not None
    assert chosen.names == ("clusters", "kinetic_energy")


@pytest.mark.parametrize("options", [["--thermo-columns", "clusters,contacts", "--thermo-every", "3"], ["--thermo"]])
def test_the_options_reach_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: list[str]) -> None:
    calls: list[Any] = []

    def run(scene: Any, directory: Path, **given: Any) -> RunResult:
        calls.append(given["options"])
        given["options"].on_frame("floating", frame(0.0), 0)
        return RunResult(directory, 301, 6000, 6.0, 90.0)

    monkeypatch.setattr(ecume.run, "run", run)
    monkeypatch.chdir(tmp_path)
    copy_template("two-spheres", tmp_path / "beads.toml")
    done = CliRunner().invoke(app, ["run", "beads.toml", *options])
    assert done.exit_code == 0
    assert calls[0].numbers == (("clusters", "contacts") if len(options) > 1 else ())
    assert done.stdout.splitlines()[0].split()[:2] == ["step", "time"]
