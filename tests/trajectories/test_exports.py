"""Trajectories for the programs of others."""

from __future__ import annotations

import csv
import errno
import json
import os
import resource
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import h5py
import numpy as np
import pytest

from ecume.errors import BadInput, StorageError
from ecume.trajectories.exports import EXPORTS, export
from ecume.trajectories.frame import Frame
from ecume.trajectories.segments import Recorder

pytestmark = pytest.mark.sampled(2)

Frames = Callable[..., list[Frame]]
Recorded = Callable[..., Path]


def test_csv_is_one_long_table_with_units(recorded: Recorded, frames: Frames, tmp_path: Path) -> None:
    with export(recorded(4).parent, "csv", tmp_path / "bowl.csv").open(newline="") as file:
        heading, *rows = list(csv.reader(file))
    components = ["x [m]", "y [m]", "vx [m/s]", "vy [m/s]", "radius [m]", "mass [kg]", "species", "neighbors"]
    assert heading == ["frame", "time [s]", "particle", *components]
    assert len(rows) == 4 * 6
    frame = frames(4)[2]
    row = rows[2 * 6 + 3]
    assert row[:3] == ["2", repr(frame.time), "3"]
    assert [float(word) for word in row[3:7]] == [*frame.arrays["position"][3], *frame.arrays["velocity"][3]]
    assert int(row[-1]) == frame.arrays["neighbors"][3]


def test_xyz_says_what_its_columns_are(recorded: Recorded, frames: Frames, tmp_path: Path) -> None:
    lines = export(recorded(3).parent, "xyz", tmp_path / "bowl.xyz").read_text().splitlines()
    assert len(lines) == 3 * (2 + 6)
    head = lines[8 + 1]
    assert head.startswith(
        "Properties=species:S:1:pos:R:3:velo:R:3:radius:R:1:mass:R:1:kind:I:1:neighbors:I:1 Time=0.1 "
    )
    assert f"kinetic_energy={frames(3)[1].numbers['kinetic_energy']!r}" in head
    words = lines[8 + 2 + 5].split()
    assert words[0] == "Li"
    assert [float(word) for word in words[1:4]] == [*frames(3)[1].arrays["position"][5], 0.0]


def test_xyz_says_which_element_stands_for_which_species(frames: Frames, tmp_path: Path) -> None:
    with Recorder(tmp_path / "traj", species=["big 'un", 'a "b"']) as recorder:
        recorder.write(frames(1)[0], 0)
    head = export(tmp_path, "xyz", tmp_path / "bowl.xyz").read_text().splitlines()[1]
    assert """ Species="H: big 'un, He: a 'b'" pbc""" in head


def test_npz_has_the_frames_as_first_axis(recorded: Recorded, frames: Frames, tmp_path: Path) -> None:
    with np.load(export(recorded(5).parent, "npz", tmp_path / "bowl.npz"), allow_pickle=False) as archive:
        for name, array in frames(5)[3].arrays.items():
            np.testing.assert_array_equal(archive[name][3], array, strict=True)
        assert archive["kinetic_energy"].tolist() == [frame.numbers["kinetic_energy"] for frame in frames(5)]
        assert archive["time"].shape == (5,)
        assert json.loads(str(archive["units"]))["velocity"] == "m/s"


def test_npz_refuses_particles_that_come_and_go(tmp_path: Path, frames: Frames) -> None:
    with Recorder(tmp_path / "traj") as recorder:
        recorder.write(frames(1, particles=3)[0], 0)
        recorder.write(frames(2, particles=4)[1], 1)
    with pytest.raises(BadInput, match="changes at frame 1"):
        export(tmp_path, "npz", tmp_path / "bowl.npz")
    assert not (tmp_path / "bowl.npz").exists()


@pytest.mark.parametrize("dimensions", [2, 3])
def test_vtk_holds_every_frame(recorded: Recorded, frames: Frames, tmp_path: Path, dimensions: int) -> None:
    path = export(recorded(5, dimensions=dimensions).parent, "vtk", tmp_path / "bowl.vtkhdf")
    with h5py.File(path) as file:
        root, steps = file["VTKHDF"], file["VTKHDF/Steps"]
        assert root.attrs["Type"] == b"PolyData"
        assert steps.attrs["NSteps"] == len(steps["Values"]) == 5
        assert len(root["PointData/radius"]) == 6, "what never changes is written once"
        for number, frame in enumerate(frames(5, dimensions=dimensions)):
            start = steps["PointOffsets"][number]
            points = root["Points"][start : start + root["NumberOfPoints"][number]]
            np.testing.assert_array_equal(points[:, :dimensions], frame.arrays["position"])
            start = steps["PointDataOffsets/neighbors"][number]
            np.testing.assert_array_equal(root["PointData/neighbors"][start : start + 6], frame.arrays["neighbors"])


def test_vtk_is_read_by_vtk(tmp_path: Path, frames: Frames) -> None:
    hdf = pytest.importorskip("vtkmodules.vtkIOHDF")
    support = pytest.importorskip("vtkmodules.util.numpy_support")
    written = [frames(1, particles=4)[0], *(frame for frame in frames(4, particles=7)[1:])]
    with Recorder(tmp_path / "traj") as recorder:
        for number, frame in enumerate(written):
            recorder.write(frame, number)
    reader = hdf.vtkHDFReader()
    reader.SetFileName(str(export(tmp_path, "vtk", tmp_path / "bowl.vtkhdf")))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == 4
    for number, frame in enumerate(written):
        reader.SetStep(number)
        reader.Update()
        shown = reader.GetOutputDataObject(0)
        points = support.vtk_to_numpy(shown.GetPoints().GetData())
        np.testing.assert_array_equal(points[:, :2], frame.arrays["position"])
        assert shown.GetNumberOfVerts() == len(points)
        data = support.vtk_to_numpy(shown.GetPointData().GetArray("species"))
        np.testing.assert_array_equal(data, frame.arrays["species"])
        energy = shown.GetFieldData().GetArray("kinetic_energy")
        assert energy.GetValue(0) == frame.numbers["kinetic_energy"]


def test_a_list_of_vtk_files_is_read_by_vtk(tmp_path: Path, frames: Frames) -> None:
    xml = pytest.importorskip("vtkmodules.vtkIOXML")
    support = pytest.importorskip("vtkmodules.util.numpy_support")
    written = frames(3, particles=5)
    with Recorder(tmp_path / "traj") as recorder:
        for number, frame in enumerate(written):
            recorder.write(frame, number)
    listed = export(tmp_path, "pvd", tmp_path / "out" / "the bowl & more.pvd")
    named = ElementTree.parse(listed).getroot().findall("Collection/DataSet")
    assert [float(entry.attrib["timestep"]) for entry in named] == [frame.time for frame in written]
    for entry, frame in zip(named, written, strict=True):
        reader = xml.vtkXMLPolyDataReader()
        reader.SetFileName(str(listed.parent / entry.attrib["file"]))
        reader.Update()
        shown = reader.GetOutput()
        points = support.vtk_to_numpy(shown.GetPoints().GetData())
        np.testing.assert_array_equal(points[:, :2], frame.arrays["position"])
        assert not points[:, 2:].any()
        assert shown.GetNumberOfVerts() == len(points)
        for name in ("species", "radius", "neighbors"):
            data = support.vtk_to_numpy(shown.GetPointData().GetArray(name))
            np.testing.assert_array_equal(data, frame.arrays[name].reshape(data.shape))
        assert shown.GetFieldData().GetArray("kinetic_energy").GetValue(0) == frame.numbers["kinetic_energy"]


def test_a_list_of_vtk_files_takes_the_place_of_the_former_and_of_nothing_else(
    recorded: Recorded, tmp_path: Path
) -> None:
    run, out = recorded(2).parent, tmp_path / "a" / "b.pvd"
    export(run, "pvd", out)
    (tmp_path / "a" / "b" / "0002.vtp").write_text("of a longer one")
    export(run, "pvd", out)
    assert sorted(path.name for path in (tmp_path / "a" / "b").iterdir()) == ["0000.vtp", "0001.vtp"]
    assert sorted(path.name for path in (tmp_path / "a").iterdir()) == ["b", "b.pvd"]
    (tmp_path / "a" / "b" / "mine.txt").write_text("kept")
    with pytest.raises(StorageError, match=r"holds what no export made \(mine.txt\)"):
        export(run, "pvd", out)
    assert sorted(path.name for path in (tmp_path / "a" / "b").iterdir()) == ["0000.vtp", "0001.vtp", "mine.txt"]
    assert not (tmp_path / "a" / "b.part").exists()


def test_numbers_are_one_line_a_frame_with_units(recorded: Recorded, frames: Frames, tmp_path: Path) -> None:
    with export(recorded(3).parent, "numbers", tmp_path / "numbers.csv").open(newline="") as file:
        heading, *rows = list(csv.reader(file))
    assert heading[:3] == ["frame", "time [s]", "kinetic_energy [J]"]
    for row, frame in zip(rows, frames(3), strict=True):
        assert [float(cell) for cell in row[1:]] == [frame.time, *frame.numbers.values()]


def test_an_unknown_format_is_refused_with_the_known_ones(recorded: Recorded, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="csv, numbers, samples, xyz, vtk, npz, pvd"):
        export(recorded(1).parent, "xlsx", tmp_path / "bowl.xlsx")


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="Windows knows no limit on the size of a file")
@pytest.mark.parametrize("kind", [kind for kind in EXPORTS if kind != "samples"])
@pytest.mark.parametrize("size", [0, 3_000, 9_000])
def test_a_full_disk_leaves_the_former_export_and_no_half_one(
    recorded: Recorded, tmp_path: Path, kind: str, size: int
) -> None:
    folder, out = recorded(400 if kind == "numbers" else 60).parent, tmp_path / "out" / "bowl"
    (folder / "samples.csv").write_text("step,time [s],contacts\n" + "1,0.5,3.0\n" * 1_000)
    out.parent.mkdir()
    out.write_text("former")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        with pytest.raises(StorageError, match=f"{out}: no room left"):
            export(folder, kind, out)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert [path.read_text() for path in out.parent.iterdir()] == ["former"]


def test_an_export_makes_the_folder_it_goes_into_unless_a_file_is_there(recorded: Recorded, tmp_path: Path) -> None:
    run = recorded(1).parent
    assert export(run, "csv", tmp_path / "deep" / "bowl.csv").is_file()
    with pytest.raises(StorageError, match=r"bowl\.csv: File exists"):
        export(run, "csv", tmp_path / "deep" / "bowl.csv" / "again.csv")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="only where pipes have names")
def test_a_pipe_or_a_device_is_left_alone(recorded: Recorded, tmp_path: Path) -> None:
    run = recorded(2).parent
    os.mkfifo(tmp_path / "pipe.csv")
    (tmp_path / "link.csv").symlink_to(tmp_path / "pipe.csv")
    for name in ("pipe.csv", "link.csv"):
        with pytest.raises(StorageError, match="is not a plain file"):
            export(run, "csv", tmp_path / name)
    assert (tmp_path / "pipe.csv").is_fifo()
    assert (tmp_path / "link.csv").is_symlink()


def test_a_link_stays_a_link_to_the_new_content(recorded: Recorded, tmp_path: Path) -> None:
    (tmp_path / "there.csv").write_text("old")
    (tmp_path / "link.csv").symlink_to(tmp_path / "there.csv")
    export(recorded(2).parent, "csv", tmp_path / "link.csv")
    assert (tmp_path / "link.csv").is_symlink()
    assert (tmp_path / "there.csv").read_text().startswith("frame,time")


def test_xyz_states_the_periodic_box(frames: Frames, tmp_path: Path) -> None:
    (frame,) = frames(1)
    box = {"box_width": 0.1, "box_height": 0.08, "box_tilt": 0.02}
    with Recorder(tmp_path / "traj") as recorder:
        recorder.write(frame._replace(numbers=frame.numbers | box), 0)
    head = export(tmp_path, "xyz", tmp_path / "bowl.xyz").read_text().splitlines()[1]
    assert head.startswith('Lattice="0.1 0 0 0.02 0.08 0 0 0 ')
    assert head.endswith(' pbc="T T F"')


@pytest.mark.parametrize("kind", [*(kind for kind in EXPORTS if kind != "samples"), "pvd"])
@pytest.mark.parametrize("stem", ["n" * 250, "ü" * 125, "-a %s b'\"$"])
def test_a_name_may_be_as_long_and_odd_as_the_system_allows(
    kind: str, stem: str, recorded: Recorded, tmp_path: Path
) -> None:
    out = tmp_path / "out" / f"{stem}.{kind[:3]}"
    export(recorded(2).parent, kind, out)
    assert out.stat().st_size > 100
    assert {path.name for path in out.parent.iterdir()} == {out.name, *([stem] if kind == "pvd" else [])}


def test_a_list_of_frames_and_its_folder_are_replaced_together(
    recorded: Recorded, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Neither is changed where the list cannot be written."""
    run, listed = recorded(2).parent, tmp_path / "out" / "bowl.pvd"
    export(run, "pvd", listed)
    for path in listed.parent.rglob("*.vtp"):
        path.write_text("former")
    before = {path: path.read_bytes() for path in listed.parent.rglob("*") if path.is_file()}

    def full(*_: object) -> str:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("ecume.trajectories.exports._listing", full)
    with pytest.raises(StorageError, match="no room left"):
        export(run, "pvd", listed)
    assert {path: path.read_bytes() for path in listed.parent.rglob("*") if path.is_file()} == before
    (tmp_path / "in the way.pvd").mkdir()
    with pytest.raises(StorageError, match="is a folder; expected a file"):
        export(run, "pvd", tmp_path / "in the way.pvd")
    assert not (tmp_path / "in the way").exists()


def test_a_folder_of_the_user_beside_a_list_of_frames_is_kept(recorded: Recorded, tmp_path: Path) -> None:
    """`bowl.part` is where frames are written first: what a killed export left there is replaced, nothing else."""
    folder = recorded(2).parent
    (tmp_path / "bowl.part").mkdir()
    (tmp_path / "bowl.part" / "0000.vtp").write_text("half")
    assert export(folder, "pvd", tmp_path / "bowl.pvd").exists()
    (tmp_path / "bowl.part").mkdir()
    (tmp_path / "bowl.part" / "thesis.txt").write_text("mine")
    with pytest.raises(StorageError, match="holds what no export made"):
        export(folder, "pvd", tmp_path / "bowl.pvd")
    assert (tmp_path / "bowl.part" / "thesis.txt").read_text() == "mine"
    assert len(list((tmp_path / "bowl").iterdir())) == 2


@pytest.mark.parametrize("kind", ["csv", "xyz", "vtk", "pvd"])
def test_frames_that_all_particles_have_left_are_exported(frames: Frames, tmp_path: Path, kind: str) -> None:
    """Arrays with components, too, have no rows then."""
    first, last = frames(2)
    with Recorder(tmp_path / "traj") as recorder:
        recorder.write(first, 0)
        recorder.write(last._replace(arrays={name: array[:0] for name, array in last.arrays.items()}), 1)
    there = export(tmp_path, kind, tmp_path / f"out.{kind}")
    if kind == "csv":
        assert len(there.read_text().splitlines()) == 1 + len(first.arrays["mass"])
