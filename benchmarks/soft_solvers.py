"""The time of each solver for a linear system of soft spheres at rest in a packing, over the length of the step.

    python benchmarks/soft_solvers.py [--layers 1000 10000] [--spaces 1000] [--steps 1 100 1e4]

Steps are in units of viscosity over modulus, the relaxation time of surfaces. The load is a wave as long as the box,
for which sweeps converge most slowly. Processor time of one thread, the best of three; `cholmod` where cvxopt is
installed. Operations are those that determine the choice of the solver.
"""

from __future__ import annotations

import time

import numpy as np
from soft_scale import packing
from timed_runs import machine

from ecume._quick import parser_of, sized
from ecume.engine.linear_solvers import solvers
from ecume.errors import BadInput
from ecume.models.soft import SOFT
from ecume.models.soft.contacts.films import contact_response
from ecume.models.soft.integration.dirk import begin_stage, first_stage
from ecume.models.soft.integration.dirk_schemes import SCHEMES
from ecume.models.soft.integration.newton import assemble_jacobian, imbalance
from ecume.models.soft.protocol import drive_at
from ecume.models.soft.state import Workspace

TRIES = sized(3, 1)
PULL = 1e-6
"""N"""


def system(count: int, dimensions: int) -> tuple[object, Workspace]:
    """A packing at the beginning of its first stage."""
    scene = packing(count, dimensions)
    parameters = SOFT.parameters(scene)
    state = SOFT.start(scene, parameters)
    scratch = SOFT.workspace(parameters, state, 1.0)
    first_stage(parameters.contacts, scratch.step, drive_at(parameters.protocol, 0.0))
    return parameters, scratch


def fill(parameters: object, scratch: Workspace, span: float) -> None:
    """The matrix and the right side of a stage of this length (s)."""
    step = scratch.step
    begin_stage(step, SCHEMES["tr-bdf2"].tableau, 1, span)
    contact_response(parameters.contacts, step.pairs, step.films, step.bodies.position, span, step.responses)  # type: ignore[attr-defined]
    imbalance(step, 1.0, span, True)
    assemble_jacobian(step, span)
    height = step.bodies.position[:, 1]
    step.bodies.right[:] = 0.0
    step.bodies.right[:, 0] = PULL * np.sin(2.0 * np.pi * height / np.ptp(height))


def timed(name: str, scratch: Workspace) -> float:
    """Seconds of one system, None where there is no solution."""
    step, spent = scratch.step, []
    right, change = step.borders.right[:1], step.borders.change[:1]
    for _ in range(TRIES):
        begin = time.process_time()
        if not solvers.SOLVERS[name](scratch.kept, step.matrix, right, change, 0):
            return float("nan")
        spent.append(time.process_time() - begin)
    return min(spent)


def main() -> None:
    """Measure, and print the table."""
    parser = parser_of(__doc__)
    parser.add_argument("--layers", type=int, nargs="*", default=sized([1000, 10_000], [40]))
    parser.add_argument("--spaces", type=int, nargs="*", default=sized([1000], [40]))
    parser.add_argument("--steps", type=float, nargs="+", default=[1.0, 100.0, 1e4])
    asked = parser.parse_args()
    print(machine())
    print("\n| | spheres | step | iterations | ms: iterative | direct | cholmod | operations: iterative | direct |")
    print("|---|---|---|---|---|---|---|---|---|")
    for dimensions, counts in ((2, asked.layers), (3, asked.spaces)):
        for count in counts:
            parameters, scratch = system(count, dimensions)
            for length in asked.steps:
                fill(parameters, scratch, length * 1e-4)
                kept = scratch.kept
                kept.iterations = kept.systems = 0
                times = {}
                for name in ("iterative", "direct", "cholmod"):
                    try:
                        times[name] = timed(name, scratch)
                    except BadInput:
                        times[name] = float("nan")
                iterations = kept.iterations // max(kept.systems, 1)
                swept, factored = iterations * solvers.operations_of_iteration(kept), solvers.work(kept)
                output = " | ".join(f"{1e3 * one:.3g}" for one in times.values())
                kind = "layer" if dimensions == 2 else "space"
                print(
                    f"| {kind} | {count:,} | {length:g} | {iterations} | {output} | {swept:.2g} | {factored:.2g} |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
