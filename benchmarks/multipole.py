"""Time, memory and iterations of the multipole solver, for hexagonal rafts of tilted pinned discs.

`python benchmarks/multipole.py [ORDER]` prints a row for each raft and method; compilation is not counted. Elimination
is left out where its matrix would take more than two gigabytes.
"""

from __future__ import annotations

import time
import tracemalloc

import numpy as np

from ecume._quick import parser_of, sized
from ecume.laws import flotation, multipole

UNIT = flotation.Liquid(density=1000.0, surface_tension=1.0, viscosity=1e-3, gravity=1e-3)
DISC = flotation.Disc(0.5, 1e-3)
GAP = 0.02
COUNTS = sized((7, 19, 91, 300), (7,))
ORDER = sized(20, 4)
MOST_BYTES = 2e9


def raft(count: int) -> np.ndarray:
    """The places nearest to the middle of a triangular lattice."""
    side = np.arange(-20, 21)
    i, j = (each.ravel() for each in np.meshgrid(side, side))
    places = 2.0 * DISC.radius * (1.0 + GAP) * np.stack([i + 0.5 * j, np.sqrt(0.75) * j], axis=1)
    return places[np.argsort(np.round(np.hypot(*places.T), 9), kind="stable")[:count]]


def measured(count: int, order: int, method: str) -> tuple[float, float, int, float]:
    """Seconds, megabytes at the peak, turns, and the sum of forces over the largest."""
    places, bodies = raft(count), [DISC] * count
    tracemalloc.start()
    began = time.perf_counter()
    found = multipole.solve(places, bodies, UNIT, order, method=method)
    took = time.perf_counter() - began
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    left = float(np.abs(found.forces.sum(axis=0)).max() / np.abs(found.forces).max())
    return took, peak / 1e6, found.iterations, left


def main(order: int) -> None:
    """Print the table."""
    for method in ("dense", "iterative"):
        measured(7, order, method)
    print(f"order {order}, gap {GAP:g} of a diameter")
    print(f"{'discs':>6} {'unknowns':>9} {'method':>10} {'seconds':>9} {'MB':>8} {'turns':>6} {'sum of forces':>14}")
    for count in COUNTS:
        unknowns = count * (2 * order + 1)
        for method in ("dense", "iterative"):
            if method == "dense" and 8.0 * unknowns**2 > MOST_BYTES:
                continue
            took, peak, turns, left = measured(count, order, method)
            print(f"{count:6d} {unknowns:9d} {method:>10} {took:9.3f} {peak:8.1f} {turns:6d} {left:14.1e}")


if __name__ == "__main__":
    parser = parser_of(__doc__)
    parser.add_argument("order", metavar="ORDER", type=int, nargs="?", default=ORDER)
    main(parser.parse_args().order)
