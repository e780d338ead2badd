"""Rows of `ecume check` on expected events: whether a run is long enough, and its frames frequent enough, to show
them.
"""

from __future__ import annotations

import math

from ecume.models.model import Row
from ecume.units import with_prefix

SHOWN = 10
"""The number of frames before an event that show it."""


def event_row(name: str, time: float, run: tuple[float, float], remark: str, *, bound: bool = False) -> list[Row]:
    """The row of an event at a time (s), or at this time or later, in a run with a duration and an interval of frames
    (s). If these would not show it, the row suggests times of frames; it is empty for an event that is never expected.

    >>> event_row("first impact", 0.24, (6.0, 0.05), "of the block")
    [('first impact', 'after about 240 ms', 'duration 500 ms and frame_every 5 ms would show it')]
    >>> event_row("first impact", 9.0, (6.0, 0.05), "of the block", bound=True)
    [('first impact', 'not before 9 s', 'after the end of the run; duration 11 s shows it')]
    """
    if not 0.0 < time < math.inf:
        return []
    duration, frame_every = run
    value = f"{'not before' if bound else 'after about'} {_rounded(time, 2)}"
    if time > duration:
        return [(name, value, f"after the end of the run; duration {_rounded(1.2 * time, 2)} shows it")]
    if time < SHOWN * frame_every:
        frames, long = _rounded(time / (5 * SHOWN), 1), _rounded(2.0 * time, 1)
        return [(name, value, f"{'' if bound else f'duration {long} and '}frame_every {frames} would show it")]
    return [(name, value, remark)]


def _rounded(time: float, digits: int) -> str:
    return with_prefix(float(f"{time:.{digits}g}"), "s")
