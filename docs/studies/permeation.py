"""The time at which packings of frictional spheres start to flow under stress, over their volume fraction, with and
without permeation.

`python docs/studies/permeation.py` loads packings between an undrained bottom and a drained top with a pressure and a
shear stress, and writes `recorded-starts.csv` beside this file; some minutes.
"""

from __future__ import annotations

import csv
from pathlib import Path

from ecume._quick import folder_of, parser_of, sized
from ecume_validation.permeation import start_time, unhindered
from ecume_validation.runner import case_scene

RECORDED = Path(__file__).parent / "recorded-starts.csv"
WRITTEN = folder_of(RECORDED.parent) / RECORDED.name
LONGEST = 8.0
"""s: the duration of the runs."""
PACKINGS = sized(
    ((0.72, 1), (0.74, 1), (0.76, 1), (0.78, 1), (0.79, 1), (0.74, 2), (0.79, 2), (0.74, 3), (0.79, 3)), ((0.74, 1),)
)
"""Volume fraction at the start, and seed."""


def recorded() -> list[dict[str, float]]:
    """The rows of the last study."""
    with RECORDED.open(newline="", encoding="utf-8") as table:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(table)]


def measured(fraction: float, seed: int) -> dict[str, float]:
    """The times (s) to a start with and without permeation; the duration of the run where there is none."""
    scene = case_scene("permeation", [f"seed={seed}", f"cell.volume_fraction={fraction}"], name="start")
    found = {"permeating": start_time(scene), "free": start_time(unhindered(scene))}
    return {"volume_fraction": fraction, "seed": seed, **found}


def main() -> None:
    """Run all and write the table."""
    with WRITTEN.open("w", newline="", encoding="utf-8") as opened:
        table = csv.DictWriter(opened, ("volume_fraction", "seed", "permeating", "free"), lineterminator="\n")
        table.writeheader()
        for packing in PACKINGS:
            table.writerow({name: f"{value:.6g}" for name, value in measured(*packing).items()})
            opened.flush()


if __name__ == "__main__":
    parser_of(__doc__).parse_args()
    main()
