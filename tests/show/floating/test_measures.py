"""Figures of what floats come to."""

import itertools

import numpy as np
import pytest

import ecume
from ecume.errors import BadInput
from ecume.scenes.load import load_scene
from ecume.show.floating.figures import FLOATING_FIGURES, MEASURES, region_of, two_body_gap
from ecume.trajectories.frame import Frame

SCENE = """
model = "floating"
duration = 1.0
frame_every = 0.1
[[particles]]
count = 7
radius = 1e-3
density = 1300
contact_angle = "90 deg"
[dish]
radius = 0.02
"""


def frames_of(apart, steps=5):
    """Seven floats around one, nearer from frame to frame; in the end they touch."""
    angles = np.arange(6) * np.pi / 3.0
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    found = []
    for step in range(steps):
        spacing = 2e-3 + apart * (1.0 - step / (steps - 1.0))
        position = np.concatenate([[[0.0, 0.0]], spacing * ring])
        found.append(Frame(0.1 * step, {"position": position, "radius": np.full(7, 1e-3)}, {}, {}))
    return found


@pytest.mark.parametrize("name", MEASURES)
def test_each_measure_is_drawn(name):
    drawn = MEASURES[name](frames_of(3e-3), load_scene(SCENE))
    assert drawn.axes[0].get_xlabel()
    assert drawn.axes[0].get_ylabel()


@pytest.mark.parametrize("name", ["approach", "shapes", "displacement"])
def test_what_there_is_nothing_of_is_said(name):
    still = frames_of(3e-3)[:1] * 3
    with pytest.raises(BadInput, match=r"no (approach|rafts|displacement) to draw"):
        MEASURES[name](still, load_scene(SCENE))


def test_the_mean_square_displacement_of_a_long_run_in_a_cell_is_that_of_all_frames():
    # 25 mm/s in a cell of 10 cm, 1,200 frames a second apart: more frames than are drawn, less than half a side each.
    frames = [
        Frame(
            float(n), {"position": np.array([[0.025 * n % 0.1, 0.04]]), "radius": np.full(1, 1e-3)},
            {"box_width": 0.1, "box_height": 0.08}, {},
        )
        for n in range(1200)
    ]  # fmt: skip
    (line,) = MEASURES["displacement"](frames, load_scene(SCENE)).axes[0].lines[:1]
    lag, square = (np.asarray(values) for values in line.get_data())
    assert lag.max() > 800.0
    assert square == pytest.approx((0.025 * lag) ** 2, rel=1e-6)


def test_centers_reach_a_radius_less_far_than_the_dish():
    scene = load_scene(SCENE)
    assert region_of(frames_of(0.0)[0], scene).radius == pytest.approx(0.019)


TWO = """
model = "floating"
duration = "1.4 s"
frame_every = "10 ms"
[[particles]]
radius = "1 mm"
density = 1250.0
contact_angle = "90 deg"
positions = [["-4 mm", "0 mm"], ["4 mm", "0 mm"]]
"""


def test_two_floats_follow_the_equation_of_motion_that_is_drawn_beside_them():
    scene = ecume.load_scene(TWO)
    frames = list(ecume.simulate(scene))
    made = FLOATING_FIGURES["distance"](frames, scene)
    run, contact, solution = (line for line in made.axes[0].lines[:3])
    assert made.axes[0].get_yscale() == "linear"
    assert run.get_ydata()[0] == pytest.approx(6.0)
    meeting = float(solution.get_xdata()[-1])
    assert 0.5 < meeting < 1.4
    assert float(contact.get_xdata()[0]) == pytest.approx(meeting, abs=0.02)
    before = run.get_xdata() < meeting - 0.05
    expected = np.interp(run.get_xdata()[before], solution.get_xdata(), solution.get_ydata())
    assert run.get_ydata()[before] == pytest.approx(expected, abs=0.03)


@pytest.mark.parametrize(
    "changes",
    [
        ["dish.radius=4 cm", "dish.contact_angle=90 deg"],
        ["flow.extension_rate=1"],
        ["particles[0].magnetic_moment=1e-6"],
        ["hydrodynamics.lubrication.roughness=1 um", "hydrodynamics.drag=stokes"],
    ],
)
def test_floats_on_which_something_else_acts_have_no_solution_of_two(changes):
    frames = list(itertools.islice(ecume.simulate(ecume.load_scene(TWO)), 2))
    assert two_body_gap(frames, ecume.load_scene(TWO)) is not None
    assert two_body_gap(frames, ecume.load_scene(TWO, changes)) is None


def test_paths_in_a_cell_continue_on_the_other_side():
    """A float that drifts by 0.2 m through a cell 0.1 m wide is drawn inside, in pieces."""
    cell = SCENE.replace("[dish]\nradius = 0.02", "[cell]\nsize = [0.1, 0.08]").replace("count = 7", "count = 1")
    fixed = {"radius": np.full(1, 1e-3), "species": np.zeros(1, np.int64)}
    frames = []
    for n in range(11):
        image, place = divmod(95 + 20 * n, 100)
        arrays = {"position": np.array([[1e-3 * place, 0.04]]), "image": np.array([[image, 0]]), **fixed}
        frames.append(Frame(0.1 * n, arrays, {"box_width": 0.1, "box_height": 0.08}, {}))
    (axes,) = FLOATING_FIGURES["paths"](frames, load_scene(cell)).axes
    discs, lines, starts = axes.collections
    assert np.asarray(discs.get_offsets()) == pytest.approx(np.array([[95.0, 40.0]]))
    assert np.asarray(starts.get_offsets()) == pytest.approx(np.array([[95.0, 40.0]]))
    pieces = [piece[:, 0] for piece in lines.get_segments()]
    assert pieces[1] == pytest.approx([-5, 15, 35, 55, 75, 95, 115])
    assert all(np.diff(piece) == pytest.approx(20.0) for piece in pieces)


@pytest.mark.parametrize(
    "change",
    [
        {"activity.propulsion": 1e-9},
        {"interaction.method": "multipole"},
        {"particles[0].velocity": [0.0, 0.01]},
        {"integration.integrator": "overdamped", "hydrodynamics.brownian": True},
    ],
)
def test_two_floats_that_more_than_their_law_moves_have_no_solution(change):
    scene = ecume.load_scene(TWO)
    assert two_body_gap([next(ecume.simulate(scene))], scene) is not None
    changed = scene.replace(change)
    assert two_body_gap([next(ecume.simulate(changed))], changed) is None
