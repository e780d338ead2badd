"""The rate at which a packing flows under the mean stress of its flow at a given rate.

`python docs/studies/stress_or_rate.py 60 240 --rate 0.8` shears that many spheres near jamming, some minutes for 60 and
an hour for 960, and adds the rows to `recorded-stress-or-rate.csv` beside this file.
"""

from __future__ import annotations

import csv
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ecume._quick import folder_of, parser_of, sized
from ecume.analysis.rheology import over_seeds, steady_state
from ecume.analysis.series import Mean, number, series, steady_mean
from ecume.simulation import moments
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
LATER = 1e-4
"""Strain by which the stress begins after the last state of the flow at a rate: that state does not know it."""
FRAMES, TRANSIENT = 60, 0.2
"""Frames per unit of strain; the first part of creep, which is not counted."""


def protocol_of(rate: float, strain: float, stress: float | None) -> list[dict[str, float]]:
    """A pre-shear that compresses the packing, a flow at the rate (1/s), and then one at a stress (N/m)."""
    found = [{"time": 0.0, "shear_rate": rate}, {"time": 1.0 / rate, "scale": math.sqrt(START / FRACTION)}]
    return found if stress is None else [*found, {"time": (1.0 + strain + LATER) / rate, "shear_stress": stress}]


def flow(spheres: int, seed: int, rate: float, strain: float, stress: float | None = None, state: Any = None,
         ) -> Iterator[tuple[Frame, Any]]:  # fmt: skip
    """The frames of a flow at the rate after the pre-shear or, from its last state on, at a stress, with the states."""
    spans = 1.0 + strain if stress is None else 1.0 + 2.0 * strain
    protocol, changes = protocol_of(rate, strain, stress), [f"cell.volume_fraction={START}"]
    scene = sheared(spheres, seed, protocol, spans / rate, round(FRAMES * spans), changes)
    for moment in moments(scene, state=state):
        if moment.frame is not None and moment.frame.time > 1.0 / rate:
            yield moment.frame, moment.state


class Measured(NamedTuple):
    """A flow at a rate, and one at its mean stress."""

    stress: Mean
    """at the rate, with its error from block means (N/m)"""
    fluctuation: float
    """the standard deviation of this stress over its mean"""
    ratio: Mean
    """the mean rate at this stress, over the given one, with its error from block means"""


def measured(spheres: int, seed: int, rate: float, strain: float) -> Measured:
    """Both flows, each over this strain at the given rate."""
    stresses, state = [], None
    for frame, state in flow(spheres, seed, rate, strain):  # noqa: B007  # the last one goes on
        stresses.append(frame.numbers["shear_stress"])
    steady = steady_state(np.array(stresses))
    time, strains = series(
        (frame for frame, _ in flow(spheres, seed, rate, strain, steady.mean.value, state)),
        lambda frame: frame.time,
        number("strain"),
    )
    rates = (np.diff(strains) / np.diff(time))[round(TRANSIENT * len(time)) :] / rate
    fluctuation = float(np.std(stresses[steady.first :])) / steady.mean.value
    return Measured(steady.mean, fluctuation, steady_mean(rates))


def main(sizes: list[int], rate: float, strain: float | None) -> None:
    """Add a row for each seed, and print the mean over seeds of each size."""
    for spheres in sizes:
        found = [measured(spheres, seed, rate, strain or STRAINS[spheres]) for seed in SEEDS[spheres]]
        for seed, one in zip(SEEDS[spheres], found, strict=True):
            row = [spheres, rate, seed, f"{one.stress.value:.5g}", f"{one.stress.error:.2g}",
                   f"{one.fluctuation:.3g}", f"{one.ratio.value:.4g}", f"{one.ratio.error:.2g}"]  # fmt: skip
            with WRITTEN.open("a", encoding="utf-8", newline="") as file:
                csv.writer(file, lineterminator="\n").writerow(row)
        mean = over_seeds([one.ratio for one in found])
        sys.stdout.write(f"{spheres} spheres: {mean.value:.3f} ± {mean.error:.3f}\n")


if __name__ == "__main__":
    parser = parser_of(__doc__)
    parser.add_argument("sizes", metavar="SPHERES", type=int, nargs="*", default=[min(STRAINS)])
    parser.add_argument("--rate", type=float, default=RATE, help="shear rate (1/s)")
    parser.add_argument("--strain", type=float, help="strain of each flow (by default from the number of spheres)")
    asked = parser.parse_args()
    main(asked.sizes, asked.rate, asked.strain)
