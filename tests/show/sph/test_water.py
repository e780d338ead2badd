"""Water in 3D is seen where its particles are, inside the tank, translucent, with solids in it."""

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from ecume.show.picture import Eye, Size
from ecume.show.sph.picture import liquid_picture
from ecume.show.sph.water import scenery_of, water_color
from ecume.trajectories.frame import Frame

from .conftest import scene_of

SMALL = Size(160, 120)
SPACING = 0.1


def cube(**more):
    """A tank of side 1 m, half full."""
    low, high = [0.0] * 3, [1.0] * 3
    fluid = [{"low": low, "high": [1.0, 0.5, 1.0]}]
    tank = {"low": low, "high": high, "top": {"kind": "open"}}
    return scene_of(dimension=3, spacing=SPACING, tank=tank, fluid=fluid, **more)


def liquid(height=0.5, keep=lambda place: np.ones(len(place), bool)):
    """Its particles at rest."""
    axes = [SPACING * (np.arange(round(side / SPACING)) + 0.5) for side in (1.0, height, 1.0)]
    place = np.stack([grid.ravel() for grid in np.meshgrid(*axes, indexing="ij")], axis=1)
    place = place[keep(place)]
    arrays = {
        "position": place,
        "velocity": np.zeros_like(place),
        "pressure": 0.5 - place[:, 1],
        "density": np.full(len(place), 1000.0),
        "mass": np.full(len(place), 1000.0 * SPACING**3),
        "species": np.zeros(len(place), np.int64),
    }
    return Frame(0.0, arrays, {}, {})


def blue(pixels):
    """Where a picture is bright, and bluer than red."""
    rgb = pixels[..., :3].astype(int)
    return (rgb[..., 2] - rgb[..., 0] > 20) & (rgb[..., 2] > 110)


def test_the_volume_of_the_region_is_that_of_the_liquid_and_its_surface_is_level():
    found = scenery_of(cube(), liquid(), np.zeros((500, 0)))
    level, grid = found.region.level, found.grid
    part = np.clip(0.5 + level / 0.56 * SPACING / grid.cell[1], 0.0, 1.0)
    assert part.sum() * np.prod(grid.cell) == pytest.approx(0.5, rel=0.02)
    columns = level.transpose(0, 2, 1).reshape(-1, grid.shape[1])
    heights = [np.interp(0.0, column[::-1], grid.centers(1)[::-1]) for column in columns]
    assert heights == pytest.approx(np.full(len(heights), 0.5), abs=0.02 * SPACING)


def test_water_is_seen_inside_its_tank_and_nowhere_else():
    scene, frame = cube(), liquid()
    picture = liquid_picture(scene, [frame], SMALL, eye=Eye(0.0, 0.0))
    wet = blue(picture.pixels(frame))
    _, top = picture.figure.axes[0].transData.transform((0.0, 1.0))
    wet[: len(wet) - int(top)] = False  # there is the time
    (left, floor), (right, level) = picture.figure.axes[0].transData.transform([(0.0, 0.0), (1.0, 0.5)])
    rows, columns = np.nonzero(wet)
    assert (columns.min(), columns.max()) == (pytest.approx(left, abs=2), pytest.approx(right, abs=2))
    assert (len(wet) - rows.max(), len(wet) - rows.min()) == (pytest.approx(floor, abs=3), pytest.approx(level, abs=3))
    inside = wet[len(wet) - int(level) + 3 : len(wet) - int(floor) - 3, int(left) + 3 : int(right) - 3]
    assert inside.mean() > 0.97


def test_a_quantity_colors_the_surface_where_one_is_chosen():
    scene, frame = cube(), liquid()
    picture = liquid_picture(scene, [frame], SMALL, color="pressure", eye=Eye(0.0, 0.0))
    assert picture.figure.axes[1].get_ylabel().startswith("gauge pressure")
    pixels = picture.pixels(frame).astype(int)
    (middle, floor), (_, level) = picture.figure.axes[0].transData.transform([(0.5, 0.0), (0.5, 0.5)])
    low, high = (pixels[len(pixels) - int(y), int(middle), :3] for y in (floor + 4, level - 4))
    assert low[1] > high[1] + 40


def test_solids_are_seen_through_the_water():
    block = {"low": [0.3, 0.0, 0.3], "high": [0.7, 0.3, 0.7], "color": "#ff0000"}
    scene = cube(obstacles=[block])

    def outside(place):
        return ~((place > [0.3, 0.0, 0.3]) & (place < [0.7, 0.3, 0.7])).all(axis=1)

    frame = liquid(keep=outside)
    picture = liquid_picture(scene, [frame], SMALL, eye=Eye(0.0, 0.0))
    pixels = picture.pixels(frame).astype(int)
    (x, y), (beside, _) = picture.figure.axes[0].transData.transform([(0.5, 0.15), (0.12, 0.15)])
    there, water = pixels[len(pixels) - int(y), int(x), :3], pixels[len(pixels) - int(y), int(beside), :3]
    assert there[0] > there[2]
    assert water[2] > water[0] + 30


def test_a_post_fills_its_frame_up_to_the_corners():
    """On the grid of the liquid edges are rounded by a good tenth of a spacing."""
    low, high = np.array([0.4, 0.0, 0.4]), np.array([0.6, 0.8, 0.6])
    found = scenery_of(cube(obstacles=[{"low": low.tolist(), "high": high.tolist()}]), liquid(), np.zeros((500, 0)))
    corners = np.stack(np.meshgrid(*np.stack([low, high], axis=1), indexing="ij"), axis=-1).reshape(-1, 3)
    inside = corners + 0.09 * SPACING * np.sign(0.5 * (low + high) - corners)
    places = (inside - found.grid.low) / found.grid.cell - 0.5
    assert (map_coordinates(found.solid, places.T, order=1, mode="nearest") > 0.0).all()


@pytest.mark.parametrize(("liquid", "color"), [({}, "#4f9fd8"), ({"name": "mercury"}, "#b3b8be")])
def test_a_substance_has_its_color(liquid, color):
    assert water_color(cube(liquid={"sound_speed": 40.0, **liquid})) == color
