"""Soft spheres as pictures."""

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.scenes.soft import SoftLiquid, SoftScene, SphereSpec
from ecume.show.movies import film
from ecume.show.soft.figures import SOFT_FIGURES
from ecume.show.soft.packing import PULL, PUSH, Packing, links_of
from ecume.trajectories.frame import Frame

UNITS = {"gap": "m", "tension": "N", "elastic_energy": "J"}


@pytest.fixture
def scene():
    spheres = SphereSpec(name="_soft $", radius=1e-3, modulus=1e4, positions=((0.0, 0.0), (2.1e-3, 0.0), (4.5e-3, 0.0)))
    return SoftScene(duration=1.0, frame_every=0.5, liquid=SoftLiquid(viscosity=1.0), spheres=(spheres,))


@pytest.fixture
def frames():
    return [_frame(0.5 * n) for n in range(3)]


def _frame(time, **numbers):
    arrays = {
        "position": np.array([[0.0, 0.0], [2.1e-3, 0.0], [5.1e-3, 0.0]]),
        "radius": np.full(3, 1e-3),
        "species": np.zeros(3, np.int64),
        "neighbor": np.array([[1, 2], [2, -1], [-1, -1]]),
        "gap": np.array([[1e-4 * (1 + time), 3e-3], [1e-3, 0.0], [0.0, 0.0]]),
        "tension": np.array([[2e-6, -1e-9], [-1e-6, 0.0], [0.0, 0.0]]),
    }
    return Frame(time, arrays, {"elastic_energy": 1e-9 * time} | numbers, UNITS)


@pytest.mark.parametrize("name", SOFT_FIGURES)
def test_every_figure_can_be_drawn_or_says_why_not(name, scene, frames):
    if name == "stress":
        with pytest.raises(BadInput, match="no box"):
            SOFT_FIGURES[name](frames, scene)
    else:
        SOFT_FIGURES[name](frames, scene).canvas.draw()


def test_what_pulls_is_red_what_pushes_blue_and_wide_films_are_left_out(scene, frames):
    shown = Packing(scene, frames)
    shown.show(frames[1])
    assert len(shown.forces.get_segments()) == 3
    colors = [tuple(round(255 * c) for c in color[:3]) for color in shown.forces.get_color()]
    assert colors[0] == tuple(bytes.fromhex(PULL[1:]))
    assert colors[1] == colors[2] == tuple(bytes.fromhex(PUSH[1:]))
    assert list(shown.films.get_array()) == pytest.approx([1.5e-4])


def test_a_mark_turns_with_its_sphere(scene, frames):
    still = Packing(scene, frames)
    assert still.marks.get_segments() == []
    half = np.sqrt(0.5)
    for spins in ({"angle": np.full(3, np.pi / 2)}, {"orientation": np.tile([half, 0.0, 0.0, half], (3, 1))}):
        turned = [frame._replace(arrays=frame.arrays | spins) for frame in frames]
        shown = Packing(scene, turned)
        from_center = np.array(shown.marks.get_segments()) - frames[0].arrays["position"][:, None]
        assert from_center[:, :, 0] == pytest.approx(np.zeros((3, 2)), abs=1e-15)
        assert (from_center[:, 1, 1] > from_center[:, 0, 1]).all()
        assert (from_center[:, 0, 1] > 0.0).all()


def test_a_contact_across_a_sheared_border_goes_to_the_nearest_copy():
    frame = _frame(0.0, box_width=6e-3, box_height=4e-3, box_tilt=1e-3)
    frame.arrays["position"][1] = 0.5e-3, 3.9e-3
    along = links_of(frame).along
    assert along[0] == pytest.approx([0.5e-3 - 1e-3, -0.1e-3])


def test_a_movie_can_be_made(scene, frames, tmp_path):
    made = film(frames, scene, tmp_path / "soft.gif")
    assert made.stat().st_size > 1000
