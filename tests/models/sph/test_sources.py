"""Liquid from tables, drawings and other runs is the liquid that they describe."""

import io

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import ecume
from ecume.engine.outlines import OBLIQUE, Cloud, Mesh, sorted_in
from ecume.errors import SceneError
from ecume.models.sph.record import SPH, start
from ecume.run import run
from ecume.scenes.sph.solids import crossing_edges

SCENE = """
model = "sph"
duration = 0.02
frame_every = 0.01
spacing = 0.1
[tank]
low = {low}
high = {high}
top = {{ kind = "open" }}
[[fluid]]
{fluid}
"""
FLAT = {"low": [0.0, 0.0], "high": [2.0, 2.0]}
SPACE = {"low": [0.0, 0.0, 0.0], "high": [2.0, 2.0, 2.0]}


def written(folder, fluid, tank=FLAT):
    """A scene file beside its sources."""
    file = folder / "mine.toml"
    file.write_text(SCENE.format(fluid=fluid, **tank))
    return file


def liquid(file):
    """The state at the start."""
    scene = ecume.load_scene(file)
    parameters = SPH.parameters(scene)
    return start(scene, parameters), scene


def cube(size=1.0, corner=0.25):
    """The twelve triangles of a cube, outwards."""
    faces = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2),
             (2, 4, 6), (1, 3, 5), (3, 7, 5)]  # fmt: skip
    corners = corner + size * np.array([(k & 1, k >> 1 & 1, k >> 2) for k in range(8)], dtype=float)
    return corners[np.array(faces)]


def stl(triangles):
    """Their text."""
    facets = [
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {x!r} {y!r} {z!r}\n" for x, y, z in each)
        + "endloop\nendfacet\n"
        for each in triangles.tolist()
    ]
    return "solid cube\n" + "".join(facets) + "endsolid cube\n"


def test_a_table_places_particles_with_their_velocities_in_its_units(tmp_path):
    (tmp_path / "drop.csv").write_text("x [cm],y [cm],vx [cm/s]\n50,50,1\n60,50,2\n60,60,3\n")
    state, _ = liquid(written(tmp_path, 'particles_from = "drop.csv"\nvelocity = [0.0, 1.0]'))
    assert state.position.T.tolist() == [[0.5, 0.5], [0.6, 0.5], [0.6, 0.6]]
    assert pytest.approx(np.array([[0.01, 1.0], [0.02, 1.0], [0.03, 1.0]])) == state.velocity.T
    assert state.density[1] > state.density[0] > 1000.0  # deeper by one particle, and under pressure at all


def test_a_table_that_gives_densities_is_believed(tmp_path):
    (tmp_path / "drop.csv").write_text("x,y,density,mass\n0.5,0.5,1001,9\n0.6,0.5,1002,8\n")
    state, _ = liquid(written(tmp_path, 'particles_from = "drop.csv"'))
    assert (state.density.tolist(), state.mass.tolist()) == ([1001.0, 1002.0], [9.0, 8.0])


@pytest.mark.parametrize(
    ("table", "says"),
    [
        ("x,y,radius\n1,1,1\n", r"fluid\[0\].particles_from: drop.csv, line 1, column 'radius': no such column"),
        ("x,y\n1,one\n", "line 2, column y: got 'one'"),
        ("x,y,z\n1,1,1\n", "got 3 numbers; the tank has 2 dimensions"),
        (None, "'drop.csv' does not exist"),
    ],
)
def test_a_table_of_no_use_is_refused_at_its_line(tmp_path, table, says):
    if table is not None:
        (tmp_path / "drop.csv").write_text(table)
    with pytest.raises(SceneError, match=says) as refused:
        ecume.load_scene(written(tmp_path, 'particles_from = "drop.csv"'))
    assert len(refused.value.faults) == 1


@pytest.mark.long
def test_a_run_goes_on_from_the_frame_of_another_with_every_number_of_its_particles(tmp_path):
    first = ecume.load_scene(written(tmp_path, "low = [0.0, 0.0]\nhigh = [0.5, 1.0]"))
    run(first, tmp_path / "one")
    with ecume.open_trajectory(tmp_path / "one") as trajectory:
        last = trajectory[-1]
    text = SCENE.format(fluid="", **FLAT).replace("[[fluid]]", "").replace("[tank]", 'start_from = "one@-1"\n[tank]')
    (tmp_path / "two.toml").write_text(text)
    state, _scene = liquid(tmp_path / "two.toml")
    assert np.array_equal(state.position.T, last.arrays["position"])
    assert np.array_equal(state.velocity.T, last.arrays["velocity"])
    assert np.array_equal(state.density, last.arrays["density"])
    assert np.array_equal(state.mass, last.arrays["mass"])
    assert np.abs(last.arrays["velocity"]).max() > 0.01
    (tmp_path / "two.toml").write_text(text.replace("spacing = 0.1", 'spacing = "10 cm"'))
    assert ecume.load_scene(tmp_path / "two.toml").spacing == 0.1
    (tmp_path / "two.toml").write_text(text.replace("spacing = 0.1", "spacing = 0.2"))
    with pytest.raises(SceneError, match=r"start_from: 'one@-1' has a spacing of 0.1 m"):
        ecume.load_scene(tmp_path / "two.toml")
    (tmp_path / "two.toml").write_text(text + "[[fluid]]\nlow = [0.0, 0.0]\nhigh = [1.0, 1.0]\n")
    with pytest.raises(SceneError, match="leave \\[\\[fluid\\]\\] out"):
        ecume.load_scene(tmp_path / "two.toml")


SINGLE = "fluid=[{{particles={{positions=[{}]}}}}, {{particles={{positions=[[0.32, 0.31]]}}}}]"


def test_single_particles_stay_where_they_are_however_near_and_above_an_open_top(tmp_path):
    text, solid = written(tmp_path, ""), "obstacles=[{low=[0.52, 0.0], high=[0.9, 0.5]}]"
    scene = ecume.load_scene(text, [SINGLE.format("[0.3, 0.3], [0.51, 0.3], [0.3, 2.2]"), solid])
    state = start(scene, SPH.parameters(scene))
    assert state.position.T.tolist() == [[0.3, 0.3], [0.51, 0.3], [0.3, 2.2], [0.32, 0.31]]
    assert state.region.tolist() == [0, 0, 0, 1]


@pytest.mark.parametrize(("place", "change"), [("[0.3, 2.2]", "tank.top.kind='wall'"), ("[-0.05, 0.3]", "seed=1")])
def test_single_particles_behind_a_wall_are_refused(tmp_path, place, change):
    scene = ecume.load_scene(written(tmp_path, ""), [SINGLE.format(place), change])
    with pytest.raises(SceneError, match="reaches out of the tank"):
        start(scene, SPH.parameters(scene))


def test_a_surface_of_triangles_is_filled_and_knows_the_depth():
    mesh, points = Mesh(cube()), np.array([[0.3, 0.35, 0.8], [0.75, 0.75, 0.75], [0.2, 0.7, 0.7], [1.3, 0.5, 0.5]])
    assert mesh.inside(points).tolist() == [True, True, False, False]
    assert mesh.way_out(points[:2], np.array([0.0, 1.0, 0.0])) == pytest.approx([0.9, 0.5])
    assert [corner.tolist() for corner in mesh.bounds()] == [[0.25] * 3, [1.25] * 3]


def ball(radius, middle, lines=24):
    """The triangles of a sphere by latitude and longitude."""
    theta, phi = np.linspace(0.0, np.pi, lines + 1), np.linspace(0.0, 2.0 * np.pi, 2 * lines + 1)
    x, y = np.outer(np.sin(theta), np.cos(phi)), np.outer(np.sin(theta), np.sin(phi))
    nodes = np.stack([x, y, np.outer(np.cos(theta), np.ones_like(phi))], axis=-1) * radius + middle
    a, b, c, d = nodes[:-1, :-1], nodes[1:, :-1], nodes[1:, 1:], nodes[:-1, 1:]
    triangles = np.concatenate([np.stack([a, b, c], 2).reshape(-1, 3, 3), np.stack([a, c, d], 2).reshape(-1, 3, 3)])
    return triangles[
        np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1) > 0
    ]


def test_shells_that_overlap_are_united_and_one_inside_out_is_a_hole():
    apart, radius = 0.3, 0.3
    both = Mesh(np.concatenate([ball(radius, [-0.5 * apart, 0.0, 0.0]), ball(radius, [0.5 * apart, 0.0, 0.0])]))
    lens = np.pi * (4.0 * radius + apart) * (2.0 * radius - apart) ** 2 / 12.0
    united = 8.0 / 3.0 * np.pi * radius**3 - lens
    assert both.volume() == pytest.approx(united, rel=0.01)
    cells = both.cells(0.05)
    assert cells.volumes.sum() == pytest.approx(both.volume())
    assert cells.volumes.max() == pytest.approx(0.05**3, rel=0.03)
    assert both.inside(np.zeros((1, 3))).all()
    hollow = Mesh(np.concatenate([ball(0.5, 0.0), ball(0.25, 0.0)[:, ::-1]]))
    assert hollow.volume() == pytest.approx(4.0 / 3.0 * np.pi * (0.5**3 - 0.25**3), rel=0.01)
    assert hollow.inside(np.array([[0.0, 0.01, 0.02], [0.37, 0.01, 0.02]])).tolist() == [False, True]


def test_a_point_meets_only_the_triangles_near_its_ray():
    fine = Mesh(ball(0.5, 0.0, lines=60))
    points = np.random.default_rng(1).uniform(-0.5, 0.5, (4000, 3))
    assert (fine.inside(points) == (np.linalg.norm(points, axis=1) < 0.4995)).mean() > 0.99
    buckets = sorted_in(fine.triangles, OBLIQUE)
    assert np.diff(buckets.first).mean() < 20
    assert len(fine.triangles) > 10000


def test_a_cloud_is_as_deep_as_the_points_above():
    axes = np.meshgrid(0.05 + 0.1 * np.arange(4), 0.05 + 0.1 * np.arange(6), indexing="ij")
    points = np.stack([axis.ravel() for axis in axes], axis=1)
    cloud = Cloud(points, 0.1)
    assert cloud.way_out(points, np.array([0.0, 1.0])) == pytest.approx(0.6 - points[:, 1])
    assert cloud.inside(np.array([[0.2, 0.3], [0.46, 0.3]])).tolist() == [True, False]


def test_an_stl_file_is_filled_with_liquid_in_its_unit(tmp_path):
    pytest.importorskip("trimesh")
    (tmp_path / "cube.stl").write_text(stl(100.0 * cube()))
    state, _ = liquid(written(tmp_path, 'outline_from = "cube.stl"\noutline_unit = "cm"', SPACE))
    assert state.position.shape == (3, 1000)
    assert state.position.min() == pytest.approx(0.3)
    for times, says in ((500.0, "is 500 x 500 x 500 m large, larger than the tank"), (1e4, r"reaches to 1.25e\+04 m")):
        (tmp_path / "cube.stl").write_text(stl(times * cube()))
        with pytest.raises(SceneError, match=says) as refused:
            liquid(written(tmp_path, 'outline_from = "cube.stl"', SPACE))
        assert len(refused.value.faults) == 1
    (tmp_path / "cube.stl").write_text(stl(cube()[1:]))
    with pytest.raises(SceneError, match=r"fluid\[0\].outline_from: 'cube.stl' has holes"):
        liquid(written(tmp_path, 'outline_from = "cube.stl"', SPACE))
    (tmp_path / "cube.obj").write_text("")
    with pytest.raises(SceneError, match=r"expected a \.stl or \.dxf file"):
        liquid(written(tmp_path, 'outline_from = "cube.obj"', SPACE))


def binary_stl(triangles, count=None):
    """Their bytes."""
    rows = np.zeros(len(triangles), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    rows["corners"] = triangles
    return b"head".ljust(80) + (len(triangles) if count is None else count).to_bytes(4, "little") + rows.tobytes()


WHOLE = binary_stl(cube())


@pytest.mark.parametrize(("content", "says"), [
    (b"", "got 0 bytes"), (b"<html>404</html>", "got 16 bytes; expected a surface of triangles"),
    (WHOLE[: len(WHOLE) // 2], "announces 12 triangles, and its bytes are those of 5.16"),
    (binary_stl(cube(), 2**32 - 1), "announces 4294967295 triangles"), (binary_stl(cube(), 5), "announces 5 triangles"),
    (WHOLE + b"more", "announces 12 triangles"), (binary_stl(cube()[:0]), "has no triangles"),
    (stl(cube()).encode()[:700], "ends before endsolid; was it cut off"),
])  # fmt: skip
def test_a_damaged_stl_file_is_told_from_a_surface_with_holes(content, says, tmp_path):
    pytest.importorskip("trimesh")
    (tmp_path / "cube.stl").write_bytes(content)
    with pytest.raises(SceneError, match=rf"'cube.stl' cannot be read as STL: .*{says}"):
        ecume.load_scene(written(tmp_path, 'outline_from = "cube.stl"', SPACE))


@pytest.mark.parametrize("turned", [(0,), (3, 7, 8), range(11), range(12)])
def test_triangles_that_run_the_other_way_are_turned_without_further_packages(turned, tmp_path):
    pytest.importorskip("trimesh")
    triangles = cube()
    for one in turned:
        triangles[one] = triangles[one][::-1]
    (tmp_path / "cube.stl").write_bytes(binary_stl(triangles))
    scene = ecume.load_scene(written(tmp_path, 'outline_from = "cube.stl"\noutline_unit = "1 m"', SPACE))
    corners = np.array(scene.fluid[0].triangles)
    volume = np.linalg.det(corners).sum() / 6.0
    assert abs(volume) == pytest.approx(1.0, rel=1e-6)


def test_a_dxf_outline_is_a_polygon_in_the_drawing_s_unit(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    drawing = ezdxf.new()
    drawing.units = 4
    drawing.modelspace().add_lwpolyline([(0, 0), (1000, 0), (1000, 500), (0, 500)], close=True)
    drawing.saveas(tmp_path / "block.dxf")
    state, scene = liquid(written(tmp_path, 'outline_from = "block.dxf"'))
    assert sorted(scene.fluid[0].vertices) == [(0.0, 0.0), (0.0, 0.5), (1.0, 0.0), (1.0, 0.5)]
    assert state.position.shape == (2, 50)
    drawing.modelspace().add_circle((3000, 0), 10)
    drawing.saveas(tmp_path / "block.dxf")
    with pytest.raises(SceneError, match="has 2 closed outlines; expected one"):
        liquid(written(tmp_path, 'outline_from = "block.dxf"'))


TANK = """model = "sph"
duration = "0.1 s"
frame_every = "0.1 s"
spacing = "1 cm"
[tank]
outline_from = "tank.dxf"
[liquid]
maximum_speed = "1 m/s"
[[fluid]]
low = ["2 cm", "2 cm"]
high = ["8 cm", "5 cm"]
"""


def drawing_of(corners):
    ezdxf = pytest.importorskip("ezdxf")
    drawing, text = ezdxf.new(units=ezdxf.units.CM), io.StringIO()
    drawing.modelspace().add_lwpolyline(corners, close=True)
    drawing.write(text)
    return text.getvalue()


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        (lambda text: "solid part", "cannot be read as DXF: it does not begin as a drawing, with a section"),
        (lambda text: text[: len(text) // 2], "cannot be read as DXF: DXFStructureError: missing"),
        (lambda text: drawing_of([(0, 0), (20, 10), (20, 0), (0, 10)]), "enclose no area"),
        (lambda text: None, "does not exist"),
    ],
)
def test_a_fault_of_a_drawn_tank_is_one_line_at_its_key(tmp_path, changed, says):
    """It came with a second fault, of the missing tank.high, or as that of an obstacle that is not in the file."""
    (tmp_path / "scene.toml").write_text(TANK)
    text = drawing_of([(0, 0), (20, 0), (20, 10), (0, 10)])
    (tmp_path / "tank.dxf").write_text("\ufeff" + text.replace("\r\n", "\n"), newline="\r\n")
    assert ecume.load_scene(tmp_path / "scene.toml").tank.high == pytest.approx((0.24, 0.14))
    new = changed(text)
    (tmp_path / "tank.dxf").write_text(new) if new is not None else (tmp_path / "tank.dxf").unlink()
    with pytest.raises(SceneError) as caught:
        ecume.load_scene(tmp_path / "scene.toml")
    (fault,) = caught.value.faults
    assert (fault.path, fault.line) == ("tank.outline_from", 6)
    assert says in fault.message
    assert "outline.dxf" not in fault.message  # our copy of the file


def test_without_the_library_a_drawing_is_refused_with_the_way_out(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "trimesh", None)
    (tmp_path / "cube.stl").write_text(stl(cube()))
    with pytest.raises(SceneError, match=r"needs trimesh, which is not installed: pip install 'ezdxf.* 'trimesh"):
        ecume.load_scene(written(tmp_path, 'outline_from = "cube.stl"', SPACE))


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_bodies_that_touch_or_stand_twice_in_a_surface_are_one(tmp_path, axis):
    touching = [cube(0.5), cube(0.5) + 0.5 * np.eye(3)[axis], cube(0.5)]
    (tmp_path / "two.stl").write_text(stl(np.concatenate(touching)))
    state, _ = liquid(written(tmp_path, 'outline_from = "two.stl"', SPACE))
    assert state.mass.sum() == pytest.approx(250.0, rel=0.005)
    assert len(state.mass) == 250


def drawn(folder, add, unit=4):
    """The outline in a drawing of these entities, and its area (m^2)."""
    ezdxf = pytest.importorskip("ezdxf")
    drawing = ezdxf.new()
    drawing.units = unit
    add(drawing)
    drawing.saveas(folder / "outline.dxf")
    _, scene = liquid(written(folder, 'outline_from = "outline.dxf"'))
    corners = np.array(scene.fluid[0].vertices)
    (x, y), (u, v) = corners.T, np.roll(corners, -1, axis=0).T
    return corners, 0.5 * abs(float((x * v - y * u).sum()))


@pytest.mark.parametrize("seed", range(4))
def test_lines_and_arcs_that_meet_are_an_outline_in_any_order_and_direction(tmp_path, seed):
    """A stadium with round ends as most programs for drawing write it, beside a center line."""
    rng = np.random.default_rng(seed)
    parts = [
        lambda space, turn: space.add_line(*[(500, 500), (1000, 500)][:: 1 - 2 * turn]),
        lambda space, turn: space.add_arc((1000, 750), 250, -90, 90),
        lambda space, turn: space.add_line(*[(1000, 1000), (500, 1000 + 1e-5)][:: 1 - 2 * turn]),
        lambda space, turn: space.add_arc((500, 750), 250, 90, 270),
        lambda space, turn: space.add_line((200, 750), (1300, 750)),
    ]

    def add(drawing):
        block = drawing.blocks.new("STADIUM")
        for k in rng.permutation(len(parts)):
            parts[k](block if seed % 2 else drawing.modelspace(), int(rng.integers(2)))
        if seed % 2:
            drawing.modelspace().add_blockref("STADIUM", (0, 0))

    corners, area = drawn(tmp_path, add)
    assert area == pytest.approx(0.25 + np.pi * 0.25**2, rel=3e-3)
    np.testing.assert_allclose([corners.min(axis=0), corners.max(axis=0)], [[0.25, 0.5], [1.25, 1.0]], atol=1e-3)


def test_lines_that_do_not_meet_or_branch_are_no_outline(tmp_path):
    corners = [(0, 0), (500, 0), (500, 500), (0, 500)]
    sides = list(zip(corners, [*corners[1:], (0, 5)], strict=True))
    for more in ([], [((0, 5), (0, 0)), ((0, 0), (250, 250)), ((250, 250), (500, 0))]):
        with pytest.raises(SceneError, match=r"has 0 closed outlines; .* where their ends meet"):
            drawn(tmp_path, lambda drawing, more=more: [drawing.modelspace().add_line(*each) for each in sides + more])


@pytest.mark.parametrize("corners", [[[0, 0], [2, 1], [2, 0], [0, 0.6]], [[0, 0], [1, 1], [1, 0], [0.5, 1.5], [0, 1]]])
def test_a_polygon_whose_edges_cross_is_refused(tmp_path, corners):
    with pytest.raises(SceneError, match=r"fluid\[0\].vertices: cross: edges"):
        ecume.load_scene(written(tmp_path, f"vertices = {corners}"))


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), min_size=3, max_size=9, unique=True))
def test_edges_cross_where_each_has_the_ends_of_the_other_on_both_sides(corners):
    ends = list(zip(corners, [*corners[1:], corners[0]], strict=True))

    def side(a, b, c):
        return np.sign((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))

    def cross(one, other):
        return side(*one, other[0]) * side(*one, other[1]) < 0 and side(*other, one[0]) * side(*other, one[1]) < 0

    expected = [(k, m) for k in range(len(ends)) for m in range(k + 1, len(ends)) if cross(ends[k], ends[m])]
    found = crossing_edges(corners)
    assert found in expected if expected else found is None


@pytest.mark.parametrize(("unit", "factor"), [("kg/m", 1.0), ("g/cm", 0.1), ("mg/mm", 1e-3)])
def test_masses_of_a_table_in_2d_are_per_depth(tmp_path, unit, factor):
    (tmp_path / "drop.csv").write_text(f"x,y,mass [{unit}]\n0.5,0.5,9\n0.6,0.5,8\n")
    state, _ = liquid(written(tmp_path, 'particles_from = "drop.csv"'))
    assert state.mass == pytest.approx(factor * np.array([9.0, 8.0]))


def test_a_mass_in_the_unit_of_the_other_dimension_is_refused(tmp_path):
    (tmp_path / "drop.csv").write_text("x,y,mass [kg]\n0.5,0.5,9\n")
    with pytest.raises(SceneError, match=r"'kg' measures mass, expected mass / length"):
        ecume.load_scene(written(tmp_path, 'particles_from = "drop.csv"'))
    (tmp_path / "drop.csv").write_text("x,y,z,mass [kg/m]\n0.5,0.5,0.5,9\n")
    with pytest.raises(SceneError, match="'kg/m' measures mass / length, expected mass"):
        ecume.load_scene(written(tmp_path, 'particles_from = "drop.csv"', SPACE))


@pytest.mark.parametrize(
    ("table", "key", "says"),
    [
        ("bodies", "angle", "vertices"),
        ("obstacles", "tilt", "vertices"),
        ("obstacles", "spin", r"bodies\.motion"),
        ("tank", "pivot", r"bodies\.motion"),
        ("base_excitation", "angle_amplitude", "roll"),
        ("bodies", "angles", r"bodies\.motion"),
    ],
)
def test_a_key_of_motions_in_another_table_is_answered_with_its_place(tmp_path, table, key, says):
    scene = written(tmp_path, "low = [0.0, 0.0]\nhigh = [0.5, 1.0]")
    text = scene.read_text()
    block = {"base_excitation": "[base_excitation]", "tank": "[tank]"}.get(table, f"[[{table}]]")
    text = text.replace(block, f"{block}\n{key} = 1") if block in text else f"{text}{block}\n{key} = 1\n"
    scene.write_text(text)
    with pytest.raises(SceneError, match=rf"{key}: no such key; did you mean {says}"):
        ecume.load_scene(scene)
