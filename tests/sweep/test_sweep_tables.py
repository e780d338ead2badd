"""What a sweep tells: its table, for libraries too, and how far it is."""

import contextlib
import json
import os
import random
import shutil
import sys
import time

import numpy as np
import pytest
from tests.sweep.four_bowls import ALONE, BOWLS

from ecume.cli.progress import counted
from ecume.errors import BadInput, EcumeError, StorageError
from ecume.sweep import open_sweep, sweep
from ecume.sweep.directory import remaining, standing, write_points
from ecume.sweep.executors import write_array
from ecume.sweep.spec import load_sweep


class Frames:
    """A library of tables that keeps what it is given."""

    @staticmethod
    def DataFrame(rows, **how):  # noqa: N802  # the name that the libraries have
        return rows, how


def test_tables_of_libraries_have_nothing_where_something_is_missing(tmp_path, monkeypatch):
    path = tmp_path / "t1.toml"
    path.write_text('process = "t1"\n[[axes]]\nkey = "gap"\nvalues = [0.1, -1.0]\n[fixed]\nreduced_force = 1e-3')
    sweep(path, tmp_path / "out", ALONE)
    found = open_sweep(tmp_path / "out")
    monkeypatch.setitem(sys.modules, "polars", Frames)
    monkeypatch.setitem(sys.modules, "pandas", Frames)
    for rows, _ in (found.polars(), found.pandas()):
        assert [row["outcome"] for row in rows] == ["t1", None]
        assert [row["gap"] for row in rows] == [0.1, -1.0]
    monkeypatch.setitem(sys.modules, "polars", None)
    with pytest.raises(BadInput, match="polars is not installed"):
        found.polars()


@pytest.mark.parametrize("library", ["polars", "pandas"])
def test_libraries_take_the_table_of_a_sweep_with_failures(tmp_path, library):
    path = tmp_path / "t1.toml"
    path.write_text('process = "t1"\n[[axes]]\nkey = "gap"\nvalues = [-1.0, 0.1]\n[fixed]\nreduced_force = 1e-3')
    sweep(path, tmp_path / "out", ALONE)
    table = getattr(open_sweep(tmp_path / "out"), library)()
    assert list(table.columns)[:2] == ["gap", "state"]
    assert table["outcome"].to_list()[1] == "t1"
    assert table["duration"].mean() == pytest.approx(24.055464, rel=1e-4)


def test_an_axis_keeps_its_numbers_where_a_process_reports_them_again(tmp_path):
    path = tmp_path / "t1.toml"
    path.write_text('process = "t1"\n[[axes]]\nkey = "reduced_force"\nvalues = [1e-2]\n[fixed]\ngap = 0.1')
    (job,) = write_points(load_sweep(path), tmp_path / "out").jobs
    job.result.write_text('{"duration": 1.0, "reduced_force": 0.009999999999999998}')
    (row,) = open_sweep(tmp_path / "out").table()
    assert row["reduced_force"] == 1e-2


def test_how_far_a_sweep_is_can_be_seen_from_outside(file, tmp_path):
    jobs = write_points(load_sweep(file), tmp_path / "out").jobs
    before = time.time()
    for place, job in enumerate(jobs[:2]):
        job.run.mkdir()
        (job.run / "DONE.json").write_text("{}")
        os.utime(job.run / "DONE.json", (before - 4.0 + 2.0 * place,) * 2)
    jobs[2].failure.write_text('{"why": "it sinks"}')
    now = standing(tmp_path / "out")
    assert (now.done, now.running, now.missing) == (2, 0, 1)
    assert now.failed == [(jobs[2].folder, "it sinks")]
    assert now.remaining == pytest.approx(4.0, abs=1.0)


def test_a_pace_is_of_the_last_points_and_none_without_workers():
    assert remaining([0.0, 10.0, 20.0], waiting=4, now=22.0) == pytest.approx(44.0)
    slow_then_fast = [float(n) * 1000.0 for n in range(10)] + [9000.0 + n for n in range(1, 60)]
    assert remaining(slow_then_fast, waiting=100, now=9059.0) == pytest.approx(100.0, rel=0.05)
    assert remaining([0.0, 10.0], waiting=4, now=10_000.0) is None
    assert remaining([0.0], waiting=4, now=1.0) is None
    assert remaining([0.0, 1.0], waiting=0, now=1.0) is None


def test_words_on_the_way_are_for_logs_too(monkeypatch, capsys):
    clock = iter([0.0, 0.0, 0.0, 1.0, 1.0, 20.0, 20.0])
    monkeypatch.setattr("ecume.cli.progress.time.monotonic", lambda: next(clock))
    with counted("points", quiet=False, lines=True) as output:
        output(10, 300)
        output(11, 300)
        output(20, 300)
    assert capsys.readouterr().err == "20 of 300 points, 9.33 min left\n"
    with counted("points", quiet=False) as output:
        assert output is None


def test_measures_are_functions_too_and_are_kept(file, tmp_path, capsys):
    sweep(file, tmp_path / "out", ALONE)
    found = open_sweep(tmp_path / "out")

    def highest(run):
        print("called")
        return float(max(frame.arrays["position"].max() for frame in run))

    first = found.table({"highest": highest})
    assert found.table({"highest": highest}) == first
    assert capsys.readouterr().out.count("called") == 4
    assert all(0.0 < row["highest"] < 0.04 for row in first)


EDGES = np.array([0.0, 1.0])


@pytest.mark.long
def test_a_number_is_measured_again_where_what_its_function_uses_has_changed(file, tmp_path):
    sweep(file, tmp_path / "out", ALONE)
    found = open_sweep(tmp_path / "out")

    def edge(run):
        return float(EDGES[1])

    def unknown(run):
        return float(next(numbers))

    numbers = iter(range(100))
    assert [row["edge"] for row in found.table({"edge": edge})] == [1.0] * 4
    EDGES[1] = 2.0
    assert [row["edge"] for row in found.table({"edge": edge})] == [2.0] * 4
    first, second = (found.table({"unknown": unknown}) for _ in range(2))
    assert [row["unknown"] for row in first + second] == list(range(8))


def damaged(content, chosen):
    """With another digit, another bit, or without its end."""
    changed, way = bytearray(content), chosen.random()
    digits = [place for place, one in enumerate(content) if chr(one).isdigit()]
    if way < 0.6 and digits:
        place = chosen.choice(digits)
        changed[place] = chosen.choice([one for one in b"0123456789" if one != content[place]])
    elif way < 0.8:
        changed[chosen.randrange(len(content))] ^= 1 << chosen.randrange(8)
    else:
        del changed[chosen.randrange(len(content)) :]
    return bytes(changed)


DAMAGES = 25
"""By default; `ECUME_DAMAGES=1000` tries as many."""


@pytest.mark.long
def test_each_damage_to_a_file_of_a_sweep_is_named_or_made_again(file, tmp_path):
    """Four in five to files beside the runs; no table has another number, before or after the sweep is issued again."""
    sweep(file, tmp_path / "out", ALONE)
    truth, chosen = open_sweep(tmp_path / "out").table(), random.Random(1)
    table = (tmp_path / "out" / "table.csv").read_bytes()
    files = sorted(path for path in (tmp_path / "out").rglob("*") if path.is_file() and path.stat().st_size)
    beside = [path for path in files if "run" not in path.parts]
    names = {path.name for path in beside}
    assert names == {"points.json", "sweep.toml", "point.json", "measures.json", "table.csv"}
    for number in range(int(os.environ.get("ECUME_DAMAGES", DAMAGES))):
        home = tmp_path / f"copy{number}"
        shutil.copytree(tmp_path / "out", home)
        path = home / chosen.choice(beside if number % 5 else files).relative_to(tmp_path / "out")
        path.write_bytes(damaged(path.read_bytes(), chosen))
        with contextlib.suppress(EcumeError):
            assert open_sweep(home).table() == truth, path
        with contextlib.suppress(EcumeError):
            sweep(file, home, ALONE)
            assert open_sweep(home).table() == truth, path
            assert (home / "table.csv").read_bytes() == table, path
        shutil.rmtree(home)


@pytest.mark.long
def test_each_file_of_another_sweep_is_named_or_made_again(file, tmp_path):
    """Of a sweep of the same points with another duration."""
    sweep(file, tmp_path / "out", ALONE)
    truth = open_sweep(tmp_path / "out").table()
    file.write_text(file.read_text().replace('"0.2 s"', '"0.3 s"'))
    sweep(file, tmp_path / "other", ALONE)
    here, there = (sorted((tmp_path / name / "points").iterdir()) for name in ("out", "other"))
    for name in ("points.json", "sweep.toml"):
        before = (tmp_path / "out" / name).read_bytes()
        shutil.copy(tmp_path / "other" / name, tmp_path / "out" / name)
        with contextlib.suppress(EcumeError):
            states = open_sweep(tmp_path / "out").states()
            assert states == ["missing"] * 4 or open_sweep(tmp_path / "out").table() == truth, name
        (tmp_path / "out" / name).write_bytes(before)
    shutil.copy(there[0] / "measures.json", here[0] / "measures.json")
    assert open_sweep(tmp_path / "out").table() == truth
    shutil.rmtree(here[0] / "run")
    shutil.copytree(there[0] / "run", here[0] / "run")
    (here[0] / "measures.json").unlink()  # else no number is read from the run
    with pytest.raises(StorageError, match="is the run of another scene"):
        open_sweep(tmp_path / "out").table()


def test_each_file_of_another_point_is_named(file, tmp_path):
    sweep(file, tmp_path / "out", ALONE)
    truth = open_sweep(tmp_path / "out").table()
    points = sorted((tmp_path / "out" / "points").iterdir())
    for name in ("measures.json", "run"):
        here, there = points[0] / name, points[1] / name
        shutil.move(here, tmp_path / name)
        (shutil.copytree if there.is_dir() else shutil.copy)(there, here)
        (points[0] / "measures.json").unlink(missing_ok=name == "run")
        if name == "run":
            with pytest.raises(StorageError, match="is the run of another scene"):
                open_sweep(tmp_path / "out").table()
            shutil.rmtree(here)
        else:
            shutil.copy(points[1] / name, here)
            assert open_sweep(tmp_path / "out").table() == truth
            here.unlink()
        shutil.move(tmp_path / name, here)


def test_a_sweep_of_an_earlier_version_is_read(file, tmp_path):
    """Its files have no checksums."""
    sweep(file, tmp_path / "out", ALONE)
    truth = open_sweep(tmp_path / "out").table()
    for path in [*(tmp_path / "out").glob("points.json"), *(tmp_path / "out" / "points").glob("*/*.json")]:
        plain = json.loads(path.read_text())
        del plain["crc32"]
        path.write_text(json.dumps(plain.get("points", plain)))
    assert open_sweep(tmp_path / "out").table() == truth


def test_files_that_no_sweep_wrote_are_not_replaced(file, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "points.json").write_text("[]")
    with pytest.raises(BadInput, match="was not written by a sweep"):
        sweep(file, tmp_path / "out", ALONE)
    assert (tmp_path / "out" / "points.json").read_text() == "[]"


@pytest.mark.parametrize(
    "line",
    [
        "--output=/home/someone/.bashrc",
        "--wrap='touch X'",
        "--prolog=x",
        "-o x",
        "--account=me --output=x",
        "--error=x",
    ],
)
def test_a_sweep_asks_a_cluster_for_resources_only(file, tmp_path, line):
    """It may be anyone's: no line of it names a file or a program."""
    for given in (f'lines = ["{line}"]', 'partition = "p --output=x"'):
        file.write_text(f"{BOWLS}\n[cluster]\n{given}\n")
        with pytest.raises(BadInput, match=r"cluster\..*expected"):
            load_sweep(file)


def test_a_sweep_may_ask_a_cluster_for_an_account(file, tmp_path):
    file.write_text(f'{BOWLS}\n[cluster]\npartition = "long-1"\nlines = ["--account=me", "--gres=gpu:a100:1"]\n')
    assert load_sweep(file).spec.cluster.lines == ("--account=me", "--gres=gpu:a100:1")


def test_a_folder_with_a_line_break_gives_no_job_script(file, tmp_path):
    laid = write_points(load_sweep(file), tmp_path / "a\ntouch x\n#")
    with pytest.raises(BadInput, match="no line of a job script"):
        write_array(laid)
