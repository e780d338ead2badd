"""Nothing is lost, and nothing that was changed is certified: damages and files of other runs, over all files."""

from __future__ import annotations

import contextlib
import os
import random
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import toy

from ecume import _plain_files
from ecume.cli.output import cleaned
from ecume.engine.linear_solvers.bicgstab import FEW as SOLVED_IN_THREADS
from ecume.engine.neighbors import THREADS_FROM
from ecume.engine.walls.event_driven import FEW as EVENTS_IN_THREADS
from ecume.errors import EcumeError, StorageError
from ecume.run import RunDirectory, RunOptions, compare, info, repair, resume, run, verify
from ecume.run.directory import manifest_of, read, write
from ecume.run.lock import handled
from ecume.run.research_object import write_crate
from ecume.run.user_code import entries
from ecume.scenes.load import load_scene
from ecume.simulation import simulate
from ecume.trajectories.exports import export
from ecume.trajectories.reader import open_trajectory
from ecume.trajectories.records import DONE, PARTS_OF_RUNS, identity

pytestmark = [
    pytest.mark.filterwarnings("ignore:.*damaged after the run was done"),
    pytest.mark.filterwarnings("ignore:.*constants are derived again"),
]
Scenes = Callable[..., toy.ToyScene]
OFTEN = RunOptions(checkpoint_every=0.0)
SAMPLED: dict[str, Any] = {"duration": 0.05, "output": {"samples": {"every_steps": 2, "block": 2}}}
DAMAGES = 40
"""By default; `ECUME_DAMAGES=1000` tries as many."""
NO_NUMBERS = ("lock", "log.jsonl", "status.json", "ro-crate-metadata.json", "ckpt")
"""Files that no result is read from once a run is done: they stay damaged, and named."""


@pytest.fixture(params=["done", "killed"])
def made(request: pytest.FixtureRequest, tmp_path: Path, scene: Scenes) -> RunDirectory:
    """A run with samples and metadata, completed or killed after its last checkpoint."""
    home = RunDirectory(tmp_path / "run")
    run(scene(**SAMPLED), home.path, options=OFTEN)
    write_crate(home.path)
    if request.param == "killed":
        home.done.unlink()
    return home


def files_of(path: Path) -> list[Path]:
    return sorted(each for each in path.rglob("*") if each.is_file() and each.stat().st_size)


def results_of(path: Path) -> dict[str, bytes]:
    """The files with numbers."""
    home = RunDirectory(path)
    kept = [*home.trajectory.glob("*.gsd"), home.scalars, home.samples]
    return {each.name: each.read_bytes() for each in kept}


def damaged(path: Path, chosen: random.Random) -> str:
    """Change a digit, a bit, or the end of a file; what was done."""
    content = bytearray(path.read_bytes())
    digits = [place for place, one in enumerate(content) if chr(one).isdigit()]
    way = chosen.random()
    if way < 0.5 and digits:
        place = chosen.choice(digits)
        content[place] = ord(chosen.choice([one for one in "0123456789" if ord(one) != content[place]]))
    elif way < 0.8:
        place = chosen.randrange(len(content))
        content[place] ^= 1 << chosen.randrange(8)
    else:
        place = chosen.randrange(len(content))
        content = content[:place]
    path.write_bytes(content)
    return f"{path.name} at {place}, {way:.2f}"


ORIGINS = ("manifest.json", "resolved.json", "scene.toml")
"""Files that only a copy of the user's replaces, in some cases: what a run is made of."""


def resumed_or_repaired(home: Path, what: str) -> None:
    """Resume a run, after `repair` where it asks for that. Raises EcumeError for damage to what it is made of alone."""
    try:
        resume(home)
    except EcumeError:
        if what.split(" at ")[0] in ORIGINS:
            raise
        repair(home)
        resume(home)


@pytest.mark.long
def test_each_damage_is_named_and_computed_again_or_refused(made: RunDirectory, tmp_path: Path) -> None:
    truth, chosen = results_of(made.path), random.Random(1)
    for _ in range(int(os.environ.get("ECUME_DAMAGES", DAMAGES))):
        shutil.rmtree(tmp_path / "copy", ignore_errors=True)
        shutil.copytree(made.path, tmp_path / "copy")
        what = damaged(chosen.choice(files_of(tmp_path / "copy")), chosen)
        found = verify(tmp_path / "copy")
        assert not found.sound or found.remarks or "lock at" in what or "log.jsonl at" in what, what
        with contextlib.suppress(EcumeError):
            resumed_or_repaired(tmp_path / "copy", what)
            assert results_of(tmp_path / "copy") == truth, what
            again = verify(tmp_path / "copy").faults
            assert not [fault for fault in again if not any(one in fault for one in NO_NUMBERS)], what


def test_damages_reach_each_file_that_a_run_can_have(made: RunDirectory) -> None:
    """A new kind of file is protected, or it fails here."""
    there = {path.name for path in made.path.iterdir()} | {"DONE.json", "FAILED.json", "scene.toml"}
    assert {part.name for part in (*made.parts(), made.lock)} == there


@pytest.mark.long
def test_each_file_that_is_removed_is_named(made: RunDirectory, tmp_path: Path) -> None:
    """But for the lock and what was exported, which a run can do without."""
    for path in files_of(made.path):
        name = path.relative_to(made.path)
        if name.name in ("lock", made.crate.name, "DONE.json", "status.json") or "ckpt" in name.parts:
            continue
        shutil.copytree(made.path, tmp_path / "copy")
        (tmp_path / "copy" / name).unlink()
        with contextlib.suppress(EcumeError):
            assert not verify(tmp_path / "copy").sound, name
        shutil.rmtree(tmp_path / "copy")


@pytest.mark.long
def test_each_file_of_another_run_is_named(made: RunDirectory, tmp_path: Path, scene: Scenes) -> None:
    """Another seed gives files of the same names and sizes."""
    run(scene(**SAMPLED | {"seed": 8}), tmp_path / "other", options=OFTEN)
    write_crate(tmp_path / "other")
    if not made.done.exists():
        (tmp_path / "other" / "DONE.json").unlink()
    truth = results_of(made.path)
    for path in files_of(made.path):
        name = path.relative_to(made.path)
        if name.name == "lock":
            continue
        shutil.copytree(made.path, tmp_path / "copy")
        shutil.copy(tmp_path / "other" / name, tmp_path / "copy" / name)
        if (tmp_path / "copy" / name).read_bytes() == path.read_bytes():  # both seeds give it
            shutil.rmtree(tmp_path / "copy")
            continue
        with contextlib.suppress(EcumeError):
            assert not verify(tmp_path / "copy").sound, name
            resume(tmp_path / "copy")
            assert results_of(tmp_path / "copy") == truth, name
        shutil.rmtree(tmp_path / "copy")


@pytest.mark.long
def test_frames_of_another_run_in_one_file_are_damaged(made: RunDirectory, tmp_path: Path, scene: Scenes) -> None:
    """The data of a later frame, with its checksum."""
    run(scene(**SAMPLED | {"seed": 8}), tmp_path / "other", options=OFTEN)
    mine, other = (home.trajectory / "0000.gsd" for home in (made, RunDirectory(tmp_path / "other")))
    content, foreign = mine.read_bytes(), other.read_bytes()
    assert len(content) == len(foreign)
    last = len(content) - 300
    mine.write_bytes(content[:last] + foreign[last:])
    assert not verify(made.path).sound
    with pytest.raises(StorageError, match="damaged"), open_trajectory(made.path) as trajectory:
        trajectory[len(trajectory) - 1]


def test_samples_that_were_changed_are_not_read(made: RunDirectory, tmp_path: Path) -> None:
    content = made.samples.read_bytes()
    place = content.rindex(b"\n", 0, -1) + 20
    made.samples.write_bytes(content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :])
    with pytest.raises(StorageError, match=r"samples\.csv: damaged"), open_trajectory(made.path) as trajectory:
        _ = trajectory.samples
    with pytest.raises(StorageError, match=r"samples\.csv: damaged"):
        export(made.path, "samples", tmp_path / "out.csv")


@pytest.mark.long
def test_a_run_of_an_earlier_version_is_read_and_is_not_said_to_be_protected(made: RunDirectory) -> None:
    """Without an identity, and without checksums of samples."""
    rows = len(open_trajectory(made.path).samples)
    for path in (made.done, made.failed, made.watch, made.status, made.log, made.scalars, made.sums, made.crate):
        path.unlink(missing_ok=True)
    shutil.rmtree(made.checkpoints)
    shutil.rmtree(made.trajectory)
    plain = {name: value for name, value in manifest_of(made).items() if name != "run"}
    write(made, made.manifest, plain | {"format": 2})
    resume(made.path)
    assert len(open_trajectory(made.path).samples) == rows
    found = verify(made.path)
    assert found.sound
    assert "not protected" in found.remarks[0]
    assert identity(manifest_of(made)) not in made.log.read_text()


@pytest.mark.long
def test_a_completed_run_of_an_earlier_version_computes_damaged_samples_again(made: RunDirectory) -> None:
    truth = made.samples.read_bytes()
    for path in (made.done, made.watch, made.status, made.log, made.scalars, made.sums, made.crate):
        path.unlink(missing_ok=True)
    shutil.rmtree(made.checkpoints)
    shutil.rmtree(made.trajectory)
    write(made, made.manifest, {name: value for name, value in manifest_of(made).items() if name != "run"})
    resume(made.path)
    made.samples.write_bytes(truth.replace(b"1", b"2", 9))
    with pytest.warns(UserWarning, match=r"samples\.csv: damaged after the run was done"):
        resume(made.path)
    assert made.samples.read_bytes() == truth
    assert verify(made.path).sound


@pytest.mark.long
def test_a_checksum_under_another_name_is_damage(made: RunDirectory) -> None:
    """It was taken for a file of an earlier version, which has none."""
    made.crate.write_text(made.crate.read_text().replace('"crc32"', '"crc72"'))
    assert any("ro-crate" in fault for fault in verify(made.path).faults)


@pytest.mark.long
def test_a_table_beside_no_table_is_compared(made: RunDirectory, tmp_path: Path, scene: Scenes) -> None:
    run(scene(duration=0.05, seed=8), tmp_path / "other")
    found = {change.name: (change.first, change.second) for change in compare(made.path, tmp_path / "other").scene}
    assert found["seed"] == (7, 8)
    assert found["output.samples.every_steps"] == (2, None)


EDGES = np.array([0.0, 1.0])
TABLE = {"a": [1.0, 2.0]}


class Limits:
    """What a measure may use."""

    def __init__(self, most: float) -> None:
        self.most = most


LIMITS = Limits(2.0)
OPEN: Any = iter(())


def uses_an_array(distance: float, parameters: Any) -> float:
    return float(EDGES[1]) * distance


def uses_a_table(distance: float, parameters: Any) -> float:
    return TABLE["a"][1]


def uses_an_object(distance: float, parameters: Any) -> float:
    return LIMITS.most


def uses_a_module(distance: float, parameters: Any) -> float:
    return toy.TIME_STEP * _plain_files.SPARSE


def uses_the_unknown(distance: float, parameters: Any) -> float:
    return float(OPEN is None)


def digest_of(function: Any) -> str:
    return str(entries([function])[0]["sha256"])


def test_a_digest_covers_what_a_function_uses(monkeypatch: pytest.MonkeyPatch) -> None:
    changes: list[tuple[Any, Callable[[], object]]] = [
        (uses_an_array, lambda: EDGES.__setitem__(1, EDGES[1] + 1.0)),
        (uses_a_table, lambda: TABLE["a"].append(3.0)),
        (uses_an_object, lambda: setattr(LIMITS, "most", LIMITS.most + 1.0)),
        (uses_a_module, lambda: monkeypatch.setattr(toy, "TIME_STEP", 2.0)),
        (lambda distance, parameters: max(EDGES), lambda: EDGES.__setitem__(0, EDGES[0] + 1.0)),
    ]
    for function, change in changes:
        before = digest_of(function)
        assert before == digest_of(function)
        change()
        assert before != digest_of(function), function


def test_what_no_digest_covers_is_named() -> None:
    assert entries([uses_the_unknown])[0]["uncovered"] == ["OPEN"]
    assert "uncovered" not in entries([uses_an_array])[0]


@pytest.mark.long
def test_one_trajectory_is_read_by_threads(made: RunDirectory) -> None:
    with open_trajectory(made.path) as trajectory:
        truth = [frame.arrays["position"].tobytes() for frame in trajectory]
        wrong: list[object] = []

        def reader() -> None:
            try:
                for _ in range(30):
                    wrong.extend(k for k, f in enumerate(trajectory) if f.arrays["position"].tobytes() != truth[k])
            except EcumeError as error:
                wrong.append(error)

        threads = [threading.Thread(target=reader) for _ in range(4)]
        for one in threads:
            one.start()
        for one in threads:
            one.join()
    assert not wrong


GROUPS = [("0::/job/step\n", "memory.max"), ("5:memory:/job/step\n", "memory.limit_in_bytes")]


@pytest.mark.parametrize(("groups", "name"), GROUPS)
def test_memory_is_that_of_the_control_group(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, groups: str, name: str
) -> None:
    """The least limit of the groups around a process counts; `max` is none."""
    (tmp_path / "cgroup").write_text(groups)
    (tmp_path / "job" / "step").mkdir(parents=True)
    (tmp_path / "job" / "step" / name).write_text("max\n")
    (tmp_path / "job" / name).write_text("1000000\n")
    monkeypatch.setattr(_plain_files, "GROUPS", tmp_path / "cgroup")
    kinds = dict.fromkeys(("", "memory"), (tmp_path, name))
    monkeypatch.setattr(_plain_files, "GROUP_LIMITS", kinds)
    assert _plain_files.memory_limit() == 1_000_000
    (tmp_path / "cgroup").write_text("0::/elsewhere\n5:memory:/elsewhere\n")
    assert _plain_files.memory_limit() > 1_000_000


MEMORY_GROUPS = [(Path("/sys/fs/cgroup/memory"), "memory.limit_in_bytes"), (Path("/sys/fs/cgroup"), "memory.max")]
SIZE = """
import pathlib, sys
pathlib.Path(sys.argv[1], "cgroup.procs").write_text("0")
from ecume._plain_files import memory_limit
print(memory_limit())
"""


@pytest.fixture
def real_group() -> Iterator[tuple[Path, int]]:
    """A control group of this machine with a limit, where tests may make one."""
    for above, name in MEMORY_GROUPS:
        group, limit = above / f"ecume-{os.getpid()}", 2**30
        try:
            group.mkdir()
            (group / name).write_text(str(limit))
        except OSError:
            with contextlib.suppress(OSError):
                group.rmdir()
            continue
        yield group, limit
        group.rmdir()
        return
    pytest.skip("control groups cannot be made here")


def test_memory_is_that_of_a_real_control_group(real_group: tuple[Path, int]) -> None:
    group, limit = real_group
    done = subprocess.run([sys.executable, "-c", SIZE, group], capture_output=True, text=True, check=True)
    assert int(done.stdout) == limit < _plain_files.memory_limit()


@pytest.mark.skipif(not hasattr(signal, "SIGUSR1"), reason="Windows has no such signal")
def test_a_handler_that_is_not_pythons_own_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    """As one of faulthandler, for which `getsignal` gives None."""
    monkeypatch.setattr(signal, "getsignal", lambda number: None)
    given: list[object] = []
    monkeypatch.setattr(signal, "signal", lambda *what: given.append(what))
    with handled(signal.SIG_IGN):
        pass
    assert given == []


def test_an_interrupt_while_a_session_is_noted_is_an_interrupt(
    tmp_path: Path, scene: Scenes, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("ecume.run.manifest.open_session", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run(scene(duration=0.05), tmp_path / "run")


def test_what_acts_on_a_terminal_is_removed() -> None:
    evil = "\x1b]0;x\x07\x9b31m\u202eab\u2028\u2066c\ud800\r"
    assert cleaned(evil) == "]0;x31mabc\N{REPLACEMENT CHARACTER}"


@pytest.mark.long
def test_info_survives_a_clock_that_was_set(made: RunDirectory, monkeypatch: pytest.MonkeyPatch) -> None:
    from ecume.run import lock

    if made.done.exists():
        made.done.unlink()
    made.status.unlink()
    with lock.held(made):
        owner = {**lock._self(), "began": 0.0}
        made.lock.write_bytes(lock.sealed_line(owner).encode().ljust(lock.WIDTH))
        assert info(made.path).state == "running"
    assert info(made.path).state == "killed"


def test_a_record_under_another_name_is_refused(made: RunDirectory) -> None:
    """`status.json` has all keys of `DONE.json`."""
    shutil.copy(made.status, made.done)
    with pytest.raises(StorageError, match="belongs to another run or file"):
        read(made, made.done, DONE)


def test_loops_over_threads_are_refused_after_a_fork(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where they would wait for ever; loops over few particles need no threads."""
    from ecume import _jit, _variants

    loop: Any = _jit.spread(lambda array: array.sum())
    monkeypatch.setattr(_variants, "_FORKED", [1])
    assert loop(np.ones(2)) == 2.0
    with pytest.raises(RuntimeError, match="spawn"):
        loop(np.ones(_jit.FEW))


def test_a_simulation_that_needs_threads_is_refused_after_a_fork(
    monkeypatch: pytest.MonkeyPatch, scene: Scenes
) -> None:
    """Its compiled steps call loops over threads, where Python sees none of them."""
    from ecume import _jit, _variants

    assert min(_jit.SEVERAL, _jit.FEW) == THREADS_FROM == EVENTS_IN_THREADS == SOLVED_IN_THREADS
    monkeypatch.setattr(_variants, "_FORKED", [1])
    assert len(list(simulate(scene(duration=0.02)))) == 3
    with pytest.raises(RuntimeError, match="spawn"):
        next(simulate(scene(count=_jit.SEVERAL)))
    floats = 'radius = "0.5 mm"\ndensity = 600\ncontact_angle = "70 deg"\nplacement = "lattice"\nspacing = "1.5 mm"'
    head = 'model = "floating"\nduration = "1 ms"\nframe_every = "1 ms"\n[dish]\nradius = "60 mm"\n[[particles]]\n'
    with pytest.raises(RuntimeError, match="spawn"):  # lists of neighbors are made before the first step
        next(simulate(load_scene(f"{head}count = {_jit.SEVERAL}\n{floats}\n")))


@pytest.mark.long
def test_no_export_replaces_a_file_of_a_run(made: RunDirectory, tmp_path: Path) -> None:
    """Nor one of another run, nor through a link; under any other name it is written, twice."""
    files = [path for path in made.path.rglob("*") if path.is_file()]
    before = {path: path.read_bytes() for path in files}
    assert {path.name for path in made.parts()} - {"traj", "ckpt"} == PARTS_OF_RUNS - {"lock"}
    (tmp_path / "link.csv").symlink_to(made.scene)
    for path in [*files, tmp_path / "link.csv"]:
        with pytest.raises(StorageError, match="is a file of a run, and is not replaced; expected another name"):
            export(made.path, "csv", path)
    assert {path: path.read_bytes() for path in files} == before
    for name in ("frames.csv", "results/scene.toml", "frames.csv", "traj/frames.csv", "traj/frames.csv"):
        assert export(made.path, "csv", tmp_path / "run" / name).exists()
