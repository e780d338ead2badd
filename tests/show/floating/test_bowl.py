"""The picture from above shows what is there, where it is, and as large as it is."""

import dataclasses

import numpy as np
import pytest
from matplotlib.colors import to_rgba

from ecume.scenes.floating import ActivitySpec, DishSpec, LiquidSpec
from ecume.show.floating.bowl import BELOW, Bowl, arrows, rises, view_of
from ecume.show.picture import Size, species
from ecume.show.style import PALETTE, contrast, height_colormap, liquid_color

pytestmark = pytest.mark.sampled(2)

SIZE = Size(800, 600)


def pixel_of(bowl, x, y):
    """The column and row (from above) at which a point of the surface is shown."""
    axes = bowl.figure.axes[0]
    column, row_from_below = axes.transData.transform((x, y))
    return column, bowl.figure.bbox.height - row_from_below


def per_meter(bowl):
    return pixel_of(bowl, 1.0, 0.0)[0] - pixel_of(bowl, 0.0, 0.0)[0]


def nearly(color, pixels):
    return np.abs(pixels[..., :3].astype(int) - np.array(to_rgba(color)[:3]) * 255).max(axis=-1) < 40


@pytest.mark.parametrize("index", [0, 1, 4, 5])
def test_a_float_covers_the_pixels_of_its_circle_and_no_others(scene, frames, index):
    bowl = Bowl(scene, frames, Size(2400, 1800))
    picture = bowl.pixels(frames[3])
    arrays = frames[3].arrays
    color = "#ff0000" if arrays["species"][index] == 0 else "#00ff00"
    column, row = pixel_of(bowl, *arrays["position"][index])
    rows, columns = np.indices(picture.shape[:2])
    distance = np.hypot(columns + 0.5 - column, rows + 0.5 - row)
    radius = arrays["radius"][index] * per_meter(bowl)
    edge = 1.5
    assert radius > 15 * edge
    assert nearly(color, picture[distance < radius - edge]).all()
    assert not nearly(color, picture[(distance > radius + edge) & (distance < radius + 3 * edge)]).any()


def test_the_rim_hides_no_float_that_touches_it(scene, frames):
    touching = frames[0].arrays["position"].copy()
    touching[4] = (0.029, 0.0)
    frame = frames[0]._replace(arrays=frames[0].arrays | {"position": touching})
    bowl = Bowl(scene, [frame], Size(2400, 1800))
    picture = bowl.pixels(frame)
    column, row = pixel_of(bowl, 0.03, 0.0)
    assert nearly("#00ff00", picture[int(row), int(column) - 3])


def test_both_directions_have_one_scale(scene, frames):
    bowl = Bowl(scene, frames, Size(900, 400))
    (x0, y0), (x1, y1) = pixel_of(bowl, 0.0, 0.0), pixel_of(bowl, 1e-2, 1e-2)
    assert x1 - x0 == pytest.approx(y0 - y1, rel=1e-9)


def test_a_larger_picture_shows_the_same_larger(scene, frames):
    small, large = Bowl(scene, frames, Size(480, 360)), Bowl(scene, frames, Size(960, 720))
    assert np.array(pixel_of(large, 0.01, 0.02)) == pytest.approx(2 * np.array(pixel_of(small, 0.01, 0.02)))
    assert large.pixels(frames[0]).shape == (720, 960, 4)


def test_a_moved_float_leaves_no_trace(scene, frames):
    one, other = Bowl(scene, frames, SIZE), Bowl(scene, frames, SIZE)
    for frame in frames[:-1]:
        one.pixels(frame)
    assert np.array_equal(one.pixels(frames[-1]), other.pixels(frames[-1]))


def test_a_float_that_turns_bears_a_line_that_turns_with_it(scene, frames):
    first = frames[0]
    turned = first._replace(arrays={**first.arrays, "angle": np.full(len(first.arrays["radius"]), 0.5 * np.pi)})
    (line, *_) = rises(turned)
    place, radius = first.arrays["position"][0], first.arrays["radius"][0]
    half = np.array([0.0, 0.8 * radius])
    assert line == pytest.approx(np.array([place - half, place + half]), rel=1e-12)
    assert len(rises(first)) == 0
    bowl = Bowl(scene, [turned], SIZE)
    bowl.show(turned)
    assert len(bowl.rises.get_segments()) == len(first.arrays["radius"])


def test_the_liquid_ends_at_the_rim(scene, frames):
    bowl = Bowl(scene, frames, SIZE)
    picture = bowl.pixels(frames[0])
    column, row = pixel_of(bowl, 0.0302, 0.0302)
    assert picture[int(row), int(column), :3].tolist() == [255, 255, 255]
    column, row = pixel_of(bowl, -0.0205, 0.0205)
    assert picture[int(row), int(column), :3].tolist() != [255, 255, 255]


def test_the_whole_of_a_rectangular_dish_is_shown(scene, frames):
    wide = dataclasses.replace(scene, dish=DishSpec(size=(0.1, 0.05)))
    view = view_of(wide, frames)
    assert view.left < -0.05 < 0.05 < view.right
    assert view.bottom < -0.025 < 0.025 < view.top
    assert Bowl(wide, frames, SIZE).pixels(frames[0]).shape == (600, 800, 4)


def test_below_a_triangular_dish_there_is_room_for_the_scale_bar(scene, frames):
    corners = ((-0.06, -0.05), (0.06, -0.05), (0.0, 0.08))
    view = view_of(dataclasses.replace(scene, dish=DishSpec(vertices=corners, law="none", image="none")), frames)
    assert view.bottom < -0.05 - BELOW * 0.12


def test_without_a_dish_all_that_floats_ever_reach_is_shown(scene, frames):
    view = view_of(dataclasses.replace(scene, dish=None), frames)
    for frame in frames:
        x, y = frame.arrays["position"].T
        radius = frame.arrays["radius"]
        assert (view.left <= x - radius).all()
        assert (x + radius <= view.right).all()
        assert (view.bottom <= y - radius).all()
        assert (y + radius <= view.top).all()


def test_colors_come_from_the_scene_and_else_from_the_palette(scene):
    cereal, bead = scene.particles
    found = species(dataclasses.replace(scene, particles=(dataclasses.replace(cereal, color=None), bead)))
    assert found == [("cereal", PALETTE[0]), ("_bead", "#00ff00")]


def test_the_color_bar_and_the_scale_bar_carry_units(scene, frames):
    bowl = Bowl(scene, frames, SIZE)
    surface, bar = bowl.figure.axes
    assert bar.get_ylabel() == "height of the liquid (mm)"
    assert "10 mm" in [text.get_text() for text in surface.texts]


def test_a_surface_without_menisci_has_no_color_bar(scene, frames):
    flat = dataclasses.replace(
        scene,
        interaction=dataclasses.replace(scene.interaction, law="none"),
        dish=dataclasses.replace(scene.dish, law="none"),
    )
    assert len(Bowl(flat, frames, SIZE).figure.axes) == 1


def test_the_scale_bar_is_as_long_as_it_says(scene, frames):
    bowl = Bowl(scene, frames, SIZE)
    axes = bowl.figure.axes[0]
    left, right = (axes.transLimits.inverted().transform((end, 0.0))[0] for end in axes.lines[0].get_xdata())
    assert right - left == pytest.approx(0.010)


def test_the_time_is_the_frame_s(scene, frames):
    bowl = Bowl(scene, frames, SIZE)
    bowl.show(frames[7])
    assert bowl.time.get_text() == "0.70 s"


def test_no_words_run_out_of_the_picture(scene, frames):
    bowl = Bowl(dataclasses.replace(scene, title="A very long title " * 9), frames, SIZE)
    bowl.pixels(frames[0])
    surface, bar = bowl.figure.axes
    boxes = [text.get_window_extent() for text in surface.texts]
    for box in [*boxes, bar.get_tightbbox(), surface.get_legend().get_window_extent()]:
        assert box.x0 >= 0
        assert box.y0 >= 0
        assert box.x1 <= SIZE.width
        assert box.y1 <= SIZE.height
    times, titles = bowl.time.get_window_extent(), surface.texts[-1].get_window_extent()
    assert not times.overlaps(titles)


@pytest.mark.parametrize(
    ("liquid", "level"), [({"color": "#fbf8f0"}, "#fbf8f0"), ({"name": "water"}, "#4f9fd8"), ({}, "#f6f7f5")]
)
def test_the_level_surface_has_the_color_of_the_liquid(liquid, level):
    colors = height_colormap(liquid_color(LiquidSpec(**liquid)))
    assert contrast(colors(0.5)[:3], level) < 1.05


@pytest.mark.parametrize("liquid", ["#fbf8f0", "#4f9fd8"])
def test_high_and_low_surfaces_differ_from_the_level_one(liquid):
    colors = height_colormap(liquid)
    assert min(contrast(colors(end)[:3], liquid) for end in (0.0, 1.0)) > 1.8


def test_high_surfaces_of_a_dark_liquid_are_bright():
    assert contrast(height_colormap("#14305c")(1.0)[:3], "#14305c") > 5.0


@pytest.mark.parametrize("liquid", [None, "#fbf8f0", "#14305c"])
def test_a_smooth_surface_has_no_edges_between_its_colors(liquid):
    shades = height_colormap(liquid)(np.linspace(0.0, 1.0, 20_000), bytes=True).astype(int)
    assert np.abs(np.diff(shades, axis=0)).max() <= 1


def test_headings_have_arrowheads(frames):
    frame = frames[0].with_arrays({**frames[0].arrays, "angle": np.zeros(len(frames[0].arrays["radius"]))})
    found = arrows(frame) - frame.arrays["position"][:, None]
    assert np.all(found[:, 1, 0] == found[..., 0].max(axis=1)), "the tip is ahead"
    assert np.all(found[:, 2, 0] < found[:, 1, 0])
    assert found[:, 2, 1] == pytest.approx(-found[:, 4, 1])
    assert len(arrows(frames[0])) == 0


def test_only_floats_that_swim_have_an_arrow(scene, frames):
    one, other = (kind.name for kind in scene.kinds)
    frame = frames[0].with_arrays({**frames[0].arrays, "angle": np.zeros(len(frames[0].arrays["radius"]))})
    count = [int(np.sum(frame.arrays["species"] == kind)) for kind in (0, 1)]
    for activity, wanted in (
        (ActivitySpec(propulsion=1e-8), sum(count)),
        (ActivitySpec(propulsion=1e-8, species=(other,)), count[1]),
        (ActivitySpec(force=1e-8, persistence=1.0, species=(one,)), 0),
    ):
        bowl = Bowl(dataclasses.replace(scene, activity=activity), [frame], SIZE)
        assert len(bowl.rises.get_segments()) == wanted
