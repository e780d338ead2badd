"""Trajectories of other programs as runs: positions and velocities are read, all else is computed."""

import shutil

import gsd.hoomd
import numpy as np
import pytest

from ecume.analysis.series import PathWarning, tracks
from ecume.cli.scenes import velocities_without_a_unit
from ecume.errors import BadInput, RunExists, SceneError
from ecume.run import resume, verify
from ecume.run.imports import Alike, NoUnit, import_run
from ecume.scenes.load import load_scene
from ecume.simulation import simulate
from ecume.trajectories.exports import export
from ecume.trajectories.foreign import dumps, xyz
from ecume.trajectories.foreign.particles import Particles
from ecume.trajectories.reader import open_trajectory

BOWL = """\
model = "floating"
duration = "0.3 s"
frame_every = "20 ms"
seed = 3
[dish]
radius = "15 mm"
[liquid]
viscosity = "20 mPa*s"
"""
SPECIES = """\
[[particles]]
name = "{name}"
{count}
radius = "1.5 mm"
density = {density}
contact_angle = "80 deg"
"""
START = """\
[start_from]
file = "bowl.lammpstrj"
length_unit = "1 mm"
time_unit = "1 ms"
"""
ARRAYS, NUMBERS = (
    ("position", "velocity", "species", "radius"),
    ("pair_energy", "kinetic_energy", "contacts", "clusters"),
)


def species(count=""):
    """Two species; without a count they come from a file."""
    return "".join(
        SPECIES.format(name=name, density=density, count=count) for name, density in (("1", 600.0), ("2", 900.0))
    )


def dumped(frames, rng):
    """The frames as a dump in mm and ms, its rows in random order."""
    text = ""
    for step, frame in enumerate(frames):
        head = f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{len(frame.arrays['species'])}\n"
        text += head + "ITEM: BOX BOUNDS ff ff pp\n-20 20\n-20 20\n-1 1\nITEM: ATOMS id type x y vx vy\n"
        rows = zip(frame.arrays["species"], 1e3 * frame.arrays["position"], frame.arrays["velocity"], strict=True)
        lines = [
            f"{i} {kind + 1} {x:.17g} {y:.17g} {u:.17g} {v:.17g}\n" for i, (kind, (x, y), (u, v)) in enumerate(rows)
        ]
        text += "".join(lines[i] for i in rng.permutation(len(lines)))
    return text


@pytest.fixture(scope="module")
def bowl(tmp_path_factory):
    """A scene that names a dump, and the frames of which the dump was made."""
    folder = tmp_path_factory.mktemp("bowl")
    frames = list(simulate(load_scene(BOWL + species("count = 6"))))
    (folder / "bowl.lammpstrj").write_text(dumped(frames, np.random.default_rng(1)))
    (folder / "bowl.toml").write_text(BOWL + START + species())
    return folder / "bowl.toml", frames


def test_an_imported_run_has_the_frames_of_the_file_and_all_quantities(bowl, tmp_path):
    path, frames = bowl
    done = import_run(path, tmp_path / "run")
    assert done.frames == len(frames) == 16
    assert frames[-1].numbers["contacts"] > 0.0
    with open_trajectory(tmp_path / "run") as found:
        for one, other in zip(found, frames, strict=True):
            assert one.time == pytest.approx(other.time)
            for name in ARRAYS:
                assert one.arrays[name] == pytest.approx(other.arrays[name], rel=1e-9, abs=1e-12), name
            for name in NUMBERS:
                assert one.numbers[name] == pytest.approx(other.numbers[name], rel=1e-9), name


def test_an_imported_run_is_sound_but_cannot_be_computed_again(bowl, tmp_path):
    import_run(bowl[0], tmp_path / "run")
    assert verify(tmp_path / "run").sound
    with pytest.raises(BadInput, match=r"its frames were imported from bowl\.lammpstrj, not computed"):
        verify(tmp_path / "run", deep=True)
    (tmp_path / "run" / "DONE.json").unlink()
    with pytest.raises(BadInput, match="import the file again"):
        resume(tmp_path / "run")


@pytest.mark.parametrize(
    ("step", "old", "new", "message"),
    [
        (9, "ITEM: BOX", "ITEM: BAX", "without ITEM: BOX BOUNDS"),
        (7, "OF ATOMS\n12", "OF ATOMS\n11", "frame 7 has 11 particles; expected 12"),
        (3, "\n-20 20\n", "\n-20 nan\n", "line .*: got 'nan'"),
    ],
)
def test_a_frame_that_does_not_fit_is_named(bowl, tmp_path, step, old, new, message):
    path, _ = bowl
    (tmp_path / "bowl.toml").write_text(path.read_text())
    text = path.with_name("bowl.lammpstrj").read_text()
    before, mark, after = text.partition(f"ITEM: TIMESTEP\n{step}\n")
    assert old in after
    (tmp_path / "bowl.lammpstrj").write_text(before + mark + after.replace(old, new, 1))
    with pytest.raises(BadInput, match=message):
        import_run(tmp_path / "bowl.toml", tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_floats_that_overlap_in_a_later_frame_are_refused(bowl, tmp_path):
    path, frames = bowl
    (tmp_path / "bowl.toml").write_text(path.read_text())
    near = frames[5].arrays["position"].copy()
    near[1] = near[0] + 1e-3
    frames = [*frames[:5], frames[5]._replace(arrays={**frames[5].arrays, "position": near}), *frames[6:]]
    (tmp_path / "bowl.lammpstrj").write_text(dumped(frames, np.random.default_rng(1)))
    with pytest.raises(BadInput, match=r"bowl\.lammpstrj: frame 5: .*overlap"):
        import_run(tmp_path / "bowl.toml", tmp_path / "run")


def test_what_cannot_be_imported_is_refused(bowl, tmp_path):
    path, _ = bowl
    with pytest.raises(BadInput, match=r"no table \[start_from\]"):
        import_run(BOWL + species("count = 2"), tmp_path / "run")
    with pytest.raises(BadInput, match="length_unit"):
        import_run(path, tmp_path / "run", overrides=["start_from.length_unit=0"])
    with pytest.raises(BadInput, match="does not exist"):
        import_run(path, tmp_path / "run", overrides=["start_from.file=nothing.dump"])
    assert not (tmp_path / "run").exists()


CELL = """\
model = "floating"
duration = "0.1 s"
frame_every = "0.1 s"
[start_from]
file = "{file}"
length_unit = "1 mm"
[[particles]]
density = 1250.0
contact_angle = "90 deg"
[cell]
size = ["10 cm", "8 cm"]
"""
HOPS = {"flags": [(5, 0), (45, -1), (85, -2)], "unwrapped": [(5, 0), (-55, 0), (-115, 0)], "none": [(5, 0), (65, 0)]}
"""Places of a float along x (mm) in a cell 100 mm wide, and image numbers."""


def hopping(kind):
    """A dump of a float that moves by -60 mm from frame to frame, and of one at rest."""
    columns = {"flags": "x y ix iy", "unwrapped": "xu yu", "none": "x y"}[kind]
    text = ""
    for step, (x, image) in enumerate(HOPS[kind]):
        head = f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp ff\n0 100\n0 80\n-1 1\n"
        more = (f" {image} 0", " 0 0") if kind == "flags" else ("", "")
        text += f"{head}ITEM: ATOMS id type radius {columns}\n1 1 1 {x} 40{more[0]}\n2 1 1 50 70{more[1]}\n"
    return text


def imported(folder, file, text=""):
    """The paths in a run that a file became (mm)."""
    if text:
        (folder / file).write_text(text)
    (folder / "cell.toml").write_text(CELL.format(file=file))
    import_run(folder / "cell.toml", folder / "run", overrides=["duration=0.2"])
    with open_trajectory(folder / "run") as found:
        return 1e3 * tracks(found)


@pytest.mark.parametrize("kind", ["flags", "unwrapped"])
def test_displacements_over_more_than_half_a_cell_are_those_of_the_file(kind, tmp_path):
    assert imported(tmp_path, "hops.dump", hopping(kind))[:, 0] == pytest.approx(
        np.array([[5, 40], [-55, 40], [-115, 40]])
    )


def test_paths_of_a_file_without_image_numbers_are_a_warning_where_they_may_be_wrong(tmp_path):
    text = hopping("none").replace("65 40", "48 40")
    with pytest.warns(PathWarning, match=r"0\.43 of a side"):
        assert imported(tmp_path, "hops.dump", text)[-1, 0] == pytest.approx([48, 40])


@pytest.mark.parametrize("depth", [0.0, 1.0])
def test_boxes_around_the_origin_and_their_image_numbers_are_read(depth, tmp_path):
    with gsd.hoomd.open(tmp_path / "box.gsd", "w") as file:
        for place, image in ((-49.0, 0), (31.0, -1)):
            frame = gsd.hoomd.Frame()
            frame.particles.N = 2
            frame.configuration.box, frame.configuration.dimensions = [100, 80, depth, 0, 0, 0], 2
            frame.particles.position = np.array([[place, 10, 0], [30, -30, 0]], np.float32)
            frame.particles.image = np.array([[image, 0, 0], [0, 0, 0]], np.int32)
            frame.particles.diameter = np.full(2, 2.0, np.float32)
            frame.particles.types, frame.particles.typeid = ["A"], np.zeros(2, np.uint32)
            file.append(frame)
    assert imported(tmp_path, "box.gsd")[:, :, 0] == pytest.approx(np.array([[-49.0, 30.0], [-69.0, 30.0]]))


def test_a_run_that_is_not_replaced_stays(bowl, tmp_path):
    """Also with --force, if a later frame is bad; and nothing is left beside it."""
    path, _ = bowl
    (tmp_path / "bowl.toml").write_text(path.read_text())
    shutil.copy(path.with_name("bowl.lammpstrj"), tmp_path / "bowl.lammpstrj")
    import_run(tmp_path / "bowl.toml", tmp_path / "run")
    (tmp_path / "run" / "notes.txt").write_text("mine")
    before = {file: file.read_bytes() for file in (tmp_path / "run").rglob("*") if file.is_file()}
    names = sorted(tmp_path.iterdir())

    def unchanged():
        there = {file: file.read_bytes() for file in (tmp_path / "run").rglob("*") if file.is_file()}
        return there == before and sorted(tmp_path.iterdir()) == names and verify(tmp_path / "run").sound

    with pytest.raises(RunExists, match="holds a run already"):
        import_run(tmp_path / "bowl.toml", tmp_path / "run")
    assert unchanged()
    text = (tmp_path / "bowl.lammpstrj").read_text()
    (tmp_path / "bowl.lammpstrj").write_text(text.replace("\n-20 20\n", "\n-20 nan\n").replace("nan", "20", 3))
    with pytest.raises(BadInput, match="got 'nan'"):
        import_run(tmp_path / "bowl.toml", tmp_path / "run", force=True)
    assert unchanged()
    (tmp_path / "bowl.lammpstrj").write_text(text)
    done = import_run(tmp_path / "bowl.toml", tmp_path / "run", force=True)
    assert (done.directory, (tmp_path / "run" / "notes.txt").read_text()) == (tmp_path / "run", "mine")
    assert verify(tmp_path / "run").sound
    assert sorted(tmp_path.iterdir()) == names


FRAME = """\
ITEM: TIMESTEP
{step}
ITEM: NUMBER OF ATOMS
2
ITEM: BOX BOUNDS pp pp ff
0 {side}
0 80
-1 1
ITEM: ATOMS type radius x y
{kinds[0]} 1 5 40
{kinds[1]} 1 50 70
"""


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"side": 90}, r"frame 2: the periodic box is 0\.09 x 0\.08 m; expected 0\.1 x 0\.08 m as in frame 0"),
        ({"step": 25}, "frame 2: is 15 steps .* the frames so far are 10 apart; expected equal intervals"),
        ({"step": 5}, "frame 2: is before the one before it; expected frames in order of time"),
        ({"step": 10}, "frame 2: is 0 steps"),
        ({"kinds": "21"}, "frame 2: particle 1 is of type 2, and of type 1 in frame 0; expected the same order"),
    ],
)
def test_frames_that_a_run_cannot_have_are_refused(changed, message, tmp_path):
    frames = [{"step": 10 * number, "side": 100, "kinds": "12"} for number in range(3)]
    frames[2] |= changed
    (tmp_path / "some.dump").write_text("".join(FRAME.format(**each) for each in frames))
    species = [f'[[particles]]\nname = "{name}"\ndensity = 1250.0\ncontact_angle = "90 deg"\n' for name in "12"]
    head, _, cell = CELL.format(file="some.dump").partition("[[particles]]")
    (tmp_path / "cell.toml").write_text(head + "".join(species) + cell[cell.index("[cell]") :])
    with pytest.raises(BadInput, match=message):
        import_run(tmp_path / "cell.toml", tmp_path / "run", overrides=["duration=0.2"])
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("ITEM: NUMBER OF ATOMS\n2", "ITEM: NUMBER OF ATOMS\n0", "line 4: has a frame without particles"),
        ("ITEM: BOX BOUNDS", "ITEM: BOX", "has a frame without ITEM: BOX BOUNDS"),
    ],
)
def test_a_fault_of_the_first_frame_is_placed_in_the_scene(old, new, message, tmp_path):
    """It was reported as one of --set, which nobody gave."""
    text = "".join(FRAME.format(step=step, side=100, kinds="11") for step in (0, 10))
    (tmp_path / "some.dump").write_text(text.replace(old, new, 1))
    (tmp_path / "cell.toml").write_text(CELL.format(file="some.dump"))
    with pytest.raises(SceneError, match=rf"cell\.toml: line \d+, column 1: start_from\.file: .*{message}") as caught:
        import_run(tmp_path / "cell.toml", tmp_path / "run")
    assert "--set" not in str(caught.value)


def test_velocities_without_a_unit_are_reported(bowl, tmp_path):
    path = bowl[0]
    shutil.copy(path.with_name("bowl.lammpstrj"), tmp_path)
    (tmp_path / "bowl.toml").write_text(path.read_text().replace('time_unit = "1 ms"\n', ""))
    with pytest.warns(NoUnit, match=r"bowl.lammpstrj: its velocities are ignored; start_from.time_unit"):
        import_run(tmp_path / "bowl.toml", tmp_path / "run")
    remark = "its velocities are ignored; start_from.time_unit states their unit"
    assert velocities_without_a_unit(tmp_path / "bowl.toml", []) == [("start_from.file", "bowl.lammpstrj", remark)]
    assert velocities_without_a_unit(tmp_path / "bowl.toml", ["start_from.time_unit=1 ms"]) == []


def test_times_that_a_file_rounds_are_equal_intervals():
    """Of 30 frames a second in ms, intervals are 33 and 34 ms; a doubled frame is found all the same."""
    made = [particles_at(round(number / 30.0, 3)) for number in range(40)]
    alike = Alike("film.xyz", made[0])
    for number, found in enumerate(made):
        alike.require(found, np.zeros(2), number)
    with pytest.raises(BadInput, match="frame 40: is 0 steps or units of time after the one before"):
        alike.require(made[-1], np.zeros(2), 40)


def particles_at(time):
    return Particles(("1",), np.zeros(1, np.int64), np.zeros((1, 3)), instant=time)


@pytest.mark.parametrize("comment", ["i = 0, time = 0.000, E = -1", "time=12:30:00", 'Time="0.5 ps"', "Time=0.25"])
def test_a_comment_of_any_program_may_name_a_time(comment):
    count, read = xyz.series(f"1\n{comment}\nA 0 0 0\n")
    assert count == 1
    assert read(0).instant == {"i = 0, time = 0.000, E = -1": 0.0, "Time=0.25": 0.25}.get(comment)


@pytest.mark.parametrize("heads", [["UNITS", "TIME", "TIMESTEP"], ["TIME", "TIMESTEP"], ["TIMESTEP", "TIME"]])
def test_the_time_of_a_dump_goes_before_its_steps(heads):
    """LAMMPS writes units and time before the step. With steps of varying length the numbers of steps are uneven where
    times are even.
    """
    text, steps = "", [0, 17, 20, 90]
    for number, step in enumerate(steps):
        values = {"UNITS": "si", "TIME": 0.5 * number, "TIMESTEP": step}
        text += "".join(f"ITEM: {head}\n{values[head]}\n" for head in heads if number == 0 or head != "UNITS")
        text += "ITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ATOMS id x y z\n1 0 0 0\n"
    frames, read = dumps.series(text)
    assert [read(frame).instant for frame in range(frames)] == [0.0, 0.5, 1.0, 1.5]


def timed(kind, interval):
    """A dump or an extended XYZ file of three frames with times (s)."""
    text = ""
    for number in range(3):
        if kind == "xyz":
            text += f"2\nProperties=species:S:1:pos:R:3 Time={interval * number}\n1 5 40 0\n1 50 70 0\n"
        else:
            text += f"ITEM: TIME\n{interval * number}\nITEM: TIMESTEP\n{number}\nITEM: NUMBER OF ATOMS\n2\n"
            text += "ITEM: BOX BOUNDS ff ff ff\n0 100\n0 80\n-1 1\nITEM: ATOMS id type x y\n1 1 5 40\n2 1 50 70\n"
    return text


@pytest.mark.parametrize("kind", ["xyz", "dump"])
def test_times_of_a_file_that_contradict_frame_every_are_refused(kind, tmp_path):
    (tmp_path / "cell.toml").write_text(CELL.format(file=f"times.{kind}"))
    overrides = ["duration=0.2", "particles[0].radius='1 mm'", "start_from.time_unit='10 ms'"]
    (tmp_path / f"times.{kind}").write_text(timed(kind, 10.0))
    import_run(tmp_path / "cell.toml", tmp_path / "run", overrides=overrides)
    (tmp_path / f"times.{kind}").write_text(timed(kind, 50.0))
    with pytest.raises(BadInput, match=r'frame 1: .*frame_every is 0\.1 s; expected frame_every = "0\.5 s"'):
        import_run(tmp_path / "cell.toml", tmp_path / "other", overrides=overrides)
    import_run(tmp_path / "cell.toml", tmp_path / "other", overrides=overrides[:2])  # the unit of times is not known


def test_paths_across_a_cell_survive_the_export_to_xyz_and_the_import(tmp_path):
    expected = imported(tmp_path, "hops.dump", hopping("flags"))
    export(tmp_path / "run", "xyz", tmp_path / "hops.xyz")
    (tmp_path / "cell.toml").write_text(CELL.format(file="hops.xyz").replace("1 mm", "1 m"))
    import_run(tmp_path / "cell.toml", tmp_path / "again", overrides=["duration=0.2", "start_from.time_unit='1 s'"])
    with open_trajectory(tmp_path / "again") as found:
        assert 1e3 * tracks(found) == pytest.approx(expected)


TANK = """\
model = "tracers"
duration = "0.2 s"
frame_every = "0.1 s"
[liquid]
viscosity = "1 mPa*s"
[tank]
low = ["{low} mm", "0 mm"]
high = ["{high} mm", "80 mm"]
periodic = ["x"]
[start_from]
file = "hops.dump"
length_unit = "1 mm"
[[particles]]
density = 1000.0
"""


@pytest.mark.parametrize("low", [0, -50, 30])
@pytest.mark.parametrize("kind", ["flags", "unwrapped"])
def test_tracers_cross_the_sides_of_a_periodic_tank_as_in_the_file(kind, low, tmp_path):
    (tmp_path / "hops.dump").write_text(hopping(kind))
    (tmp_path / "tank.toml").write_text(TANK.format(low=low, high=low + 100))
    import_run(tmp_path / "tank.toml", tmp_path / "run")
    with open_trajectory(tmp_path / "run") as found:
        assert 1e3 * tracks(found)[:, 0] == pytest.approx(np.array([[5, 40], [-55, 40], [-115, 40]]))
        for frame in found:
            places = 1e3 * frame.arrays["position"][:, 0]
            assert (places >= low).all()
            assert (places < low + 100).all()
