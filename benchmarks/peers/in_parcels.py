"""Tracers in a steady gyre on a grid in parcels: processor time per particle and step, and the peak of memory.

    python in_parcels.py COUNT STEPS

Runs in an environment that has parcels; prints a line of JSON.
"""

from __future__ import annotations

import json
import resource
import sys
import time

import numpy as np
import parcels
import parcels.kernels
from parcels._datasets.structured.generated import simple_UV_dataset

NODES = (129, 65)
"""Of the grid, along x and y."""
STEP = 0.01
"""s"""


def main(count: int, steps: int) -> None:
    """Integrate, and print the costs."""
    x, y = np.linspace(0.0, 2.0, NODES[0]), np.linspace(0.0, 1.0, NODES[1])
    data = simple_UV_dataset(n_times=2, nz=2, ny=NODES[1], nx=NODES[0], mesh="flat").assign_coords(
        lon=("XG", x, {"axis": "X"}), lat=("YG", y, {"axis": "Y"})
    )
    across, up = np.meshgrid(x, y)
    data["U"].data[:] = -np.sin(np.pi * across) * np.cos(np.pi * up)
    data["V"].data[:] = np.cos(np.pi * across) * np.sin(np.pi * up)
    fields = parcels.FieldSet.from_sgrid_conventions(data.isel(time=slice(0, 1)), mesh="flat")
    start = np.random.default_rng(1).uniform((0.05, 0.05), (1.95, 0.95), (count, 2))
    particles = parcels.ParticleSet(fields, x=start[:, 0], y=start[:, 1], z=np.zeros(count))
    step = np.timedelta64(round(1e3 * STEP), "ms")
    advect = {"dt": step, "verbose_progress": False}
    particles.execute(parcels.kernels.AdvectionRK4, runtime=step, **advect)
    begun = time.process_time()
    particles.execute(parcels.kernels.AdvectionRK4, runtime=steps * step, **advect)
    taken = time.process_time() - begun
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024.0
    found = {
        "seconds": taken / count / steps,
        "peak": peak,
        "x": float(np.mean(particles.x)),
        "version": parcels.__version__,
    }
    print(json.dumps(found))


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
