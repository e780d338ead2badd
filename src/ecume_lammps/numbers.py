"""The numbers of a deck: kinds of floats, contacts as springs and dashpots, time step and initial state."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.models.floating.contacts import contact_models
from ecume.models.floating.contacts.collisions import float_inertia
from ecume.models.floating.contacts.springs import Springs
from ecume.models.floating.parameters import Parameters, State
from ecume.models.floating.setup.initial_state import start
from ecume.models.floating.setup.kinds import FloatKind, distinct_kinds, turning_friction_of
from ecume.models.floating.setup.scene_parameters import parameters_of
from ecume.models.step_counts import last_step
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene

DRAG_STEP = 0.1
"""The longest time step over the shortest relaxation time: LAMMPS applies drag as an explicit force."""
ROLLING = 2.0 / 7.0
"""Tangential over normal stiffness and damping: the reduced mass at the surface of a homogeneous sphere is 2/7 of that
of its center, and this stiffness lets a sticking contact rebound along the surface within the time of the normal one.
"""


class Contacts(NamedTuple):
    """Contacts as springs and dashpots."""

    stiffness: float
    """N/m"""
    among: float
    """the parameter e* of `damping coeff_restitution` between floats"""
    at_walls: float
    """the parameter e* at walls"""
    friction: tuple[float, float]
    """Coulomb's coefficients between floats and at walls"""


class Turning(NamedTuple):
    """Rotation of floats by friction."""

    friction: list[float]
    """N m s, rotational friction of each kind"""
    shortest_time: float
    """s: the shortest time in which the liquid slows a spin"""


class DeckNumbers(NamedTuple):
    """All numbers of the deck of a scene."""

    scene: FloatingScene
    parameters: Parameters
    """with springs and dashpots, and with the time step for these"""
    state: State
    kinds: list[FloatKind]
    kind: Integers
    """(N,) the kind of each float, from 0"""
    first: Integers
    """the first float of each kind, whose properties are those of the kind"""
    contacts: Contacts | None
    turning: Turning | None
    time_step: float
    steps: int
    steps_per_frame: int


class TurningSprings(NamedTuple):
    """`Springs` with contact friction, which LAMMPS computes."""

    stiffness: float
    damping: float
    wall_damping: float
    inertia: Array
    """(N,) kg m^2"""


contact_models.BY_CONSTANTS[TurningSprings] = dataclasses.replace(
    contact_models.CONTACTS["spring-dashpot"],
    constants=TurningSprings, inertia=lambda part: np.asarray(part.inertia), gives=frozenset(),
)  # fmt: skip


def parameters_for(scene: FloatingScene) -> Parameters:
    """The parameters of the deck of a scene that a deck can express, with its time step. Raises SceneError."""
    parameters = parameters_of(with_springs(scene))
    kinds, kind = distinct_kinds(scene)
    per_frame = _steps_per_frame(scene, parameters, _turning(scene, kinds))
    springs = parameters.parts.contacts
    if scene.rubs and isinstance(springs, Springs):
        inertia = np.array([float_inertia(each) for each in kinds])[kind]
        parameters = parameters._replace(parts=parameters.parts._replace(contacts=TurningSprings(*springs, inertia)))
    return parameters._replace(time_step=scene.frame_every / per_frame, steps_per_frame=per_frame)


def numbers_of(scene: FloatingScene, parameters: Parameters | None = None, state: State | None = None) -> DeckNumbers:
    """The numbers of a deck that starts from a state; default: that of the scene. Raises SceneError."""
    parameters = parameters_for(scene) if parameters is None else parameters
    kinds, kind = distinct_kinds(scene)
    return DeckNumbers(
        scene=scene,
        parameters=parameters,
        state=start(scene, parameters) if state is None else state,
        kinds=kinds,
        kind=kind,
        first=np.unique(kind, return_index=True)[1].astype(np.int64),
        contacts=_contacts(scene, parameters),
        turning=_turning(scene, kinds),
        time_step=parameters.time_step,
        steps=last_step(scene, parameters.steps_per_frame),
        steps_per_frame=parameters.steps_per_frame,
    )


def with_springs(scene: FloatingScene) -> FloatingScene:
    """The scene with springs and dashpots in place of rigid contacts, and with the integrator of LAMMPS."""
    law = "none" if scene.contacts.law == "none" else "spring-dashpot"
    slow = scene.integration.integrator == "overdamped"
    return dataclasses.replace(
        scene,
        contacts=dataclasses.replace(scene.contacts, law=law, friction=0.0),
        dish=None if scene.dish is None else dataclasses.replace(scene.dish, friction=0.0),
        integration=dataclasses.replace(
            scene.integration, integrator="overdamped" if slow else "velocity-verlet", time_step=None
        ),
        interaction=dataclasses.replace(scene.interaction, summation="cells", precision="double"),
    )


def _contacts(scene: FloatingScene, parameters: Parameters) -> Contacts | None:
    """The springs and dashpots of the scene; None without contacts."""
    springs = parameters.parts.contacts
    if not isinstance(springs, Springs | TurningSprings):
        return None
    rubbing = scene.contacts.friction, scene.dish.friction if scene.dish is not None else 0.0
    return Contacts(springs.stiffness, nominal(springs.damping), nominal(springs.wall_damping), rubbing)


def nominal(damping: float) -> float:
    """The parameter e* = exp(-pi zeta/sqrt(1 - zeta^2)) from which LAMMPS computes the damping
    ratio zeta.

    It is the restitution of a contact that ends when the overlap vanishes. Contacts of the deck end when their force
    vanishes (`limit_damping`), with a larger restitution: `ecume.laws.friction.dashpot_restitution`.

    >>> nominal(0.0), round(nominal(0.5), 6)
    (1.0, 0.163034)
    """
    return math.exp(-math.pi * damping / math.sqrt(1.0 - damping * damping))


def _turning(scene: FloatingScene, kinds: list[FloatKind]) -> Turning | None:
    """The drag on rotation; None if no float rotates."""
    if not scene.rubs:
        return None
    friction = [turning_friction_of(kind, scene) for kind in kinds]
    times = [float_inertia(kind) / each for kind, each in zip(kinds, friction, strict=True) if each > 0.0]
    return Turning(friction, min(times, default=math.inf))


def _steps_per_frame(scene: FloatingScene, parameters: Parameters, turning: Turning | None) -> int:
    """The number of steps per frame, for time steps that suit springs and explicit drag."""
    if not parameters.scheme.inertia:
        return parameters.steps_per_frame
    shortest_time = min(float(parameters.floats.relaxation_time.min()), turning.shortest_time if turning else math.inf)
    longest = min(parameters.time_step, DRAG_STEP * shortest_time)
    times = math.ceil(parameters.time_step / longest * (1.0 - 1e-9))
    return times * parameters.steps_per_frame


FEWEST, MOST = 250, 64_000
"""The least and the largest number of rows of a table."""
SHORTEST, LONGEST = 4, 20
"""The least and the largest degree of the fit."""
