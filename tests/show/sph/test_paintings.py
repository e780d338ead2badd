"""A picture of a liquid has it where it is, in the colors that its bar explains."""

import time
from pathlib import Path

import numpy as np
import pytest
from PIL import ImageColor

from ecume.errors import BadInput
from ecume.show.movies import MovieOptions, film, picture_of
from ecume.show.picture import Eye, Species
from ecume.show.sph.picture import liquid_picture
from ecume.show.style import RIM
from ecume.show.tank import seen

from .conftest import SPACING, carrying, frame_of, scene_of

pytestmark = pytest.mark.sampled(2)


def colored(pixels):
    """Where a picture is neither white nor gray."""
    rgb = pixels[..., :3].astype(int)
    return np.ptp(rgb, axis=-1) > 40


def green(pixels):
    """Where it is green."""
    return colored(pixels) & (pixels[..., 1] > pixels[..., 0])


def test_the_liquid_is_seen_where_it_is(scene):
    picture = liquid_picture(scene, [frame_of()])
    left, right = (colored(picture.pixels(frame_of(length=length))) for length in (1.0, 2.0))
    columns = np.flatnonzero(left[:, :700].sum(axis=0) > 50)
    wide = np.flatnonzero(right[:, :760].sum(axis=0) > 50)
    assert (columns[0], 2 * np.ptp(columns)) == (pytest.approx(wide[0], abs=1), pytest.approx(np.ptp(wide), abs=12))
    assert np.ptp(np.flatnonzero(left[:, :700].sum(axis=1) > 50)) == pytest.approx(np.ptp(columns) / 2, abs=4)


def test_pressure_is_brightest_at_the_bottom_and_speed_at_the_top(scene):
    for color, brightest in (("pressure", -1), ("speed", 0), (None, -1)):
        pixels = liquid_picture(scene, [frame_of()], color=color).pixels(frame_of())
        rows = np.flatnonzero(colored(pixels)[:, 100:700].sum(axis=1) > 200)
        green = [pixels[rows[end], 100:700, 1].mean() for end in (0, -1)]
        assert np.argmax(green) == brightest % 2


def test_without_gravity_speed_is_shown():
    weightless = scene_of(gravity=[0.0, 0.0], liquid={"sound_speed": 40.0, "maximum_speed": 4.0})
    assert liquid_picture(weightless, [frame_of()]).coloring.label == "speed"


def test_an_unknown_color_is_refused_with_what_was_meant(scene, frames, tmp_path):
    with pytest.raises(BadInput, match="'sped'; did you mean speed"):
        film(frames, scene, tmp_path / "a.gif", MovieOptions(size=(96, 72), color="sped"))


def test_one_peak_does_not_pale_all_other_particles(scene):
    frame = frame_of()
    peak = frame._replace(arrays={**frame.arrays, "pressure": frame.arrays["pressure"].copy()})
    peak.arrays["pressure"][7] = 1e9
    assert liquid_picture(scene, [peak]).mapping.get_clim()[1] < 1e4


def test_what_is_nearer_hides_what_is_farther():
    camera = Eye(0.0, 0.0).camera()
    assert seen(np.array([[1.0, 2.0, 3.0]]), camera) == pytest.approx(np.array([[1.0, 2.0]]))
    cube = scene_of(dimension=3)
    frame = frame_of(dimension=3)
    picture = liquid_picture(cube, [frame], color="region", particles=True)
    near = frame.arrays["position"] @ picture.setting.camera[2] > 0.9
    two = frame._replace(arrays={**frame.arrays, "species": near.astype(np.int64)})
    picture.setting = picture.setting._replace(kinds=[Species("far", "#ff0000"), Species("near", "#00ff00")])
    alone = two._replace(arrays={name: array[near] for name, array in two.arrays.items()})
    both, only = (green(picture.pixels(shown)) for shown in (two, alone))
    assert 0 < both.sum() < colored(picture.pixels(two)).sum()
    assert both.sum() == pytest.approx(only.sum(), rel=0.03)


@pytest.mark.compiled
def test_five_thousand_particles_are_drawn_many_times_a_second():
    rng = np.random.default_rng(1)
    frame = frame_of()
    position = rng.uniform([0, 0], [2.0, 1.0], (5000, 2))
    many = frame._replace(arrays={"position": position, "pressure": position[:, 0], "velocity": position})
    picture = liquid_picture(scene_of(spacing=SPACING / 3), [many])
    picture.pixels(many)
    start = time.process_time()
    for _ in range(3):
        picture.pixels(many)
    assert (time.process_time() - start) / 3 < 0.4


@pytest.mark.parametrize("color", ["pressure", "speed", "region"])
def test_what_is_carried_keeps_its_color_and_does_not_stretch_the_liquid_s(color):
    scene = scene_of(passive_tracers=[{"positions": [[1.0, 0.25]], "color": "#ff0000"}])
    frame = carrying(frame_of())
    picture = liquid_picture(scene, [frame], color=color)
    red = (picture.pixels(frame)[..., :3] == (255, 0, 0)).all(axis=-1)
    assert red.sum() > 50
    assert picture.mapping is None or picture.mapping.get_clim()[1] < 1e4


def test_a_drop_that_swings_between_few_frames_is_never_cut_off():
    sides = {side: {"kind": "open"} for side in ("left", "right", "bottom", "top")}
    scene = scene_of(tank={"low": [-9.0, -9.0], "high": [9.0, 9.0], **sides})
    still, frames = frame_of(), []
    for step in range(161):  # four swings
        stretched = still.arrays["position"] * (1.0 + 0.5 * np.sin(np.pi * step / 40.0) ** 2)
        frames.append(still._replace(time=0.1 * step, arrays={**still.arrays, "position": stretched}))
    picture = picture_of(scene, frames, MovieOptions(size=(240, 180)), Path("a.png"))
    assert picture.view.right > max(frame.arrays["position"][:, 0].max() for frame in frames) + 0.6 * SPACING


def walled(left):
    """Which parts of the left side, the floor and the open top have the color of walls, where liquid touches them."""
    sides = {"left": {"kind": left}, "right": {"kind": left}, "top": {"kind": "open"}}
    scene = scene_of(tank={"low": [0.0, 0.0], "high": [2.0, 1.0], **sides})
    picture = liquid_picture(scene, [frame_of()])
    shown = picture.pixels(frame_of())[::-1, :, :3].astype(int)
    dark = np.abs(shown - ImageColor.getrgb(RIM)).max(axis=-1) < 20
    (x0, y0), (x1, y1) = picture.figure.axes[0].transData.transform([(0.0, 0.0), (2.0, 1.0)]).round().astype(int)
    _, wet = picture.figure.axes[0].transData.transform((0.0, 0.5)).astype(int)
    side, floor = dark[y0 + 9 : wet - 9, x0 - 1 : x0 + 1], dark[y0 - 1 : y0 + 1, x0 + 9 : x1 - 9]
    top = dark[y1 - 2 : y1 + 2, x0 + 9 : x1 - 9]
    return side.any(axis=1).mean(), floor.any(axis=0).mean(), top.mean()


def test_walls_stand_before_the_liquid_and_where_a_side_is_open_there_is_none():
    assert walled("wall") == (1.0, 1.0, 0.0)
    assert walled("open") == (0.0, 1.0, 0.0)
    dotted, *others = walled("periodic")
    assert 0.0 < dotted < 0.6
    assert others == [1.0, 0.0]
