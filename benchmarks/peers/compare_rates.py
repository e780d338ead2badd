"""The rates of one state in ecume and LAMMPS, with Lucy's kernel in both: the two integrate the same equations.

    python compare_rates.py

A small cube is integrated by LAMMPS until its density varies. Rates of density and, without artificial viscosity,
accelerations are then equal to rounding. With it they differ by the density that divides it: LAMMPS has that of the
pair, ecume the reference density.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import cube
import in_ecume
import in_lammps
import numpy as np

from ecume.models.sph.rates.right_hand_side import evaluate_rates

EDGE, STEPS = 6, 20
SAME = {"density": 1e-12, "pressure": 1e-12, "viscosity": 1e-2}
"""The largest differences allowed: of the rate of density, of the acceleration by pressure, of that by viscosity."""


def rates_in_lammps(alpha: float) -> dict[str, Any]:
    """The state after some steps, in the order of the particles, with accelerations and rates of density."""
    water = cube.cube(EDGE)
    engine = in_lammps.engine_of(water, EDGE, in_lammps.SKIN)
    engine.command(f"run {STEPS} post no")
    engine.command(f"pair_coeff * * {cube.DENSITY} {cube.SOUND} {alpha} {water.support}")
    engine.command("run 0 post no")
    wide, order = {"x": 3, "vest": 3, "f": 3}, np.argsort(engine.numpy.extract_atom("id", nelem=water.count))
    names = ("x", "vest", "f", "rho", "drho")
    found = {
        name: np.array(engine.numpy.extract_atom(name, nelem=water.count, dim=wide.get(name, 1))) for name in names
    }
    return {name: values.reshape(water.count, -1)[order].T for name, values in found.items()}


def rates_in_ecume(there: dict[str, Any], alpha: float) -> tuple[Any, Any]:
    """The accelerations and the rates of density of the same state."""
    run = in_ecume.run_of(EDGE, "double", kernel="lucy", alpha=alpha)
    state = run.state
    state.position[...], state.velocity[...], state.density[...] = there["x"], there["vest"], there["rho"][0]
    state.reference[...] = there["x"]
    run.workspace = run.model.workspace(run.parameters, state, 1.0)
    evaluate_rates(run.parameters, state, run.workspace, 0.0)
    return state.acceleration.copy(), state.density_rate.copy()


def differences() -> dict[str, float]:
    """The largest differences between both programs, over the largest values."""
    there = {alpha: rates_in_lammps(alpha) for alpha in (0.0, cube.ALPHA)}
    here = {alpha: rates_in_ecume(there[alpha], alpha) for alpha in there}
    mass = cube.cube(EDGE).mass
    theirs = {alpha: found["f"] / mass for alpha, found in there.items()}
    viscous = theirs[cube.ALPHA] - theirs[0.0], here[cube.ALPHA][0] - here[0.0][0]
    pairs = {
        "density": (there[0.0]["drho"][0], here[0.0][1]),
        "pressure": (theirs[0.0], here[0.0][0]),
        "viscosity": viscous,
    }
    return {name: float(np.abs(a - b).max() / np.abs(a).max()) for name, (a, b) in pairs.items()}


def main() -> int:
    """Print the differences; 1 if one of them is too large."""
    found = differences()
    print("RESULT " + json.dumps(found))
    return int(any(found[name] > most for name, most in SAME.items()))


if __name__ == "__main__":
    sys.exit(main())
