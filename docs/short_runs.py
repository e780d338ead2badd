"""Runs of figures and clips with `--quick`: the same number of frames, at much shorter intervals."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

import ecume.simulation
from ecume.scenes.schema import Scene
from ecume.simulation import Moment, moments

LESS = 200
"""How many times shorter."""


def short_moments(scene: Scene, **given: Any) -> Iterator[Moment]:
    """The moments of a much shorter run; its frames state the times at which they were due."""
    every = scene.frame_every / LESS
    if step := getattr(getattr(scene, "integration", None), "time_step", None):
        every = step * max(1, round(every / step))
    short = copy.copy(scene)
    # Not checked: loadings and other events may lie beyond the end.
    object.__setattr__(short, "duration", scene.duration * every / scene.frame_every)
    object.__setattr__(short, "frame_every", every)
    due = 0
    for moment in moments(short, **given):
        if moment.frame is None:
            yield moment
        else:
            yield moment._replace(frame=moment.frame._replace(time=scene.frame_time(due)))
            due += 1


def shorten_runs() -> None:
    """Shorten every run of this process that is begun by `simulate`."""
    ecume.simulation.moments = short_moments
