"""The time for which packings of one volume fraction, with films of different thickness, hold a stress before they
yield.

`python docs/studies/delay_under_stress.py [PROCESSES]` runs the template `stress-step` for some seeds and ages, and
writes `recorded-delays.csv` beside this file; some minutes. A first run of each seed tells the normal stress at each
age, and the step is made at that: so the box does not jump, and the volume fraction is the same.
"""

from __future__ import annotations

import csv
import itertools
import math
from collections.abc import Sequence
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from ecume._quick import folder_of, parser_of, sized
from ecume.analysis.rheology import yield_delay
from ecume.analysis.series import Mean
from ecume.laws.soft_pair import SoftPair, passage_time
from ecume.scenes.load import load_scene
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame

TEMPLATE = Path(__file__).parents[2] / "src" / "ecume" / "templates" / "stress-step.toml"
RECORDED = Path(__file__).parent / "recorded-delays.csv"
WRITTEN = folder_of(RECORDED.parent) / RECORDED.name
SEEDS = sized((1, 2, 3, 4, 5, 6), (1,))
AGES = sized((8.0, 32.0, 128.0, 512.0), (4.0,))
"""S: when the stress is put on."""
FRICTION = 0.6
"""Shear stress over normal stress."""
STRAINS = (0.10, 0.15, 0.20)
"""Since the step: thresholds of yielding."""
LONGEST = sized(12.0, 0.125)
"""Ages after the step that are waited for."""
NEVER = "1e9 s"

Row = dict[str, float]


def normal_stresses(seed: int) -> dict[float, float]:
    """The normal stress at each age (N/m) while nothing is done."""
    still = (f"seed={seed}", f"protocol[2].time={NEVER}", f"duration={max(AGES)}", f"frame_every={min(AGES)}")
    frames = simulate(load_scene(TEMPLATE, still))
    return {frame.time: frame.numbers["normal_stress"] for frame in frames if frame.time in AGES}


def stepped(seed: int, age: float, normal: float) -> list[Frame]:
    """Frames until well after yielding."""
    step = (
        f"seed={seed}", f"protocol[2].time={age}", f"protocol[2].normal_stress={normal!r}",
        f"protocol[2].shear_stress={FRICTION * normal!r}", f"duration={(1.0 + LONGEST) * age}",
        f"frame_every={age / 16}",
    )  # fmt: skip
    frames: list[Frame] = []
    before = math.nan
    for frame in simulate(load_scene(TEMPLATE, step)):
        frames.append(frame)
        if frame.time == age:
            before = frame.numbers["strain"]
        if frame.numbers["strain"] - before > 1.05 * max(STRAINS):
            break
    return frames


def row_of(seed: int, age: float, frames: Sequence[Frame]) -> Row:
    """What is kept of a run."""
    at = next(frame.numbers for frame in frames if frame.time == age)
    radius, shear = float(frames[0].arrays["radius"].mean()), frames[-1].numbers["shear_stress"]
    pair = SoftPair(radius, 1e4, 1.0)
    kept = ("volume_fraction", "mean_gap", "smallest_gap", "coordination", "normal_stress")
    return {
        "seed": seed, "age": age, **{name: at[name] for name in kept}, "shear_stress": shear,
        "separation_time": passage_time(pair, 2.0 * radius * shear, at["mean_gap"], radius),
        **{f"delay_{strain:.2f}": yield_delay(frames, age, strain) for strain in STRAINS},
    }  # fmt: skip


def measured(seed: int) -> list[Row]:
    """All ages of one seed."""
    normal = normal_stresses(seed)
    return [row_of(seed, age, stepped(seed, age, normal[age])) for age in AGES]


def recorded() -> list[Row]:
    """The rows of the last study."""
    with RECORDED.open(newline="", encoding="utf-8") as table:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(table)]


def geometric_mean(rows: Sequence[Row], name: str) -> Mean:
    """Over seeds; the error is that of its logarithm."""
    values = np.log([row[name] for row in rows])
    return Mean(float(np.exp(values.mean())), float(values.std(ddof=1) / math.sqrt(len(values))))


def main(processes: int) -> None:
    """Run all and write the table."""
    with get_context("spawn").Pool(processes) as pool:
        rows = list(itertools.chain.from_iterable(pool.imap(measured, SEEDS)))
    with WRITTEN.open("w", newline="", encoding="utf-8") as opened:
        table = csv.DictWriter(opened, rows[0], lineterminator="\n")
        table.writeheader()
        table.writerows({name: f"{value:.6g}" for name, value in row.items()} for row in rows)


if __name__ == "__main__":
    parser = parser_of(__doc__)
    parser.add_argument("processes", metavar="PROCESSES", type=int, nargs="?", default=1)
    main(parser.parse_args().processes)
