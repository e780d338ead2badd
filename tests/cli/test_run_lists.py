"""The verbs list and compare, and output for other programs."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from ecume.cli import app
from ecume.run import compare, list_runs
from ecume.scenes.templates import copy_template

cli = CliRunner()
SCENE = """
model = "tracers"
title = "Two grains"
duration = "20 ms"
frame_every = "10 ms"

[tank]
high = ["1 cm", "1 cm"]

[[particles]]
radius = "50 um"
density = 2500
positions = [["4 mm", "5 mm"], ["6 mm", "5 mm"]]
"""


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("grains.toml").write_text(SCENE)


def made(out: str, *changes: str) -> Path:
    words = [word for change in changes for word in ("--set", change)]
    done = cli.invoke(app, ["run", "grains.toml", "-o", out, "-q", *words])
    assert done.exit_code == 0, done.output
    return Path(out)


@pytest.mark.long
@pytest.mark.compiled
def test_a_folder_lists_its_runs_and_a_damaged_one_does_not_hide_the_others() -> None:
    made("runs/one"), made("runs/deep/two", "title=Other grains")
    Path("runs/deep/two/manifest.json").write_text("{")
    Path("runs/link").symlink_to("one", target_is_directory=True)
    listed = {run.directory.as_posix(): run for run in list_runs("runs")}
    assert list(listed) == ["runs/deep/two", "runs/one"]
    assert listed["runs/deep/two"].state == "damaged"
    assert listed["runs/one"][1:4] == ("tracers", "Two grains", "done")
    assert listed["runs/one"].frames == 3
    done = cli.invoke(app, ["list"])
    assert "Two grains" in done.stdout
    assert [one["state"] for one in json.loads(cli.invoke(app, ["list", "runs", "--json"]).stdout)] == [
        "damaged",
        "done",
    ]
    assert cli.invoke(app, ["list", "nowhere"]).exit_code == 2


@pytest.mark.long
@pytest.mark.compiled
def test_two_runs_of_one_scene_are_the_same_and_two_of_others_are_not() -> None:
    one, again = made("one"), made("again")
    found = compare(one, again)
    assert found.same
    assert found == ([], [], (3, 3), 3, [])
    assert cli.invoke(app, ["compare", "one", "again"]).exit_code == 0
    other = made("other", "gravity=5", "frame_every=20 ms")
    found = compare(one, other)
    assert not found.same
    assert (found.frames, found.common) == ((3, 2), 2)
    changed = {change.name: (change.first, change.second) for change in found.scene}
    assert changed["frame_every"] == (0.01, 0.02)
    assert changed["gravity"][1] == 5.0
    position = next(row for row in found.quantities if row.name == "position")
    from ecume.trajectories.reader import open_trajectory

    with open_trajectory(one) as mine, open_trajectory(other) as theirs:
        apart = np.abs(mine[-1].arrays["position"] - theirs[-1].arrays["position"]).max()
    assert position.largest == apart > 0.0
    assert (position.unit, position.from_time) == ("m", 0.02)
    done = cli.invoke(app, ["compare", "one", "other"])
    assert done.exit_code == 1
    assert "gravity" in done.stdout
    assert "differs from" in done.stdout
    plain = json.loads(cli.invoke(app, ["compare", "one", "other", "--json"]).stdout)
    assert plain["same"] is False
    assert plain["common"] == 2


@pytest.mark.compiled
def test_a_run_with_fewer_frames_is_not_the_same() -> None:
    one = made("one")
    shutil.copytree(one, "short")
    shorter = made("shorter", "duration=10 ms")
    found = compare(one, shorter)
    assert not found.same
    assert (found.frames, found.common, found.quantities) == ((3, 2), 2, [])


@pytest.mark.compiled
def test_info_check_and_validate_print_json() -> None:
    made("one")
    info = json.loads(cli.invoke(app, ["info", "one", "--json"]).stdout)
    assert (info["state"], info["frames"], info["manifest"]["model"]) == ("done", 3, "tracers")
    rows = json.loads(cli.invoke(app, ["check", "grains.toml", "--json"]).stdout)
    assert {"quantity", "value", "remark"} == set(rows[0])
    results = json.loads(cli.invoke(app, ["validate", "kernels", "--json"]).stdout)
    assert [(one["case"], one["met"]) for one in results] == [("kernels", True)]
    assert results[0]["rows"]


def test_json_of_a_sweep_is_of_its_status() -> None:
    copy_template("t1-durations", Path("durations.toml"))
    refused = cli.invoke(app, ["sweep", "durations.toml", "--json"])
    assert refused.exit_code == 2
    assert "--json goes with --status" in refused.stderr


@pytest.mark.long
@pytest.mark.compiled
def test_runs_of_other_particle_numbers_say_so() -> None:
    made("two")
    made("one", 'particles[0].positions=[["4 mm", "5 mm"]]')
    done = cli.invoke(app, ["compare", "two", "one"])
    assert "2 and 1 particles" in done.stdout
    assert "inf" not in done.stdout.replace("first", "")
    rows = {
        row["name"]: row
        for row in json.loads(cli.invoke(app, ["compare", "two", "one", "--json"]).stdout)["quantities"]
    }
    assert rows["position"]["shapes"] == "2 and 1 particles"


def test_rounding_is_told_from_differences() -> None:
    """A force of the size of rounding noise in addition to one of 5 N is not a difference; the same number is one if it
    is the only one of its unit.
    """
    from ecume.run.reports import _differences
    from ecume.trajectories.frame import Frame

    units = {"floor_force": "N", "net_force": "N", "energy": "J"}

    def frame(**numbers: float) -> Frame:
        return Frame(0.0, {}, numbers, units)

    first = frame(floor_force=5.0, net_force=-4.4e-16, energy=1e-16)
    second = frame(floor_force=5.0 + 8.9e-16, net_force=4.4e-16, energy=3e-16)
    found = {row.name: row.rounding for row in _differences(iter([(first, second)]))}
    assert found == {"floor_force": True, "net_force": True, "energy": False}
