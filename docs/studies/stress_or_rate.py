"""The rate at which a packing flows under the mean stress of its flow at a given rate.

`python docs/studies/stress_or_rate.py 60 240 --rate 0.8` shears that many spheres near jamming, some minutes for 60 and
an hour for 960, and adds the rows to `recorded-stress-or-rate.csv` beside this file.
"""

from __future__ import annotations

import csv
import math
import sys
from pathlib import Path

import numpy as np

from ecume._quick import folder_of, parser_of, sized
from ecume.analysis.rheology import over_seeds, steady_state
from ecume.analysis.series import Mean
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume_validation.rheology import sheared

RECORDED = Path(__file__).parent / "recorded-stress-or-rate.csv"
WRITTEN = folder_of(RECORDED.parent) / RECORDED.name
START, FRACTION = 0.80, 0.84
"""Volume fractions: of the start, and after a pre-shear to a strain of 1."""
RATE = 0.8
"""1/s, 1.6e-5 of modulus over viscosity, where no other is given."""
STRAINS = sized({12: 6.0, 24: 4.0, 60: 10.0, 240: 8.0, 960: 4.0}, {12: 0.5})
"""After the pre-shear, by the number of spheres."""
SEEDS = sized({12: (1,), 24: (1,), 60: (1, 2, 3), 240: (1,), 960: (1,)}, {12: (1,)})
FRAMES, TRANSIENT = 60, 0.2
"""Frames per unit of strain; the first part of creep, which is not counted."""


def frames_of(spheres: int, seed: int, rate: float, stress: float | None = None) -> list[Frame]:
    """A pre-shear, and then a flow at the rate (1/s), or at a stress (N/m)."""
    strain = STRAINS[spheres]
    after = {"time": 1.0 / rate, "scale": math.sqrt(START / FRACTION)}
    protocol = [{"time": 0.0, "shear_rate": rate}, after if stress is None else after | {"shear_stress": stress}]
    changes = [f"cell.volume_fraction={START}"]
    found = simulate(sheared(spheres, seed, protocol, (1.0 + strain) / rate, round(FRAMES * (1.0 + strain)), changes))
    return [frame for frame in found if frame.time > 1.0 / rate]


def measured(spheres: int, seed: int, rate: float) -> tuple[Mean, float, float]:
    """The mean stress at the given rate, its standard deviation over the mean, and the mean rate at this stress over
    the given rate.
    """
    stresses = np.array([frame.numbers["shear_stress"] for frame in frames_of(spheres, seed, rate)])
    steady = steady_state(stresses)
    creeping = frames_of(spheres, seed, rate, steady.mean.value)
    first, last = creeping[round(TRANSIENT * len(creeping))], creeping[-1]
    crept = (last.numbers["strain"] - first.numbers["strain"]) / (last.time - first.time)
    return steady.mean, float(stresses[steady.first :].std()) / steady.mean.value, crept / rate


def main(sizes: list[int], rate: float) -> None:
    """Add a row for each seed, and print the mean over seeds of each size."""
    for spheres in sizes:
        ratios = []
        for seed in SEEDS[spheres]:
            stress, fluctuation, ratio = measured(spheres, seed, rate)
            ratios.append(Mean(ratio, 0.0))
            row = [
                spheres,
                rate,
                seed,
                f"{stress.value:.5g}",
                f"{stress.error:.2g}",
                f"{fluctuation:.3g}",
                f"{ratio:.4g}",
            ]
            with WRITTEN.open("a", encoding="utf-8", newline="") as file:
                csv.writer(file, lineterminator="\n").writerow(row)
        mean = over_seeds(ratios)
        sys.stdout.write(f"{spheres} spheres: {mean.value:.3f} ± {mean.error:.3f}\n")


if __name__ == "__main__":
    parser = parser_of(__doc__)
    parser.add_argument("sizes", metavar="SPHERES", type=int, nargs="*", default=[min(STRAINS)])
    parser.add_argument("--rate", type=float, default=RATE, help="shear rate (1/s)")
    asked = parser.parse_args()
    main(asked.sizes, asked.rate)
