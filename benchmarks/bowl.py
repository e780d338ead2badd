"""Steps a second of sixty cereals in a bowl: while they drift, and as settled rafts.

python benchmarks/bowl.py
"""

from __future__ import annotations

from marching import March, cereal_bowl, machine, seconds

from ecume._jit import use_threads

COUNT = 60
DRIFT = 2.0
"""Simulated seconds of drifting that are timed."""
LONGEST = 600.0
AT_REST = 1e-6
TRIES = 3
WANTED = {"drifting": 20_000, "settled": 3_000}


def drifting() -> float:
    """Steps a second in the first simulated seconds: the best of three."""
    best = float("inf")
    for _ in range(TRIES):
        march = March(cereal_bowl(COUNT))
        march.go(1)
        steps = round(DRIFT / march.parameters.time_step)
        best = min(best, seconds(lambda march=march, steps=steps: march.go(steps)))
    return steps / best


def settle(march: March) -> None:
    """March until everyone is at rest, or for ten simulated minutes."""
    second = round(1.0 / march.parameters.time_step)
    while march.time < LONGEST and (march.time < DRIFT or march.numbers()["largest_speed"] >= AT_REST):
        march.go(second)


def main() -> None:
    """Print both."""
    use_threads(1)
    print(f"{machine()}\n")
    March(cereal_bowl(COUNT)).go(1)
    rates = {"drifting": drifting()}
    march = March(cereal_bowl(COUNT))
    took = seconds(lambda: settle(march))
    numbers, marched = march.numbers(), int(march.state.step[0])
    steps = round(DRIFT / march.parameters.time_step)
    rates["settled"] = steps / min(seconds(lambda: march.go(steps)) for _ in range(TRIES))
    print(f"time step {march.parameters.time_step * 1e3:.3g} ms")
    overlap = numbers["largest_overlap"] / march.parameters.floats.radius[0]
    print(f"settled after {march.time:.0f} s: speed {numbers['largest_speed']:.1e} m/s,")
    print(f"  {numbers['contacts']:.0f} contacts, {numbers['clusters']:.0f} clusters, overlap {overlap:.1e} R")
    print(f"on the way there: {marched / took:,.0f} steps/s")
    for name, rate in rates.items():
        print(f"{name}: {rate:,.0f} steps/s (wanted: {WANTED[name]:,})")


if __name__ == "__main__":
    main()
