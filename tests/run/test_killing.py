"""Runs that are killed, stopped, or that find the disk full, and go on as if nothing had happened."""

from __future__ import annotations

import dataclasses
import json
import os
import random
import resource
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import toy

from ecume.errors import RunExists, Stopped, StorageError
from ecume.models import MODELS
from ecume.run import Progress, RunDirectory, RunOptions, checkpoints, info, resume, run
from ecume.trajectories.reader import open_trajectory

pytestmark = [
    pytest.mark.skipif(os.name == "nt", reason="Windows knows no SIGKILL and no limit on the size of a file"),
    pytest.mark.sampled(2),
]

Scenes = Callable[..., toy.ToyScene]
Results = Callable[[Path], dict[str, bytes]]
ASKED = {"duration": 2.0, "frame_every": 0.01, "seed": 3, "rest": 0.004}


def until(condition: Callable[[], bool], seconds: float = 20.0) -> None:
    """Wait for it."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.005)


def frames_in(directory: Path) -> int:
    """How many frames a run shows to whoever looks."""
    try:
        with open_trajectory(directory) as trajectory:
            return len(trajectory)
    except ValueError:
        return 0


@contextmanager
def files_of_at_most(size: int) -> Iterator[None]:
    """As if the disk were full as soon as a file is this large."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.long
def test_a_run_killed_ten_times_equals_one_that_was_left_alone(
    tmp_path: Path, server: Callable[..., Any], results: Results
) -> None:
    chance = random.Random(5)
    home = RunDirectory(tmp_path / "killed")
    one = server("run", home.path, ASKED, 0.05)
    until(home.manifest.exists)
    for _ in range(10):
        time.sleep(chance.uniform(0.0, 0.15))
        os.kill(one.pid, signal.SIGKILL)
        assert one.end() == -signal.SIGKILL
        assert info(home.path).state == "killed"
        one = server("resume", home.path, 0.05)
    assert one.end() == 0
    assert info(home.path).state == "done"
    run(toy.ToyScene(**ASKED), tmp_path / "left alone")
    assert results(home.path) == results(tmp_path / "left alone")


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGUSR1"])
def test_a_signal_leaves_a_checkpoint_and_says_how_to_go_on(
    tmp_path: Path, scene: Scenes, results: Results, name: str
) -> None:
    number = getattr(signal, name)
    before = signal.getsignal(number)

    def ask(progress: Progress) -> None:
        if progress.step == 130:
            os.kill(os.getpid(), number)

    with pytest.raises(
        Stopped, match=rf"stopped by {name} at step 1[34]0 of 300; to continue: ecume resume {tmp_path}/run"
    ):
        run(scene(duration=0.3), tmp_path / "run", options=RunOptions(progress=ask))
    assert signal.getsignal(number) is before
    seen = info(tmp_path / "run")
    assert (seen.state, seen.checkpoint) == ("stopped", seen.step)
    resume(tmp_path / "run")
    run(scene(duration=0.3), tmp_path / "other")
    assert results(tmp_path / "run") == results(tmp_path / "other")


@pytest.mark.parametrize("name", ["SIGTERM", "SIGUSR1"])
def test_a_signal_before_the_integration_has_begun_is_not_lost(
    tmp_path: Path, scene: Scenes, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    def slow_start(*given: Any) -> Any:
        os.kill(os.getpid(), getattr(signal, name))
        return toy.start(*given)

    monkeypatch.setitem(MODELS, "toy", dataclasses.replace(toy.model(), start=slow_start))
    with pytest.raises(Stopped, match=f"stopped by {name} at step 0 of 300"):
        run(scene(duration=0.3), tmp_path / "run")
    assert info(tmp_path / "run").checkpoint == 0


def test_a_process_that_is_asked_to_stop_ends_with_the_code_that_batch_systems_requeue(
    tmp_path: Path, server: Callable[..., Any]
) -> None:
    one = server("run", tmp_path / "run", ASKED, 60.0)
    until(lambda: frames_in(tmp_path / "run") > 5)
    os.kill(one.pid, signal.SIGTERM)
    assert one.end() == 75


def test_a_second_writer_is_refused_and_the_lock_of_a_dead_one_is_taken_over(
    tmp_path: Path, server: Callable[..., Any], scene: Scenes
) -> None:
    one = server("run", tmp_path / "run", {**ASKED, "duration": 10.0}, 0.05)
    until(lambda: frames_in(tmp_path / "run") > 5)
    assert info(tmp_path / "run").state == "running"
    with pytest.raises(RunExists, match=f"being written by process {one.pid}"):
        resume(tmp_path / "run")
    with pytest.raises(RunExists, match="being written"):
        run(scene(), tmp_path / "run", force=True)
    os.kill(one.pid, signal.SIGKILL)
    assert one.end() == -signal.SIGKILL
    run(scene(), tmp_path / "run", force=True)
    assert info(tmp_path / "run").state == "done"


@pytest.mark.long
def test_whoever_reads_while_a_run_writes_sees_whole_frames_only(tmp_path: Path, server: Callable[..., Any]) -> None:
    home = RunDirectory(tmp_path / "run")
    one = server("run", home.path, {**ASKED, "duration": 0.8, "frame_every": 0.002, "rest": 0.0}, 0.05)
    until(lambda: frames_in(home.path) > 0)
    looks = 0
    with open_trajectory(home.path) as trajectory:
        while not home.done.exists():
            count = trajectory.refresh()
            assert trajectory[count - 1].time == pytest.approx(0.002 * (count - 1))
            assert len(trajectory.times) == count
            looks += 1
        assert trajectory.refresh() == 401
    assert looks > 20
    assert one.end() == 0


@pytest.mark.long
@pytest.mark.parametrize("size", [100, 3_000, 20_000, 30_000, 40_000, 58_000])
def test_a_full_disk_is_one_line_and_keeps_every_committed_frame(
    tmp_path: Path, scene: Scenes, results: Results, size: int
) -> None:
    home, asked = RunDirectory(tmp_path / "run"), scene(duration=0.1, frame_every=0.001)
    with files_of_at_most(size), pytest.raises(StorageError, match="no room left") as raised:
        run(asked, home.path, options=RunOptions(checkpoint_every=0.02))
    assert "\n" not in str(raised.value)
    if not home.manifest.exists():
        run(asked, home.path, force=True)
    committed = frames_in(home.path)
    if committed:
        assert open_trajectory(home.path)[committed - 1].time == pytest.approx(0.001 * (committed - 1))
    resume(home.path)
    run(asked, tmp_path / "roomy")
    assert results(home.path) == results(tmp_path / "roomy")


def _interrupted(home: RunDirectory) -> None:
    """Make a finished run look as if it had been killed before it could say that it is done."""
    home.done.unlink()


@pytest.mark.parametrize("seed", range(12))
def test_a_damaged_checkpoint_is_never_used(tmp_path: Path, scene: Scenes, results: Results, seed: int) -> None:
    chance = random.Random(seed)
    home = RunDirectory(tmp_path / "run")
    run(scene(duration=0.1), home.path, options=RunOptions(checkpoint_every=0.0))
    before = results(home.path)
    _interrupted(home)
    newest, older = checkpoints.newest_first(home)
    content = bytearray(newest.read_bytes())
    if seed % 3 == 0:
        content = content[: chance.randrange(len(content))]
    else:
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    newest.write_bytes(content)
    if seed % 4 == 0:
        older.write_bytes(b"")
    resume(home.path)
    assert results(home.path) == before


def test_frames_that_were_lost_before_the_checkpoint_are_computed_again(
    tmp_path: Path, scene: Scenes, results: Results
) -> None:
    home = RunDirectory(tmp_path / "run")
    run(scene(), home.path, options=RunOptions(checkpoint_every=0.0))
    before = results(home.path)
    _interrupted(home)
    segment = home.trajectory / "0000.gsd"
    os.truncate(segment, segment.stat().st_size - 5000)
    resume(home.path)
    assert results(home.path) == before
    events = [json.loads(line)["event"] for line in home.log.read_text().splitlines()]
    assert "checkpoint set aside" in events


def test_numbers_that_were_lost_are_taken_from_the_frames(tmp_path: Path, scene: Scenes, results: Results) -> None:
    home = RunDirectory(tmp_path / "run")
    run(scene(), home.path)
    before = results(home.path)
    _interrupted(home)
    home.scalars.write_bytes(home.scalars.read_bytes()[:700])
    resume(home.path)
    assert results(home.path) == before


def test_a_frame_damaged_after_the_checkpoint_is_written_again(tmp_path: Path, scene: Scenes, results: Results) -> None:
    home = RunDirectory(tmp_path / "run")
    run(scene(), home.path)
    before = results(home.path)
    _interrupted(home)
    for path in checkpoints.newest_first(home):
        path.unlink()
    segment = home.trajectory / "0000.gsd"
    content = bytearray(segment.read_bytes())
    content[-2000] ^= 4
    segment.write_bytes(content)
    resume(home.path)
    assert results(home.path) == before
