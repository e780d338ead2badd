"""The start of dense packings under stress with and without permeation, over the height of the packing.

`python docs/studies/permeation_sizes.py` compresses packings of 30 to 120 frictional spheres between an undrained
bottom and a drained top by a pressure, loads them with a fifth of it and with a shear stress, and writes
`recorded-heights.csv` beside this file; some hours. Runs that end with an error are omitted.
"""

from __future__ import annotations

import csv
import math
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ecume._quick import folder_of, parser_of, sized
from ecume.errors import Diverged
from ecume.scenes.soft import SoftScene
from ecume.simulation import simulate
from ecume.units import Array
from ecume_validation.permeation import STARTED, unhindered
from ecume_validation.runner import case_scene

RECORDED = Path(__file__).parent / "recorded-heights.csv"
WRITTEN = folder_of(RECORDED.parent) / RECORDED.name
LOOSE = 0.7
"""The volume fraction before the compression."""
DIAMETER, WIDTH = 2.4e-3, 12e-3
"""m: the mean diameter, and the period along the walls."""
MODULUS, PREPARED = 2e5, 0.5
"""Pa, and N/m: five times the pressure of the wall"""
SPHERES = sized((30, 60, 120), (30,))
SEEDS = sized((1, 2, 3), (1,))
LONGEST = sized(100.0, 0.2)
"""s: the duration of the runs."""
FIELDS = ("spheres", "seed", "height", "fraction", "permeation", "upper", "lower", "suction", "rise", "until")


class Start(NamedTuple):
    """The start of a packing under stress."""

    height: float
    """of the wall at time 0, over the mean diameter"""
    fraction: float
    """the volume fraction of the middle half at time 0"""
    upper: float
    """s: when the upper half is sheared by `STARTED`; infinite where it is not"""
    lower: float
    """s: the same of the lower half"""
    suction: float
    """the lowest pore pressure at the undrained bottom until both halves have started, over the pressure of the wall"""
    rise: float
    """by which the wall has risen then, over the height at time 0"""
    until: float
    """s: when both have started, or the run ended"""


def recorded() -> list[dict[str, float]]:
    """The rows of the last study."""
    with RECORDED.open(newline="", encoding="utf-8") as table:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(table)]


def scene_of(spheres: int, seed: int) -> SoftScene:
    """A packing five diameters wide, compressed by more than the pressure under which it starts."""
    changes = [f"seed={seed}", f"cell.volume_fraction={LOOSE}", f"duration={LONGEST}", "cell.minimum_gap=2e-5"]
    changes += [f"preparation.pressure={PREPARED}", "preparation.rate=0.05", "preparation.relaxed=0.05"]
    for species in range(2):
        changes += [f"particles[{species}].count={spheres // 2}", f"particles[{species}].modulus={MODULUS}"]
    scene = case_scene("permeation", [*changes, f"cell.size=[{WIDTH}, {19.6e-3 * spheres / 40}]"], name="start")
    assert isinstance(scene, SoftScene)  # noqa: S101  # that of this case is
    return scene


def start_of(scene: SoftScene) -> Start:
    """Integrate until both halves of a packing have started."""
    pressure = max(wall.pressure or 0.0 for wall in scene.walls)
    first: Array | None = None
    started, suction, height, fraction, risen, until = [math.inf, math.inf], 0.0, 0.0, 0.0, 0.0, 0.0
    radius = np.repeat(
        [species.radius for species in scene.particles], [species.count or 0 for species in scene.particles]
    )
    for frame in simulate(scene):
        position = frame.arrays["position"] + frame.arrays["image"] * [frame.numbers["box_width"], 0.0]
        if first is None:
            first, height = position, frame.numbers["top_y"]
            fraction = middle_fraction(position[:, 1], radius, height)
        risen, until = frame.numbers["top_y"] / height - 1.0, frame.time
        suction = min(suction, frame.numbers.get("pore_pressure_bottom", 0.0) / pressure)
        for half in range(2):
            if started[half] == math.inf and strain_of(first, position, half) > STARTED:
                started[half] = frame.time
        if max(started) < math.inf:
            break
    return Start(height / DIAMETER, fraction, started[0], started[1], abs(suction), risen, until)


def middle_fraction(height: Array, radius: Array, top: float) -> float:
    """The volume fraction of discs in the middle half of a packing."""
    rows = np.linspace(0.25 * top, 0.75 * top, 400)
    chord = 2.0 * np.sqrt(np.maximum(radius**2 - (rows[:, None] - height) ** 2, 0.0))
    return float(chord.sum(axis=1).mean() / WIDTH)


def filling_time(height: Array) -> Array:
    """The time (s) in which a suction as large as the pressure draws in 0.02 of the volume through the height, which is
    given in mean diameters; 1 Pa s and 0.1 N/m in a layer as high as the mean diameter.
    """
    return 12.0 * height**2 * 1.0 * DIAMETER / 0.1


def strain_of(first: Array, position: Array, half: int) -> float:
    """The strain of the upper (0) or lower (1) half of a packing: the slope of displacements along x over heights."""
    height = first[:, 1]
    inside = (height >= np.median(height)) == (half == 0)
    return float(np.polyfit(height[inside], (position - first)[inside, 0], 1)[0])


def main() -> None:
    """Run all and write the table."""
    cases = [(spheres, seed) for seed in SEEDS for spheres in SPHERES]
    with WRITTEN.open("w", newline="", encoding="utf-8") as opened:
        table = csv.DictWriter(opened, FIELDS, lineterminator="\n")
        table.writeheader()
        for case in cases:
            with suppress(Diverged):
                table.writerows(rows_of(*case))
            opened.flush()


def rows_of(spheres: int, seed: int) -> list[dict[str, str]]:
    """The rows of one packing with and without permeation."""
    scene = scene_of(spheres, seed)
    found = []
    for permeation, one in ((1, scene), (0, unhindered(scene))):
        assert isinstance(one, SoftScene)  # noqa: S101  # as above
        begun = start_of(one)
        row = (spheres, seed, *begun[:2], permeation, *begun[2:])
        found.append({name: f"{value:.4g}" for name, value in zip(FIELDS, row, strict=True)})
    return found


if __name__ == "__main__":
    parser_of(__doc__).parse_args()
    main()
