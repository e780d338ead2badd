"""Particles are drawn as discs as large as the spacing, and never outside of walls; pictures fill their frame."""

import numpy as np
import pytest

from ecume.scenes.schema import from_plain
from ecume.show.sph.picture import liquid_picture
from ecume.trajectories.frame import Frame

RED = "#ff0000"


def pictured(high, places, spacing=0.1, top="wall"):
    """A picture of red particles at these places in a tank, and where its axes are in pixels."""
    scene = from_plain(
        {
            "model": "sph", "duration": 0.1, "frame_every": 0.1, "spacing": spacing,
            "tank": {"high": list(high), "top": {"kind": top}},
            "fluid": [{"low": [0.0, 0.0], "high": [high[0], 0.5 * high[1]], "color": RED}],
        }
    )  # fmt: skip
    count = len(places)
    arrays = {
        "position": np.array(places), "velocity": np.zeros((count, 2)), "density": np.full(count, 1e3),
        "pressure": np.zeros(count), "mass": np.ones(count), "species": np.zeros(count, np.int64),
    }  # fmt: skip
    frame = Frame(0.0, arrays, {}, {})
    picture = liquid_picture(scene, [frame], color="region", particles=True)
    return picture, np.array(picture.pixels(frame))[..., :3].astype(int)


def pixel_of(picture):
    """The size of a pixel (m)."""
    return picture.view.width / picture.figure.axes[0].bbox.width


def red_places(picture, pixels):
    """(n, 2) the places of red pixels (m)."""
    rows, columns = np.nonzero((pixels[..., 0] > 200) & (pixels[..., 1] < 60) & (pixels[..., 2] < 60))
    axes = picture.figure.axes[0]
    return axes.transData.inverted().transform(np.column_stack([columns + 0.5, len(pixels) - rows - 0.5]))


@pytest.mark.parametrize("high", [(1.0, 1.0), (2.0, 0.5), (0.4, 2.0)])
def test_a_disc_is_as_large_as_the_spacing(high):
    picture, pixels = pictured(high, [[0.2, 0.25]])
    extent = np.ptp(red_places(picture, pixels), axis=0)
    pixel = pixel_of(picture)
    assert extent == pytest.approx([0.1, 0.1], abs=4.0 * pixel)


def test_nothing_of_a_disc_is_outside_of_walls():
    corners = [[0.01, 0.01], [0.99, 0.01], [0.01, 0.99], [0.99, 0.99], [0.5, 0.01], [0.01, 0.5]]
    picture, pixels = pictured((1.0, 1.0), corners)
    places, pixel = red_places(picture, pixels), pixel_of(picture)
    assert len(places) > 100
    assert places.min() > -pixel
    assert places.max() < 1.0 + pixel
    above = red_places(*pictured((1.0, 1.0), corners, top="open"))
    assert above[:, 1].max() > 1.0 + pixel


@pytest.mark.parametrize("high", [(3.0, 0.4), (0.3, 2.0), (1.0, 1.0)])
def test_a_picture_fills_its_frame_along_one_direction(high):
    """Nothing is left beside the tank but margins, the title, and the bar of colors."""
    picture, pixels = pictured(high, [[0.2, 0.25]])
    box = picture.figure.axes[0].get_position()
    free = (1.0 - box.width) * pixels.shape[1], (1.0 - box.height) * pixels.shape[0]
    assert min(free) < 100.0
