"""Series read each frame once and in order."""

import numpy as np
import pytest

from ecume.analysis.series import PathWarning, number, series, times, tracks
from ecume.analysis.structure import mean_square_displacement
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


def in_a_cell(place, image=None, velocity=0.0):
    """A frame of one particle in a cell of 1 m by 1 m."""
    arrays = {"position": np.array([[place, 0.5]])}
    if image is not None:
        arrays["image"] = np.array([[image, 0]])
    return Frame(0.0, arrays, {"box_width": 1.0, "box_height": 1.0}, {})


def test_image_numbers_lead_paths_across_borders_however_far_apart_frames_are():
    shown = [in_a_cell(0.9, 0), in_a_cell(0.6, 1), in_a_cell(0.3, -4)]
    assert tracks(shown)[:, 0, 0] == pytest.approx([0.9, 1.6, -3.7])
    assert tracks(shown, [0, 2])[:, 0, 0] == pytest.approx([0.9, -3.7])


def test_paths_without_image_numbers_are_followed_through_frames_that_are_not_kept():
    shown = [in_a_cell(0.3 * n % 1.0) for n in range(11)]
    assert tracks(shown, [0, 5, 10])[:, 0, 0] == pytest.approx([0.0, 1.5, 3.0])


def test_a_move_that_may_be_more_than_half_a_side_is_a_warning():
    with pytest.warns(PathWarning, match=r"0\.45 of a side"):
        tracks([in_a_cell(0.0), in_a_cell(0.45)])


def test_image_numbers_of_a_sheared_box_count_its_tilted_vectors():
    arrays = {"position": np.array([[0.2, 0.1]]), "image": np.array([[1, 2]])}
    box = {"box_width": 1.0, "box_height": 0.5, "box_tilt": 0.3}
    assert tracks([Frame(0.0, arrays, box, {})])[0, 0] == pytest.approx([0.2 + 1.0 + 2 * 0.3, 0.1 + 2 * 0.5])


def test_particles_count_from_entering_to_leaving():
    first = Frame(0.0, {"position": np.array([[0.0, 0.0]]), "left": np.array([-1])}, {}, {})
    then = Frame(1.0, {"position": np.array([[1.0, 0.0], [0.0, 5.0]]), "left": np.array([-1, -1])}, {}, {})
    last = Frame(2.0, {"position": np.array([[1.5, 0.0], [1.0, 5.0]]), "left": np.array([0, -1])}, {}, {})
    found = tracks([first, then, last])
    assert found.shape == (3, 2, 2)
    assert np.isnan(found[..., 0]).tolist() == [[False, True], [False, False], [True, False]]
    square = mean_square_displacement(found, [0, 1, 2])
    assert square[:2].tolist() == [0.0, 1.0]
    assert np.isnan(square[2])


def test_frames_that_lose_particles_without_their_numbers_are_refused():
    shown = [Frame(0.0, {"position": np.zeros((n, 2))}, {}, {}) for n in (2, 3)]
    with pytest.raises(BadInput, match="which particle is which"):
        tracks(shown)
