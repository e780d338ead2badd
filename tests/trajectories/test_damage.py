"""Files that lost their end, or a bit."""

from __future__ import annotations

import contextlib
import os
import random
from collections.abc import Callable
from pathlib import Path

import pytest
from some_frames import same

from ecume.errors import StorageError
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import Trajectory, open_trajectory
from ecume.trajectories.segments import Recorder, repair

pytestmark = pytest.mark.sampled(2)

Frames = Callable[..., list[Frame]]
Recorded = Callable[..., Path]


@pytest.mark.long
def test_whole_frames_of_a_file_without_its_end_are_all_read(recorded: Recorded, frames: Frames) -> None:
    chance = random.Random(2)
    path, written = recorded(150) / "0000.gsd", frames(150)
    content = path.read_bytes()
    ends = [content.index(frame.arrays["neighbors"].tobytes()) for frame in written]
    kept = possible = 0
    for _ in range(60):
        size = chance.randrange(ends[1], len(content))
        path.write_bytes(content[:size])
        with open_trajectory(path.parent) as trajectory:
            assert all(same(here, there) for here, there in zip(trajectory, written, strict=False))
            kept += len(trajectory)
        possible += sum(end + 200 < size for end in ends)
    assert kept >= 0.98 * possible


def test_a_file_without_its_end_is_gone_on_with(recorded: Recorded, frames: Frames) -> None:
    path, written = recorded(150) / "0000.gsd", frames(150)
    content = path.read_bytes()
    for size in (len(content) // 3, len(content) // 2, len(content) - 1):
        path.write_bytes(content[:size])
        with Recorder(path.parent) as recorder:
            assert 10 < recorder.frames < 150
            for number in range(recorder.frames, 150):
                recorder.write(written[number], 10 * number)
        with open_trajectory(path.parent) as trajectory:
            assert all(same(here, there) for here, there in zip(trajectory, written, strict=True))


def test_each_flipped_bit_is_reported_or_changes_nothing(recorded: Recorded, frames: Frames) -> None:
    chance = random.Random(3)
    path, written = recorded(40) / "0000.gsd", frames(40)
    content = path.read_bytes()
    reported = 0
    for _ in range(150):
        damaged = bytearray(content)
        damaged[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
        path.write_bytes(damaged)
        try:
            with open_trajectory(path.parent) as trajectory:
                found = list(trajectory)
        except StorageError:
            reported += 1
            continue
        assert len(found) == 40 or _unreadable_end(path)
        assert all(same(here, there) for here, there in zip(found, written, strict=False))
    assert reported > 60


def _unreadable_end(path: Path) -> bool:
    """Only the entry of the last frame's checksum can vanish without a trace: it looks like a frame half written."""
    with Trajectory(path.parent) as trajectory:
        return len(trajectory) == 39


def test_repair_names_what_is_lost_and_keeps_the_rest(recorded: Recorded, frames: Frames) -> None:
    folder, written = recorded(60, largest=30_000), frames(60)
    first, second, last = sorted(folder.iterdir())[:2] + sorted(folder.iterdir())[-1:]
    content = bytearray(first.read_bytes())
    content[content.index(written[2].arrays["position"].tobytes()) + 5] ^= 8
    first.write_bytes(content)
    os.truncate(last, last.stat().st_size - 300)
    second.write_bytes(b"nothing" * 50)
    with pytest.raises(StorageError, match=r"0001\.gsd: not a GSD file"):
        Trajectory(folder)
    repaired = repair(folder)
    assert any("frame 2 is damaged" in fault for fault in repaired.faults)
    assert repaired.unusable == (second.with_suffix(".gsd.damaged"),)
    with Trajectory(folder) as trajectory:
        whole = []
        for number in range(len(trajectory)):
            with contextlib.suppress(StorageError):
                whole.append(same(trajectory[number], written[number]))
    assert len(whole) == repaired.good > 25
    assert all(whole)
    assert repair(folder).good == repaired.good


def test_a_missing_segment_is_missed(recorded: Recorded, frames: Frames) -> None:
    folder = recorded(60, largest=30_000)
    (folder / "0001.gsd").unlink()
    with Trajectory(folder) as trajectory:
        assert len(trajectory) == 60
        assert trajectory.intact < 60
        assert same(trajectory[0], frames(1)[0])
        with pytest.raises(StorageError, match=rf"frame {trajectory.intact} is missing"):
            trajectory[trajectory.intact]
        with pytest.raises(StorageError, match="frames are missing"):
            _ = trajectory.times


def test_a_damaged_number_is_not_plotted(recorded: Recorded, frames: Frames) -> None:
    import struct

    path = recorded(10) / "0000.gsd"
    content = bytearray(path.read_bytes())
    content[content.index(struct.pack("<d", frames(10)[4].numbers["kinetic_energy"]))] ^= 1
    path.write_bytes(content)
    with open_trajectory(path.parent) as trajectory, pytest.raises(StorageError, match="frame 4 is damaged"):
        trajectory.numbers("kinetic_energy")


@pytest.mark.parametrize("content", [b"", b"GSD", bytes(300), b"\xdfe\xdfe\xdfe\xdfe" + b"\xff" * 400])
def test_what_is_no_trajectory_is_refused_in_one_line(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "0000.gsd").write_bytes(content)
    with pytest.raises(StorageError, match=r"0000\.gsd") as raised:
        open_trajectory(tmp_path)
    assert "\n" not in str(raised.value)
