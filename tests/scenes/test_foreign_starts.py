"""Scenes that start from files of other programs: GSD, LAMMPS data, XYZ and extended XYZ."""

from __future__ import annotations

import contextlib
import gzip
from pathlib import Path

import gsd.hoomd
import numpy as np
import pytest

import ecume
from ecume.errors import SceneError
from ecume.scenes.schema import from_plain, to_plain
from ecume.scenes.starts import StartSpec
from ecume.trajectories.foreign import gsd as gsd_files
from ecume.trajectories.foreign import lammps, xyz
from ecume.trajectories.foreign.particles import MOST_PARTICLES

XYZ = """\
2
a first frame
A 0 0 0
B 9 0 0
3
Lattice="20 0 0 0 10 0 0 0 1" Properties=species:S:1:pos:R:3:velo:R:3:radius:R:1 pbc="T T F"
A 1 2 0 0.5 0 0 1
B 5 2 0 0 -1 0 1.5
A 9.5 7 0 0 0 0 1
"""
LAMMPS = """\
A packing

3 atoms
2 atom types

0 20 xlo xhi
-5 5 ylo yhi
-0.5 0.5 zlo zhi

Masses

1 2.5
2 3

Atoms # sphere

7 1 2.0 3.0 1 2 0 0 0 1
3 2 3.0 3.0 5 2 0 0 0 0
5 1 2.0 3.0 9.5 7 0

Velocities

3 0 -1 0 0 0 0
5 0 0 0 0 0 0
7 0.5 0 0 0 0 0
"""
DUMP = """\
ITEM: TIMESTEP
0
ITEM: NUMBER OF ATOMS
2
ITEM: BOX BOUNDS pp pp pp
0 20
-5 5
-0.5 0.5
ITEM: ATOMS id type x y z radius
1 A 1 2 0 1
2 B 5 2 0 1.5
"""
FLOATS = """\
model = "floating"
duration = "1 s"
frame_every = "0.1 s"
[start_from]
file = "{file}"
length_unit = "1 mm"
{more}
[[particles]]
name = "A"
density = 600
contact_angle = "70 deg"
color = "red"
[[particles]]
name = "B"
density = 700
contact_angle = "80 deg"
"""
SOFT = """\
model = "soft"
duration = "1 s"
frame_every = "0.1 s"
liquid.viscosity = 1
start_from = {{ file = "{file}", length_unit = "1 mm" }}
particles = [{{ name = "A", modulus = 1e4 }}, {{ name = "B", modulus = 2e4 }}]
cell = {{ {cell} }}
"""
TRACERS = """\
model = "tracers"
duration = "1 s"
frame_every = "0.1 s"
start_from = {{ file = "{file}", length_unit = "1 mm", time_unit = "1 s" }}
particles = [{{ name = "A", density = 1000 }}, {{ name = "B", density = 1100, radius = "0.5 mm" }}]
tank = {{ high = ["20 mm", "10 mm"{height}] }}
"""


def hoomd(path: Path, **changes: object) -> None:
    """A file of two frames, as HOOMD-blue writes it."""
    with gsd.hoomd.open(path, "w") as file:
        for step in range(2):
            frame = gsd.hoomd.Frame()
            frame.configuration.step = step
            frame.configuration.box = changes.get("box", [20, 10, 1, 0, 0, 0])
            frame.particles.N = 3
            frame.particles.types = ["A", "B"]
            frame.particles.typeid = [0, 1, 0]
            frame.particles.position = [[1, 2, 0], [5, 2, 0], [9.5 - 0.5 * (1 - step), 7, changes.get("z", 0)]]
            frame.particles.velocity = [[0.5, 0, 0], [0, -1, 0], [0, 0, 0]]
            frame.particles.diameter = [2, 3, 2]
            frame.particles.mass = [2.5, 3, 2.5]
            file.append(frame)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "start.xyz").write_text(XYZ)
    (tmp_path / "start.data").write_text(LAMMPS)
    hoomd(tmp_path / "start.gsd")
    return tmp_path


def loaded(folder: Path, text: str) -> ecume.Scene:
    (folder / "scene.toml").write_text(text)
    return ecume.load_scene(folder / "scene.toml")


def faults(folder: Path, text: str) -> list[str]:
    with pytest.raises(SceneError) as caught:
        loaded(folder, text)
    return [f"{fault.path}: {fault.message}" for fault in caught.value.faults]


@pytest.mark.parametrize("file", ["start.gsd", "start.data", "start.xyz", "start.gsd@1", "start.xyz@1"])
def test_floats_start_from_every_format(folder: Path, file: str) -> None:
    scene = loaded(folder, FLOATS.format(file=file, more='time_unit = "10 ms"'))
    assert isinstance(scene, ecume.FloatingScene)
    assert [row.species_name for row in scene.rows] == ["A", "B", "A"]
    places = [(row.x, row.y, row.vx, row.vy, row.radius) for row in scene.rows]
    expected = [(0.001, 0.002, 0.05, 0.0, 0.001), (0.005, 0.002, 0.0, -0.1, 0.0015), (0.0095, 0.007, 0.0, 0.0, 0.001)]
    assert np.allclose(places, expected, rtol=1e-12, atol=0.0)
    assert [(row.density, row.color) for row in scene.rows] == [(600, "#d62728"), (700, None), (600, "#d62728")]
    assert from_plain(to_plain(scene)) == scene


def test_without_a_unit_of_time_velocities_are_ignored(folder: Path) -> None:
    scene = loaded(folder, FLOATS.format(file="start.gsd", more=""))
    assert {(row.vx, row.vy) for row in scene.rows} == {(0.0, 0.0)}  # type: ignore[union-attr]


@pytest.mark.parametrize("file", ["start.gsd@0", "start.gsd@-2"])
def test_a_frame_is_chosen_as_of_a_run(folder: Path, file: str) -> None:
    assert loaded(folder, FLOATS.format(file=file, more="")).rows[2].x == pytest.approx(0.009)  # type: ignore[union-attr]


def test_a_radius_of_the_scene_takes_precedence(folder: Path) -> None:
    text = FLOATS.format(file="start.xyz", more="").replace("density = 600", "density = 600\nradius = 0.0005")
    assert [row.radius for row in loaded(folder, text).rows] == [0.0005, 0.0015, 0.0005]  # type: ignore[union-attr]


def test_types_may_have_other_names_than_species(folder: Path) -> None:
    text = FLOATS.format(file="start.data", more='species = { 1 = "B", 2 = "A" }')
    assert [row.species_name for row in loaded(folder, text).rows] == ["B", "A", "B"]  # type: ignore[union-attr]


@pytest.mark.parametrize("file", ["start.gsd", "start.xyz", "start.data"])
def test_soft_spheres_start_in_the_cell_of_the_file(folder: Path, file: str) -> None:
    scenes = [loaded(folder, SOFT.format(file=file, cell=cell)) for cell in ("", "size = ['20 mm', '1 cm']")]
    for scene in scenes:
        assert np.allclose(scene.cell.size, (0.02, 0.01), rtol=1e-9)  # type: ignore[union-attr]
        assert np.allclose(scene.particles[0].positions, [(0.001, 0.002), (0.0095, 0.007)], rtol=1e-7)  # type: ignore[union-attr]
        assert [round(one.radius, 9) for one in scene.particles] == [0.001, 0.0015]  # type: ignore[union-attr]
        assert [one.modulus for one in scene.particles] == [1e4, 2e4]  # type: ignore[union-attr]


def test_a_cell_of_another_size_is_refused(folder: Path) -> None:
    (fault,) = faults(folder, SOFT.format(file="start.gsd", cell="size = ['20 mm', '11 mm']"))
    assert fault.startswith("cell.size: got 0.02 m, 0.011 m; the periodic box of start.gsd is 0.02 m, 0.01 m; check")
    (fault,) = faults(folder, SOFT.format(file="start.gsd", cell="volume_fraction = 0.8, size = [1, 1]"))
    assert (
        fault == "cell.volume_fraction: has no meaning beside start_from or particles_from, which contain the positions"
    )
    hoomd(folder / "start.gsd", box=[20, 10, 1, 0.5, 0, 0])
    (fault,) = faults(folder, SOFT.format(file="start.gsd", cell=""))
    assert fault == "start_from: start.gsd has a box tilted by 0.005 m; expected a rectangular one"


def test_tracers_start_with_velocities_in_two_and_three_dimensions(folder: Path) -> None:
    for height, dimensions in (("", 2), (', "5 mm"', 3)):
        scene = loaded(folder, TRACERS.format(file="start.data", height=height))
        heavy = scene.particles[1]  # type: ignore[union-attr]
        assert (heavy.count, heavy.radius, heavy.density) == (1, 0.0005, 1100.0)
        assert heavy.positions == ((0.005, 0.002, 0.0)[:dimensions],)
        assert heavy.velocities == ((0.0, -0.001, 0.0)[:dimensions],)


def test_a_tank_starts_from_particles_with_masses(folder: Path) -> None:
    text = """
        model = "sph"
        duration = 1
        frame_every = 1
        spacing = "1 mm"
        tank = { low = [0, -0.005], high = [0.02, 0.01], left = { kind = "KIND" }, right = { kind = "KIND" } }
        start_from = { file = "start.gsd", length_unit = "1 mm", time_unit = "1 s", mass_unit = "1 mg" }
    """
    scene = loaded(folder, text.replace("KIND", "periodic"))
    first, second = (region.particles for region in scene.fluid)  # type: ignore[union-attr]
    assert np.allclose(first.positions, [(0.001, 0.002), (0.0095, 0.007)], rtol=1e-7)
    assert np.allclose([*first.masses, *second.masses], [2.5e-6, 2.5e-6, 3e-6], rtol=1e-9)
    assert second.velocities == ((0.0, -0.001),)
    narrow = text.replace("KIND", "periodic").replace("0.02,", "0.03,")
    assert "the periodic box of start.gsd is 0.02 m; check length_unit" in faults(folder, narrow)[0]
    assert faults(folder, text.replace("KIND", "periodic") + "fluid = [{ low = [0, 0], high = [1, 1] }]\n") == [
        "fluid: has no meaning beside start_from, which contains all the liquid"
    ]


@pytest.mark.parametrize(
    ("file", "text", "message"),
    [
        (
            "start.xyz",
            XYZ.replace("3\nLat", "30\nLat"),
            "start.xyz, line 5: announces 30 particles, and 3 lines follow",
        ),
        ("start.xyz", XYZ.replace("9.5", "9,5"), "start.xyz, line 9: got '9,5'; expected a number"),
        ("start.xyz", XYZ.replace("1.5\n", "nan\n"), "start.xyz, line 8: got 'nan'; expected a number"),
        ("start.xyz", XYZ.replace(" 1.5\n", "\n"), "start.xyz, line 8: got 7 columns; expected 8"),
        ("start.xyz", XYZ.replace("radius:R:1", "radius:R:9999"), "start.xyz, line 6: got 9999 columns of radius"),
        ("start.xyz", XYZ.replace("pos:R:3", "pos:R:2"), "start.xyz, line 6: got 2 columns of pos; expected 3"),
        ("start.xyz", XYZ.replace("pos:R", "place:R"), "start.xyz, line 6: got no column pos"),
        (
            "start.xyz",
            XYZ.replace("10 0 0 0 1", "10 0 0 0"),
            "start.xyz, line 6: got a Lattice of 8 numbers; expected 9",
        ),
        ("start.xyz", "x" + XYZ, "start.xyz, line 1: got 'x2'; expected a whole number of 1 or more"),
        ("start.xyz", "\n", "'start.xyz' is empty"),
        ("start.data", LAMMPS.replace("3 atoms", "4 atoms"), "start.data, line 3: announces 4 particles, and 3 lines"),
        (
            "start.data",
            LAMMPS.replace("3 atoms", "2 atoms"),
            "start.data, line 15: got 3 atoms; the header announces 2",
        ),
        (
            "start.data",
            LAMMPS.replace("# sphere", "# body"),
            "line 15: got the atom style 'body'; expected a line such",
        ),
        ("start.data", LAMMPS.replace(" # sphere", ""), "line 15: got Atoms without its atom style"),
        ("start.data", LAMMPS.replace("9.5 7 0", "9.5 7"), "line 19: got 6 columns; expected 7 (id type diameter"),
        ("start.data", LAMMPS.replace("9.5", "inf"), "start.data, line 19: got 'inf'; expected a number"),
        ("start.data", LAMMPS.replace("Atoms", "Bonds"), "'start.data' has no section Atoms"),
        ("start.data", LAMMPS.replace("7 0.5", "8 0.5"), "line 25: got '8 0.5 0 0 0 0 0'; expected an atom's id"),
        ("start.data", LAMMPS.replace("5 1 2.0", "3 1 2.0"), "line 19: got the id 3 for the second time"),
        ("start.data", LAMMPS.split("\n7 1 2.0")[0] + "\n", "line 15: got no atoms; expected one or more"),
        ("start.data", LAMMPS.replace("0 20 xlo", "20 0 xlo"), "got a box with the sides -20, 10 and 1"),
        (
            "start.xyz",
            XYZ.replace("species:S", "id:I:1:species:S")
            .replace("A 1", "1 A 1")
            .replace("B 5", "1 B 5")
            .replace("A 9.5", "2 A 9.5"),
            "line 8: got the id 1 for the second time",
        ),
        ("start.dump", DUMP.replace("\n2 ", "\n1 "), "start.dump, line 11: got the id 1 for the second time"),
        ("start.dump", DUMP.replace("0 20", "20 0"), "got a box with the sides -20, 10 and 1; expected positive ones"),
        ("start.gsd", "no GSD file", "'start.gsd' cannot be read: not a GSD file, or its beginning is damaged"),
        ("start.gsd", None, "'start.gsd' does not exist"),
        ("../start.gsd", None, "'../start.gsd' leads out of the scene's folder"),
        ("start.png", "", "'start.png' has an unknown ending; expected one of .gsd, .xyz"),
        ("start.gsd@7", LAMMPS, "'start.gsd@7' has no frame 7; there are 0 to 1, and -1 for the last"),
    ],
)
def test_a_fault_of_a_file_names_it_and_its_line(folder: Path, file: str, text: str | None, message: str) -> None:
    if text is None:
        (folder / "start.gsd").unlink()
    elif "@" not in file:
        (folder / file).write_text(text)
    (fault,) = faults(folder, FLOATS.format(file=file, more=""))
    assert fault.startswith("start_from.file: ")
    assert message in fault


@pytest.mark.parametrize("box", [[np.nan, 10, 1, 0, 0, 0], [20, np.inf, 1, 0, 0, 0], [20, -10, 1, 0, 0, 0]])
@pytest.mark.parametrize(
    "text", [FLOATS.format(file="start.gsd", more=""), TRACERS.format(file="start.gsd", height="")]
)
def test_a_box_that_no_system_has_is_refused(folder: Path, box: list[float], text: str) -> None:
    """NaN passes each comparison with the periods of a tank."""
    hoomd(folder / "start.gsd", box=box)
    (fault,) = faults(folder, text)
    assert fault.startswith("start_from.file: start.gsd, got a box with the sides")


def test_a_box_without_area_is_none(folder: Path) -> None:
    (folder / "start.xyz").write_text(XYZ.replace("20 0 0 0 10 0 0 0 1", "0 0 0 0 0 0 0 0 0"))
    assert xyz.read((folder / "start.xyz").read_text()).sides is None
    hoomd(folder / "start.gsd", box=[0, 0, 0, 0, 0, 0])
    assert gsd_files.read(folder / "start.gsd").sides is None


def test_a_damaged_gsd_file_gives_faults_and_no_crash(folder: Path) -> None:
    whole = (folder / "start.gsd").read_bytes()
    random = np.random.default_rng(1)
    for _ in range(60):
        data = bytearray(whole[: int(random.integers(100, len(whole) + 1))])
        for place in random.integers(0, len(data), 20):
            data[place] = int(random.integers(256))
        (folder / "start.gsd").write_bytes(data)
        with contextlib.suppress(SceneError):
            assert len(loaded(folder, FLOATS.format(file="start.gsd", more="")).rows) == 3  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'name = "B"',
            'name = "C"',
            "start_from: start.gsd has particles of type 'B', and the species are 'A', 'C'; expected",
        ),
        ("density = 700", "density = 700\ncount = 3", "particles[1].count: has no meaning beside start_from"),
        ("density = 700\n", "", "particles[1].density: is missing; expected for example '1030 kg/m^3'"),
        ("density = 700", "density = -1", "particles[1].density: got -1; expected 0.001 or more"),
        ("density = 700", "density = [700, 800]", "particles[1].density: got [700, 800]; expected a number"),
        ("density = 600", "density = 600\ncolr = 3", "particles[0].colr: no such key; did you mean color?"),
        (
            'contact_angle = "80 deg"',
            "",
            "particles[1]: expected either contact_angle or surface_energies; got neither",
        ),
        ('length_unit = "1 mm"', "", "start_from.length_unit: is missing"),
        ('length_unit = "1 mm"', 'length_unit = "1 s"', "start_from.length_unit: got '1 s'; 's' measures time"),
        ('length_unit = "1 mm"', 'length_unit = "1 mm"\nunit = 3', "start_from.unit: no such key"),
        ('file = "start.gsd"', "file = 3", "start_from.file: got 3; expected text"),
        ('file = "start.gsd"', 'file = "."', "start_from.file: '.' is not a regular file; a run is named by text"),
    ],
)
def test_a_fault_of_the_scene_names_its_path(folder: Path, old: str, new: str, message: str) -> None:
    (fault,) = faults(folder, FLOATS.format(file="start.gsd", more="").replace(old, new))
    assert fault.startswith(message)


def test_a_species_without_particles_is_refused(folder: Path) -> None:
    text = FLOATS.format(file="start.xyz@0", more="") + '[[particles]]\nname = "C"\nradius = 1e-3\ndensity = 1\n'
    text = text.replace("density = 600", "density = 600\nradius = 1e-3").replace(
        "density = 700", "density = 7\nradius = 1e-3"
    )
    assert faults(folder, text) == [
        "particles[2].name: got 'C'; start.xyz@0 has no particle of it: its types are 'A', 'B'"
    ]


def test_a_file_needs_diameters_or_a_radius(folder: Path) -> None:
    text = FLOATS.format(file="start.xyz@0", more="").replace("density = 600", "density = 600\nradius = 1e-3")
    assert faults(folder, text) == ["particles[1].radius: is missing; start.xyz@0 has no diameters"]
    (folder / "start.xyz").write_text(XYZ.replace("0 0 0 1\n", "0 0 0 1.1\n"))
    (folder / "scene.toml").write_text(SOFT.format(file="start.xyz", cell=""))
    assert max(ecume.load_scene(folder / "scene.toml").particles[0].radii) == pytest.approx(1.1e-3)


def test_a_file_in_three_dimensions_is_refused_for_a_surface(folder: Path) -> None:
    hoomd(folder / "start.gsd", z=0.25)
    assert faults(folder, FLOATS.format(file="start.gsd", more="")) == [
        "start_from: start.gsd is 3D: z is from 0 m to 0.00025 m; the scene has 2 dimensions"
    ]


def test_text_names_a_run_only(folder: Path) -> None:
    for text, key in ((FLOATS, "start_from"), (TRACERS, "start_from")):
        plain = "\n".join(
            line for line in text.format(file="", more="", height="").splitlines() if "start_from" not in line
        )
        plain = plain.replace('file = ""\nlength_unit = "1 mm"\n', "")
        (fault,) = faults(folder, 'start_from = "start.gsd@0"\n' + plain)
        assert fault.startswith(
            f"{key}: 'start.gsd@0' is a file without units; expected a table such as start_from = {{ file"
        )


def test_labels_and_styles_of_lammps_are_read() -> None:
    text = "t\n\n1 atoms\n\nAtom Type Labels\n\n1 C\n2 Si\n\nMasses\n\nC 12\n2 28\n\n"
    found = lammps.read(text + "Atoms # full\n\n1 1 Si 0.5 1 2 3 0 0 0\n")
    assert (found.names, found.kind.tolist(), found.position.tolist()) == (("C", "Si"), [1], [[1.0, 2.0, 3.0]])
    assert found.mass is not None
    assert found.mass.tolist() == [28.0]
    sph = lammps.read("t\n\n1 atoms\n\nAtoms # sph\n\n1 1 998 0 0 1 2 3\n")
    assert sph.density is not None
    assert (sph.density[0], sph.position.tolist()) == (998.0, [[1.0, 2.0, 3.0]])


def test_more_particles_than_can_be_read_are_refused_before_memory_is_allocated() -> None:
    with pytest.raises(ValueError, match=f"line 1: announces {10**18 - 1} particles; at most {MOST_PARTICLES}"):
        xyz.read("9" * 18 + "\n\nA 0 0 0\n")
    with pytest.raises(ValueError, match="at most"):
        lammps.read("t\n\n999999999999 atoms\n\nAtoms # atomic\n\n1 1 0 0 0\n")


def test_a_chunk_that_is_too_large_is_not_read(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gsd_files, "MOST_NUMBERS", 8)
    (fault,) = faults(folder, FLOATS.format(file="start.gsd", more=""))
    assert "has 9 numbers in the chunk particles/position of frame 1; expected fewer" in fault


def test_the_command_line_names_the_line_of_a_start(folder: Path) -> None:
    (folder / "start.data").write_text(LAMMPS.replace("9.5", "inf"))
    with pytest.raises(SceneError) as caught:
        loaded(folder, FLOATS.format(file="start.data", more=""))
    assert f"{folder / 'scene.toml'}: line 5, column 1: start_from.file: start.data, line 19: got 'inf'" in str(
        caught.value
    )


@pytest.mark.parametrize(("name", "hint"), [("beads.csv", "particles_from"), ("beads.abc", "")])
def test_an_unknown_ending_is_refused_and_a_table_sent_to_its_key(tmp_path, name, hint):
    (tmp_path / name).write_text("x,y\n0,0\n")
    scene = (
        'model = "floating"\nduration = 1\nframe_every = 1\n[liquid]\nviscosity = 1\n[[particles]]\nradius = 1e-3\n'
        f'[start_from]\nfile = "{name}"\nlength_unit = "1 m"\n[dish]\nradius = 1\n'
    )
    (tmp_path / "scene.toml").write_text(scene)
    with pytest.raises(SceneError, match="unknown ending") as caught:
        ecume.load_scene(tmp_path / "scene.toml")
    assert ("particles_from" in str(caught.value)) == bool(hint)


def test_a_density_that_the_scene_omits_follows_from_the_masses(folder: Path) -> None:
    """Of spheres: 2.5 mg in a diameter of 2 mm."""
    bare = FLOATS.replace("density = 600\n", "")
    scene = loaded(folder, bare.format(file="start.gsd", more='mass_unit = "1 mg"'))
    assert isinstance(scene, ecume.FloatingScene)
    expected = 2.5e-6 / (4.0 / 3.0 * np.pi * 1e-9)
    assert [row.density for row in scene.rows] == pytest.approx([expected, 700.0, expected])
    assert "particles[0].density: is missing" in faults(folder, bare.format(file="start.gsd", more=""))[0]
    settling = TRACERS.replace(", density = 1000", "").replace('time_unit = "1 s"', 'mass_unit = "1 mg"')
    tracers = loaded(folder, settling.format(file="start.gsd", height=""))
    assert [one.density for one in tracers.particles] == pytest.approx([expected, 1100.0])


def test_a_file_of_hoomd_with_diameters_of_1_says_what_it_omits(folder: Path) -> None:
    with gsd.hoomd.open(folder / "ones.gsd", "w") as file:
        frame = gsd.hoomd.Frame()
        frame.configuration.box = [20, 10, 1, 0, 0, 0]
        frame.particles.N, frame.particles.types, frame.particles.typeid = 2, ["A", "B"], [0, 1]
        frame.particles.position, frame.particles.diameter = [[1, 2, 0], [5, 2, 0]], [1, 1]
        file.append(frame)
    for name in ("ones.gsd", "ones.gsd@0"):
        assert "GSD omits diameters that are all 1" in faults(folder, FLOATS.format(file=name, more=""))[0]


DUMP = """\
ITEM: TIMESTEP
0
ITEM: NUMBER OF ATOMS
1
ITEM: BOX BOUNDS ff ff ff
0 1
0 1
0 1
ITEM: ATOMS id type x y z vx vy vz radius
1 1 0.5 0.5 0.0 3.0 4.0 0.0 0.1
"""


@pytest.mark.parametrize(("stated", "expected"), [("", (3.0, 4.0)), ("velocity = [0.5, 0.25]\n", (0.5, 0.25))])
@pytest.mark.parametrize("model", ["floating", "tracers"])
def test_a_velocity_that_a_species_states_takes_precedence_over_the_file(tmp_path, model, stated, expected):
    (tmp_path / "a.dump").write_text(DUMP)
    own = "contact_angle = 1.0\n[dish]\nradius = 1\n" if model == "floating" else "[tank]\nhigh = [1, 1]\n"
    (tmp_path / "scene.toml").write_text(
        f'model = "{model}"\nduration = 1\nframe_every = 1\n[liquid]\nviscosity = 1\n[start_from]\nfile = "a.dump"\n'
        f'length_unit = "1 m"\ntime_unit = "1 s"\n[[particles]]\ndensity = 500\n{stated}{own}'
    )
    scene = ecume.load_scene(tmp_path / "scene.toml")
    if model == "floating":
        assert (scene.rows[0].vx, scene.rows[0].vy) == expected
    else:
        assert (scene.particles[0].velocities[0] if not stated else scene.particles[0].velocity) == expected


@pytest.mark.parametrize("file", ["start.data", "start.xyz"])
def test_a_compressed_text_is_the_text(folder: Path, file: str) -> None:
    plain = loaded(folder, TRACERS.format(file=file, height=""))
    (folder / f"{file}.gz").write_bytes(gzip.compress((folder / file).read_bytes()))
    (folder / file).unlink()
    assert loaded(folder, TRACERS.format(file=f"{file}.gz", height="")) == plain
    (folder / f"{file}.gz").write_bytes(b"no archive")
    assert "cannot be decompressed" in faults(folder, TRACERS.format(file=f"{file}.gz", height=""))[0]
    (folder / "start.gsd.gz").write_bytes(gzip.compress(b"GSD"))
    assert "decompress it: gunzip start.gsd.gz" in faults(folder, TRACERS.format(file="start.gsd.gz", height=""))[0]
    (folder / f"{file}.gz").write_bytes(gzip.compress(bytes(65 * 2**20)))
    assert "holds more than 64 MiB" in faults(folder, TRACERS.format(file=f"{file}.gz", height=""))[0]


LATTICE = """
model = "sph"
duration = 1
frame_every = 1
spacing = "1 mm"
up = "{up}"
{start}
[tank]
low = {low}
high = {high}
{sides}
"""


@pytest.mark.parametrize(("up", "depth"), [("y", 0), ("y", 6), ("z", 6)])
@pytest.mark.parametrize("seed", range(3))
def test_a_box_around_the_origin_fills_a_periodic_tank(tmp_path: Path, up: str, depth: int, seed: int) -> None:
    """HOOMD and many decks of LAMMPS have boxes around the origin; tanks begin anywhere."""
    rng = np.random.default_rng(seed)
    counts = [10, 8, depth][: 3 if depth else 2]
    low = rng.integers(-20, 20, len(counts))
    home = np.stack(np.meshgrid(*(0.5 + np.arange(n) for n in counts), indexing="ij"), axis=-1).reshape(-1, len(counts))
    places = home - 0.5 * np.array(counts)
    bounds = "".join(f"{-0.5 * n} {0.5 * n}\n" for n in [*counts, 1][:3])
    head = f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{len(home)}\nITEM: BOX BOUNDS pp pp pp\n{bounds}"
    columns = " ".join("xyz"[: len(counts)])
    rows = "".join(" ".join(map(str, place)) + "\n" for place in places)
    (tmp_path / "box.dump").write_text(f"{head}ITEM: ATOMS {columns}\n{rows}")
    sides = ["left", "right", "bottom", "top", "front", "back"][: 2 * len(counts)]
    text = LATTICE.format(
        up=up,
        start='start_from = { file = "box.dump", length_unit = "1 mm" }',
        low=(1e-3 * low).tolist(),
        high=(1e-3 * (low + counts)).tolist(),
        sides="".join(f'{side} = {{ kind = "periodic" }}\n' for side in sides),
    )
    found = 1e3 * np.array(loaded(tmp_path, text).fluid[0].particles.positions) - low  # type: ignore[union-attr]
    assert sorted(np.round(found, 9).tolist()) == sorted(home.tolist())
    longer = f"{-0.5 * counts[-1]} {0.5 * counts[-1] + 1}\n"
    wrong = bounds.replace(f"{-0.5 * counts[-1]} {0.5 * counts[-1]}\n", longer)
    (tmp_path / "box.dump").write_text(f"{head.replace(bounds, wrong)}ITEM: ATOMS {columns}\n{rows}")
    assert "the periodic box of box.dump is" in faults(tmp_path, text)[0]


def test_a_tilted_box_is_refused_where_images_would_be_shifted(tmp_path: Path) -> None:
    """In a tank that is periodic along y, particles one period higher are also one tilt further along x."""
    head = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS xy xz yz pp pp pp\n0 12 2\n0 8 0\n0 1 0\n"
    (tmp_path / "box.dump").write_text(f"{head}ITEM: ATOMS x y\n3.5 0.5\n")
    start = 'start_from = { file = "box.dump", length_unit = "1 mm" }'
    periodic = {side: f'{side} = {{ kind = "periodic" }}\n' for side in ("left", "right", "bottom", "top")}
    both, along_x = "".join(periodic.values()), periodic["left"] + periodic["right"]
    texts = [
        LATTICE.format(up="y", start=start, low=[0, 0], high=[0.010, 0.008], sides=each) for each in (both, along_x)
    ]
    assert faults(tmp_path, texts[0]) == [
        "start_from: box.dump has a box tilted by 0.002 m; expected a rectangular one for a tank that is periodic "
        "along x and y; write the file without a tilt, or use walls there"
    ]
    assert np.allclose(loaded(tmp_path, texts[1]).fluid[0].particles.positions, [[0.0035, 0.0005]])  # type: ignore[union-attr]


def test_a_mass_per_depth_is_of_liquid_in_two_dimensions_only(folder: Path) -> None:
    text = LATTICE.format(
        up="y",
        start='start_from = { file = "start.gsd", length_unit = "1 mm", mass_unit = "1 mg/mm" }',
        low=[-0.01, -0.01],
        high=[0.02, 0.02],
        sides="",
    )
    masses = [region.particles.masses for region in loaded(folder, text).fluid]  # type: ignore[union-attr]
    assert np.allclose(np.concatenate(masses), [2.5e-3, 2.5e-3, 3e-3])
    assert faults(
        folder, TRACERS.format(file="start.gsd", height="").replace('"1 s" }', '"1 s", mass_unit = "1 kg/m" }')
    ) == ["start_from.mass_unit: got a mass per length; expected a mass as in '1 mg', of spheres"]


PERIODIC = TRACERS.replace("tank = {{", 'tank = {{ periodic = ["x", "y"],')
TILTED = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS {}\nITEM: ATOMS type x y z\nA {} 2 0\nB 5 2 0\n"


@pytest.mark.parametrize(
    ("bounds", "x", "fault"),
    [
        ("xy xz yz pp pp pp\n0 25 5\n-5 5 0\n-1 1 0", "1", "has a box tilted by 0.005 m"),
        ("pp pp pp\n0 20\n-5 5\n-1 1", "1e300", "positions[0][0]: got"),
    ],
)
def test_a_tilted_box_and_lost_positions_are_refused_in_a_periodic_tank(
    folder: Path, bounds: str, x: str, fault: str
) -> None:
    (folder / "start.dump").write_text(TILTED.format(bounds, x))
    scene = PERIODIC.replace("density = 1000 }}", 'density = 1000, radius = "0.5 mm" }}')
    found = faults(folder, scene.format(file="start.dump", height=""))
    assert any(fault in one for one in found), found


@pytest.mark.parametrize(("unit", "meters"), [("1 nautical_mile", 1852.0), ("100 km", 1e5), ("1 nm", 1e-9)])
def test_lengths_of_files_may_be_in_miles(unit, meters):
    assert StartSpec(file="drifters.xyz", length_unit=unit).length_unit == pytest.approx(meters)
    with pytest.raises(SceneError, match="length_unit"):
        StartSpec(file="drifters.xyz", length_unit="1 light_year")
