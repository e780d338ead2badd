"""Actions during a run: at fixed steps, checked, in the energy budget, and the same after a kill."""

from __future__ import annotations

import dataclasses
import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import toy

import ecume
from ecume.errors import BadInput, StorageError
from ecume.models import MODELS
from ecume.models.actions import Access, Action, View
from ecume.run import Progress, RunDirectory, RunOptions, resume, run, user_code
from ecume.simulation import simulate
from ecume.trajectories.reader import Trajectory

pytestmark = pytest.mark.sampled(2)

Scenes = Callable[..., toy.ToyScene]


@pytest.fixture(autouse=True)
def _toy_that_can_be_changed(_toy_among_the_models: None, monkeypatch: pytest.MonkeyPatch) -> None:
    def far(scene: Any, parameters: Any, state: Any) -> list[str]:
        return [f"bead {i} is outside" for i in np.flatnonzero(abs(state.position[:, 0]) > 100.0)]

    access = Access(arrays=lambda state: {"position": state.position, "velocity": state.velocity}, faults=far)
    monkeypatch.setitem(MODELS, "toy", dataclasses.replace(toy.model(), access=access))


@ecume.every(steps=7)
def damp(view: View) -> None:
    view.velocity *= 0.9


@ecume.every(time="25 ms")
def nudge(view: View) -> None:
    view.position[0] += 0.01 * view.scene.count


def steps_of(scene: Any, **period: Any) -> list[int]:
    """The steps at which an action of this period was called."""
    called = []
    list(simulate(scene, actions=[ecume.every(**period)(lambda view: called.append(view.step))]))
    return called


@pytest.mark.parametrize(
    ("period", "wanted"),
    [
        ({"steps": 30}, [30, 60, 90]),
        ({"steps": 1}, list(range(1, 101))),
        ({"time": 0.03}, [30, 60, 90]),
        ({"time": 0.0299}, [30, 60, 90]),
        ({"time": 0.0301}, [31, 61, 91]),
        ({"time": 0.05}, [50, 100]),
        ({"time": 1e-4}, list(range(1, 101))),
        ({"time": 1.0}, []),
    ],
)
def test_an_action_is_called_at_the_steps_that_are_due(
    period: dict[str, Any], wanted: list[int], scene: Scenes
) -> None:
    assert steps_of(scene(duration=0.1), **period) == wanted


def test_an_action_changes_the_state_by_what_it_writes(scene: Scenes) -> None:
    seen = []

    @ecume.every(steps=50)
    def stop(view: View) -> None:
        seen.append((view.time, view.step, view.velocity.copy(), list(view.ids)))
        view.velocity = 0.0

    frames = list(simulate(scene(duration=0.05), actions=[stop]))
    assert seen[0][:2] == (0.05, 50)
    assert seen[0][3] == [0, 1, 2, 3, 4]
    assert np.abs(seen[0][2]).max() > 0.0
    assert not frames[-1].arrays["velocity"].any()


def test_an_action_that_changes_nothing_changes_no_bit(scene: Scenes) -> None:
    def look(view: View) -> None:
        view.velocity *= 1.0
        assert view.numbers["kinetic_energy"] >= 0.0

    plain, watched = (list(simulate(scene(), actions=each)) for each in ([], [ecume.every(steps=3)(look)]))
    assert plain[-1].arrays["position"].tobytes() == watched[-1].arrays["position"].tobytes()


@pytest.mark.long
@pytest.mark.parametrize("after", [3, 49, 123, 331])
def test_a_run_that_was_stopped_ends_with_the_same_bits(after: int, tmp_path: Path, scene: Scenes) -> None:
    def refuse(progress: Progress) -> None:
        if progress.step > after:
            raise StorageError("no room")

    actions = [damp, nudge]
    run(scene(), tmp_path / "whole", actions=actions)
    with pytest.raises(StorageError, match="no room"):
        run(scene(), tmp_path / "parts", actions=actions, options=RunOptions(progress=refuse, checkpoint_every=0.0))
    resume(tmp_path / "parts", actions=actions)
    with (
        Trajectory(RunDirectory(tmp_path / "whole").trajectory) as whole,
        Trajectory(RunDirectory(tmp_path / "parts").trajectory) as parts,
    ):
        assert len(whole) == len(parts) == 51
        for name in ("position", "velocity"):
            assert whole[50].arrays[name].tobytes() == parts[50].arrays[name].tobytes()


def test_the_manifest_holds_names_digests_and_periods(tmp_path: Path, scene: Scenes) -> None:
    run(scene(), tmp_path / "run", actions=[damp, nudge])
    text = (tmp_path / "run" / "manifest.json").read_text()
    entries = json.loads(text)["actions"]
    assert [(one["name"], len(one["sha256"]), one["every"]) for one in entries] == [
        ("damp", 64, {"steps": 7}),
        ("nudge", 64, {"time": 0.025}),
    ]
    assert "test_actions" not in text


@pytest.mark.parametrize(
    ("actions", "says"),
    [
        ([], r"user-defined actions damp; .* ecume resume .* --actions FILE\.py:damp\n.*actions=\[damp\]\)"),
        ([nudge], "got the actions nudge; expected damp"),
        ([dataclasses.replace(damp, steps=8)], "damp: the text of this action, or what it uses, has changed"),
    ],
)
def test_other_actions_are_refused(actions: list[Action], says: str, tmp_path: Path, scene: Scenes) -> None:
    run(scene(), tmp_path / "run", actions=[damp])
    (tmp_path / "run" / "DONE.json").unlink()
    with pytest.raises(BadInput, match=says):
        resume(tmp_path / "run", actions=actions)


def unknown(view: View) -> None:
    view.temperature  # noqa: B018


def read_only(view: View) -> None:
    view.radius[0] = 1.0


def infinite(view: View) -> None:
    view.velocity[3, 1] /= 0.0


def outside(view: View) -> None:
    view.position[2] = 1e3


def broken(view: View) -> None:
    view.velocity[17] = 0.0


@pytest.mark.parametrize(
    ("function", "says"),
    [
        (unknown, "there is no 'temperature'; expected one of position, velocity"),
        (read_only, "read-only; positions and velocities can be changed"),
        (infinite, "velocity of particle 3 is not finite"),
        (outside, "bead 2 is outside"),
        (broken, r"line \d+: IndexError"),
    ],
)
@pytest.mark.filterwarnings("ignore:divide by zero")
def test_a_fault_of_an_action_is_one_clear_error(function: Any, says: str, scene: Scenes) -> None:
    with pytest.raises(BadInput, match=rf"^actions: {function.__name__}: at t = 0.02 s \(step 20\).*{says}"):
        list(simulate(scene(), actions=[ecume.every(steps=20)(function)]))


@pytest.mark.parametrize("period", [{}, {"steps": 3, "time": 1.0}, {"steps": 0}, {"steps": 2.5}, {"time": -1.0}])
def test_a_period_that_is_none_is_refused(period: dict[str, Any]) -> None:
    with pytest.raises(BadInput, match=r"^every: got .*; expected"):
        ecume.every(**period)


def test_a_function_without_a_period_is_refused(scene: Scenes) -> None:
    with pytest.raises(BadInput, match=r"expected a function decorated with ecume\.every"):
        next(simulate(scene(), actions=[unknown]))  # type: ignore[list-item]


FILE = """
import ecume


@ecume.every(steps=10)
def slow(view):
    view.velocity *= FACTOR


@ecume.every(time=0.1)
def stop(view):
    view.velocity = 0.0


FACTOR = 0.5


def helper(view):
    pass
"""


def test_a_file_gives_its_actions(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(FILE)
    assert [action.name for action in user_code.actions_from([str(tmp_path / "mine.py")])] == ["slow", "stop"]
    (one,) = user_code.actions_from([f"{tmp_path / 'mine.py'}:slow"])
    assert one.steps == 10
    with pytest.raises(BadInput, match="has no action 'helper'; it has slow, stop"):
        user_code.actions_from([f"{tmp_path / 'mine.py'}:helper"])


def test_an_edit_that_changes_neither_size_nor_time_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    file = tmp_path / "mine.py"
    for exponent in ("2", "3"):
        file.write_text(f"def law(distance, parameters):\n    return distance**{exponent}\n")
        os.utime(file, (1e9, 1e9))
        (law,) = user_code.laws_from([str(file)])
        assert law(2.0, None) == 2.0 ** int(exponent)
    assert list(tmp_path.iterdir()) == [file]


def test_an_action_whose_numbers_changed_is_another(tmp_path: Path) -> None:
    digests = []
    for factor in ("0.5", "0.6"):
        (tmp_path / "mine.py").write_text(FILE.replace("FACTOR = 0.5", f"FACTOR = {factor}"))
        actions = user_code.actions_from([str(tmp_path / "mine.py")])
        digests.append([one["sha256"] for one in user_code.UserCode(actions=actions).entries()["actions"]])
    assert digests[0][0] != digests[1][0]
    assert digests[0][1] == digests[1][1]
