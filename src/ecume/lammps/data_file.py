"""The first state as a data file of LAMMPS."""

from __future__ import annotations

import math

import numpy as np

from ecume.lammps.numbers import DeckNumbers
from ecume.lammps.walls import box_of


def density_of(deck: DeckNumbers) -> list[float]:
    """The densities (kg/m^3) with which spheres of these radii have the masses of the floats."""
    floats = deck.parameters.floats
    found: list[float] = (floats.mass / (4.0 / 3.0 * math.pi * floats.radius**3)).tolist()
    return found


def thickness_of(deck: DeckNumbers) -> float:
    """Half of the thickness of the box (m), which has no meaning in 2D; LAMMPS refuses one far below the cutoff."""
    return max(float(deck.parameters.floats.radius.max()), 0.1 * deck.parameters.cutoff)


def data_text(deck: DeckNumbers) -> str:
    """The data file: box, atoms of the style `sphere`, velocities."""
    x_low, x_high, y_low, y_high = box_of(deck)
    half = thickness_of(deck)
    state = deck.state
    spin = state.turning[:, 1] if len(state.turning) and state.turning.shape[1] else np.zeros(len(state.position))
    numbers = range(1, len(state.position) + 1)
    atoms = zip(numbers, (deck.kind + 1).tolist(), (2.0 * deck.parameters.floats.radius).tolist(), density_of(deck),
                *state.position.T.tolist(), strict=True)  # fmt: skip
    speeds = zip(numbers, *state.velocity.T.tolist(), spin.tolist(), strict=True)
    return "\n".join(
        [
            f"{deck.scene.title or 'Floats'}, written by ecume; SI units",
            "",
            f"{len(state.position)} atoms",
            f"{len(deck.kinds)} atom types",
            "",
            f"{x_low!r} {x_high!r} xlo xhi",
            f"{y_low!r} {y_high!r} ylo yhi",
            f"{-half!r} {half!r} zlo zhi",
            "",
            "Atoms  # sphere",
            "",
            *(f"{n} {kind} {diameter!r} {density!r} {x!r} {y!r} 0.0" for n, kind, diameter, density, x, y in atoms),
            "",
            "Velocities",
            "",
            *(f"{n} {vx!r} {vy!r} 0.0 0.0 0.0 {turn!r}" for n, vx, vy, turn in speeds),
            "",
        ]
    )
