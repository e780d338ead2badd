"""From a film to tracks and from tracks to a surface tension, for a film with a known one."""

import math

import numpy as np
import pytest

from ecume.cli.fits import track
from ecume.engine.ffmpeg import pictures_of
from ecume.errors import BadInput, StorageError
from ecume.fitting import Camera, fit, read_tracks
from ecume.fitting.films import FilmTracks, Search, _centered, at_rest, film_tracks, table_of_tracks
from ecume.scenes.schema import from_plain
from ecume.show.floating.bowl import Bowl
from ecume.show.movies import encode
from ecume.show.overlay import Scale, overlay
from ecume.show.picture import Size
from ecume.simulation import simulate

pytest.importorskip("trackpy")
pytest.importorskip("imageio_ffmpeg")

TENSION = 0.0728
BEADS = {
    "model": "floating", "duration": 1.0, "frame_every": 0.04,
    "liquid": {"density": 998.0, "viscosity": 0.01, "surface_tension": TENSION},
    "particles": [
        {
            "radius": 1e-3, "density": 1250.0, "contact_angle": math.pi / 2, "color": "black",
            "positions": [[-3e-3, 0.0], [3e-3, 0.0]],
        },
    ],
}  # fmt: skip


def spots(path, positions, radius, shape=(120, 160), rate=25, dark=False):
    """A film of discs; positions (T, N, 2) in pixels from the lower left corner."""
    rows, columns = np.mgrid[0 : shape[0], 0 : shape[1]]
    pictures = []
    for places in positions:
        light = np.zeros(shape)
        for x, y in places:
            away = np.hypot(columns - x, shape[0] - 1 - rows - y)
            light = np.maximum(light, np.clip(radius + 0.5 - away, 0.0, 1.0))
        picture = np.uint8(np.round(40 + 180 * (1.0 - light if dark else light)))
        pictures.append(np.repeat(picture[:, :, None], 3, axis=2))
    return encode(iter(pictures), path, rate)


def moving(count=12):
    steps = np.arange(count)[:, None]
    return np.stack(
        [np.hstack([40 + 1.3 * steps, 60 + 0.4 * steps]), np.hstack([110 - 0.9 * steps, 50.0 + 0 * steps])], 1
    )


@pytest.mark.long
@pytest.mark.parametrize("dark", [False, True])
def test_discs_are_found_where_they_are_and_keep_their_names(tmp_path, dark):
    path = spots(tmp_path / "discs.mp4", moving(), 6.0, dark=dark)
    found = film_tracks(path, Search(12.0, 2, dark), rate=50.0)
    assert found.size == (160, 120)
    np.testing.assert_allclose(found.times, np.arange(12) / 50.0)
    order = np.argsort(found.position[0, :, 0])
    np.testing.assert_allclose(found.position[:, order], moving(), atol=0.25)
    table = read_tracks(keep(tmp_path / "discs.csv", table_of_tracks(found)), Camera(pixel=1e-5))
    np.testing.assert_allclose(table.position[:, order], 1e-5 * moving(), atol=2.5e-6)


def keep(path, text):
    path.write_text(text)
    return path


def test_water_that_is_darker_on_one_side_moves_no_center():
    """Menisci shade the water between two floats, here down to half of the brightness of a disc over its width."""
    place = np.array([60.3, 48.6])
    rows, columns = np.mgrid[0:100, 0:120]
    cover = np.clip(20.5 - np.hypot(columns - place[0], rows - place[1]), 0.0, 1.0)
    water = 130.0 - 1.2 * (columns - place[0]) + 0.7 * (rows - place[1])
    assert _centered(-(1.0 - cover) * water, place + 3.0, 40.0) == pytest.approx(place, abs=0.02)


def test_a_part_of_the_picture_has_its_objects_alone(tmp_path):
    path = spots(tmp_path / "discs.mp4", moving(), 6.0)
    found = film_tracks(path, Search(12.0, box=(80, 0, 80, 120)))
    assert found.position.shape[1] == 1
    np.testing.assert_allclose(found.position[:, 0], moving()[:, 1], atol=0.25)


@pytest.mark.parametrize(
    ("search", "says"),
    [
        (Search(0.5), "2 to 1000"),
        (Search(12.0, box=(100, 0, 80, 120)), "160 x 120"),
    ],
)
def test_a_search_of_no_use_is_refused(tmp_path, search, says):
    path = spots(tmp_path / "discs.mp4", moving(), 6.0)
    with pytest.raises(BadInput, match=says):
        film_tracks(path, search)


def test_what_is_no_film_is_refused(tmp_path):
    with pytest.raises(BadInput, match="as a film"):
        film_tracks(keep(tmp_path / "no.mp4", "no film"), Search(12.0))
    with pytest.raises(StorageError, match="no such file"):
        film_tracks(tmp_path / "absent.mp4", Search(12.0))


@pytest.mark.long
@pytest.mark.compiled
def test_a_film_of_a_known_surface_tension_gives_it_back(tmp_path):
    """The film is the movie that ecume makes; only the size of a pixel is known from it."""
    scene = from_plain(BEADS)
    frames = list(simulate(scene))
    picture = Bowl(scene, frames, Size(640, 480))
    path = encode((picture.pixels(frame).copy() for frame in frames), tmp_path / "beads.mp4", 25)
    axes, view = picture.figure.axes[0], picture.view
    ends = axes.transData.transform([(view.left, view.bottom), (view.right, view.top)])
    pixel = view.width / (ends[1, 0] - ends[0, 0])
    left, top, right, bottom = round(ends[0, 0]), round(480 - ends[1, 1]), round(ends[1, 0]), round(480 - ends[0, 1])
    box = (left, top, right - left, round(0.8 * (bottom - top)))
    found = film_tracks(path, Search(2e-3 / pixel, 2, dark=True, box=box))
    table = read_tracks(keep(tmp_path / "beads.csv", table_of_tracks(found)), Camera(pixel=pixel))
    guess = {**BEADS, "liquid": {**BEADS["liquid"], "surface_tension": 0.06}}
    result = fit(table, from_plain(guess), ["surface_tension"])
    (tension,) = result.estimates
    assert tension.low <= TENSION <= tension.high
    assert tension.high - tension.low < 0.1 * TENSION
    assert result.noise < pixel
    shown = overlay(path, result, Scale(pixel, (0.0, 0.0)), tmp_path / "overlay.mp4")
    pairs = zip(pictures_of(shown, "rgb24"), pictures_of(path, "rgb24"), strict=True)
    changed = [np.abs(one.astype(int) - other).max(axis=2) > 60 for one, other in pairs]
    assert len(changed) == len(frames)
    _, columns = np.nonzero(changed[0])
    assert columns.min() == pytest.approx(found.position[0, :, 0].min() - 1e-3 / pixel, abs=4.0)


def test_an_object_that_never_moves_is_reported_as_a_part_of_the_picture(tmp_path, capsys, monkeypatch):
    """The bar of a scale was tracked instead of a bead, in silence."""
    steps = np.arange(12)[:, None]
    bar = np.hstack([110 + 0.1 * np.sin(steps), 50.0 + 0 * steps])
    found = FilmTracks(np.arange(12) / 50.0, np.stack([moving()[:, 0], bar], 1), (160, 120))
    assert at_rest(found, 12.0) == [(pytest.approx(110.0, abs=0.1), 50.0)]
    assert at_rest(found._replace(position=moving()), 12.0) == []
    monkeypatch.setattr("ecume.fitting.films.film_tracks", lambda *given: found)
    (tmp_path / "film.mp4").touch()
    track(tmp_path / "film.mp4", diameter="12 px", out=tmp_path / "film.csv")
    assert "1 of 2 objects do not move, at (110, 50) px" in capsys.readouterr().err


def test_tracking_does_not_replace_a_table(tmp_path):
    there = tmp_path / "film.csv"
    there.write_text("t,x,y,id\n")
    with pytest.raises(BadInput, match="exists already; choose another name with -o, or replace it with --force"):
        track(tmp_path / "film.mp4", diameter="12 px", out=there)
    assert there.read_text() == "t,x,y,id\n"
