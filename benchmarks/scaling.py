"""The time per float and step, from one to ten thousand floats at one density, with one and with two threads.

python benchmarks/scaling.py
"""

from __future__ import annotations

from timed_runs import TimedRun, heavy_spheres, machine, seconds

from ecume._jit import use_threads
from ecume._quick import parser_of, sized

COUNTS = sized((1, 10, 100, 1_000, 10_000), (1, 10, 100))
WARM_UP = sized(100, 10)
"""Steps before the clock starts: afterwards all move and the neighbor lists are renewed now and then."""
LEAST_WORK = sized(300_000, 1_000)
"""Floats times steps that one figure is taken from; at least 100 steps."""
TRIES = sized(3, 1)
WANTED = 1.5


def nanoseconds(count: int, threads: int) -> float:
    """Per float and step: the best of three goes."""
    use_threads(threads)
    run = TimedRun(heavy_spheres(f"count = {count}\n"))
    run.go(WARM_UP)
    steps = max(100, LEAST_WORK // count)
    return min(seconds(lambda: run.go(steps)) for _ in range(TRIES)) / (steps * count) * 1e9


def main() -> None:
    """Print the table and the ratio."""
    parser_of(__doc__).parse_args()
    print(f"{machine()}\n\nfloats cover 15 % of an open surface; ns per float and step")
    print("  floats   1 thread   2 threads")
    for threads in (1, 2):
        nanoseconds(10, threads)
    cost = {count: [nanoseconds(count, threads) for threads in (1, 2)] for count in COUNTS}
    for count, (one, two) in cost.items():
        print(f"{count:8d} {one:10.0f} {two:11.0f}")
    for threads in (1, 2):
        *_, fewer, most = COUNTS
        ratio = cost[most][threads - 1] / cost[fewer][threads - 1]
        print(f"cost({most:,}) / cost({fewer:,}), threads = {threads}: {ratio:.2f} (wanted: at most {WANTED})")


if __name__ == "__main__":
    main()
