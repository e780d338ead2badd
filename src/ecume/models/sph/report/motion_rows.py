"""Rows of `ecume check` on what moves the whole tank: base excitation and roll."""

from __future__ import annotations

import itertools
import math

import numpy as np

from ecume.models.model import Row
from ecume.models.sph.boundaries.rigid_bodies import drive_at
from ecume.models.sph.parameters import Drive, Parameters, Roll
from ecume.scenes.sph import SphScene
from ecume.scenes.sph.motions import tried
from ecume.units import Array, with_prefix


def motion_rows(scene: SphScene, parameters: Parameters) -> list[Row]:
    """The largest acceleration of the base excitation; the largest angle of the roll, and what it does to the liquid
    that is farthest from its pivot. Empty without them.
    """
    rows = []
    if parameters.base_excitation is not None:
        largest = float(np.sqrt((_over_run(parameters.base_excitation, scene)[0] ** 2).sum(axis=1)).max())
        rows.append(("base excitation", with_prefix(largest, "m/s^2", 3), "the largest acceleration"))
    if parameters.roll is not None:
        value, rate, second = (np.abs(each).max() for each in _over_run(parameters.roll.drive, scene))
        arm = max(_distance_from_axis(corner, parameters.roll) for corner in itertools.product(*_corners(scene)))
        angle, pushed = f"{math.degrees(value):.3g}°", with_prefix(float(second) * arm, "m/s^2", 3)
        pulled = with_prefix(float(rate) ** 2 * arm, "m/s^2", 3)
        rows.append(("roll", angle, f"at most; {pushed} of Euler's and {pulled} of the centrifugal acceleration"))
    return rows


def _over_run(drive: Drive, scene: SphScene) -> tuple[Array, Array, Array]:
    """The values of a drive at many times of a run, and their first and second derivatives, (T, n) each."""
    value, rate, second = zip(*(drive_at(drive, time) for time in tried(scene.duration)), strict=True)
    return np.array(value), np.array(rate), np.array(second)


def _corners(scene: SphScene) -> list[tuple[float, float]]:
    """The ends of the tank along x, y and z (m)."""
    ends = [*zip(scene.tank.low, scene.tank.high, strict=True)]
    return [*ends, *[(0.0, 0.0)] * (3 - len(ends))]


def _distance_from_axis(corner: tuple[float, ...], roll: Roll) -> float:
    """The distance of a point from the axis of the roll (m)."""
    return float(np.linalg.norm(np.cross(roll.axis, np.array(corner) - roll.pivot)))
