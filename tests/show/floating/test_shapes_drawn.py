"""Floats with a shape are drawn as what they are, turned as they are; the surface is that of their contact lines."""

import math

import numpy as np
import pytest

from ecume.analysis.boxes import SIDES
from ecume.scenes.load import load_scene
from ecume.show.floating.bowl import Bowl
from ecume.show.floating.surface import outlines_in, shapes_of, sheet, surface
from ecume.show.picture import Size, view_around
from ecume.show.view.chunks import pack
from ecume.show.view.scenery import floating_stage
from ecume.trajectories.frame import Frame

SCENE = """
model = "floating"
duration = 1.0
frame_every = 1.0
[[particles]]
radius = "1 mm"
density = 500.0
contact_angle = "90 deg"
color = "#00ff00"
shape = { kind = "ellipsoid", width = "0.6 mm", undulation = "20 um" }
[[particles]]
radius = "1 mm"
density = 1000.0
color = "#ff0000"
shape = { kind = "square" }
"""


def framed(angle, position=((0.0, 0.0), (3e-3, 0.0))):
    arrays = {
        "position": np.array(position),
        "radius": np.full(2, 1e-3),
        "charge": np.zeros(2),
        "angle": np.array([angle, 0.0]),
        "species": np.array([0, 1]),
    }
    return Frame(0.0, arrays, {"kinetic_energy": 0.0}, {})


def test_outlines_turn_and_move_with_their_floats():
    shapes = shapes_of(load_scene(SCENE))
    ellipse, square = outlines_in(framed(0.5 * math.pi), shapes)
    assert np.abs(ellipse).max(axis=0) == pytest.approx([0.3e-3, 1e-3], rel=1e-6)
    assert square[:, 0].max() == pytest.approx(4e-3, rel=1e-6)


def test_the_surface_rises_at_the_tips():
    scene, frame = load_scene(SCENE), framed(0.5 * math.pi, ((0.0, 0.0), (0.1, 0.0)))
    on = sheet(scene, view_around(0.0, 0.0, 4e-3, 4e-3), cells=101, closest=1e-3)
    height = surface(frame, on)
    up = height[int(np.argmin(np.abs(on.y - 1.02e-3))), 50]
    aside = height[50, int(np.argmin(np.abs(on.x - 0.32e-3)))]
    assert up == pytest.approx(20e-6, rel=0.25)
    assert aside < -10e-6


def test_a_picture_shows_the_shape_and_not_its_circle():
    scene, frame = load_scene(SCENE), framed(0.0)
    seen = Bowl(scene, [frame], Size(480, 360)).pixels(frame)[:, :320]  # without the legend
    green = np.all(seen[..., :3] == (0, 255, 0), axis=-1)
    rows, columns = np.nonzero(green)
    across, along = np.ptp(rows) + 1, np.ptp(columns) + 1
    assert along / across == pytest.approx(1.0 / 0.3, rel=0.1)
    assert green.sum() == pytest.approx(0.25 * math.pi * along * across, rel=0.05)


def test_the_page_has_outlines_around_discs_inside_them():
    scene, frame = load_scene(SCENE), framed(0.3)
    stage = floating_stage(scene, [frame])
    chunk = pack([frame], stage)
    assert chunk.header["movers"] == [121, 121]
    assert stage.inner == pytest.approx([0.3e-3, 1e-3 / (0.9 * math.sqrt(2.0) + 0.1)], rel=1e-3)
    assert chunk.header["ranges"]["array/radius"] == pytest.approx([*stage.inner])


def test_the_page_has_outlines_of_floats_and_of_what_is_behind_a_barrier():
    barred = '[dish]\nsize = [0.03, 0.02]\nlaw = "none"\n[dish.barrier]\nvelocity = 1e-3\n'
    frame = framed(0.3)
    moving = floating_stage(load_scene(SCENE + barred), [frame]).movers(frame)
    assert [len(each) for each in moving] == [121, 121, 5]


def test_the_surface_goes_on_across_the_border_of_a_cell_as_around_images():
    scene = load_scene(SCENE + "[cell]\nsize = [0.1, 0.1]\n")
    seen = view_around(0.05, 0.05, 0.1, 0.1)
    heights = []
    for place, shift in ((0.0999, 0), (0.0499, 25)):
        frame = framed(0.3, ((place, 0.05), (place - 0.05, 0.02)))
        frame = frame._replace(numbers=frame.numbers | dict.fromkeys(SIDES[:2], 0.1))
        on = sheet(scene, seen, cells=50, closest=1e-3)
        heights.append(np.roll(surface(frame, on), shift, axis=1))
    highest = float(np.abs(heights[0]).max())
    assert highest > 1e-6
    assert heights[0] == pytest.approx(heights[1], abs=1e-3 * highest)
