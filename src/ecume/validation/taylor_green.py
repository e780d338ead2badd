"""Vortices that fade, at two resolutions, beside the exact flow and what another package reaches."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume.laws.flows import taylor_green_decay, taylor_green_velocity
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume.validation.rows import Row, above, below, within
from ecume.validation.runner import case_scene, read_table

SIDES = (25, 50)
VISCOSITY = 0.01
RATE = taylor_green_decay(2.0 * math.pi, 2.0 * math.pi, VISCOSITY)


class Course(NamedTuple):
    """The time series by which a run is judged, relative to the exact flow."""

    time: Array
    error: Array
    """mean of the speeds' errors"""
    fastest: Array
    energy: Array
    volume: Array


def rows() -> list[Row]:
    """Compare both resolutions, then the finer one with the published one."""
    courses = {side: course(side) for side in SIDES}
    errors = [float(courses[side].error[1:].max()) for side in SIDES]
    coarse = [below(f"{SIDES[0]} a side: largest error", errors[0], 0.06)]
    return [*coarse, *of_the_finer(courses[SIDES[1]]), above("order of the largest error", order(errors), 1.0)]


def of_the_finer(found: Course) -> list[Row]:
    """Compare the finer run with the exact flow and with PySPH."""
    swing = float(np.abs(found.fastest - 1.0).max())
    name = f"{SIDES[1]} a side"
    return [
        below(f"{name}: largest error", float(found.error[1:].max()), 0.03),
        below(f"{name}: largest speed over the exact one, off by", swing, 0.02),
        within(f"{name}: energy at the end over the exact one", float(found.energy[-1]), 1.0, 0.04),
        within(f"{name}: volume at the end", float(found.volume[-1]), 1.0, 0.002),
        *beside_published(found),
    ]


def beside_published(found: Course) -> list[Row]:
    """Compare our error at the nearest frame with the published one."""
    return [
        below(
            f"below PySPH's {case['scheme']}: error at t = {case['time']}",
            float(found.error[np.argmin(np.abs(found.time - float(case["time"])))]),
            float(case["error"]),
        )
        for case in read_table("taylor_green")
    ]


def course(side: int) -> Course:
    """One run."""
    scene = case_scene("taylor_green", [f"spacing={1.0 / side!r}"])
    return Course(*np.array([judged(frame) for frame in simulate(scene)]).T)


def judged(frame: Frame) -> tuple[float, ...]:
    """One instant."""
    faded = math.exp(-RATE * frame.time)
    x, y = 2.0 * math.pi * frame.arrays["position"].T
    exact = faded * np.hypot(taylor_green_velocity(x, y, 1.0), taylor_green_velocity(y, x, -1.0))
    speed = np.hypot(*frame.arrays["velocity"].T)
    error = float(np.abs(speed - exact).mean() / exact.mean())
    numbers = frame.numbers
    return (
        frame.time,
        error,
        float(speed.max()) / faded,
        numbers["kinetic_energy"] / (0.25 * faded**2),
        numbers["volume"],
    )


def order(errors: list[float]) -> float:
    """The order of convergence when the spacing is halved."""
    return math.log2(errors[0] / errors[1])
