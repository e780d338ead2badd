"""Numbers that are sampled between frames, and their averages."""

from __future__ import annotations

import dataclasses
import os
import random
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import toy

from ecume.errors import BadInput, SceneError, Stopped, StorageError
from ecume.models import MODELS
from ecume.models.step_counts import sample_clock
from ecume.run import RunDirectory, RunOptions, checkpoints, info, resume, run
from ecume.run.comparison import difference
from ecume.run.lock import ask_to_stop
from ecume.run.scalars import lines_of
from ecume.simulation import simulate
from ecume.trajectories.exports import export
from ecume.trajectories.reader import open_trajectory

pytestmark = pytest.mark.sampled(2)

Scenes = Callable[..., toy.ToyScene]
EACH = {"output": {"samples": {"every_steps": 1}}}


def samples_of(path: Path) -> Any:
    with open_trajectory(path) as trajectory:
        return trajectory.samples


def test_samples_of_each_step_are_the_numbers_of_a_run_that_writes_each_step(tmp_path: Path, scene: Scenes) -> None:
    run(scene(duration=0.1, **EACH), tmp_path / "run")
    found = samples_of(tmp_path / "run")
    frames = list(simulate(scene(duration=0.1, frame_every=0.001)))
    assert found.steps.tolist() == list(range(101))
    np.testing.assert_allclose(found.times, [frame.time for frame in frames], rtol=1e-12)
    assert found.mean("kinetic_energy").tolist() == [frame.numbers["kinetic_energy"] for frame in frames]
    assert (found.names, found.units["kinetic_energy"], found.units["pairs"]) == (["kinetic_energy", "pairs"], "J", "1")


@pytest.mark.parametrize("block", [2, 7, 50, 1000])
def test_blocks_are_the_averages_of_their_samples(tmp_path: Path, scene: Scenes, block: int) -> None:
    """The last block may be shorter."""
    run(scene(duration=0.2, **EACH), tmp_path / "each")
    run(scene(duration=0.2, output={"samples": {"every_steps": 1, "block": block}}), tmp_path / "blocks")
    each, found = samples_of(tmp_path / "each"), samples_of(tmp_path / "blocks")
    whole = np.split(each.mean("kinetic_energy"), range(block, len(each), block))
    assert found.counts.tolist() == [len(part) for part in whole]
    assert found.counts.sum() == 201
    np.testing.assert_allclose(found.mean("kinetic_energy"), [part.mean() for part in whole], rtol=1e-12)
    assert found.minimum("kinetic_energy").tolist() == [part.min() for part in whole]
    assert found.maximum("kinetic_energy").tolist() == [part.max() for part in whole]
    errors = [part.std(ddof=1) / np.sqrt(len(part)) if len(part) > 1 else np.nan for part in whole]
    np.testing.assert_allclose(found.error("kinetic_energy"), errors, rtol=1e-9, atol=1e-15)
    times = np.split(each.times, range(block, len(each), block))
    np.testing.assert_allclose(found.times, [part.mean() for part in times], rtol=1e-12, atol=1e-15)
    assert found.steps.tolist() == [part[-1] for part in np.split(each.steps, range(block, len(each), block))]
    mean = each.average("kinetic_energy").mean
    assert found.average("kinetic_energy").mean == pytest.approx(mean, rel=1e-12)


def test_samples_change_no_frame(tmp_path: Path, scene: Scenes) -> None:
    run(scene(), tmp_path / "plain")
    run(scene(output={"samples": {"every": 0.0037}}), tmp_path / "sampled")
    files = [RunDirectory(tmp_path / name) for name in ("plain", "sampled")]
    with open_trajectory(files[0].path) as plain, open_trajectory(files[1].path) as sampled:
        assert [difference(one, other) for one, other in zip(plain, sampled, strict=True)] == [None] * len(plain)
    assert list(lines_of(files[0])) == list(lines_of(files[1]))
    assert not files[0].samples.exists()


@pytest.mark.parametrize("every", [0.0004, 0.001, 0.0037, 0.01, 0.025])
def test_a_sample_is_at_the_first_step_of_each_interval(tmp_path: Path, scene: Scenes, every: float) -> None:
    run(scene(output={"samples": {"every": every}}), tmp_path / "run")
    found = samples_of(tmp_path / "run").steps
    stride = every / toy.TIME_STEP
    expected = sorted({int(np.ceil(k * stride - 1e-9)) for k in range(int(500 / stride) + 1)})
    assert found.tolist() == expected


def test_only_named_numbers_are_sampled(tmp_path: Path, scene: Scenes) -> None:
    run(scene(output={"samples": {"every": 0.1, "numbers": ["pairs"]}}), tmp_path / "run")
    found = samples_of(tmp_path / "run")
    assert found.names == ["pairs"]
    with pytest.raises(BadInput, match=r"'kinetic_energy'; expected one of pairs"):
        found.mean("kinetic_energy")


def test_an_unknown_number_is_refused_before_anything_is_written(tmp_path: Path, scene: Scenes) -> None:
    with pytest.raises(SceneError, match=r"output\.samples\.numbers\[1\]: got 'x'; expected one of kinetic_energy, pa"):
        run(scene(output={"samples": {"every": 0.1, "numbers": ["pairs", "x"]}}), tmp_path / "run")
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("asked", [{}, {"every": 0.1, "every_steps": 2}, {"every": 0.6}, {"every": 0.0}, {"block": 0}])
def test_intervals_that_cannot_be_are_refused(scene: Scenes, asked: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"every|block"):
        scene(output={"samples": asked})


def test_adaptive_steps_are_not_counted(scene: Scenes) -> None:
    with pytest.raises(SceneError, match=r"every_steps: .* adapt"):
        sample_clock(scene(**EACH), dataclasses.replace(MODELS["toy"], adaptive=True), 1024)


def test_a_run_without_samples_has_none(tmp_path: Path, scene: Scenes) -> None:
    run(scene(duration=0.01), tmp_path / "run")
    with pytest.raises(BadInput, match=r"no samples; its scene has no table \[output\.samples\]"):
        samples_of(tmp_path / "run")


def test_the_table_is_exported_and_read(tmp_path: Path, scene: Scenes) -> None:
    run(scene(output={"samples": {"every": 0.01, "block": 5}}), tmp_path / "run")
    file = RunDirectory(tmp_path / "run").samples
    assert export(tmp_path / "run", "samples", tmp_path / "out.csv").read_bytes() == file.read_bytes()
    first = "step,time [s],samples,kinetic_energy [J],kinetic_energy_min [J],kinetic_energy_max [J],"
    assert file.read_text().startswith(first)
    table = samples_of(tmp_path / "run").columns()
    assert list(table)[:5] == ["step", "time", "samples", "kinetic_energy", "kinetic_energy_min"]
    assert {len(column) for column in table.values()} == {11}
    assert repr(samples_of(tmp_path / "run")).endswith("11 rows, 0.02 s to 0.5 s: kinetic_energy, pairs)")
    RunDirectory(tmp_path / "run").done.unlink()
    with file.open("a") as torn:
        torn.write("12,0.6")  # a run is writing just now
    assert len(samples_of(tmp_path / "run")) == 11
    file.write_text("step,time [s]\n1,x\n")
    with pytest.raises(StorageError, match="damaged"):
        samples_of(tmp_path / "run")


@pytest.mark.parametrize("library", ["polars", "pandas"])
def test_the_table_is_a_data_frame(tmp_path: Path, scene: Scenes, library: str) -> None:
    run(scene(output={"samples": {"every": 0.01, "block": 5}}), tmp_path / "run")
    table = getattr(samples_of(tmp_path / "run"), library)()
    assert list(table.columns) == list(samples_of(tmp_path / "run").columns())
    assert len(table) == 11


OUTPUTS = [{"every": 0.0037}, {"every": 0.0037, "block": 9}, {"every_steps": 3, "block": 1000}]


@pytest.mark.long
@pytest.mark.parametrize("samples", OUTPUTS)
def test_a_run_stopped_often_has_the_samples_of_one_that_was_not(
    tmp_path: Path, scene: Scenes, results: Callable[..., Any], samples: dict[str, Any]
) -> None:
    asked = scene(output={"samples": samples})
    run(asked, tmp_path / "whole")

    def stop(progress: Any) -> None:
        if (progress.step and progress.step % 83 == 0) or progress.step % 100 == 0:
            ask_to_stop(os.getpid())

    with pytest.raises(Stopped):
        run(asked, tmp_path / "stopped", options=RunOptions(progress=stop))
    for _ in range(3):
        with pytest.raises(Stopped):
            resume(tmp_path / "stopped", options=RunOptions(progress=stop))
    resume(tmp_path / "stopped")
    assert results(tmp_path / "stopped") == results(tmp_path / "whole")
    whole, stopped = (RunDirectory(tmp_path / name).samples.read_bytes() for name in ("whole", "stopped"))
    assert stopped == whole


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGKILL")
def test_a_run_killed_at_random_has_the_samples_of_one_that_was_not(
    tmp_path: Path, server: Callable[..., Any], results: Callable[..., Any]
) -> None:
    asked = {"duration": 0.5, "frame_every": 0.01, "seed": 3, "rest": 0.002}
    asked["output"] = {"samples": {"every": 0.0023, "block": 4}}  # type: ignore[assignment]
    moments, home = random.Random(4), RunDirectory(tmp_path / "killed")
    one = server("run", home.path, asked, 0.02)
    while not home.manifest.exists():
        time.sleep(0.005)
    for _ in range(4):
        time.sleep(moments.uniform(0.0, 0.15))
        os.kill(one.pid, signal.SIGKILL)
        one.end()
        one = server("resume", home.path, 0.02)
    assert one.end() == 0
    assert info(home.path).state == "done"
    run(toy.ToyScene(**asked), tmp_path / "whole")  # type: ignore[arg-type]
    assert results(home.path) == results(tmp_path / "whole")
    assert home.samples.read_bytes() == RunDirectory(tmp_path / "whole").samples.read_bytes()


def test_a_checkpoint_without_its_samples_is_not_used(
    tmp_path: Path, scene: Scenes, results: Callable[..., Any]
) -> None:
    asked = scene(output={"samples": {"every": 0.01}})
    run(asked, tmp_path / "whole")
    run(asked, tmp_path / "cut")
    home = RunDirectory(tmp_path / "cut")
    home.done.unlink()
    os.truncate(home.samples, 200)
    resume(home.path)
    assert len(list(home.checkpoints.glob("*.damaged"))) == 1
    assert home.samples.read_bytes() == RunDirectory(tmp_path / "whole").samples.read_bytes()
    assert checkpoints.newest_first(home)


def test_rows_after_the_checkpoint_are_cut(tmp_path: Path, scene: Scenes) -> None:
    run(scene(output={"samples": {"every": 0.01}}), tmp_path / "run")
    home = RunDirectory(tmp_path / "run")
    whole = home.samples.read_bytes()
    home.done.unlink()
    home.samples.write_bytes(whole + b"600,0.6,1.0,2.0\n7")
    resume(home.path)
    assert home.samples.read_bytes() == whole
