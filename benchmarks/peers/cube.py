"""The cube of water that every package integrates: a free jittered block, no walls, no gravity.

Only NumPy, since each package runs this with a Python of its own.
"""

from __future__ import annotations

import json
import sys
import time
from dataclasses import dataclass

import numpy as np

DENSITY = 1000.0
SOUND = 20.0
"""m/s"""
ALPHA = 0.1
STIFFENING = 7.0
SPACING = 0.01
"""Radius of the kernels' support (m)."""
REACH = 2.8
"""Radius of the kernel's support over the spacing."""
TIME_STEP = 1e-4
"""s: 0.14 h/c"""
JITTER = 0.1
SPEED = 0.1
"""m/s: the standard deviation of each component at the start"""
SEED = 1


@dataclass(frozen=True)
class Cube:
    """Where the particles are, and how fast."""

    position: np.ndarray
    """(N, 3) m"""
    velocity: np.ndarray
    """(N, 3) m/s"""

    @property
    def mass(self) -> float:
        """Of one particle (kg)."""
        return DENSITY * SPACING**3

    @property
    def count(self) -> int:
        """Particles."""
        return len(self.position)

    @property
    def support(self) -> float:
        """Radius of the kernels' support (m)."""
        return REACH * SPACING


def cube(edge: int) -> Cube:
    """`edge`³ particles."""
    random = np.random.default_rng(SEED)
    along = np.arange(edge) + 0.5
    lattice = np.stack(np.meshgrid(along, along, along, indexing="ij"), axis=-1).reshape(-1, 3)
    position = SPACING * (lattice + random.uniform(-JITTER, JITTER, lattice.shape))
    return Cube(position, random.normal(0.0, SPEED, lattice.shape))


def asked() -> tuple[int, int, int]:
    """Edge, steps and threads from the command line."""
    edge, steps, threads = (int(word) for word in sys.argv[1:4])
    return edge, steps, threads


class Watch:
    """Wall and processor time since it was made."""

    def __init__(self) -> None:
        self.wall, self.processor = time.perf_counter(), time.process_time()

    def report(self, steps: int, count: int, **more: object) -> None:
        """One line for whoever started this process."""
        wall, processor = time.perf_counter() - self.wall, time.process_time() - self.processor
        found = {"wall": wall, "processor": processor, "steps": steps, "count": count, **more}
        print("RESULT " + json.dumps(found), flush=True)
