"""Delays of given creep curves."""

import math

import numpy as np
import pytest

from ecume.analysis.rheology import least_rate, yield_delay
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame


def creeping(step=5.0, sign=1.0, offset=0.3):
    """Frames at rest until a step, then with a strain of t/100 + (t/20)^3 / 10 - ..., slowest at t = 6."""
    frames = []
    for time in np.arange(0.0, 40.0, 0.25):
        since = max(time - step, 0.0)
        strain = 0.002 * since + 1e-4 * ((since - 6.0) ** 3 + 216.0)
        frames.append(Frame(time, {}, {"strain": offset + sign * strain}, {}))
    return frames


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("wanted", [0.03, 0.1, 0.2])
def test_a_delay_ends_where_the_strain_is_reached_whichever_way_and_from_wherever(sign, wanted):
    delay = yield_delay(creeping(sign=sign), 5.0, wanted)
    assert 0.002 * delay + 1e-4 * ((delay - 6.0) ** 3 + 216.0) == pytest.approx(wanted, rel=0.02)


def test_the_slowest_creep_is_found_between_the_first_answer_and_the_flow():
    assert least_rate(creeping(), 5.0, 0.2) == pytest.approx(6.0, abs=0.26)


def test_who_never_yields_has_an_infinite_delay():
    assert yield_delay(creeping(), 5.0, strain=1e3) == math.inf
    assert least_rate(creeping(), 5.0, strain=1e3) == math.inf


def test_a_step_after_the_last_frame_is_refused():
    with pytest.raises(BadInput, match="two frames"):
        yield_delay(creeping(), 50.0)
