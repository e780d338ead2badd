"""Drawings whose unit was forgotten: a tank of 600 m instead of 600 mm."""

import pytest
from typer.testing import CliRunner

from ecume.cli import app
from ecume.errors import SceneError
from ecume.scenes.load import load_scene
from ecume.scenes.schema import from_plain, to_plain

SCENE = """
model = "sph"
duration = "0.02 s"
frame_every = "10 ms"
spacing = "{spacing}"
[tank]
{tank}
[[fluid]]
low = [0, 0]
high = [0.2, 0.2]
{more}
"""
SQUARE = "[[0, 0], [600, 0], [600, 400], [0, 400]]"


def drawn(path):
    """A drawing of lines without a unit, as the oldest dialect has it."""
    corners = [(0, 0), (600, 0), (600, 400), (0, 400)]
    lines = [
        f"0\nLINE\n8\n0\n10\n{a}\n20\n{b}\n11\n{c}\n21\n{d}\n"
        for (a, b), (c, d) in zip(corners, corners[1:] + corners[:1], strict=True)
    ]
    path.write_text("0\nSECTION\n2\nENTITIES\n" + "".join(lines) + "0\nENDSEC\n0\nEOF\n")


@pytest.mark.parametrize("verb", ["check", "run"])
def test_a_drawing_in_millimeters_read_in_meters_is_refused_before_it_fills_the_memory(verb, tmp_path):
    drawn(tmp_path / "tank.dxf")
    file = tmp_path / "tank.toml"
    file.write_text(SCENE.format(spacing="2 cm", tank='outline_from = "tank.dxf"', more=""))
    done = CliRunner().invoke(app, [verb, str(file), *(["-o", str(tmp_path / "run")] if verb == "run" else [])])
    assert done.exit_code == 2
    assert "tank: is 600 × 400 m, which are 6e+08 points at this spacing" in done.output
    assert 'outline_unit = "mm"' in done.output
    load_scene(file, ['tank.outline_unit="mm"'])


def test_a_scene_that_python_makes_is_refused_as_well(tmp_path):
    """Fits, sweeps and `simulate` take scenes that no verb has read."""
    file = tmp_path / "small.toml"
    file.write_text(SCENE.format(spacing="2 cm", tank="high = [0.6, 0.4]", more=""))
    plain = to_plain(load_scene(file))
    for table, more in (("obstacles", {}), ("bodies", {"density": 500.0})):
        shape = {"vertices": [[0.0, 0.0], [600.0, 0.0], [600.0, 400.0], [0.0, 400.0]]}
        with pytest.raises(SceneError, match=rf"{table}\[0\]: is 600 × 400 m"):
            from_plain(plain | {table: [shape | more]})


def test_corners_in_the_file_count_too(tmp_path):
    file = tmp_path / "post.toml"
    file.write_text(SCENE.format(spacing="2 cm", tank="high = [0.6, 0.4]", more=f"[[obstacles]]\nvertices = {SQUARE}"))
    done = CliRunner().invoke(app, ["check", str(file)])
    assert done.exit_code == 2
    assert "obstacles[0]: is 600 × 400 m" in done.output


def test_a_sweep_refuses_it_before_the_first_run(tmp_path):
    drawn(tmp_path / "tank.dxf")
    (tmp_path / "tank.toml").write_text(SCENE.format(spacing="2 cm", tank='outline_from = "tank.dxf"', more=""))
    (tmp_path / "sweep.toml").write_text(
        'scene = "tank.toml"\nmeasures = ["max front"]\n[[axes]]\nkey = "spacing"\nvalues = ["4 cm", "2 cm"]\n'
    )
    done = CliRunner().invoke(app, ["sweep", str(tmp_path / "sweep.toml"), "-o", str(tmp_path / "all")])
    assert done.exit_code == 2
    assert "tank: is 600 × 400 m" in done.output
    assert not (tmp_path / "all").exists()
