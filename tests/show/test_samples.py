"""The figure of numbers that were sampled between frames."""

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.show.curves import samples, samples_of, shown_numbers
from ecume.trajectories.reader import Trajectory
from ecume.trajectories.segments import Recorder

STATISTICS = ("{}{}", "{}_min{}", "{}_max{}", "{}_error{}")
HEADING = [
    each.format(name, unit) for name, unit in (("kinetic_energy", " [J]"), ("clusters", "")) for each in STATISTICS
]
BLOCKS = f"""step,time [s],samples,{",".join(HEADING)}
9,0.1,10,2e-9,1e-9,4e-9,1e-10,5.5,5.0,6.0,0.1
19,0.2,10,3e-9,nan,6e-9,nan,4.5,4.0,5.0,0.1
29,0.3,10,4e-9,3e-9,5e-9,1e-10,4.0,4.0,4.0,0.0
"""


@pytest.fixture
def trajectory(tmp_path, frames):
    """A trajectory on disk, without samples as yet."""
    with Recorder(tmp_path / "run" / "traj") as recorder:
        for number, frame in enumerate(frames):
            recorder.write(frame, number)
    return Trajectory(tmp_path / "run" / "traj")


def test_blocks_are_curves_with_their_range(trajectory, scene):
    (trajectory.directory / "samples.csv").write_text(BLOCKS)
    drawn = samples(trajectory, scene)
    assert [axes.get_ylabel() for axes in drawn.axes] == ["kinetic energy\n(nJ)", "clusters"]
    assert drawn.axes[0].get_title(loc="left").startswith("Averages of 10 samples")
    (curve,) = drawn.axes[0].lines
    np.testing.assert_allclose(curve.get_xydata(), [[0.1, 2.0], [0.2, 3.0], [0.3, 4.0]])
    (band,) = drawn.axes[1].collections
    np.testing.assert_allclose(band.get_datalim(drawn.axes[1].transData).intervaly, [4.0, 6.0])


def test_single_samples_have_no_range(trajectory, scene):
    (trajectory.directory / "samples.csv").write_text("step,time [s],clusters\n0,0.0,6.0\n1,0.1,5.0\n")
    drawn = samples(trajectory, scene)
    assert drawn.axes[0].get_title(loc="left").startswith("Samples")
    assert len(drawn.axes[0].lines) == 1
    assert len(drawn.axes[0].collections) == 0


@pytest.mark.parametrize("text", [None, "step,time [s],clusters\n0,0.0,6.0\n"])
def test_a_run_without_samples_has_no_such_figure(trajectory, scene, frames, text):
    if text is not None:
        (trajectory.directory / "samples.csv").write_text(text)
    for nothing in (trajectory, frames):
        with pytest.raises(BadInput, match=r"no two rows of samples; write a table \[output\.samples\]"):
            samples(nothing, scene)


def test_of_many_numbers_the_main_ones_are_shown(trajectory):
    names = [f"number_{number}" for number in range(20)]
    cells = ",".join(["0"] * 20)
    rows = f"step,time [s],{','.join(names)}\n0,0.0,{cells}\n1,0.1,{cells}\n"
    (trajectory.directory / "samples.csv").write_text(rows)
    found = samples_of(trajectory)
    assert shown_numbers(found, ("number_7", "number_3")) == ["number_3", "number_7"]
    assert shown_numbers(found, ("front",)) == names[:8]
