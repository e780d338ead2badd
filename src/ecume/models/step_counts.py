"""The last step of a run whose duration is not a multiple of the time between frames, and the steps at which numbers
are sampled between frames.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

from ecume.errors import Fault, SceneError

if TYPE_CHECKING:
    from ecume.models.model import Model
    from ecume.scenes.common import Common

MOST_MORE = 1.5
"""The largest factor of the number of steps with which a run ends exactly at the duration; otherwise it ends at the
nearest step.
"""
BEFORE = -1
"""The position of the last sample before the first one."""


def last_step(scene: Common, per_frame: int, least: int = 1) -> int:
    """The step at which a run ends: the nearest to its duration, and not earlier than a given number of steps after the
    last whole frame.
    """
    rest = scene.rest
    return scene.whole_frames * per_frame + (max(least, round(rest * per_frame)) if rest else 0)


def ending_on_a_step(scene: Common, per_frame: int) -> int:
    """The number of steps per frame, at least the given one, with which the duration is also a whole number of steps,
    if this requires not many more. Unchanged if the duration is a multiple of the time between frames.
    """
    multiple = scene.rest.denominator
    more = -(-per_frame // multiple) * multiple
    return more if more <= MOST_MORE * per_frame else per_frame


class SampleClock(NamedTuple):
    """The clock of samples, which are due at the first step at or after each multiple of an interval.

    >>> clock = SampleClock(Fraction(5, 2))
    >>> [step for step in range(11) if clock.is_due(step, step - 1)], clock.next_after(3), clock.next_after(5)
    ([0, 3, 5, 8, 10], 5, 8)
    """

    interval: Fraction

    def is_due(self, step: int, last: int) -> bool:
        """Whether a multiple of the interval is after the last sample and not after this step."""
        return step // self.interval > last // self.interval

    def next_after(self, step: int) -> int:
        """The first step after this one at which a sample is due."""
        return math.ceil((step // self.interval + 1) * self.interval)


def sample_clock(scene: Common, model: Model, per_frame: int) -> SampleClock | None:
    """The clock of a scene; None without samples. Raises SceneError for steps that cannot be counted."""
    asked = scene.output.samples
    if asked is None:
        return None
    if asked.every is not None:
        return SampleClock(Fraction(repr(asked.every)) / Fraction(repr(scene.frame_every)) * per_frame)
    if model.adaptive:
        message = "the time steps of this model adapt, so their number is no measure of time; use output.samples.every"
        raise SceneError([Fault("output.samples.every_steps", message)])
    return SampleClock(Fraction(asked.every_steps or 1))
