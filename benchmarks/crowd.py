"""Pair forces in ecume and LAMMPS, and sums over many floats: direct, with cells, with a grid.

    python benchmarks/crowd.py [pairs] [sums]

One thread, processor time; the measurements of a table alternate. `pairs` needs the extra `bench`.
"""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from lammps_raft import POINTS, table_of
from timed_runs import TimedRun, heavy_spheres, lammps_library, machine

from ecume._jit import compiled_once, use_threads
from ecume._quick import parser_of, sized
from ecume.laws.special import bessel_k1
from ecume.models.floating.forces import pair_forces
from ecume.models.floating.forces.pair_forces import pairs_of, summed_law
from ecume.models.floating.time_integration.integration import forces_at
from ecume.scenes.load import load_scene

COUNT, SPACING = sized(2000, 100), 2.02e-3
REPEATS, ROUNDS = sized((20, 7), (1, 1))
CROWDS = sized((500, 2000, 5000, 20_000, 100_000, 1_000_000), (100,))
BEADS = (
    'model = "floating"\nduration = 1.0\nframe_every = 1.0\n[[particles]]\ncount = {count}\nradius = {radius}\n'
    'density = 2000.0\ncontact_angle = "90 deg"\n[integration]\nintegrator = "overdamped"\n'
    '[interaction]\nsummation = "{sum}"\naccuracy = {accuracy}\n'
)


def seconds(work: Callable[[], object], repeats: int) -> float:
    """Processor time of one call."""
    began = time.process_time()
    for _ in range(repeats):
        work()
    return (time.process_time() - began) / repeats


def pull_of(run: TimedRun, kind: type) -> Callable[[], None]:
    """All pair forces in a precision."""
    scratch, rows = run.workspace.scratch.interactions[0], pairs_of(run.workspace.lists.rows)
    floats, pair = (scratch.charge.astype(kind), scratch.radius), run.parameters.pair.astype(kind)
    law = summed_law(run.parameters._replace(single=kind is np.float32))

    def pull() -> None:
        pair_forces.sum_pair_forces(law, rows, floats, pair, scratch.force)

    pull()
    return pull


def lammps_pairs(lammps: Any, run: TimedRun, folder: Path) -> Any:
    """LAMMPS with the same floats at rest: it works out their forces in each step, by a table of our law."""
    position, cutoff = run.state.position, float(run.parameters.cutoff)
    table_of(run, folder / "raft.table")
    half = 2.0 * float(np.abs(position).max())
    engine = lammps(cmdargs=["-log", "none", "-screen", "none"])
    for line in (
        "units si", "dimension 2", "atom_style atomic", "boundary f f p", "newton on",
        f"region all block {-half} {half} {-half} {half} -0.01 0.01", "create_box 1 all", "mass 1 1.0",
    ):  # fmt: skip
        engine.command(line)
    places = np.column_stack([position, np.zeros(len(position))])
    engine.create_atoms(len(position), None, np.ones(len(position), dtype=np.int32), places.ravel())
    for line in (
        f"pair_style table linear {POINTS}", f"pair_coeff * * {folder / 'raft.table'} RAFT {cutoff * (1.0 - 1e-9)}",
        f"neighbor {run.parameters.skin} bin", "neigh_modify every 1000000 delay 1000000", "timestep 1e-9",
        "thermo 1000000", "run 0",
    ):  # fmt: skip
        engine.command(line)
    return engine


def pairs() -> None:
    """Forces of one raft: LAMMPS's table, ours in double and in single precision."""
    if (lammps := lammps_library()) is None:
        return
    run = TimedRun(
        heavy_spheres(
            f'count = {COUNT}\nplacement = "lattice"\nspacing = {SPACING}\n[interaction]\nsummation = "cells"\n'
        )
    )
    apart = run.state.position[None] - run.state.position[:, None]
    within = int(np.sum(np.hypot(apart[..., 0], apart[..., 1]) < run.parameters.cutoff)) - COUNT
    with tempfile.TemporaryDirectory() as name:
        engine = lammps_pairs(lammps, run, Path(name))
        work = {
            "LAMMPS, table, half lists": lambda: engine.command(f"run {REPEATS} post no"),
            "ecume, double": pull_of(run, np.float64),
            "ecume, single": pull_of(run, np.float32),
        }
        found: dict[str, list[float]] = {title: [] for title in work}
        for _ in range(ROUNDS):
            for title, go in work.items():
                ours = not title.startswith("LAMMPS")
                found[title].append(seconds(go, REPEATS if ours else 1) / (1 if ours else REPEATS))
    theirs = np.array(found["LAMMPS, table, half lists"])
    print(f"{COUNT} floats, {within / COUNT:.0f} neighbors each within the cutoff")
    for title, times in found.items():
        rate, ratio = within / np.median(times) / 1e6, np.median(theirs / np.array(times))
        print(f"{title:28s} {rate:7.0f} million pairs (i, j) a second, {ratio:.2f} times LAMMPS")


@compiled_once
def direct_sum(position: Any, charge: Any, length: float, force: Any) -> None:
    """All pairs, exactly."""
    for i in range(len(charge)):
        for j in range(i):
            x, y = (position[j, 0] - position[i, 0]) / length, (position[j, 1] - position[i, 1]) / length
            distance = math.sqrt(x * x + y * y)
            pull = charge[i] * charge[j] * bessel_k1(distance) / distance
            force[i, 0] += pull * x
            force[i, 1] += pull * y
            force[j, 0] -= pull * x
            force[j, 1] -= pull * y


def cell_sum(count: int, radius: float, accuracy: float) -> Callable[[], None]:
    """Forces with cells alone."""
    return pull_of(
        TimedRun(load_scene(BEADS.format(count=count, radius=radius, sum="cells", accuracy=accuracy))), np.float64
    )


def grid_sum(count: int, radius: float, accuracy: float) -> Callable[[], None]:
    """Forces with a grid."""
    run = TimedRun(load_scene(BEADS.format(count=count, radius=radius, sum="grid", accuracy=accuracy)))

    def go() -> None:
        forces_at(run.parameters, run.state.position, run.workspace)

    go()
    return go


def direct(count: int, radius: float, accuracy: float) -> Callable[[], None]:
    """Forces of all pairs."""
    run = TimedRun(load_scene(BEADS.format(count=count, radius=radius, sum="cells", accuracy=accuracy)))
    charge, force = run.parameters.floats.charge, np.zeros((count, 2))
    return lambda: direct_sum(run.state.position, charge, float(run.parameters.pair[1]), force)


def sums() -> None:
    """Microseconds a float of one evaluation, floats covering 15 %."""
    print("microseconds of a float and evaluation, 15 % covered, accuracy 1e-4")
    print("  radius   floats   direct    cells     grid")
    for radius in (2e-5, 1e-3):
        for count in CROWDS:
            cost = []
            for make, most in ((direct, 2000), (cell_sum, 5000 if radius < 1e-3 else 100_000), (grid_sum, 1_000_000)):
                if count > most:
                    cost.append("       –")
                    continue
                go = make(count, radius, 1e-4)
                cost.append(f"{1e6 * min(seconds(go, 1) for _ in range(2)) / count:8.2f}")
            print(f"{radius * 1e6:6.0f} um {count:8d} {' '.join(cost)}", flush=True)


def main() -> None:
    """What is asked for, or all."""
    parser = parser_of(__doc__)
    parser.add_argument("tables", nargs="*", help="pairs, sums; default: both")
    asked = parser.parse_args().tables or ["pairs", "sums"]
    use_threads(1)
    print(machine(), "\n")
    for name, table in (("pairs", pairs), ("sums", sums)):
        if name in asked:
            table()
            print()


if __name__ == "__main__":
    main()
