"""A tank whose liquid starts disordered and has to come to rest: pressure, level, speed, and slow settling."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from ecume.laws.hydrostatics import column_height, column_pressure
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume_validation.runner import Row, below, sph_scene, within

MOST_ERROR, LARGEST_ERROR, MOST_SHIFT, MOST_SPEED = 0.01, 0.015, 0.003, 2e-4
"""Limits in units of rho g H, of H and of sqrt(g H)."""
MOST_CREEP = 1e-4
"""The limit of the settling in the last quarter of the time, over H."""
MOST_LASTING = 0.85
"""The limit of the settling in a quarter over that in the quarter before: it has to decay."""
SOUND_SPEED = 10.0


class Rest(NamedTuple):
    """The measurements of a frame, in units of rho g H, of H and of sqrt(g H)."""

    error: float
    """root mean square of the pressure minus rho_0 g (H - y)"""
    largest: float
    from_column: float
    """root mean square of the pressure minus that of Tait's column of the same mass"""
    speed: float
    """root mean square"""
    center: float
    """height of the center of mass"""
    hits: float
    """collisions with the guard behind the walls, until then"""
    there: int
    """particles inside the tank"""


def rows() -> list[Row]:
    """Compare 1e5 steps with 16 and with 32 particles per depth, and a run of twice the duration."""
    coarse, fine = run(["duration=568.0"]), run(["spacing=0.03125", "duration=284.0"])
    half, middle = len(coarse) // 2 + 1, len(fine) // 2 + 1
    return [
        *rows_of("16 deep, 1e5 steps", coarse[:half]),
        *rows_of("16 deep, 2e5 steps", coarse),
        below("16 deep, 2e5 steps: center's creep in the last quarter, over H", creep(coarse), MOST_CREEP),
        *rows_of("32 deep, 1e5 steps", fine[:middle]),
        *rows_of("32 deep, 2e5 steps", fine),
        below("32 deep, 2e5 steps: creep in the last quarter, over that before", lasting(fine), MOST_LASTING),
    ]


def run(changes: Sequence[str]) -> list[Rest]:
    """The measurements of each frame of the changed scene."""
    scene = sph_scene("tank", changes)
    return [rest(frame) for frame in simulate(scene)]


def rest(frame: Frame) -> Rest:
    """The measurements of a frame, with depth, density and gravity equal to 1."""
    height, pressure = frame.arrays["position"][:, 1], frame.arrays["pressure"]
    error = pressure - (1.0 - height)
    inside = (frame.arrays["position"] > 0.0).all(axis=1) & (frame.arrays["position"][:, 0] < 1.0)
    return Rest(
        error=_root_mean_square(error),
        largest=float(np.abs(error).max()),
        from_column=_root_mean_square(pressure - column(height, float(frame.arrays["mass"].sum()))),
        speed=_root_mean_square(frame.arrays["velocity"]) * np.sqrt(2.0),
        center=frame.numbers["center_y"],
        hits=frame.numbers["guard_hits"],
        there=int(np.sum(inside)),
    )


def column(height: Array, load: float) -> Array:
    """The pressure at heights in a column of Tait's liquid with this mass per floor area."""
    top = column_height(load, 1.0, 1.0, SOUND_SPEED)
    return np.array([column_pressure(top - y, 1.0, 1.0, SOUND_SPEED) for y in height])


def rows_of(name: str, frames: Sequence[Rest]) -> list[Row]:
    """Rows on a run; all except the counts are means over its last quarter."""
    late, last = last_quarter(frames), frames[-1]
    shift = abs(_mean(frame.center for frame in late) - frames[0].center)
    return [
        below(f"{name}: pressure's error, over rho g H", _mean(frame.error for frame in late), MOST_ERROR),
        below(f"{name}: from Tait's column, over rho g H", _mean(frame.from_column for frame in late), MOST_ERROR),
        below(f"{name}: pressure's largest error, over rho g H", _mean(f.largest for f in late), LARGEST_ERROR),
        below(f"{name}: center's shift, over H", shift, MOST_SHIFT),
        below(f"{name}: speed, over sqrt(g H)", _mean(frame.speed for frame in late), MOST_SPEED),
        within(f"{name}: hits of the guard", last.hits, 0.0, 0.0),
        within(f"{name}: particles lost", frames[0].there - last.there, 0.0, 0.0),
    ]


def creep(frames: Sequence[Rest]) -> float:
    """The displacement of the center of mass in the last quarter."""
    late = last_quarter(frames)
    return abs(late[-1].center - late[0].center)


def lasting(frames: Sequence[Rest]) -> float:
    """The displacement of the center of mass in the last quarter, over that in the quarter before."""
    quarter = len(last_quarter(frames))
    return creep(frames) / abs(frames[-quarter - 1].center - frames[-2 * quarter].center)


def last_quarter(frames: Sequence[Rest]) -> Sequence[Rest]:
    """The frames of the last quarter of the time."""
    return frames[-max(1, len(frames) // 4) :]


def _mean(numbers: Iterable[float]) -> float:
    return float(np.mean(list(numbers)))


def _root_mean_square(numbers: Array) -> float:
    return float(np.sqrt(np.mean(numbers**2)))
