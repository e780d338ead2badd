"""Floats that LAMMPS integrates: commands, the state that it returns, and ecume's forces on the
particles of a rank.

A rank has local particles, and ghosts of particles of other ranks and of the periodic box. Ghosts are particles with
known positions, so that sums over pairs need no periodic images. The forces on ghosts are incomplete and are not used.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.models.costs import within_steps
from ecume.models.floating.parameters import DEEPEST, Parameters, State, Workspace, is_driven, make_state
from ecume.models.floating.record import workspace
from ecume.models.floating.setup.initial_state import with_parts
from ecume.models.floating.time_integration.integration import forces_at
from ecume.models.invariants import ENERGY, INJECTED, Invariant
from ecume.scenes.schema import to_plain
from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume_lammps.expressible import calls_us, require_simulable
from ecume_lammps.numbers import numbers_of, parameters_for
from ecume_lammps.pair_tables import pair_tables, text_of
from ecume_lammps.process import SCENE
from ecume_lammps.script import DATA, TABLES, data_text, external_text, setup_text

if TYPE_CHECKING:
    from ecume.models.model import Model
    from ecume.scenes.floating import FloatingScene

COLUMNS = ("x", "y", "vx", "vy", "omegaz")
UNKNOWN = ("angle", "collisions", "contact_sweeps", "unconverged_steps")
"""Quantities of frames that LAMMPS does not compute."""


def parameters(scene: FloatingScene) -> Parameters:
    """The parameters of a scene with spring contacts. Raises SceneError for features that LAMMPS cannot express."""
    require_simulable(scene)
    return within_steps(scene, parameters_for(scene))


def commands(scene: FloatingScene, parameters: Parameters, state: State) -> tuple[dict[str, str], str]:
    """The files and commands from which LAMMPS continues a state."""
    deck = numbers_of(scene, parameters, state)
    if calls_us(scene):
        alike = deck._replace(kinds=deck.kinds[:1], kind=np.zeros_like(deck.kind))
        return {DATA: data_text(alike), SCENE: json.dumps(to_plain(scene))}, external_text(alike)
    tables = list(pair_tables(deck))
    files = {DATA: data_text(deck), **({TABLES: "".join(map(text_of, tables))} if tables else {})}
    return files, setup_text(deck, tables)


def take(scene: FloatingScene, parameters: Parameters, state: State, found: Array) -> None:
    """Copy the particles of LAMMPS to the state."""
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


class Kept(NamedTuple):
    """Neighbor lists, and the positions for which they are valid."""

    which: Integers
    position: Array
    parameters: Parameters
    workspace: Workspace


class ExternalForces:
    """The forces of a scene on some of its floats, with their drag."""

    def __init__(self, parameters: Parameters) -> None:
        """`parameters` are those of all floats."""
        self._parameters = parameters
        self._kept: Kept | None = None

    def __call__(self, which: Integers, position: Array, velocity: Array) -> Array:
        """The forces (N) on the first floats, one per velocity; `which` are the indices of all floats."""
        own = len(velocity)
        kept = self._kept
        if kept is None or not _holds(kept, which, position):
            kept = self._kept = _listed(part_of(self._parameters, which), which, position)
        floats = kept.parameters.floats
        friction = (floats.mass / floats.relaxation_time)[:own, None]
        found: Array = forces_at(kept.parameters, position, kept.workspace)[:own] - friction * velocity
        return found


def part_of(parameters: Parameters, which: Integers) -> Parameters:
    """The parameters of these floats, which may be repeated, without the periodic cell."""
    count, kick = len(parameters.floats.radius), parameters.kick
    rows = np.concatenate([which, np.arange(count, len(kick.mobility))])
    return parameters._replace(
        floats=parameters.floats._replace(**{name: row[which] for name, row in parameters.floats._asdict().items()}),
        kick=kick._replace(decay=kick.decay[which], gain=kick.gain[which], mobility=kick.mobility[rows]),
        wall_strength=np.ascontiguousarray(parameters.wall_strength[:, which]),
        periods=np.zeros_like(parameters.periods),
    )


def _holds(kept: Kept, which: Integers, position: Array) -> bool:
    """Whether neighbor lists are valid: the floats are the same, and none has moved by more than half of the skin."""
    if not np.array_equal(kept.which, which):
        return False
    return bool(np.linalg.norm(position - kept.position, axis=1).max() <= 0.5 * kept.parameters.skin)


def _listed(parameters: Parameters, which: Integers, position: Array) -> Kept:
    """New neighbor lists at these positions."""
    state = with_parts(make_state(position.copy(), np.zeros_like(position)), parameters)
    return Kept(which.copy(), position.copy(), parameters, workspace(parameters, state, 1.0))
