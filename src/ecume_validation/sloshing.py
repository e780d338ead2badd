"""A tank with a small oscillation: the rise of the surface at its walls, compared with the series of potential flow."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecume.analysis.gauges import water_level
from ecume.laws.water_waves import BaseExcitation, Tank, sloshing_height
from ecume.scenes.sph import SphScene
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume_validation.runner import Row, above, below, sph_scene, within

DEEP = (16, 32)
"""Particles per depth."""
MOST_ERROR = {16: 0.08, 32: 0.04}
"""Limits of the root mean square difference, over that of the series."""
SETTLED = 5.0
"""The time after which the initial disorder no longer affects the gauges."""
REACH = 4.0
"""The range of a gauge, in spacings."""


class Rise(NamedTuple):
    """Half of the difference of the surface heights at the left and the right wall over time."""

    times: Array
    computed: Array
    series: Array
    hits: float
    """collisions with the wall guard"""


def rows() -> list[Row]:
    """Compare both resolutions, and their order of convergence."""
    runs = {deep: rise(deep) for deep in DEEP}
    coarse, fine = (error(runs[deep]) for deep in DEEP)
    return [
        *(row for deep, run in runs.items() for row in rows_of(run, deep)),
        above("order of convergence of the rise", math.log2(coarse / fine), 0.7),
    ]


def rows_of(run: Rise, deep: int) -> list[Row]:
    """Rows on one run."""
    ours, theirs = (float(np.abs(rise[run.times >= SETTLED]).max()) for rise in (run.computed, run.series))
    return [
        below(f"{deep} deep: rise at the wall, error over the series", error(run), MOST_ERROR[deep]),
        within(f"{deep} deep: highest rise at the wall, over H", ours, theirs, MOST_ERROR[deep] * theirs),
        within(f"{deep} deep: hits of the guard", run.hits, 0.0, 0.0),
    ]


def error(run: Rise) -> float:
    """The root mean square difference over that of the series, after the initial relaxation."""
    late = run.times >= SETTLED
    return float(np.sqrt(np.mean((run.computed - run.series)[late] ** 2) / np.mean(run.series[late] ** 2)))


def rise(deep: int, changes: Sequence[str] = ()) -> Rise:
    """Run the scene with this number of particles per depth."""
    scene = sph_scene("sloshing", [f"spacing={1.0 / deep!r}", *changes])
    frames = [(frame.time, _difference(frame, scene), frame.numbers["guard_hits"]) for frame in simulate(scene)]
    times, computed, hits = (np.array(column) for column in zip(*frames, strict=True))
    return Rise(times, computed, series(times, scene), float(hits[-1]))


def _difference(frame: Frame, scene: SphScene) -> float:
    """Half of the level difference. Half of the surroundings of a gauge in a wall is outside, so that the level is
    twice its value.
    """
    left, right = water_level(frame, np.array([scene.tank.low[0], scene.tank.high[0]]), REACH * scene.spacing)
    return float(left - right)


def series(times: Array, scene: SphScene) -> Array:
    """The heights from potential flow at those times."""
    assert scene.base_excitation is not None  # noqa: S101  # the case's is
    assert scene.base_excitation.amplitude is not None  # noqa: S101
    assert scene.base_excitation.frequency is not None  # noqa: S101
    length, gravity = scene.tank.high[0] - scene.tank.low[0], -(scene.gravity or (0.0, -1.0))[1]
    tank = Tank(length, scene.fluid[0].high[1], gravity, scene.liquid.viscosity / scene.liquid.density)  # type: ignore[index,operator]
    excitation = BaseExcitation(
        scene.base_excitation.amplitude[0], 2.0 * math.pi * scene.base_excitation.frequency, scene.base_excitation.phase
    )
    return np.array([sloshing_height(0.0, time, tank, excitation) for time in times])
