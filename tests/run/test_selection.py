"""Runs that write some quantities only, or in single precision."""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import toy

from ecume.errors import BadInput, SceneError, Stopped
from ecume.run import RunDirectory, RunOptions, checkpoints, resume, run, runner
from ecume.run.lock import ask_to_stop
from ecume.simulation import simulate
from ecume.trajectories.reader import open_trajectory

Scenes = Callable[..., toy.ToyScene]


def test_a_run_writes_the_quantities_of_its_scene(tmp_path: Path, scene: Scenes) -> None:
    asked = scene(output={"quantities": ["species"]})
    run(asked, tmp_path / "run")
    with open_trajectory(tmp_path / "run") as trajectory:
        for here, there in zip(trajectory, simulate(asked), strict=True):
            assert list(here.arrays) == ["position", "species"]
            np.testing.assert_array_equal(here.arrays["position"], there.arrays["position"], strict=True)
            assert here.numbers == there.numbers
        assert "velocity" not in trajectory.units
        assert trajectory.scene == asked


def test_an_omitted_quantity_is_one_clear_sentence(tmp_path: Path, scene: Scenes) -> None:
    run(scene(duration=0.05, output={"quantities": ["position"]}), tmp_path / "run")
    with open_trajectory(tmp_path / "run") as trajectory:
        frame = pickle.loads(pickle.dumps(trajectory[0]))
    with pytest.raises(BadInput, match=r"no velocity, .* output\.quantities; add \"velocity\" there and run"):
        frame.arrays["velocity"]
    with pytest.raises(KeyError):
        frame.arrays["nonsense"]
    assert frame.arrays.get("velocity") is None
    part = frame.with_arrays({name: array[:2] for name, array in frame.arrays.items()})
    with pytest.raises(BadInput, match="no velocity"):
        part.arrays["velocity"]


def test_single_precision_is_read_back_within_its_rounding(tmp_path: Path, scene: Scenes) -> None:
    asked = scene(output={"precision": "single"})
    run(asked, tmp_path / "run")
    with open_trajectory(tmp_path / "run") as trajectory:
        for here, there in zip(trajectory, simulate(asked), strict=True):
            assert list(here.arrays) == list(there.arrays)
            assert here.numbers == there.numbers
            for name, array in there.arrays.items():
                assert here.arrays[name].dtype == array.dtype
                np.testing.assert_allclose(here.arrays[name], array, rtol=6e-8)
        assert (trajectory[-1].arrays["position"] != there.arrays["position"]).any()


def test_single_precision_takes_less_than_half_of_the_space(tmp_path: Path, scene: Scenes) -> None:
    sizes = []
    for precision in ("double", "single"):
        run(scene(duration=0.05, count=5000, output={"precision": precision}), tmp_path / precision)
        sizes.append(sum(path.stat().st_size for path in (tmp_path / precision / "traj").iterdir()))
    assert sizes[1] < 0.55 * sizes[0]


@pytest.mark.parametrize("output", [{"precision": "single"}, {"quantities": ["velocity"]}])
def test_a_stopped_run_is_continued_to_the_same_bytes(
    tmp_path: Path, scene: Scenes, results: Callable[..., Any], output: dict[str, Any]
) -> None:
    asked = scene(output=output)
    run(asked, tmp_path / "whole")

    def stop(progress: Any) -> None:
        if progress.frames == 20:
            ask_to_stop(os.getpid())

    with pytest.raises(Stopped):
        run(asked, tmp_path / "stopped", options=RunOptions(progress=stop))
    resume(tmp_path / "stopped")
    assert results(tmp_path / "stopped") == results(tmp_path / "whole")


def test_frames_after_the_last_checkpoint_are_compared_as_they_were_written(
    tmp_path: Path, scene: Scenes, results: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What differs by rounding to single precision only is the same frame."""
    asked = scene(output={"precision": "single", "quantities": ["radius"]})
    run(asked, tmp_path / "whole")
    with monkeypatch.context() as patch:
        patch.setattr(runner._Session, "succeed", lambda _: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            run(asked, tmp_path / "killed", options=RunOptions(checkpoint_every=1e9))
    newest = checkpoints.newest_first(RunDirectory(tmp_path / "killed"))[0]
    newest.unlink()  # as if it had been killed before: all frames are there, and the first checkpoint only
    resume(tmp_path / "killed")
    assert results(tmp_path / "killed") == results(tmp_path / "whole")


def test_unknown_names_are_refused_with_the_known_ones(tmp_path: Path, scene: Scenes) -> None:
    with pytest.raises(SceneError) as error:
        run(scene(output={"quantities": ["velocty", "position", "x"]}), tmp_path / "run")
    first, second = map(str, error.value.faults)
    assert first.startswith("output.quantities[0]: got 'velocty'; expected one of position, velocity, radius, species")
    assert first.endswith("did you mean velocity?")
    assert second.startswith("output.quantities[2]: got 'x'; expected one of position,")
    assert not (tmp_path / "run").exists()


def test_frames_are_passed_on_as_they_are_computed(tmp_path: Path, scene: Scenes) -> None:
    seen: list[tuple[str, float, int]] = []
    options = RunOptions(on_frame=lambda model, frame, step: seen.append((model, frame.time, step)))
    run(scene(duration=0.05, output={"quantities": ["radius"]}), tmp_path / "run", options=options)
    assert seen == [("toy", pytest.approx(0.01 * number), 10 * number) for number in range(6)]


def test_unknown_numbers_are_refused_before_a_run_begins(tmp_path: Path, scene: Scenes) -> None:
    with pytest.raises(BadInput, match=r"got 'energy'; expected one of kinetic_energy, pairs"):
        run(scene(), tmp_path / "run", options=RunOptions(numbers=("pairs", "energy")))
    assert not (tmp_path / "run").exists()
