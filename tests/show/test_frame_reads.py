"""Figures read each frame of a run twice at most: a long run is a lazy sequence, whose frames are read from files."""

from collections.abc import Sequence

import pytest

import ecume
from ecume.errors import BadInput
from ecume.scenes.schema import from_plain
from ecume.show.figures import FIGURES

MOST = 2
"""Reads of a frame on average; one more of each end, whose units and ranges figures look up."""
ENDS = 8
NEAR = [[1e-3, 1e-3], [3.01e-3, 1e-3], [1e-3, 3.01e-3], [3.01e-3, 3.01e-3]]
APART = [[0, 0], [3e-3, 0], [0, 4e-3]]
RUN = {"duration": 0.2, "frame_every": 0.01}
SCENES = {
    "floating": {
        **RUN, "liquid": {"viscosity": 0.01},
        "particles": [{"radius": 1e-3, "density": 600.0, "contact_angle": 1.2, "positions": APART}],
    },
    "sph": {
        "duration": 0.1, "frame_every": 0.005, "spacing": 0.25, "liquid": {"maximum_speed": 3.0},
        "tank": {"high": [1.0, 1.0], "top": {"kind": "open"}}, "fluid": [{"low": [0.0, 0.0], "high": [0.5, 0.5]}],
        "gauges": [{"name": "wet", "position": [0.25, 0.0], "quantities": ["pressure", "level"]}],
    },
    "soft": {
        **RUN, "liquid": {"viscosity": 1.0}, "cell": {"size": [4.02e-3, 4.02e-3]},
        "particles": [{"radius": 1e-3, "modulus": 1e4, "positions": NEAR}],
        "protocol": [{"time": 0.0, "shear_rate": 1.0}],
    },
    "tracers": {
        **RUN, "tank": {"high": [0.1, 0.1]},
        "particles": [{"radius": 1e-4, "density": 2000.0, "positions": [[0.05, 0.05], [0.02, 0.05]]}],
    },
}  # fmt: skip


class Counted(Sequence):
    """Frames as a trajectory has them, which counts how often they are read."""

    def __init__(self, frames):
        self.frames, self.reads = frames, 0

    def __len__(self):
        return len(self.frames)

    def __getitem__(self, place):
        found = self.frames[place]
        self.reads += len(found) if isinstance(place, slice) else 1
        return Counted(found) if isinstance(place, slice) else found


@pytest.fixture(scope="module")
def runs():
    """The frames of each model, computed once."""
    found = {}
    for model, plain in SCENES.items():
        scene = from_plain({"model": model, **plain})
        found[model] = scene, list(ecume.simulate(scene))
    scene, frames = found["soft"]
    # Figures of flows are for packings under compression, which takes longer to make.
    found["soft"] = scene, [one._replace(numbers={**one.numbers, "normal_stress": 1.0}) for one in frames]
    return found


@pytest.mark.parametrize(("model", "name"), [(model, name) for model in SCENES for name in FIGURES[model]])
def test_a_figure_reads_each_frame_a_few_times_at_most(runs, model, name):
    scene, frames = runs[model]
    counted = Counted(frames)
    try:
        FIGURES[model][name](counted, scene)
    except BadInput:
        pytest.skip("this run has nothing of the kind")
    assert 0 < counted.reads <= MOST * len(frames) + ENDS
