"""The start of dense packings under stress with and without permeation, over the height of the packing.

`python docs/studies/permeation_sizes.py` loads packings of 30 and 60 frictional spheres between an undrained bottom and
a drained top with a pressure and a shear stress, and writes `recorded-heights.csv` beside this file; some minutes.
"""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ecume._quick import folder_of, parser_of, sized
from ecume.scenes.soft import SoftScene
from ecume.simulation import simulate
from ecume.units import Array
from ecume_validation.permeation import STARTED, unhindered
from ecume_validation.runner import case_scene

RECORDED = Path(__file__).parent / "recorded-heights.csv"
WRITTEN = folder_of(RECORDED.parent) / RECORDED.name
FRACTION = 0.77
"""The volume fraction at the start."""
DIAMETER = 2.4e-3
"""m: the mean one"""
SPHERES = sized((30, 60), (30,))
SEEDS = sized((1, 2, 3), (1,))
LONGEST = sized(16.0, 0.2)
"""s: the duration of the runs."""
FIELDS = ("spheres", "height", "seed", "permeation", "upper", "lower", "suction")


class Start(NamedTuple):
    """The start of a packing under stress."""

    upper: float
    """s: when the upper half is sheared by `STARTED`; infinite where it is not"""
    lower: float
    """s: the same of the lower half"""
    suction: float
    """the lowest pore pressure at the undrained bottom until the lower half starts, over the pressure of the wall"""


def recorded() -> list[dict[str, float]]:
    """The rows of the last study."""
    with RECORDED.open(newline="", encoding="utf-8") as table:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(table)]


def scene_of(spheres: int, seed: int) -> SoftScene:
    """A packing five diameters wide."""
    changes = [f"seed={seed}", f"cell.volume_fraction={FRACTION}", f"duration={LONGEST}"]
    changes += [f"particles[{species}].count={spheres // 2}" for species in range(2)]
    scene = case_scene("permeation", [*changes, f"cell.size=[12e-3, {19.6e-3 * spheres / 40}]"], name="start")
    assert isinstance(scene, SoftScene)  # noqa: S101  # that of this case is
    return scene


def start_of(scene: SoftScene) -> Start:
    """Integrate until both halves of a packing have started."""
    pressure = max(wall.pressure or 0.0 for wall in scene.walls)
    first: Array | None = None
    started, suction = [math.inf, math.inf], 0.0
    for frame in simulate(scene):
        position = frame.arrays["position"] + frame.arrays["image"] * [frame.numbers["box_width"], 0.0]
        first = position if first is None else first
        suction = min(suction, frame.numbers.get("pore_pressure_bottom", 0.0) / pressure)
        for half in range(2):
            if started[half] == math.inf and strain_of(first, position, half) > STARTED:
                started[half] = frame.time
        if max(started) < math.inf:
            break
    return Start(started[0], started[1], abs(suction))


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
            table.writerows(rows_of(*case))
            opened.flush()


def rows_of(spheres: int, seed: int) -> list[dict[str, str]]:
    """The rows of one packing with and without permeation."""
    scene, height = scene_of(spheres, seed), HEIGHT * spheres
    found = []
    for permeation, one in ((1, scene), (0, unhindered(scene))):
        assert isinstance(one, SoftScene)  # noqa: S101  # as above
        row = (spheres, height, seed, permeation, *start_of(one))
        found.append({name: f"{value:.4g}" for name, value in zip(FIELDS, row, strict=True)})
    return found


HEIGHT = math.pi / 4.0 * (2.0e-3**2 + 2.8e-3**2) / 2.0 / FRACTION / 12e-3 / DIAMETER
"""The height of the packing over the mean diameter, for each sphere."""


if __name__ == "__main__":
    parser_of(__doc__).parse_args()
    main()
