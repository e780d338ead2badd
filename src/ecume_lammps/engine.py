"""LAMMPS as the engine of a run: it integrates from pause to pause, and ecume keeps the state.

The commands are generated from the validated scene and from the state of the checkpoint at every start. Frames,
checkpoints, invariants and numbers are those of the scene's model, computed from positions and velocities that LAMMPS
returns. `SYSTEMS` has a row for each model: its parameters, its commands, and the columns of its particles.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np

from ecume.errors import BadInput, Diverged
from ecume.models.model import DIVERGED, DONE, LAMMPS, Engine, Model
from ecume.trajectories.frame import Frame
from ecume.units import Array, with_prefix
from ecume_lammps import floats_in_engine, tanks_in_engine
from ecume_lammps.expressible import require_simulable
from ecume_lammps.process import Lammps, Program, program

BALANCING = "fix balance all balance 1000 1.1 shift xy 10 1.05"
"""The command that adapts the domains of ranks to the particles."""


class System(NamedTuple):
    """The functions by which LAMMPS integrates the states of one model."""

    require: Callable[[Any], None]
    """require(scene) raises SceneError for what LAMMPS cannot simulate"""
    parameters: Callable[[Any], Any]
    """parameters(scene), with LAMMPS's time step. Raises SceneError for what LAMMPS cannot express"""
    commands: Callable[[Any, Any, Any], tuple[Mapping[str, str], str]]
    """commands(scene, parameters, state): files, and the commands before the first time step"""
    columns: tuple[str, ...]
    """of the dump"""
    take: Callable[[Any, Any, Any, Array], None]
    """take(scene, parameters, state, columns) copies the particles of the dump to the state"""
    observe: Callable[[Model, Any, Any], Frame]
    """observe(model, parameters, state)"""
    invariants: Callable[[Model, Any, Any], list[Any]]
    """invariants(model, scene, parameters): those that need no sums over the steps of ecume"""
    group: str = "all"
    """the group of LAMMPS with the particles of the state"""


SYSTEMS: Mapping[str, System] = {
    "floating": System(
        require=require_simulable,
        parameters=floats_in_engine.parameters,
        commands=floats_in_engine.commands,
        columns=floats_in_engine.COLUMNS,
        take=floats_in_engine.take,
        observe=floats_in_engine.observe,
        invariants=floats_in_engine.invariants,
    ),
    "sph": System(
        require=tanks_in_engine.require,
        parameters=tanks_in_engine.parameters,
        commands=tanks_in_engine.commands,
        columns=tanks_in_engine.COLUMNS,
        take=tanks_in_engine.take,
        observe=tanks_in_engine.observe,
        invariants=tanks_in_engine.invariants,
        group=tanks_in_engine.GROUP,
    ),
}
"""The systems by model."""


class _Open:
    """A running LAMMPS with the state of one run."""

    def __init__(self, system: System, model: Model, started: Program, ranks: int) -> None:
        self._system, self._model, self._program, self._ranks = system, model, started, ranks
        self._scene: Any = None
        self.lammps: Lammps | None = None

    def parameters(self, scene: Any) -> Any:
        """See `Model.parameters`."""
        self._scene = scene
        return self._system.parameters(scene)

    def workspace(self, parameters: Any, state: Any, room: float) -> Lammps:
        """A LAMMPS with this state, after the computation of all forces."""
        self.close()
        files, setup = self._system.commands(self._scene, parameters, state)
        self.lammps = Lammps(self._program, self._ranks, files)
        balancing = [BALANCING] if self._ranks > 1 else []
        more = ["thermo_style custom step", "thermo_modify lost error norm no"]
        self.lammps.do("\n".join([setup, *balancing, *more, "run 0 post no"]))
        return self.lammps

    def advance(self, parameters: Any, state: Any, workspace: Lammps, steps: int) -> int:
        """See `Model.advance`."""
        before = int(state.step[0])
        try:
            workspace.do(f"run {steps} pre no post no")
            particles = workspace.particles(self._system.columns, self._system.group)
        except Diverged as error:
            begin, end = (with_prefix(at * parameters.time_step, "s", 6) for at in (before, before + steps))
            raise Diverged(
                f"between t = {begin} and {end}: {error}. Particles overlap too much for the time step: use stiffer "
                "contacts (contacts.stiffness) or slower particles"
            ) from None
        self._system.take(self._scene, parameters, state, particles)
        state.step[0] += steps
        return DONE if np.isfinite(particles).all() else DIVERGED

    def close(self) -> None:
        """End LAMMPS."""
        if self.lammps is not None:
            self.lammps.close()
            self.lammps = None


def _refused(laws: Any) -> Model:
    raise BadInput("--engine lammps: got user-defined laws; expected none, or --engine local")


def system_of(name: str) -> System:
    """The row of a model. Raises BadInput for a model that LAMMPS cannot simulate."""
    if name not in SYSTEMS:
        raise BadInput(f"--engine lammps: got a scene of the model {name}; expected one of: {', '.join(SYSTEMS)}")
    return SYSTEMS[name]


def require_runnable(scene: Any) -> None:
    """Raise BadInput or SceneError for a scene that LAMMPS cannot simulate."""
    system_of(scene.model).require(scene)


@contextmanager
def lammps_engine(ranks: int = 1) -> Iterator[Engine]:
    """A context with LAMMPS on this number of ranks, for `RunOptions.engine`. Raises BadInput if LAMMPS is not
    installed.
    """
    started = program()
    started.words(ranks)
    opened: list[_Open] = []

    def model_of(model: Model) -> Model:
        system = system_of(model.name)
        own = _Open(system, model, started, ranks)
        opened.append(own)
        return dataclasses.replace(
            model,
            parameters=own.parameters,
            workspace=own.workspace,
            advance=own.advance,
            observe=lambda parameters, state, workspace: system.observe(model, parameters, state),
            invariants=lambda scene, parameters: system.invariants(model, scene, parameters),
            extended=_refused,
        )

    def facts() -> Mapping[str, str | int]:
        return {"lammps": next((each.lammps.version for each in opened if each.lammps), ""), "ranks": ranks}

    try:
        yield Engine(model_of, LAMMPS, repeats=False, facts=facts)
    finally:
        for each in opened:
            each.close()
