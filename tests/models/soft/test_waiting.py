"""Rates held until the stress is stationary end where it is, and a resumed run ends them at the same frames."""

import itertools
import math

import numpy as np
import pytest

from ecume.engine.stationarity import FEWEST
from ecume.errors import SceneError
from ecume.models.soft.protocol import drive_at, protocol_of
from ecume.models.soft.waiting import RUNNING, STATIONARY, UNSETTLED, make_waiting, rate_at, shortened, take
from ecume.scenes.soft import RateStepsSpec, StageSpec
from ecume.simulation import moments

from .test_packings import packing

EVERY = 0.01


def waiting_protocol(*rates, strain=2.0, within=0.05, before=(), after=()):
    steps = RateStepsSpec(rates=rates, strain=strain, stationary_within=within)
    return protocol_of([*before, StageSpec(time=1.0, rate_steps=steps), *after])


def frames_until_all_ended(protocol, stress_of):
    """What the rates reached with frames of this shear stress, a function of the rate and the frame."""
    waiting, present = make_waiting(protocol, EVERY), protocol
    for frame in range(1, 2000):
        time = 1.0 + frame * EVERY
        stress = stress_of(drive_at(present, time - 0.5 * EVERY).rate, frame)
        take(waiting, present, time, (stress, 1.0 + 0.1 * math.sin(1.7 * frame)))
        present = shortened(protocol, waiting)
        if not (waiting.reached == RUNNING).any():
            break
    return waiting, present


def noisy(rate, frame):
    return rate * (1.0 + 0.1 * math.sin(2.4 * frame))


def test_a_stationary_rate_ends_early_and_the_next_one_begins_at_the_same_strain():
    protocol = waiting_protocol(2.0, 1.0, -2.0, before=(StageSpec(time=0.0, shear_rate=0.5),))
    waiting, present = frames_until_all_ended(protocol, noisy)
    assert waiting.reached.tolist() == [STATIONARY] * 3
    assert waiting.ends == pytest.approx(1.0 + EVERY * FEWEST * np.array([1, 3, 4]))
    # The slower rate is tested at every second frame: at the same strains as the faster ones.
    assert [drive_at(present, time).rate for time in (0.5, 1.4, 1.9, 2.6, 3.5)] == [0.5, 2.0, 1.0, -2.0, 0.0]
    assert [rate_at(present, time) for time in (1.0, 1.5, 1.51, 2.5, 3.5, 9.0)] == [0, 1, 2, 2, 0, 0]
    for place, time in itertools.islice(enumerate(present.times), 1, None):
        assert drive_at(present, time, place).strain == pytest.approx(drive_at(present, time, place - 1).strain)
    assert drive_at(present, 9.0).strain == pytest.approx(0.5 + 1.0 + 1.0 - 1.0)
    assert not waiting.stresses.any()


@pytest.mark.parametrize("stress", [lambda rate, frame: 0.01 * frame, lambda rate, frame: 0.0])
def test_a_rate_without_a_stationary_stress_is_held_for_the_largest_strain(stress):
    protocol = waiting_protocol(2.0, -1.0)
    waiting, present = frames_until_all_ended(protocol, stress)
    assert waiting.reached.tolist() == [UNSETTLED] * 2
    assert waiting.ends == pytest.approx([2.0, 4.0])
    assert present is not protocol
    assert all(np.array_equal(one, other) for one, other in zip(present, protocol, strict=True))


def test_the_strain_is_held_until_the_next_moment_which_begins_as_planned():
    after = (StageSpec(time=2.0, shear_rate=-3.0, height_rate=0.1), StageSpec(time=3.0, scale=0.9, shear_rate=0.0))
    protocol = waiting_protocol(2.0, before=(StageSpec(time=0.0, height_rate=0.2),), after=after)
    _, present = frames_until_all_ended(protocol, noisy)
    assert present.times == pytest.approx([0.0, 1.0, 1.5, 2.0, 3.0])
    assert [drive_at(present, time).rate for time in (1.2, 1.7, 2.5, 3.5)] == [2.0, 0.0, -3.0, 0.0]
    assert [drive_at(present, time).strain for time in (1.5, 2.0, 3.0)] == pytest.approx([1.0, 1.0, -2.0])
    assert drive_at(present, 1.7).height == pytest.approx(drive_at(protocol, 1.7).height)
    assert drive_at(present, 2.5).scale == pytest.approx(0.95)


def waiting_packing(**more):
    steps = {"rates": [0.4, -0.2], "strain": 8.0, "stationary_within": 1.0}
    given = {"count": 4, "filled": 0.65, "duration": 62.0, "frame_every": 0.2}
    return packing(**given, protocol=[{"time": 2.0, "rate_steps": steps}], **more)


def run_past_first_rate(scene, state=None):
    """The numbers of all frames up to the fifth after the first rate has ended, and the states at each."""
    found, states = [], []
    for moment in moments(scene, state=state):
        if moment.frame is not None:
            found.append(moment.frame.numbers)
            states.append(type(moment.state)(*(np.array(part) for part in moment.state)))
            if [numbers["rates_left"] for numbers in found[-6:-5]] == [1.0]:
                break
    return found, states


@pytest.mark.long
@pytest.mark.compiled
def test_a_resumed_run_ends_its_rates_at_the_same_frames():
    whole, states = run_past_first_rate(waiting_packing())
    ended = len(whole) - 6
    assert [numbers["rates_left"] for numbers in whole[ended - 1 : ended + 1]] == [2.0, 1.0]
    assert 10 + FEWEST <= ended < 110  # before its largest strain
    assert whole[-1]["strain_rate"] == pytest.approx(-0.2)
    resumed, _ = run_past_first_rate(waiting_packing(), state=states[ended - 10])
    assert repr(resumed) == repr(whole[ended - 10 :])


def test_rates_with_too_few_frames_to_be_found_stationary_are_refused():
    with pytest.raises(SceneError) as caught:
        packing(duration=5.0, frame_every=0.1, protocol=[
            {"time": 0.0, "rate_steps": {"rates": [1.0, 0.5], "strain": 1.0, "stationary_within": 0.05}}])  # fmt: skip
    assert "1 /s has 10 in a strain of 1; expected 50 or more: a frame_every of 0.02 s" in str(caught.value)
    with pytest.raises(SceneError, match=r"1 /s has 37 in a strain of 1; .* a frame_every of 0.01 s"):
        packing(duration=5.0, frame_every=1.0 / 75.0, protocol=[  # 50 frames at 1.5 /s, and every second one at 1 /s
            {"time": 0.0, "rate_steps": {"rates": [1.5, 1.0], "strain": 1.0, "stationary_within": 0.05}}])  # fmt: skip
    with pytest.raises(SceneError) as caught:
        packing(duration=5.0, frame_every=0.01, protocol=[
            {"time": 0.0, "rate_steps": {"rates": [1.0], "strain": 1.0, "stationary_within": 0.05}},
            {"time": 2.0, "strain": 3.0}])  # fmt: skip
    assert "is unknown after rates with stationary_within" in str(caught.value)
