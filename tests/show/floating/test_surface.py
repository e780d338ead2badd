"""The height on the grid is the sum of the laws."""

import dataclasses

import numpy as np
import pytest
from scipy.special import k0

from ecume.laws import meniscus
from ecume.laws.radiated_waves import ripples, surface_per_force
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import DishSpec
from ecume.scenes.load import load_scene
from ecume.show.floating.surface import CUTOFF, View, sheet, surface, unit_meniscus, wave_heights
from ecume.trajectories.frame import Frame

VIEW = View(-0.03, 0.03, -0.03, 0.03)
CLOSEST = 1e-3


def on_the_surface(grid, frame):
    """The points of the grid where liquid is, and their distances from each float."""
    x, y = np.meshgrid(grid.x, grid.y)
    r = np.stack([np.hypot(x - px, y - py) for px, py in frame.arrays["position"]])
    return (r > frame.arrays["radius"][:, None, None]).all(axis=0), r


def test_menisci_add_up_to_the_sum_of_k0(scene, frames):
    open_surface = dataclasses.replace(scene, dish=None)
    grid = sheet(open_surface, VIEW, cells=60, closest=CLOSEST)
    length = liquid_of(scene).capillary_length
    wet, r = on_the_surface(grid, frames[0])
    charge = frames[0].arrays["charge"][:, None, None]
    wanted = (-charge * k0(r / length)).sum(axis=0)
    allowed = 2 * np.abs(charge).max() * k0(CUTOFF) + 2e-3 * np.abs(wanted[wet]).max()
    assert surface(frames[0], grid)[wet] == pytest.approx(wanted[wet], abs=allowed)
    assert allowed < 0.03 * np.abs(wanted[wet]).max()


def test_under_a_float_the_surface_stands_as_high_as_at_its_edge(scene, frames):
    grid = sheet(dataclasses.replace(scene, dish=None), VIEW, cells=61, closest=CLOSEST)
    arrays = {name: array[:1] for name, array in frames[0].arrays.items()}
    alone = frames[0]._replace(arrays={**arrays, "position": np.zeros((1, 2))})
    height, length = surface(alone, grid), liquid_of(scene).capillary_length
    middle = height[30, 30]
    assert middle == pytest.approx(1e-4 * k0(2e-3 / length), rel=2e-3)
    assert height[30, 31] == middle


def test_light_floats_lift_the_surface_and_heavy_ones_press_it_down(scene, frames):
    grid = sheet(dataclasses.replace(scene, dish=None), VIEW, cells=60, closest=CLOSEST)
    height = surface(frames[0], grid)
    for (px, py), charge in zip(frames[0].arrays["position"], frames[0].arrays["charge"], strict=True):
        here = height[np.searchsorted(grid.y, py), np.searchsorted(grid.x, px)]
        assert np.sign(here) == -np.sign(charge)


def test_the_dish_s_own_field_is_the_law_s(scene, frames):
    grid = sheet(scene, VIEW, cells=40, closest=CLOSEST)
    x, y = np.meshgrid(grid.x, grid.y)
    r = np.hypot(x, y)
    inside = r < scene.dish.radius
    wanted = meniscus.dish_height(r=r[inside], dish_radius=0.03, contact_angle=0.8, liquid=liquid_of(scene))
    assert grid.still[inside] == pytest.approx(wanted, rel=1e-6)
    assert grid.still[inside].max() > 1e-3


def test_without_floats_nearby_the_surface_is_the_dish_s(scene, frames):
    grid = sheet(scene, VIEW, cells=40, closest=CLOSEST)
    flat = frames[0]._replace(arrays={**frames[0].arrays, "charge": np.zeros(6)})
    assert np.array_equal(surface(flat, grid), grid.still)
    assert not np.array_equal(surface(frames[0], grid), grid.still)


def test_a_float_beside_the_shown_part_still_bends_it(scene, frames):
    corner = View(0.022, 0.03, -0.012, 0.012)
    grid = sheet(dataclasses.replace(scene, dish=None), corner, cells=40, closest=CLOSEST)
    assert np.abs(surface(frames[0], grid)).max() > 1e-6


def test_between_facing_walls_their_menisci_add_up(scene, frames):
    box = dataclasses.replace(scene, dish=DishSpec(size=(0.02, 0.05), contact_angle=0.8))
    liquid = liquid_of(scene)
    grid = sheet(box, View(-0.01, 0.01, -0.025, 0.025), cells=50, closest=CLOSEST)
    across, along = (meniscus.facing_amplitude(side, 0.8, liquid) for side in (0.02, 0.05))

    def walls(x, side):
        return np.exp(-(side / 2 - x) / liquid.capillary_length) + np.exp(-(side / 2 + x) / liquid.capillary_length)

    wanted = across * walls(grid.x, 0.02) + along * walls(grid.y, 0.05)[:, None]
    assert grid.still == pytest.approx(wanted, rel=1e-5)


def test_a_dish_without_a_meniscus_leaves_the_liquid_flat(scene):
    flat = dataclasses.replace(scene, dish=DishSpec(radius=0.03, law="none"))
    assert not sheet(flat, VIEW, cells=20, closest=CLOSEST).still.any()


def test_menisci_fade_out_before_they_end(scene):
    on = sheet(scene, VIEW, cells=20, closest=1e-3)
    heights = unit_meniscus(on, np.array([1.0, 0.5, 0.9, 0.99, 1.01]) * on.reach)
    assert abs(heights[3]) < 1e-5 * abs(unit_meniscus(on, np.array([on.closest]))[0])
    assert heights[4] == 0.0


def test_without_a_law_of_menisci_none_is_drawn(scene, frames):
    none = dataclasses.replace(scene, interaction=dataclasses.replace(scene.interaction, law="none"), dish=None)
    assert not np.any(surface(frames[0], sheet(none, VIEW, cells=20, closest=1e-3)))


WAVES = """\
model = "floating"
duration = "1 s"
frame_every = "0.05 s"
[liquid]
density = 1149.5
viscosity = "10 mPa*s"
surface_tension = "67 mN/m"
[[particles]]
radius = "2 mm"
density = 1100.0
disc = { thickness = "0.5 mm" }
positions = [["0 mm", "0 mm"]]
[dish]
radius = "35 mm"
[waves]
frequency = "100 Hz"
[[waves.sources]]
force = "0.12 mN"
"""


def test_waves_of_floats_are_drawn():
    scene = load_scene(WAVES)
    arrays = {"position": np.zeros((1, 2)), "angle": np.zeros(1)}
    on = sheet(scene, View(-0.02, 0.02, -0.02, 0.02), cells=40, closest=2e-3)
    found = wave_heights(Frame(0.0, arrays, {}, {}), on)
    assert found == pytest.approx(found.T)
    given = scene.liquid
    waves = ripples(100.0, given.density, given.surface_tension, given.viscosity, scene.gravity)
    exact = -1.2e-4 * surface_per_force(np.hypot(on.x[30], on.y[20]), waves).real
    assert found[20, 30] == pytest.approx(exact, rel=0.02, abs=1e-8)


def test_floats_without_menisci_leave_the_surface_level_and_need_no_images(scene, frames, monkeypatch):
    """A cell of 40 um would have a million images within the range of menisci."""
    bare = dataclasses.replace(scene, dish=None, interaction=dataclasses.replace(scene.interaction, law="none"))
    grid = sheet(bare, VIEW, cells=60, closest=CLOSEST)
    monkeypatch.setattr("ecume.show.floating.surface.with_images", None)
    assert not surface(frames[0], grid).any()
