"""Start-up, relaxation and recovery of sheared packings."""

import math

import numpy as np
import pytest

from ecume.analysis.transients import recovery, relaxation, start_up
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame


def frames_of(times, **numbers):
    return [Frame(t, {}, {name: value(t) for name, value in numbers.items()}, {}) for t in times]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_surfaces_recover_at_once_counts_as_recovered(sign):
    """A stress from 2 s to 12 s: an elastic strain of 0.2 in addition to a creep at 0.1/s; frames at jumps show the
    state after them.
    """
    frames = frames_of(
        np.arange(0.0, 25.0), strain=lambda t: sign * (0.2 * (2.0 <= t < 12.0) + 0.1 * (min(max(t, 2.0), 12.0) - 2.0))
    )
    found = recovery(frames, 2.0, 12.0)
    assert (found.crept, found.recovered[0], found.part) == pytest.approx((1.2, 0.2, 0.2 / 1.2))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_peak_is_found_whichever_way_a_flow_goes_and_compared_with_the_steady_stress(sign):
    noise = np.random.default_rng(1)
    frames = frames_of(
        np.linspace(0.0, 8.0, 401),
        strain=lambda t: 3.0 + sign * t,
        shear_stress=lambda t: (
            sign * (2.0 - 2.0 * math.exp(-9 * t) + 3.0 * t * math.exp(-3 * t) + 0.02 * noise.normal())
        ),
    )
    found = start_up(frames)
    assert found.peak_strain == pytest.approx(0.4, abs=0.1)
    assert found.overshoot == pytest.approx(0.15, abs=0.04)
    assert found.steady.mean.value == pytest.approx(2.0, rel=0.01)


def test_a_stress_that_still_falls_has_a_rate_and_one_that_is_left_has_none():
    now = np.linspace(0.0, 9.0, 181)
    falling = relaxation(frames_of(now, shear_stress=lambda t: -math.exp(-t)))
    left = relaxation(frames_of(now, shear_stress=lambda t: 1.0 + math.exp(-9.0 * t)))
    assert (falling.rate, falling.half_time) == pytest.approx((1.0, math.log(2.0)), rel=2e-3)
    assert (left.rate, left.left) == pytest.approx((0.0, 0.5), abs=1e-6)


def test_too_few_frames_are_refused():
    with pytest.raises(BadInput, match="expected 8 frames or more from 0 s to inf s; got 3"):
        relaxation(frames_of(np.arange(3.0), shear_stress=lambda t: 1.0))
