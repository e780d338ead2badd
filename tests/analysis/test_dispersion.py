"""Spreading, residence, breakthrough, concentration and deposition, on made-up frames with known answers."""

import numpy as np
import pytest

from ecume.analysis import dispersion
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame

DICE = np.random.default_rng(4)


def frame(time, position, left=None, **numbers):
    left = np.full(len(position), -1) if left is None else np.asarray(left)
    return Frame(time, {"position": np.asarray(position, float), "left": left}, numbers, {})


def spreading(drift=2.0, rate=0.5, count=4000):
    """Random walks with a drift along x and different rates along both axes."""
    position, found = np.zeros((count, 2)), []
    for k in range(11):
        found.append(frame(0.1 * k, position.copy()))
        position += [[drift * 0.1, 0.0]] + DICE.normal(size=(count, 2)) * np.sqrt(2 * 0.1 * np.array([rate, 0.1]))
    return found


def test_displacements_are_those_of_a_random_walk_with_a_drift():
    frames = spreading()
    with_drift = dispersion.displacements(frames)
    alone = dispersion.displacements(frames, without_drift=True)
    assert with_drift.value[-1, 0] == pytest.approx(4.0 + 1.0, abs=5 * with_drift.error[-1, 0])
    assert alone.value[-1] == pytest.approx([1.0, 0.2], abs=5 * alone.error[-1].max())
    assert 0.005 < alone.error[-1, 0] < 0.06


def test_the_dispersion_coefficient_is_half_the_growth_of_the_variance():
    course = dispersion.dispersion_coefficient(spreading())
    assert len(course.time) == 10
    assert course.value.mean() == pytest.approx(0.5, abs=5 * course.error.mean() / np.sqrt(10))


def test_residence_and_breakthrough_count_those_that_left():
    start = np.zeros((4, 2))
    numbers = {"left_through_opening_0": 0.0, "left_through_opening_1": 0.0}
    frames = [
        frame(0.0, start, **numbers),
        frame(1.0, start, [0, -1, -1, 1], **numbers),
        frame(2.0, start, [0, 0, -1, 1], **numbers),
    ]
    stayed = dispersion.residence_times(frames)
    assert sorted(stayed.times) == [0.5, 0.5, 1.5]
    assert stayed.remaining == 1
    assert dispersion.breakthrough(frames, 0).value.tolist() == [0.0, 0.25, 0.5]
    with pytest.raises(BadInput, match="got opening 2; the run has 2"):
        dispersion.breakthrough(frames, 2)


def test_particles_that_enter_between_frames_have_residence_times_without_a_bias():
    """One particle stays for 1.2 s, one enters and leaves between two frames, and one left earlier."""
    frames = [
        frame(0.0, np.zeros((1, 2)), [0]),
        frame(1.0, np.zeros((2, 2)), [0, -1]),
        frame(2.0, np.zeros((3, 2)), [0, 1, 1]),
    ]
    stayed = dispersion.residence_times(frames)
    assert sorted(stayed.times) == [0.0, 1.0]
    assert stayed.remaining == 0


def test_concentration_counts_only_particles_inside():
    one = frame(0.0, [[0.1, 0.0], [0.2, 0.0], [0.7, 0.0], [0.8, 0.0]], [-1, -1, -1, 0])
    course = dispersion.concentration([one], np.array([0.0, 0.5, 1.0]))
    assert course.value.tolist() == [[4.0, 2.0]]
    assert course.error[0] == pytest.approx([2 * np.sqrt(2.0), 2.0])


def test_deposits_are_counted_by_wall_and_place():
    numbers = {"left_through_opening_0": 1.0, "deposited_on_wall_1": 2.0, "deposited_on_wall_3": 1.0}
    one = frame(0.0, [[0.1, 0.0], [0.2, 0.0], [0.7, 0.0], [0.8, 0.0]], [1, 2, 1, 0], **numbers)
    assert dispersion.deposited(one, 1).tolist() == [True, False, True, False]
    assert dispersion.deposition(one, np.array([0.0, 0.5, 1.0]), wall=1).density.tolist() == [2.0, 2.0]
    assert dispersion.collector_efficiency(one) == pytest.approx((0.75, np.sqrt(0.75 * 0.25 / 4)))
    with pytest.raises(BadInput, match=r"wall 0 does not hold particles; those that do: \[1, 3\]"):
        dispersion.deposited(one, 0)


def test_a_dataset_is_read_back_with_its_conventions(tmp_path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    frames = [frame(0.0, [[0.1, 0.2], [0.3, 0.4]]), frame(1.0, [[0.5, 0.6], [0.7, 0.8]], [-1, 0])]
    dispersion.dataset(frames).to_netcdf(tmp_path / "paths.nc", engine="h5netcdf")
    with xarray.open_dataset(tmp_path / "paths.nc") as found:
        assert (found.time.values[:, 1] == np.datetime64("1970-01-01T00:00:01")).all()
        assert found.attrs["featureType"] == "trajectory"
        assert found.trajectory.attrs["cf_role"] == "trajectory_id"
        assert found.x.values == pytest.approx(np.array([[0.1, 0.5], [0.3, np.nan]]), nan_ok=True)
        assert found.y.attrs["units"] == "m"
        assert found["left"].values.tolist() == [[-1, -1], [-1, 0]]


def coming_and_going(count=600, speed=1.0, rate=0.02):
    """Frames of particles that enter one per frame, drift with noise and leave after ten frames."""
    entered, moved = np.arange(count) * 30 // count, np.zeros((count, 2))
    found = []
    for k in range(31):
        number = int((entered <= k).sum())
        left = np.where(k - entered[:number] > 10, 0, -1)
        found.append(frame(5.0 + 0.1 * k, moved[:number].copy(), left, left_through_opening_0=float((left == 0).sum())))
        moved[:number] += [0.1 * speed, 0.0] + DICE.normal(size=(number, 2)) * np.sqrt(2 * 0.1 * rate)
    return found


def test_displacements_of_particles_that_come_and_go_are_over_the_time_since_they_entered():
    frames = coming_and_going()
    course = dispersion.displacements(frames)
    assert course.time == pytest.approx(0.1 * np.arange(11)), "none is inside for longer"
    assert course.value[:, 0] == pytest.approx(course.time**2 + 0.04 * course.time, abs=6 * course.error[:, 0].max())
    alone = dispersion.displacements(frames, without_drift=True)
    assert alone.value[-1] == pytest.approx([0.04, 0.04], abs=5 * alone.error[-1].max())
    spread = dispersion.dispersion_coefficient(frames)
    assert spread.time == pytest.approx(0.1 * np.arange(10) + 0.05)
    assert spread.value.mean() == pytest.approx(0.02, abs=5 * spread.error.mean() / np.sqrt(10))


def test_frames_at_unequal_times_have_no_displacements_since_entering():
    frames = coming_and_going(60)
    with pytest.raises(BadInput, match="intervals between frames differ"):
        dispersion.displacements([*frames[:5], *frames[7:]])


def test_a_dataset_says_where_each_particle_is_and_keeps_those_on_walls():
    pytest.importorskip("xarray")
    numbers = {"left_through_opening_0": 1.0, "deposited_on_wall_3": 1.0}
    frames = [
        frame(0.0, [[0.1, 0.2]], **numbers),
        frame(1.0, [[0.5, 0.6], [0.7, 0.8], [0.2, 0.2]], [1, 0, -1], **numbers),
    ]
    found = dispersion.dataset(frames)
    assert found["left"].values.tolist() == [[-1, 1], [-2, 0], [-2, -1]]
    assert found["left"].attrs["flag_meanings"] == "not_yet_entered inside left_through_opening_0 on_wall_3"
    assert found["left"].attrs["flag_values"].tolist() == [-2, -1, 0, 1]
    assert found.x.values == pytest.approx(np.array([[0.1, 0.5], [np.nan, np.nan], [np.nan, 0.2]]), nan_ok=True)
