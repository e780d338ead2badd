"""Floats from a frame of another run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.scenes.load import load_scene
from ecume.scenes.schema import Scene, from_plain, to_plain
from ecume.scenes.writing import scene as made
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.trajectories.segments import Recorder

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
        ("@x", "", "'runs/bowl@x' 'x' is not a frame number; expected RUN@FRAME"),
        ("@", "", "'' is not a frame number"),
        ("@1.5", "", "'1.5' is not a frame number"),
        ("2", "", "does not exist; paths are relative to the scene's folder, /"),
        ("@0", "[[particles]]\nradius = 1\n", "particles[0].name: is missing; expected one of 'light', 'heavy'"),
        ("@0", "[[particles]]\nname = 'lihgt'", "got 'lihgt'; runs/bowl@0 has no such species; did you mean light?"),
        ("@0", "[[particles]]\nname = 'light'\ncount = 3", "particles[0].count: has no meaning beside start_from"),
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


BODIES = [
    {},
    {"disc": {"thickness": 1e-3}},
    {"shape": {"kind": "needle", "width": 5e-4}},
    {"shape": {"kind": "needle", "width": 8e-4}},
    {"shape": {"kind": "square"}},
]
"""A sphere, a disc, two needles and a square: bodies of one species of rows."""


def different_bodies(folder: Path, bodies: list[dict[str, Any]]) -> None:
    """Record a run of rows of one species, each with another body."""
    rows = []
    for number, body in enumerate(bodies):
        pinned = "disc" in body or body.get("shape", {}).get("kind") == "square"
        row = {"x": 0.02 * number, "y": 0.0, "radius": 3e-3, "density": 900.0, **body}
        rows.append(row if pinned else {**row, "contact_angle": 1.2})
    scene = from_plain({"model": "floating", "duration": 1, "frame_every": 0.1, "rows": rows})
    run_of(scene, next(simulate(scene)).arrays, {}, folder / "runs" / "bowl")


def test_bodies_of_one_species_start_as_they_were_left(tmp_path: Path) -> None:
    different_bodies(tmp_path, BODIES)
    sphere, disc, thin, thick, square = read(tmp_path).rows  # type: ignore[attr-defined]
    assert (sphere.disc, sphere.shape, sphere.contact_angle) == (None, None, 1.2)
    assert (disc.disc.thickness, disc.shape, disc.contact_angle) == (1e-3, None, None)
    assert (thin.shape.width, thick.shape.width, square.shape.kind) == (5e-4, 8e-4, "square")


@pytest.mark.parametrize(
    ("more", "kind", "angle"),
    [
        ("contact_angle = 1.0", "needle", 1.0),
        ('shape = { kind = "ellipsoid", width = "1 mm" }', "ellipsoid", 1.2),
        ('shape = { kind = "square" }', "square", None),
    ],
)
def test_a_changed_contact_angle_keeps_the_shape_and_the_reverse(
    tmp_path: Path, more: str, kind: str, angle: float | None
) -> None:
    different_bodies(tmp_path, BODIES[2:3])
    (needle,) = read(tmp_path, "", f"[[particles]]\nname = 'float-1'\n{more}\n").rows  # type: ignore[attr-defined]
    assert (needle.shape.kind, needle.contact_angle) == (kind, angle)


def test_headings_of_swimmers_go_on(tmp_path: Path) -> None:
    bead = {"radius": 1e-3, "density": 600.0, "contact_angle": 1.2, "count": 5}
    driven = {"activity": {"propulsion": 1e-7}, "interaction": {"law": "none"}}
    for number, more in enumerate(({}, {"contacts": {"friction": 0.2}})):
        plain = {"model": "floating", "duration": 1, "frame_every": 0.1, "particles": [bead], **driven, **more}
        first, folder = next(simulate(from_plain(plain))).arrays, tmp_path / str(number)
        run_of(from_plain({**plain, "seed": 3}), first, {}, folder / "runs" / "bowl")
        written = "seed = 9\ninteraction.law = 'none'\nactivity.propulsion = 1e-7\n"
        written += "".join(f"contacts.friction = {rub['friction']}\n" for rub in more.values())
        again = next(simulate(read(folder, "", written)))  # type: ignore[arg-type]
        assert again.arrays["angle"] == pytest.approx(first["angle"], abs=1e-12)


def test_species_of_the_scene_replace_those_of_the_run_by_name(folder: Path) -> None:
    more = "[[particles]]\nname = 'light'\ndensity = 300\nradius = '1.5 mm'\ncolor = 'blue'\n"
    heavy, light = read(folder, "@0", more).rows  # type: ignore[attr-defined]
    assert (light.density, light.radius, light.color, light.contact_angle) == (300.0, 0.0015, "#1f77b4", 2.0)
    assert (light.x, light.vy, heavy.density, heavy.radius) == (0.2, 0.1, 600.0, 1e-3)
    energies = "[[particles]]\nname = 'heavy'\nsurface_energies = { solid_gas = 0.03, solid_liquid = 0.02 }\n"
    heavy, light = read(folder, "@0", energies).rows  # type: ignore[attr-defined]
    assert (heavy.contact_angle, heavy.surface_energies.solid_gas, light.contact_angle) == (None, 0.03, 2.0)


def test_changed_species_that_overlap_are_refused_with_the_overlap(tmp_path: Path) -> None:
    species = {"name": "corks", "radius": 2e-3, "density": 600, "contact_angle": 1.0, "count": 2}
    scene = from_plain({"model": "floating", "duration": 1, "frame_every": 0.1, "particles": [species]})
    columns = {"radius": 2e-3, "density": 600.0, "contact_angle": 1.0}
    arrays = {name: np.full(2, value) for name, value in columns.items()} | {"species": np.zeros(2, np.int64)}
    arrays |= {"position": np.array([[0.0, 0.0], [5e-3, 0.0]]), "velocity": np.zeros((2, 2))}
    run_of(scene, arrays, {}, tmp_path / "runs" / "bowl")
    larger = read(tmp_path, "", "[[particles]]\nname = 'corks'\nradius = '3 mm'\n")
    with pytest.raises(SceneError, match=r"rows\[0\]: overlaps rows\[1\] by 1 mm"):
        next(simulate(larger))  # type: ignore[arg-type]


def scene_of(model: str, keys: dict[str, Any], folder: Path) -> Scene:
    return made(model, folder=folder, **keys)


def run_of(scene: Scene, arrays: dict[str, np.ndarray], numbers: dict[str, float], run: Path) -> None:
    with Recorder(run / "traj") as recorder:
        recorder.write(Frame(0.0, arrays, numbers, {}), 0)
    (run / "resolved.json").write_text(json.dumps(to_plain(scene)))


def test_soft_spheres_and_tracers_start_from_runs_of_any_model(tmp_path: Path) -> None:
    species = [
        {"name": "small", "radius": 1e-3, "modulus": 1e4, "count": 1},
        {"name": "large", "radius": 2e-3, "count": 1},
    ]
    plain = {"duration": 1, "frame_every": 0.1, "liquid": {"viscosity": 1.0}, "cell": {"size": [0.02, 0.01]}}
    scene = from_plain({"model": "soft", **plain, "particles": species})
    position = np.array([[0.015, 0.001], [0.002, 0.003]])
    arrays = {"position": position, "radius": np.array([2e-3, 1e-3]), "species": np.array([1, 0])}
    box = {"box_width": 0.02, "box_height": 0.01, "box_tilt": 0.0}
    run_of(scene, arrays, box, tmp_path / "run")
    again = scene_of("soft", {**plain, "start_from": "run", "particles": [{"name": "large", "modulus": 5.0}]}, tmp_path)
    large, small = again.particles  # type: ignore[union-attr]
    assert (large.name, large.modulus, large.radius, large.positions) == ("large", 5.0, 2e-3, ((0.015, 0.001),))
    assert (small.name, small.modulus, small.radius, small.positions) == ("small", 1e4, 1e-3, ((0.002, 0.003),))
    tracers = [{"name": name, "density": 2000.0} for name in ("small", "large")]
    keys = {"duration": 1, "frame_every": 0.1, "start_from": "run@0", "tank": {"high": [0.02, 0.01]}}
    first, second = scene_of("tracers", {**keys, "particles": tracers}, tmp_path).particles  # type: ignore[union-attr]
    assert (first.radius, first.positions, second.radius) == (1e-3, ((0.002, 0.003),), 2e-3)
    run_of(scene, arrays, {**box, "box_tilt": 0.023}, tmp_path / "sheared")
    with pytest.raises(
        SceneError, match=r"start_from: sheared has a box tilted by 0.003 m; expected a rectangular one"
    ):
        scene_of("soft", {**plain, "start_from": "sheared"}, tmp_path)
    with pytest.raises(SceneError, match=r"got 0.03 m, 0.01 m; the periodic box of run is 0.02 m, 0.01 m"):
        scene_of("soft", {**plain, "cell": {"size": [0.03, 0.01]}, "start_from": "run"}, tmp_path)


def test_tracers_that_left_are_not_there_again(tmp_path: Path) -> None:
    tank = {"duration": 1, "frame_every": 0.1, "tank": {"high": [0.02, 0.01]}}
    scene = from_plain(
        {"model": "tracers", **tank, "particles": [{"name": "dust", "radius": 1e-6, "density": 2000.0, "count": 3}]}
    )
    position = np.array([[0.0199, 0.001], [0.002, 0.003], [0.004, 0.005]])
    arrays = {"position": position, "radius": np.full(3, 1e-6), "species": np.zeros(3, np.int64)}
    run_of(scene, {**arrays, "left": np.array([0, -1, -1])}, {}, tmp_path / "run")
    keys = {**tank, "start_from": "run", "particles": [{"name": "dust"}]}
    (dust,) = scene_of("tracers", keys, tmp_path).particles  # type: ignore[union-attr]
    assert dust.positions == ((0.002, 0.003), (0.004, 0.005))
    run_of(scene, {**arrays, "left": np.array([0, 0, 1])}, {}, tmp_path / "empty")
    with pytest.raises(SceneError, match="start_from: 'empty' has no particle in this frame"):
        scene_of("tracers", {**keys, "start_from": "empty"}, tmp_path)


def test_floats_of_a_cell_start_in_a_cell_of_this_size(tmp_path: Path) -> None:
    """In another one they would be put into it silently, at other distances."""
    body = {"name": "a", "radius": 1e-3, "density": 600, "contact_angle": 1.4}
    scene = from_plain({"model": "floating", "duration": 1, "frame_every": 0.1, "particles": [body]})
    arrays = {name: array[:1] for name, array in frame(0.06).arrays.items()} | {"species": np.zeros(1, np.int64)}
    run_of(scene, arrays, {"box_width": 0.07, "box_height": 0.07}, tmp_path / "run")
    keys = {"duration": 1, "frame_every": 0.1, "start_from": "run"}
    with pytest.raises(SceneError, match=r"got 0\.06 m, 0\.06 m; the periodic box of run is 0\.07 m, 0\.07 m$"):
        scene_of("floating", {**keys, "cell": {"size": [0.06, 0.06]}}, tmp_path)
    filled = scene_of("floating", {**keys, "cell": {}}, tmp_path)
    assert filled.cell.size == (0.07, 0.07)  # type: ignore[union-attr]
