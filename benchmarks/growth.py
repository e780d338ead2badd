"""The time of a step and the memory over the size of a cube of water, and how much of both is due to its shape.

    python benchmarks/growth.py [--edges 22 46 126] [--steps 40] [--rounds 3] [--precision double]

One thread, processor time, all sizes in turns in one process, over the same steps. A cube with free faces
is measured beside one that is periodic, where all have as many neighbors whatever the size: particles of a larger
free cube have more, since fewer are at its faces.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from timed_runs import TimedRun, machine

from ecume._jit import use_threads
from ecume._quick import parser_of, sized

sys.path.insert(0, str(Path(__file__).parent / "peers"))
from cube import REACH, SPACING
from in_ecume import WARM_UP, bytes_of, run_of

SAMPLE = 20_000
"""Particles whose neighbors are counted."""


class Cube(NamedTuple):
    """A cube in progress."""

    sides: str
    count: int
    run: TimedRun
    seconds: list[float]
    """Of each round, per particle and step"""


def neighbors_inside(run: TimedRun) -> float:
    """Of a particle inside the support: the lists look a little farther."""
    lists, fields, support = run.workspace.lists, run.workspace.fields, REACH * SPACING
    count = len(lists.counts)
    chosen = np.random.default_rng(1).choice(count, min(count, SAMPLE), replace=False)
    place = fields.position[:3].astype(float)
    found = 0
    for i in chosen:
        first = lists.start[i]
        away = place[:, lists.neighbor[first : first + lists.counts[i]]] - place[:, i : i + 1]
        found += int(((away**2).sum(axis=0) < support**2).sum())
    return found / len(chosen)


def time_rounds(cubes: list[Cube], steps: int, rounds: int) -> None:
    """Integrate all of them, in turns."""
    for cube in cubes:
        cube.run.go(WARM_UP)
    for _ in range(rounds):
        for cube in cubes:
            began = time.process_time()
            cube.run.go(steps)
            cube.seconds.append((time.process_time() - began) / (steps * cube.count))


def show(cubes: list[Cube], precision: str) -> None:
    """A row a cube: the best of the rounds, over that of the smallest with such faces."""
    for sides in dict.fromkeys(cube.sides for cube in cubes):
        first = None
        for cube in (one for one in cubes if one.sides == sides):
            spent, around = 1e9 * min(cube.seconds), neighbors_inside(cube.run)
            first = first or (spent, around)
            print(
                f"| {precision}, {sides} | {cube.count:,} | {spent:.0f} | {spent / first[0]:.2f} | {around:.1f} "
                f"| {around / first[1]:.2f} | {spent / around:.2f} | {spent * first[1] / (around * first[0]):.2f} "
                f"| {bytes_of(cube.run) / cube.count:.0f} |"
            )


def main() -> None:
    """Measure, and print the table."""
    parser = parser_of(__doc__)
    parser.add_argument("--edges", type=int, nargs="*", default=sized([22, 46, 126], [7, 8]))
    for name, number in (("steps", sized(40, 2)), ("rounds", sized(3, 1))):
        parser.add_argument(f"--{name}", type=int, default=number)
    parser.add_argument("--precision", nargs="*", default=["double"], choices=["double", "single"])
    asked = parser.parse_args()
    use_threads(1)
    print(f"{machine()}\n")
    print("| sums, faces | particles | ns a step | growth | neighbors | growth | ns a pair | growth | bytes |")
    print("|---|---|---|---|---|---|---|---|---|")
    for precision in asked.precision:
        cubes = [
            Cube(sides, edge**3, run_of(edge, precision, sides=sides), [])
            for sides in ("open", "periodic")
            for edge in asked.edges
        ]
        time_rounds(cubes, asked.steps, asked.rounds)
        show(cubes, precision)
    if hasattr(os, "getloadavg"):
        print(f"\nload {os.getloadavg()[0]:.1f} at the end")


if __name__ == "__main__":
    main()
