"""The height of the surface as numbers."""

import dataclasses
import json
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.special import k0
from typer.testing import CliRunner

from ecume.cli import app
from ecume.errors import BadInput
from ecume.laws import meniscus
from ecume.models.floating.dishes import field_of
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import InteractionSpec
from ecume.scenes.schema import to_plain
from ecume.show.floating.heights import export_heights, height_field
from ecume.trajectories.segments import Recorder


@pytest.fixture
def run(tmp_path, scene, frames):
    """A run on disk of three frames."""
    with Recorder(tmp_path / "run" / "traj") as recorder:
        for number, frame in enumerate(frames[:3]):
            recorder.write(frame, number)
    (tmp_path / "run" / "resolved.json").write_text(json.dumps(to_plain(scene)))
    (tmp_path / "run" / "manifest.json").write_text('{"ecume": "0"}')
    return tmp_path / "run"


def test_heights_are_the_menisci_of_all_floats_and_of_the_dish(scene, frames):
    found, arrays = height_field(scene, frames[2], cells=41), frames[2].arrays
    liquid = liquid_of(scene)
    for row, column in ((20, 20), (3, 17), (38, 30), (0, 0)):
        x, y = found.x[column], found.y[row]
        wanted = meniscus.dish_height(min(np.hypot(x, y), 0.03), 0.03, 0.8, liquid)
        apart = np.maximum(np.hypot(*(arrays["position"] - [x, y]).T), arrays["radius"]) / liquid.capillary_length
        wanted -= np.sum(arrays["charge"] * k0(apart))
        assert found.height[row, column] == pytest.approx(wanted, rel=1e-6)


def test_floats_without_menisci_leave_the_surface_as_pictures_show_it(scene, frames):
    alone = dataclasses.replace(scene, interaction=InteractionSpec(law="none"))
    found = height_field(alone, frames[2], cells=20)
    assert np.array_equal(found.height, field_of(scene.dish, liquid_of(scene), found.x, found.y))


@pytest.mark.long
def test_the_surface_away_from_floats_obeys_the_linear_equation(scene, frames):
    open_scene = dataclasses.replace(scene, dish=None)
    found = height_field(open_scene, frames[0], cells=400)
    cell, h = found.x[1] - found.x[0], found.height
    bend = (h[1:-1, 2:] + h[1:-1, :-2] + h[2:, 1:-1] + h[:-2, 1:-1] - 4.0 * h[1:-1, 1:-1]) / cell**2
    x, y = np.meshgrid(found.x[1:-1], found.y[1:-1])
    near = np.min(np.hypot(*(np.stack([x, y], -1)[..., None, :] - frames[0].arrays["position"]).T), axis=0).T
    far = near > 5e-3  # nearer, differences of this grid are off by more
    length = liquid_of(scene).capillary_length
    assert far.sum() > 1000
    assert bend[far] == pytest.approx(h[1:-1, 1:-1][far] / length**2, rel=2e-3, abs=1e-4 * np.abs(h).max() / length**2)


def test_a_run_is_written_for_numpy_with_its_places_and_times(run, scene, frames, tmp_path):
    with np.load(export_heights(run, tmp_path / "h.npz", cells=30), allow_pickle=False) as archive:
        assert archive["height"].shape == (3, len(archive["y"]), len(archive["x"]))
        assert archive["time"].tolist() == [frame.time for frame in frames[:3]]
        second = height_field(scene, frames[1], cells=30)
        np.testing.assert_array_equal(archive["height"][1], second.height)
        np.testing.assert_array_equal(archive["x"], second.x)
        heights = archive["height"]
    np.testing.assert_array_equal(np.load(export_heights(run, tmp_path / "h.npy", cells=30)), heights)


def test_a_run_is_written_as_images_that_vtk_reads(run, scene, frames, tmp_path):
    xml = pytest.importorskip("vtkmodules.vtkIOXML")
    support = pytest.importorskip("vtkmodules.util.numpy_support")
    listed = export_heights(run, tmp_path / "h.pvd", cells=30)
    named = ElementTree.parse(listed).getroot().findall("Collection/DataSet")
    assert [float(entry.attrib["timestep"]) for entry in named] == [frame.time for frame in frames[:3]]
    reader = xml.vtkXMLImageDataReader()
    reader.SetFileName(str(tmp_path / named[1].attrib["file"]))
    reader.Update()
    shown, wanted = reader.GetOutput(), height_field(scene, frames[1], cells=30)
    assert shown.GetDimensions() == (len(wanted.x), len(wanted.y), 1)
    assert shown.GetPoint(0)[:2] == (wanted.x[0], wanted.y[0])
    assert shown.GetPoint(shown.GetNumberOfPoints() - 1)[:2] == pytest.approx((wanted.x[-1], wanted.y[-1]))
    heights = support.vtk_to_numpy(shown.GetPointData().GetArray("height"))
    np.testing.assert_array_equal(heights, wanted.height.ravel())


def test_the_command_writes_among_the_results(run):
    done = CliRunner().invoke(app, ["export", str(run), "--to", "heights"])
    assert done.exit_code == 0, done.output
    assert (run / "results" / "frames-heights.npz").is_file()


def test_what_has_no_surface_or_no_such_ending_is_refused(run, scene, frames, tmp_path):
    with pytest.raises(BadInput, match=r"\.npz, \.npy, \.pvd"):
        export_heights(run, tmp_path / "h.txt")
    with pytest.raises(BadInput, match="model 'floating'"):
        height_field(None, frames[0])
    with pytest.raises(BadInput, match="expected 1 or more"):
        height_field(scene, frames[0], cells=0)
