"""Obstacles, bodies and tanks of any shape: from STL and DXF files, polygons that are not convex, cylinders, ramps."""

import numpy as np
import pytest

import ecume
from ecume.errors import SceneError
from ecume.models.sph.boundaries.rigid_bodies import rotations
from ecume.models.sph.record import SPH
from ecume.scenes.schema import from_plain
from tests.engine.test_meshes import corner_mesh
from tests.models.sph.test_solids import integrated
from tests.models.sph.test_sources import ball, stl

DEEP = {
    "model": "sph", "duration": 0.01, "frame_every": 0.01, "spacing": 0.2, "liquid": {"maximum_speed": 3.0},
    "tank": {"low": [-1.0, -1.0, -1.0], "high": [1.0, 1.0, 1.0]},
    "fluid": [{"low": [-1.0, -1.0, -1.0], "high": [1.0, 0.6, 1.0]}],
}  # fmt: skip
WIDE = {
    "model": "sph", "duration": 0.3, "frame_every": 0.1, "spacing": 0.05, "liquid": {"maximum_speed": 3.0},
    "tank": {"low": [0.0, 0.0], "high": [1.0, 1.0], "top": {"kind": "open"}},
    "fluid": [{"low": [0.0, 0.0], "high": [1.0, 0.6]}],
}  # fmt: skip
ROUNDED = np.round(1000.0 * ball(0.5, np.zeros(3), lines=12), 6) + 0.0
BALL = stl(ROUNDED[np.array([len(np.unique(each, axis=0)) == 3 for each in ROUNDED])])
CORNER = [[0.3, 0.1], [0.7, 0.1], [0.7, 0.2], [0.45, 0.2], [0.45, 0.5], [0.3, 0.5]]


def started(scene):
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    return parameters, state


def drawn(folder, file, table, tank='low = ["-1 m", "-1 m", "-1 m"]\nhigh = ["1 m", "1 m", "1 m"]'):
    (folder / "scene.toml").write_text(
        f'model = "sph"\nduration = 0.01\nframe_every = 0.01\nspacing = "20 cm"\n[tank]\n{tank}\n'
        "[liquid]\nmaximum_speed = 3.0\n[[fluid]]\nlow = [-1, -1, -1]\nhigh = [1, 0.6, 1]\n"
        f'[[{table}]]\noutline_from = "{file}"\noutline_unit = "mm"\n' + ("density = 500.0\n" * (table == "bodies"))
    )
    return folder / "scene.toml"


def mine_of(table, parameters):
    return (parameters.bodies.obstacles if table == "obstacles" else parameters.bodies.shapes)[0]


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("table", ["obstacles", "bodies"])
def test_a_ball_of_an_stl_file_is_a_ball(tmp_path, table):
    pytest.importorskip("trimesh")
    (tmp_path / "ball.stl").write_text(BALL)
    round_one = {"center": [0.0, 0.0, 0.0], "radius": 0.5, **({"density": 500.0} if table == "bodies" else {})}
    starts = [
        started(ecume.load_scene(drawn(tmp_path, "ball.stl", table))),
        started(from_plain({**DEEP, table: [round_one]})),
    ]
    (mine, state), (its, other) = starts
    ratio = mine_of(table, mine).volume() / mine_of(table, its).volume()
    assert 0.96 < ratio < 1.0
    displaced = 1000.0 * mine_of(table, its).volume() * (1.0 - ratio)
    assert state.mass.sum() - other.mass.sum() == pytest.approx(displaced, rel=0.1)
    assert np.linalg.norm(state.position, axis=0).min() > 0.48
    volumes = [parameters.boundary.dummies.volume.sum() for parameters in (mine, its)]
    assert volumes[0] / volumes[1] == pytest.approx(ratio, rel=0.02)
    if table == "bodies":
        assert mine.bodies.mass[0] / its.bodies.mass[0] == pytest.approx(ratio)
        np.testing.assert_allclose(mine.bodies.inertia, ratio * its.bodies.inertia, rtol=0.05)
    else:
        assert mine.bodies.drawn == (0,)
        assert not its.bodies.drawn


@pytest.mark.long
@pytest.mark.compiled
def test_the_liquid_lifts_a_drawn_ball_by_what_it_displaces(tmp_path):
    pytest.importorskip("trimesh")
    (tmp_path / "ball.stl").write_text(BALL)
    frames = [
        list(ecume.simulate(ecume.load_scene(drawn(tmp_path, "ball.stl", "obstacles"))))[-1],
        list(ecume.simulate(from_plain({**DEEP, "obstacles": [{"center": [0.0, 0.0, 0.0], "radius": 0.5}]})))[-1],
    ]
    lifts = [frame.numbers["obstacle0_force_y"] for frame in frames]
    weight = 4.0 / 3.0 * np.pi * 0.5**3 * 1000.0 * 9.81
    assert lifts[0] == pytest.approx(lifts[1], abs=0.1 * weight)
    assert frames[0].numbers["obstacle0_hits"] == 0


@pytest.mark.long
@pytest.mark.compiled
def test_liquid_stays_out_of_a_corner_and_rests_on_it():
    scene = from_plain({**WIDE, "obstacles": [{"vertices": CORNER}], "duration": 0.6})
    last = list(ecume.simulate(scene))[-1]
    shape = SPH.parameters(scene).bodies.obstacles[0]
    assert not shape.inside(last.arrays["position"]).any()
    area = 0.4 * 0.1 + 0.15 * 0.3
    assert last.numbers["obstacle0_force_y"] == pytest.approx(area * 1000.0 * 9.81, rel=0.35)
    assert np.linalg.norm(last.arrays["velocity"], axis=1).max() < 0.3


@pytest.mark.compiled
def test_a_drop_thrown_at_a_corner_does_not_get_into_it():
    scene = from_plain(
        {
            **WIDE, "duration": 0.2, "gravity": 0.0, "obstacles": [{"vertices": CORNER}],
            "fluid": [{"center": [0.6, 0.5], "radius": 0.12, "velocity": [0.0, -3.0]}],
        }
    )  # fmt: skip
    shape = SPH.parameters(scene).bodies.obstacles[0]
    for frame in ecume.simulate(scene):
        assert shape.nearest(frame.arrays["position"])[0].min() > -1e-9


@pytest.mark.long
@pytest.mark.compiled
def test_a_basin_of_any_shape_holds_its_liquid():
    basin = [[0.1, 0.9], [0.3, 0.2], [0.7, 0.2], [0.9, 0.9]]
    scene = from_plain(
        {
            **WIDE, "duration": 0.5, "obstacles": [{"vertices": basin, "hollow": True}],
            "fluid": [{"vertices": [[0.214285714, 0.5], [0.3, 0.2], [0.7, 0.2], [0.785714286, 0.5]]}],
        }
    )  # fmt: skip
    frames = list(ecume.simulate(scene))
    hole = SPH.parameters(scene).bodies.obstacles[0].hole
    assert all(hole.inside(frame.arrays["position"]).all() for frame in frames)
    area = 0.5 * (0.4 + 0.571428572) * 0.3
    assert frames[0].numbers["volume"] == pytest.approx(area, rel=0.01)
    down = np.mean([frame.numbers["obstacle0_force_y"] for frame in frames[2:]])
    assert down == pytest.approx(-area * 1000.0 * 9.81, rel=0.15)


@pytest.mark.long
@pytest.mark.compiled
def test_the_drawing_of_a_tank_becomes_a_hole_in_a_block(tmp_path):
    pytest.importorskip("trimesh")
    (tmp_path / "room.stl").write_text(BALL)
    path = drawn(
        tmp_path, "room.stl", "bodies", 'outline_from = "room.stl"\noutline_unit = "mm"\ntop = {kind = "open"}'
    )
    text = path.read_text().partition("[[fluid]]")[0] + "[[fluid]]\ncenter = [0, 0, 0]\nradius = 0.4\n"
    path.write_text(text)
    scene = ecume.load_scene(path)
    assert scene.obstacles[-1].hollow
    assert scene.tank.high[1] == pytest.approx(0.5)
    assert scene.tank.low[1] == pytest.approx(-0.5 - 4.0 * 0.2)
    _, state = started(scene)
    assert np.linalg.norm(state.position, axis=0).max() < 0.5


@pytest.mark.compiled
def test_a_drawn_body_turns_about_its_principal_axes_and_frames_say_how_far_since_the_start():
    corner = 0.1 * corner_mesh().triangles
    scene = from_plain(
        {
            **DEEP, "gravity": 0.0, "fluid": [{"low": [-1.0, -1.0, -1.0], "high": [1.0, -0.6, 1.0]}],
            "bodies": [{"triangles": corner.tolist(), "density": 500.0, "spin": [3.0, 1.0, 2.0]}],
        }
    )  # fmt: skip
    parameters, state = started(scene)
    numbers = SPH.observe(parameters, state, SPH.workspace(parameters, state, 1.0)).numbers
    assert [numbers[f"body0_q{part}"] for part in "wxyz"] == pytest.approx([1.0, 0.0, 0.0, 0.0], abs=1e-12)

    def angular(one):
        turn, spin = rotations(one.pose)[0], one.motion[3:, 0]
        return turn @ (parameters.bodies.inertia[:, 0] * (turn.T @ spin))

    points = rotations(state.pose)[0] @ parameters.boundary.dummies.position[:, parameters.bodies.first :]
    around = points.T + state.pose[:3, 0]
    assert (
        parameters.bodies.shapes[0].turned(rotations(state.pose)[0].T).carried(state.pose[:3, 0]).inside(around).all()
    )
    before = angular(state)
    parameters, later = integrated(scene, 40)
    np.testing.assert_allclose(angular(later), before, rtol=1e-3)
    assert abs(later.pose[3:, 0] - state.pose[3:, 0]).max() > 0.05


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize(
    ("solid", "volume"),
    [
        ({"center": [0.0, 0.0, 0.0], "radius": 0.4, "axis": [0.0, 0.0, 0.8]}, np.pi * 0.16 * 0.8),
        ({"vertices": [[x, y, z] for z in (-0.5, 0.5) for x, y in ((-0.5, -1.0), (0.5, -1.0), (0.5, -0.5))]}, 0.25),
    ],
)
def test_cylinders_and_ramps_displace_their_volume(solid, volume):
    whole = started(from_plain(DEEP))[1].mass.sum()
    parameters, state = started(from_plain({**DEEP, "obstacles": [solid]}))
    assert (whole - state.mass.sum()) / 1000.0 == pytest.approx(volume, rel=0.02)
    assert not parameters.bodies.obstacles[0].inside(state.position.T).any()


@pytest.mark.long
@pytest.mark.parametrize("table", ["obstacles", "bodies"])
def test_shells_that_overlap_are_refused_in_solids(table):
    both = np.concatenate([ball(0.3, [-0.15, 0.0, 0.0]), ball(0.3, [0.15, 0.0, 0.0])])
    solid = {"triangles": both.tolist(), **({"density": 500.0} if table == "bodies" else {})}
    with pytest.raises(SceneError, match="shells that overlap"):
        SPH.parameters(from_plain({**DEEP, table: [solid]}))


@pytest.mark.parametrize(
    ("solid", "says"),
    [
        ({"center": [0.5, 0.5], "radius": 0.1, "axis": [0.1, 0.0]}, "cylinder"),
        ({"low": [0.1, 0.1], "high": [0.2, 0.2], "axis": [0.1, 0.0]}, "center and radius"),
        ({"vertices": [[0.1, 0.1, 0.1], [0.2, 0.1, 0.1], [0.1, 0.2, 0.1], [0.1, 0.1, 0.2]]}, "2 dimensions"),
        ({"triangles": [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]}, "2 dimensions"),
        ({"vertices": [[0.1, 0.1, 0.1], [0.2, 0.1, 0.1]]}, "at least 4"),
    ],
)
def test_solids_of_no_use_are_refused(solid, says):
    with pytest.raises(SceneError, match=says):
        from_plain({**WIDE, "obstacles": [solid]})
