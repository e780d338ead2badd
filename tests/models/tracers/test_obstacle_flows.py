"""Creeping flow in channels around obstacles, solved by finite elements."""

import math

import numpy as np
import pytest

from ecume.citing import papers_of
from ecume.engine.walls import clearance
from ecume.errors import SceneError
from ecume.models import MODELS
from ecume.models.tracers import obstacle_flows
from ecume.models.tracers.check_report import surface_points
from ecume.models.tracers.liquid_flow import varying_flow
from ecume.models.tracers.tank import body_of, bounds
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

pytest.importorskip("skfem")

DISC = {"center": [1.0, 0.45], "radius": 0.15}
TRIANGLE = {"vertices": [[1.7, 0.3], [2.0, 0.35], [1.8, 0.7]]}


def scene_of(obstacles, particles=None, **changes):
    """A channel of 3 by 1 with obstacles."""
    plain = {
        "model": "tracers", "duration": 0.5, "frame_every": 0.5, "gravity": 0.0, "tank": {"high": [3.0, 1.0]},
        "flow": {"name": "channel", "speed": 0.2, "around_obstacles": "creeping"}, "obstacles": obstacles,
        "particles": [particles or {"radius": 1e-6, "density": 1000.0, "positions": [[0.2, 0.5]]}],
        "integration": {"integrator": "overdamped"},
    }  # fmt: skip
    return from_plain({**plain, **changes})


@pytest.fixture(scope="module")
def flow():
    scene = scene_of([DISC, TRIANGLE])
    return varying_flow(scene, bounds(scene))


@pytest.mark.long
def test_no_liquid_crosses_walls_and_obstacles_and_as_much_flows_everywhere(flow):
    angle = np.linspace(0.0, 2.0 * math.pi, 100)
    around = np.stack([1.0 + 0.15 * np.cos(angle), 0.45 + 0.15 * np.sin(angle)], axis=1)
    assert np.abs(flow.velocity(around, 0.0)).max() < 1e-12
    corners = np.array(TRIANGLE["vertices"])
    for share in (0.2, 0.7):
        side = corners + share * (np.roll(corners, -1, axis=0) - corners)
        assert np.abs(flow.velocity(side, 0.0)).max() < 1e-9
    x = np.linspace(0.1, 2.9, 7)
    assert np.abs(flow.velocity(np.stack([x, 0.0 * x], axis=1), 0.0)).max() < 1e-12
    z = (np.arange(1000) + 0.5) / 1000
    for place in (0.0, 0.7, 1.0, 1.85, 3.0):
        across = flow.velocity(np.stack([np.full(1000, place), z], axis=1), 0.0)
        assert across[:, 0].mean() == pytest.approx(0.2, rel=1e-5)


def test_the_flow_has_no_divergence_anywhere(flow):
    points, h = np.random.default_rng(1).uniform((0.05, 0.05), (2.95, 0.95), (100, 2)), 1e-5
    right, up = np.array([h, 0.0]), np.array([0.0, h])
    along = flow.velocity(points + right, 0.0) - flow.velocity(points - right, 0.0)
    upward = flow.velocity(points + up, 0.0) - flow.velocity(points - up, 0.0)
    size = np.abs(along / (2.0 * h)).max()
    # Where an edge of the mesh is within h, slopes of two triangles are mixed.
    assert np.quantile(np.abs(along[:, 0] + upward[:, 1]) / (2.0 * h), 0.9) < 1e-7 * size


@pytest.mark.long
def test_a_slow_flow_is_the_same_forward_and_backward():
    """Stokes's equations are reversible: the mirror image of a symmetric disc has the same velocity along x."""
    scene = scene_of([{"center": [1.5, 0.45], "radius": 0.2}])
    found = varying_flow(scene, bounds(scene))
    points = np.random.default_rng(2).uniform((0.1, 0.1), (1.2, 0.9), (50, 2))
    mirrored = np.stack([3.0 - points[:, 0], points[:, 1]], axis=1)
    one, other = found.velocity(points, 0.0), found.velocity(mirrored, 0.0)
    assert one[:, 0] == pytest.approx(other[:, 0], abs=5e-3 * 0.2)
    assert one[:, 1] == pytest.approx(-other[:, 1], abs=5e-3 * 0.2)


@pytest.mark.long
def test_a_finer_mesh_has_the_same_flow(monkeypatch):
    scene = scene_of([DISC])
    points = np.random.default_rng(3).uniform((0.1, 0.1), (2.9, 0.9), (60, 2))
    points = points[np.hypot(points[:, 0] - 1.0, points[:, 1] - 0.45) > 0.17]
    coarse = varying_flow(scene, bounds(scene)).velocity(points, 0.0)
    monkeypatch.setattr(obstacle_flows, "COARSEST", 0.06)
    monkeypatch.setattr(obstacle_flows, "ROUND", 80)
    obstacle_flows._solved.cache_clear()
    fine = varying_flow(scene, bounds(scene)).velocity(points, 0.0)
    obstacle_flows._solved.cache_clear()
    # Of the mean speed; the polygon around the disc has 0.14 and 0.05 % more than its area.
    assert np.abs(coarse - fine).max() < 0.01 * 0.2


@pytest.mark.long
@pytest.mark.parametrize("seed", [6, 36])
def test_polygons_with_sides_of_very_different_lengths_have_a_mesh(seed):
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(0.0, 6.283, int(rng.integers(3, 7))))
    body = [1.0, 0.5] + rng.uniform(0.05, 0.3) * np.column_stack([np.cos(angles), np.sin(angles)])
    sides = np.linalg.norm(np.roll(body, -1, axis=0) - body, axis=1)
    assert sides.min() < 0.02 * sides.max()
    nodes, triangles = obstacle_flows.mesh_of((0.0, 0.0), (2.0, 1.0), [body])
    (ax, ay), (bx, by) = np.moveaxis(nodes[triangles[:, 1:]] - nodes[triangles[:, :1]], (1, 2), (0, 1))
    hole = 0.5 * np.sum(body[:, 0] * np.roll(body[:, 1], -1) - np.roll(body[:, 0], -1) * body[:, 1])
    assert 0.5 * np.abs(ax * by - ay * bx).sum() == pytest.approx(2.0 - hole, rel=1e-12)


@pytest.mark.long
@pytest.mark.compiled
def test_tracers_pass_obstacles_and_keep_their_density():
    """A uniform suspension of tracers stays uniform: none is held, and none is missing behind an obstacle."""
    particles = {"radius": 1e-6, "density": 1000.0, "count": 20000, "low": [0.0, 0.0], "high": [3.0, 1.0]}
    periodic = {"tank": {"high": [3.0, 1.0], "periodic": ["x"]}, "duration": 5.0, "frame_every": 5.0}
    *_, last = simulate(scene_of([DISC, TRIANGLE], particles, **periodic))
    place = last.arrays["position"]
    assert last.numbers["particles_inside"] == 20000
    counts = np.histogram2d(place[:, 0], place[:, 1], bins=(6, 2), range=((0.0, 3.0), (0.0, 1.0)))[0]
    grid = np.stack(np.meshgrid((np.arange(1200) + 0.5) / 400, (np.arange(400) + 0.5) / 400, indexing="ij"), axis=-1)
    free = np.hypot(grid[..., 0] - 1.0, grid[..., 1] - 0.45) > 0.15
    free &= ~obstacle_flows._within(grid.reshape(-1, 2), np.array(TRIANGLE["vertices"])).reshape(free.shape)
    share = free.reshape(6, 200, 2, 200).mean(axis=(1, 3))
    expected = share / share.sum() * 20000
    assert np.abs(counts - expected).max() < 4.5 * np.sqrt(expected.max())


def test_the_points_at_which_the_flow_is_examined_are_on_obstacles():
    for plain in (TRIANGLE, {"low": [1.0, 2.0], "high": [3.0, 5.0]}, DISC):
        body = scene_of([plain]).obstacles[0]
        places, normals = surface_points(body)
        assert clearance(places, body_of(body))[0] == pytest.approx(0.0, abs=1e-12)
        assert (normals * (places - places.mean(axis=0))).sum(axis=1).min() > 0.0


@pytest.mark.long
def test_check_cites_and_describes_the_flow():
    scene = scene_of([DISC, TRIANGLE])
    rows = {row[0]: row[1:] for row in MODELS["tracers"].summary(scene)}
    assert rows["flow"][1].startswith("creeping, around obstacles: largest speed")
    assert float(rows["obstacle: Reynolds number"][0]) == pytest.approx(0.4 * 0.2 / 1e-6, rel=1e-3)
    assert {"scott1985", "batchelor1967"} <= set(papers_of(scene))


@pytest.mark.parametrize(
    ("obstacles", "changes", "words"),
    [
        ([{"center": [1.0, 0.2], "radius": 0.2}], {}, "obstacle 0 is outside of the channel, or 0 m from"),
        ([DISC, {"center": [1.31, 0.45], "radius": 0.155}], {}, "from another or from a side; expected at least 0.02"),
        ([DISC, {"center": [1.0, 0.45], "radius": 0.05}], {}, "obstacle [01] is .*0 m from"),
        ([{"center": [1.0, 0.5], "radius": 1e-4}], {}, "is 1.31e-05 m, too short for a mesh"),
        ([], {}, "got no obstacles"),
        ([DISC], {"tank": {"radius": 3.0}, "flow": {"name": "channel", "speed": 1.0, "around_obstacles": "creeping",
         "low": [0.0, 0.0], "high": [1.0, 1.0]}}, "is not used by a channel with obstacles"),
        ([DISC], {"flow": {"name": "channel", "speed": 1.0, "around_obstacles": "ideal"}}, "needs a uniform flow"),
    ],
)  # fmt: skip
def test_obstacles_that_no_flow_goes_around_are_refused(obstacles, changes, words):
    with pytest.raises(SceneError, match=words):
        MODELS["tracers"].parameters(scene_of(obstacles, **changes))


@pytest.mark.long
def test_a_periodic_array_has_one_flux_and_the_same_flow_on_both_sides():
    """No liquid crosses walls and obstacles, the mean speed is that of the key, and nothing diverges."""
    scene = scene_of([DISC, TRIANGLE], tank={"high": [2.3, 1.0], "periodic": ["x"]})
    found = varying_flow(scene, bounds(scene)).unbounded()
    z = (np.arange(1000) + 0.5) / 1000
    for place in (0.0, 0.7, 1.0, 1.85, 2.3):
        across = found.velocity(np.stack([np.full(1000, place), z], axis=1), 0.0)
        assert across[:, 0].mean() == pytest.approx(0.2, rel=1e-5)
    sides = [found.velocity(np.stack([np.full(1000, place), z], axis=1), 0.0) for place in (0.0, 2.3)]
    assert sides[1] == pytest.approx(sides[0], abs=1e-9)
    # Unlike between plates alone, the wake of one disc meets the next.
    assert np.abs(sides[0][:, 1]).max() > 1e-3 * 0.2
    angle = np.linspace(0.0, 2.0 * math.pi, 100)
    around = np.stack([1.0 + 0.15 * np.cos(angle), 0.45 + 0.15 * np.sin(angle)], axis=1)
    assert np.abs(found.velocity(around, 0.0)).max() < 1e-12
    points, h = np.random.default_rng(3).uniform((0.05, 0.05), (2.25, 0.95), (100, 2)), 1e-5
    right, up = np.array([h, 0.0]), np.array([0.0, h])
    along = found.velocity(points + right, 0.0) - found.velocity(points - right, 0.0)
    upward = found.velocity(points + up, 0.0) - found.velocity(points - up, 0.0)
    rate = np.abs(along[:, 0] + upward[:, 1]) / (2.0 * h)
    assert np.quantile(rate, 0.9) < 1e-7 * np.abs(along / (2.0 * h)).max()


@pytest.mark.long
def test_a_long_period_has_the_flow_of_a_single_obstacle():
    """Within 1e-5 of the mean speed where the ends are two widths from the disc. What a disc changes decays by e^-4.2
    over a width, so that at one width the two differ by 0.6 %, on any mesh: there the single disc is already felt
    where the velocity of the channel is prescribed.
    """
    disc = {"center": [2.0, 0.45], "radius": 0.15}
    alone, repeated = (
        varying_flow(scene, bounds(scene))
        for scene in (
            scene_of([disc], tank={"high": [4.0, 1.0]}),
            scene_of([disc], tank={"high": [4.0, 1.0], "periodic": ["x"]}),
        )
    )
    points = np.random.default_rng(4).uniform((1.6, 0.05), (2.4, 0.95), (100, 2))
    assert repeated.velocity(points, 0.0) == pytest.approx(alone.velocity(points, 0.0), abs=1e-5 * 0.2)


def test_an_array_that_is_periodic_across_is_refused():
    with pytest.raises(SceneError, match=r"tank\.periodic: got y beside a flow around obstacles"):
        MODELS["tracers"].parameters(scene_of([DISC], tank={"high": [3.0, 1.0], "periodic": ["y"]}))
