"""The steps of a duration that is no multiple of the time between frames."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ecume.scenes.common import Common

MOST_MORE = 1.5
"""Times as many steps that are taken to end exactly at the duration; otherwise a run ends at the nearest step."""


def last_step(scene: Common, per_frame: int, least: int = 1) -> int:
    """The step at which a run ends: the nearest to its duration, and at least so many past the last whole frame."""
    rest = scene.rest
    return scene.whole_frames * per_frame + (max(least, round(rest * per_frame)) if rest else 0)


def ending_on_a_step(scene: Common, per_frame: int) -> int:
    """At least so many steps per frame, with which the duration is a whole number of steps, too, if that is not much
    more. Nothing changes where the duration is a multiple of the time between frames.
    """
    multiple = scene.rest.denominator
    more = -(-per_frame // multiple) * multiple
    return more if more <= MOST_MORE * per_frame else per_frame
