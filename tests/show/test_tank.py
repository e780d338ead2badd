from dataclasses import replace

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.scenes.tracers import ObstacleSpec, OpeningSpec, ParticleSpec, TankSpec, TracersScene
from ecume.show.picture import Size
from ecume.show.tank import Coloring, Round, Setting, Tank
from ecume.show.tracer_measures import MEASURES
from ecume.show.tracers import TRACER_FIGURES, setting_of, tracers_picture, wall_names
from ecume.trajectories.frame import Frame, RecordedArrays

BLUE, RED = (0, 0, 255), (255, 0, 0)


def frame(time, height):
    position = np.array([[0.5, height], [0.8, 0.2]])
    arrays = {
        "position": position, "radius": np.array([0.1, 0.1]), "species": np.array([0, 1]),
        "speed": np.array([0.0, 2.0]), "left": np.array([-1, -1]),
    }  # fmt: skip
    numbers = {
        "kinetic_energy": 1.0 - time,
        "potential_energy": time,
        "total_energy": 1.0,
        "hits_on_wall_0": 3.0 * time,
    }
    units = {"kinetic_energy": "J", "potential_energy": "J", "total_energy": "J"}
    return Frame(time, arrays, numbers, units)


FRAMES = [frame(0.0, 0.9), frame(0.5, 0.5), frame(1.0, 0.1)]
BALLS = tuple(ParticleSpec(radius=0.1, density=2.0, color=color) for color in ("#0000ff", "#ff0000"))
SCENE = TracersScene(
    duration=1.0,
    frame_every=0.5,
    particles=BALLS,
    tank=TankSpec(high=(1.0, 1.0)),
    obstacles=(ObstacleSpec(low=(0.0, 0.4), high=(0.2, 0.6)), ObstacleSpec(center=(0.1, 0.9), radius=0.05)),
    openings=(OpeningSpec(wall=1, low=(0.4, 0.0), high=(0.6, 0.0)),),
)


def pixel(picture, shown, x, y):
    """The color at a point of the tank."""
    pixels = picture.pixels(shown)
    across, down = picture.figure.axes[0].transData.transform((x, y))
    return tuple(int(value) for value in pixels[pixels.shape[0] - int(down), int(across), :3])


def test_particles_are_where_they_are_in_the_color_of_their_species():
    picture = tracers_picture(SCENE, FRAMES, Size(480, 360))
    assert pixel(picture, FRAMES[0], 0.5, 0.9) == BLUE
    assert pixel(picture, FRAMES[2], 0.5, 0.1) == BLUE
    assert pixel(picture, FRAMES[2], 0.8, 0.2) == RED
    assert pixel(picture, FRAMES[2], 0.5, 0.9) not in (BLUE, RED)


def test_a_quantity_may_color_them_and_the_bar_says_its_unit():
    setting = Setting("title", Round(0.5, 0.5, 0.6))
    picture = Tank(setting, FRAMES, Size(480, 360), Coloring(lambda shown: shown.arrays["speed"], "speed", "m/s"))
    slow, fast = pixel(picture, FRAMES[1], 0.5, 0.5), pixel(picture, FRAMES[1], 0.8, 0.2)
    assert sum(fast) > sum(slow) + 100
    assert picture.figure.axes[1].get_ylabel() == "speed (m/s)"
    assert picture.figure.axes[1].get_ylim() == pytest.approx((0.0, 2.0))


def test_the_setting_has_every_obstacle_and_opening():
    setting = setting_of(SCENE)
    assert [type(body) for body in setting.bodies] == [np.ndarray, Round]
    assert setting.gaps[0].tolist() == [[0.4, 0.0], [0.6, 0.0]]


def test_walls_have_names_in_the_order_of_their_numbers():
    sides = ["left", "floor", "right", "ceiling"]
    assert wall_names(SCENE) == [*sides, *(f"obstacle 1, {side}" for side in sides), "obstacle 2"]


def measured(time):
    """A frame of particles of which one is deposited, and others have left since."""
    spread = np.linspace(0.1, 0.9, 9)
    position = np.stack([0.1 + 0.5 * time * spread, spread], axis=1)
    left = np.array([-1] * 5 + [0 if time > 0.3 else -1, 0 if time > 0.7 else -1, 1 if time > 0.4 else -1, -1])
    arrays = {"position": position, "left": left, "species": np.zeros(9, int), "speed": spread}
    numbers = {"left_through_opening_0": float((left == 0).sum()), "deposited_on_wall_1": float((left == 1).sum())}
    return Frame(time, arrays, numbers, {})


@pytest.mark.parametrize("name", MEASURES)
def test_every_figure_of_measures_has_curves_and_errors(name):
    drawn = MEASURES[name]([measured(time) for time in (0.0, 0.5, 1.0)], SCENE)
    axes = drawn.axes[0]
    assert axes.get_ylabel()
    assert len(axes.lines) + len(axes.patches) > 0
    assert len(axes.collections) > 0


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("residence", "0 particles have left"),
        ("breakthrough", "no openings"),
        ("deposition", "no particle is deposited"),
        ("efficiency", "no wall and no obstacle holds particles"),
    ],
)
def test_a_run_without_the_quantity_says_so(name, words):
    with pytest.raises(BadInput, match=words):
        MEASURES[name](FRAMES, SCENE)


@pytest.mark.parametrize("name", [name for name in TRACER_FIGURES if name not in MEASURES])
def test_every_figure_of_tracers_draws_what_it_says(name):
    drawn = TRACER_FIGURES[name](FRAMES, SCENE)
    assert drawn.axes[0].get_xlabel() or drawn.axes[0].get_ylabel()
    assert len(drawn.axes[0].lines) + len(drawn.axes[0].patches) > 0


def larger(frame, radii, left):
    """A frame with these particles."""
    count = len(radii)
    arrays = {
        "position": np.stack([np.linspace(0.2, 0.8, count), np.full(count, 0.5)], axis=1), "radius": np.array(radii),
        "species": np.zeros(count, int), "speed": np.zeros(count), "left": np.array(left),
    }  # fmt: skip
    return frame._replace(arrays=arrays, numbers={**frame.numbers, "left_through_opening_0": 0.0})


def blue_pixels(picture, frame):
    return int((np.abs(picture.pixels(frame)[..., :3].astype(int) - BLUE).max(axis=-1) < 60).sum())


@pytest.mark.parametrize("first", [2, 1500])
def test_particles_that_enter_have_their_own_size_and_those_that_left_are_gone(first):
    """Also among so many that they are painted: sizes are those of the frame, not of the first one."""
    start = larger(FRAMES[0], [1e-3] * first, [-1] * first)
    picture = tracers_picture(SCENE, [start], Size(400, 400))
    few = blue_pixels(picture, start)
    entered = larger(FRAMES[1], [1e-3] * first + [0.1], [-1] * (first + 1))
    assert blue_pixels(picture, entered) > few + 2000
    gone = larger(FRAMES[2], [1e-3] * first + [0.1], [-1] * first + [0])
    assert blue_pixels(picture, gone) == pytest.approx(few, rel=0.1)


def test_where_nothing_can_leave_pictures_need_no_record_of_it():
    """As of a scene whose `output.quantities` omit it."""
    shown = FRAMES[0]._replace(arrays=RecordedArrays({**FRAMES[0].arrays}, ("left",)))
    del shown.arrays["left"]
    picture = tracers_picture(replace(SCENE, openings=()), [shown], Size(480, 360))
    assert pixel(picture, shown, 0.5, 0.9) == BLUE
