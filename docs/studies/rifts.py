"""Rifts in a raft on a surface that is stretched: the length of the clusters over the pulling rate.

`python docs/studies/rifts.py` pulls strips of beads at several rates, with and without hydrodynamic interaction, and
writes `recorded-rifts.csv` beside this file; some minutes.
"""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np

from ecume._quick import folder_of, parser_of, sized
from ecume.analysis.clusters import touching_clusters
from ecume.laws.capillarity import pair_force
from ecume.models import MODELS
from ecume.models.floating.parameters import CAPILLARY_LENGTH, STRENGTH
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame

RECORDED = Path(__file__).parent / "recorded-rifts.csv"
WRITTEN = folder_of(RECORDED.parent) / RECORDED.name
RADIUS = 3e-4
LENGTH, WIDTH = sized((30, 3), (4, 2))
"""Beads along and across the strip."""
SEEDS = sized((1, 2, 3), (1,))
RATES = sized((0.1, 0.3, 1.0, 3.0), (3.0,))
"""Separation speed of two touching beads by the flow, over the speed at which their attraction closes it."""
INTERACTIONS = ("none", "rotne-prager")
STRETCH = 2.0
"""How many times longer than at the start a line on the surface is when clusters are counted."""
DISORDER = 0.02
"""R.m.s. displacement of the beads at the start, over their diameter."""
GAP = 0.2
"""Gap over the radius up to which beads belong to one cluster."""
WIDE = 1.0
"""Half the side of the square on which the flow is given (m)."""


def strip(seed: int) -> np.ndarray:
    """A strip of a triangular lattice, slightly disordered."""
    column, row = (each.ravel() for each in np.meshgrid(np.arange(LENGTH), np.arange(WIDTH), indexing="ij"))
    places = 2.0 * RADIUS * np.stack([column + 0.5 * (row % 2), math.sqrt(0.75) * row], axis=1).astype(float)
    dice = np.random.default_rng(seed)
    moved = (1.0 + 4.0 * DISORDER) * places + 2.0 * RADIUS * DISORDER * dice.uniform(-1.0, 1.0, places.shape)
    return np.asarray(moved - moved.mean(axis=0))


def scene_of(rate: float, interaction: str, seed: int, duration: float) -> object:
    """A raft on a surface that expands along x at `rate` (1/s)."""
    ends = [[-rate * WIDE] * 2, [rate * WIDE] * 2]
    return from_plain({
        "model": "floating", "duration": duration, "frame_every": duration / 4.0,
        "liquid": {"density": 1000.0, "viscosity": 0.02, "surface_tension": 0.0728},
        "particles": [{"radius": RADIUS, "density": 1300.0, "contact_angle": 0.5 * math.pi,
                       "positions": strip(seed).tolist()}],
        "flow": {"nodes": {"low": [-WIDE, -WIDE], "high": [WIDE, WIDE], "vx": ends, "vy": [[0.0, 0.0], [0.0, 0.0]]}},
        "integration": {"integrator": "overdamped"}, "hydrodynamics": {"interaction": interaction},
    })  # fmt: skip


def closing_rate() -> float:
    """The rate (1/s) at which a flow would separate two touching beads as fast as their attraction closes them."""
    parameters = MODELS["floating"].parameters(scene_of(1.0, "none", 1, 1.0))
    charge, length = float(parameters.floats.charge[0]), float(parameters.pair[CAPILLARY_LENGTH])
    force = -float(pair_force(2.0 * RADIUS, float(parameters.pair[STRENGTH]) * charge**2, length))
    return force * float(parameters.kick.gain[0]) / RADIUS


def clusters_of(frame: Frame) -> tuple[int, float]:
    """The number of clusters, and the mean extent along x of the clusters, weighted by their beads, in diameters."""
    found = touching_clusters(frame, tolerance=GAP)
    x, total = frame.arrays["position"][:, 0], 0.0
    for label in np.unique(found.labels):
        members = x[found.labels == label]
        total += len(members) * (float(np.ptp(members)) / (2.0 * RADIUS) + 1.0)
    return len(found.sizes), total / len(x)


def recorded() -> dict[str, dict[float, list[float]]]:
    """The cluster lengths of the last study, by interaction and rate."""
    with RECORDED.open(newline="", encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    found: dict[str, dict[float, list[float]]] = {name: {} for name in INTERACTIONS}
    for row in rows:
        found[row["interaction"]].setdefault(float(row["rate"]), []).append(float(row["cluster_length"]))
    return found


def main() -> None:
    """Run all cases and write the table."""
    unit = closing_rate()
    with WRITTEN.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["interaction", "seed", "rate", "pulling_rate", "clusters", "cluster_length"])
        for interaction in INTERACTIONS:
            for rate in RATES:
                for seed in SEEDS:
                    pulled = rate * unit
                    frames = list(simulate(scene_of(pulled, interaction, seed, math.log(STRETCH) / pulled)))
                    count, length = clusters_of(frames[-1])
                    table.writerow([interaction, seed, rate, f"{pulled:.4g}", count, f"{length:.4g}"])
                    file.flush()


if __name__ == "__main__":
    parser_of(__doc__).parse_args()
    main()
