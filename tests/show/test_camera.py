"""Pictures look closer, after one particle, and from where they are asked to; many processes draw the same ones."""

from types import SimpleNamespace

import numpy as np
import pytest

import ecume
from ecume.errors import BadInput
from ecume.run import runner
from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder
from ecume.scenes.tracers import ObstacleSpec, ParticleSpec, TankSpec, TracersScene
from ecume.show.movies import MovieOptions, drawn_by_many, film, movie, picture_of
from ecume.show.picture import STANDING, WIDE, Aim, Eye, Size, aimed, wires_of
from ecume.show.soft.packing import Packing, soft_picture
from ecume.show.tracers import tracers_picture
from ecume.trajectories.frame import Frame

BLUE, RED = "#0000ff", "#ff0000"
SIZE = Size(480, 360)


def frame(time, places):
    position = np.array(places, dtype=float)
    count = len(position)
    arrays = {
        "position": position, "radius": np.full(count, 0.1), "species": np.arange(count), "left": np.full(count, -1),
    }  # fmt: skip
    return Frame(time, arrays, {}, {})


FRAMES = [frame(0.0, [(0.5, 0.6), (0.7, 0.4)]), frame(1.0, [(0.4, 0.45), (0.7, 0.4)])]


def scene(size=(1.0, 1.0), **more):
    kinds = tuple(ParticleSpec(radius=0.1, density=2.0, color=color) for color in (BLUE, RED))
    return TracersScene(duration=1.0, frame_every=0.5, particles=kinds, tank=TankSpec(high=size), **more)


def columns_of(pixels, blue):
    """How wide one color is, and where its middle is, as parts of the picture."""
    rgb = pixels[:, : pixels.shape[1] * 2 // 3, :3].astype(int)  # further right is the legend
    here = rgb[..., 2 if blue else 0] - rgb[..., 0 if blue else 2] > 60
    rows, columns = np.nonzero(here)
    return np.ptp(columns) + 1, columns.mean(), rows.mean()


def middle_of(picture):
    box = picture.figure.axes[0].bbox
    return (box.x0 + box.x1) / 2, picture.figure.bbox.height - (box.y0 + box.y1) / 2


def test_twice_as_large_is_twice_as_large():
    plain = tracers_picture(scene(), FRAMES, SIZE)
    width, across, down = columns_of(plain.pixels(FRAMES[1]), blue=True)
    middle = middle_of(plain)
    closer = aimed(tracers_picture(scene(), FRAMES, SIZE), Aim(2.0))
    again = columns_of(closer.pixels(FRAMES[1]), blue=True)
    assert again[0] == pytest.approx(2 * width, abs=2)
    assert again[1] - middle[0] == pytest.approx(2 * (across - middle[0]), abs=2)
    assert again[2] - middle[1] == pytest.approx(2 * (down - middle[1]), abs=2)


def test_who_is_followed_stays_in_the_middle_and_the_others_move():
    after = aimed(tracers_picture(scene(), FRAMES, SIZE), Aim(1.1, follow=0))
    places = []
    for shown in FRAMES:
        pixels = after.pixels(shown)
        assert columns_of(pixels, blue=True)[1:] == pytest.approx(middle_of(after), abs=2)
        places.append(columns_of(pixels, blue=False)[1:])
    assert places[1][0] > places[0][0] + 20
    assert places[1][1] < places[0][1] - 20  # rows go down


def test_the_scale_bar_says_what_is_seen():
    def output(picture):
        bar, text = picture.bars
        left, right = bar.get_xdata()
        number, unit = text.get_text().split()
        return float(number) * {"mm": 1e-3, "m": 1.0, "cm": 1e-2}[unit] / (right - left)

    for zoom in (1.0, 3.0, 7.0):
        picture = aimed(tracers_picture(scene(), FRAMES, SIZE), Aim(zoom))
        low, high = picture.figure.axes[0].get_xlim()
        assert output(picture) == pytest.approx(high - low)


def test_nothing_asked_is_nothing_changed():
    picture = tracers_picture(scene(), FRAMES, SIZE)
    assert aimed(picture, WIDE) is picture


@pytest.mark.parametrize("one", [-1, 2])
def test_whoever_is_not_there_cannot_be_followed(tmp_path, one):
    with pytest.raises(BadInput, match=f"no particle {one} at 0 s; expected 0 to 1"):
        film(FRAMES, scene(), tmp_path / "a.gif", MovieOptions(aim=Aim(follow=one), size=(96, 72)))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("zoom", [0.0, -1.0, float("nan"), 1e9])
def test_a_zoom_that_shows_nothing_is_refused(zoom):
    with pytest.raises(BadInput, match=r"zoom is .*; expected 2 for twice as large"):
        MovieOptions(aim=Aim(zoom))


def test_an_eye_goes_around_and_above():
    assert Eye(0.0, 0.0).camera() == pytest.approx(np.eye(3))
    assert Eye(90.0, 0.0).camera() @ [1.0, 0.0, 0.0] == pytest.approx([0.0, 0.0, 1.0])
    assert Eye(0.0, 90.0).camera() @ [0.0, 1.0, 0.0] == pytest.approx([0.0, 0.0, 1.0])
    camera = Eye(33.0, 12.0).camera(STANDING)
    assert camera @ camera.T == pytest.approx(np.eye(3))
    assert np.linalg.det(camera) == pytest.approx(1.0)
    assert (camera @ [0.0, 0.0, 1.0])[1] == pytest.approx(np.cos(np.radians(12.0)))


def test_of_a_box_three_edges_are_behind():
    wires = wires_of((0.0, 0.0, 0.0), (1.0, 2.0, 3.0), Eye().camera())
    assert (len(wires.front), len(wires.behind)) == (9, 3)


def test_particles_in_space_are_seen_from_where_the_eye_stands():
    box = scene(size=(1.0, 1.0, 1.0), obstacles=(ObstacleSpec(center=(0.5, 0.5, 0.1), radius=0.05),))
    two = [frame(0.0, [(0.2, 0.2, 0.5), (0.8, 0.8, 0.5)])]
    front = tracers_picture(box, two, SIZE, Eye(0.0, 0.0)).pixels(two[0])
    back = tracers_picture(box, two, SIZE, Eye(180.0, 0.0)).pixels(two[0])
    assert columns_of(front, blue=True)[1] < columns_of(front, blue=False)[1]
    assert columns_of(back, blue=True)[1] > columns_of(back, blue=False)[1]


def test_an_eye_in_a_plane_is_refused(tmp_path):
    with pytest.raises(BadInput, match="for a 2D scene"):
        film(FRAMES, scene(), tmp_path / "a.gif", MovieOptions(eye=Eye(), size=(96, 72)))


def test_many_soft_spheres_in_space_are_balls_in_their_box():
    rng = np.random.default_rng(2)
    several = frame(0.0, rng.uniform(0, 1, (80, 3)))
    several.arrays["species"][:] = 0
    sides = {"box_width": 1.0, "box_height": 1.0, "box_depth": 1.0}
    steady = several._replace(numbers=sides)
    wider = several._replace(numbers={**sides, "box_width": 1.5})
    kinds = SimpleNamespace(title="t", walls=(), kinds=[SimpleNamespace(name="a", color=BLUE)])
    ball = soft_picture(kinds, [steady], SIZE)
    assert not isinstance(ball, Packing)
    assert columns_of(ball.pixels(steady), blue=True)[0] > 100
    moved = soft_picture(kinds, [steady, wider], SIZE)
    assert (moved.pixels(steady).copy() != moved.pixels(wider)).any()


@pytest.mark.long
@pytest.mark.compiled
def test_many_processes_draw_what_one_draws(tmp_path):
    text = (folder() / "two-spheres.toml").read_text()
    run = runner.run(load_scene(text), tmp_path / "run").directory
    options = MovieOptions(size=(96, 72), every=20)
    with ecume.open_trajectory(run) as trajectory:
        shown = options.shown(trajectory)
        picture = picture_of(trajectory.scene, shown, options, tmp_path / "a.gif")
        alone = [picture.pixels(one)[..., :3].copy() for one in shown]
    together = list(drawn_by_many(run, options, tmp_path / "a.gif", 2))
    assert len(alone) == len(together) > 4
    assert all((one == other).all() for one, other in zip(alone, together, strict=True))


@pytest.mark.long
@pytest.mark.compiled
def test_a_movie_by_many_processes_reports_its_progress(tmp_path):
    text = (folder() / "two-spheres.toml").read_text()
    run = runner.run(load_scene(text), tmp_path / "run").directory
    options, heard = MovieOptions(size=(96, 72), every=20), []
    with ecume.open_trajectory(run) as trajectory:
        count = len(options.shown(trajectory))
    movie(run, tmp_path / "a.gif", options, workers=2, progress=lambda *now: heard.append(now))
    assert heard[-1] == (count, count)
