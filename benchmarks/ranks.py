"""A crowd of heavy spheres on ranks with one thread each: steps alone and together, in turns.

    python benchmarks/ranks.py --floats 100000 --ranks 2

Starts itself with the launcher of the extra `mpi`. Where other work keeps the cores busy the wall time says little: the
processor's time that a rank takes for its own part, messages left out, stands beside it.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from typing import Any

import numpy as np
from marching import heavy_spheres, machine

ROUNDS, WARM_UP = 5, 2


class Clock:
    """Wall and processor time, less what messages took."""

    def __init__(self) -> None:
        self.messages = np.zeros(2)

    def now(self) -> Any:
        """Both, so far."""
        return np.array([time.perf_counter(), time.process_time()])

    def around(self, message: Any) -> Any:
        """The message, timed."""

        def timed(*what: Any) -> Any:
            began = self.now()
            answer = message(*what)
            self.messages += self.now() - began
            return answer

        return timed


def main() -> int:
    """Start the ranks, or be one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--floats", type=int, default=100_000)
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--steps", type=int, default=20)
    parser.add_argument("--spacing", type=float, help="m, of a lattice; left out, floats cover 15 %%")
    asked = parser.parse_args()
    if "PMI_SIZE" in os.environ:
        measure(asked)
        return 0
    from ecume.cli.engines import QUIET, launcher
    from ecume.errors import BadInput

    try:
        command = [str(launcher()), "-n", str(asked.ranks), sys.executable, *sys.argv]
    except BadInput as error:
        print(error)
        return 0
    return subprocess.run(command, env={**os.environ, "NUMBA_NUM_THREADS": "1", **QUIET}, check=False).returncode


def measure(asked: argparse.Namespace) -> None:
    """All ranks together; the first prints."""
    from ecume.models import MODELS
    from ecume.models.floating.spread import march_shared
    from ecume.run.ranks import share_of, world

    everyone, clock = world(), Clock()
    lattice = f'placement = "lattice"\nspacing = {asked.spacing}\n' if asked.spacing else ""
    scene, model = heavy_spheres(f"count = {asked.floats}\n{lattice}"), MODELS["floating"]
    parameters = model.parameters(scene)
    states = [model.start(scene, parameters) for _ in range(2)]
    share = share_of(everyone)
    share = share._replace(gather=clock.around(share.gather))
    workspace = model.workspace(parameters, states[0], 1.0)
    own = model.workspace(parameters, states[1], 1.0)

    def alone(steps: int) -> None:
        if everyone.rank == 0:
            model.advance(parameters, states[0], workspace, steps)

    def together(steps: int) -> None:
        march_shared(share, parameters, states[1], own, steps)

    def cost(march: Any) -> Any:
        wait(everyone)
        began, clock.messages[:] = clock.now(), 0.0
        march(asked.steps)
        spent = (clock.now() - began) / asked.steps * 1e3
        return np.append(spent, spent[1] - clock.messages[1] / asked.steps * 1e3)

    for march in (alone, together):
        march(WARM_UP)
    told = []
    for number in range(ROUNDS):
        one, many = cost(alone), cost(together)
        slowest = np.max(everyone.gather(many) or [many], axis=0)
        told.append((one, slowest))
        if everyone.rank == 0:
            print(
                f"round {number}: alone {one[0]:.1f} ms a step ({one[1]:.1f} of the processor); {everyone.size} ranks "
                f"{slowest[0]:.1f} ms ({slowest[2]:.1f} of the processor for the largest part, messages left out)"
            )
    if everyone.rank == 0:
        same = all(np.array_equal(a, b) for a, b in zip(*states, strict=True))
        wall, work = (np.median([one[k] / many[m] for one, many in told]) for k, m in ((0, 0), (1, 2)))
        print(f"{machine()}\n{asked.floats} floats, the same bits: {same}")
        print(f"median of {ROUNDS}: {wall:.2f} times as fast by the wall, {work:.2f} times by the processor's time")


def wait(everyone: Any) -> None:
    """For the others, without keeping a core busy."""
    there = everyone.Ibarrier()
    while not there.Test():
        time.sleep(1e-3)


if __name__ == "__main__":
    sys.exit(main())
