"""What must hold is judged frame by frame, alike in runs that were stopped, reported in a line, and may stop a run."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import toy

from ecume.errors import BadInput, Diverged, Stopped
from ecume.models import MODELS
from ecume.models.invariants import Invariant, at_most, energy_never_rises, kept
from ecume.run import RunDirectory, RunOptions, info, resume, run
from ecume.run.invariant_monitor import Watch, budget, summary_line

Scenes = Callable[..., toy.ToyScene]
QUIET = {"kinetic_energy": 1.0, "total_energy": 5.0, "momentum_x": 2.0, "momentum_y": 0.0}


def watched(tmp_path: Path, *invariants: Invariant, policy: str = "warn") -> Watch:
    return Watch(RunDirectory(tmp_path), invariants, policy)


def energies(watch: Watch, *totals: float) -> float:
    for step, total in enumerate(totals):
        watch.take(0.1 * step, {**QUIET, "total_energy": total}, step)
    return watch.verdicts()[0].worst


def test_energy_that_falls_holds_and_any_rise_counts_from_the_least_so_far(tmp_path: Path) -> None:
    assert energies(watched(tmp_path, energy_never_rises(0.1)), 5.0, 3.0, 2.0) == 0.0
    assert energies(watched(tmp_path, energy_never_rises(0.1)), 5.0, 2.0, 3.0) == pytest.approx(1.0 / (1.0 + 3.0))


def test_the_worst_and_its_time_are_kept_when_all_is_well_again(tmp_path: Path) -> None:
    watch = watched(tmp_path, at_most("density", "its change", "density_change", 0.1))
    for step, change in enumerate((0.0, 0.3, 0.05)):
        watch.take(0.1 * step, {"density_change": change}, step)
    (verdict,) = watch.verdicts()
    assert (verdict.worst, verdict.time, verdict.held) == (0.3, 0.1, False)


def test_momentum_is_compared_with_the_start_over_its_scale(tmp_path: Path) -> None:
    watch = watched(tmp_path, kept("momentum", ("momentum_x", "momentum_y"), lambda seen: 10.0, 0.1))
    watch.take(0.0, QUIET, 0)
    assert watch.take(1.0, {**QUIET, "momentum_y": 0.5}, 1) == []
    (broken,) = watch.take(2.0, {**QUIET, "momentum_x": 5.0, "momentum_y": 4.0}, 2)
    assert broken.worst == pytest.approx(0.5)


def test_what_is_no_number_never_holds(tmp_path: Path) -> None:
    watch = watched(tmp_path, at_most("density", "its change", "density_change", 0.1))
    watch.take(0.0, {"density_change": 0.0}, 0)
    (broken,) = watch.take(1.0, {"density_change": math.nan}, 1)
    assert not broken.held


def test_dissipation_is_known_where_nothing_is_injected() -> None:
    first, now = {"total_energy": 5.0}, {"total_energy": 2.0}
    closed = budget(first, now, closed=True)
    assert (closed["injected"], closed["dissipated"], closed["change"]) == (0.0, 3.0, -3.0)
    assert budget(first, now, closed=False)["dissipated"] is None


def test_injected_work_may_raise_the_energy_and_is_not_dissipated(tmp_path: Path) -> None:
    watch = watched(tmp_path, energy_never_rises(0.1))
    for step, (total, work) in enumerate(((5.0, 0.0), (7.0, 2.5), (4.5, 2.5))):
        watch.take(0.1 * step, {**QUIET, "total_energy": total, "injected_work": work}, step)
    assert watch.verdicts()[0].worst == 0.0
    watch.take(0.3, {**QUIET, "total_energy": 5.0, "injected_work": 2.5}, 3)
    assert watch.verdicts()[0].worst == pytest.approx(0.5 / (1.0 + 3.0 + 2.5))
    output = budget({"total_energy": 5.0}, {"total_energy": 4.5, "injected_work": 2.5}, closed=True)
    assert (output["injected"], output["dissipated"]) == (2.5, 3.0)


def test_a_law_without_an_energy_has_no_line_of_it() -> None:
    from ecume.scenes.schema import from_plain

    beads = [{"radius": 1e-3, "density": 600, "contact_angle": 1.2, "count": 2}]
    common = {"model": "floating", "duration": 1.0, "frame_every": 0.1, "particles": beads, "dish": {"radius": 0.03}}
    for law, judged in (("one-sided-legacy", False), ("capillary", True)):
        scene, model = from_plain({**common, "interaction": {"law": law}}), MODELS["floating"]
        assert ("energy" in [one.name for one in model.invariants(scene, model.parameters(scene))]) == judged


def test_the_line_contains_injected_and_dissipated_energy(tmp_path: Path) -> None:
    watch = watched(tmp_path, energy_never_rises(0.1))
    for step, (total, work) in enumerate(((5.0, 0.0), (4.5, 2.5))):
        watch.take(0.1 * step, {**QUIET, "total_energy": total, "injected_work": work}, step)
    watch.keep()
    line = "held: energy (0 of 0.1); injected 2.5 J{}, dissipated 3 J"
    assert summary_line(RunDirectory(tmp_path)) == line.format("")
    watch.take(0.2, {**QUIET, "total_energy": 4.5, "injected_work": 2.5, "numerical_work": 0.5}, 2)
    watch.keep()
    assert summary_line(RunDirectory(tmp_path)) == line.format(" (0.5 J by the numerical method)")


def test_each_model_has_something_to_hold() -> None:
    import ecume

    for template in ("cereal-bowl", "taylor-green", "settling", "t1"):
        scene = ecume.load_scene(Path(ecume.__file__).parent / "templates" / f"{template}.toml")
        model = MODELS[scene.model]
        names = [one.name for one in model.invariants(scene, model.parameters(scene))]
        assert len(names) == len(set(names)) >= 1, template


@pytest.fixture
def hot(monkeypatch: pytest.MonkeyPatch) -> None:
    """A toy whose kinetic energy must stay below a limit that it leaves at about t = 0.1 s."""
    limit = Invariant("heat", "the kinetic energy", 0.02, lambda seen: seen.now["kinetic_energy"])
    monkeypatch.setitem(MODELS, "toy", dataclasses.replace(toy.model(), invariants=lambda *_: [limit]))


@pytest.mark.usefixtures("hot")
def test_a_run_that_breaks_an_invariant_says_so_and_goes_on(tmp_path: Path, scene: Scenes) -> None:
    run(scene(), tmp_path / "run")
    seen = info(tmp_path / "run")
    assert seen.state == "done"
    assert seen.watch.startswith("broken: heat (")
    events = [json.loads(line) for line in (tmp_path / "run" / "log.jsonl").read_text().splitlines()]
    assert sum(event["event"] == "broken" for event in events) == 1


@pytest.mark.usefixtures("hot")
def test_a_run_that_is_to_stop_stops_there_with_code_3_and_can_be_resumed(tmp_path: Path, scene: Scenes) -> None:
    with pytest.raises(Diverged, match=r"heat: the kinetic energy, is .*, more than 0.02, at t = "):
        run(scene(), tmp_path / "run", options=RunOptions(on_violation="stop"))
    assert info(tmp_path / "run").state == "failed"
    with pytest.raises(Diverged):
        resume(tmp_path / "run")
    assert resume(tmp_path / "run", options=RunOptions(on_violation="warn")).frames == 51


@pytest.mark.usefixtures("hot")
def test_the_scene_may_say_what_becomes_of_it_and_the_caller_overrides_it(tmp_path: Path, scene: Scenes) -> None:
    strict = scene(on_violation="stop")
    with pytest.raises(Diverged, match="heat"):
        run(strict, tmp_path / "run")
    with pytest.raises(Diverged, match="heat"):
        resume(tmp_path / "run")
    assert run(strict, tmp_path / "on", options=RunOptions(on_violation="warn")).frames == 51
    assert "stop" in (tmp_path / "on" / "scene.toml").read_text()


def test_a_policy_that_there_is_not_is_refused_in_a_scene_too() -> None:
    from ecume.errors import SceneError
    from ecume.scenes.schema import from_plain

    with pytest.raises(SceneError, match="on_violation: got 'panic'; expected one of warn, stop"):
        from_plain({"model": "tracers", "duration": 1.0, "frame_every": 1.0, "on_violation": "panic"})


@pytest.mark.long
@pytest.mark.usefixtures("hot")
def test_a_run_that_was_stopped_judges_like_one_that_was_not(tmp_path: Path, scene: Scenes) -> None:
    def ask(progress: Any) -> None:
        if progress.step == 300:
            raise KeyboardInterrupt

    run(scene(), tmp_path / "whole")
    with pytest.raises((Stopped, KeyboardInterrupt)):
        run(scene(), tmp_path / "parts", options=RunOptions(progress=ask, checkpoint_every=0.0))
    resume(tmp_path / "parts")
    assert (tmp_path / "parts" / "watch.json").read_text() == (tmp_path / "whole" / "watch.json").read_text()


def test_a_policy_that_there_is_not_is_refused() -> None:
    with pytest.raises(BadInput, match="on_violation: got 'panic'"):
        RunOptions(on_violation="panic")
