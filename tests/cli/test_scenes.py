"""The verbs new and check."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ecume.cli import app
from ecume.cli.scenes import is_small, without_compiler
from ecume.errors import Fault, SceneError
from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder, sweep_templates, templates

cli = CliRunner()
DERIVED = {"floating": "capillary length", "soft": "narrowest gap", "sph": "sound speed", "tracers": "terminal speed"}
"""A number that follows from each scene of a model."""
SLOW_TO_START = ("active-raft", "ellipsoids", "original-2022", "pressed-packing")
"""Templates that take seconds to place their particles, or compile laws of their own."""


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_new_lists_the_templates_with_what_they_show() -> None:
    done = cli.invoke(app, ["new"])
    groups = [group.splitlines() for group in done.stdout.split("\n\n")]
    assert [group[0] for group in groups] == ["Floats:", "Liquids in tanks:", "Soft spheres:", "Tracers:", "Sweeps:"]
    *scenes, sweeps = ([line.split()[0] for line in group[1:]] for group in groups)
    assert sorted(name for names in scenes for name in names) == list(templates())
    assert all(names for names in scenes)
    assert sweeps == list(sweep_templates())
    assert "Sixty pieces of cereal" in done.stdout


def test_new_writes_a_template_and_its_table_once(tmp_path: Path) -> None:
    assert (
        cli.invoke(app, ["new", "raft-from-table", "-o", "mine.toml"]).stdout
        == "wrote mine.toml\nwrote raft-from-table.csv\n"
    )
    again = cli.invoke(app, ["new", "raft-from-table", "-o", "mine.toml"])
    assert (again.exit_code, again.stderr) == (2, "ecume: mine.toml exists already; name another file with -o\n")


def test_new_makes_the_folder_it_writes_into_unless_a_file_is_there() -> None:
    assert cli.invoke(app, ["new", "two-spheres", "-o", "some/where.toml"]).exit_code == 0
    assert Path("some/where.toml").is_file()
    done = cli.invoke(app, ["new", "two-spheres", "-o", "some/where.toml/else.toml"])
    assert (done.exit_code, done.stderr.startswith("ecume: some/where.toml")) == (4, True)


def test_a_name_without_its_ending_and_that_of_a_template_are_recognized() -> None:
    absent = cli.invoke(app, ["check", "two-spheres.toml"]).stderr
    assert absent.endswith("No such file or directory; `ecume new two-spheres` writes it\n")
    cli.invoke(app, ["new", "two-spheres"])
    assert cli.invoke(app, ["check", "two-spheres"]).stderr.endswith("; did you mean two-spheres.toml?\n")
    Path("run").mkdir()
    Path("run/scene.toml").touch()
    assert "the scene of that run is run" in cli.invoke(app, ["check", "run"]).stderr


def test_check_reports_all_faults_and_ends_with_two() -> None:
    Path("bad.toml").write_text('model = "floating"\nduration = 1\nframe_every = -1\n[liqid]\n')
    done = cli.invoke(app, ["check", "bad.toml", "--set", "seed=x"])
    assert done.exit_code == 2
    assert done.stderr.splitlines() == [
        "ecume: bad.toml: line 3, column 1: frame_every: got -1; expected more than 0",
        "ecume: bad.toml: line 4, column 1: liqid: no such key; did you mean liquid?",
        "ecume: bad.toml: seed: got 'x'; expected a whole number (from --set)",
    ]


@pytest.mark.parametrize("name", ["none.toml", ".", "x" * 5000])
def test_check_of_what_is_no_file_ends_with_two(name: str) -> None:
    done = cli.invoke(app, ["check", name])
    assert done.exit_code == 2
    assert "Traceback" not in done.stderr


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.long] * (name in SLOW_TO_START)) for name in templates()],
)
def test_check_derives_the_numbers_of_each_template(name: str) -> None:
    cli.invoke(app, ["new", name])
    done = cli.invoke(app, ["check", f"{name}.toml"])
    assert done.exit_code == 0, done.stderr
    assert DERIVED[load_scene(f"{name}.toml").model] in done.stdout
    assert "Warning" not in done.stderr


def test_what_a_model_refuses_is_reported_with_its_line() -> None:
    cli.invoke(app, ["new", "two-spheres"])
    text = Path("two-spheres.toml").read_text().replace("1300.0", "70000.0")
    Path("two-spheres.toml").write_text(text)
    done = cli.invoke(app, ["check", "two-spheres.toml"])
    assert done.exit_code == 2
    assert f"line {text[: text.index('[[particles]]')].count(chr(10)) + 1}, column 1: particles[0]" in done.stderr


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ("positions=[[0, 0], [0.001, 0]]", "particles[0].positions[0]: overlaps particles[0].positions[1] by 1 mm"),
        ("positions=[[0, 0], [1, 0]]", "particles[0].positions[1]: (1 m, 0 m) is not inside the dish"),
        ("count=5000", "particles: together the floats would cover 1250% of the surface"),
    ],
)
def test_check_reports_what_would_keep_a_run_from_starting(change: str, says: str) -> None:
    Path("dish.toml").write_text(
        'model = "floating"\nduration = 1\nframe_every = 0.1\n[dish]\nradius = "2 cm"\n'
        '[[particles]]\nradius = "1 mm"\ndensity = 600\ncontact_angle = "70 deg"\n'
    )
    done = cli.invoke(app, ["check", "dish.toml", "--set", f"particles[0].{change}"])
    assert done.exit_code == 2
    assert says in done.stderr


def test_what_a_model_refuses_of_a_table_is_reported_with_the_tables_line(monkeypatch: pytest.MonkeyPatch) -> None:
    from ecume.cli.scenes import placed

    cli.invoke(app, ["new", "raft-from-table"])
    with pytest.raises(SceneError) as caught, placed(Path("raft-from-table.toml"), []):
        raise SceneError([Fault("rows[1]", "overlaps rows[0]")])
    beads = "raft-from-table.csv, line"
    assert f"particles_from: {beads} 4: overlaps {beads} 3" in str(caught.value)


def test_small_scenes_are_checked_without_the_compiler_in_a_process_of_their_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "0")  # so that it is put back also where it was not set
    monkeypatch.delenv("NUMBA_DISABLE_JIT")
    monkeypatch.delitem(sys.modules, "ecume._jit", raising=False)
    scenes = {name: load_scene(folder() / f"{name}.toml") for name in ("cereal-bowl", "dam-break", "t1", "colloids")}
    assert [name for name, scene in scenes.items() if is_small(scene)] == ["cereal-bowl", "dam-break", "t1"]
    without_compiler(scenes["cereal-bowl"])
    assert "NUMBA_DISABLE_JIT" not in os.environ
    monkeypatch.setattr("ecume.cli.scenes.own_process", [True])
    without_compiler(scenes["colloids"])
    assert "NUMBA_DISABLE_JIT" not in os.environ
    without_compiler(scenes["cereal-bowl"])
    assert os.environ["NUMBA_DISABLE_JIT"] == "1"


CURVED = "center = [1, 1, 1]\nradius = 0.5"


@pytest.mark.parametrize(
    ("solid", "small"),
    [("[[obstacles]]\nlow = [0, 0, 0]\nhigh = [1, 1, 1]", True), (f"[[obstacles]]\n{CURVED}", False),
     (f"[[bodies]]\ndensity = 500\n{CURVED}", False)],
    ids=["block", "ball", "floating ball"],
)  # fmt: skip
def test_liquid_around_curved_solids_in_3d_is_packed_by_compiled_loops(solid: str, small: bool) -> None:
    """In plain Python the check of a ball of an STL file took minutes."""
    text = 'model = "sph"\nduration = 1\nframe_every = 1\nspacing = 0.1\n[tank]\nlow = [0, 0, 0]\nhigh = [2, 2, 2]\n'
    fluid = "[[fluid]]\nlow = [0, 0, 0]\nhigh = [2, 1, 2]\n"
    assert is_small(load_scene(text + fluid + solid)) is small


@pytest.mark.long
def test_a_check_reports_the_same_in_plain_python(tmp_path: Path) -> None:
    cli.invoke(app, ["new", "cereal-bowl"])
    output = subprocess.run(
        [sys.executable, "-m", "ecume", "check", "cereal-bowl.toml", "--json"],
        cwd=tmp_path, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    here = json.loads(cli.invoke(app, ["check", "cereal-bowl.toml", "--json"]).stdout)
    measured = ("frames", "time on this machine")
    rows = [[row for row in found if row["quantity"] not in measured] for found in (json.loads(output.stdout), here)]
    assert rows[0] == rows[1]


@pytest.mark.parametrize("verb", ["check", "run"])
def test_faults_come_with_the_slips_that_may_cause_them(verb: str) -> None:
    """A remark on the key of a fault would repeat the fault."""
    cli.invoke(app, ["new", "settling"])
    done = cli.invoke(
        app, [verb, "settling.toml", "--set", "particles[0].radius=20", "--set", "liquid.temperature=1e9"]
    )
    *others, last = done.stderr.splitlines()
    assert done.exit_code == 2
    assert any("liquid.temperature: " in line for line in others)
    assert not any("liquid.temperature: got 1e+09 K, " in line for line in (*others, last))
    assert "particles[0].radius: got 20 m, more than 100 mm; plain numbers are in SI units: 20 um?" in last


def test_a_table_that_is_written_twice_is_one_fault() -> None:
    """Its keys were reported as faults of the preceding table, too."""
    cli.invoke(app, ["new", "cereal-bowl"])
    scene = Path("cereal-bowl.toml")
    scene.write_text(scene.read_text(encoding="utf-8") + "\n[dish]\nradius = 0.04\n", encoding="utf-8")
    (line,) = cli.invoke(app, ["check", str(scene)]).stderr.splitlines()
    assert "Cannot declare ('dish',) twice; expected each table once" in line
