"""Creeping flow in ducts and between plates around obstacles in 3D, solved by finite elements."""

import itertools
import math

import numpy as np
import pytest

from ecume.citing import papers_of
from ecume.errors import SceneError
from ecume.laws.carrier_flows import creeping_flow_past_sphere
from ecume.models import MODELS
from ecume.models.tracers import divergence_free, obstacle_flows_3d, tetrahedral_mesh
from ecume.models.tracers.check_report import flow_through, surface_points
from ecume.models.tracers.liquid_flow import varying_flow
from ecume.models.tracers.simplex_bins import bins_of
from ecume.models.tracers.tank import bounds
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

pytest.importorskip("skfem")

BALL = {"center": [0.45, 0.45, 0.5], "radius": 0.2}
BLOCK = {"low": [0.95, 0.3, 0.3], "high": [1.2, 0.6, 0.55]}
OCTAHEDRON = {
    "vertices": [[1.3, 0.5, 0.5], [0.9, 0.5, 0.5], [1.1, 0.7, 0.5], [1.1, 0.3, 0.5], [1.1, 0.5, 0.7], [1.1, 0.5, 0.3]]
}


def scene_of(name, periodic, obstacles, high=(1.5, 1.0, 1.0), particles=None, **changes):
    """A duct, or plates, with obstacles."""
    plain = {
        "model": "tracers", "duration": 0.5, "frame_every": 0.5, "gravity": 0.0,
        "tank": {"high": list(high), "periodic": periodic}, "obstacles": obstacles,
        "flow": {"name": name, "speed": 0.2, "around_obstacles": "creeping"},
        "particles": [particles or {"radius": 1e-6, "density": 1000.0, "positions": [[0.1, 0.5, 0.5]]}],
        "integration": {"integrator": "overdamped"},
    }  # fmt: skip
    return from_plain({**plain, **changes})


@pytest.fixture
def coarse(monkeypatch):
    """Few elements, since what is tested is exact on any mesh."""
    monkeypatch.setattr(tetrahedral_mesh, "ON_SPHERE", 60)
    monkeypatch.setattr(tetrahedral_mesh, "COARSEST", 0.2)
    monkeypatch.setattr(obstacle_flows_3d, "COARSEST", 0.2)
    obstacle_flows_3d._solved.cache_clear()
    yield
    obstacle_flows_3d._solved.cache_clear()


def test_four_parts_of_a_tetrahedron_have_every_divergence_without_a_mean():
    field = divergence_free.inner_correction()
    found = np.einsum("aqc,scap->sqp", divergence_free.slopes(), field)
    wanted = -np.eye(10)
    wanted[0] += divergence_free.MEAN / divergence_free.MEAN[0]
    assert found == pytest.approx(np.tile(wanted, (4, 1, 1)), abs=1e-10)
    # On the face across from a corner the part with this corner's coordinate as the smallest is zero.
    share = np.random.default_rng(0).dirichlet(np.ones(3), 10)
    for part in range(4):
        others = [k for k in range(4) if k != part]
        places = share @ divergence_free.CORNERS[others]
        values = np.einsum("nc,cap->nap", divergence_free.monomials(places, divergence_free.CUBICS), field[part])
        assert np.abs(values).max() < 1e-12


@pytest.mark.long
@pytest.mark.parametrize("seed", range(2))
def test_the_mesh_fills_the_space_between_bodies_exactly(seed, monkeypatch):
    monkeypatch.setattr(tetrahedral_mesh, "COARSEST", 0.2)
    rng = np.random.default_rng(seed)
    low, high = np.zeros(3), np.array([1.5, 1.0, 1.2])
    sides = rng.uniform(0.15, 0.25, 3)
    corners = np.array(list(np.ndindex(2, 2, 2))) * sides + np.array([0.95, 0.4, 0.5])
    center = np.array([0.4, *rng.uniform(0.45, 0.55, 2)])
    bodies = [
        tetrahedral_mesh.ball(tuple(center.tolist()), 0.25, 0.15),
        tetrahedral_mesh.polyhedron(corners, 0.15),
    ]
    periodic = tuple(rng.random(3) < 0.5)
    mesh = tetrahedral_mesh.mesh_of(low, high, bodies, periodic)
    volume = np.abs(tetrahedral_mesh.volumes(mesh.nodes, mesh.tetrahedra)).sum()
    assert volume == pytest.approx(1.8 - sum(body.volume for body in bodies), rel=1e-9)
    assert tetrahedral_mesh.shapes_of(mesh.nodes, mesh.tetrahedra).min() > 0.01
    # No facet cuts the sphere, and none is far from it.
    depth = bodies[0].planes[:, :3] @ center + bodies[0].planes[:, 3]
    assert -0.25 * 1.02 < depth.min() <= depth.max() < -0.25 * (1.0 - 1e-9)
    for axis in np.flatnonzero(periodic):
        sides = [np.delete(mesh.nodes[mesh.nodes[:, axis] == end[axis]], axis, axis=1) for end in (low, high)]
        ordered = [side[np.lexsort(np.round(side, 9).T)] for side in sides]
        assert ordered[0] == pytest.approx(ordered[1], abs=1e-12)


@pytest.mark.parametrize("dimensions", [2, 3])
def test_bins_name_the_element_around_each_point(dimensions):
    from scipy.spatial import Delaunay

    rng = np.random.default_rng(dimensions)
    nodes = rng.random((60, dimensions))
    mesh = Delaunay(nodes)
    bins = bins_of(nodes[mesh.simplices], (0.0,) * dimensions, (1.0,) * dimensions, 5.0)
    points = rng.random((200, dimensions))
    where = mesh.find_simplex(points)
    for point, element in zip(points[where >= 0], where[where >= 0], strict=True):
        cell = tuple((point / np.array(bins.step)).astype(int))
        first = bins.first[cell]
        assert element in bins.near[first : first + bins.many[cell]]


@pytest.mark.long
def test_a_sphere_has_stokes_s_exact_flow_around_it(monkeypatch):
    """With the exact velocities at the sides of a box. The error is that of the polyhedron around the sphere, of second
    order in its edges.
    """
    monkeypatch.setattr(tetrahedral_mesh, "ON_SPHERE", 60)
    monkeypatch.setattr(tetrahedral_mesh, "COARSEST", 0.15)
    radius, center = 0.2, np.array([0.5, 0.5, 0.45])
    box = (np.zeros(3), np.ones(3))

    def exact(places):
        return np.array([
            creeping_flow_past_sphere(tuple((each - center).tolist()), radius, (1.0, 0.0, 0.0)) for each in places
        ])  # fmt: skip

    def given(places):
        found = exact(places)
        found[np.sqrt(((places - center) ** 2).sum(axis=1)) < 1.1 * radius] = 0.0
        return found

    points = np.random.default_rng(1).uniform(0.02, 0.98, (200, 3))
    points = points[np.sqrt(((points - center) ** 2).sum(axis=1)) > 1.1 * radius]
    error = []
    for edge in (0.09, 0.04):
        bodies = [tetrahedral_mesh.ball(tuple(center.tolist()), radius, edge)]
        mesh = tetrahedral_mesh.mesh_of(*box, bodies, (False,) * 3)
        solution = obstacle_flows_3d.solved(mesh, box, given, (False,) * 3, balanced=False)
        shape = obstacle_flows_3d.shape_of(solution, (0.0,) * 3, (1.0,) * 3)
        found = [obstacle_flows_3d.solid_obstacle_velocity(shape, *each, 0.0) for each in points.tolist()]
        error.append(float(np.sqrt(((np.array(found) - exact(points)) ** 2).sum(axis=1).mean())))
    assert error[0] < 0.01
    assert error[1] < 0.5 * error[0]


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "periodic", "obstacles"),
    [
        ("duct", [], [BALL, BLOCK]),
        ("duct", ["x"], [BALL, OCTAHEDRON]),
        ("channel", ["y"], [BALL]),
        ("channel", ["x", "y"], [BALL, OCTAHEDRON]),
    ],
)
@pytest.mark.usefixtures("coarse")
def test_no_liquid_crosses_walls_and_obstacles_and_none_gathers(name, periodic, obstacles):
    scene = scene_of(name, periodic, obstacles)
    flow = varying_flow(scene, bounds(scene)).unbounded()
    shape, high = flow.current.shape, np.array([1.5, 1.0, 1.0])
    inverse = shape.inverse[:, 3:].reshape(-1, 3, 3)
    divergence = np.einsum("aqc,tak,tsck->tsq", divergence_free.slopes(), inverse, shape.cubic)
    slopes = np.einsum("aqc,tak,tscm->tsqkm", divergence_free.slopes(), inverse, shape.cubic)
    assert np.abs(divergence).max() < 1e-11 * np.abs(slopes).max()
    for body in scene.obstacles:
        assert np.abs(flow.velocity(surface_points(body)[0], 0.0)).max() < 1e-11
        assert flow_through(flow, body) < 1e-11
    rng = np.random.default_rng(0)
    for axis in range(3):
        for value in (0.0, high[axis]):
            places = rng.uniform(0.0, high, (50, 3))
            places[:, axis] = value
            velocities = flow.velocity(places, 0.0)
            if "xyz"[axis] in periodic:
                places[:, axis] = high[axis] - value
                assert velocities == pytest.approx(flow.velocity(places, 0.0), abs=1e-9)
            elif axis > 0:
                assert np.abs(velocities).max() < 1e-11
    # The velocity does not jump where a line leaves one part of the mesh for another.
    line = np.linspace(0.0, 1.0, 2001)[:, None] * np.array([1.5, 0.9, 0.85]) + np.array([0.0, 0.05, 0.08])
    along = flow.velocity(line, 0.0)
    assert np.abs(np.diff(along, axis=0)).max() < 50.0 * 0.2 * float(np.linalg.norm(line[1] - line[0]))
    grid = (np.arange(24) + 0.5) / 24
    across, up = (each.ravel() for each in np.meshgrid(grid, grid, indexing="ij"))
    means = [
        flow.velocity(np.stack([np.full(len(up), x), across, up], axis=1), 0.0)[:, 0].mean()
        for x in (0.0, 0.1, 0.8, 1.5)
    ]
    assert means == pytest.approx([0.2] * 4, rel=5e-3)


@pytest.mark.long
@pytest.mark.usefixtures("coarse")
def test_check_cites_and_describes_the_flow():
    scene = scene_of("duct", [], [BALL])
    rows = {row[0]: row[1:] for row in MODELS["tracers"].summary(scene)}
    assert rows["flow"][1].startswith("creeping, around the obstacle: largest speed")
    assert float(rows["obstacle: Reynolds number"][0]) == pytest.approx(0.4 * 0.2 / 1e-6, rel=1e-3)
    assert "flow through obstacle 0" not in rows
    assert {"taylor1973", "zhang2005", "batchelor1967"} <= set(papers_of(scene))


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.usefixtures("coarse")
def test_tracers_pass_obstacles_and_keep_their_density():
    """A uniform suspension of tracers stays uniform: none is held, and none is missing behind an obstacle."""
    particles = {"radius": 1e-6, "density": 1000.0, "count": 4000, "low": [0.0] * 3, "high": [1.5, 1.0, 1.0]}
    scene = scene_of("duct", ["x"], [BALL, BLOCK], particles=particles, duration=3.0, frame_every=3.0)
    *_, last = simulate(scene)
    place = last.arrays["position"]
    assert last.numbers["particles_inside"] == 4000
    edges = [np.linspace(0.0, side, count + 1) for side, count in zip((1.5, 1.0, 1.0), (3, 2, 2), strict=True)]
    counts = np.histogramdd(place, edges)[0]
    steps = [(np.arange(count) + 0.5) / 100 for count in (150, 100, 100)]
    grid = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1)
    free = np.sqrt(((grid - np.array(BALL["center"])) ** 2).sum(axis=-1)) > BALL["radius"]
    free &= ~((grid > BLOCK["low"]) & (grid < BLOCK["high"])).all(axis=-1)
    share = free.reshape(3, 50, 2, 50, 2, 50).mean(axis=(1, 3, 5))
    expected = share / share.sum() * 4000
    assert np.abs(counts - expected).max() < 4.5 * math.sqrt(expected.max())


TINY = {"center": [5.0, 5.0, 5.0], "radius": 0.01}


@pytest.mark.parametrize(
    ("name", "periodic", "obstacles", "high", "words"),
    [
        ("duct", [], [{"center": [0.5, 0.22, 0.5], "radius": 0.2}], (1, 1, 1), "obstacle 0 is 0.0.* from another"),
        ("duct", [], [BALL, {"center": [0.84, 0.45, 0.5], "radius": 0.18}], (1.5, 1, 1), "from another or from a side"),
        ("duct", ["y"], [BALL], (1, 1, 1), r"tank\.periodic: the flow channel in 3D is periodic along y"),
        ("channel", [], [BALL], (1, 1, 1), r"tank\.periodic: the flow channel in 3D is periodic along y"),
        ("duct", [], [BALL], (60, 1, 1), "nodes; at most 12000 are solved"),
        ("duct", [], [TINY], (20, 10, 10), "too small for the channel|nodes; at most 12000"),
        ("tube", [], [BALL], (1, 1, 1), "or a creeping flow in a channel or duct"),
    ],
)  # fmt: skip
def test_obstacles_that_no_flow_goes_around_are_refused(name, periodic, obstacles, high, words):
    with pytest.raises(SceneError, match=words):
        MODELS["tracers"].parameters(scene_of(name, periodic, obstacles, high))


@pytest.mark.long
def test_a_body_that_no_mesh_fits_is_refused_with_the_way_out():
    dice = np.random.default_rng(0)
    for count in (30, 12):
        ways = dice.normal(size=(count, 3))
        ways *= dice.uniform(0.6, 1.0, (count, 1)) / np.linalg.norm(ways, axis=1)[:, None]
    body = {"vertices": (0.5 + 0.2 * ways).tolist()}
    with pytest.raises(SceneError, match=r"no mesh fits the obstacles.*read with flow\.field"):
        MODELS["tracers"].parameters(scene_of("duct", [], [body], (1, 1, 1)))


def test_a_duct_in_two_dimensions_is_refused():
    plain = {
        "model": "tracers", "duration": 0.5, "frame_every": 0.5, "tank": {"high": [3.0, 1.0]},
        "flow": {"name": "duct", "speed": 0.2, "around_obstacles": "creeping"},
        "obstacles": [{"center": [1.0, 0.5], "radius": 0.2}],
        "particles": [{"radius": 1e-6, "density": 1000.0, "positions": [[0.1, 0.5]]}],
    }  # fmt: skip
    with pytest.raises(SceneError, match=r"flow\.name: got 'duct' in 2D"):
        MODELS["tracers"].parameters(from_plain(plain))


def test_monomials_come_in_the_order_in_which_velocities_are_summed():
    order = [
        (first, second, total - first - second)
        for total in range(4)
        for first, second in itertools.product(range(total, -1, -1), range(total, -1, -1))
        if first + second <= total
    ]
    assert tuple(order) == divergence_free.CUBICS
