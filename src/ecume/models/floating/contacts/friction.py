"""Contacts with Coulomb friction, and the spins that it causes.

A collision applies (1 + e) times the impulses that stop all relative motion, including the tangential ones. These
remove a part of the kinetic energy, of which the collision returns a fraction, so that the energy can only decrease.
In a single collision a sliding contact loses mu times its normal impulse; a sticking contact rebounds tangentially
with e.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.contact import contacts as touching
from ecume.engine.contact import friction as coulomb
from ecume.engine.contact.contacts import Bodies, Contacts, Memory
from ecume.engine.contact.friction import FrictionRows, Motion
from ecume.engine.contact.impulse_solvers import Goal
from ecume.laws import drag, flotation
from ecume.models.floating.options import Built
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.setup.kinds import FloatKind, distinct_kinds, turning_frictions
from ecume.models.floating.state import State, Workspace
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene


class Friction(NamedTuple):
    """Constants of contacts with friction."""

    friction: tuple[float, float]
    """coefficients of friction between two floats, and at walls"""
    inertia: Array
    """(N,) kg m^2"""
    decay: Array
    """(N,) the fraction of a spin that remains after the drag of one kick"""
    ease: Array
    """(N + walls,) spin per angular impulse during one kick"""
    overlapping: bool = False
    """see `contact_solver.Impulses`"""


class FrictionScratch(NamedTuple):
    """Workspace of contacts with friction."""

    rubbing: FrictionRows
    spin: Array
    """(N + walls,) rad/s, during this step; walls do not turn"""
    before: Array
    """(N + walls,) rad/s, before contacts"""


def make_friction_scratch(
    part: Friction, parameters: Parameters, state: State, workspace: Workspace
) -> FrictionScratch:
    """Return a workspace for as many contacts as the common workspace holds."""
    count = len(parameters.kick.mobility)
    return FrictionScratch(coulomb.make_friction_rows(len(workspace.contacts.gap)), np.zeros(count), np.zeros(count))


@compiled
def memory_of(state: State) -> Memory:
    """Return the impulses of the previous step."""
    return Memory(state.touches, state.touching, state.push)


@compiled
def solve_with_friction(
    part: Friction, rubbing: FrictionRows, bodies: Bodies, contacts: Contacts, motion: Motion, goal: Goal
) -> int:
    """Solve contacts with friction for these velocities and spins; return the number of sweeps."""
    touching.set_effective_masses(contacts, bodies.mobility)
    coulomb.prepare(contacts, rubbing, bodies.radius, part.friction, motion)
    return coulomb.solve(contacts, rubbing, motion, goal)


@compiled
def stop_with_friction(
    part: Friction, own: FrictionScratch, bodies: Bodies, contacts: Contacts, velocity: Array, goal: Goal
) -> int:
    """Stop all relative motion, starting from zero impulses; return the number of sweeps."""
    for row in range(contacts.total[0]):
        own.rubbing.impulse[row] = 0.0
    motion = Motion(velocity, own.before, bodies.mobility, part.ease)
    return solve_with_friction(part, own.rubbing, bodies, contacts, motion, goal)


@compiled
def push_with_friction(
    part: Friction, own: FrictionScratch, bodies: Bodies, contacts: Contacts, midstep_velocity: Array
) -> None:
    """Apply the impulses of collisions to the midstep velocities and the spins."""
    rubbing = own.rubbing
    for row in range(contacts.total[0]):
        contacts.impulse[row] *= contacts.scratch[row]
        rubbing.impulse[row] *= contacts.scratch[row]
    motion = Motion(midstep_velocity, own.spin, bodies.mobility, part.ease)
    coulomb.apply_impulses(contacts, rubbing, (contacts.impulse, rubbing.impulse), motion)


@compiled
def continue_with_friction(
    part: Friction, own: FrictionScratch, bodies: Bodies, contacts: Contacts, velocity: Array, goal: Goal
) -> int:
    """Solve for velocities and spins, starting from the stored impulses; return the number of sweeps."""
    motion = Motion(velocity, own.spin, bodies.mobility, part.ease)
    return solve_with_friction(part, own.rubbing, bodies, contacts, motion, goal)


@compiled
def recall_friction(part: Friction, own: FrictionScratch, state: State, workspace: Workspace) -> None:
    """Start from the tangential impulses of the previous step."""
    coulomb.recall(workspace.contacts, own.rubbing, memory_of(state), state.rub)


@compiled
def remember_friction(part: Friction, own: FrictionScratch, state: State, workspace: Workspace) -> None:
    """Store the tangential impulses for the next step."""
    coulomb.remember(workspace.contacts, own.rubbing, memory_of(state), state.rub)


@compiled
def load_friction_spins(part: Friction, own: FrictionScratch, parameters: Parameters, state: State, last: bool) -> None:
    """Apply a kick to the spins; in velocity Verlet, the other half follows at the end of the step."""
    kicked = not last or parameters.scheme.half_kicks
    for i in range(len(state.turning)):
        own.spin[i] = state.turning[i, 1] * (part.decay[i] if kicked else 1.0)
        own.before[i] = own.spin[i]


@compiled
def store_friction_spins(
    part: Friction, own: FrictionScratch, parameters: Parameters, state: State, last: bool
) -> None:
    """Store the spins in the state, and advance the angles with them."""
    for i in range(len(state.turning)):
        state.turning[i, 1] = own.spin[i]
        if not last:
            state.turning[i, 0] += parameters.time_step * own.spin[i]


def friction_of(parameters: Parameters, scene: FloatingScene, interactions: tuple[Any, ...]) -> Built:
    """Return contacts with friction; `friction_at_step` adds what depends on the time step."""
    kinds, number = distinct_kinds(scene)
    inertia = np.array([float_inertia(kind) for kind in kinds])[number]
    friction = turning_frictions(scene)
    coefficients = scene.contacts.friction, scene.dish.friction if scene.dish is not None else 0.0
    return Built(Friction(coefficients, inertia, friction, friction))


def friction_at_step(part: Friction, parameters: Parameters, turned: Array | None) -> Friction:
    """Return the part with the constants of its spin kicks. If interactions also turn the floats, they include the
    drag.
    """
    friction = part.decay if turned is None else np.zeros_like(part.decay)
    decay, ease = spin_kick(parameters, part.inertia, friction)
    walls = np.zeros(len(parameters.kick.mobility) - len(ease))
    return part._replace(decay=decay, ease=np.concatenate([ease, walls]))


def float_inertia(kind: FloatKind) -> float:
    """The moment of inertia of one float about the vertical (kg m^2), without added mass."""
    if isinstance(kind.body, flotation.Disc):
        return drag.disc_inertia(kind.mass, kind.body.radius)
    return drag.sphere_inertia(kind.density * 4.0 / 3.0 * math.pi * kind.radius**3, kind.radius)


def spin_kick(parameters: Parameters, inertia: Array, friction: Array) -> tuple[Array, Array]:
    """The fraction of each spin that remains after the drag of one kick, and the spin per angular impulse."""
    time = 0.5 * parameters.time_step if parameters.scheme.half_kicks else parameters.time_step
    if not parameters.scheme.inertia:
        return np.zeros_like(inertia), 1.0 / (friction * time)
    rate = friction / inertia * time
    with np.errstate(invalid="ignore", divide="ignore"):
        held = np.where(rate > 0.0, -np.expm1(-rate) / rate, 1.0)
    return np.exp(-rate), held / inertia
