"""A movie of frames has the pictures that were asked for."""

import types

import numpy as np
import pytest
from PIL import Image

from ecume.errors import BadInput, StorageError
from ecume.show import movies
from ecume.show.movies import MovieOptions, film, movie, picture_of
from ecume.show.picture import Eye
from ecume.trajectories.frame import Frame


@pytest.mark.parametrize(("every", "count"), [(1, 11), (2, 6), (5, 3), (100, 1)])
def test_every_nth_frame_is_shown(scene, frames, tmp_path, every, count):
    with Image.open(film(frames, scene, tmp_path / "film.gif", MovieOptions(every=every, size=(160, 120)))) as made:
        assert (getattr(made, "n_frames", 1), made.size) == (count, (160, 120))


def test_progress_hears_of_every_picture(scene, frames, tmp_path):
    heard = []
    options = MovieOptions(every=5, size=(96, 72))
    film(frames, scene, tmp_path / "film.gif", options, progress=lambda *now: heard.append(now))
    assert heard == [(1, 3), (2, 3), (3, 3)]


def test_a_movie_of_a_run_stands_among_its_results(opened, tmp_path, monkeypatch):
    monkeypatch.setattr(movies, "open_trajectory", lambda directory: opened)
    made = movie(tmp_path, options=MovieOptions(size=(96, 72), every=5))
    assert made == tmp_path / "results" / "movie.mp4"
    assert made.stat().st_size > 500


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        ({"fps": 0}, "got fps = 0; expected 1 to 240"),
        ({"every": 0}, "every is 0; expected 1"),
        ({"size": (10, 10)}, "size is 10 x 10; expected from 64"),
        ({"start": 2.0, "end": 1.0}, "from 2 s to 1 s there is no time"),
        ({"color": "taste"}, "'floating' take no color; leave color taste out"),
        ({"eye": Eye()}, "'floating' are seen from above alone; leave azimuth and elevation out"),
    ],
)
def test_what_cannot_be_shown_is_refused(scene, frames, tmp_path, asked, says):
    with pytest.raises(BadInput, match=says):
        film(frames, scene, tmp_path / "film.gif", MovieOptions(**asked))


@pytest.mark.parametrize(
    ("options", "times"),
    [
        (MovieOptions(start=0.3), (0.3, 1.0, 8)),
        (MovieOptions(end=0.3), (0.0, 0.3, 4)),
        (MovieOptions(start=0.25, end=0.75), (0.3, 0.7, 5)),
        (MovieOptions(start=0.3, every=2), (0.3, 0.9, 4)),
        (MovieOptions(end=100.0), (0.0, 1.0, 11)),
    ],
)
def test_a_movie_begins_and_ends_with_the_frames_of_its_times(frames, options, times):
    shown = options.shown(frames)
    assert (shown[0].time, shown[-1].time, len(shown)) == pytest.approx(times)


def test_a_time_in_which_there_is_no_frame_is_refused_with_those_there_are(frames):
    with pytest.raises(BadInput, match="from 2 s on there is no frame; the run has frames from 0 s to 1 s"):
        MovieOptions(start=2.0).shown(frames)


def test_a_model_without_pictures_of_its_own_shows_its_particles(frames, tmp_path):
    plain = types.SimpleNamespace(model="toy", title="toy", kinds=())
    alike = [Frame(0.0, {**frames[0].arrays, "species": 0 * frames[0].arrays["species"]}, {}, {})]
    picture = picture_of(plain, alike, MovieOptions(size=(320, 240)), tmp_path / "film.gif")
    seen = picture.pixels(alike[0])
    assert seen.shape == (240, 320, 4)
    assert np.ptp(seen[..., :3].astype(float), axis=2).max() > 50.0


def test_a_run_without_frames_is_refused(scene, tmp_path):
    with pytest.raises(BadInput, match="no frames yet"):
        film([], scene, tmp_path / "film.gif")


def test_numbered_pictures_appear_when_all_are_whole(tmp_path):
    """A series that fails leaves the former one, and nothing else."""
    picture = np.zeros((4, 4, 3), np.uint8)
    movies.encode([picture] * 3, tmp_path / "film.png", 30)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert set(before) == {f"film-000{number}.png" for number in range(3)}
    (tmp_path / "film-0003.png").mkdir()
    with pytest.raises(StorageError, match=r"film-0003.png: is a folder"):
        movies.encode([picture + 200] * 4, tmp_path / "film.png", 30)
    (tmp_path / "film-0003.png").rmdir()

    def interrupted():
        yield picture + 100
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        movies.encode(interrupted(), tmp_path / "film.png", 30)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
