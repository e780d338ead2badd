"""Sweeps of runs that LAMMPS integrates."""

import json
import os

import pytest
from tests.lammps.test_engine import in_lammps
from tests.sweep.four_bowls import ALONE, BOWLS

from ecume.errors import BadInput, SceneError
from ecume.run import info
from ecume.sweep import open_sweep, sweep
from ecume.sweep.directory import existing_sweep, write_points
from ecume.sweep.executors import write_array
from ecume.sweep.spec import load_sweep

STOKES = '[fixed]\n"hydrodynamics.drag" = "stokes"\n"hydrodynamics.added_mass" = false\n'
"""LAMMPS has no drag by Reynolds number, which the template has."""
TWO = BOWLS.replace("[1, 2, 3, 4]", "[1, 2]").replace("0.2 s", "0.02 s").replace("50 ms", "10 ms")
TWO = TWO.replace("[fixed]\n", STOKES)
LED = 'engine = "lammps"\n'


@pytest.mark.long
@in_lammps
def test_points_run_in_lammps_and_are_continued(file, tmp_path):
    file.write_text(LED + TWO)
    done = sweep(file, tmp_path / "out", ALONE)
    assert (done.done, done.failed) == (2, [])
    jobs = existing_sweep(tmp_path / "out").jobs
    assert {info(job.run).manifest["engine"] for job in jobs} == {"lammps"}
    assert all(row["max kinetic_energy"] > 0.0 for row in open_sweep(tmp_path / "out").table())
    (jobs[0].run / "DONE.json").unlink()
    assert sweep(file, tmp_path / "out", ALONE).done == 2
    assert len(info(jobs[0].run).manifest["sessions"]) == 2


@in_lammps
def test_numbers_that_lammps_does_not_compute_are_refused(file, tmp_path):
    file.write_text(LED + TWO.replace("final kinetic_energy", "final collisions"))
    with pytest.raises(BadInput, match="no number collisions"):
        sweep(file, tmp_path / "out", ALONE)


def test_points_of_another_engine_have_other_folders_but_not_those_with_other_ranks(file, tmp_path):
    folders = {}
    for name, head in (("local", ""), ("one", LED), ("two", LED + "ranks = 2\n")):
        file.write_text(head + TWO)
        jobs = write_points(load_sweep(file), tmp_path / name).jobs
        folders[name] = {job.folder.name for job in jobs}
    assert folders["one"] == folders["two"]
    assert not folders["one"] & folders["local"]
    asked = json.loads(jobs[0].asked.read_text())
    assert (asked["engine"], asked["ranks"]) == ("lammps", 2)


def test_tasks_of_an_array_have_a_core_for_each_rank(file, tmp_path):
    file.write_text(LED + "ranks = 3\n" + TWO)
    assert "--cpus-per-task=3" in write_array(write_points(load_sweep(file), tmp_path / "out")).read_text()


@pytest.mark.parametrize(
    ("head", "says"),
    [
        ("ranks = 2\n" + TWO, "ranks: expected them with engine = 'lammps' only"),
        ('engine = "mpi"\n' + TWO, "got 'mpi'; expected one of local, lammps"),
        (LED + 'process = "t1"\naxes = [{key = "gap", values = [0.1]}]', "engine: the process t1 integrates its own"),
        (
            LED + TWO.replace("cereal-bowl", "sheared-packing").replace(STOKES, "[fixed]\n"),
            "got a scene of the model soft",
        ),
        (LED + TWO.replace('key = "seed"', 'key = "interaction.method"').replace("[1, 2]", '["multipoles"]'), "LAMMPS"),
    ],
)
def test_what_lammps_cannot_simulate_is_refused_before_anything_is_written(file, tmp_path, head, says):
    file.write_text(head)
    with pytest.raises((BadInput, SceneError)) as refused:
        sweep(file, tmp_path / "out", ALONE)
    assert says in str(refused.value)
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(os.name == "nt", reason="needs scripts with an interpreter")
def test_a_missing_engine_is_reported_once(file, tmp_path, monkeypatch):
    file.write_text(LED + TWO)
    monkeypatch.setenv("ECUME_LAMMPS", str(tmp_path / "lmp"))
    with pytest.raises(BadInput, match="expected the path of an executable of LAMMPS"):
        sweep(file, tmp_path / "out", ALONE)
