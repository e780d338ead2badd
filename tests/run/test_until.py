"""Conditions that end a run before its duration."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import toy
from hypothesis import given
from hypothesis import strategies as st

from ecume.cli.runs import described, summary
from ecume.errors import BadInput, Stopped
from ecume.run import Progress, RunOptions, info, resume, run, verify
from ecume.run.until import Awaited, read_condition
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame

Scenes = Callable[..., toy.ToyScene]


def energies(scene: toy.ToyScene) -> list[float]:
    return [frame.numbers["kinetic_energy"] for frame in simulate(scene)]


def crossed(scene: toy.ToyScene) -> tuple[str, int]:
    """A condition that is met first in the middle of the run, and the number of frames then."""
    values = energies(scene)
    bound = float(np.median(values))
    return f"kinetic_energy > {bound!r}", next(place for place, value in enumerate(values) if value > bound) + 1


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_run_ends_at_the_first_frame_that_meets_its_condition(tmp_path: Path, scene: Scenes, seed: int) -> None:
    asked = scene(seed=seed)
    condition, frames = crossed(asked)
    done = run(asked, tmp_path / "run", options=RunOptions(until=condition))
    assert (done.early, done.frames) == (True, frames)
    assert done.until in summary(done)
    assert verify(tmp_path / "run", deep=True).sound
    assert resume(tmp_path / "run")._replace(seconds=0.0) == done._replace(seconds=0.0, integrating=None)
    assert ("ends", f"{condition}; met") in described(info(tmp_path / "run"))


@pytest.mark.parametrize("after", [1, 3])
def test_a_stopped_run_ends_where_it_would_have_ended(
    tmp_path: Path, scene: Scenes, results: Callable[..., Any], after: int
) -> None:
    condition, _ = crossed(scene())
    run(scene(), tmp_path / "whole", options=RunOptions(until=condition))

    def stopping(at: Progress) -> None:
        if at.frames == after:
            raise Stopped("enough")

    with pytest.raises(Stopped):
        run(scene(), tmp_path / "run", options=RunOptions(until=condition, progress=stopping, checkpoint_every=0.0))
    assert resume(tmp_path / "run").early
    assert results(tmp_path / "run") == results(tmp_path / "whole")


def test_a_run_that_is_damaged_afterwards_ends_there_again(tmp_path: Path, scene: Scenes) -> None:
    condition, frames = crossed(scene())
    run(scene(), tmp_path / "run", options=RunOptions(until=condition))
    shutil.copy(tmp_path / "run" / "scalars.jsonl", tmp_path)
    (tmp_path / "run" / "scalars.jsonl").write_bytes(b"")
    with pytest.warns(UserWarning, match="damaged after the run was done"):
        again = resume(tmp_path / "run")
    assert (again.early, again.frames) == (True, frames)
    assert (tmp_path / "run" / "scalars.jsonl").read_bytes() == (tmp_path / "scalars.jsonl").read_bytes()


def test_a_condition_that_is_never_met_leaves_the_duration(tmp_path: Path, scene: Scenes) -> None:
    done = run(scene(), tmp_path / "run", options=RunOptions(until="kinetic_energy < -1"))
    assert (done.early, done.frames, done.until) == (False, 51, "kinetic_energy < -1")
    assert ("ends", "kinetic_energy < -1; not met before the end") in described(info(tmp_path / "run"))


def test_a_condition_that_the_start_meets_ends_nothing_before_it_is_left(tmp_path: Path, scene: Scenes) -> None:
    """The beads start at rest."""
    bound = 0.5 * energies(scene())[1]
    done = run(scene(), tmp_path / "run", options=RunOptions(until=f"kinetic_energy < {bound!r}"))
    assert (done.early, done.frames) == (False, 51)


def test_a_condition_that_the_last_frame_meets_is_met(tmp_path: Path, scene: Scenes) -> None:
    """A warning would say otherwise."""
    condition, frames = crossed(scene())
    done = run(scene(duration=0.01 * (frames - 1)), tmp_path / "run", options=RunOptions(until=condition))
    assert (done.early, done.frames) == (True, frames)


@pytest.mark.parametrize(("condition", "answer"), [
    ("kinetic_enrgy > 1", "until: got 'kinetic_enrgy', which is no number of the frames; did you mean kinetic_energy?"),
    ("kinetic_energy", "until: got 'kinetic_energy'; expected a condition such as 'stationary"),
    ("kinetic_energy > 3 mm", "expected a condition"),
    ("stationary kinetic_energy within 2", "expected a condition"),
    ("stationary kinetic_energy within -2 %", "expected a condition"),
    ("stationary " + "a" * 100_000, "expected a condition"),
])  # fmt: skip
def test_other_conditions_are_refused_before_anything_is_written(
    tmp_path: Path, scene: Scenes, condition: str, answer: str
) -> None:
    with pytest.raises(BadInput) as refused:
        run(scene(), tmp_path / "run", options=RunOptions(until=condition))
    assert answer in str(refused.value)
    assert len(str(refused.value)) < 500
    assert not (tmp_path / "run").exists()


def ended(condition: str, values: list[float]) -> int | None:
    """The number of frames at which a series of values meets a condition."""
    awaited = Awaited(read_condition(condition))
    frames = (Frame(0.0, {}, {"stress": value}, {}) for value in values)
    return next((place + 1 for place, frame in enumerate(frames) if awaited.take(frame)), None)


@pytest.mark.parametrize(("condition", "values", "frames"), [
    ("stress < 1", [0.0, 2.0, 1.0, 0.5, 0.4], 4),
    ("stress > -1", [0.0, -2.0, -1.0, -0.5], 4),
    ("stress > 1", [2.0, 3.0], None),
    ("stress > 1", [float("nan"), 3.0], 2),
    ("stress > 1", [float("nan")] * 3, None),
])  # fmt: skip
def test_a_number_crosses_a_bound_from_one_frame_to_the_next(
    condition: str, values: list[float], frames: int | None
) -> None:
    assert ended(condition, values) == frames


@pytest.mark.long
@given(st.integers(0, 1000), st.sampled_from([10.0, 30.0, 100.0]))
def test_a_series_is_stationary_only_after_its_transient(seed: int, decay: float) -> None:
    """A transient of 20 times the noise, and noise about 1 afterwards."""
    now = np.arange(3000)
    noise = np.random.default_rng(seed).normal(size=len(now))
    values = list(1.0 + 2.0 * np.exp(-now / decay) + 0.1 * noise)
    frames = ended("stationary stress", values)
    assert frames is not None
    assert frames >= decay
    within = ended("stationary stress within 0.5 %", values)
    assert within is not None
    assert within >= frames
    assert abs(float(np.mean(values[within // 2 : within])) - 1.0) < 0.05


def test_a_series_that_drifts_is_never_stationary() -> None:
    assert ended("stationary stress", list(np.linspace(0.0, 1.0, 500))) is None
    assert ended("stationary stress", [float("nan")] * 500) is None


@pytest.mark.parametrize("value", [0.0, 3.0])
def test_a_series_that_has_not_begun_to_change_is_not_stationary(value: float) -> None:
    """A stress is zero until the first contact."""
    assert ended("stationary stress", [value] * 500) is None
    noise = np.random.default_rng(1).normal(size=2000)
    assert ended("stationary stress", [value] * 100 + list(value + 1.0 + 0.1 * noise)) is not None
