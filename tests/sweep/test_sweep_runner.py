"""A sweep runs what is missing, wherever; what is done stays, failures are reported, and the table is the same."""

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import time
import warnings

import psutil
import pytest
from tests.sweep.four_bowls import ALONE, BOWLS
from typer.testing import CliRunner

from ecume.cli import app
from ecume.errors import SceneError, Stopped
from ecume.scenes.templates import copy_template
from ecume.sweep import open_sweep, sweep
from ecume.sweep.directory import existing_sweep, write_points
from ecume.sweep.executors import ExecutorOptions, _client, next_outcome, work
from ecume.sweep.results import Outcome
from ecume.sweep.spec import load_sweep

pytestmark = pytest.mark.sampled(2)


def table(directory):
    return (directory / "table.csv").read_text()


def test_each_point_has_a_run_and_a_row(file, tmp_path):
    done = sweep(file, tmp_path / "out", ALONE)
    assert (done.done, done.failed, done.busy) == (4, [], 0)
    rows = open_sweep(tmp_path / "out").table()
    assert [row["seed"] for row in rows] == [1, 2, 3, 4]
    assert all(row["state"] == "done" and row["max kinetic_energy"] >= row["final kinetic_energy"] > 0 for row in rows)
    assert len({row["final kinetic_energy"] for row in rows}) == 4
    assert table(tmp_path / "out").splitlines()[0] == "seed,state,final kinetic_energy (J),max kinetic_energy (J)"


def test_only_what_is_missing_is_run(file, tmp_path):
    sweep(file, tmp_path / "out", ALONE)
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("DONE.json")}
    file.write_text(BOWLS.replace("[1, 2, 3, 4]", "[2, 3, 4, 5, 6]"))
    heard = []
    assert sweep(file, tmp_path / "out", ExecutorOptions(workers=1, progress=lambda *now: heard.append(now))).done == 5
    assert heard == [(3, 5), (4, 5), (5, 5)]
    assert all(path.stat().st_mtime_ns == at for path, at in before.items())
    assert [row["seed"] for row in open_sweep(tmp_path / "out").table()] == [2, 3, 4, 5, 6]


@pytest.mark.long
def test_each_run_ends_by_the_condition_of_the_sweep(file, tmp_path):
    """Other runs are in other folders, and are kept."""
    sweep(file, tmp_path / "out", ALONE)
    rows = open_sweep(tmp_path / "out").table()
    file.write_text('until = "kinetic_energy > 0"\n' + BOWLS)
    done = sweep(file, tmp_path / "out", ALONE)
    assert done.done == len(rows)
    ends = [json.loads(path.read_text()) for path in (tmp_path / "out").rglob("DONE.json")]
    assert sorted(one.get("early", False) for one in ends) == [False] * len(rows) + [True] * len(rows)
    file.write_text('until = "kinetic_energy"\n' + BOWLS)
    with pytest.raises(SceneError, match=r"until: got 'kinetic_energy'; expected a condition such as"):
        sweep(file, tmp_path / "out", ALONE)


@pytest.mark.long
def test_many_workers_make_the_same_table(file, tmp_path):
    sweep(file, tmp_path / "alone", ALONE)
    assert sweep(file, tmp_path / "many", ExecutorOptions(workers=2)).done == 4
    assert table(tmp_path / "many") == table(tmp_path / "alone")


@pytest.mark.long
@pytest.mark.compiled  # processes: once is enough
def test_as_many_workers_of_dask_are_started_as_are_asked_for(file, tmp_path):
    with _client(ExecutorOptions(workers=3), write_points(load_sweep(file), tmp_path / "out"), 3) as client:
        assert len(client.scheduler_info(n_workers=-1)["workers"]) == 3


@pytest.mark.long
@pytest.mark.compiled  # processes: once is enough
def test_sweeps_at_the_same_time_do_not_compete_for_a_port(file, tmp_path):
    with socket.socket() as taken:
        with contextlib.suppress(OSError):  # taken already: as well
            taken.bind(("", 8787))
            taken.listen()
        with warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("always")
            with _client(ExecutorOptions(workers=2), write_points(load_sweep(file), tmp_path / "out"), 2) as client:
                assert len(client.scheduler_info(n_workers=-1)["workers"]) == 2
    assert [str(each.message) for each in heard if "Port" in str(each.message)] == []


@pytest.mark.long
def test_a_worker_that_is_killed_loses_nothing(file, tmp_path):
    file.write_text(BOWLS.replace('"0.2 s"', '"10 s"'))
    jobs = write_points(load_sweep(file), tmp_path / "out").jobs
    call = f"from ecume.sweep.executors import work; work({str(jobs[0].folder)!r})"
    with subprocess.Popen([sys.executable, "-c", call]) as worker:
        while not (jobs[0].run / "traj").exists() and worker.poll() is None:
            time.sleep(0.01)
        worker.send_signal(signal.SIGKILL)
    sweep(file, tmp_path / "out", ALONE)
    sweep(file, tmp_path / "whole", ALONE)
    assert table(tmp_path / "out") == table(tmp_path / "whole")


@pytest.mark.long
def test_workers_of_dask_may_die(file, tmp_path):
    """The first worker that begins a point is killed; its point is given to another."""
    file.write_text(BOWLS.replace('"0.2 s"', '"10 s"'))
    out = tmp_path / "out"
    call = (
        "from ecume.sweep.results import ExecutorOptions, sweep\n"
        f"if __name__ == '__main__': print(sweep({str(file)!r}, {str(out)!r}, ExecutorOptions(workers=2)).done)"
    )
    script = tmp_path / "call.py"
    script.write_text(call)
    with subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True) as sweeping:
        killed = _kill_a_worker(out, sweeping)
        reported = sweeping.communicate(timeout=200)[0]
    assert killed
    assert reported.strip() == "4"
    sweep(file, tmp_path / "alone", ALONE)
    assert table(out) == table(tmp_path / "alone")


class Answer:
    """A future of Dask that has ended: with a word, an error, or the connection's."""

    def __init__(self, word="", error=None, broken=None):
        self.word, self.error, self.broken = word, error, broken

    def cancelled(self):
        return False

    def exception(self):
        return self.error

    def result(self):
        if self.broken:
            raise self.broken
        return self.word


def test_a_scheduler_that_is_gone_is_reported_in_a_line_with_code_75():
    ended = iter([Answer("done"), Answer(error=RuntimeError("its worker died")), Answer(broken=OSError("closed"))])
    assert [next_outcome(ended)[1], next_outcome(ended)[1]] == ["done", "lost"]
    with pytest.raises(Stopped, match="lost the scheduler; finished points are kept"):
        next_outcome(ended)
    assert next_outcome(ended) is None


def test_points_that_are_lost_are_no_success(file, tmp_path, monkeypatch):
    lost = Outcome(tmp_path, 3, [], 0, lost=1)
    monkeypatch.setattr("ecume.sweep.results.sweep", lambda *_: lost)
    done = CliRunner().invoke(app, ["sweep", str(file)])
    assert done.exit_code == 75
    assert "1 of the points are missing" in done.stderr


def _kill_a_worker(out, sweeping):
    while sweeping.poll() is None:
        for lock in out.glob("points/*/run/lock"):
            try:
                pid = json.loads(lock.read_text())["pid"]
                if psutil.pid_exists(pid):
                    os.kill(pid, signal.SIGKILL)
                    return True
            except (OSError, ValueError, KeyError):
                continue
        time.sleep(0.01)
    return False


def test_failures_are_reported_and_the_rest_continues(tmp_path):
    path = tmp_path / "t1.toml"
    path.write_text('process = "t1"\n[[axes]]\nkey = "gap"\nvalues = [0.1, -1.0]\n[fixed]\nreduced_force = 1e-3')
    done = sweep(path, tmp_path / "out", ALONE)
    assert done.done == 1
    ((_, why),) = done.failed
    assert "gap" in why
    assert "\n" not in why
    assert [row["state"] for row in open_sweep(tmp_path / "out").table()] == ["done", "failed"]


def test_a_process_gives_its_own_numbers(tmp_path):
    path = tmp_path / "t1.toml"
    path.write_text('process = "t1"\n[[axes]]\nkey = "gap"\nvalues = [0.1]\n[fixed]\nreduced_force = 1e-3')
    sweep(path, tmp_path / "out", ALONE)
    (row,) = open_sweep(tmp_path / "out").table()
    assert row["outcome"] == "t1"
    assert row["duration"] == pytest.approx(24.055464, rel=1e-4)  # reference table of the process, gap 0.1, kappa 1e-3


def test_what_breaks_in_a_point_is_reported_in_a_line_and_the_rest_continues(file, tmp_path, monkeypatch):
    """A defect of ours, too: a week of other points is no price for it."""

    def breaks(job, plan, laws):
        if plan["scene"]["seed"] == 2:
            raise ZeroDivisionError("nobody\nthought of it")
        (job.folder / "result.json").write_text("{}")

    monkeypatch.setattr("ecume.sweep.executors._scene", breaks)
    monkeypatch.setattr("ecume.sweep.results.write_table", lambda sweeping: None)
    heard = []
    done = sweep(file, tmp_path / "out", ExecutorOptions(workers=1, failed=lambda *now: heard.append(now)))
    assert done.done == 3
    assert done.failed == heard
    assert heard[0][1] == "ZeroDivisionError: nobody thought of it"


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="Windows has no such signals")
@pytest.mark.parametrize(
    ("workers", "name"),
    [(1, "SIGTERM"), *(pytest.param(2, name, marks=pytest.mark.long) for name in ("SIGTERM", "SIGINT"))],
)
def test_a_signal_stops_a_sweep_that_the_same_command_goes_on_with(file, tmp_path, workers, name):
    """Ctrl-C goes to everybody, the workers among them, who are silent."""
    file.write_text(BOWLS.replace('"0.2 s"', '"20 s"'))
    command = [
        sys.executable,
        "-m",
        "ecume",
        "sweep",
        str(file),
        "-o",
        str(tmp_path / "out"),
        "--workers",
        str(workers),
    ]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True) as sweeping:
        while not list((tmp_path / "out").glob("points/*/run/scalars.jsonl")) and sweeping.poll() is None:
            time.sleep(0.01)
        time.sleep(0.3)
        os.killpg(sweeping.pid, signal.SIGINT) if name == "SIGINT" else sweeping.terminate()
        reported = sweeping.communicate(timeout=200)[1]
    assert sweeping.returncode == Stopped.exit_code
    assert f"ecume: stopped by {name}; " in reported
    assert "of 4 points are done; the same command continues" in reported
    assert "Traceback" not in reported


def test_a_run_that_another_process_holds_is_left_to_it(file, tmp_path):
    (first, *_) = write_points(load_sweep(file), tmp_path / "out").jobs
    first.run.mkdir()
    (first.run / "manifest.json").write_text('{"ecume": "0"}')
    call = (
        "import time; from pathlib import Path; from ecume.run.directory import RunDirectory as R\n"
        "from ecume.run.lock import held\n"
        f"with held(R(Path({str(first.run)!r}))): print('held', flush=True); time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", call], stdout=subprocess.PIPE, text=True) as other:
        other.stdout.readline()
        assert work(str(first.folder)) == "busy"
        other.kill()


def test_repeats_have_seeds_of_their_own(file, tmp_path):
    once = BOWLS.replace('[[axes]]\nkey = "seed"\nvalues = [1, 2, 3, 4]', "")
    file.write_text(once.replace("measures", "repeats = 3\nmeasures"))
    sweep(file, tmp_path / "out", ALONE)
    rows = open_sweep(tmp_path / "out").table()
    assert [row["repeat"] for row in rows] == [0, 1, 2]
    assert len({row["final kinetic_energy"] for row in rows}) == 3


@pytest.mark.long
def test_the_command_reports_how_it_ends(file, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    runner = CliRunner()
    done = runner.invoke(app, ["sweep", "bowls.toml", "--workers", "1"])
    assert done.exit_code == 0
    assert "sweeps/bowls: 4 points done, 0 failed" in done.stdout
    reported = runner.invoke(app, ["sweep", "sweeps/bowls", "--status"])
    assert reported.stdout == "sweeps/bowls: 4 done, 0 failed, 0 running, 0 missing\n"
    twice = runner.invoke(app, ["sweep", "bowls.toml", "--slurm", "--workers", "2"])
    assert twice.exit_code == 2
    assert "expected one of --workers" in twice.stderr
    drawn = runner.invoke(app, ["plot", "sweeps/bowls"])
    assert drawn.exit_code == 0
    assert (tmp_path / "sweeps/bowls/curves.png").exists()
    assert not (tmp_path / "sweeps/bowls/map.png").exists()
    named = runner.invoke(app, ["plot", "sweeps/bowls", "--what", "curves:max kinetic_energy"])
    assert named.stdout == "wrote sweeps/bowls/curves-max-kinetic-energy.png\n"
    assert (tmp_path / "sweeps/bowls/scatter.png").stat().st_size > 5000


def test_a_sweep_is_gone_on_with_by_its_directory_too(file, tmp_path, monkeypatch):
    """Where the file of its scene is not."""
    monkeypatch.chdir(tmp_path)
    copy_template("cereal-bowl", tmp_path / "bowl.toml")
    file.write_text(BOWLS.replace('template = "cereal-bowl"', 'scene = "bowl.toml"'))
    jobs = write_points(load_sweep(file), tmp_path / "sweeps/bowls").jobs
    work(str(jobs[0].folder))
    done = CliRunner().invoke(app, ["sweep", "sweeps/bowls", "--workers", "1"])
    assert done.exit_code == 0, done.output
    assert "4 points done" in done.stdout


def test_a_job_array_runs_each_point_once(file, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    runner = CliRunner()
    assert runner.invoke(app, ["sweep", "bowls.toml", "--array"]).exit_code == 0
    script = (tmp_path / "sweeps/bowls/array.sh").read_text()
    assert "#SBATCH --array=0-3%4" in script
    subprocess.run(["sh", "-n", "sweeps/bowls/array.sh"], check=True)
    for task in ("0/2", "1/2"):
        assert runner.invoke(app, ["sweep", "sweeps/bowls", "--task", task]).exit_code == 0
    assert {job.state for job in existing_sweep(tmp_path / "sweeps/bowls").jobs} == {"done"}
