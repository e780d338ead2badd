"""SPlisHSPlasH: DFSPH with walls of particles, in single precision. Its support is twice the spacing.

python dam_in_splishsplash.py DEEP
"""

from __future__ import annotations

import contextlib
import ctypes
import json
import sys
import tempfile
import time
from pathlib import Path

import dam
import numpy as np

with contextlib.suppress(OSError):
    # The wheel's copy of this library does not get on with a newer system's graphics libraries.
    ctypes.CDLL("libGLdispatch.so.0", ctypes.RTLD_GLOBAL)

import pysplishsplash

DFSPH = 4
COURANT = 0.5
"""Of the spacing over the speed, as in ecume: a quarter of its smoothing length, which is two spacings."""


def scene(deep: int) -> dict[str, object]:
    """The dam; walls are the inside of a box."""
    spacing = 1.0 / deep
    models = Path(sys.prefix) / "bin" / "data" / "models"
    return {
        "Configuration": {
            "particleRadius": 0.5 * spacing, "simulationMethod": DFSPH, "gravitation": [0, -1, 0], "sim2D": True,
            "cflMethod": 1, "cflFactor": COURANT, "cflMaxTimeStepSize": 0.25 * spacing, "timeStepSize": 0.1 * spacing,
            "maxIterations": 100, "maxError": 0.01, "maxIterationsV": 100, "maxErrorV": 0.1,
            "enableDivergenceSolver": True, "boundaryHandlingMethod": 0,
            "enableVTKExport": False, "enablePartioExport": False, "pause": False,
        },
        "Fluid": {"density0": 1.0, "viscosityMethod": 1, "Viscosity": {"viscosity": 0.0, "viscosityBoundary": 0.0}},
        "FluidBlocks": [{"denseMode": 0, "start": [0.0, 0.0, -1.0], "end": [dam.WIDTH, dam.HEIGHT, 1.0]}],
        "RigidBodies": [
            {
                "geometryFile": str(models / "UnitBox.obj"), "isWall": True, "isDynamic": False, "mapInvert": True,
                "translation": [0.5 * dam.LENGTH, 1.0, 0.0], "rotationAxis": [1, 0, 0], "rotationAngle": 0,
                "scale": [dam.LENGTH, 2.0, 1.0], "color": [0, 0, 0, 0],
            }
        ],
    }  # fmt: skip


def main(deep: int) -> None:
    """Time all steps, and read the front at the times that are compared."""
    folder = Path(tempfile.mkdtemp())
    path = folder / "dam.json"
    path.write_text(json.dumps(scene(deep)))
    base = pysplishsplash.Exec.SimulatorBase()
    base.init(useGui=False, sceneFile=str(path), outputDir=str(folder), initialPause=False, stopAt=dam.END + 0.01)
    base.initSimulation()
    front: dict[float, float] = {}
    steps = [0]

    def read() -> None:
        steps[0] += 1
        now = pysplishsplash.TimeManager.getCurrent().getTime()
        due = dam.EVERY * (len(front) + 1)
        if now >= due and due <= dam.END:
            model = pysplishsplash.Simulation.getCurrent().getFluidModel(0)
            front[due] = float(np.array(model.getFieldBuffer("position"))[:, 0].max())

    base.setTimeStepCB(read)
    began = time.perf_counter(), time.process_time()
    base.runSimulation()
    dam.report(time.perf_counter() - began[0], time.process_time() - began[1], steps[0], front)


main(int(sys.argv[1]))
