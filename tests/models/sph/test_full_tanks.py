"""Full is a matter of volume: closed tanks with air, full ones, and liquids that fill them without sound."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial import cKDTree

import ecume
from ecume.engine.shapes import Ball
from ecume.models.sph import SPH
from ecume.models.sph.boundaries.walls import speed_of
from ecume.models.sph.setup.choices import free_surface, full
from ecume.models.sph.setup.shapes import dummies_of
from ecume.scenes.schema import from_plain, to_plain
from tests.models.sph.scenes import OPEN

SIZE = [1.0, 0.5]


def closed(fluid, spacing=0.05, gravity=-1.0, **changes):
    """A closed tank, twice as wide as high, under gravity."""
    plain = {
        "model": "sph", "duration": 1.0, "frame_every": 0.5, "spacing": spacing, "gravity": [0.0, gravity],
        "liquid": {"density": 1.0}, "tank": {"high": SIZE}, "fluid": fluid,
    }  # fmt: skip
    for table, change in changes.items():
        plain[table] = {**plain.get(table, {}), **change} if isinstance(change, dict) else change
    return from_plain(plain)


def box(left, bottom, right, top):
    return {"low": [left, bottom], "high": [right, top]}


COLUMN_AND_POOL = [box(0.0, 0.0, 0.3, 0.5), box(0.3, 0.0, 1.0, 0.2)]
SLOPES = [{"vertices": [[0, 0], [1, 0], [0, 0.5]]}, {"vertices": [[1, 0], [1, 0.5], [0, 0.5]]}]
WHOLE = [box(0.0, 0.0, *SIZE)]
PISTON = {"motion": {"amplitude": 0.01, "frequency": 1.0}}


@pytest.mark.parametrize(
    ("scene", "free"),
    [
        (closed(WHOLE), False),
        (closed(COLUMN_AND_POOL), True),
        (closed([box(0.0, 0.0, 0.2, 0.5), box(0.8, 0.0, 1.0, 0.5)]), True),
        (closed(SLOPES[:1]), True),
        (closed(SLOPES), False),
        (closed([{"center": [0.5, 0.5], "radius": 0.5}], tank={"high": [1.0, 1.0]}), True),
        (closed(WHOLE, obstacles=[{"center": [0.5, 0.25], "radius": 0.1}]), False),
        (closed(WHOLE, bodies=[{"center": [0.5, 0.25], "radius": 0.1, "density": 1.0}]), False),
        (closed(WHOLE, tank={"high": SIZE, "left": PISTON}), True),
        (closed(WHOLE, tank={"high": SIZE, "left": PISTON, "right": PISTON}), False),
        (closed(WHOLE, tank={"high": SIZE, "top": OPEN}), True),
        (closed(WHOLE, tank={"high": SIZE, "right": {"kind": "outflow"}}), True),
        (closed(WHOLE, tank={"high": SIZE, "left": {"kind": "inflow", "speed": 0.1}, "right": {"kind": "outflow"}}),
         False),
    ],
)  # fmt: skip
def test_the_surface_is_free_where_a_part_of_the_room_is_or_gets_empty(scene, free):
    assert free_surface(scene) == free


@pytest.mark.parametrize("seed", range(10))
def test_a_tank_is_full_if_its_liquid_and_solids_have_its_volume(seed):
    """Of random widths, columns and discs; one of the columns reaches the lid in any case."""
    rng = np.random.default_rng(seed)
    width, height = rng.uniform(0.5, 2.0, 2)
    spacing = min(width, height) / rng.uniform(8, 20)
    ends = np.concatenate([[0.0], np.sort(rng.uniform(0.0, width, 2)), [width]])
    tops = [height, *rng.choice([height, 0.9 * height], 2)]
    columns = [box(a, 0.0, b, top) for a, b, top in zip(ends[:-1], ends[1:], tops, strict=True)]
    disc = {"center": [0.5 * width, 0.5 * height], "radius": 0.2 * min(width, height)}
    scene = closed(columns, spacing, tank={"high": [width, height]}, obstacles=[disc])
    air = sum((b - a) * (height - top) for a, b, top in zip(ends[:-1], ends[1:], tops, strict=True))
    assert full(scene) == (air < 0.5 * spacing**2)


def test_a_drop_that_touches_the_lid_leaves_the_method_as_it_is():
    pool = [[x, y] for x in np.arange(0.025, 1.0, 0.05) for y in np.arange(0.025, 0.2, 0.05)]
    scenes = [closed([{"particles": {"positions": [*pool, [0.5, drop]]}}]) for drop in (0.4, 0.475)]
    apart, touching = (SPH.parameters(scene) for scene in scenes)
    assert (touching.fixed_volume, touching.shifting) == (apart.fixed_volume, apart.shifting) == (False, "none")


@pytest.mark.compiled
@pytest.mark.parametrize("pressure", ["tait", "incompressible"])
def test_a_column_that_touches_the_lid_falls_and_loses_energy(pressure):
    start, _, end = ecume.simulate(closed(COLUMN_AND_POOL, 0.025, method={"pressure": pressure}))
    gained = end.numbers["total_energy"] - end.numbers.get("injected_work", 0.0) - start.numbers["total_energy"]
    height = start.numbers["potential_energy"]
    assert end.numbers["center_y"] < start.numbers["center_y"]
    assert gained < 1e-3 * height
    assert abs(end.numbers.get("injected_work", 0.0)) < 0.02 * height
    assert np.quantile(end.arrays["pressure"], 0.02) > -0.1 * 0.5  # but for single drops


@pytest.mark.compiled
@pytest.mark.parametrize("jitter", [0.05, 0.2])
def test_still_water_without_sound_rests_in_a_full_tank(jitter):
    scene = closed(WHOLE, 1.0 / 24.0, method={"pressure": "incompressible", "jitter": jitter})
    start, _, end = ecume.simulate(scene)
    depth = SIZE[1] - end.arrays["position"][:, 1]
    assert end.numbers["largest_speed"] < 0.1 * jitter * np.sqrt(SIZE[1])
    assert end.numbers["total_energy"] < start.numbers["total_energy"] + 1e-4
    assert np.abs(end.arrays["pressure"] - depth).max() < 0.1 * SIZE[1]
    assert end.arrays["pressure"].min() >= 0.0


@pytest.mark.parametrize("courant", [0.05, 0.25, 1.0])
def test_the_repulsion_is_resolved_by_the_step_of_a_liquid_without_sound(courant):
    scene = closed([box(0.0, 0.0, 0.5, 0.4)], method={"pressure": "incompressible"})
    scene = dataclasses.replace(scene, integration=dataclasses.replace(scene.integration, courant_number=courant))
    parameters = SPH.parameters(scene)
    rate = speed_of(parameters) / parameters.boundary.guard.reach
    assert 0.0 < rate * parameters.time_step <= 0.5 + 1e-12


@pytest.mark.compiled
def test_the_tip_of_a_dam_break_without_sound_stays_on_the_floor_and_gains_no_energy():
    tank = {"high": [4.0, 1.5], "top": OPEN}
    scene = closed([box(0.0, 0.0, 1.0, 1.0)], 0.05, tank=tank, method={"pressure": "incompressible"})
    frames = list(ecume.simulate(dataclasses.replace(scene, duration=2.0, frame_every=0.02)))
    energy = np.array([frame.numbers["total_energy"] for frame in frames])
    assert np.diff(energy).max() < 1e-4 * energy[0]
    for frame in frames:
        front = frame.arrays["position"][:, 0] > 1.2
        assert (frame.arrays["velocity"][front, 1] < 0.3).all()


def test_stacked_regions_start_with_the_weight_above_them():
    """Two or three on one another, one of them a disc in the middle, have the pressures of one region."""
    one = closed([box(0.0, 0.0, 1.0, 0.4)])
    lower, upper = box(0.0, 0.0, 1.0, 0.2), box(0.0, 0.2, 1.0, 0.4)
    disc = {"center": [0.5, 0.2], "radius": 0.1}
    for regions in ([lower, upper], [upper, lower], [disc, lower, upper]):
        scene = closed(regions)
        parameters = SPH.parameters(scene)
        start = SPH.observe(parameters, state := SPH.start(scene, parameters), SPH.workspace(parameters, state, 1.0))
        depth = 0.4 - start.arrays["position"][:, 1]
        assert np.abs(start.arrays["pressure"] - depth).max() < 0.005 * 0.4  # of compression
        assert parameters.pressure_reference.level == SPH.parameters(one).pressure_reference.level == 0.4


def test_a_drop_above_a_pool_does_not_raise_its_level():
    pool, drop = box(0.0, 0.0, 1.0, 0.2), {"center": [0.5, 0.4], "radius": 0.05}
    assert SPH.parameters(closed([drop, pool])).pressure_reference.level == 0.2


def test_the_level_of_a_polygon_under_oblique_gravity_is_that_of_its_highest_corner():
    triangle = {"vertices": [[0.0, 0.0], [0.4, 0.0], [0.0, 0.3]]}
    plain = to_plain(closed([triangle]))
    reference = SPH.parameters(from_plain({**plain, "gravity": [-0.6, -0.8]})).pressure_reference
    assert reference.level == pytest.approx(0.24)  # of the two corners on the slope, not of the box around them


def test_level_gauges_follow_a_side_that_moves():
    """A column at rest between a wall and a piston has the depth of its volume, up to the piston."""
    push = {"motion": {"times": [0.0, 1.0], "positions": [0.0, -0.4]}}
    tank = {"high": [1.0, 0.5], "right": push, "top": OPEN}
    gauges = [{"name": name, "position": [x, 0.0], "quantities": ["level"]} for name, x in (("a", 0.05), ("b", 0.575))]
    scene = closed([box(0.0, 0.0, 1.0, 0.2)], tank=tank, gauges=gauges)
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    state.position[0] *= 0.6
    state.clock[0] = 1.0
    frame = SPH.observe(parameters, state, SPH.workspace(parameters, state, 1.0))
    assert frame.numbers["a_level"] == pytest.approx(0.2 / 0.6, rel=0.03)
    assert frame.numbers["b_level"] == pytest.approx(0.2 / 0.6, rel=0.03)


@pytest.mark.parametrize("radius", [0.1, 0.13, 0.17])
def test_dummies_of_a_disc_are_symmetric_about_its_axes_and_diagonals(radius):
    points, volume = dummies_of(Ball(np.zeros(2), radius), 0.03, 0.12)
    for turn in ([[-1, 0], [0, 1]], [[1, 0], [0, -1]], [[0, 1], [1, 0]]):
        distance, other = cKDTree(points).query(points @ np.array(turn))
        assert distance.max() < 1e-12
        assert (volume == volume[other]).all()


@pytest.mark.long
@pytest.mark.compiled
def test_a_neutral_disc_in_the_middle_neither_turns_nor_leaves_it():
    body = {"center": [0.5, 0.2], "radius": 0.1, "density": 1.0}
    *_, end = ecume.simulate(closed([box(0.0, 0.0, 1.0, 0.4)], bodies=[body]))
    assert abs(end.numbers["body0_angle"]) < 1e-9
    assert abs(end.numbers["body0_x"] - 0.5) < 1e-9


def test_liquid_that_leaves_through_an_open_side_breaks_no_invariant():
    walls, draining = (
        closed([box(0.0, 0.0, 1.0, 0.4)], tank={"high": SIZE, **sides}) for sides in ({}, {"left": OPEN})
    )
    names = [[each.name for each in SPH.invariants(scene, SPH.parameters(scene))] for scene in (walls, draining)]
    assert ["mass" in each for each in names] == [True, False]
