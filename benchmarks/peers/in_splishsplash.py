"""SPlisHSPlasH: WCSPH. Its support is always twice the spacing, so that a particle has a third of the neighbors.

OMP_NUM_THREADS=THREADS python in_splishsplash.py EDGE STEPS THREADS
"""

from __future__ import annotations

import contextlib
import ctypes
import json
import os
import tempfile
from pathlib import Path

import cube

edge, steps, threads = cube.asked()
os.environ["OMP_NUM_THREADS"] = str(threads)
with contextlib.suppress(OSError):
    # The wheel's own copy of this library does not get on with a newer system's graphics libraries.
    ctypes.CDLL("libGLdispatch.so.0", ctypes.RTLD_GLOBAL)

import pysplishsplash  # noqa: E402

WCSPH = 0
WARM_UP = 3


def scene() -> dict[str, object]:
    """A block of particles one diameter apart, nothing else."""
    side = (edge + 0.5) * cube.SPACING
    return {
        "Configuration": {
            "particleRadius": 0.5 * cube.SPACING, "simulationMethod": WCSPH, "gravitation": [0, 0, 0],
            "cflMethod": 0, "timeStepSize": cube.TIME_STEP, "stiffness": cube.DENSITY * cube.SOUND**2 / 7.0,
            "exponent": cube.STIFFENING, "enableVTKExport": False, "enablePartioExport": False, "pause": False,
        },
        "Fluid": {"density0": cube.DENSITY, "viscosityMethod": 1, "Viscosity": {"viscosity": 0.01}},
        "FluidBlocks": [{"denseMode": 0, "start": [0, 0, 0], "end": [side, side, side]}],
    }  # fmt: skip


def main() -> None:
    """Time so many steps."""
    folder = Path(tempfile.mkdtemp())
    path = folder / "cube.json"
    path.write_text(json.dumps(scene()))
    base = pysplishsplash.Exec.SimulatorBase()
    stop = (WARM_UP + steps + 0.5) * cube.TIME_STEP
    base.init(useGui=False, sceneFile=str(path), outputDir=str(folder), initialPause=False, stopAt=stop)
    base.initSimulation()
    watches: list[cube.Watch] = []
    base.setTimeStepCB(lambda: watches.append(cube.Watch()))
    base.runSimulation()
    simulation = pysplishsplash.Simulation.getCurrent()
    count = simulation.getFluidModel(0).numActiveParticles()
    some = range(0, count, 97)
    neighbors = sum(simulation.numberOfNeighbors(0, 0, i) for i in some) / len(some)
    watches[WARM_UP - 1].report(len(watches) - WARM_UP, count, neighbors=neighbors)


main()
