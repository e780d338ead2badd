"""A run of liquid opens in other programs as a series in time."""

import numpy as np
import pytest

import ecume
from ecume.run import run
from ecume.trajectories.exports import export

from .scenes import tank


@pytest.mark.compiled
def test_vtk_reads_a_run_of_liquid_as_a_series_with_pressure_velocity_and_density(tmp_path):
    hdf = pytest.importorskip("vtkmodules.vtkIOHDF")
    support = pytest.importorskip("vtkmodules.util.numpy_support")
    run(tank().replace("duration", 0.2), tmp_path / "run")
    reader = hdf.vtkHDFReader()
    reader.SetFileName(str(export(tmp_path / "run", "vtk", tmp_path / "run.vtkhdf")))
    reader.UpdateInformation()
    with ecume.open_trajectory(tmp_path / "run") as trajectory:
        assert reader.GetNumberOfSteps() == len(trajectory) == 3
        for number, frame in enumerate(trajectory):
            reader.SetStep(number)
            reader.Update()
            assert reader.GetTimeValue() == pytest.approx(frame.time)
            data = reader.GetOutputDataObject(0).GetPointData()
            for name in ("pressure", "density"):
                np.testing.assert_array_equal(support.vtk_to_numpy(data.GetArray(name)), frame.arrays[name])
            velocity = support.vtk_to_numpy(data.GetArray("velocity"))
            assert velocity.shape[1] == 3, "an arrow has three components"
            np.testing.assert_array_equal(velocity[:, :2], frame.arrays["velocity"])
