"""A movie of frames has the pictures that were asked for."""

import pytest
from PIL import Image

from ecume.errors import BadInput
from ecume.show import movies
from ecume.show.movies import film, movie


@pytest.mark.parametrize(("every", "count"), [(1, 11), (2, 6), (5, 3), (100, 1)])
def test_every_nth_frame_is_shown(scene, frames, tmp_path, every, count):
    with Image.open(film(frames, scene, tmp_path / "film.gif", every=every, size=(160, 120))) as made:
        assert (getattr(made, "n_frames", 1), made.size) == (count, (160, 120))


def test_progress_hears_of_every_picture(scene, frames, tmp_path):
    heard = []
    film(frames, scene, tmp_path / "film.gif", every=5, size=(96, 72), progress=lambda *now: heard.append(now))
    assert heard == [(1, 3), (2, 3), (3, 3)]


def test_a_movie_of_a_run_stands_among_its_results(scene, frames, tmp_path, monkeypatch):
    monkeypatch.setattr(movies, "open_trajectory", lambda directory: Run(frames, scene))
    made = movie(tmp_path, size=(96, 72), every=5)
    assert made == tmp_path / "results" / "movie.mp4"
    assert made.stat().st_size > 500


class Run(list):
    """A trajectory in memory."""

    def __init__(self, frames, scene):
        super().__init__(frames)
        self.scene = scene

    def __enter__(self):
        return self

    def __exit__(self, *error):
        return None


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        ({"fps": 0}, "fps is 0; wanted from 1 to 240"),
        ({"every": 0}, "every is 0; wanted 1"),
        ({"size": (10, 10)}, "size is 10 x 10; wanted from 64"),
    ],
)
def test_what_cannot_be_shown_is_refused(scene, frames, tmp_path, asked, says):
    with pytest.raises(BadInput, match=says):
        film(frames, scene, tmp_path / "film.gif", **asked)


def test_a_run_without_frames_is_refused(scene, tmp_path):
    with pytest.raises(BadInput, match="no frames yet"):
        film([], scene, tmp_path / "film.gif")
