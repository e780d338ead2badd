"""Floats from a table."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ecume.errors import SceneError
from ecume.scenes.floating import FloatingScene
from ecume.scenes.load import load_scene
from ecume.scenes.tables import TableFaults, lines_of

SCENE = """\
model = "floating"
duration = 1
frame_every = 0.1
particles_from = "bowl.csv"
"""
DEFAULTS = """\
[[particles]]
radius = "2 mm"
density = 600
contact_angle = "60 deg"
velocity = [0.5, 0]
color = "red"
"""


def read(folder: Path, table: str, more: str = "") -> FloatingScene:
    (folder / "bowl.csv").write_text(table)
    (folder / "scene.toml").write_text(SCENE + more)
    return load_scene(folder / "scene.toml")


def faults_of(folder: Path, table: str, more: str = "") -> list[str]:
    with pytest.raises(SceneError) as caught:
        read(folder, table, more)
    return [str(fault) for fault in caught.value.faults]


def test_columns_are_read_in_the_units_of_their_heads(tmp_path: Path) -> None:
    table = "name,x [mm],y,vx [cm/s],vy,radius [um],density [g/cm^3],contact_angle [deg]\nbig, 1 ,0.002,3,4,5,0.6,90\n"
    (row,) = read(tmp_path, table).rows
    assert (row.species_name, row.x, row.y, row.vx, row.vy) == ("big", 0.001, 0.002, 0.03, 4.0)
    assert (row.radius, row.density) == pytest.approx((5e-6, 600.0), rel=1e-15)
    assert row.contact_angle == pytest.approx(1.5707963267948966, rel=1e-15)


def test_diameters_decimal_commas_and_round_brackets_are_read(tmp_path: Path) -> None:
    table = "x (mm);y (mm);diameter (um)\n1,5;-,25;400\n3;5e-1;8,0e2\n"
    rows = read(tmp_path, table, DEFAULTS).rows
    assert [row.x for row in rows] == pytest.approx([1.5e-3, 3e-3], rel=1e-15)
    assert [row.y for row in rows] == pytest.approx([-0.25e-3, 0.5e-3], rel=1e-15)
    assert [row.radius for row in rows] == pytest.approx([2e-4, 4e-4], rel=1e-15)


def test_a_radius_and_a_diameter_are_not_both_taken(tmp_path: Path) -> None:
    faults = faults_of(tmp_path, "x,y,radius,diameter\n0,0,1,3\n", DEFAULTS)
    assert any("radius appears twice" in fault for fault in faults)


@pytest.mark.parametrize("cell", ["1,234,567", "1.234,5", "1,"])
def test_a_number_with_other_commas_is_refused(tmp_path: Path, cell: str) -> None:
    assert any(cell in fault for fault in faults_of(tmp_path, f"x;y;radius\n{cell};0;1\n", DEFAULTS))


def test_a_quoted_comma_between_columns_with_commas_is_refused(tmp_path: Path) -> None:
    """There it separates thousands."""
    (fault,) = faults_of(tmp_path, 'x,y,radius\n"1,234",0,1\n', DEFAULTS)
    assert fault.endswith("line 2, column x: got '1,234'; expected a number")


def test_the_one_entry_of_floats_fills_what_the_table_leaves_out(tmp_path: Path) -> None:
    scene = read(tmp_path, "x [mm],y [mm],radius [mm]\n0,0,1\n5,0,3\n", DEFAULTS)
    assert scene.particles == ()
    assert [row.radius for row in scene.rows] == [0.001, 0.003]
    assert {(row.density, row.vx, row.species_name, row.color) for row in scene.rows} == {
        (600.0, 0.5, "float-1", "#d62728")
    }


def test_a_scene_with_rows_stands_alone(tmp_path: Path) -> None:
    from ecume.scenes.writing import to_toml

    scene = read(tmp_path, "x,y\n0,0\n5,0\n", DEFAULTS)
    (tmp_path / "bowl.csv").unlink()
    assert load_scene(to_toml(scene)) == scene


@pytest.mark.parametrize(
    "table", ["x;y\n1.5;2\n", "x\ty\n1.5\t2\n", "# a remark\n\nx,y\n# another\n1.5,2\n\n", '"x","y"\n"1.5",2\n']
)
def test_semicolons_tabs_remarks_and_quotes_are_read(tmp_path: Path, table: str) -> None:
    (row,) = read(tmp_path, table, DEFAULTS).rows
    assert (row.x, row.y) == (1.5, 2.0)


@pytest.mark.parametrize(
    ("table", "says"),
    [
        ("x,y\n1,2\n3\n", "particles_from: bowl.csv, line 3: 1 cells, expected 2 as in the head"),
        ("x,y\n1,2,3\n", "line 2: 3 cells"),
        ("x,y\n1,2\n\n3,abc\n", "line 4, column y: got 'abc'; expected a number"),
        ("x,y\n1,nan\n", "line 2, column y: got 'nan'"),
        ("x,y\n1,inf\n", "line 2, column y: got 'inf'"),
        ("x,y\n1,1_0\n", "line 2, column y: got '1_0'"),
        ("x,y\n1,\n", "line 2, column y: got ''"),
        ("x,y,radios\n1,2,3\n", "line 1, column 'radios': no such column; did you mean radius?"),
        ("x [kg],y\n1,2\n", "line 1, column 'x [kg]': 'kg' measures mass, expected length"),
        ("x [m^9^9^9],y\n1,2\n", "is not how a unit is written"),
        ("x [mm,y\n1,2\n", "expected a name, or a name with its unit"),
        ("name [m],x,y\na,1,2\n", "text has no unit"),
        ("x,y,x\n1,2,3\n", "line 1: column x appears twice"),
        ("x\n1\n", "line 1: no column y"),
        ("x,y\n", "no rows below the header"),
        ("", "no column x"),
        ('x,y\n"1,2\n', "bowl.csv, line"),
        ("x,y,radius [mm]\n1,2,3\n4,5,-6\n", "bowl.csv, line 3, radius: got -0.006; expected 1e-08 or more"),
        ("x,y\n1e9,2\n", "bowl.csv, line 2, x: got 1000000000.0; expected 1000 or less"),
    ],
)
def test_a_fault_of_a_table_is_reported_with_its_line_and_column(tmp_path: Path, table: str, says: str) -> None:
    faults = faults_of(tmp_path, table, DEFAULTS)
    assert any(says in fault for fault in faults), faults
    assert all(fault.startswith("line 4, column 1: particles_from") for fault in faults), faults


def test_many_faults_of_a_table_are_cut_short(tmp_path: Path) -> None:
    faults = faults_of(tmp_path, "x,y\n" + "a,b\n" * 100, DEFAULTS)
    assert len(faults) == 21
    assert "and 180 more like these" in faults[-1]


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ("", "bowl.csv has no column radius, and no [[particles]] gives one"),
        (DEFAULTS + "count = 3", "particles[0].count: has no meaning beside particles_from"),
        (DEFAULTS + "colour = 3", "particles[0].colour: no such key; did you mean color?"),
        (DEFAULTS.replace("600", "-1"), "particles[0].density: got -1; expected 0.001 or more"),
        (DEFAULTS * 2, "particles: beside particles_from expected one [[particles]] table"),
        ("start_from = 'run'", "only one can stand in a scene"),
        ("[[rows]]\nx = 1", "only one can stand in a scene"),
    ],
)
def test_what_stands_beside_a_table_must_fit(tmp_path: Path, more: str, says: str) -> None:
    faults = faults_of(tmp_path, "x,y\n1,2\n", more)
    assert any(says in fault for fault in faults), faults
    assert not any("nothing afloat" in fault for fault in faults)


@pytest.mark.parametrize(
    ("name", "says"),
    [
        (".", "is a folder; expected a file"),
        ("", "expected the path of a file"),
        ("x\\u0000y", "expected the path of a file"),
        ("nowhere.csv", "does not exist; paths are relative to the scene's folder"),
        ("/nowhere/bowl.csv", "leads out of the scene.s folder"),
        ("loop", "does not exist"),
        ("x" * 900, "does not exist"),
    ],
)
def test_a_table_that_cannot_be_read_is_reported_by_its_key(tmp_path: Path, name: str, says: str) -> None:
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "scene.toml").write_text(SCENE.replace("bowl.csv", name) + DEFAULTS)
    with pytest.raises(SceneError, match=f"particles_from.*{says}"):
        load_scene(tmp_path / "scene.toml")


@pytest.mark.parametrize("way", ["../bowl.csv", "link.csv", "linked/bowl.csv", "absolute", "~/bowl.csv"])
def test_a_table_lies_in_the_folder_of_the_scene_or_in_one_that_the_user_trusts(
    tmp_path: Path, way: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    folder = tmp_path / "scenes"
    folder.mkdir()
    (tmp_path / "bowl.csv").write_text("x,y\n1,2\n")
    (folder / "link.csv").symlink_to(tmp_path / "bowl.csv")
    (folder / "linked").symlink_to(tmp_path)
    name = (tmp_path / "bowl.csv").as_posix() if way == "absolute" else way
    (folder / "scene.toml").write_text(SCENE.replace("bowl.csv", name) + DEFAULTS)
    with pytest.raises(SceneError, match="leads out of the scene's folder"):
        load_scene(folder / "scene.toml")
    monkeypatch.setenv("ECUME_SCENE_FOLDERS", os.pathsep.join(["/nowhere", str(tmp_path)]))
    assert load_scene(folder / "scene.toml").rows[0].x == 1.0


def test_a_table_in_a_folder_below_is_read(tmp_path: Path) -> None:
    (tmp_path / "tables").mkdir()
    (tmp_path / "tables" / "bowl.csv").write_text("x,y\n1,2\n")
    (tmp_path / "scene.toml").write_text(SCENE.replace("bowl.csv", "tables/../tables/bowl.csv") + DEFAULTS)
    assert load_scene(tmp_path / "scene.toml").rows[0].x == 1.0


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
def test_a_table_that_is_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "bowl.csv")
    (tmp_path / "scene.toml").write_text(SCENE + DEFAULTS)
    with pytest.raises(SceneError, match="is not a regular file"):
        load_scene(tmp_path / "scene.toml")


@given(st.text(alphabet='xy,;\t\n"[m]#1e9-. \0\r', max_size=60))
def test_any_text_is_a_table_or_a_table_fault(text: str) -> None:
    try:
        lines = lines_of("x,y\n" + text)
    except TableFaults:
        return
    assert all(line.values.keys() == {"x", "y"} for line in lines)


def test_a_tables_own_angle_overrules_the_surface_energies_of_the_defaults(tmp_path: Path) -> None:
    young = DEFAULTS.replace('contact_angle = "60 deg"', "surface_energies = {solid_gas = 0.04, solid_liquid = 0.01}")
    (row,) = read(tmp_path, "x,y,contact_angle\n1,2,1.5\n", young).rows
    assert (row.contact_angle, row.surface_energies) == (1.5, None)
    (row,) = read(tmp_path, "x,y\n1,2\n", young).rows
    assert row.surface_energies is not None


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_a_table_is_read_in_every_encoding_of_spreadsheets(tmp_path: Path, encoding: str) -> None:
    (tmp_path / "bowl.csv").write_bytes("x [µm];y [µm];contact_angle [°]\n1000,5;2000;60\n".encode(encoding))
    (tmp_path / "scene.toml").write_text(SCENE + "[[particles]]\nradius = '1 mm'\ndensity = 600\n")
    (row,) = load_scene(tmp_path / "scene.toml").rows  # type: ignore[union-attr]
    assert (row.x, row.y, row.contact_angle) == pytest.approx((0.0010005, 0.002, 1.0471975512))
