"""The drawn region of a liquid: its area is the liquid's volume, its edge is the liquid's edge, inside the walls."""

import time
from pathlib import Path as File

import numpy as np
import pytest
from matplotlib.path import Path

from ecume.show.movies import MovieOptions, picture_of
from ecume.show.picture import Size
from ecume.show.sph.liquid import read, surface_of
from ecume.show.sph.picture import liquid_picture
from ecume.trajectories.frame import Frame

from .conftest import SPACING, frame_of, scene_of


def lattice(low, high, spacing=SPACING):
    """Particles half a spacing from each edge of a box."""
    axes = [np.arange(a + 0.5 * spacing, b, spacing) for a, b in zip(low, high, strict=True)]
    return np.stack([axis.ravel() for axis in np.meshgrid(*axes)], axis=1)


def frame_at(position, **numbers):
    """Particles of the volume of a lattice's cell, at pressures that grow linearly along x and y."""
    arrays = {
        "position": position,
        "velocity": np.zeros_like(position),
        "pressure": 3.0 * position[:, 0] + 5.0 * position[:, 1],
        "density": np.full(len(position), 1000.0),
        "mass": np.full(len(position), 1000.0 * SPACING**2),
        "species": np.zeros(len(position), np.int64),
    }
    return Frame(0.0, arrays, numbers, {})


def surface(scene, frame, fine=4.0):
    return surface_of(scene, frame, frame.arrays["pressure"][:, None], fine)


def area(path: Path):
    """Of polygons with holes."""
    rings = path.to_polygons(closed_only=True)
    return abs(sum(0.5 * float(np.sum(r[:-1, 0] * r[1:, 1] - r[1:, 0] * r[:-1, 1])) for r in rings))


def random_tank(seed):
    """A tank of random shape with a jittered column of liquid in a corner of it."""
    rng = np.random.default_rng(seed)
    low = rng.uniform(-1.0, 1.0, 2)
    high = low + SPACING * rng.integers(12, 60, 2)
    full = low + SPACING * np.maximum(((high - low) / SPACING * rng.uniform(0.4, 1.0, 2)).round(), 8.0)
    position = lattice(low, full)
    position += rng.uniform(-0.2, 0.2, position.shape) * SPACING
    top = "open" if seed % 2 else "wall"
    tank = {"low": low.tolist(), "high": high.tolist(), "top": {"kind": top}}
    fluid = [{"low": low.tolist(), "high": full.tolist()}]
    return scene_of(tank=tank, fluid=fluid), frame_at(position)


@pytest.mark.parametrize("fine", [2.0, 3.7, 8.0])
def test_a_flat_surface_lies_half_a_spacing_above_the_last_row(fine):
    position = lattice((0.0, 0.0), (2.0, 0.5))
    (line,) = surface(scene_of(), frame_at(position), fine).lines()
    assert line[:, 0].min() == pytest.approx(0.0, abs=1e-12)
    assert line[:, 0].max() == pytest.approx(2.0, abs=1e-12)
    assert line[:, 1] == pytest.approx(position[:, 1].max() + 0.5 * SPACING, abs=0.01 * SPACING)


@pytest.mark.parametrize("seed", range(12))
def test_the_drawn_area_is_the_volume_and_no_vertex_is_outside_the_walls(seed):
    scene, frame = random_tank(seed)
    outline = surface(scene, frame).outline()
    volume = float((frame.arrays["mass"] / frame.arrays["density"]).sum())
    assert np.isfinite(outline.vertices).all()
    assert area(outline) == pytest.approx(volume, rel=0.02)
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    high[1] = np.inf if scene.tank.top.kind == "open" else high[1]
    assert (outline.vertices >= low - 1e-12).all()
    assert (outline.vertices <= high + 1e-12).all()


def test_a_full_tank_has_neither_gaps_nor_a_free_surface():
    rng = np.random.default_rng(3)
    position = lattice((0.0, 0.0), (2.0, 1.0))
    frame = frame_at(position + rng.uniform(-0.2, 0.2, position.shape) * SPACING)
    seen = surface(scene_of(tank={"low": [0.0, 0.0], "high": [2.0, 1.0]}), frame)
    assert seen.region.level.min() > 0.2
    assert seen.lines() == []
    assert area(seen.outline()) == pytest.approx(2.0)


def test_particles_far_from_all_others_are_discs_of_their_own_area():
    position = np.array([[0.3, 0.7], [1.0, 0.9], [1.7, 0.71]])
    outline = surface(scene_of(), frame_at(position), 10.0).outline()
    assert len(outline.to_polygons()) == 3
    assert area(outline) == pytest.approx(3 * SPACING**2, rel=0.02)


def test_quantities_are_interpolated_between_the_particles():
    seen = surface(scene_of(), frame_at(lattice((0.0, 0.0), (2.0, 0.5))))
    x, y = np.meshgrid(seen.grid.centers(0), seen.grid.centers(1), indexing="ij")
    inside = (abs(x - 1.0) < 0.8) & (abs(y - 0.25) < 0.1)
    assert seen.region.values[inside, 0] == pytest.approx((3.0 * x + 5.0 * y)[inside], abs=0.01)


def test_a_moved_wall_bounds_the_liquid_where_it_is():
    driven = {"kind": "wall", "motion": {"times": [0.0, 1.0], "positions": [0.0, 0.2]}}
    scene = scene_of(tank={"low": [0.0, 0.0], "high": [2.0, 1.0], "left": driven, "top": {"kind": "open"}})
    outline = surface(scene, frame_at(lattice((0.2, 0.0), (2.0, 0.5)), left_position=0.2)).outline()
    assert outline.vertices[:, 0].min() == pytest.approx(0.2, abs=1e-12)
    assert area(outline) == pytest.approx(0.9, rel=0.01)


def test_liquid_ends_at_solids_without_a_gap_and_is_not_painted_into_them():
    block = {"low": [1.0, 0.0], "high": [1.3, 0.3], "color": "#ff00ff"}
    scene = scene_of(obstacles=[block])
    position = lattice((0.0, 0.0), (2.0, 0.5))
    inside = ((position > [1.0, 0.0]) & (position < [1.3, 0.3])).all(axis=1)
    frame = frame_at(position[~inside])
    seen = surface(scene, frame, 6.0)
    near = np.array([(0.99, 0.15), (1.31, 0.15), (1.15, 0.31), (0.99, 0.31)])
    assert seen.outline().contains_points(near).all()
    assert read(seen.region.level, near, seen.grid) == pytest.approx(0.5, abs=0.2)
    picture = liquid_picture(scene, [frame], Size(640, 480))
    pixels = picture.pixels(frame)
    across, down = picture.figure.axes[0].transData.transform((1.15, 0.15))
    assert tuple(pixels[pixels.shape[0] - int(down), int(across), :3]) == (255, 0, 255)


def test_periodic_sides_continue_the_liquid():
    ring = {side: {"kind": "periodic"} for side in ("left", "right", "bottom", "top")}
    scene = scene_of(tank={"low": [0.0, 0.0], "high": [2.0, 1.0], **ring})
    seen = surface(scene, frame_at(lattice((0.0, 0.0), (2.0, 1.0)) % [2.0, 1.0]))
    assert seen.region.level == pytest.approx(0.5, abs=1e-3)


def test_twenty_thousand_particles_take_well_below_two_tenths_of_a_second():
    spacing = 0.01
    position = lattice((0.0, 0.0), (2.0, 1.0), spacing)
    assert len(position) == 20_000
    scene = scene_of(spacing=spacing)
    position += np.random.default_rng(1).uniform(-0.2, 0.2, position.shape) * spacing
    frame = frame_at(position)
    frame.arrays["mass"][:] = 1000.0 * spacing**2
    picture = liquid_picture(scene, [frame])
    start = time.process_time()
    for _ in range(3):
        picture.pixels(frame)
    assert (time.process_time() - start) / 3 < 0.2


@pytest.mark.parametrize("aspect", [(10.0, 1.0), (3.0, 1.0), (1.0, 1.0), (1.0, 4.0)])
def test_a_film_of_any_tank_fills_its_frame(aspect):
    scene = scene_of(tank={"low": [0.0, 0.0], "high": list(aspect)}, fluid=[{"low": [0.0, 0.0], "high": [0.9, 0.5]}])
    picture = picture_of(scene, [frame_of(length=0.9)], MovieOptions(), File("a.mp4"))
    width, height = picture.figure.get_size_inches() * picture.figure.dpi
    assert (round(width) % 2, round(height) % 2) == (0, 0)
    *_, across, up = picture.figure.axes[0].get_position().bounds
    assert (1.0 - across) * width == pytest.approx(194.0, abs=2.0) or round(width) == 380
    assert (1.0 - up) * height == pytest.approx(90.0, abs=2.0) or round(height) == 250
