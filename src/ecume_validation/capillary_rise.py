"""Liquid that rises between plates over time, beside the equation of Bosanquet."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from ecume.scenes.sph import SphScene
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume_validation.contact_lines import SLIP, line_friction
from ecume_validation.runner import Row, above, below, sph_scene, within

VISCOSITIES = (5, 15)
"""In mPa s: one with which the column overshoots its height a little, and one with which it creeps to it."""
MOST_ERROR = 0.05
"""The limit of the r.m.s. difference, over the rise."""


class Trough(NamedTuple):
    """The gap with the column, and what is connected to it; lengths in m."""

    gap: float
    """the width of the gap"""
    reservoir: float
    """the width of the reservoir"""
    passage: float
    """the length of the way below the plate, along its center line; it is as wide as the gap"""
    start: float
    """the height of the liquid above the lower edge of the plate, at the start"""
    drive: float
    """the tension times the cosine of the contact angle, over the density (m^3/s^2)"""
    viscosity: float
    """kinematic (m^2/s)"""
    gravity: float
    lines: float
    """the friction of the contact lines in the gap, over viscosity and speed"""


def rows() -> list[Row]:
    """Compare the rise of two liquids."""
    return [row for viscosity in VISCOSITIES for row in rows_of(f"{viscosity} mPa s", *rise(viscosity))]


def rise(viscosity: float) -> tuple[Trough, Array, Array]:
    """The trough of a run, its times, and the heights of its column."""
    scene = sph_scene("capillary_rise", [f"liquid.viscosity={viscosity} mPa*s"])
    seen = [(frame.time, column(frame, scene)) for frame in simulate(scene)]
    times, heights = np.array(seen).T
    return trough_of(scene), times, heights


def rows_of(name: str, trough: Trough, times: Array, heights: Array) -> list[Row]:
    """Rows on one run."""
    full, bare = height(trough, times), height(trough._replace(lines=0.0), times)
    rose = float(full[-1] - full[0])
    fastest, expected = (float(np.diff(smooth(h)).max() / np.diff(times).mean()) for h in (heights, full))
    return [
        below(f"{name}: height over time, r.m.s. difference over the rise", error(heights, full) / rose, MOST_ERROR),
        within(f"{name}: rise at the end (m)", float(heights[-1] - heights[0]), rose, MOST_ERROR * rose),
        within(f"{name}: fastest rise (m/s)", fastest, expected, 0.1 * expected),
        above(f"{name}: r.m.s. difference without friction at lines", error(heights, bare) / rose, MOST_ERROR),
    ]


def error(one: Array, other: Array) -> float:
    """The r.m.s. difference."""
    return float(np.sqrt(np.mean((one - other) ** 2)))


def smooth(heights: Array) -> Array:
    """Means over five frames: single particles step over the edge of the plate."""
    return np.convolve(heights, np.full(5, 0.2), mode="valid")


def trough_of(scene: SphScene) -> Trough:
    """The trough of the scene of the case."""
    (plate,), liquid = scene.obstacles, scene.liquid
    low, high = plate.low or (math.nan, math.nan), plate.high or (math.nan, math.nan)
    (pool,) = scene.fluid
    density, angle = liquid.density or math.nan, liquid.contact_angle or math.nan
    gap = low[0] - scene.tank.low[0]
    return Trough(
        gap=gap,
        reservoir=scene.tank.high[0] - high[0],
        passage=0.5 * low[1] + high[0] - 0.5 * gap,
        start=(pool.high or (math.nan, math.nan))[1] - low[1],
        drive=(liquid.surface_tension or math.nan) * math.cos(angle) / density,
        viscosity=(liquid.viscosity or math.nan) / density,
        gravity=-(scene.gravity or (math.nan, math.nan))[1],
        lines=2.0 * line_friction(angle, 0.5 * gap, SLIP * scene.spacing),
    )


def column(frame: Frame, scene: SphScene) -> float:
    """The volume of the liquid in the gap above the lower edge of the plate, over the width of the gap (m)."""
    (right, low), density = scene.obstacles[0].low or (math.nan, math.nan), scene.liquid.density or math.nan
    x, y = frame.arrays["position"].T
    return float(frame.arrays["mass"][(x < right) & (y > low)].sum() / density / right)


def height(trough: Trough, times: Array) -> Array:
    """The height h of the column over time, from rest: (h + l + k d/w) h'' + |h'| h'/2 + (12 nu (h + l)/d^2
    + 3 nu k d/w^3 + K nu/d) h' = 2 s/d - s/w - g (h - k), with the level k = h_0 - (h - h_0) d/w of the reservoir.

    d, l: width of the gap, length of the way to it; w: width of the reservoir, one of whose walls is wetted and not
    slippery; s: tension times cosine over density; K: friction of the contact lines. With l = w^-1 = K = g = 0 it is
    that of [bosanquet1923], apart from the half: the liquid outside is at rest.
    """
    d, w, nu = trough.gap, trough.reservoir, trough.viscosity

    def rates(_: float, state: Array) -> list[float]:
        h, speed = state
        level = trough.start - (h - trough.start) * d / w
        pull = trough.drive * (2.0 / d - 1.0 / w) - trough.gravity * (h - level)
        drag = 12.0 * nu * (h + trough.passage) / d**2 + 3.0 * nu * level * d / w**3 + trough.lines * nu / d
        return [speed, (pull - drag * speed - 0.5 * speed * abs(speed)) / (h + trough.passage + level * d / w)]

    found = solve_ivp(rates, (0.0, times[-1]), [trough.start, 0.0], "LSODA", times, rtol=1e-9, atol=1e-13)
    return np.asarray(found.y[0])
