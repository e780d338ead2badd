"""Endings of commands: exit codes, and messages on stderr."""

from __future__ import annotations

import errno
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

import ecume.run
from ecume.cli import app
from ecume.cli.endings import INTERRUPTED, say, warned
from ecume.errors import Diverged, EcumeError, RunExists, Stopped, StorageError

cli = CliRunner()


@pytest.mark.parametrize(
    ("error", "code", "says"),
    [
        (RunExists("runs/x: holds a run already"), 2, "ecume: runs/x: holds a run already\n"),
        (Diverged("float 3 left at 1.2 s"), 3, "ecume: float 3 left at 1.2 s\n"),
        (StorageError("disk full"), 4, "ecume: disk full\n"),
        (
            Stopped("stopped; to continue: ecume resume runs/x"),
            75,
            "ecume: stopped; to continue: ecume resume runs/x\n",
        ),
        (EcumeError("odd"), 1, "ecume: odd\n"),
        (
            OSError(errno.ENOSPC, "No space left on device", "traj/0000.gsd"),
            4,
            "traj/0000.gsd: No space left on device",
        ),
        (MemoryError(), 2, "ecume: this needs more memory than the machine has\n"),
        (KeyboardInterrupt(), INTERRUPTED, "ecume: interrupted\n"),
        (StorageError("name \x1b[31mred\x07\x9b"), 4, "ecume: name [31mred\n"),
    ],
)
def test_an_error_ends_with_its_code_and_one_message(
    error: BaseException, code: int, says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(ecume.run, "resume", fails)
    done = cli.invoke(app, ["resume", "runs/x", "--engine", "local"])
    assert done.exit_code == code
    assert says in done.stderr
    assert "Traceback" not in done.output


def test_a_defect_of_ours_keeps_its_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ecume.run, "resume", lambda *_, **__: 1 / 0)
    assert isinstance(cli.invoke(app, ["resume", "runs/x", "--engine", "local"]).exception, ZeroDivisionError)


def test_a_warning_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    warned(UserWarning("the step is coarse"), UserWarning, "file.py", 3)
    assert capsys.readouterr().err == "ecume: warning: the step is coarse\n"


def command(*words: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "ecume", *words], capture_output=True, text=True, cwd=folder, timeout=60
    )


@pytest.mark.long
def test_a_process_ends_with_the_code_too(tmp_path: Path) -> None:
    (tmp_path / "bad.toml").write_text('model = "floating"\nduration = "3 kg"\nframe_every = 1\ntitel = 3\n')
    done = command("check", "bad.toml", folder=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.splitlines() == [
        "ecume: bad.toml: line 2, column 1: duration: got '3 kg'; 'kg' measures mass, expected time as in '20 s'",
        "ecume: bad.toml: line 4, column 1: titel: no such key; did you mean title?",
    ]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--nosuch"], "--nosuch: no such option; see ecume --help"),
        (["nosuch"], "nosuch: no such command; see ecume --help"),
        (["movie", "x", "--fps", "a"], "--fps: expected an integer; see ecume movie --help"),
        (["run", "a.toml", "--threads", "0"], "--threads: expected 1 or more; see ecume run --help"),
        (["run", "a", "b"], "got too many arguments: b; see ecume run --help"),
        (["fit", "a.csv"], "--scene: is missing; see ecume fit --help"),
        (["movie", "x", "--zoom"], "--zoom: expected a value; see ecume --help"),
    ],
)
def test_faults_of_the_command_line_have_the_form_of_all_messages(words: list[str], message: str) -> None:
    done = cli.invoke(app, words)
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr.replace("ecume root", "ecume") == f"ecume: {message}\n"


def test_a_choice_that_is_missing_is_one_line_with_all_choices() -> None:
    done = cli.invoke(app, ["export", "run"])
    assert done.exit_code == 2
    assert done.stderr.splitlines() == [done.stderr.rstrip("\n")]
    assert done.stderr.startswith("ecume: --to: is missing; expected one of csv, numbers, samples, xyz, ")


def test_each_line_of_a_message_has_the_prefix(capsys: pytest.CaptureFixture[str]) -> None:
    say("bad.toml: one\nbad.toml: two")
    assert capsys.readouterr().err == "ecume: bad.toml: one\necume: bad.toml: two\n"


def test_a_reader_that_leaves_early_sees_no_traceback(tmp_path: Path) -> None:
    shell = f"{sys.executable} -m ecume new | true"
    done = subprocess.run(shell, shell=True, capture_output=True, text=True, cwd=tmp_path, timeout=200)
    assert "Traceback" not in done.stderr


def test_the_version_is_that_of_the_project() -> None:
    import tomllib

    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())["project"]
    assert cli.invoke(app, ["--version"]).output == f"ecume {project['version']}\n"


def test_help_imports_nothing_heavy(tmp_path: Path) -> None:
    heavy = ("numpy", "numba", "pydantic", "pint", "matplotlib", "scipy", "gsd")
    code = f"import sys, ecume.cli; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.parametrize("verb", [None, "new", "check", "run", "resume", "info", "repair", "movie", "plot", "export"])
def test_every_verb_explains_itself_with_an_example(verb: str | None) -> None:
    done = cli.invoke(app, [*([verb] if verb else []), "--help"], terminal_width=200)
    assert done.exit_code == 0
    assert "ecume " + (verb or "new") in done.output


def test_a_misspelt_verb_is_refused() -> None:
    done = cli.invoke(app, ["rnu"])
    assert done.exit_code == 2
    assert "Did you mean 'run'" in done.stderr


def test_public_names_are_there_when_asked_for() -> None:
    import ecume

    assert all(hasattr(ecume, name) for name in ecume.__all__)
    assert set(dir(ecume)) == set(ecume.__all__)
    with pytest.raises(AttributeError, match="ecume has no simulat"):
        ecume.simulat  # noqa: B018  # the asking is the test
