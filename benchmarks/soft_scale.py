"""The time of a step of sheared soft spheres over their number: periodic packings of two sizes, in 2D and in 3D.

    python benchmarks/soft_scale.py [--layers 1000 10000] [--spaces 1000 10000] [--steps 12] [--strain 0.05]

Each packing is integrated in a process of its own, after compilation and after the first quick steps, without the
placement. With `--strain` spheres have a steric layer and are sheared so far first: a flow that has developed needs
more iterations than one that begins. Processor time is that of all threads (`--threads 1 2`); wall time shows what a
second thread gains, and needs a quiet machine. The processor time of the main thread, which contains all serial work
and its share of the rest, shows on a busy machine what could be gained on a quiet one.
"""

from __future__ import annotations

import math
import multiprocessing
import os
import resource
import time
from concurrent.futures import ProcessPoolExecutor
from typing import NamedTuple

import numpy as np
from timed_runs import machine

from ecume._quick import parser_of, sized
from ecume.engine.linear_solvers import solvers
from ecume.models.soft import SOFT
from ecume.models.soft.contacts.contact_list import update_contact_list
from ecume.models.soft.integration.time_stepping import one_step
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.state import CLOCK, State, Workspace
from ecume.scenes.schema import from_plain
from ecume.scenes.soft import SoftScene

FILLED = {2: 0.80, 3: 0.58}
BEGIN = sized(14, 2)
"""Steps that are not counted: they grow from next to nothing."""


class Asked(NamedTuple):
    """The packing to integrate."""

    count: int
    dimensions: int
    steps: int
    solver: str
    threads: int
    strain: float


class Row(NamedTuple):
    """What one packing took."""

    count: int
    contacts: int
    solver: str
    """the one that solved the most systems"""
    systems: float
    """a step, with those of failed tries"""
    iterations: int
    """of gradients a system, in the last step that took any"""
    step: float
    """s of processor time, an accepted step with all its tries"""
    main: float
    """s of it, of the main thread"""
    wall: float
    """s of wall time"""
    strain: float
    """s of processor time, a unit of strain"""
    memory: float
    """bytes, of the process at its largest"""


STERIC = {"law": "steric", "steric_strength": 1e-5, "steric_length": 1e-5}


def packing(count: int, dimensions: int, solver: str = "auto", *, layer: bool = False) -> SoftScene:
    """As many spheres of radius 1 as of radius 1.4, with or without a steric layer, sheared by one unit in 4 s."""
    volume = count / 2 * sum(math.pi * r**2 if dimensions == 2 else 4 / 3 * math.pi * r**3 for r in (1e-3, 1.4e-3))
    plain = {
        "model": "soft", "duration": 4.0, "frame_every": 4.0, "liquid": {"viscosity": 1.0},
        "hydrodynamics": {"drag": "stokes"},
        "particles": [{"radius": r, "modulus": 1e4, "count": count // 2} for r in (1e-3, 1.4e-3)],
        "cell": {"size": [(volume / FILLED[dimensions]) ** (1 / dimensions)] * dimensions, "minimum_gap": 2e-5},
        "protocol": [{"time": 0.0}, {"time": 4.0, "strain": 1.0}], "long_range_forces": STERIC if layer else {},
        "integration": {"integrator": "tr-bdf2", "tolerance": 1e-3, "solver": solver},
    }  # fmt: skip
    scene = from_plain(plain)
    assert isinstance(scene, SoftScene)
    return scene


def watched() -> dict[str, int]:
    """How many systems each solver has solved from now on."""
    systems = dict.fromkeys(solvers.SOLVERS, 0)
    for name, solve in list(solvers.SOLVERS.items()):

        def counted(*given: object, name: str = name, solve: solvers.Solve = solve) -> bool:
            systems[name] += 1
            return solve(*given)  # type: ignore[arg-type]

        solvers.SOLVERS[name] = counted
    return systems


def stepped(parameters: Parameters, state: State, scratch: Workspace) -> Workspace:
    """Integrate one step. Returns the workspace for the contacts after it."""
    met = one_step(parameters, state, scratch)
    if met is None:
        raise SystemExit(SOFT.diagnosis(parameters, state))
    return SOFT.workspace(parameters, state, 1.0) if update_contact_list(parameters, state, met) else scratch


def measure(asked: Asked) -> Row:
    """Integrate one packing."""
    scene = packing(asked.count, asked.dimensions, asked.solver, layer=asked.strain > 0.0)
    systems, left = watched(), BEGIN
    parameters = SOFT.parameters(scene)
    state = SOFT.start(scene, parameters)
    scratch = SOFT.workspace(parameters, state, 1.0)
    while left > 0 or state.pace[CLOCK] < 4.0 * asked.strain:
        scratch, left = stepped(parameters, state, scratch), left - 1
    clock, systems_before = float(state.pace[CLOCK]), sum(systems.values())
    spent, waited, main = time.process_time(), time.perf_counter(), time.thread_time()
    for _ in range(asked.steps):
        scratch = stepped(parameters, state, scratch)
    spent, waited = time.process_time() - spent, time.perf_counter() - waited
    main = time.thread_time() - main
    return Row(
        systems=(sum(systems.values()) - systems_before) / asked.steps,
        count=asked.count,
        contacts=int(state.contacts[0]),
        solver=max(systems, key=systems.__getitem__) if any(systems.values()) else "dense",
        iterations=int(state.effort[0]),
        step=spent / asked.steps,
        main=main / asked.steps,
        wall=waited / asked.steps,
        strain=spent / (state.pace[CLOCK] - clock) * 4.0,
        memory=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024.0,
    )


def alone(asked: Asked) -> Row:
    """The same in a process of its own, which has its own largest memory and number of threads."""
    os.environ["NUMBA_NUM_THREADS"] = str(asked.threads)
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        return pool.submit(measure, asked).result()


def grown(rows: list[Row], what: str) -> float:
    """The power of their number with which something grows."""
    counts, values = [row.count for row in rows], [getattr(row, what) for row in rows]
    return float(np.polyfit(np.log(counts), np.log(values), 1)[0])


def row_of(dimensions: int, threads: int, row: Row) -> str:
    """A line of the table."""
    kind = "layer" if dimensions == 2 else "space"
    times = f"{row.step:.3g} | {row.main:.3g} | {row.wall:.3g} | {row.strain:.3g}"
    return (
        f"| {kind} | {row.count:,} | {row.contacts:,} | {threads} | {row.solver}, {row.iterations}, {row.systems:.1f} "
        f"| {times} | {1e6 * row.step / row.count:.1f} "
        f"| {row.memory / 1e6:.0f} |"
    )


def main() -> None:
    """Measure, and print the table and the growth."""
    parser = parser_of(__doc__)
    parser.add_argument("--layers", type=int, nargs="*", default=sized([1000, 10_000], [40]))
    parser.add_argument("--spaces", type=int, nargs="*", default=sized([1000, 10_000], [40]))
    parser.add_argument("--steps", type=int, default=sized(12, 2))
    parser.add_argument("--strain", type=float, default=0.0, help="before the measured steps")
    parser.add_argument("--solver", default="auto")
    parser.add_argument("--threads", type=int, nargs="+", default=[1])
    asked = parser.parse_args()
    print(machine())
    times = "s a step | main thread | wall s | s a unit of strain"
    print(
        f"\n| | spheres | contacts | threads | solver, iterations, systems a step | {times} | us a sphere "
        "and step | MB |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for dimensions, counts in ((2, asked.layers), (3, asked.spaces)):
        for threads in asked.threads:
            rows = []
            for count in sorted(counts):
                rows.append(alone(Asked(count, dimensions, asked.steps, asked.solver, threads, asked.strain)))
                print(row_of(dimensions, threads, rows[-1]), flush=True)
            if len(rows) > 1:
                step, memory = grown(rows, "step"), grown(rows, "memory")
                print(f"a step grows with the power {step:.2f} of their number, memory with {memory:.2f}", flush=True)


if __name__ == "__main__":
    main()
