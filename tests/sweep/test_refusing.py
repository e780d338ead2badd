"""What cannot be run is refused before anything is, in the words of the sweep that asks for it."""

import json

import pytest
from tests.sweep.four_bowls import ALONE, BOWLS
from typer.testing import CliRunner

from ecume.cli import app
from ecume.errors import BadInput, SceneError, StorageError
from ecume.scenes.load import load_scene
from ecume.sweep import open_sweep, sweep
from ecume.sweep.directory import write_points
from ecume.sweep.spec import load_sweep


def test_an_argument_that_a_process_has_not_is_refused_before_anything_is_written(tmp_path):
    path = tmp_path / "t1.toml"
    path.write_text('process = "t1"\n[[axes]]\nkey = "gapp"\nvalues = [0.1]')
    with pytest.raises(BadInput, match=r"no argument 'gapp'; did you mean gap\?"):
        sweep(path, tmp_path / "out", ALONE)
    assert not (tmp_path / "out").exists()


def test_a_scene_that_is_wrong_at_one_point_is_refused_before_anything_is_written(file, tmp_path):
    file.write_text(BOWLS.replace('key = "seed"\nvalues = [1, 2, 3, 4]', 'key = "frame_every"\nvalues = [0.01, -1]'))
    with pytest.raises(BadInput, match="frame_every"):
        sweep(file, tmp_path / "out", ALONE)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("axis", "says"),
    [
        (
            'key = "liquid.viscocity"\nvalues = [1, 2]',
            "at liquid.viscocity = 1: liquid.viscocity: no such key; did you mean",
        ),
        (
            'key = "particles[7].radius"\nvalues = ["1 mm"]',
            "at particles[7].radius = '1 mm': particles is a list; expected one of it",
        ),
        (
            'key = "particles[0].count"\nspan = {start = 3, stop = 6}',
            "expected a whole number; whole = true in a span rounds",
        ),
        (
            'key = "liquid.viscosity"\nspan = {start = "1 kg", stop = "2 kg"}',
            "'kg' measures mass, expected mass / length",
        ),
        ('key = "model"\nvalues = ["sph"]', "cereal-bowl.toml: line 1, column 1: spacing: is missing"),
    ],
)
def test_a_point_that_is_no_scene_is_reported_as_the_sweep_asks_for_it(file, tmp_path, axis, says):
    file.write_text(
        BOWLS.replace('"particles[0].count" = 5\n', "").replace('key = "seed"\nvalues = [1, 2, 3, 4]', axis)
    )
    with pytest.raises(BadInput) as refused:
        sweep(file, tmp_path / "out", ALONE)
    assert str(refused.value).startswith(f"{file}: at ")
    assert says in str(refused.value)
    assert "--set" not in str(refused.value)


def test_a_number_that_runs_do_not_have_is_refused_before_anything_is_written(file, tmp_path):
    file.write_text(BOWLS.replace("final kinetic_energy", "final kinetic_enrgy"))
    with pytest.raises(BadInput, match="no number kinetic_enrgy; did you mean kinetic_energy"):
        sweep(file, tmp_path / "out", ALONE)
    assert not (tmp_path / "out").exists()


def test_tables_may_be_fixed(file, tmp_path):
    fixed = BOWLS.replace(
        '"particles[0].count" = 5', 'particles = [{count = 3, radius = "2 mm", density = 300, contact_angle = 1.2}]'
    )
    file.write_text(fixed)
    jobs = write_points(load_sweep(file), tmp_path / "out").jobs
    (floats,) = json.loads(jobs[0].asked.read_text())["scene"]["particles"]
    assert (floats["count"], floats["radius"]) == (3, 2e-3)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ('key = "gap"\nvalues = ["wide"]', "at gap = 'wide': gap: got 'wide'; expected a number"),
        ('key = "forces"\nvalues = [[1, 2, 3]]', "forces: got a list of 3; expected a list of numbers"),
        ('key = "reduced_force"\nvalues = [1e-3]', "the process t1 needs gap; add it to"),
    ],
)
def test_arguments_of_another_kind_are_refused_before_anything_is_run(tmp_path, given, says):
    path = tmp_path / "t1.toml"
    more = "" if "reduced_force" in given else "\n[fixed]\ngap = 0.1" * ("forces" in given)
    path.write_text(f'process = "t1"\n[[axes]]\n{given}{more}')
    with pytest.raises(BadInput) as refused:
        write_points(load_sweep(path), tmp_path / "out")
    assert says in str(refused.value)


@pytest.mark.long
@pytest.mark.parametrize("text", ["last kinetic_energy", "final", "first top", "final kinetic energy now"])
def test_a_measure_that_there_is_not_is_refused(file, tmp_path, text):
    sweep(file, tmp_path / "out", ALONE)
    with pytest.raises(BadInput, match="measures"):
        open_sweep(tmp_path / "out").table({"x": text})


def test_a_scene_is_no_sweep_and_a_sweep_no_scene(file, tmp_path):
    (tmp_path / "bowl.toml").write_text('model = "floating"\nduration = "1 s"')
    with pytest.raises(SceneError, match="is a scene and no sweep; `ecume run` runs it"):
        load_sweep(tmp_path / "bowl.toml")
    with pytest.raises(SceneError, match=r"is a sweep and no scene: ecume sweep .*bowls\.toml"):
        load_scene(file)


@pytest.mark.parametrize("text", ["[", '{"gap": 1}', ""])
def test_damaged_files_of_a_sweep_are_reported_in_a_line(tmp_path, text):
    path = tmp_path / "t1.toml"
    path.write_text('process = "t1"\n[[axes]]\nkey = "gap"\nvalues = [0.1]\n[fixed]\nreduced_force = 1e-3')
    (job,) = write_points(load_sweep(path), tmp_path / "out").jobs
    (tmp_path / "out" / "points.json").write_text(text)
    for verb in (["sweep", str(tmp_path / "out"), "--status"], ["plot", str(tmp_path / "out")]):
        output = CliRunner().invoke(app, verb)
        assert output.exit_code == 4
        assert "points.json: damaged" in output.stderr
        assert "sweep again: that makes it again" in output.stderr
    job.asked.write_text(text)
    (again,) = write_points(load_sweep(path), tmp_path / "out").jobs
    assert json.loads(again.asked.read_text())["settings"]["gap"] == 0.1
    job.result.write_text("3")
    with pytest.raises(StorageError, match=r"result\.json: damaged; delete it"):
        open_sweep(tmp_path / "out").table()
