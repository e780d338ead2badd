"""Two versions of ecume compared: the time of each for the same frames of the same scenes.

    python benchmarks/versions.py OLD NEW [--cases bowl crowd cube packing] [--pairs 11] [--processes 3]

OLD and NEW are checkouts (folders with `src/ecume`). Both run in processes of their own, one thread each, and take
turns frame by frame, so that whatever else the machine does slows both. Each pair of frames gives one ratio NEW/OLD of
processor times. Printed are the median of all ratios, its 95 % confidence interval (order statistics), and whether both
versions ended at the same positions.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy import stats

HERE = Path(__file__).resolve()
CHECKOUT = HERE.parents[1]


class Case(NamedTuple):
    """A scene whose frames take some tenths of a second."""

    template: str
    changes: tuple[str, ...]


FEW = ("frame_every=1 ms", "duration=20 ms")
"""Short frames, to see that it works."""
CASES = {
    "bowl": Case(
        "cereal-bowl",
        ("frame_every=3 s", "duration=120 s", "hydrodynamics.drag=stokes", "hydrodynamics.added_mass=false"),
    ),
    "crowd": Case("colloids", ("particles[0].count=2000", "dish.radius=1.7 mm", "frame_every=10 s", "duration=1000 s")),
    "cube": Case("dam-break-3d", ("spacing=1.4 cm", "frame_every=10 ms", "duration=600 ms")),
    "packing": Case(
        "sheared-packing", ("frame_every=80 ms", "duration=4 s", "protocol[1].time=4 s", "protocol[1].strain=1")
    ),
}


def serve(name: str, frames: int, changes: list[str]) -> None:
    """Compute one frame for each line read, and print its processor time; in the end the sum of all positions.

    This runs with the ecume of a checkout that may be old, and so names nothing that is new.
    """
    import time

    from ecume._jit import use_threads
    from ecume.scenes.load import load_scene
    from ecume.simulation import simulate

    use_threads(1)
    import ecume

    case = CASES[name]
    template = Path(ecume.__file__).parent / "templates" / f"{case.template}.toml"
    run = simulate(load_scene(template, [*case.changes, *changes]))
    frame = next(run)
    next(run)  # what had to be compiled is compiled now
    print("ready", flush=True)
    for _ in range(frames):
        sys.stdin.readline()
        began = time.process_time()
        frame = next(run)
        print(time.process_time() - began, flush=True)
    print(float(np.sum(frame.arrays["position"])).hex(), flush=True)


class Version:
    """A process that computes frames with one version."""

    def __init__(self, checkout: Path, case: str, frames: int, changes: Sequence[str]) -> None:
        """Start it; `ready` waits for it."""
        environment = {**os.environ, "PYTHONPATH": str(checkout.resolve() / "src")}
        words = [sys.executable, str(HERE), "serve", case, str(frames), *changes]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(words, stdin=pipe, stdout=pipe, text=True, env=environment)

    def ask(self) -> float:
        """The processor time of the next frame."""
        assert self.process.stdin is not None
        print(file=self.process.stdin, flush=True)
        return float(self.read())

    def read(self) -> str:
        """The next line of its output."""
        assert self.process.stdout is not None
        line = self.process.stdout.readline().strip()
        if not line:
            sys.exit("a version ended early")
        return line


def compare(
    old: Path, new: Path, case: str, pairs: int, changes: Sequence[str]
) -> tuple[list[float], list[float], bool]:
    """Processor times of each frame by both versions, and whether both ended with the same bits."""
    versions = Version(old, case, pairs, changes), Version(new, case, pairs, changes)
    for version in versions:
        version.read()
    times: tuple[list[float], list[float]] = ([], [])
    for number in range(pairs):
        order = (0, 1) if number % 2 else (1, 0)
        for which in order:
            times[which].append(versions[which].ask())
    ends = [version.read() for version in versions]
    return *times, ends[0] == ends[1]


def interval(ratios: list[float]) -> tuple[float, float]:
    """The 95 % confidence interval of the median by order statistics."""
    ordered, n = sorted(ratios), len(ratios)
    low = int(stats.binom.ppf(0.025, n, 0.5))
    return ordered[max(low - 1, 0)], ordered[min(n - low, n - 1)]


def main() -> None:
    """A line for each case."""
    from ecume._quick import QUICK, parser_of, sized

    parser = parser_of(__doc__)
    parser.add_argument("old", type=Path, nargs="?" if QUICK else None, default=CHECKOUT)
    parser.add_argument("new", type=Path, nargs="?" if QUICK else None, default=CHECKOUT)
    parser.add_argument("--cases", nargs="+", choices=list(CASES), default=sized([*CASES], ["packing"]))
    parser.add_argument("--pairs", type=int, default=sized(11, 1), help="pairs of frames in each pair of processes")
    parser.add_argument("--processes", type=int, default=sized(3, 1), help="pairs of processes")
    asked = parser.parse_args()
    print("case      old s/frame   NEW/OLD   95 % interval     pairs   same bits")
    for case in asked.cases:
        ratios, times, same = [], [], True
        for _ in range(asked.processes):
            old, new, alike = compare(asked.old, asked.new, case, asked.pairs, sized((), FEW))
            ratios += [b / a for a, b in zip(old, new, strict=True)]
            times += old
            same = same and alike
        low, high = interval(ratios)
        median = float(np.median(ratios))
        row = f"{case:<8}{np.median(times):>12.3f}{median:>11.3f}   {low:.3f} to {high:.3f}{len(ratios):>9}"
        print(f"{row}   {'yes' if same else 'no'}", flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["serve"]:
        serve(sys.argv[2], int(sys.argv[3]), sys.argv[4:])
    else:
        main()
