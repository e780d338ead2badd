"""Floats that overlap slightly at the start, as after soft contacts, are moved apart before the run."""

import json
import math

import numpy as np
import pytest

from ecume.engine.walls import no_walls
from ecume.engine.walls.surfaces import clearances
from ecume.errors import SceneError
from ecume.models.floating.record import FLOATING
from ecume.models.floating.setup.overlaps import KEPT, SLIGHT, separated
from ecume.models.floating.setup.scene_parameters import SLOP
from ecume.run import RunOptions, run, verify
from ecume.scenes.schema import from_plain

RADIUS = 1e-3
PLAIN = pytest.mark.uncompiled
"""Ellipses in a square dish, which nothing else compiles, for ten seconds; either is compiled without the other."""


def scene(positions, **more):
    species = {"radius": RADIUS, "density": 1250.0, "contact_angle": "90 deg", "positions": positions}
    plain = {"model": "floating", "duration": 0.2, "frame_every": 0.1, "particles": [species]}
    return from_plain(plain | {"dish": {"radius": 0.05, "contact_angle": "90 deg"}} | more)


def triangle(overlap):
    side = 2.0 * RADIUS * (1.0 - 0.5 * overlap)
    return [[0.0, 0.0], [side, 0.0], [0.5 * side, 0.5 * np.sqrt(3.0) * side]]


def distances(position):
    return [float(np.linalg.norm(position[i] - position[j])) for i, j in ((0, 1), (0, 2), (1, 2))]


@pytest.mark.parametrize("overlap", [5e-4, 2e-3, 1.9e-2])
def test_slight_overlaps_are_removed_about_the_common_center(overlap):
    asked = scene(triangle(overlap))
    there = FLOATING.start(asked, FLOATING.parameters(asked)).position
    assert distances(there) == pytest.approx([2.0 * RADIUS] * 3, rel=1e-9)
    assert there.mean(axis=0) == pytest.approx(np.mean(triangle(overlap), axis=0), abs=1e-12)


def test_larger_overlaps_are_refused():
    asked = scene(triangle(0.03))
    with pytest.raises(SceneError, match="overlaps"):
        FLOATING.start(asked, FLOATING.parameters(asked))


def test_floats_without_overlaps_stay_to_the_bit():
    radius, free = np.full(3, RADIUS), (np.zeros((1, 2)), no_walls(), SLOP * RADIUS)
    for overlap in (0.0, -0.1, 0.4 * SLOP):
        there = np.array(triangle(overlap))
        assert np.array_equal(separated(there, radius, *free), there)


def test_a_pair_across_a_periodic_border_is_moved_apart():
    box, radius = np.array([[0.02, 0.03]]), np.full(2, RADIUS)
    pair = np.array([[0.0005, 0.01], [0.02 - 0.001495, 0.01]])
    found = separated(pair, radius, box, no_walls(), SLOP * RADIUS)
    gap = found[0, 0] + box[0, 0] - found[1, 0] - 2.0 * RADIUS
    assert abs(gap) < 1e-12
    assert abs(pair[0, 0] + box[0, 0] - pair[1, 0] - 2.0 * RADIUS) > 4e-6


def test_chains_and_rafts_are_solved_together():
    columns = np.arange(12) * 2.0 * RADIUS * (1.0 - 1e-3)
    row = np.stack([columns, np.zeros(12)], axis=1)
    found = separated(row, np.full(12, RADIUS), np.zeros((1, 2)), no_walls(), SLOP * RADIUS)
    assert np.diff(found[:, 0]).min() > 2.0 * RADIUS * (1.0 - 1e-6)


@pytest.mark.parametrize(
    ("contacts", "overlap"),
    [({"law": "none"}, 1e-2), ({"law": "spring-dashpot", "stiffness": 10.0}, 1e-2), ({"law": "spring-dashpot"}, 2e-3)],
)
def test_overlaps_that_the_contacts_allow_stay_to_the_bit(contacts, overlap):
    asked = scene(triangle(overlap), contacts=contacts)
    there = FLOATING.start(asked, FLOATING.parameters(asked)).position
    assert np.array_equal(there, triangle(overlap))


@pytest.mark.parametrize("layout", ["chain", "triangle", "pair"])
@pytest.mark.parametrize("overlap", [0.0, SLOP, 1.5 * SLOP, 3e-4, 2e-3])
def test_a_raft_at_rest_keeps_its_energy(layout, overlap, tmp_path):
    """Nothing moves but what contacts correct within rounding: no energy is gained by the measure of the raft's own."""
    side = 2.0 * RADIUS * (1.0 - 0.5 * overlap)
    places = {
        "chain": [[k * side, 0.0] for k in range(3)],
        "triangle": triangle(overlap),
        "pair": triangle(overlap)[:2],
    }
    run(scene(places[layout]), tmp_path / "run", options=RunOptions(on_violation="stop"))
    assert verify(tmp_path / "run").sound


def wall_scene(overlap, dish, place, **species):
    """A float that overlaps the wall, which attracts it, by a fraction of its radius."""
    kind = {"radius": RADIUS, "density": 1250.0, "contact_angle": "90 deg", "positions": [place], **species}
    plain = {"model": "floating", "duration": 0.004, "frame_every": 0.002, "particles": [kind]}
    return from_plain(plain | {"dish": {**dish, "contact_angle": "100 deg"}})


ROUND = {"radius": 0.02}
SQUARE = {"shape": "rectangle", "size": [0.04, 0.04]}
ELLIPSE = {"shape": {"kind": "ellipsoid", "width": 0.8e-3, "angle": 0.0}}


@pytest.mark.parametrize("overlap", [SLOP, 1.01 * SLOP, 5e-4, 9e-4])
@pytest.mark.parametrize(
    ("dish", "species"), [(ROUND, {}), (SQUARE, {}), (ROUND, ELLIPSE), pytest.param(SQUARE, ELLIPSE, marks=PLAIN)]
)
def test_a_float_in_a_wall_is_moved_before_the_run(dish, species, overlap, tmp_path):
    place = [0.02 - RADIUS * (1.0 - overlap), 0.0]
    run(wall_scene(overlap, dish, place, **species), tmp_path / "run", options=RunOptions(on_violation="stop"))
    assert deepest_ever(tmp_path / "run") <= KEPT * SLOP * RADIUS


@pytest.mark.parametrize("overlap", [SLOP, 5e-4, 9e-4])
@pytest.mark.parametrize("turned", [0.0, 0.3])
def test_shapes_that_overlap_slightly_are_moved_before_the_run(overlap, turned, tmp_path):
    half = RADIUS * (1.0 - 0.5 * overlap)
    pair = {
        "radius": RADIUS,
        "density": 1050.0,
        "contact_angle": "80 deg",
        "shape": {**ELLIPSE["shape"], "angle": turned},
    }
    plain = {"model": "floating", "duration": 0.002, "frame_every": 0.001}
    along = half if turned == 0.0 else touching_half(turned, overlap)
    places = [{**pair, "positions": [[side * along, 0.0]]} for side in (-1.0, 1.0)]
    run(from_plain(plain | {"particles": places}), tmp_path / "run", options=RunOptions(on_violation="stop"))
    assert deepest_ever(tmp_path / "run") <= KEPT * SLOP * RADIUS


def touching_half(turned, overlap):
    """Half the distance along x of two parallel ellipses that touch, less a part of the radius: that of the points
    where a line along x through the center leaves one of them.
    """
    inverse = math.hypot(math.cos(turned) / RADIUS, math.sin(turned) / 0.4e-3)
    return 1.0 / inverse - 0.5 * overlap * RADIUS


def deepest_ever(home):
    return max(json.loads(line)["deepest_overlap"] for line in (home / "scalars.jsonl").read_text().splitlines())


@pytest.mark.parametrize("seed", range(30))
def test_rafts_of_unequal_floats_in_any_dish_begin_without_deep_overlaps(seed):
    """Grown float by float, each of them overlapping one before, or the wall, by up to the limit."""
    random = np.random.default_rng(seed)
    radius = RADIUS * random.uniform(0.3, 1.0, 12)
    limit = 10.0 ** random.uniform(-6.0, math.log10(0.9 * SLIGHT))
    wide = 0.006
    dish = [{"radius": wide}, {"shape": "rectangle", "size": [2.0 * wide, 2.0 * wide]}][seed % 2]
    places = [[wide - radius[0] * (1.0 - min(limit, 9e-4)), 0.0]]
    while len(places) < len(radius):
        r, on = radius[len(places)], random.integers(len(places))
        angle, deep = random.uniform(0.0, 2.0 * math.pi), limit * random.uniform(0.1, 1.0)
        far = radius[on] + r - deep * min(r, radius[on])
        place = np.array(places[on]) + far * np.array([math.cos(angle), math.sin(angle)])
        others = np.hypot(*(np.array(places) - place).T) - radius[: len(places)] - r
        inside = wide - r - (np.hypot(*place) if seed % 2 == 0 else np.abs(place).max())
        if np.sum(others < 0.0) == 1 and inside > 0.0:
            places.append(place.tolist())
    kinds = [
        {"radius": float(r), "density": 1100.0, "contact_angle": "90 deg", "positions": [place]}
        for r, place in zip(radius, places, strict=True)
    ]
    asked = from_plain({"model": "floating", "duration": 0.1, "frame_every": 0.1, "particles": kinds, "dish": dish})
    parameters = FLOATING.parameters(asked)
    found = FLOATING.start(asked, parameters).position
    walls, among = parameters.walls, np.triu_indices(len(radius), 1)
    gap = np.hypot(*(found[among[0]] - found[among[1]]).T) - radius[among[0]] - radius[among[1]]
    free = min(min(clearances(walls, place)) - r for place, r in zip(found, radius, strict=True))
    assert min(gap.min(), free) >= -KEPT * parameters.slop
    assert np.abs(found - places).max() < 3.0 * SLIGHT * RADIUS
