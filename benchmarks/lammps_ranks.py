"""LAMMPS as engine on one and two ranks: wall time of a step, gain of the second rank, and memory of large systems.

    python benchmarks/lammps_ranks.py             # strong and weak scaling at 100,000 heavy spheres
    python benchmarks/lammps_ranks.py --rounds 3
    python benchmarks/lammps_ranks.py --large     # a million heavy spheres, and a million particles of water

Ranks busy-wait: no other program may use the cores. Needs the extra `lammps`.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from importlib.resources import files
from typing import Any, NamedTuple

import psutil
from timed_runs import heavy_spheres, machine

from ecume._quick import parser_of, sized
from ecume.models import MODELS
from ecume.scenes.load import load_scene
from ecume_lammps import floats_in_engine, tanks_in_engine
from ecume_lammps.engine import BALANCING
from ecume_lammps.process import Lammps, program

SIZE, STEPS = sized((100_000, 50), (200, 2))
LARGE, LARGE_STEPS, LARGE_SPACING = sized((1_000_000, 100, "0.001"), (200, 2, "0.05"))
STRONG, WEAK = 1.6, 0.85
"""Wanted: the gain of a second rank at one size, and the share of the speed that remains at one size per rank."""


class Cost(NamedTuple):
    """What a run on some ranks needed."""

    step: float
    """Wall time of a time step (s)."""
    memory: list[float]
    """Of each rank (MB)."""
    setup: float
    """Wall time before the first step (s)."""


def cost(scene: Any, ranks: int, steps: int, system: Any) -> Cost:
    """Of `steps` time steps after five that are not counted."""
    began = time.perf_counter()
    parameters = system.parameters(scene)
    texts, commands = system.commands(scene, parameters, MODELS[scene.model].start(scene, parameters))
    lammps = Lammps(program(), ranks, texts)
    lammps.do(f"{commands}{BALANCING if ranks > 1 else ''}\nrun 5 post no")
    setup = time.perf_counter() - began
    began = time.perf_counter()
    lammps.do(f"run {steps} pre no post no")
    step = (time.perf_counter() - began) / steps
    children = psutil.Process().children(recursive=True)
    memory = [child.memory_info().rss / 1e6 for child in children if child.name() == "lmp"]
    lammps.close()
    return Cost(step, memory, setup)


def spheres(count: int) -> Any:
    """Heavy spheres on a lattice, almost in contact."""
    return heavy_spheres(f'count = {count}\nplacement = "lattice"\nspacing = "2.02 mm"\n')


def water(spacing: str) -> Any:
    """Vortices in a periodic square of 1 m, which has no walls and therefore no images in LAMMPS."""
    text = (files("ecume") / "templates" / "taylor-green.toml").read_text(encoding="utf-8")
    return load_scene(text, [f"spacing={spacing}", "method.shifting=none"])


def scaling(count: int) -> None:
    """Print medians and ratios of rounds in which the three runs take turns."""
    runs: dict[str, Callable[[], Cost]] = {
        "half, 1 rank": lambda: cost(spheres(SIZE // 2), 1, STEPS, floats_in_engine),
        "whole, 1 rank": lambda: cost(spheres(SIZE), 1, STEPS, floats_in_engine),
        "whole, 2 ranks": lambda: cost(spheres(SIZE), 2, STEPS, floats_in_engine),
    }
    rounds = [{name: run() for name, run in runs.items()} for _ in range(count)]
    times = {name: [costs[name].step for costs in rounds] for name in runs}
    middle = {name: statistics.median(values) for name, values in times.items()}
    for name, values in times.items():
        memory = ", ".join(f"{size:.0f}" for size in rounds[-1][name].memory)
        print(f"{name:15} {middle[name]:.3f} s a step ({min(values):.3f} to {max(values):.3f}), {memory} MB")
    strong = middle["whole, 1 rank"] / middle["whole, 2 ranks"]
    weak = middle["half, 1 rank"] / middle["whole, 2 ranks"]
    print(f"strong {strong:.2f} (wanted {STRONG}), weak {weak:.2f} (wanted {WEAK}): medians of {count} rounds")


def large() -> None:
    """Print time of a step, memory of each rank and time before the first step of a million particles on two ranks."""
    for name, scene, system in (
        ("heavy spheres", spheres(LARGE), floats_in_engine),
        ("water", water(LARGE_SPACING), tanks_in_engine),
    ):
        found = cost(scene, 2, LARGE_STEPS, system)
        memory = ", ".join(f"{size:.0f}" for size in found.memory)
        print(f"{LARGE:,} {name}: {found.step:.2f} s a step over {LARGE_STEPS}, {memory} MB, setup {found.setup:.0f} s")


def main() -> None:
    """Print the machine, and what was asked for."""
    parser = parser_of(__doc__)
    parser.add_argument("--rounds", type=int, default=sized(11, 1))
    parser.add_argument("--large", action="store_true")
    asked = parser.parse_args()
    print(machine())
    if not asked.large:
        scaling(asked.rounds)
    if asked.large or asked.quick:
        large()


if __name__ == "__main__":
    main()
