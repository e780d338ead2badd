"""A picture of a liquid has it where it is, in the colors that its bar explains."""

import time

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.show.movies import Cut, film
from ecume.show.picture import Species
from ecume.show.space import Eye
from ecume.show.sph.picture import liquid_picture
from ecume.show.tank import seen

from .conftest import SPACING, frame_of, scene_of


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
    weightless = scene_of(gravity=[0.0, 0.0], liquid={"sound_speed": 40.0, "fastest": 4.0})
    assert liquid_picture(weightless, [frame_of()]).coloring.label == "speed"


def test_an_unknown_color_is_refused_with_what_was_meant(scene, frames, tmp_path):
    with pytest.raises(BadInput, match="'sped'; did you mean speed"):
        film(frames, scene, tmp_path / "a.gif", Cut(size=(96, 72), color="sped"))


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
    picture = liquid_picture(cube, [frame], color="region")
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
    carrying = scene_of(carried=[{"positions": [[1.0, 0.25]], "color": "#ff0000"}])
    frame = frame_of()
    arrays = {name: np.concatenate([array, array[:1]]) for name, array in frame.arrays.items()}
    arrays["position"][-1], arrays["pressure"][-1], arrays["species"][-1] = (1.0, 0.25), 1e9, 1
    picture = liquid_picture(carrying, [frame._replace(arrays=arrays)], color=color)
    red = (picture.pixels(frame._replace(arrays=arrays))[..., :3] == (255, 0, 0)).all(axis=-1)
    assert red.sum() > 50
    assert picture.mapping is None or picture.mapping.get_clim()[1] < 1e4
