"""Frames that are written come back."""

from __future__ import annotations

import math
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import gsd.fl
import gsd.hoomd
import numpy as np
import pytest
from some_frames import frame_at, same

from ecume.errors import BadInput, StorageError
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import Trajectory, open_trajectory
from ecume.trajectories.segments import Recorder

pytestmark = pytest.mark.sampled(2)

Frames = Callable[..., list[Frame]]
Recorded = Callable[..., Path]


@pytest.mark.parametrize("dimensions", [2, 3])
def test_frames_come_back_bit_for_bit(recorded: Recorded, frames: Frames, dimensions: int) -> None:
    folder = recorded(80, dimensions=dimensions)
    with open_trajectory(folder.parent) as trajectory:
        assert len(trajectory) == 80
        assert all(same(here, there) for here, there in zip(trajectory, frames(80, dimensions=dimensions), strict=True))
        assert trajectory.times.tolist() == [0.1 * number for number in range(80)]
        assert trajectory.steps.tolist() == list(range(0, 800, 10))
        energies = [frame.numbers["kinetic_energy"] for frame in frames(80)]
        assert dimensions == 3 or trajectory.numbers("kinetic_energy").tolist() == energies
        assert trajectory.units["velocity"] == "m/s"


def test_a_trajectory_is_a_sequence(recorded: Recorded, frames: Frames) -> None:
    with open_trajectory(recorded(9)) as trajectory:
        assert same(trajectory[-1], frames(9)[8])
        assert same(trajectory[-9], trajectory[0])
        assert [frame.time for frame in trajectory[2:8:3]] == [frames(9)[2].time, frames(9)[5].time]
        assert same(trajectory[::-1][1:][0], frames(9)[7])
        for outside in (9, -10):
            with pytest.raises(IndexError, match="the run has 9"):
                trajectory[outside]


def test_a_frame_owns_its_arrays(recorded: Recorded, frames: Frames) -> None:
    with open_trajectory(recorded(3)) as trajectory:
        trajectory[1].arrays["radius"][:] = 7.0
        trajectory[1].arrays["position"][:] = 7.0
        assert same(trajectory[1], frames(3)[1])
        assert same(trajectory[2], frames(3)[2])


def test_numbers_that_no_run_has_are_refused_with_those_it_has(recorded: Recorded) -> None:
    with open_trajectory(recorded(3)) as trajectory, pytest.raises(BadInput, match="contacts, kinetic_energy"):
        trajectory.numbers("kinetic")


def test_a_path_without_a_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="contains no run"):
        open_trajectory(tmp_path / "nothing")


def test_segments_hold_no_more_than_they_may(recorded: Recorded, frames: Frames) -> None:
    folder = recorded(60, largest=30_000)
    sizes = [path.stat().st_size for path in folder.iterdir()]
    assert len(sizes) > 2
    assert max(sizes) <= 30_000
    with open_trajectory(folder) as trajectory:
        assert all(same(here, there) for here, there in zip(trajectory, frames(60), strict=True))
        assert len(trajectory.numbers("contacts")) == 60


def test_what_never_changes_is_written_once(recorded: Recorded) -> None:
    with gsd.fl.open(recorded(5) / "0000.gsd", "r") as file:
        for name in ("log/particles/radius", "particles/diameter", "particles/typeid", "ecume/header"):
            assert [file.chunk_exists(number, name) for number in range(5)] == [True, False, False, False, False]
        assert all(file.chunk_exists(number, "log/particles/position") for number in range(5))


@pytest.mark.parametrize("dimensions", [2, 3])
def test_the_readers_of_hoomd_see_the_same_particles(recorded: Recorded, frames: Frames, dimensions: int) -> None:
    folder = recorded(120, dimensions=dimensions)  # enough for an index that has grown
    with gsd.hoomd.open(folder / "0000.gsd") as file:
        assert len(file) == 120
        for number in (0, 57, 119):
            seen, frame = file[number], frames(120, dimensions=dimensions)[number]
            assert (seen.configuration.step, seen.configuration.dimensions) == (10 * number, dimensions)
            np.testing.assert_array_equal(seen.particles.position[:, :dimensions], np.float32(frame.arrays["position"]))
            np.testing.assert_array_equal(seen.particles.position[:, dimensions:], 0.0)
            np.testing.assert_array_equal(seen.particles.diameter, np.float32(2 * frame.arrays["radius"]))
            np.testing.assert_array_equal(seen.particles.typeid, frame.arrays["species"])
            assert seen.particles.types == ["species 0", "species 1", "species 2"]
            assert (np.abs(seen.particles.position[:, :dimensions]) < seen.configuration.box[:dimensions] / 2).all()
            np.testing.assert_array_equal(seen.log["particles/position"], frame.arrays["position"])
            assert seen.log["kinetic_energy"] == frame.numbers["kinetic_energy"]
            assert seen.log["time"] == frame.time


@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize("strain", [0.0, 3.4])
def test_the_readers_of_hoomd_see_a_periodic_box_with_all_particles_in_it(
    tmp_path: Path, strain: float, single: bool
) -> None:
    position = np.random.default_rng(5).uniform(-3.0, 5.0, (40, 2))
    arrays = {"position": position, "radius": np.full(40, 0.1)}
    frame = Frame(0.0, arrays, {"box_width": 2.0, "box_height": 1.5, "strain": strain}, {})
    with Recorder(tmp_path, single=single) as recorder:
        recorder.write(frame, 0)
    with gsd.hoomd.open(tmp_path / "0000.gsd") as file:
        box, seen = file[0].configuration.box, file[0].particles.position[:, :2].astype(float)
    tilt = math.remainder(strain * 1.5, 2.0) / 1.5
    np.testing.assert_allclose(box, [2.0, 1.5, 1.0, tilt, 0.0, 0.0], rtol=1e-6)
    across, up = (seen[:, 0] - tilt * seen[:, 1]) / 2.0, seen[:, 1] / 1.5
    assert max(np.abs(across).max(), np.abs(up).max()) <= 0.5 + 1e-6
    # The ways between particles are the same but for copies: one box up is 1.5 strains to the right.
    moved = (seen - seen[0]) - (position - position[0])
    rows = moved[:, 1] / 1.5
    columns = (moved[:, 0] - strain * moved[:, 1]) / 2.0
    np.testing.assert_allclose([rows, columns], np.round([rows, columns]), atol=1e-5)
    (back,) = Trajectory(tmp_path)
    np.testing.assert_allclose(back.arrays["position"], position, rtol=1e-6 if single else 0.0)


def test_the_readers_of_hoomd_see_the_names_of_the_species(frames: Frames, tmp_path: Path) -> None:
    names = ["céréale", "big bead"]
    with Recorder(tmp_path, species=names) as recorder:
        recorder.write(frames(1)[0], 0)
    with Recorder(tmp_path, species=names) as recorder:
        recorder.write(frames(2)[1], 10)
    with gsd.hoomd.open(tmp_path / "0000.gsd") as file:
        assert [frame.particles.types for frame in file] == 2 * [[*names, "species 2"]]
    assert Trajectory(tmp_path).species == tuple(names)


@pytest.mark.long
def test_a_recorder_goes_on_where_another_ended(recorded: Recorded, frames: Frames, tmp_path: Path) -> None:
    folder = recorded(70)
    for number, frame in enumerate(frames(70)):
        with Recorder(tmp_path / "again", largest=2**29) as recorder:
            assert recorder.frames == number
            recorder.write(frame, 10 * number)
    assert (tmp_path / "again" / "0000.gsd").read_bytes() == (folder / "0000.gsd").read_bytes()


@pytest.mark.parametrize("kept", [0, 1, 29, 59])
def test_a_trajectory_that_is_cut_and_written_again_is_the_same(recorded: Recorded, frames: Frames, kept: int) -> None:
    folder = recorded(60, largest=30_000)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    with Recorder(folder, largest=30_000) as recorder:
        recorder.cut(kept)
        assert recorder.frames == kept
        assert len(Trajectory(folder)) == kept
        left = sum(path.stat().st_size for path in folder.iterdir())
        assert left < sum(map(len, before.values())), "what was cut away takes no room"
        for number in range(kept, 60):
            recorder.write(frames(60)[number], 10 * number)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_particles_may_come_and_go_and_numbers_may_be_anything(tmp_path: Path) -> None:
    odd = [-0.0, math.nan, math.inf, 5e-324, 0.1 + 0.2]
    written = []
    with Recorder(tmp_path) as recorder:
        for number, value in enumerate(odd):
            arrays = {"position": np.full((number, 2), value), "tensor": np.full((number, 2, 2), value)}
            written.append(Frame(value, arrays, {"value": value}, {}))
            recorder.write(written[-1], number)
    with open_trajectory(tmp_path) as trajectory:
        for here, there in zip(trajectory, written, strict=True):
            assert repr(here) == repr(there)
            assert math.copysign(1.0, here.time) == math.copysign(1.0, there.time)
        assert trajectory[4].arrays["tensor"].shape == (4, 2, 2)


def test_other_quantities_begin_another_segment(tmp_path: Path, frames: Frames) -> None:
    plain = frames(4)
    written = [*plain[:2], *(frame._replace(numbers={**frame.numbers, "rafts": 2.0}) for frame in plain[2:])]
    with Recorder(tmp_path) as recorder:
        for number, frame in enumerate(written):
            recorder.write(frame, number)
    assert len(list(tmp_path.iterdir())) == 2
    with open_trajectory(tmp_path) as trajectory:
        assert all(same(here, there) for here, there in zip(trajectory, written, strict=True))
        np.testing.assert_array_equal(trajectory.numbers("rafts"), [math.nan, math.nan, 2.0, 2.0])


@pytest.mark.parametrize("kind", [np.float32, np.int32, bool, complex])
def test_arrays_that_could_not_come_back_are_refused(tmp_path: Path, frames: Frames, kind: type) -> None:
    frame = frames(1)[0]
    with Recorder(tmp_path) as recorder, pytest.raises(BadInput, match="expected float64 or int64"):
        recorder.write(frame._replace(arrays={**frame.arrays, "mass": np.ones(6, kind)}), 0)
    assert not list(tmp_path.iterdir())


def test_reading_and_writing_frames_waits_for_no_compiler() -> None:
    code = (
        "import sys; import ecume.trajectories.reader, ecume.trajectories.segments, ecume.trajectories.exports;"
        "assert not {'numba', 'h5py', 'pydantic', 'matplotlib'} & sys.modules.keys()"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)


WRITER = """
import os, sys
from pathlib import Path
sys.path.insert(0, {here!r})
from some_frames import frame_at
from ecume.trajectories.segments import Recorder
for line in sys.stdin:
    if not (child := os.fork()):
        with Recorder(Path(line.strip()), largest=60_000) as recorder:
            while True:
                recorder.write(frame_at(recorder.frames), recorder.frames)
                os.write(1, b"%d\\n" % recorder.frames)
    os.write(1, b"pid %d\\n" % child)
    os.waitpid(child, 0)
    os.write(1, b"dead\\n")
"""


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="Windows has no fork")
def test_no_committed_frame_is_lost_when_the_writer_is_killed(tmp_path: Path) -> None:
    chance = random.Random(1)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, "-c", WRITER.format(here=str(Path(__file__).parent))]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment) as writer:
        assert writer.stdin is not None
        assert writer.stdout is not None
        committed = 0
        for _ in range(30):
            writer.stdin.write(f"{tmp_path}\n")
            writer.stdin.flush()
            child, heard = 0, 0
            until = chance.randrange(7)
            while not child or heard < until:
                said = writer.stdout.readline()
                if said.startswith("pid"):
                    child = int(said.split()[1])
                else:
                    committed, heard = int(said), heard + 1
            time.sleep(chance.uniform(0.0, 0.005))
            os.kill(child, signal.SIGKILL)
            while (said := writer.stdout.readline()) != "dead\n":
                committed = int(said)
            assert committed <= len(_frames(tmp_path)) <= committed + 1
        writer.stdin.close()
    assert committed > 40
    assert len(list(tmp_path.glob("*.gsd"))) > 1


def _frames(folder: Path) -> list[Frame]:
    """All frames, each checked."""
    try:
        with open_trajectory(folder) as trajectory:
            frames = list(trajectory)
    except BadInput:  # nothing was committed yet
        return []
    assert all(same(frame, frame_at(number)) for number, frame in enumerate(frames))
    return frames


def test_a_closed_trajectory_is_empty(recorded: Recorded) -> None:
    trajectory = open_trajectory(recorded(2))
    trajectory.close()
    assert len(trajectory) == 0


def test_damage_is_reported_with_the_frame_that_it_is_in(recorded: Recorded, frames: Frames) -> None:
    path = recorded(10) / "0000.gsd"
    content = bytearray(path.read_bytes())
    place = content.index(frames(10)[6].arrays["velocity"].tobytes())
    content[place + 17] ^= 1
    path.write_bytes(content)
    with open_trajectory(path.parent) as trajectory:
        assert same(trajectory[5], frames(10)[5])
        with pytest.raises(StorageError, match=r"0000\.gsd: frame 6 is damaged"):
            trajectory[6]
        assert len(trajectory.times) == 10
