"""Floats from a frame of another run."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.scenes.load import load_scene
from ecume.scenes.schema import from_plain, to_plain
from ecume.trajectories.frame import Frame
from ecume.trajectories.recorder import Recorder

SCENE = """\
model = "floating"
duration = 1
frame_every = 0.1
start_from = "runs/bowl{}"
"""


def frame(time: float) -> Frame:
    arrays = {
        "position": np.array([[time, 0.1], [0.2, 0.3]]),
        "velocity": np.array([[0.0, -0.0], [1e-300, 0.1]]),
        "radius": np.array([1e-3, 2e-3]),
        "density": np.array([600.0, 1200.0]),
        "contact_angle": np.array([1.0, 2.0]),
        "species": np.array([1, 0]),
    }
    return Frame(time, arrays, {"kinetic_energy": 1.0}, {})


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a run of three frames and two species."""
    body = {"radius": 0.001, "density": 600, "contact_angle": 1.0}
    species = [{**body, "name": "light", "color": "red"}, {**body, "name": "heavy"}]
    scene = from_plain({"model": "floating", "duration": 1, "frame_every": 0.1, "particles": species})
    run = tmp_path / "runs" / "bowl"
    with Recorder(run / "traj") as recorder:
        for step in range(3):
            recorder.write(frame(step / 10), step)
    (run / "resolved.json").write_text(json.dumps(to_plain(scene)))
    return tmp_path


def read(folder: Path, at: str = "", more: str = "") -> object:
    (folder / "scene.toml").write_text(SCENE.format(at) + more)
    return load_scene(folder / "scene.toml")


@pytest.mark.parametrize(("at", "x"), [("", 0.2), ("@-1", 0.2), ("@0", 0.0), ("@-2", 0.1)])
def test_a_scene_starts_from_a_frame_of_another_run(folder: Path, at: str, x: float) -> None:
    first, second = read(folder, at).rows  # type: ignore[attr-defined]
    assert (first.x, first.y, first.radius, first.species_name, first.color) == (x, 0.1, 1e-3, "heavy", None)
    assert (second.vx, second.vy, second.density, second.contact_angle) == (1e-300, 0.1, 1200.0, 2.0)
    assert (second.species_name, second.color) == ("light", "#d62728")


@pytest.mark.parametrize(
    ("at", "more", "says"),
    [
        ("@3", "", "'runs/bowl@3' has no frame 3; there are 0 to 2, and -1 for the last"),
        ("@-4", "", "has no frame -4"),
        ("@x", "", "'runs/bowl@x' 'x' is no number of a frame; expected RUN@FRAME"),
        ("@", "", "'' is no number of a frame"),
        ("@1.5", "", "'1.5' is no number of a frame"),
        ("2", "", "does not exist; paths are relative to the scene's folder, /"),
        ("@0", "[[particles]]\nradius = 1\ndensity = 1\ncontact_angle = 1", "brings all the floats"),
    ],
)
def test_a_start_that_cannot_be_is_refused(folder: Path, at: str, more: str, says: str) -> None:
    with pytest.raises(SceneError) as caught:
        read(folder, at, more)
    assert [says in str(fault) for fault in caught.value.faults] == [True]


@pytest.mark.parametrize("absolute", [True, False])
def test_a_run_elsewhere_is_refused_unless_the_user_trusts_its_folder(
    folder: Path, absolute: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder / "inner").mkdir()
    runs = f"{folder.as_posix()}/runs/" if absolute else "../runs/"
    (folder / "inner" / "scene.toml").write_text(SCENE.format("@0").replace("runs/", runs))
    with pytest.raises(SceneError, match="leads out of the scene's folder"):
        load_scene(folder / "inner" / "scene.toml")
    monkeypatch.setenv("ECUME_SCENE_FOLDERS", str(folder / "runs"))
    assert load_scene(folder / "inner" / "scene.toml").rows[0].x == 0.0


def test_a_run_may_have_an_at_in_its_name(folder: Path) -> None:
    (folder / "runs" / "bowl").rename(folder / "runs" / "bowl@home")
    assert read(folder, "@home").rows[0].x == 0.2  # type: ignore[attr-defined]
    assert read(folder, "@home@0").rows[0].x == 0.0  # type: ignore[attr-defined]


def test_a_run_without_densities_is_of_another_model(folder: Path) -> None:
    other = frame(0.0)
    arrays = {name: array for name, array in other.arrays.items() if name != "density"}
    with Recorder(folder / "runs" / "other" / "traj") as recorder:
        recorder.write(other._replace(arrays=arrays), 0)
    (folder / "runs" / "other" / "resolved.json").write_bytes((folder / "runs" / "bowl" / "resolved.json").read_bytes())
    (folder / "scene.toml").write_text(SCENE.format("").replace("bowl", "other"))
    with pytest.raises(SceneError, match="another model: its frames have no density"):
        load_scene(folder / "scene.toml")


def test_discs_and_shapes_start_as_they_were_left(tmp_path: Path) -> None:
    disc = {"name": "flake", "radius": 2e-3, "density": 500, "disc": {"thickness": 1e-3, "angle": 0.1}}
    needle = {"name": "pin", "radius": 3e-3, "density": 900, "contact_angle": 1.2}
    needle["shape"] = {"kind": "needle", "width": 5e-4}
    scene = from_plain({"model": "floating", "duration": 1, "frame_every": 0.1, "particles": [disc, needle]})
    run = tmp_path / "runs" / "bowl"
    arrays = {
        "position": np.array([[0.0, 0.1], [0.2, 0.3]]),
        "velocity": np.array([[0.0, 0.0], [1e-3, 0.1]]),
        "radius": np.array([2e-3, 3e-3]),
        "density": np.array([500.0, 900.0]),
        "contact_angle": np.array([np.nan, 1.2]),
        "species": np.array([0, 1]),
        "angle": np.array([0.4, 2.5]),
        "spin": np.array([0.0, -3.0]),
    }
    with Recorder(run / "traj") as recorder:
        recorder.write(Frame(0.0, arrays, {"kinetic_energy": 1.0}, {}), 0)
    (run / "resolved.json").write_text(json.dumps(to_plain(scene)))
    again = read(tmp_path)
    flake, pin = again.rows  # type: ignore[attr-defined]
    assert (flake.disc.thickness, flake.disc.angle, flake.contact_angle, flake.angle) == (1e-3, None, None, 0.4)
    assert (pin.shape.kind, pin.shape.width, pin.contact_angle, pin.spin) == ("needle", 5e-4, 1.2, -3.0)
    assert again.shaped  # type: ignore[attr-defined]
    # What was read stands alone, and starts a run in turn.
    assert from_plain(to_plain(again)) == again
