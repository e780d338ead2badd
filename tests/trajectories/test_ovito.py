"""OVITO shows what a run wrote: radii, colors, our quantities, times. Only where it is installed, a large package."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from some_frames import frame_at

from ecume.trajectories.exports import export
from ecume.trajectories.frame import Frame
from ecume.trajectories.segments import Recorder

io = pytest.importorskip("ovito.io")


def some(number: int) -> Frame:
    """A frame without integers that only 64 bits hold: extended XYZ is text, and OVITO reads 32."""
    frame = frame_at(number)
    return frame._replace(arrays={name: array for name, array in frame.arrays.items() if name != "neighbors"})


COLORS = ("#ff0000", "#00ff80", "#0000ff")


@pytest.fixture
def run(tmp_path: Path) -> Path:
    with Recorder(tmp_path / "run" / "traj", species=["a", "b", "c"], colors=COLORS) as recorder:
        for number, frame in enumerate(map(some, range(4))):
            recorder.write(frame, number)
    return tmp_path / "run"


def test_gsd_opens_with_radius_color_and_quantities(run: Path) -> None:
    pipeline = io.import_file(str(run / "traj" / "0000.gsd"))
    assert pipeline.source.num_frames == 4
    for number, frame in enumerate(map(some, range(4))):
        shown = pipeline.compute(number)
        particles, arrays = shown.particles, frame.arrays
        np.testing.assert_allclose(particles["Position"][:, :2], arrays["position"], rtol=1e-6)
        np.testing.assert_allclose(particles["Radius"], arrays["radius"], rtol=1e-6)
        np.testing.assert_array_equal(particles["radius"], arrays["radius"])
        shades = np.array([list(bytes.fromhex(color[1:])) for color in COLORS]) / 255.0
        np.testing.assert_allclose(particles["Color"], shades[arrays["species"]], atol=1e-6)
        assert [kind.name for kind in particles.particle_types.types] == ["a", "b", "c"]
        assert shown.attributes["kinetic_energy"] == frame.numbers["kinetic_energy"]
        assert shown.attributes["time"] == frame.time


def test_extended_xyz_opens_with_radius_and_time(run: Path, tmp_path: Path) -> None:
    pipeline = io.import_file(str(export(run, "xyz", tmp_path / "a.xyz")))
    assert pipeline.source.num_frames == 4
    for number, frame in enumerate(map(some, range(4))):
        shown = pipeline.compute(number)
        np.testing.assert_allclose(shown.particles["Position"][:, :2], frame.arrays["position"])
        np.testing.assert_allclose(shown.particles["Radius"], frame.arrays["radius"])
        assert shown.attributes["Time"] == frame.time
