"""A sweep of the T1 process by one worker and by two, alternating: points per second, and their ratio.

python benchmarks/sweeping.py [POINTS]

One worker is the process itself, two are Dask's on this machine. The clock starts when a few points are done, so that
neither the start of Dask nor compiling counts.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from timed_runs import machine

from ecume._quick import parser_of, sized
from ecume.sweep import sweep
from ecume.sweep.executors import ExecutorOptions

POINTS = sized(200, 16)
WANTED = 1.8
ROUNDS = sized(2, 1)
SWEEP = """
process = "t1"
[[axes]]
key = "gap"
span = {{ start = 1e-4, stop = 1e-1, count = {count}, log = true }}
[[axes]]
key = "reduced_force"
values = [1e-5, 1e-4, 1e-3, 1e-2]
"""


def seconds(file: Path, folder: Path, workers: int) -> float:
    """For all points, from the pace of those after the first few."""
    ends: list[float] = []
    done = sweep(
        file,
        folder,
        ExecutorOptions(workers=workers, progress=lambda done, _: ends.append(time.perf_counter()) if done else None),
    )
    assert not done.failed
    skipped = 4 * workers
    return (ends[-1] - ends[skipped]) * len(ends) / (len(ends) - 1 - skipped)


def main(points: int) -> None:
    """Print times in turns, and the ratio of the best."""
    print(f"{machine()}, {points} points\n")
    best = {1: float("inf"), 2: float("inf")}
    with tempfile.TemporaryDirectory() as place:
        file = Path(place) / "durations.toml"
        file.write_text(SWEEP.format(count=max(2, points // 4)))
        for turn in range(ROUNDS):
            for workers in best:
                took = seconds(file, Path(place) / f"{turn}-{workers}", workers)
                best[workers] = min(best[workers], took)
                print(f"{workers} workers: {took:.1f} s")
    print(f"\ntwo workers over one: {best[1] / best[2]:.2f} times as fast (wanted: at least {WANTED:g})")


if __name__ == "__main__":
    parser = parser_of(__doc__)
    parser.add_argument("points", metavar="POINTS", type=int, nargs="?", default=POINTS)
    main(parser.parse_args().points)
