"""Cost of a float and step, from one float to ten thousand at one density, with one and with two threads.

python benchmarks/scaling.py
"""

from __future__ import annotations

from timed_runs import TimedRun, heavy_spheres, machine, seconds

from ecume._jit import use_threads

COUNTS = (1, 10, 100, 1_000, 10_000)
WARM_UP = 100
"""Steps before the clock starts: afterwards all move and the neighbor lists are renewed now and then."""
LEAST_WORK = 300_000
"""Floats times steps that one figure is taken from; at least 100 steps."""
TRIES = 3
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
    print(f"{machine()}\n\nfloats cover 15 % of an open surface; ns per float and step")
    print("  floats   1 thread   2 threads")
    for threads in (1, 2):
        nanoseconds(10, threads)
    cost = {count: [nanoseconds(count, threads) for threads in (1, 2)] for count in COUNTS}
    for count, (one, two) in cost.items():
        print(f"{count:8d} {one:10.0f} {two:11.0f}")
    for threads in (1, 2):
        ratio = cost[10_000][threads - 1] / cost[1_000][threads - 1]
        print(f"cost(10,000) / cost(1,000), threads = {threads}: {ratio:.2f} (wanted: at most {WANTED})")


if __name__ == "__main__":
    main()
