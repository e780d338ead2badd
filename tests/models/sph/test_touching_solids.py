"""What obstacles and bodies bear that touch a wall or one another, and what is beside them."""

import math

import numpy as np
import pytest

import ecume
from ecume.engine.shapes import Ball, Box, Polygon
from ecume.models.sph import SPH
from ecume.models.sph.boundaries import touching_solids
from ecume.models.sph.boundaries.touching_solids import exchanged_loads, kernel_sums
from ecume.models.sph.setup.walls_and_bodies import PANEL
from ecume.scenes.schema import from_plain, to_plain
from tests.models.sph.scenes import OPEN

RADIUS, SPACING = 0.15, 0.05


def pool(spacing=SPACING, walls="mirror", duration=2.0, **solids):
    """Water under unit gravity, 1.2 wide and 1 deep."""
    return from_plain(
        {
            "model": "sph", "duration": duration, "frame_every": 0.5, "spacing": spacing, "gravity": [0.0, -1.0],
            "liquid": {"density": 1.0}, "tank": {"high": [1.2, 1.5], "top": OPEN, "walls": walls},
            "fluid": [{"low": [0.0, 0.0], "high": [1.2, 1.0]}], **solids,
        }
    )  # fmt: skip


def disc(height, **more):
    return {"center": [0.6, height], "radius": RADIUS, **more}


AREA = math.pi * RADIUS**2


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("walls", ["mirror", "dummy"])
@pytest.mark.parametrize("gap", [0.0, 0.5, 2.0])
def test_a_disc_on_or_close_to_the_floor_has_the_lift_of_its_area(gap, walls):
    *_, end = ecume.simulate(pool(walls=walls, obstacles=[disc(RADIUS + gap * SPACING)]))
    assert end.numbers["obstacle0_force_y"] == pytest.approx(AREA, rel=0.02)
    assert end.numbers["obstacle0_force_x"] == pytest.approx(0.0, abs=0.01 * AREA)
    assert end.numbers["bottom_force_y"] == pytest.approx(-1.2, rel=0.01)  # of the liquid up to the level, disc or not


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("walls", ["mirror", "dummy"])
def test_a_slope_between_wall_and_floor_bears_the_pressure_over_it(walls):
    """So do the wall and the floor, neither of which has a force along it."""
    slope = {"vertices": [[0.0, 0.0], [0.4, 0.0], [0.0, 0.4]]}
    *_, end = ecume.simulate(pool(walls=walls, obstacles=[slope]))
    for axis in "xy":
        assert end.numbers[f"obstacle0_force_{axis}"] == pytest.approx(-0.5 + 0.5 * 0.6**2, rel=0.01)
    assert end.numbers["left_force_x"] == pytest.approx(-0.5 * 0.6**2, rel=0.03)
    assert end.numbers["right_force_x"] == pytest.approx(0.5, rel=0.02)
    assert abs(end.numbers["left_force_y"]) < 0.005
    assert abs(end.numbers["bottom_force_x"]) < 0.005
    assert end.numbers["bottom_force_y"] == pytest.approx(-0.8, rel=0.01)


@pytest.mark.compiled
def test_a_block_on_the_floor_is_dry_below():
    *_, end = ecume.simulate(pool(obstacles=[{"low": [0.45, 0.0], "high": [0.75, 0.3]}]))
    assert end.numbers["obstacle0_force_y"] == pytest.approx(-0.3 * 0.7, rel=0.01)


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize(("density", "rises"), [(0.5, True), (3.0, False)])
def test_a_body_on_the_floor_rises_if_it_is_light_and_pays_for_it(density, rises):
    frames = list(ecume.simulate(pool(bodies=[disc(RADIUS, density=density)])))
    start, end = frames[0], frames[-1]
    assert start.numbers["body0_force_y"] == pytest.approx(AREA, rel=0.05)
    assert (end.numbers["body0_y"] > 2.0 * RADIUS) == rises
    left = [frame.numbers["total_energy"] - frame.numbers["injected_work"] for frame in frames]
    assert np.diff(left).max() < 1e-4 * left[0]


@pytest.mark.parametrize("spacings", [1.0, 2.0, 3.0])
def test_panels_of_a_ball_are_fine_enough(spacings):
    """Half a spacing wide: the pressure of a pool has the lift of the volume within 1 %, within 1e-3 from two on."""
    points, normal, area = Ball(np.array([0.3, -0.2, 0.5]), spacings).panels(PANEL[3])
    lift = (points[:, 1] * normal[:, 1] * area).sum()
    volume = 4.0 / 3.0 * math.pi * spacings**3
    assert lift == pytest.approx(volume, rel=0.01 if spacings < 2.0 else 1e-3)
    assert np.abs((points[:, 1] * area) @ normal[:, [0, 2]]).max() < (0.01 if spacings < 2.0 else 1e-3) * volume


def test_sums_at_points_are_those_over_all_pairs():
    rng = np.random.default_rng(3)
    for d in (2, 3):
        place, points, values = rng.uniform(size=(d, 200)), rng.uniform(-0.2, 1.2, (d, 50)), rng.normal(size=(2, 200))
        sums, nearest = kernel_sums(points, place, values, 0.3)
        apart = np.sqrt(((points[:, :, None] - place[:, None]) ** 2).sum(axis=0))
        weight = np.maximum(1.0 - apart / 0.3, 0.0) ** 4 * (4.0 * apart / 0.3 + 1.0)
        assert sums == pytest.approx(values @ weight.T, abs=1e-12)
        there = apart.min(axis=1) < 0.3
        assert (nearest == np.where(there, apart.argmin(axis=1), -1)).all()


@pytest.mark.long
@pytest.mark.compiled
def test_the_energy_budget_takes_the_loads_that_moved_the_bodies(monkeypatch):
    scene = pool(bodies=[disc(RADIUS, density=2.0)], duration=0.5)
    *_, before = ecume.simulate(scene)
    monkeypatch.setattr(touching_solids, "exchanged_loads", None)  # `right_hand_side` has its own
    *_, after = ecume.simulate(scene)
    assert after.numbers["injected_work"] == before.numbers["injected_work"] != 0.0


@pytest.mark.parametrize("walls", ["mirror", "dummy"])
@pytest.mark.parametrize("place", [(0.5, 0.4), (0.5, 0.25)])
def test_loads_of_a_mirrored_tank_are_mirrored(place, walls):
    """Also of a disc that two walls are equally close to: the exchange once took the first of them."""
    found = []
    for x, sign in ((place[0], 1.0), (1.0 - place[0], -1.0)):
        scene = pool(spacing=0.125, walls=walls, obstacles=[{"center": [x, place[1]], "radius": 0.2}])
        plain = to_plain(scene)
        plain["tank"]["high"], plain["fluid"] = [1.0, 1.5], [{"low": [0.0, 0.0], "high": [0.5, 1.0]}]
        if sign < 0.0:
            plain["fluid"] = [{"low": [0.5, 0.0], "high": [1.0, 1.0]}]
        numbers = next(iter(ecume.simulate(from_plain(plain)))).numbers
        sides = ("left", "right", "bottom", "obstacle0")
        other = {"left": "right", "right": "left"} if sign < 0.0 else {}
        found.append(
            [
                numbers[f"{other.get(side, side)}_force_{axis}"] * (sign if axis == "x" else 1.0)
                for side in sides
                for axis in "xy"
            ]
        )
    np.testing.assert_allclose(found[0], found[1], atol=1e-12)
    assert np.abs(found[0]).max() > 0.1


@pytest.mark.parametrize("gap", [-0.01, 0.0, 0.005])
def test_a_dry_post_on_the_floor_of_a_hollow_tank_bears_nothing(gap):
    basin = {"vertices": [[0.3, 0.3], [0.9, 0.3], [0.9, 1.4], [0.3, 1.4]], "hollow": True}
    post = {"low": [0.8, 0.3 + gap], "high": [0.9, 0.8]}
    scene = pool(fluid=[{"low": [0.3, 0.3], "high": [0.5, 0.6]}], obstacles=[post, basin], walls="dummy")
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    frame = SPH.observe(parameters, state, SPH.workspace(parameters, state, 1.0))
    assert frame.numbers["obstacle0_force_x"] == frame.numbers["obstacle0_force_y"] == 0.0


@pytest.mark.long
@pytest.mark.parametrize("bodies", [[disc(RADIUS, density=2.0)], [disc(RADIUS, density=2.0), disc(0.46, density=0.5)]])
def test_what_one_gets_the_other_loses(bodies):
    scene = pool(bodies=bodies, obstacles=[{"low": [0.8, 0.0], "high": [1.0, 0.3]}])
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    workspace = SPH.workspace(parameters, state, 1.0)
    SPH.observe(parameters, state, workspace)
    found = exchanged_loads(parameters, state, workspace)
    force = np.sum([load[0] for load in found.values()], axis=0)
    turn = np.sum(
        [load[1] + np.cross(parameters.boundary.centers[owner], load[0]) for owner, load in found.items()], axis=0
    )
    assert np.abs(force).max() < 1e-12
    assert np.abs(turn).max() < 1e-12
    assert np.abs(found[5 if bodies else 4][0]).max() > 0.1 * AREA


@pytest.mark.parametrize(
    "shape",
    [
        Ball(np.array([1.0, 2.0]), 0.5), Ball(np.array([1.0, 2.0, 3.0]), 0.5),
        Box(np.array([1.0, 2.0]), np.array([1.5, 3.0])), Box(np.array([1.0, 2.0, 0.0]), np.array([1.5, 3.0, 0.7])),
        Polygon(np.array([[0.0, 0.0], [2.0, 0.0], [1.0, 1.5]])),
        Polygon(np.array([[0.0, 0.0], [1.0, 1.5], [2.0, 0.0]])),
    ],
)  # fmt: skip
def test_panels_close_and_enclose_the_volume(shape):
    """Gauss: the sum of n A is zero, that of x.n A is the volume in each direction."""
    points, normal, area = shape.panels(0.03)
    assert area.sum() == pytest.approx(shape.surface(), rel=1e-9)
    assert np.abs((area[:, None] * normal).sum(axis=0)).max() < 2e-3 * shape.surface()
    each = ((points - shape.middle()) * normal * area[:, None]).sum(axis=0)
    assert each == pytest.approx(np.full(points.shape[1], shape.volume()), rel=0.01)
