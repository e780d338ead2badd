"""What figures of tracers count, and when."""

import numpy as np
import pytest

from ecume.analysis.dispersion import collector_efficiency
from ecume.errors import BadInput
from ecume.scenes.schema import from_plain, to_plain
from ecume.show.tracer_measures import before_exits, dispersion_over_time, efficiency, spreading, whole_bins
from ecume.show.tracers import heights, wall_hits
from ecume.trajectories.frame import Frame

SCENE = from_plain({
    "model": "tracers", "duration": 9.0, "frame_every": 1.0, "title": "Dye", "tank": {"high": [1.0, 1.0]},
    "particles": [{"radius": 1e-6, "density": 1000.0, "count": 40}],
})  # fmt: skip


def course(exits):
    """Ten frames of a pulse that spreads along x; from each particle's time on it is outside."""
    start, speed = np.zeros(len(exits)), np.linspace(-1.0, 1.0, len(exits))
    return [
        Frame(float(k), {
            "position": np.column_stack([start + 0.01 * k * speed, start]),
            "left": np.where(k >= np.asarray(exits), 0, -1),
        }, {"left_through_opening_0": 0.0}, {})
        for k in range(10)
    ]  # fmt: skip


def test_dispersion_ends_before_the_first_exit_of_a_pulse():
    frames = course([*[99] * 39, 6])
    kept, remark = before_exits(frames)
    assert (len(kept), remark) == (6, ", until the first exit")
    (axes,) = dispersion_over_time(frames, SCENE).axes
    assert axes.get_title("left").startswith("Dispersion coefficient, until the first exit")
    assert max(line.get_xdata().max() for line in axes.lines[:1]) < 6.0


def test_without_time_before_the_first_exit_the_title_says_who_is_counted():
    assert before_exits(course([99] * 40))[1] == ""
    assert before_exits(course([*[99] * 38, 1, 4]))[1] == ", of those that stay inside"


def test_where_particles_enter_the_time_is_that_since_entering():
    frames = course([3] * 20 + [6] * 20)
    frames = [frame._replace(arrays={name: array[: 20 + 2 * k] for name, array in frame.arrays.items()})
              for k, frame in enumerate(frames)]  # fmt: skip
    assert before_exits(frames) == (frames, ", since entering")
    for figure in (spreading, dispersion_over_time):
        (axes,) = figure(frames, SCENE).axes
        assert axes.get_title("left").split("\n")[0].endswith(", since entering: Dye")


@pytest.mark.parametrize("interval", [0.025, 1.0, 7.0])
def test_no_bin_of_residence_times_is_empty_by_its_width_alone(interval):
    times = interval * np.arange(3, 90)
    counts, _ = np.histogram(times, whole_bins(times, interval))
    assert counts.sum() == len(times)
    assert len(set(counts[:-1].tolist())) == 1, "as many multiples of the interval in each bin"


def test_an_efficiency_needs_something_that_holds_particles():
    with pytest.raises(BadInput, match="no wall and no obstacle holds particles"):
        efficiency(course([5] * 40), SCENE)


def test_each_species_has_its_own_efficiency():
    species = np.repeat([0, 1], 20)
    frames = [
        frame._replace(
            arrays=frame.arrays | {"species": species, "left": np.where(frame.arrays["left"] < 0, -1, species)},
            numbers={"left_through_opening_0": 0.0, "deposited_on_wall_4": 0.0},
        )
        for frame in course([5] * 20 + [7] * 20)
    ]
    scene = from_plain({**to_plain(SCENE), "particles": [to_plain(SCENE)["particles"][0] | {"name": n} for n in "ab"]})
    (axes,) = efficiency(frames, scene).axes
    through, held = (line.get_ydata() for line in axes.lines)
    np.testing.assert_array_equal(through, [np.nan] * 5 + [0.0] * 5)
    np.testing.assert_array_equal(held, [np.nan] * 7 + [1.0] * 3)
    assert collector_efficiency(frames[-1]).value == 0.5


def test_walls_without_collisions_are_not_drawn():
    frames = [frame._replace(numbers={"hits": 0.0, "hits_on_wall_0": 0.0}) for frame in course([99] * 40)]
    with pytest.raises(BadInput, match="no wall turned a particle back"):
        wall_hits(frames, SCENE)


def test_heights_below_zero_are_not_cut_off():
    frames = [frame._replace(arrays=frame.arrays | {"species": np.zeros(40, np.int64)}) for frame in course([99] * 40)]
    (axes,) = heights(frames, SCENE).axes
    assert axes.get_ylim()[0] == 0.0
    deep = [frame._replace(arrays=frame.arrays | {"position": frame.arrays["position"] - 0.5}) for frame in frames]
    (axes,) = heights(deep, SCENE).axes
    assert axes.get_ylim()[0] < axes.lines[0].get_ydata().min() < 0.0
