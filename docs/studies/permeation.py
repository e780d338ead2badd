"""When packings of frictional spheres start to flow under stress: by their volume fraction and their height, with and
without permeation.

`python docs/studies/permeation.py` loads packings between an undrained bottom and a drained top with a pressure and a
shear stress, and writes `recorded-starts.csv` beside this file; some minutes.
"""

from __future__ import annotations

import csv
import itertools
from pathlib import Path

from ecume._quick import folder_of, parser_of, sized
from ecume_validation.permeation import start_time, unhindered
from ecume_validation.runner import case_scene

RECORDED = Path(__file__).parent / "recorded-starts.csv"
WRITTEN = folder_of(RECORDED.parent) / RECORDED.name
ACROSS, ROW = 5, 2.45e-3
"""Spheres in a row, and the height of a row in the proportions of the cell (m)."""
LONGEST = 8.0
"""s: the duration of the runs."""
SEEDS = sized((1,), (1,))
PACKINGS = sized(((8, 0.72), (8, 0.74), (8, 0.76), (8, 0.78), (8, 0.79)), ((4, 0.74),))
"""Rows of spheres, and the volume fraction at the start."""


def recorded() -> list[dict[str, float]]:
    """The rows of the last study."""
    with RECORDED.open(newline="", encoding="utf-8") as table:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(table)]


def measured(rows: int, fraction: float, seed: int) -> dict[str, float]:
    """The times (s) to a start with and without permeation; the duration of the run where there is none."""
    count = rows * ACROSS // 2
    changes = [f"seed={seed}", f"cell.volume_fraction={fraction}", f"cell.size=[0.012, {rows * ROW}]"]
    changes += [f"particles[{place}].count={count}" for place in (0, 1)]
    scene = case_scene("permeation", changes, name="start")
    found = {"permeating": start_time(scene), "free": start_time(unhindered(scene))}
    return {"rows": rows, "volume_fraction": fraction, "seed": seed, **found}


def main() -> None:
    """Run all and write the table."""
    with WRITTEN.open("w", newline="", encoding="utf-8") as opened:
        table = csv.DictWriter(opened, ("rows", "volume_fraction", "seed", "permeating", "free"), lineterminator="\n")
        table.writeheader()
        for seed, packing in itertools.product(SEEDS, PACKINGS):
            table.writerow({name: f"{value:.6g}" for name, value in measured(*packing, seed).items()})
            opened.flush()


if __name__ == "__main__":
    parser_of(__doc__).parse_args()
    main()
