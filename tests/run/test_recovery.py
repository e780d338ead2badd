"""What is damaged beside a run's frames is never gone on with in silence, and made again where something tells it."""

import json
import os
from pathlib import Path

import pytest

from ecume.errors import BadInput, Stopped, StorageError
from ecume.run import RunDirectory, info, repair, resume, run

pytestmark = pytest.mark.sampled(2)


@pytest.fixture
def half(tmp_path, scene):
    """A run that was stopped on its way, and how the same run ends."""
    run(scene(), tmp_path / "whole")

    def stop(progress):
        if progress.step > 200:
            raise Stopped("half way")

    from ecume.run import RunOptions

    with pytest.raises(Stopped):
        run(scene(), tmp_path / "half", options=RunOptions(progress=stop, checkpoint_every=0.0))
    return RunDirectory(tmp_path / "half"), RunDirectory(tmp_path / "whole")


def cut(path: Path) -> None:
    os.truncate(path, path.stat().st_size // 2)


def other_seed(path: Path) -> None:
    path.write_text(path.read_text().replace('"seed": 7', '"seed": 8'))


@pytest.mark.parametrize("spoil", [cut, other_seed, Path.unlink])
def test_another_scene_than_the_first_is_not_gone_on_with_and_the_first_is_made_again(half, spoil, results):
    one, whole = half
    spoil(one.resolved)
    with pytest.raises(StorageError, match=r"resolved\.json"):
        resume(one.path)
    assert repair(one.path).faults == (f"{one.resolved}: was damaged; made again from scene.toml",)
    assert repair(one.path).faults == ()
    resume(one.path)
    assert results(one.path) == results(whole.path)


def test_a_scene_that_cannot_be_recovered_is_left_as_it_is(half):
    one, _ = half
    cut(one.resolved)
    one.scene.write_text(one.scene.read_text().replace("seed = 7", "seed = 8"))
    before = one.resolved.read_bytes()
    (fault,) = repair(one.path).faults
    assert "put it back from a copy" in fault
    assert one.resolved.read_bytes() == before


@pytest.mark.parametrize("name", ["status.json", "watch.json", "DONE.json"])
def test_what_a_run_writes_again_is_reported_and_set_aside(half, name, results):
    one, whole = half
    (one.path / name).write_text("[1]")
    if name != "DONE.json":
        assert f"{name}: damaged: expected a table; `ecume repair" in info(one.path).why
        assert info(one.path).frames > 0
    assert repair(one.path).faults == (f"{one.path / name}: damaged: expected a table; set aside",)
    assert (one.path / f"{name}.damaged").read_text() == "[1]"
    assert "damaged" not in info(one.path).why
    resume(one.path)
    assert results(one.path) == results(whole.path)
    assert json.loads((one.path / "status.json").read_text())["state"] == "done"


def test_frames_without_a_manifest_are_not_to_be_written_over(half):
    one, _ = half
    one.manifest.unlink()
    with pytest.raises(BadInput, match=r"its manifest\.json is gone: put it back from a copy") as output:
        resume(one.path)
    assert "--force" not in str(output.value)
