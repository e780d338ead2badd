"""Liquid that permeates packings: Terzaghi's consolidation, and the onset of flow of dense and loose packings under
stress.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ecume.laws.permeability import (
    consolidation_coefficient,
    degree_of_consolidation,
    excess_pressure,
    kozeny_carman,
)
from ecume.scenes.schema import Scene
from ecume.scenes.soft import SoftScene
from ecume.simulation import moments, simulate
from ecume.units import Array
from ecume_validation.runner import Row, above, below, case_scene, within

RADIUS, VISCOSITY, WIDTH, PRESSURE, MORE, STEP, ROWS = 1e-3, 1.0, 2.5e-3, 2e-3, 0.01, 20.0, 20
"""m, Pa s, m, N/m, the part by which the load grows, s when it does, and the spheres of `column.toml`."""
TIMES = (40.0, 80.0, 120.0, 160.0)
"""s"""
STARTED = 0.3
"""The strain at which a packing has started."""


def rows() -> list[Row]:
    """Compare both subjects."""
    return [*column(), *starts()]


def column() -> list[Row]:
    """Settlement and pore pressures of a column, over the final settlement and the added load."""
    frames = {frame.time: frame for frame in simulate(case_scene("permeation", name="column"))}
    height = frames[0.0].numbers["top_y"]
    coefficient, last = consolidation(height)
    found = []
    for time in TIMES:
        frame, since = frames[time], time - STEP
        settled = (height - frame.numbers["top_y"]) / last
        expected = degree_of_consolidation(height, since, coefficient)
        found.append(within(f"column: settlement at {time:g} s", settled, expected, 0.01))
        for name, pressure, depth in (
            ("bottom", frame.numbers["pore_pressure_bottom"], height),
            ("half of the height", half_pressure(frame.arrays["pore_pressure"]), 0.5 * height),
        ):
            expected = excess_pressure(depth, height, since, coefficient)
            computed = pressure / (MORE * PRESSURE)
            found.append(within(f"column: pore pressure at {name} at {time:g} s", computed, expected, 0.01))
    return found


def half_pressure(pressures: Array) -> float:
    """The pressure between the two spheres in the middle of the column."""
    return float(pressures[ROWS // 2 - 1 : ROWS // 2 + 1].mean())


def consolidation(height: float) -> tuple[float, float]:
    """The coefficient of consolidation (m^2/s) at the first load, and the final settlement (m) by the added load:
    Hertz's law F ~ d^(3/2) of contacts in series.
    """
    force, spacing = PRESSURE * WIDTH, height / ROWS
    stiffness = 1.5 * force / (2.0 * RADIUS - spacing)
    area = WIDTH * 2.0 * RADIUS
    fraction = 4.0 / 3.0 * math.pi * RADIUS**3 / (area * spacing)
    modulus = stiffness * spacing / area
    coefficient = consolidation_coefficient(kozeny_carman(fraction, 2.0 * RADIUS), modulus, VISCOSITY)
    return coefficient, MORE * force / stiffness * ROWS


def starts() -> list[Row]:
    """The delays of the onset of flow of a dense and of a loose packing, over those without permeation."""
    found = []
    for name, fraction in (("dense", 0.79), ("loose", 0.74)):
        scene = case_scene("permeation", [f"cell.volume_fraction={fraction}"], name="start")
        ratio = start_time(scene) / start_time(unhindered(scene))
        bound = above if name == "dense" else below
        found.append(
            bound(f"{name} packing: start over that without permeation", ratio, 5.0 if name == "dense" else 1.5)
        )
    return found


def unhindered(scene: Scene) -> Scene:
    """The same scene without permeation: the liquid flows without a pressure."""
    assert isinstance(scene, SoftScene)  # noqa: S101  # that of this case is
    walls = tuple(replace(wall, drained=None) for wall in scene.walls)
    return replace(scene, permeation=None, walls=walls)


def start_time(scene: Scene) -> float:
    """The time (s) at which a packing reaches the strain of a start, or the end of the run."""
    first: Array | None = None
    for moment in moments(scene):
        position = moment.state.position
        first = position.copy() if first is None else first
        if moment.frame is not None and sheared(first, position) > STARTED:
            return moment.frame.time
    return scene.duration


def sheared(first: Array, position: Array) -> float:
    """The displacement of the upper quarter of the spheres along x relative to the lower one, over their distance."""
    order, part = np.argsort(first[:, 1]), len(first) // 4
    lower, upper = order[:part], order[-part:]
    moved = (position - first)[:, 0]
    apart = first[upper, 1].mean() - first[lower, 1].mean()
    return float((moved[upper].mean() - moved[lower].mean()) / apart)
