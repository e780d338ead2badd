"""Affine deformations have no residual, and deviations from them are found."""

import numpy as np
import pytest

from ecume.analysis.boxes import Box, wrapped
from ecume.analysis.rearrangements import local_deformation, nonaffine_displacement, nonaffine_velocity
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame

BOX = Box(np.array([9.0, 7.0]), 0.2)


def frame_of(position, box=None, time=0.0):
    numbers = {}
    if box is not None:
        numbers = {"box_width": box.sides[0], "box_height": box.sides[1], "strain": box.strain}
        position = wrapped(position, box)
    return Frame(time, {"position": position}, numbers, {})


def deformed(rest=0.0, strain=0.35, scale=1.1, drift=(0.0, 0.0)):
    """Random particles, the same particles in a box that is sheared and enlarged, and the deviations from this
    deformation.
    """
    start = np.random.default_rng(2).uniform(size=(70, 2)) * BOX.sides
    end = Box(scale * BOX.sides, strain)
    moved = start @ (end.tilt @ np.linalg.inv(BOX.tilt)).T + rest + np.array(drift)
    return frame_of(start, BOX), frame_of(moved, end, time=2.0)


def test_an_even_deformation_of_a_box_leaves_nothing():
    before, after = deformed(drift=(3.1, -2.0))
    assert nonaffine_displacement(before, after) == pytest.approx(np.zeros((70, 2)), abs=1e-12)
    local = local_deformation(before, after, 2.5)
    assert local.rest == pytest.approx(np.zeros(70), abs=1e-20)
    wanted = 1.1 * np.array([[1.0, 0.35 - 0.2], [0.0, 1.0]])
    assert local.gradient == pytest.approx(np.broadcast_to(wanted, (70, 2, 2)))


def test_what_departs_from_an_even_deformation_is_found():
    rest = np.random.default_rng(5).normal(scale=0.1, size=(70, 2))
    before, after = deformed(rest)
    assert nonaffine_displacement(before, after) == pytest.approx(rest - rest.mean(axis=0))
    assert nonaffine_velocity(before, after) == pytest.approx((rest - rest.mean(axis=0)) / 2.0)


def test_one_that_jumps_stands_out_by_the_square_of_its_jump():
    rest = np.zeros((70, 2))
    rest[11] = 0.3, 0.4
    local = local_deformation(*deformed(rest), 2.0)
    assert np.argmax(local.rest) == 11
    assert 0.1 * 0.25 < local.rest[11] < 0.25
    assert np.median(local.rest) < 0.05 * local.rest[11]


def test_the_rest_does_not_depend_on_how_all_turn():
    start = np.random.default_rng(3).uniform(size=(50, 3)) * 5.0
    moved = start + np.random.default_rng(4).normal(scale=0.1, size=start.shape)
    turn = np.linalg.qr(np.random.default_rng(6).normal(size=(3, 3)))[0]
    one = local_deformation(frame_of(start), frame_of(moved), 2.5)
    other = local_deformation(frame_of(start), frame_of(moved @ turn.T), 2.5)
    assert other.rest == pytest.approx(one.rest, nan_ok=True)
    assert other.gradient == pytest.approx(turn @ one.gradient, nan_ok=True)


def test_too_few_neighbors_have_no_deformation():
    frame = frame_of(np.array([[0.0, 0.0], [1.0, 0.0], [9.0, 9.0], [9.5, 9.0], [9.0, 9.5]]))
    found = local_deformation(frame, frame, 1.2)
    assert found.neighbors.tolist() == [1, 1, 2, 2, 2]
    assert np.isnan(found.rest).tolist() == [True, True, False, False, False]


def test_what_cannot_be_compared_is_refused():
    before, after = deformed()
    with pytest.raises(BadInput, match="periodic box"):
        nonaffine_displacement(frame_of(np.zeros((2, 2))), frame_of(np.zeros((2, 2))))
    with pytest.raises(BadInput, match="takes time"):
        nonaffine_velocity(before, before)
    with pytest.raises(BadInput, match="different particles"):
        local_deformation(before, frame_of(np.zeros((2, 2))), 1.0)
    assert after.time == 2.0
