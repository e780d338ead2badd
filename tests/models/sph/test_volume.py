"""The liquid at the start has the volume that is drawn, and stays at rest, whatever the spacing."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

import ecume
from ecume.laws.kernels import kernel
from ecume.models.sph.record import SPH
from ecume.models.sph.setup.initial_particles import cells_of
from ecume.scenes.schema import from_plain


def random_tank(seed, dimension=2, layers=(8, 18), obstacles=True):
    """A tank with still water of any size and spacing, with or without a lid, often with boxes on its floor."""
    rng = np.random.default_rng(seed)
    size = rng.uniform(0.2, 1.5) * np.array([1.0, rng.uniform(0.4, 1.3), rng.uniform(0.6, 1.2)])[:dimension]
    size = np.round(size, 3)
    high = size.copy()
    high[1] *= rng.choice([1.0, rng.uniform(1.1, 2.0)])
    scene = {
        "model": "sph",
        "seed": seed,
        "duration": 1.0,
        "frame_every": 1.0,
        "spacing": round(float(size.min() / rng.integers(*layers) * rng.uniform(0.9, 1.1)), 4),
        "tank": {"low": [0.0] * dimension, "high": high.tolist(), "walls": str(rng.choice(["mirror", "dummy"]))},
        "fluid": [{"low": [0.0] * dimension, "high": size.tolist()}],
    }
    if obstacles and rng.random() < 0.6:
        low = np.round(rng.uniform(0.1, 0.5, dimension) * size, 3)
        top = np.round(low + rng.uniform(0.2, 0.4, dimension) * size, 3)
        low[1] = 0.0
        scene["obstacles"] = [{"low": low.tolist(), "high": top.tolist()}]
    return from_plain(scene)


def box_volume(spec):
    return math.prod(b - a for a, b in zip(spec.low, spec.high, strict=True))


def drawn_volume(scene):
    """Obstacles stand in the liquid; those of these scenes do not reach above it."""
    return box_volume(scene.fluid[0]) - sum(box_volume(each) for each in scene.obstacles)


@pytest.mark.long
@pytest.mark.parametrize(("dimension", "tanks"), [(2, 40), (3, 15)])
def test_boxes_have_the_volume_that_is_drawn_to_rounding(dimension, tanks):
    for seed in range(tanks):
        scene = random_tank(seed, dimension)
        state = SPH.start(scene, SPH.parameters(scene))
        assert (state.mass / state.density).sum() == pytest.approx(drawn_volume(scene), rel=1e-12)


@pytest.mark.parametrize(
    "region",
    [
        {"vertices": [[0.1, 0.0], [0.87, 0.05], [0.7, 0.63], [0.2, 0.5]]},
        {"center": [0.5, 0.5], "radius": 0.31},
    ],
    ids=["polygon", "disc"],
)
def test_other_shapes_have_their_volume_at_any_spacing(region):
    for spacing in np.random.default_rng(1).uniform(0.01, 0.05, 20):
        scene = from_plain(
            {
                "model": "sph",
                "duration": 1.0,
                "frame_every": 1.0,
                "spacing": float(spacing),
                "tank": {"low": [0.0, 0.0], "high": [1.0, 1.0]},
                "fluid": [region],
            }
        )
        [(cells, _)] = cells_of(scene)
        area = math.pi * 0.31**2 if "radius" in region else 0.34605
        assert cells.volumes.sum() == pytest.approx(area, rel=1e-9)


def test_liquid_over_round_and_slanted_obstacles_has_the_volume_that_is_left():
    for seed in range(10):
        scene = random_tank(seed, obstacles=False)
        width, depth = scene.fluid[0].high
        small = 0.2 * min(width, depth)
        solids = [
            {"center": [0.5 * width, 0.5 * depth], "radius": small},
            {"vertices": [[0.8 * width, 0.0], [width, 0.0], [width, 0.2 * depth]]},
        ]
        plain = ecume.scenes.schema.to_plain(scene)
        [(cells, _)] = cells_of(from_plain({**plain, "obstacles": solids}))
        left = width * depth - math.pi * small**2 - 0.5 * 0.2 * width * 0.2 * depth
        assert cells.volumes.sum() == pytest.approx(left, rel=1e-12)


def test_a_region_that_an_earlier_one_covers_adds_nothing():
    """Also beside a slanted solid, where cells are chosen by their volume."""
    box = {"low": [0.0, 0.0], "high": [1.2, 0.3]}
    plain = {
        "model": "sph", "duration": 1.0, "frame_every": 0.1, "spacing": 0.03,
        "tank": {"low": [0.0, 0.0], "high": [1.2, 0.8], "top": {"kind": "open"}},
        "obstacles": [{"vertices": [[0.78, 0.0], [1.08, 0.0], [0.93, 0.15]]}],
    }  # fmt: skip
    once, twice = (cells_of(from_plain({**plain, "fluid": [box] * count})) for count in (1, 2))
    volumes = [sum(each.volumes.sum() for each, _ in cells) for cells in (once, twice)]
    assert volumes[0] == volumes[1] > 0.3


def test_liquid_in_two_regions_that_overlap_counts_once():
    scene = random_tank(3, obstacles=False)
    width, depth = scene.fluid[0].high
    plain = ecume.scenes.schema.to_plain(scene)
    regions = [
        {"low": [0.0, 0.0], "high": [0.37 * width, depth]},
        {"low": [0.0, 0.0], "high": [width, 0.61 * depth]},
    ]
    cells = [each for each, _ in cells_of(from_plain({**plain, "fluid": regions}))]
    union = 0.37 * width * depth + 0.63 * width * 0.61 * depth
    assert sum(each.volumes.sum() for each in cells) == pytest.approx(union, rel=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_fine_lattices_have_even_masses_and_half_a_spacing_to_each_wall(dimension):
    for seed in range(20 if dimension == 2 else 5):
        scene = random_tank(seed, dimension, layers=(20, 30), obstacles=False)
        [(cells, _)] = cells_of(scene)
        np.testing.assert_allclose(cells.volumes, scene.spacing**dimension, rtol=0.06)
        assert cells.widths.max() / cells.widths.min() < 1.05
        np.testing.assert_allclose(cells.centers.min(axis=0), 0.5 * cells.widths[0], rtol=1e-9)
        np.testing.assert_allclose(
            np.array(scene.fluid[0].high) - cells.centers.max(axis=0), 0.5 * cells.widths[0], rtol=1e-9
        )


def test_the_summed_density_inside_is_that_of_the_liquid():
    weight = kernel("wendland-c2", dim=2)
    for seed in range(10):
        scene = random_tank(seed, layers=(14, 20), obstacles=False)
        [(cells, _)] = cells_of(scene)
        reach = 4.0 * scene.spacing
        low, high = cells.centers.min(axis=0) + reach, cells.centers.max(axis=0) - reach
        inside = ((cells.centers >= low) & (cells.centers <= high)).all(axis=1)
        tree = cKDTree(cells.centers)
        for index in np.flatnonzero(inside)[::17]:
            near = tree.query_ball_point(cells.centers[index], reach)
            away = np.linalg.norm(cells.centers[near] - cells.centers[index], axis=1)
            total = np.dot(weight.value(away, 0.5 * reach), cells.volumes[near])
            assert total == pytest.approx(1.0, rel=0.01)


@pytest.mark.long
@pytest.mark.compiled  # a few thousand steps
def test_still_water_stays_still():
    for seed in (1, 3, 5, 7):  # between mirrors and dummies, with boxes and without, below a lid and open
        scene = random_tank(seed, layers=(8, 13))
        frame = list(ecume.simulate(scene))[-1]
        depth = scene.fluid[0].high[1]
        speed = np.linalg.norm(frame.arrays["velocity"], axis=1).max()
        assert speed < 0.03 * math.sqrt(9.81 * depth), seed
        assert frame.numbers["volume"] == pytest.approx(drawn_volume(scene), rel=0.01)


def full_tank(seed, dimension, **changes):
    """Water up to the lid, with displacements of a fifth of a spacing."""
    rng = np.random.default_rng([seed, dimension])
    size = np.round(rng.uniform(0.2, 1.0) * rng.uniform(0.7, 1.2, dimension), 3).tolist()
    return from_plain(
        {
            "model": "sph", "seed": seed, "duration": 0.5, "frame_every": 0.5,
            "spacing": min(size) / (6 if dimension == 2 else 5),
            "tank": {"high": size, "walls": str(rng.choice(["mirror", "dummy"]))},
            "fluid": [{"low": [0.0] * dimension, "high": size}],
            "method": {"jitter": 0.2},
            **changes,
        }
    )  # fmt: skip


@pytest.mark.long
@pytest.mark.compiled  # some hundred steps
@pytest.mark.parametrize(("dimension", "seed"), [(2, 0), (2, 2), (3, 0)])
def test_a_full_tank_keeps_its_volume_and_its_pressure_while_particles_settle(dimension, seed):
    scene = full_tank(seed, dimension)
    start, end = ecume.simulate(scene)
    depth = scene.fluid[0].high[1]
    excess = end.arrays["pressure"] / (1000.0 * 9.81 * depth) - (1.0 - end.arrays["position"][:, 1] / depth)
    assert end.numbers["volume"] == pytest.approx(start.numbers["volume"], rel=1e-6)
    assert abs(excess.mean()) < 0.01
    speed = np.linalg.norm(end.arrays["velocity"], axis=1).max()
    assert speed < 0.08 * math.sqrt(9.81 * depth)  # what is left of the displacements


@pytest.mark.parametrize(
    ("changes", "fixed"),
    [
        ({}, True),
        ({"gravity": [0.0, 0.0], "liquid": {"maximum_speed": 1.0}}, False),
        ({"method": {"pressure": "incompressible"}}, False),
        ({"tank": {"high": [1.0, 1.0], "left": {"kind": "periodic"}, "right": {"kind": "periodic"}}}, True),
        ({"tank": {"high": [1.0, 1.0], "left": {"kind": "periodic"}, "right": {"kind": "periodic"}},
          "gravity": [1.0, 0.0]}, False),
        ({"tank": {"high": [1.0, 1.0], **{side: {"motion": {"amplitude": 0.01, "frequency": 1.0}}
                                          for side in ("left", "right")}}}, True),
        ({"tank": {"high": [1.0, 1.0], "top": {"kind": "open"}}}, False),
        ({"tank": {"high": [1.0, 1.5]}}, False),
        ({"tank": {"high": [1.0, 1.0], "left": {"motion": {"amplitude": 0.01, "frequency": 1.0}}}}, False),
    ],
)  # fmt: skip
def test_only_full_closed_tanks_under_gravity_keep_their_volume(changes, fixed):
    box = {"tank": {"high": [1.0, 1.0]}, "fluid": [{"low": [0.0, 0.0], "high": [1.0, 1.0]}], "spacing": 0.1}
    assert SPH.parameters(full_tank(0, 2, **{**box, **changes})).fixed_volume == fixed
