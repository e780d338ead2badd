"""How long a packing holds a stress before it flows: delays after a step of stress."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ecume.analysis.series import number, series, times
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame
from ecume.units import Array, Number, Time

YIELDED = 0.1
"""Of strain since the step: well beyond what surfaces give way, well before steady flow."""


def yield_delay(frames: Sequence[Frame], step: Time, strain: Number = YIELDED) -> Time:
    """How long after a step of stress a packing has been strained by so much, either way; infinite where it never is.

    >>> frames = [Frame(t, {}, {"strain": 0.05 * max(t - 2.0, 0.0)}, {}) for t in (0.0, 1.0, 2.0, 3.0, 6.0)]
    >>> yield_delay(frames, step=1.0)
    3.0
    """
    time, crept = creep(frames, step)
    beyond = np.flatnonzero(crept >= strain)
    if not len(beyond):
        return math.inf
    last = int(beyond[0])
    return float(np.interp(strain, crept[last - 1 : last + 1], time[last - 1 : last + 1]))


def least_rate(frames: Sequence[Frame], step: Time, strain: Number = YIELDED) -> Time:
    """When, after a step of stress, creep is the slowest before so much strain is reached: there slowing down ends.

    Half-way between the two frames around it; infinite where the strain is never reached.
    """
    time, crept = creep(frames, step)
    beyond = np.flatnonzero(crept >= strain)
    if not len(beyond):
        return math.inf
    end = int(beyond[0]) + 1
    slowest = int(np.argmin(np.diff(crept[:end]) / np.diff(time[:end])))
    return float(0.5 * (time[slowest] + time[slowest + 1]))


def creep(frames: Sequence[Frame], step: Time) -> tuple[Array, Array]:
    """The time since a step of stress, and the strain since then in the sense in which it ends."""
    now, strain = times(frames), *series(frames, number("strain"))
    after = now >= step * (1.0 - 1e-9)
    if after.sum() < 2:
        raise BadInput(f"wanted two frames or more from the step at {step:g} s on; came {int(after.sum())}")
    crept = strain[after] - strain[after][0]
    return now[after] - step, math.copysign(1.0, crept[-1]) * crept
