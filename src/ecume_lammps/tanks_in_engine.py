"""Tanks that LAMMPS integrates: commands, and the state that it returns."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ecume.models.invariants import ENERGY, INJECTED, Invariant
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.report.energy_budget import has_external_work
from ecume.models.sph.state import State
from ecume.scenes.sph import SphScene
from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume_lammps.expressible import require_expressible
from ecume_lammps.tanks import DATA, TANKS, axes_of, data_text, folded, parameters_for, setup_text, tank_of

if TYPE_CHECKING:
    from ecume.models.model import Model

COLUMNS = ("x", "y", "z", "vx", "vy", "vz", "c_density")
GROUP = "liquid"
UNKNOWN = (INJECTED, "numerical_work", "guard_hits", "substeps", "most_substeps")
"""Numbers of frames that LAMMPS does not compute."""


def parameters(scene: SphScene) -> Parameters:
    """The parameters of a tank with LAMMPS's time step. Raises SceneError for features that LAMMPS cannot express."""
    require(scene)
    return parameters_for(scene)


def require(scene: SphScene) -> None:
    """Raise SceneError for features that LAMMPS cannot express."""
    require_expressible(scene, TANKS)


def commands(scene: SphScene, parameters: Parameters, state: State) -> tuple[dict[str, str], str]:
    """The files and commands from which LAMMPS continues a state."""
    tank = tank_of(scene, parameters, state)
    return {DATA: data_text(tank)}, setup_text(tank)


def take(scene: SphScene, parameters: Parameters, state: State, found: Array) -> None:
    """Copy the particles of LAMMPS to the state."""
    tank_axes, dimension, speed = axes_of(scene), parameters.dimension, parameters.material.sound_speed
    place, velocity = scene.spacing * found[:, :dimension], speed * found[:, 3 : 3 + dimension]
    position, velocity = folded(tank_axes, place, velocity)
    state.position[:], state.velocity[:] = position.T, velocity.T
    state.reference[:] = state.position
    state.density[:] = parameters.material.density * found[:, 6]
    state.ready[0] = 0


def observe(model: Model, parameters: Parameters, state: State) -> Frame:
    """The frame of a state, without numbers that need sums over all steps."""
    state.clock[:] = int(state.step[0]) * parameters.time_step
    frame = model.observe(parameters, state, model.workspace(parameters, state, 1.0))
    missing = {name for name in frame.numbers if name in UNKNOWN or name.endswith("_hits")}
    return frame._replace(
        numbers={name: value for name, value in frame.numbers.items() if name not in missing},
        units={name: unit for name, unit in frame.units.items() if name not in missing},
    )


def invariants(model: Model, scene: Any, parameters: Parameters) -> list[Invariant]:
    """The invariants of a tank, without those of walls, which have no guard here, and without the energy budget, since
    the work is unknown.
    """
    dropped = {"guard", *([ENERGY] if has_external_work(parameters) else [])}
    return [row for row in model.invariants(scene, parameters) if row.name not in dropped]
