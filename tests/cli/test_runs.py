"""The verbs run, resume, info and repair."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import ecume.run
from ecume._compiler_events import watch
from ecume.cli import app, progress, runs
from ecume.cli.progress import Lines, ahead, lasting, line, place, shown, waiting
from ecume.cli.runs import summary, use_at_most
from ecume.run import Progress, RunOptions, RunResult
from ecume.scenes.templates import copy_template
from ecume.simulation import Moment

cli = CliRunner()
HALF = Progress(step=50, steps=100, time=1.0, duration=2.0, frames=3, speed=4.0, steps_per_second=200.0, remaining=0.25)


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    copy_template("two-spheres", tmp_path / "beads.toml")


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Record the arguments of `ecume.run.run` instead of running."""
    calls: list[Any] = []

    def run(scene: Any, directory: Path, **options: Any) -> RunResult:
        calls.append((scene, directory, options))
        if options["options"].progress is not None:
            options["options"].progress(HALF)
        return RunResult(directory, 301, 6000, 6.0, 90.0)

    monkeypatch.setattr(ecume.run, "run", run)
    # Whatever ran before in this process: its first command would count all of its time, and set variables for Numba.
    monkeypatch.setattr(progress, "_began", [0.0])
    monkeypatch.setattr(runs, "use_at_most", lambda threads: None)
    return calls


def test_a_run_goes_to_a_directory_of_its_scenes_name(asked: list[Any]) -> None:
    done = cli.invoke(app, ["run", "beads.toml"])
    ((scene, directory, options),) = asked
    assert done.exit_code == 0
    assert done.stdout == "runs/beads: 301 frames, 6 s in 6000 steps, 90 s\n".replace("/", os.sep)
    assert (scene.title, directory) == ("Two spheres", Path("runs/beads"))
    assert options["options"].source == Path("beads.toml").read_bytes()
    assert (options["force"], options["options"].threads) == (False, None)


def test_the_options_of_a_run_reach_it(asked: list[Any]) -> None:
    words = [
        "run",
        "beads.toml",
        "-o",
        "here",
        "--set",
        "duration=1 s",
        "--set",
        "seed=3",
        "--threads",
        "2",
        "--force",
        "-q",
    ]
    done = cli.invoke(app, words)
    ((scene, directory, options),) = asked
    assert done.output == ""
    assert (scene.duration, scene.seed, directory) == (1.0, 3, Path("here"))
    assert options == {"extra_laws": [], "actions": [], "force": True, "options": RunOptions(threads=2)}


@pytest.mark.parametrize(
    "words", [["--threads", "0"], ["--threads", "x"], ["--set"], ["--set", "seed"], ["--set", "seed=-1"]]
)
def test_an_option_that_cannot_be_ends_with_two(words: list[str], asked: list[Any]) -> None:
    assert cli.invoke(app, ["run", "beads.toml", *words]).exit_code == 2
    assert not asked


def test_the_most_threads_are_set_before_numba_is_imported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    monkeypatch.delitem(sys.modules, "numba", raising=False)
    use_at_most(1000)
    assert os.environ["NUMBA_NUM_THREADS"] == "1000"
    use_at_most(None)
    assert os.environ["NUMBA_NUM_THREADS"] == "1000"


def test_a_log_gets_a_plain_line_now_and_then(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = iter([0.0, 1.0, 10.5, 11.0])
    monkeypatch.setattr("ecume.cli.progress.time.monotonic", lambda: next(clock))
    lines = Lines()
    for _ in range(3):
        lines(HALF)
    assert capsys.readouterr().err == "1 s of 2 s, 4 x real time, 0.25 s left\n"


def test_a_terminal_gets_a_bar(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("FORCE_COLOR", "1")
    with shown(quiet=False) as reported:
        assert reported is not None
        reported(HALF)
    assert "1 s of 2 s" in capsys.readouterr().err


def test_quiet_prints_nothing() -> None:
    with shown(quiet=True) as reported:
        assert reported is None


def test_wall_times_are_printed_for_readers() -> None:
    assert [lasting(seconds) for seconds in (0.25, 99.0, 240.0, 7200.0, 4e5)] == [
        "0.25 s",
        "99 s",
        "4 min",
        "2 h",
        "4.63 days",
    ]
    assert (ahead(None), ahead(240.0)) == ("", "4 min left")
    assert place(HALF._replace(speed=0.0)) == "1 s of 2 s"


@pytest.mark.parametrize("verb", ["resume", "info", "repair", "movie", "plot"])
def test_a_directory_without_a_run_is_refused(verb: str, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    for directory in ("empty", "nowhere"):
        done = cli.invoke(app, [verb, directory])
        assert done.exit_code == 2, done
        assert f"{directory}: contains no run" in done.stderr


def test_the_name_of_a_scene_or_of_the_folder_around_is_answered_with_the_runs() -> None:
    assert "beads.toml: contains no run; that is a scene" in cli.invoke(app, ["info", "beads.toml"]).stderr
    for name in ("bowl", "beads"):
        Path("runs", name).mkdir(parents=True)
        Path("runs", name, "manifest.json").touch()
    for words, says in ((["info"], "the current directory holds no run"), (["info", "runs"], "runs: contains no run")):
        reported = cli.invoke(app, words).stderr
        assert reported == f"ecume: {says}; there is {Path('runs/beads')}, {Path('runs/bowl')}\n"


@pytest.mark.long
@pytest.mark.compiled
def test_a_bead_run_is_reported_exported_and_not_replaced() -> None:
    """All verbs on a run of the real model, for a few frames."""
    words = ["run", "beads.toml", "-o", "beads", "--set", "duration=60 ms", "--quiet"]
    done = cli.invoke(app, words)
    assert done.exit_code == 0, done
    reported = cli.invoke(app, ["info", "beads"]).stdout
    assert "state       done" in reported
    assert "frames      4" in reported
    assert "model       floating" in reported
    again = cli.invoke(app, words)
    assert again.exit_code == 2
    assert "beads: holds a run already" in again.stderr
    assert cli.invoke(app, [*words, "--force"]).exit_code == 0
    assert cli.invoke(app, ["resume", "beads"]).stdout.endswith("it was complete already\n")
    assert cli.invoke(app, ["repair", "beads"]).stdout == "4 intact frames\n"
    wrote = cli.invoke(app, ["export", "beads", "--to", "csv"])
    assert wrote.exit_code == 0
    assert len(Path(wrote.stdout.split()[1]).read_text().splitlines()) == 1 + 4 * 2


@pytest.mark.long
@pytest.mark.compiled
def test_a_scene_starts_from_the_end_of_a_run() -> None:
    assert cli.invoke(app, ["run", "beads.toml", "-o", "beads", "--set", "duration=60 ms", "-q"]).exit_code == 0
    text = Path("beads.toml").read_text()
    Path("more.toml").write_text('start_from = "beads@-1"\n' + text[: text.index("[[particles]]")])
    done = cli.invoke(app, ["check", "more.toml"])
    assert done.exit_code == 0, done.stderr


def test_compilation_does_not_count_for_the_time_that_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    from ecume.run.progress import Pace

    clock = iter([0.0, 60.0, 60.5, 61.0])
    monkeypatch.setattr("ecume.run.progress.time.monotonic", lambda: next(clock))
    pace = Pace(duration=10.0)
    reported = [pace.progress(moment_at(step, 1001), 1) for step in (0, 1, 2, 101)]
    # A first half second of small steps would say a quarter of an hour.
    assert [progress.remaining for progress in reported] == [None, None, None, 9.0]
    assert [progress.begun for progress in reported] == [False, False, True, True]
    assert line(reported[2]) == "0.01998 s of 10 s, 0.02 x real time"
    assert pace.integrating == 1.0


def moment_at(step: int, steps: int) -> Moment:
    """A pause of a model of equal time steps."""
    return Moment(state=None, frame=None, step=step, steps=steps, parameters=None, taken=step, planned=steps)


def test_before_the_first_step_a_bar_says_what_is_done(monkeypatch: pytest.MonkeyPatch) -> None:
    assert waiting() == "setting up"
    monkeypatch.setattr(watch, "depth", 1)
    assert waiting() == "compiling"


def test_the_last_line_names_setup_where_it_takes_much_of_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ecume.cli.runs.elapsed", lambda: 4.5)
    monkeypatch.setattr(watch, "count", 0)
    done = RunResult(Path("here"), 11, 600, 6.0, 4.0, 0.9)
    assert summary(done) == "here: 11 frames, 6 s in 600 steps, 4.5 s (3.6 s for setup)"
    assert summary(done._replace(integrating=4.0)) == "here: 11 frames, 6 s in 600 steps, 4.5 s"
    monkeypatch.setattr(watch, "count", 3)
    assert summary(done).endswith("4.5 s (3.6 s for setup and compilation)")


def test_a_command_is_timed_from_its_start(monkeypatch: pytest.MonkeyPatch) -> None:
    now = iter([100.0, 103.5])
    monkeypatch.setattr("ecume.cli.progress.time.monotonic", lambda: next(now))
    monkeypatch.setattr("ecume.cli.progress._began", [50.0])
    progress.start()
    assert progress.elapsed() == 3.5


def test_a_total_that_is_unknown_is_not_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    assert HALF.place == "at step 50 of 100"
    assert HALF._replace(steps=None).place == "at t = 1 s (step 50)"


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.skipif(os.name == "nt", reason="Ctrl-C cannot be sent to one process alone there")
def test_ctrl_c_stops_with_a_checkpoint_and_says_how_to_go_on(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "ecume", "run", "beads.toml", "-o", "long", "--set", "duration=60000 s", "-q"]
    process = subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    patience = time.monotonic() + 200
    while not list(tmp_path.glob("long/scalars.jsonl")) and time.monotonic() < patience:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, reported = process.communicate(timeout=200)
    assert process.returncode == 75
    assert reported.startswith("ecume: stopped by SIGINT at step")
    assert reported.endswith("to continue: ecume resume long\n")
    assert list(tmp_path.glob("long/ckpt/*.npz"))


LAW = """
def push(distance, parameters):
    return 1e-9 * (4e-3 / distance) ** 2
"""


def test_the_users_laws_reach_a_run_and_neither_path_nor_text_is_kept(asked: list[Any], tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(LAW)
    assert cli.invoke(app, ["run", "beads.toml", "--laws", "mine.py"]).exit_code == 0
    ((_, _, options),) = asked
    assert [law.__name__ for law in options["extra_laws"]] == ["push"]


@pytest.mark.long
def test_a_run_with_laws_is_resumed_with_their_file_and_says_so_without(tmp_path: Path) -> None:
    """Runs as plain Python in separate processes, since compiling the time step with the law would take longer."""

    def ecume(*words: str) -> subprocess.CompletedProcess[str]:
        plain = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
        return subprocess.run([sys.executable, "-m", "ecume", *words], env=plain, capture_output=True, text=True)

    (tmp_path / "mine.py").write_text(LAW)
    words = ["--set", "duration=0.1 s", "--laws", "mine.py:push"]
    assert ecume("run", "beads.toml", "-q", *words).returncode == 0
    home = tmp_path / "runs" / "beads"
    (home / "DONE.json").unlink()
    without = cli.invoke(app, ["resume", "runs/beads"])
    assert without.exit_code == 2
    assert "ecume resume runs/beads --laws FILE.py:push" in without.stderr
    assert ecume("resume", "runs/beads", "-q", "--laws", "mine.py").returncode == 0
    kept = b"".join(path.read_bytes() for path in home.rglob("*") if path.suffix in (".json", ".jsonl", ".toml"))
    assert b"push" in kept
    assert b"mine.py" not in kept
    assert b"4e-3" not in kept


@pytest.mark.long
def test_check_names_the_users_laws_and_refuses_one_that_is_not_reciprocal(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(LAW)
    done = cli.invoke(app, ["check", "beads.toml", "--laws", "mine.py"])
    assert "user laws" in done.stdout
    assert "push" in done.stdout
    (tmp_path / "mine.py").write_text(LAW.replace("1e-9", "parameters.radius_i"))
    refused = cli.invoke(app, ["check", "beads.toml", "--laws", "mine.py"])
    assert refused.exit_code == 2
    assert "would create momentum" in refused.stderr


GRAINS = """
model = "tracers"
duration = "0.1 s"
frame_every = "0.05 s"

[[particles]]
name = "sand"
radius = "1 mm"
density = 2500
positions = [["0 mm", "0 mm"]]

[[user_laws]]
law = "lift"
species = ["sand"]
constants = [12.5]
"""
CODE = """
import ecume


def lift(position, velocity, time, parameters):
    return 0.0, parameters.constants[0]


@ecume.every(steps=5)
def stop(view):
    view.velocity *= 0.25
"""


@pytest.mark.long
@pytest.mark.compiled
def test_a_run_with_a_named_law_and_an_action_is_resumed_with_their_files(tmp_path: Path) -> None:
    (tmp_path / "grains.toml").write_text(GRAINS)
    (tmp_path / "mine.py").write_text(CODE)
    without = cli.invoke(app, ["run", "grains.toml"])
    assert without.exit_code == 2
    assert (
        "user_laws[0].law: got 'lift', a function that is not given; give its file: --laws FILE.py:lift"
        in without.stderr
    )
    own = ["--laws", "mine.py", "--actions", "mine.py"]
    checked = cli.invoke(app, ["check", "grains.toml"])
    assert "give their file with --laws" in checked.stdout
    assert cli.invoke(app, ["run", "grains.toml", "-q", *own]).exit_code == 0
    home = tmp_path / "runs" / "grains"
    (home / "DONE.json").unlink()
    without = cli.invoke(app, ["resume", "runs/grains"])
    assert without.exit_code == 2
    assert "ecume resume runs/grains --laws FILE.py:lift --actions FILE.py:stop" in without.stderr
    assert cli.invoke(app, ["resume", "runs/grains", "-q", *own]).exit_code == 0
    assert "actions" in cli.invoke(app, ["info", "runs/grains"]).stdout
    kept = b"".join(path.read_bytes() for path in home.rglob("*") if path.suffix in (".json", ".jsonl", ".toml"))
    assert b'"stop"' in kept
    assert b"mine.py" not in kept
    assert b"view.velocity" not in kept


def test_a_run_with_a_slip_of_a_unit_says_so(asked: list[Any]) -> None:
    """The remark also appears for users who do not check a scene."""
    slip = ["run", "beads.toml", "--set", "liquid.surface_tension=45"]
    text = "liquid.surface_tension: got 45 N/m, 600 times that of water; plain numbers are in SI units: 45 mN/m?"
    assert cli.invoke(app, slip).stderr.startswith(f"ecume: warning: {text}\n")
    assert cli.invoke(app, [*slip, "-q"]).stderr == ""
    assert len(asked) == 2
