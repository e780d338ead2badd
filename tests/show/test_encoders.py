"""Movies have as many pictures as went in, of their size; there is always some way to write one."""

import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

from ecume.engine import ffmpeg as ffmpeg_program
from ecume.errors import BadInput, StorageError
from ecume.show import movies


def pictures(count, height=64, width=96):
    for n in range(count):
        picture = np.full((height, width, 4), 255, dtype=np.uint8)
        picture[:, : 8 * n, 0] = 0
        yield picture


def probe(path):
    """The size and the number of pictures of a movie, as ffmpeg decodes it."""
    command = [movies.ffmpeg(), "-v", "error", "-i", str(path), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    return subprocess.run(command, capture_output=True, check=True).stdout


@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize(("count", "suffix"), [(1, ".mp4"), (7, ".mp4"), (7, ".webm")])
def test_a_video_has_every_picture(tmp_path, count, suffix, channels):
    made = (picture[..., :channels] for picture in pictures(count))
    out = movies.encode(made, tmp_path / "deep" / f"film{suffix}", 30)
    raw = np.frombuffer(probe(out), dtype=np.uint8).reshape(-1, 64, 96, 3)
    assert len(raw) == count
    for n, picture in enumerate(raw):
        assert picture[:, : max(8 * n - 4, 0), 0].mean() < 60 if n else picture.mean() > 220
        assert picture[:, 8 * n + 4 :, 0].mean() > 220


@pytest.mark.parametrize("suffix", [".gif", ".webp"])
def test_animations_have_every_picture_and_their_pace(tmp_path, suffix):
    out = movies.encode(pictures(5), tmp_path / f"film{suffix}", 20)
    with Image.open(out) as film:
        assert (film.n_frames, film.size) == (5, (96, 64))
        film.seek(3)
        film.load()
        assert film.info["duration"] == 50
        assert film.info["loop"] == 0


def test_pictures_may_be_numbered_files(tmp_path):
    first = movies.encode(pictures(3), tmp_path / "deep" / "shot.png", 20)
    assert first.name == "shot-0000.png"
    assert sorted(path.name for path in first.parent.iterdir()) == [f"shot-000{n}.png" for n in range(3)]
    with Image.open(first.with_name("shot-0002.png")) as picture:
        assert (np.asarray(picture) == list(pictures(3))[2][..., :3]).all()


def test_a_gif_keeps_the_colors_that_come_later_and_pays_for_what_moves_only(tmp_path):
    shades = np.linspace(0, 255, 64 * 96).reshape(64, 96, 1).repeat(4, axis=2).astype(np.uint8)

    def moving():
        for n in range(30):
            picture = shades.copy()
            picture[8:16, 2 * n : 2 * n + 8] = (255, 0, 0, 255) if n else shades[8:16, :8]
            yield picture

    out = movies.encode(moving(), tmp_path / "film.gif", 20)
    with Image.open(out) as film:
        film.seek(20)
        seen = np.asarray(film.convert("RGB")).astype(int)
    assert tuple(seen[12, 44]) == (255, 0, 0)
    # Pillow looks for the nearest color of a palette in boxes of four shades: it may be four off.
    assert np.abs(seen[20:] - shades[20:, :, :3]).max() <= 4
    alone = movies.encode(iter([shades]), tmp_path / "still.gif", 20)
    assert out.stat().st_size < 0.5 * 30 * alone.stat().st_size


def test_a_gif_keeps_the_colors_of_a_small_color_bar(tmp_path):
    bar = np.linspace([248, 244, 238], [140, 74, 31], 60)
    sea = np.linspace([246, 247, 245], [31, 78, 121], 200 * 300).reshape(200, 300, 3)
    picture = np.full((200, 300, 4), 255, np.uint8)
    picture[:, :, :3] = sea
    picture[100:160, 290:296, :3] = bar[:, None, :]
    out = movies.encode(iter([picture]), tmp_path / "film.gif", 20)
    with Image.open(out) as film:
        seen = np.asarray(film.convert("RGB")).astype(int)
    assert np.abs(seen[100:160, 292] - bar).max() < 12


def test_odd_sides_lose_a_line_and_not_the_movie(tmp_path):
    out = movies.encode(pictures(3, height=65, width=97), tmp_path / "film.mp4", 30)
    assert len(probe(out)) == 3 * 64 * 96 * 3


def test_without_ffmpeg_an_mp4_becomes_a_webp(tmp_path, monkeypatch):
    monkeypatch.setattr(movies, "ffmpeg", lambda: None)
    out = movies.encode(pictures(3), tmp_path / "film.mp4", 30)
    assert out == tmp_path / "film.webp"
    with Image.open(out) as film:
        assert film.n_frames == 3


def test_ffmpeg_is_looked_for_on_the_path_first(monkeypatch):
    monkeypatch.setattr(ffmpeg_program.shutil, "which", lambda name: f"/somewhere/{name}")
    assert movies.ffmpeg() == "/somewhere/ffmpeg"


def test_a_machine_without_the_package_has_no_ffmpeg(monkeypatch):
    monkeypatch.setattr(ffmpeg_program.shutil, "which", lambda name: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    assert movies.ffmpeg() is None


def test_an_unknown_kind_of_movie_is_refused_with_those_there_are(tmp_path):
    with pytest.raises(BadInput, match=r"'.avi'; expected one of .mp4, .webm, .webp, .gif, .png"):
        movies.encode(pictures(1), tmp_path / "film.avi", 30)


def test_a_movie_that_fails_half_way_leaves_the_old_one_alone(tmp_path):
    def broken():
        yield from pictures(2)
        raise RuntimeError("the run is gone")

    out = tmp_path / "film.mp4"
    out.write_text("the old film")
    with pytest.raises(RuntimeError, match="the run is gone"):
        movies.encode(broken(), out, 30)
    assert [path.name for path in tmp_path.iterdir()] == ["film.mp4"]
    assert out.read_text() == "the old film"


def test_what_ffmpeg_complains_about_is_reported(tmp_path, monkeypatch):
    monkeypatch.setitem(movies.CODECS[".mp4"], "libx264", ("-no-such-option", "1"))
    monkeypatch.setattr(movies, "_codec", lambda program, kind: "libx264")
    with pytest.raises(StorageError, match="ffmpeg gave up"):
        movies.encode(pictures(200), tmp_path / "film.mp4", 30)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_a_file_is_a_storage_error(tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(StorageError, match="cannot be written"):
        movies.encode(pictures(1), tmp_path / "taken" / "film.gif", 30)
