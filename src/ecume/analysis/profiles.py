"""Velocities along lines, and where a run's energy goes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ecume.analysis.gauges import linear_values_at, points_along
from ecume.analysis.series import number, series, times
from ecume.models.invariants import INJECTED
from ecume.trajectories.frame import Frame
from ecume.units import Array, Length


class Profile(NamedTuple):
    """Values along a line."""

    along: Array
    """(n,) the distance from the line's start (m)"""
    points: Array
    """(n, d)"""
    values: Array
    """(n, ...), not a number where there is no liquid"""


def profile_along(
    frame: Frame, name: str, ends: tuple[Sequence[float], Sequence[float]], count: int, reach: Length
) -> Profile:
    """An array of the frame at points from one end of a line to the other; exact for what grows linearly."""
    points = points_along(*ends, count)
    return Profile(np.linalg.norm(points - points[0], axis=1), points, linear_values_at(frame, name, points, reach))


def velocity_profile(frame: Frame, ends: tuple[Sequence[float], Sequence[float]], count: int, reach: Length) -> Profile:
    """The velocity along a line, (n, d) in m/s."""
    return profile_along(frame, "velocity", ends, count, reach)


ENERGIES = ("J", "J/m")
"""Units of energies: of a 2D tank they are per meter of depth."""


def energy_budget(frames: Iterable[Frame]) -> Mapping[str, Array]:
    """Each kind of energy over time (J; J/m in 2D), and the energy lost since the first frame.

    Keys: `time` (s), every energy of the frames, `lost`, and `dissipated`: that, and what work was injected.
    """
    kept = list(frames)
    names = [name for name, unit in kept[0].units.items() if unit in ENERGIES]
    curves = dict(zip(names, series(kept, *map(number, names)), strict=True))
    lost, work = curves["total_energy"][0] - curves["total_energy"], curves.get(INJECTED, np.zeros(len(kept)))
    return {"time": times(kept), **curves, "lost": lost, "dissipated": lost + work - work[0]}
