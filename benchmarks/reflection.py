"""The number of particles per second that make a step with walls: `python benchmarks/reflection.py [PARTICLES]`.

The core, as a model calls it: arrays in place, no checks. Prints particles x steps a second, for tanks and for how many
hits a particle has in a step. By processor time, which other work on the machine disturbs less than wall time: of one
core, whatever the threads.
"""

from __future__ import annotations

import time

import numpy as np

from ecume._jit import use_threads
from ecume._quick import parser_of, sized
from ecume.engine import walls

STEPS = 10
PARTICLES = sized(200_000, 2_000)


def measure(tank, count: int, way: float, fall: float) -> tuple[float, float]:
    """Particles x steps a second of a core, and hits of a particle in a step of that way (in lengths of the tank)."""
    dice, d = np.random.default_rng(1), tank.dimension
    position = dice.uniform(0.1, 0.3, (count, d))
    velocity = way * dice.normal(size=(count, d)) / np.sqrt(d)
    push = np.zeros((1, d))
    push[0, -1] = -fall
    tally = np.zeros(count, np.int64), np.zeros(count, np.int64), np.zeros(len(tank.kind), np.int64)
    given = (position, velocity, push, 1.0, walls.sheet(tank, 0.95), np.zeros(1), tally)
    walls.reflect_all(*given)
    before, began = tally[2].sum(), time.process_time()
    for _ in range(STEPS):
        if walls.reflect_all(*given):
            raise SystemExit("somebody was outside")
    took = time.process_time() - began
    return count * STEPS / took, float(tally[2].sum() - before) / (count * STEPS)


def main(count: int) -> None:
    """The table."""
    heptagon = walls.polygon([(np.cos(a), np.sin(a)) for a in 2.0 * np.pi * np.arange(7) / 7])
    tanks = {
        "rectangle": walls.box((0.0, 0.0), (1.0, 1.0)),
        "box": walls.box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)),
        "heptagon": heptagon,
        "circle": walls.disc((0.0, 0.0), 1.0),
        "rectangle with an obstacle": walls.together(
            walls.box((0.0, 0.0), (1.0, 1.0)), walls.outside(walls.polygon([(0.4, 0.4), (0.8, 0.5), (0.5, 0.8)]))
        ),
    }
    use_threads(1)
    print(f"{count} particles, one thread")
    print(f"{'tank':30s} {'way':>6s} {'fall':>6s} {'hits a step':>12s} {'particles x steps / s':>22s}")
    for name, tank in tanks.items():
        for way, fall in ((1e-3, 0.0), (0.3, 0.0), (0.3, 0.3), (1.0, 0.0)):
            rate, hits = measure(tank, count, way, fall)
            print(f"{name:30s} {way:6g} {fall:6g} {hits:12.3f} {rate:22.3g}")


if __name__ == "__main__":
    parser = parser_of(__doc__)
    parser.add_argument("particles", metavar="PARTICLES", type=int, nargs="?", default=PARTICLES)
    main(parser.parse_args().particles)
