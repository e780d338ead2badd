"""Many heavy spheres, or a tank, on ranks with one thread each: steps alone and together, in turns.

    python benchmarks/ranks.py --particles 100000 --ranks 2
    python benchmarks/ranks.py --model sph

Starts itself with the launcher of the extra `mpi`. Where other work keeps the cores busy the wall time says little: the
processor's time that a rank takes for its own part, messages left out, stands beside it.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Callable
from importlib.resources import files
from typing import Any

import numpy as np
from timed_runs import heavy_spheres, machine

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
    parser.add_argument("--model", choices=("floating", "sph"), default="floating")
    parser.add_argument("--particles", type=int, default=100_000, help="about so many, of a tank")
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--steps", type=int, default=20)
    parser.add_argument("--spacing", type=float, help="m, of a lattice of floats; left out, they cover 15 %%")
    asked = parser.parse_args()
    if "PMI_SIZE" in os.environ:
        measure(asked)
        return 0
    from ecume.cli.mpi_launcher import QUIET, launcher
    from ecume.errors import BadInput

    try:
        command = [str(launcher()), "-n", str(asked.ranks), sys.executable, *sys.argv]
    except BadInput as error:
        print(error)
        return 0
    return subprocess.run(command, env={**os.environ, "NUMBA_NUM_THREADS": "1", **QUIET}, check=False).returncode


def scene_of(asked: argparse.Namespace) -> Any:
    """Loose floats, or a column of liquid that falls."""
    from ecume.scenes.load import load_scene

    if asked.model == "sph":
        text = (files("ecume") / "templates" / "dam-break-3d.toml").read_text(encoding="utf-8")
        liquid: Any = load_scene(text).fluid[0]
        volume = float(np.prod(np.array(liquid.high) - np.array(liquid.low)))
        return load_scene(text, [f"spacing={(volume / asked.particles) ** (1.0 / 3.0)}"])
    lattice = f'placement = "lattice"\nspacing = {asked.spacing}\n' if asked.spacing else ""
    return heavy_spheres(f"count = {asked.particles}\n{lattice}")


def runs_of(asked: argparse.Namespace, communicator: Any, clock: Clock) -> tuple[Callable[[int], Any], ...]:
    """The integration by the first rank alone, that by all together, and whether both have the same bits."""
    from ecume.models import MODELS
    from ecume.run.ranks import share_of, spread_of

    model, spread, share = MODELS[asked.model], spread_of(asked.model), share_of(communicator)
    share = share._replace(gather=clock.around(share.gather))
    scene = scene_of(asked)
    parameters = model.parameters(scene)
    spread.require_spreadable(parameters)
    one, many = (model.start(scene, parameters) for _ in range(2))
    whole, own = model.workspace(parameters, one, 1.0), spread.workspace_shared(share, parameters, many, 1.0)

    def alone(steps: int) -> None:
        if communicator.rank == 0:
            model.advance(parameters, one, whole, steps)

    def together(steps: int) -> None:
        spread.integrate_shared(share, parameters, many, own, steps)

    def same(_: int) -> bool:
        return all(np.array_equal(a, b, equal_nan=True) for a, b in zip(one, many, strict=True))

    return alone, together, same


def measure(asked: argparse.Namespace) -> None:
    """All ranks together; the first prints."""
    from ecume.run.ranks import world

    communicator, clock = world(), Clock()
    alone, together, same = runs_of(asked, communicator, clock)

    def cost(run: Callable[[int], Any]) -> Any:
        wait(communicator)
        began, clock.messages[:] = clock.now(), 0.0
        run(asked.steps)
        spent = (clock.now() - began) / asked.steps * 1e3
        return np.append(spent, spent[1] - clock.messages[1] / asked.steps * 1e3)

    for run in (alone, together):
        run(WARM_UP)
    costs = []
    for number in range(ROUNDS):
        one, many = cost(alone), cost(together)
        costs.append((one, np.max(communicator.gather(many) or [many], axis=0)))
        if communicator.rank == 0:
            print(f"round {number}: {in_words(communicator.size, *costs[-1])}", flush=True)
    if communicator.rank == 0:
        print(f"{machine()}\nabout {asked.particles} particles of the model {asked.model}, the same bits: {same(0)}")
        wall, work = (np.median([one[k] / many[m] for one, many in costs]) for k, m in ((0, 0), (1, 2)))
        print(f"median of {ROUNDS}: {wall:.2f} times as fast by the wall, {work:.2f} times by the processor's time")


def in_words(ranks: int, one: Any, many: Any) -> str:
    """What a round came to."""
    return (
        f"alone {one[0]:.1f} ms a step ({one[1]:.1f} of the processor); {ranks} ranks {many[0]:.1f} ms "
        f"({many[2]:.1f} of the processor for the largest part, messages left out)"
    )


def wait(communicator: Any) -> None:
    """For the others, without keeping a core busy."""
    there = communicator.Ibarrier()
    while not there.Test():
        time.sleep(1e-3)


if __name__ == "__main__":
    sys.exit(main())
