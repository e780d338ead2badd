"""Obstacles, rigid bodies, and the guard behind the walls."""

import numpy as np
import pytest

import ecume
from ecume._jit import use_threads
from ecume.engine.shapes import Ball, Box, Polygon
from ecume.errors import SceneError
from ecume.models.sph.boundaries.forces_on_solids import loads
from ecume.models.sph.boundaries.rigid_bodies import accelerations_of, collide, move_bodies, rotations
from ecume.models.sph.rates.right_hand_side import evaluate_accelerations
from ecume.models.sph.record import SPH
from ecume.models.sph.setup.shapes import dummies_of, obstacle_dummies
from ecume.scenes.schema import from_plain, to_plain
from tests.models.sph.scenes import free_blob, tank
from tests.models.sph.test_runs import integrated

pytestmark = pytest.mark.sampled(2)


def changed(scene, **tables):
    return from_plain({**to_plain(scene), **tables})


def last_of(scene):
    (*_, last) = ecume.simulate(scene)
    return last


SHAPES = [
    Box(np.array([0.0, 1.0]), np.array([2.0, 1.5])),
    Ball(np.array([0.3, -0.2]), 0.7),
    Polygon(np.array([[0.0, 0.0], [2.0, 0.0], [1.5, 1.0], [0.2, 0.8]])),
    Box(np.zeros(3), np.array([1.0, 2.0, 0.5])),
    Ball(np.array([0.3, -0.2, 1.0]), 0.7),
]


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: f"{type(shape).__name__}{len(shape.middle())}")
def test_the_way_to_a_surface_leads_there(shape):
    low, high = shape.bounds()
    points = np.random.default_rng(1).uniform(low - 0.5, high + 0.5, (400, len(low)))
    gap, normal = shape.nearest(points)
    assert np.array_equal(gap < 0.0, shape.inside(points))
    np.testing.assert_allclose(shape.nearest(points - gap[:, None] * normal)[0], 0.0, atol=1e-12)
    np.testing.assert_allclose(shape.nearest(shape.rim(0.1))[0], 0.0, atol=1e-12)


@pytest.mark.parametrize("radius", [0.19833634655429808, 0.05, 0.31, 1.0])
def test_a_disc_touches_the_floor_with_its_lowest_point_in_any_mirrored_tank(radius):
    """With 35 points a disc that fell on the floor bounced to one side, and mirrored tanks differed."""
    rim = Ball(np.zeros(2), radius).rim(0.036)
    assert rim[:, 1].min() == pytest.approx(-radius, rel=1e-12)
    for turn in ([-1.0, 1.0], [1.0, -1.0]):
        apart = np.linalg.norm(rim[:, None] - turn * rim[None], axis=2)
        assert apart.min(axis=0).max() < 1e-12 * radius


@pytest.mark.parametrize("seed", range(12))
def test_dummies_of_obstacles_at_sides_are_mirrored_in_a_mirrored_tank(seed):
    """Rows that meet no side start anywhere: those of a disc that touched the floor were not mirrored, and after 100
    steps mirrored tanks differed by 3 %.
    """
    rng = np.random.default_rng(seed)
    radius = float(rng.uniform(0.11, 0.3))
    x, y = float(rng.uniform(0.35, 0.65)), float(rng.choice([radius, 0.9 * radius, 0.2 * radius, 0.5]))
    turn, found = float(rng.uniform(0.0, 1.5)), []
    for sign in (1.0, -1.0):
        solid = {"center": [0.5 + sign * (x - 0.5), y], "radius": radius}
        if seed % 3 == 2:
            at = turn + 0.5 * np.pi * np.arange(4)[:: int(sign)]
            corners = np.stack([x + radius * np.cos(at), np.maximum(y + radius * np.sin(at), 0.0)], axis=1)
            solid = {"vertices": [[0.5 + sign * (a - 0.5), b] for a, b in corners.tolist()]}
        plain = {**to_plain(tank()), "obstacles": [solid]}
        plain["tank"] = {"high": [1.0, 1.0], "walls": "mirror"}
        points, volume = obstacle_dummies(from_plain(plain), 0.15)[0]
        found.append(np.column_stack([0.5 + sign * (points[:, 0] - 0.5), points[:, 1], volume]))
    apart = np.linalg.norm(found[0][:, None] - found[1][None], axis=2)
    assert len(found[0]) == len(found[1])
    assert max(apart.min(axis=0).max(), apart.min(axis=1).max()) < 1e-12


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: f"{type(shape).__name__}{len(shape.middle())}")
def test_middle_volume_and_inertia_are_those_of_a_fine_lattice(shape):
    low, high = shape.bounds()
    axes = [np.linspace(a, b, 121)[:-1] + (b - a) / 240 for a, b in zip(low, high, strict=True)]
    points = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)
    inside = points[shape.inside(points)]
    assert shape.volume() == pytest.approx(len(inside) / len(points) * np.prod(high - low), rel=5e-3)
    np.testing.assert_allclose(inside.mean(axis=0), shape.middle(), atol=2e-3)
    away = np.pad(inside - shape.middle(), ((0, 0), (0, 3 - len(low))))
    moments = ((away**2).sum(axis=1)[:, None] - away**2).mean(axis=0)
    np.testing.assert_allclose(shape.inertia()[5 - len(low) - 1 :], moments[5 - len(low) - 1 :], rtol=1e-2)


ASKEW = [[[0.0, 0.0], [0.9, 0.1], [0.5, 0.6]], [[0.0, 0.0], [0.3, 1.0], [1.1, 0.9], [1.2, 0.2]]]


@pytest.mark.parametrize("vertices", ASKEW)
@pytest.mark.parametrize("turn", [1, -1])
def test_a_polygon_has_no_holes_that_liquid_could_find(vertices, turn):
    shape = Polygon(np.array(vertices)[::turn])
    points, volume = dummies_of(shape, 0.05, 10.0)
    assert volume.sum() == pytest.approx(shape.volume(), rel=1e-12)
    assert shape.nearest(points)[0].max() == pytest.approx(-0.025, abs=1e-12)
    rim = shape.rim(0.01)
    corner = np.linalg.norm(rim[:, None] - shape.vertices[None], axis=2).min(axis=1) < 0.1
    away = np.linalg.norm(rim[~corner, None] - points[None], axis=2).min(axis=1)
    assert away.max() < 0.75 * 0.05


def test_a_polygon_that_is_not_convex_is_known():
    assert Polygon(np.array(ASKEW[1])).convex()
    assert not Polygon(np.array([[0.0, 0.0], [1.0, 0.0], [0.2, 0.2], [0.0, 1.0]])).convex()


@pytest.mark.compiled
@pytest.mark.parametrize("walls", ["mirror", "dummy"])
def test_walls_carry_the_liquid(walls):
    numbers = last_of(tank(walls=walls, jitter=0.0)).numbers
    assert numbers["bottom_force_y"] == pytest.approx(-1.0, abs=0.05)
    assert numbers["left_force_x"] == pytest.approx(-0.5, abs=0.02)
    assert numbers["right_force_x"] == pytest.approx(0.5, abs=0.02)


@pytest.mark.compiled
def test_reflection_alone_keeps_all_inside_and_counts():
    last = last_of(tank(walls="reflect"))
    x, y = last.arrays["position"].T
    assert min(x.min(), 1.0 - x.max(), y.min()) >= 0.999e-3 / 8
    assert last.numbers["guard_hits"] == sum(last.numbers[f"{side}_hits"] for side in ("left", "right", "bottom"))
    assert last.numbers["bottom_hits"] > 0


@pytest.mark.compiled
def test_an_obstacle_keeps_the_liquid_out_and_is_lifted_by_what_it_displaces():
    disc = {"center": [0.5, 0.45], "radius": 0.2}
    scene = changed(tank(deep=16, jitter=0.0), obstacles=[disc], duration=0.5)
    last = last_of(scene)
    away = np.linalg.norm(last.arrays["position"] - [0.5, 0.45], axis=1)
    assert away.min() > 0.2
    lift = np.pi * 0.2**2
    assert last.numbers["obstacle0_force_y"] == pytest.approx(lift, rel=0.25)
    assert abs(last.numbers["obstacle0_force_x"]) < 0.1 * lift
    assert last.numbers["obstacle0_hits"] == 0


WEDGE = {"vertices": [[0.3, 0.0], [0.7, 0.0], [0.6, 0.3], [0.4, 0.3]]}


@pytest.mark.compiled
def test_an_obstacle_on_the_floor_bears_the_liquid_above_it_and_no_image():
    frames = list(ecume.simulate(changed(tank(deep=20, jitter=0.0), obstacles=[WEDGE], duration=0.5)))
    above, liquid = 0.2 * 0.7 + 2 * 0.1 * 0.85, 1.0 - 0.5 * (0.4 + 0.2) * 0.3
    down = [frame.numbers["obstacle0_force_y"] for frame in frames]
    floor = [frame.numbers["bottom_force_y"] for frame in frames]
    assert np.mean(down) == pytest.approx(-above, rel=0.15)  # 0.10 here, 0.05 at twice the resolution
    assert np.mean(down) + np.mean(floor) == pytest.approx(-liquid, rel=0.05)
    assert abs(frames[-1].numbers["obstacle0_force_x"]) < 1e-10


@pytest.mark.compiled
@pytest.mark.parametrize("force", ["sum", "monaghan"])
def test_the_force_on_solids_is_minus_that_on_the_liquid(force):
    scene = changed(tank(deep=10, pressure_force=force, jitter=0.0), obstacles=[WEDGE])
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    workspace = SPH.workspace(parameters, state, 1.0)
    SPH.advance(parameters, state, workspace, 1)
    evaluate_accelerations(parameters, state, workspace, 0.0)
    report = sum(force for _, force, _ in loads(parameters, workspace))[:2]
    gained = state.acceleration @ state.mass - parameters.gravity * state.mass.sum()
    # Not to the last bit: an image has its source's pressure and the weight between, and so has a dummy's.
    np.testing.assert_allclose(gained, -report, atol=2e-4 * np.abs(report).max())


def body(**more):
    return {"low": [-0.3, -0.3], "high": [0.3, 0.3], "density": 500.0, "spin": 1.0, "velocity": [0.4, 0.1], **more}


@pytest.mark.compiled
@pytest.mark.parametrize("force", ["sum", "monaghan", "transport"])
def test_what_a_body_gets_the_liquid_loses(force):
    # At a free surface there must be no background pressure.
    more = {"background_pressure": 0.0} if force == "transport" else {}
    scene = changed(free_blob(pressure_force=force, **more), bodies=[body()])
    parameters = SPH.parameters(scene)
    if force == "transport":  # a little of it, so that the momentum that it carries counts
        parameters = parameters._replace(background=10.0)
    state = SPH.start(scene, parameters)
    mass = parameters.bodies.mass[0]

    def momentum():
        return state.velocity @ state.mass + mass * state.motion[:2, 0]

    before, alone = momentum(), state.motion[:2, 0].copy()
    SPH.advance(parameters, state, SPH.workspace(parameters, state, 1.0), 20)
    moved = np.abs(mass * (state.motion[:2, 0] - alone)).max()
    assert moved > 1.0
    np.testing.assert_allclose(momentum(), before, atol=1e-10 * moved)


@pytest.mark.long
@pytest.mark.compiled
def test_threads_change_no_bit_of_a_body_or_of_a_load():
    scene = changed(tank(deep=72), bodies=[{"center": [0.5, 0.9], "radius": 0.2, "density": 0.5, "spin": 1.0}])
    before, found = use_threads(None), []
    try:
        for threads in (1, 2):
            use_threads(threads)
            parameters, state = integrated(scene, 3)
            frame = SPH.observe(parameters, state, SPH.workspace(parameters, state, 1.0))
            found.append((state.motion.tobytes(), state.velocity.tobytes(), frame.numbers))
    finally:
        use_threads(before)
    assert found[0] == found[1]


@pytest.mark.long
@pytest.mark.compiled
def test_a_box_of_half_the_density_floats_half_immersed():
    box = {"low": [0.25, 0.85], "high": [0.75, 1.15], "density": 0.5}
    numbers = [
        frame.numbers for frame in ecume.simulate(changed(tank(deep=12, jitter=0.0), bodies=[box], duration=4.0))
    ]
    # It displaces what it was put in the place of: the level stays at 1.
    assert np.mean([row["body0_y"] for row in numbers[-20:]]) == pytest.approx(1.0, abs=0.02)
    assert np.mean([row["body0_force_y"] for row in numbers[-20:]]) == pytest.approx(0.5 * 0.15, rel=0.03)
    assert abs(numbers[-1]["body0_angle"]) < 0.1


@pytest.mark.long
@pytest.mark.compiled
def test_a_heavy_box_sinks_to_the_bottom():
    # With 8 particles over the depth the box would be exactly three cells wide, and in a perfectly symmetric start it
    # stands on the column below its middle: an unstable balance that any disorder ends.
    box = {"low": [0.3, 0.8], "high": [0.7, 1.2], "density": 3.0}
    numbers = last_of(changed(tank(deep=10, jitter=0.0), bodies=[box], duration=4.0)).numbers
    assert numbers["body0_y"] == pytest.approx(0.2, abs=0.02)


@pytest.mark.compiled
def test_a_liquid_that_slips_cannot_turn_a_disc():
    disc = {"center": [0.5, 0.8], "radius": 0.2, "density": 0.8, "velocity": [0.3, -0.5]}
    numbers = last_of(changed(tank(), bodies=[disc], duration=0.4)).numbers
    assert abs(numbers["body0_y"] - 0.8) > 0.05
    assert abs(numbers["body0_torque_z"]) < 0.05 * 0.2 * np.hypot(numbers["body0_force_x"], numbers["body0_force_y"])
    # Dummies on rings are not quite a smooth surface: what little it turns is slow beside what it falls.
    assert 0.2 * abs(numbers["body0_spin_z"]) < 0.05 * np.hypot(0.3, 0.5)


def bodies_of(*specs, dimension=2):
    scene = changed(free_blob(dimension), bodies=list(specs))
    parameters = SPH.parameters(scene)
    return parameters, parameters.bodies, parameters.bodies.pose.copy(), parameters.bodies.motion.copy()


def test_a_collision_keeps_momentum_spin_included_and_takes_its_share_of_the_approach():
    specs = (
        {"center": [-1.0, 0.0], "radius": 0.3, "mass": 2.0, "velocity": [1.0, 0.0], "restitution": 0.5},
        {"low": [-0.68, -0.1], "high": [-0.06, 0.5], "mass": 1.0, "restitution": 0.8, "spin": 0.5},
    )
    parameters, bodies, pose, motion = bodies_of(*specs)
    pose[0, 1] -= 0.04

    def momenta():
        linear = motion[:3] @ bodies.mass
        around = np.cross(pose[:3].T, (bodies.mass * motion[:3]).T).sum(axis=0)
        return linear, around[2] + bodies.inertia[2] @ motion[5]

    before, energy = momenta(), bodies.mass @ (motion[:3] ** 2).sum(axis=0) + bodies.inertia[2] @ motion[5] ** 2
    place = pose.copy()
    assert collide(bodies, parameters.boundary.guard.sheet, (pose, motion), 0.0)[0] > 0
    moved, pose[...] = pose.copy(), place
    after = momenta()
    np.testing.assert_allclose(after[0], before[0], atol=1e-12)
    assert after[1] == pytest.approx(before[1], abs=0.02)
    assert bodies.mass @ (motion[:3] ** 2).sum(axis=0) + bodies.inertia[2] @ motion[5] ** 2 < energy
    assert motion[0, 0] < motion[0, 1]
    np.testing.assert_allclose(moved[:3] @ bodies.mass, place[:3] @ bodies.mass, atol=1e-12)


def test_a_body_that_nothing_touches_keeps_its_angular_momentum_and_energy():
    spec = {"low": [-0.3, -0.2, -0.1], "high": [0.3, 0.2, 0.1], "mass": 1.0, "spin": [0.1, 2.0, 0.1]}
    _, bodies, pose, motion = bodies_of(spec, dimension=3)
    none = np.zeros((1, 3))

    def momentum():
        turn = rotations(pose)[0]
        return turn @ (bodies.inertia[:, 0] * (turn.T @ motion[3:, 0]))

    before = momentum()
    for _ in range(2000):
        push = accelerations_of(bodies, pose, motion, (none, none), np.zeros(3))
        middle = motion + 0.0025 * push
        move_bodies(pose, middle, 0.0025)
        motion += 0.005 * accelerations_of(bodies, pose, middle, (none, none), np.zeros(3))
        move_bodies(pose, motion, 0.0025)
    # About its middle axis it tumbles: the spin turns over, the momentum stays.
    np.testing.assert_allclose(momentum(), before, atol=0.02 * np.linalg.norm(before))


def test_a_body_comes_to_rest_on_the_floor_without_sinking_into_it():
    spec = {"low": [-0.3, 0.2], "high": [0.3, 0.5], "mass": 1.0, "spin": 0.7}
    plain = to_plain(free_blob())
    plain["tank"]["bottom"] = {"kind": "wall"}
    plain["tank"]["low"] = [-3.0, -1.0]
    parameters = SPH.parameters(from_plain({**plain, "bodies": [spec]}))
    bodies, pose, motion = parameters.bodies, parameters.bodies.pose.copy(), parameters.bodies.motion.copy()
    for _ in range(2000):
        motion[1] -= 0.005
        move_bodies(pose, motion, 0.005)
        collide(bodies, parameters.boundary.guard.sheet, (pose, motion), 0.05)
    assert pose[1, 0] == pytest.approx(-0.85, abs=1e-3)
    assert np.abs(motion).max() < 0.02


@pytest.mark.parametrize(
    ("tables", "path"),
    [
        ({"bodies": [{"center": [0.5, 0.5], "radius": 0.2}]}, "bodies[0]"),
        ({"bodies": [{"center": [0.5, 0.0], "radius": 0.2, "density": 1.0}]}, "bodies[0]"),
        (
            {
                "obstacles": [{"low": [0.2, 0.2], "high": [0.4, 0.4]}],
                "bodies": [{"center": [0.45, 0.3], "radius": 0.1, "density": 1.0}],
            },
            "bodies[0]: starts 50 mm inside obstacles[0]",
        ),
        (
            {"bodies": [{"center": [0.5, 0.5], "radius": radius, "density": 1.0} for radius in (0.1, 0.3)]},
            "bodies[1]: starts 200 mm inside bodies[0]",
        ),
        ({"obstacles": [{"vertices": [[0, 0], [1, 1], [1, 0], [0, 1]]}]}, "obstacles[0].vertices"),
        ({"obstacles": [{"center": [0.5, 0.5, 0.5], "radius": 0.2}]}, "obstacles[0].center"),
        ({"bodies": [{"center": [0.5, 0.5], "radius": 0.2, "mass": 1.0, "spin": [0, 0, 1]}]}, "bodies[0].spin"),
    ],
)
def test_a_solid_that_cannot_be_says_which_and_why(tables, path):
    with pytest.raises(SceneError) as caught:
        SPH.parameters(changed(tank(), **tables))
    assert path in str(caught.value)


@pytest.mark.compiled
def test_what_pulls_towards_a_point_pulls_at_bodies_too():
    plain = to_plain(free_blob())
    plain["fluid"][0].pop("velocity_gradient")
    disc = {"center": [2.0, 0.5], "radius": 0.2, "density": 500.0, "spin": 0.3}
    scene = from_plain(
        {**plain, "bodies": [disc], "central_force": {"angular_frequency": 1.0, "center": [0.0, 0.5]}, "duration": 0.8}
    )
    last = last_of(scene)
    assert last.numbers["body0_x"] == pytest.approx(2.0 * np.cos(last.time), rel=1e-4)
    assert last.numbers["body0_y"] == pytest.approx(0.5, abs=1e-9)
    assert last.numbers["body0_spin_z"] == pytest.approx(0.3, rel=1e-9)


@pytest.mark.parametrize(
    ("solid", "thick"),
    [
        ({"low": [0.2, 0.2], "high": [0.8, 0.3]}, "0.8"),
        ({"center": [0.5, 0.4], "radius": 0.1}, "1.6"),
        ({"vertices": [[0.2, 0.2], [0.8, 0.2], [0.8, 0.4]]}, "1.52"),
        ({"low": [0.2, 0.2], "high": [0.8, 0.7]}, None),
    ],
)
def test_check_reports_a_solid_thinner_than_the_support(solid, thick):
    for table, more in (("obstacles", {}), ("bodies", {"density": 1.0})):
        rows = {row[0]: row for row in SPH.summary(changed(tank(), **{table: [{**solid, **more}]}))}
        found = [row for name, row in rows.items() if name in ("obstacle0", "body0")]
        assert [row[1] for row in found] == ([f"{thick} spacings thick"] if thick else [])
        assert all("thinner than the support, 4" in row[2] for row in found)
