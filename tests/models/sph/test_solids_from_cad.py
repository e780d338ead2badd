"""Solids and liquid of files that CAD programs write: `stl_large` and the solids of `gate_and_cad_solids`."""

import struct
import time

import numpy as np
import pytest

from ecume import SceneError
from ecume.cli.scenes import odd_values
from ecume.models.sph.record import SPH
from ecume.models.sph.setup.initial_particles import liquid_of
from ecume.scenes.load import load_scene

HEAD = """model = "sph"
duration = "0.01 s"
frame_every = "0.01 s"
gravity = {gravity}
spacing = "{spacing}"
[tank]
low = ["-1 m", "-1 m", "-1 m"]
high = ["1 m", "1 m", "1 m"]
[liquid]
maximum_speed = "1 m/s"
"""
HALF = '[[fluid]]\nlow = ["-1 m", "-1 m", "-1 m"]\nhigh = ["1 m", "1 m", "0 m"]\n'


def sphere(radius, center=(0.0, 0.0, 0.0), parts=24):
    """The triangles of a sphere in mm, as many as in `ball.stl`: 2,208."""
    polar, around = np.linspace(0.0, np.pi, parts + 1), np.linspace(0.0, 2.0 * np.pi, 2 * parts, endpoint=False)
    ring = np.stack([np.cos(around), np.sin(around)], axis=1)
    points = [np.column_stack([np.sin(t) * ring, np.full(len(ring), np.cos(t))]) for t in polar]
    found = []
    for i in range(parts):
        for j in range(2 * parts):
            a, b, c, d = points[i][j], points[i + 1][j], points[i + 1][j - 2 * parts + 1], points[i][j - 2 * parts + 1]
            found += [(a, b, c)] * (i < parts - 1) + [(a, c, d)] * (i > 0)
    return radius * np.array(found) + np.array(center)


def scene_of(folder, triangles, text, spacing="5 cm", gravity="0.0"):
    head = b"binary stl".ljust(80) + struct.pack("<I", len(triangles))
    rows = (struct.pack("<12fH", 0.0, 0.0, 0.0, *triangle.ravel(), 0) for triangle in triangles)
    (folder / "part.stl").write_bytes(head + b"".join(rows))
    path = folder / "scene.toml"
    path.write_text(HEAD.format(spacing=spacing, gravity=gravity) + text)
    return load_scene(path)


DRAWN = 'outline_from = "part.stl"\noutline_unit = "mm"\n'


@pytest.mark.long
def test_stl_large(tmp_path):
    """A sphere of a meter, 65,000 particles at 20 mm, in seconds: lattice points times triangles took 19 s."""
    began = time.process_time()
    scene = scene_of(tmp_path, sphere(500.0), f"[[fluid]]\n{DRAWN}", spacing="2 cm")
    made = liquid_of(scene, SPH.parameters(scene).material)
    assert time.process_time() - began < 12.0
    inside = np.pi / 6.0
    assert made.mass.sum() == pytest.approx(1000.0 * inside, rel=0.01)
    assert made.position.shape[1] == pytest.approx(inside / 0.02**3, rel=0.01)


@pytest.mark.long
@pytest.mark.parametrize(
    "table",
    [f"[[obstacles]]\n{DRAWN}", f"[[bodies]]\n{DRAWN}density = 500.0\n",
     f'[[bodies]]\n{DRAWN}motion = {{ velocity = ["0 m/s", "0 m/s", "1 m/s"] }}\n'],
    ids=["obstacle", "body", "driven"],
)  # fmt: skip
def test_gate_and_cad_solids(tmp_path, table):
    """An obstacle, a floating body and a driven body of the same file have its volume and hold off the liquid."""
    parameters = SPH.parameters(scene_of(tmp_path, sphere(400.0), HALF + table, "10 cm", '"9.81 m/s^2"'))
    bodies = parameters.bodies
    (shape,) = (*bodies.obstacles, *bodies.shapes)
    assert shape.volume() == pytest.approx(4.0 / 3.0 * np.pi * 0.4**3, rel=0.02)
    if bodies.shapes and np.isfinite(bodies.mass[0]):
        assert bodies.mass[0] == pytest.approx(500.0 * shape.volume())
    if bodies.paths:
        assert bodies.motion[:, 0].tolist() == [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]


def test_check_states_the_size_of_drawings_without_a_unit(tmp_path, capsys):
    """A part of 400 mm that is read in meters is seen by its size, with the key that says its unit."""
    unitless = DRAWN.replace('outline_unit = "mm"\n', "")
    room = f"[[fluid]]\nhigh = [1.0, 1.0, 1.0]\nlow = [0.0, 0.0, 0.0]\n[[obstacles]]\n{unitless}"
    scene_of(tmp_path, sphere(0.2), room + f"[[obstacles]]\n{DRAWN}", "10 cm", '"9.81 m/s^2"')
    rows = odd_values(tmp_path / "scene.toml", [], load_scene(tmp_path / "scene.toml"))
    (row,) = [row for row in rows if "outline_from" in row[0]]
    assert row[:2] == ("obstacles[0].outline_from", "0.4 × 0.4 × 0.4 m")
    assert 'outline_unit = "mm"' in row[2]


def test_a_drawn_tank_is_a_solid_of_this_name(tmp_path):
    """Names distinguish their sizes and forces, and messages count the obstacles of the file."""
    scene_of(tmp_path, sphere(400.0), HALF, "10 cm")
    path = tmp_path / "drawn.toml"
    post = DRAWN.replace('outline_unit = "mm"', 'outline_unit = "0.4 mm"')
    path.write_text(
        f'model = "sph"\nduration = 1\nframe_every = 1\nspacing = "10 cm"\n[tank]\n{DRAWN}'
        '[[fluid]]\nlow = [-0.2, -0.2, -0.2]\nhigh = [0.2, 0.2, 0.2]\n'
        f'[[obstacles]]\nname = "post"\n{post}'
    )  # fmt: skip
    scene = load_scene(path)
    assert scene.obstacle_names == ("post", "tank")
    path.write_text(path.read_text().replace('"post"', '"tank"'))
    with pytest.raises(
        SceneError,
        match=r"^\S*: line 12, column 1: obstacles\[0\]\.name: got 'tank', the name of the drawn tank; choose another$",
    ):
        load_scene(path)
    path.write_text(path.read_text().replace('outline_unit = "0.4 mm"', "").replace('name = "tank"', 'name = "post"'))
    with pytest.raises(SceneError, match=r"obstacles\[0\]: is 800 × 800 × 800 m, .* give the unit of the drawing"):
        load_scene(path)
