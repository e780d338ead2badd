"""Floats that LAMMPS integrates: commands, and the state that it hands back."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from ecume.lammps.expressible import calls_us, require_simulable
from ecume.lammps.numbers import numbers_of, parameters_for
from ecume.lammps.pair_tables import pair_tables, text_of
from ecume.lammps.process import SCENE
from ecume.lammps.script import DATA, TABLES, data_text, external_text, setup_text
from ecume.models.costs import within_steps
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.state import DEEPEST, State
from ecume.models.floating.time_integration.integrators import is_driven
from ecume.models.invariants import ENERGY, INJECTED, Invariant
from ecume.scenes.schema import to_plain
from ecume.trajectories.frame import Frame
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.models.model import Model
    from ecume.scenes.floating import FloatingScene

COLUMNS = ("x", "y", "vx", "vy", "omegaz")
UNKNOWN = ("angle", "collisions", "contact_sweeps", "unconverged_steps")
"""Quantities of frames that LAMMPS does not compute."""


def parameters(scene: FloatingScene) -> Parameters:
    """The parameters of a scene with springs as contacts. Raises SceneError for what LAMMPS cannot express."""
    require_simulable(scene)
    return within_steps(scene, parameters_for(scene))


def commands(scene: FloatingScene, parameters: Parameters, state: State) -> tuple[dict[str, str], str]:
    """The files and commands with which LAMMPS continues from a state."""
    deck = numbers_of(scene, parameters, state)
    if calls_us(scene):
        alike = deck._replace(kinds=deck.kinds[:1], kind=np.zeros_like(deck.kind))
        return {DATA: data_text(alike), SCENE: json.dumps(to_plain(scene))}, external_text(alike)
    tables = list(pair_tables(deck))
    files = {DATA: data_text(deck), **({TABLES: "".join(map(text_of, tables))} if tables else {})}
    return files, setup_text(deck, tables)


def take(scene: FloatingScene, parameters: Parameters, state: State, found: Array) -> None:
    """Particles of LAMMPS become the state."""
    state.position[:], state.velocity[:] = found[:, :2], found[:, 2:4]
    state.reference[:] = state.position
    if state.turning.shape[1]:
        state.turning[:, 1] = found[:, 4]


def observe(model: Model, parameters: Parameters, state: State) -> Frame:
    """The frame of a state, without quantities that need sums over all steps."""
    frame = model.observe(parameters, state, model.workspace(parameters, state, 1.0))
    state.tally[DEEPEST] = max(state.tally[DEEPEST], frame.numbers["largest_overlap"])
    numbers = {**frame.numbers, "deepest_overlap": float(state.tally[DEEPEST])}
    missing = {*UNKNOWN, INJECTED}
    return frame._replace(
        arrays={name: array for name, array in frame.arrays.items() if name not in missing},
        numbers={name: value for name, value in numbers.items() if name not in missing},
        units={name: unit for name, unit in frame.units.items() if name not in missing},
    )


def invariants(model: Model, scene: Any, parameters: Parameters) -> list[Invariant]:
    """The invariants of floats; driven floats have no energy budget here."""
    dropped = {"contacts", *([ENERGY] if is_driven(parameters) else [])}
    return [row for row in model.invariants(scene, parameters) if row.name not in dropped]
