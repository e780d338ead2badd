"""Series read each frame once and keep its place in time."""

import numpy as np
import pytest

from ecume.analysis.series import number, series, times, tracks
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame


def frames():
    for n in range(4):
        yield Frame(0.5 * n, {"position": np.full((3, 2), float(n))}, {"kinetic_energy": 10.0 - n}, {})


def test_measures_are_rows_and_instants_are_columns():
    values = series(frames(), number("kinetic_energy"), lambda frame: frame.time)
    assert values.tolist() == [[10.0, 9.0, 8.0, 7.0], [0.0, 0.5, 1.0, 1.5]]
    assert times(frames()).tolist() == [0.0, 0.5, 1.0, 1.5]


def test_no_frames_give_empty_rows():
    assert series([], number("kinetic_energy"), number("other")).shape == (2, 0)


def test_a_number_that_is_not_there_is_refused_with_those_that_are():
    with pytest.raises(BadInput, match="'heat'; they have kinetic_energy"):
        series(frames(), number("heat"))


def test_tracks_keep_each_float_in_its_column():
    assert tracks(frames()).shape == (4, 3, 2)
    assert tracks(frames())[2, 1].tolist() == [2.0, 2.0]
