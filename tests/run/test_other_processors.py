"""Runs that are resumed on another processor, or with other versions of the libraries."""

from __future__ import annotations

import dataclasses
import json
import os
import signal
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import toy
from hypothesis import given
from hypothesis import strategies as st

from ecume.cli.runs import described
from ecume.errors import Stopped, StorageError
from ecume.models import MODELS
from ecume.run import RunDirectory, RunOptions, checkpoints, constants, info, manifest, repair, resume, run
from ecume.run.comparison import difference
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import Trajectory, open_trajectory

Scenes = Callable[..., toy.ToyScene]
Processor = Callable[..., None]
ROUNDING = 1e-13
SEVENTEEN = 17
"""The frame before which runs of these tests keep their last checkpoint."""


@pytest.fixture
def processor(monkeypatch: pytest.MonkeyPatch) -> Processor:
    """Moves the test to a processor with a name and a rounding of its own."""

    def move(name: str, rounding: float = 0.0) -> None:
        monkeypatch.setattr(manifest, "_processor", lambda: name)
        monkeypatch.setattr(toy, "ROUNDING", rounding)
        monkeypatch.setitem(MODELS, "toy", toy.model())

    move("A")
    return move


def as_if_killed(home: RunDirectory, saved: dict[str, bytes]) -> None:
    """Make a finished run look as if it had been killed at its end, long after it saved these checkpoints."""
    home.done.unlink()
    for path in checkpoints.newest_first(home):
        path.unlink()
    for name, content in saved.items():
        (home.checkpoints / name).write_bytes(content)


def saved_in(home: RunDirectory) -> dict[str, bytes]:
    """The checkpoints of a run."""
    return {path.name: path.read_bytes() for path in checkpoints.newest_first(home)}


def checkpoint_at(frame: int) -> Callable[[Any], None]:
    """Ask for a stop, with a checkpoint, at a frame."""

    def progress(at: Any) -> None:
        if at.step == 10 * frame:
            os.kill(os.getpid(), signal.SIGTERM)

    return progress


def left_at(scene: toy.ToyScene, path: Path, frame: int = SEVENTEEN) -> RunDirectory:
    """A run with a checkpoint at a frame, and all later frames on disk, as if it had been killed at its end."""
    home = RunDirectory(path)
    with pytest.raises(Stopped):
        run(scene, path, options=RunOptions(progress=checkpoint_at(frame)))
    saved = saved_in(home)
    resume(path)
    as_if_killed(home, saved)
    return home


def positions(path: Path) -> list[Any]:
    with open_trajectory(path) as trajectory:
        return [frame.arrays["position"].copy() for frame in trajectory]


def test_a_run_goes_on_elsewhere_and_says_once_what_changed_and_by_how_much(
    tmp_path: Path, scene: Scenes, processor: Processor
) -> None:
    home = left_at(scene(), tmp_path / "run")
    before = positions(home.path)
    processor("B", ROUNDING)
    with pytest.warns(UserWarning, match=r"frame 18 .* in position by \d\.\de-1\d m .*processor A -> B") as output:
        done = resume(home.path)
    assert len(output) == 1
    assert (done.frames, info(home.path).state) == (51, "done")
    after = positions(home.path)
    np.testing.assert_array_equal(before[: SEVENTEEN + 1], after[: SEVENTEEN + 1])
    assert not np.array_equal(before[-1], after[-1])
    np.testing.assert_allclose(before[-1], after[-1], rtol=1e-9)


def test_what_was_replaced_is_in_the_manifest_the_log_and_info(
    tmp_path: Path, scene: Scenes, processor: Processor
) -> None:
    home = left_at(scene(), tmp_path / "run")
    processor("B", ROUNDING)
    with pytest.warns(UserWarning, match="replaced"):
        resume(home.path)
    session = json.loads(home.manifest.read_text())["sessions"][-1]
    assert session["circumstances"]["processor"] == "B"
    assert (session["first_frame"], session["replaced"]["frame"]) == (SEVENTEEN + 1, SEVENTEEN + 1)
    events = [json.loads(line) for line in home.log.read_text().splitlines()]
    assert [one["changed"] for one in events if one["event"] == "frames replaced"] == [["processor A -> B"]]
    assert "from frame 18 (t = 0.18 s) on" in dict(described(info(home.path)))["replaced"]


def test_numbers_and_frames_of_a_run_that_moved_belong_together(
    tmp_path: Path, scene: Scenes, processor: Processor
) -> None:
    home = left_at(scene(), tmp_path / "run")
    processor("B", ROUNDING)
    with pytest.warns(UserWarning, match="replaced"):
        resume(home.path)
    lines = [json.loads(line) for line in home.scalars.read_text().splitlines()]
    with open_trajectory(home.path) as trajectory:
        assert [line["kinetic_energy"] for line in lines] == [one.numbers["kinetic_energy"] for one in trajectory]
        assert trajectory.steps.tolist() == [line["step"] for line in lines] == list(range(0, 501, 10))


def test_strict_refuses_other_bits_and_leaves_the_frames_alone(
    tmp_path: Path, scene: Scenes, processor: Processor
) -> None:
    home = left_at(scene(), tmp_path / "run")
    before = positions(home.path)
    processor("B", ROUNDING)
    with pytest.raises(StorageError, match=r"processor A -> B.*without --strict"):
        resume(home.path, options=RunOptions(strict=True))
    np.testing.assert_array_equal(before, positions(home.path))
    processor("B")  # another processor with the same bits
    assert resume(home.path, options=RunOptions(strict=True)).frames == 51


def test_other_bits_of_the_same_processor_and_versions_are_a_fault(
    tmp_path: Path, scene: Scenes, processor: Processor
) -> None:
    home = left_at(scene(), tmp_path / "run")
    before = positions(home.path)
    processor("A", ROUNDING)
    with pytest.raises(StorageError, match="although the processor and all versions are the same"):
        resume(home.path)
    np.testing.assert_array_equal(before, positions(home.path))


@pytest.mark.long
def test_each_frame_is_compared_with_the_processor_that_wrote_it(
    tmp_path: Path, scene: Scenes, processor: Processor
) -> None:
    home = left_at(scene(), tmp_path / "run")
    saved = saved_in(home)
    processor("B", ROUNDING)
    with pytest.warns(UserWarning, match="processor A -> B"):
        resume(home.path)
    as_if_killed(home, saved)  # all frames after the checkpoint are B's now
    processor("B", 2 * ROUNDING)
    with pytest.raises(StorageError, match="a fault in memory"):
        resume(home.path)
    processor("A")
    with pytest.warns(UserWarning, match="processor B -> A"):
        resume(home.path)


def test_moving_to_a_processor_with_the_same_bits_is_not_worth_a_word(
    tmp_path: Path, scene: Scenes, processor: Processor, results: Callable[..., Any]
) -> None:
    run(scene(), tmp_path / "one")
    home = left_at(scene(), tmp_path / "run")
    processor("B")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        resume(home.path)
    assert results(home.path) == results(tmp_path / "one")
    assert "replaced" not in dict(described(info(home.path)))


def advance_as_on_a(given: Any, state: Any, workspace: Any, steps: int) -> int:
    """Take steps without the rounding of this processor."""
    kept, toy.ROUNDING = toy.ROUNDING, 0.0
    try:
        return toy.advance(given, state, workspace, steps)
    finally:
        toy.ROUNDING = kept


def test_constants_and_start_stay_what_they_were_on_the_first_processor(
    tmp_path: Path, scene: Scenes, processor: Processor, monkeypatch: pytest.MonkeyPatch
) -> None:
    home = RunDirectory(tmp_path / "run")
    with pytest.raises(Stopped):
        run(scene(), home.path, options=RunOptions(progress=checkpoint_at(0)))
    expected = [frame.arrays["position"] for frame in simulate(scene())]
    processor("B", 1e-3)  # derives other constants, and would place the beads elsewhere
    monkeypatch.setitem(MODELS, "toy", dataclasses.replace(toy.model(), advance=advance_as_on_a))
    resume(home.path)
    np.testing.assert_array_equal(expected, positions(home.path))
    events = [json.loads(line) for line in home.log.read_text().splitlines()]
    assert any("by 1.0e-03 of its" in one["remark"] for one in events if one["event"] == "constants")


def test_damaged_constants_are_refused_until_repair_sets_them_aside(tmp_path: Path, scene: Scenes) -> None:
    home = left_at(scene(), tmp_path / "run")
    content = bytearray(home.constants.read_bytes())
    content[len(content) // 2] ^= 1
    home.constants.write_bytes(bytes(content))
    before = [home.manifest.read_bytes(), home.status.read_bytes()]
    with pytest.raises(StorageError, match=r"constants.npz: damaged.*ecume repair"):
        resume(home.path)
    assert [home.manifest.read_bytes(), home.status.read_bytes()] == before
    assert any("constants.npz" in fault for fault in repair(home.path).faults)
    with pytest.raises(StorageError, match=r"derived again.*--strict"):
        resume(home.path, options=RunOptions(strict=True))
    with pytest.warns(UserWarning, match="constants are derived again"):
        assert resume(home.path).frames == 51


def test_frames_after_a_damaged_one_are_those_of_the_processor_that_wrote_them(
    tmp_path: Path, scene: Scenes, processor: Processor, monkeypatch: pytest.MonkeyPatch
) -> None:
    home = left_at(scene(), tmp_path / "run")
    saved = saved_in(home)
    processor("B", ROUNDING)
    kept = Trajectory.__getitem__

    def damaged(self: Trajectory, index: int) -> Frame:
        if index == SEVENTEEN + 1:
            raise StorageError("frame 18 is damaged")
        return kept(self, index)

    with monkeypatch.context() as patch:
        patch.setattr(Trajectory, "__getitem__", damaged)
        resume(home.path)
    as_if_killed(home, saved)
    processor("A")
    with pytest.warns(UserWarning, match="processor B -> A"):
        resume(home.path)


class Inner(NamedTuple):
    charge: Any
    count: int


class Outer(NamedTuple):
    time_step: float
    steps_per_frame: int
    inner: Inner
    names: tuple[str, ...]
    rest: tuple[Any, ...]


numbers = st.floats(allow_nan=True, allow_infinity=True)
arrays = st.lists(numbers, max_size=5).map(np.array)
parts = st.one_of(numbers, st.complex_numbers(), st.booleans(), st.none(), st.integers(-9, 9), arrays)
trees = st.builds(
    Outer,
    st.floats(1e-9, 1e3),
    st.integers(1, 1000),
    st.builds(Inner, arrays, st.integers(0, 5)),
    st.tuples(st.text(max_size=3)),
    st.lists(parts, max_size=4).map(tuple),
)


def same(one: Any, other: Any) -> bool:
    """Whether two trees are the same in types, names and bits."""
    if type(one) is not type(other):
        return False
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, np.ndarray):
        return (one.shape, one.dtype, one.tobytes()) == (other.shape, other.dtype, other.tobytes())
    return repr(one) == repr(other)


@pytest.mark.long
@given(tree=trees)
def test_any_constants_come_back_to_the_bit(tmp_path_factory: Any, tree: Outer) -> None:
    home = RunDirectory(tmp_path_factory.mktemp("run"))
    home.manifest.write_text(json.dumps({"constants_sha256": constants.save_constants(home, tree)}))
    with np.errstate(over="ignore"):
        nudged = tree.inner._replace(charge=tree.inner.charge * (1 - 1e-12))
    nudged = tree._replace(time_step=tree.time_step * (1 + 1e-12), inner=nudged)
    assert same(constants.restored(home, nudged).parameters, tree)
    other = tree._replace(inner=tree.inner._replace(count=tree.inner.count + 1))
    kept = constants.restored(home, other)
    assert kept.parameters is other
    assert "inner.count was stored with other values" in kept.remark


@pytest.mark.parametrize("layout", ["C", "F", "strided", "read-only"])
def test_constants_keep_their_layout_in_memory(tmp_path: Path, layout: str) -> None:
    array = {
        "C": np.arange(6.0).reshape(2, 3),
        "F": np.asfortranarray(np.arange(6.0).reshape(2, 3)),
        "strided": np.arange(24.0).reshape(4, 6)[::2, ::2],
        "read-only": np.broadcast_to(np.arange(3.0), (2, 3)).copy(),
    }[layout]
    array.flags.writeable = layout != "read-only"
    home = RunDirectory(tmp_path)
    tree = Outer(0.1, 1, Inner(array, 1), (), ())
    home.manifest.write_text(json.dumps({"constants_sha256": constants.save_constants(home, tree)}))
    back = constants.restored(home, tree).parameters.inner.charge
    np.testing.assert_array_equal(back, array)
    names = ("C_CONTIGUOUS", "F_CONTIGUOUS", "WRITEABLE", "ALIGNED")
    assert [back.flags[name] for name in names] == [array.flags[name] for name in names]


@given(
    values=st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=6),
    changes=st.lists(st.sampled_from([0.0, 1e-15, 1e-9, -0.5]), min_size=6, max_size=6),
)
def test_the_difference_of_two_frames_is_that_of_the_first_quantity_that_differs(
    values: list[float], changes: list[float]
) -> None:
    one = np.array(values)
    other = one * (1.0 + np.array(changes[: len(values)]))
    frames = [
        Frame(0.0, {"species": np.arange(2), "position": array}, {"noise": noise}, {"position": "m"})
        for array, noise in ((one, 1e-19), (other, -1e-19))
    ]
    found = difference(*frames)
    assert found is not None
    if one.tobytes() == other.tobytes():
        assert (found.quantity, found.others, found.relative) == ("noise", 0, 2.0)
        assert difference(frames[0], frames[0]) is None
    else:
        apart, largest = np.abs(one - other).max(), np.abs(one).max()
        assert (found.quantity, found.unit, found.others) == ("position", "m", 1)
        assert found.size == pytest.approx(apart)
        assert found.relative == pytest.approx(apart / largest)
        assert str(found).endswith("of its largest value) and 1 more quantity")


def test_frames_of_other_shapes_or_quantities_differ_in_these() -> None:
    one, two = (Frame(0.0, {"position": np.zeros((count, 2))}, {}, {}) for count in (1, 2))
    assert str(difference(one, two)) == "position"
    assert str(difference(one, one._replace(numbers={"energy": 1.0}))) == "the names of its quantities"
