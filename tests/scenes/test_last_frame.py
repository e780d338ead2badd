"""Durations that are no multiple of the time between frames."""

import itertools
import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ecume.models.step_counts import MOST_MORE, ending_on_a_step, last_step
from ecume.scenes.common import Common

DECIMALS = st.builds(lambda digits, power: float(f"{digits}e{power}"), st.integers(1, 9999), st.integers(-9, 3))
PER_FRAME = st.integers(1, 5000)


@st.composite
def scenes(draw):
    """A time between frames, and a duration of one to a thousand of these."""
    every = draw(DECIMALS)
    times = draw(st.one_of(st.integers(1, 1000), st.floats(1.0, 1000.0)))
    duration = float(f"{every * times:.9g}") if isinstance(times, float) else float(f"{every * times:.15g}")
    return Common(model="floating", duration=max(duration, every), frame_every=every)


@given(scenes())
def test_frames_are_due_at_ascending_decimal_times_up_to_the_duration(scene):
    times = [scene.frame_time(number) for number in range(scene.frames + 1)]
    assert (times[0], times[-1]) == (0.0, scene.duration)
    assert all(before < after for before, after in itertools.pairwise(times))
    assert all(after - before <= scene.frame_every * (1 + 1e-6) for before, after in itertools.pairwise(times))
    # Decimals that the scene has are all that a time has.
    for number, time in enumerate(times[:-1]):
        assert Fraction(repr(time)) == pytest.approx(number * Fraction(repr(scene.frame_every)), rel=1e-15)


@given(scenes(), PER_FRAME)
def test_a_run_ends_at_the_step_nearest_to_its_duration(scene, per_frame):
    steps = ending_on_a_step(scene, per_frame)
    assert per_frame <= steps <= MOST_MORE * per_frame
    step = scene.frame_every / steps
    end = last_step(scene, steps)
    assert scene.whole_frames * steps + (scene.rest > 0) <= end <= scene.frames * steps
    assert abs(end * step - scene.duration) <= max(0.5, 1.0 - scene.rest * steps) * step * (1 + 1e-6)
    if scene.rest.denominator <= per_frame / 3:
        assert math.isclose(end * step, scene.duration, rel_tol=1e-9)


@given(DECIMALS, st.integers(1, 1000), PER_FRAME)
def test_multiples_stay_as_they_are(every, times, per_frame):
    scene = Common(model="floating", duration=every * times, frame_every=every)
    assert (scene.frames, scene.rest) == (times, 0)
    assert ending_on_a_step(scene, per_frame) == per_frame
    assert last_step(scene, per_frame) == times * per_frame


def test_times_have_no_float_noise():
    scene = Common(model="floating", duration=0.5, frame_every=0.14)
    assert [scene.frame_time(number) for number in range(5)] == [0.0, 0.14, 0.28, 0.42, 0.5]
    assert 3 * 0.14 != 0.42
