"""How a step of sheared soft spheres grows with their number: periodic packings of two sizes, in layers and in space.

    python benchmarks/soft_scale.py [--layers 1000 10000] [--spaces 1000 10000] [--steps 12]

Processor time of one process, after compilation and after the first quick steps; the placement is not counted.
"""

from __future__ import annotations

import argparse
import math
import resource
import time
from typing import NamedTuple

import numpy as np
from marching import machine

from ecume.models.soft import SOFT
from ecume.models.soft.meeting import renew_contacts
from ecume.models.soft.state import CLOCK
from ecume.models.soft.stepping import one_step
from ecume.scenes.schema import from_plain
from ecume.scenes.soft import SoftScene

FILLED = {2: 0.80, 3: 0.58}
BEGIN = 14
"""Steps that are not counted: they grow from next to nothing."""


class Row(NamedTuple):
    """What one packing took."""

    count: int
    contacts: int
    step: float
    """s of processor time, an accepted step with all its tries"""
    strain: float
    """s of processor time, a unit of strain"""
    memory: float
    """bytes a sphere, of the whole process at its largest"""


def packing(count: int, dimensions: int) -> SoftScene:
    """As many spheres of radius 1 as of radius 1.4, sheared by one unit in 4 s."""
    volume = count / 2 * sum(math.pi * r**2 if dimensions == 2 else 4 / 3 * math.pi * r**3 for r in (1e-3, 1.4e-3))
    plain = {
        "model": "soft", "duration": 4.0, "frame_every": 4.0, "liquid": {"viscosity": 1.0, "drag": True},
        "spheres": [{"radius": r, "modulus": 1e4, "count": count // 2} for r in (1e-3, 1.4e-3)],
        "box": {"size": [(volume / FILLED[dimensions]) ** (1 / dimensions)] * dimensions, "gap": 2e-5},
        "protocol": [{"time": 0.0}, {"time": 4.0, "strain": 1.0}],
        "stepping": {"scheme": "tr-bdf2", "tolerance": 1e-3, "solver": "iterative"},
    }  # fmt: skip
    scene = from_plain(plain)
    assert isinstance(scene, SoftScene)
    return scene


def measure(count: int, dimensions: int, steps: int) -> Row:
    """March one packing."""
    scene = packing(count, dimensions)
    parameters = SOFT.parameters(scene)
    state = SOFT.start(scene, parameters)
    scratch = SOFT.workspace(parameters, state, 1.0)
    begin, clock = 0.0, 0.0
    for number in range(BEGIN + steps):
        if number == BEGIN:
            begin, clock = time.process_time(), float(state.pace[CLOCK])
        if not one_step(parameters, state, scratch) > 0.0:
            raise SystemExit(SOFT.diagnosis(parameters, state))
        if renew_contacts(parameters, state):
            scratch = SOFT.workspace(parameters, state, 1.0)
    spent = time.process_time() - begin
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / count
    return Row(count, int(state.contacts[0]), spent / steps, spent / (state.pace[CLOCK] - clock) * 4.0, memory)


def main() -> None:
    """Measure, and print the table and the growth."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--layers", type=int, nargs="*", default=[1000, 10_000])
    parser.add_argument("--spaces", type=int, nargs="*", default=[1000, 10_000])
    parser.add_argument("--steps", type=int, default=12)
    asked = parser.parse_args()
    print(machine())
    print("\n| dimensions | spheres | contacts | s a step | s a unit of strain | bytes a sphere |")
    print("|---|---|---|---|---|---|")
    for dimensions, counts in ((2, asked.layers), (3, asked.spaces)):
        rows = [measure(count, dimensions, asked.steps) for count in sorted(counts)]
        for row in rows:
            told = f"{row.count:,} | {row.contacts:,} | {row.step:.3g} | {row.strain:.3g} | {row.memory:.0f}"
            print(f"| {dimensions} | {told} |", flush=True)
        if len(rows) > 1:
            power = np.polyfit(np.log([row.count for row in rows]), np.log([row.step for row in rows]), 1)[0]
            print(f"| {dimensions} | a step grows with the power {power:.2f} of their number | | | | |")


if __name__ == "__main__":
    main()
