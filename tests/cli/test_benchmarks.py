"""The verb bench, and the records of validate and bench."""

import json

import pytest
from typer.testing import CliRunner

from ecume.cli import app, comparisons
from ecume.cli.comparisons import BENCHES, PEERS, Bench
from ecume_validation import Case
from ecume_validation.runner import below, within

cli = CliRunner()


@pytest.fixture
def scripts(tmp_path, monkeypatch):
    """Small benchmarks that replace the real ones."""
    texts = {"good.py": "import sys; print('fast:', len(sys.argv) - 1)", "bad.py": "raise SystemExit(3)"}
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    asked = (
        Bench("good", "about good", "good.py", (PEERS, "--steps")),
        Bench("bad", "about bad", "bad.py"),
        Bench("lonely", "about peers", "good.py", needs=("no_such_module",)),
    )
    monkeypatch.setattr(comparisons, "BENCHES", {one.name: one for one in asked})
    monkeypatch.setattr(comparisons, "folder", lambda: tmp_path)
    monkeypatch.setattr("ecume.made_from.scripts_of", lambda package=None: tmp_path)
    return tmp_path


def test_every_benchmark_has_its_script_and_every_script_its_benchmark():
    shared = {"timed_runs.py", "versions.py"}  # the latter needs two checkouts
    assert {one.script for one in BENCHES.values()} == {
        path.name for path in comparisons.folder().glob("*.py")
    } - shared


def test_left_to_itself_it_lists_what_there_is():
    done = cli.invoke(app, ["bench"])
    assert done.exit_code == 0
    assert [line.split()[0] for line in done.stdout.splitlines()[1:]] == list(BENCHES)


def test_a_benchmark_says_what_it_measured_and_can_be_kept(scripts):
    kept = scripts / "kept.json"
    kept.write_text('{"another": {"date": "2000-01-01"}}')
    done = cli.invoke(app, ["bench", "good", "--record", str(kept)])
    assert done.exit_code == 0, done.output
    assert "fast: 2" in done.stdout
    entry = json.loads(kept.read_text())
    assert set(entry) == {"another", "good"}
    assert entry["good"]["output"] == "fast: 2\n"
    assert entry["good"]["command"] == "python benchmarks/good.py PEERS --steps"
    assert entry["good"]["date"] > "2026"


@pytest.mark.parametrize("verb", ["bench", "validate"])
@pytest.mark.parametrize(
    ("content", "name", "said"),
    [
        ("", "kept.json", "damaged: "),
        ("[1]", "kept.json", "expected a table"),
        ('{"another": {"da', "kept.json", "damaged: "),
        ("{}", "missing/kept.json", "No such file or directory"),
        ("{}", ".", "is a folder"),
        ("{}", "kept.json/kept.json", "Not a directory"),
    ],
)
def test_a_record_that_cannot_be_kept_is_refused_before_anything_is_computed(
    scripts, verb, content, name, said, monkeypatch
):
    computed = []
    case = Case("good", "about it", False, lambda: computed.append(1), "ecume_validation.kernels")
    monkeypatch.setattr("ecume_validation.CASES", {"good": case})
    (scripts / "kept.json").write_text(content)
    done = cli.invoke(app, [verb, "good", "--record", str(scripts / name)])
    assert done.exit_code == 4, done.output
    assert said in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert not computed
    assert "==" not in done.stdout
    assert (scripts / "kept.json").read_text() == content


def test_a_peer_that_is_not_installed_is_skipped_and_named(scripts):
    done = cli.invoke(app, ["bench", "lonely", "good", "--record", str(scripts / "kept.json")])
    assert done.exit_code == 0
    assert "lonely: skipped: no_such_module not installed" in done.stderr
    assert set(json.loads((scripts / "kept.json").read_text())) == {"good"}


def test_a_benchmark_that_fails_ends_with_one_and_is_not_kept(scripts):
    kept = scripts / "kept.json"
    done = cli.invoke(app, ["bench", "bad", "good", "--record", str(kept)])
    assert done.exit_code == 1
    assert "bad: failed with 3" in done.stdout
    assert set(json.loads(kept.read_text())) == {"good"}


@pytest.mark.parametrize(("given", "said"), [(["goood"], "did you mean good?"), (["good", "--all"], "either names")])
def test_what_it_cannot_do_is_reported(scripts, given, said):
    done = cli.invoke(app, ["bench", *given])
    assert done.exit_code == 2
    assert said in done.stderr


def test_a_validation_is_kept_with_what_was_met_and_what_was_not(tmp_path, monkeypatch):
    rows = [within("height", 1.0004, 1.0, 1e-3), below("speed", 2.0, 1.0)]
    monkeypatch.setattr(
        "ecume_validation.CASES", {"one": Case("one", "about one", False, lambda: rows, "ecume_validation.kernels")}
    )
    kept = tmp_path / "kept.json"
    assert cli.invoke(app, ["validate", "one", "--record", str(kept)]).exit_code == 1
    entry = json.loads(kept.read_text())["one"]
    assert [row["met"] for row in entry["rows"]] == [True, False]
    assert entry["rows"][0] == {
        "name": "height",
        "computed": "1.0004",
        "expected": "1",
        "tolerance": "0.001",
        "met": True,
    }
    assert entry["processor"]
