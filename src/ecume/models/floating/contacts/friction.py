"""Floats whose surfaces rub: contacts with Coulomb's friction, and the spins that it makes.

A bounce gives (1 + e) times the impulses that would stop everyone, those along the surfaces included: these do no work
on what they stop, so that the bounce mirrors a part of what they take, and energy can only fall. What slides in a lone
collision is braked by mu times its normal impulse, as it should be; what sticks springs back by e along the surface.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.contact import contacts as touching
from ecume.engine.contact import friction as coulomb
from ecume.engine.contact.contacts import Bodies, Contacts
from ecume.engine.contact.friction import Motion, Rubbing
from ecume.engine.contact.projected_gauss_seidel import Goal
from ecume.engine.contact.warm_start import Memory
from ecume.laws import drag, flotation, rotation
from ecume.models.floating.options import Built
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.setup.kinds import FloatKind, distinct_kinds
from ecume.models.floating.state import State, Workspace
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene


class Friction(NamedTuple):
    """What never changes where surfaces rub."""

    friction: tuple[float, float]
    """coefficients between two floats, and at walls"""
    inertia: Array
    """(N,) kg m^2"""
    decay: Array
    """(N,) what drag leaves of a spin over the scheme's kick"""
    ease: Array
    """(N + walls,) spin per angular impulse over the kick"""
    overlapping: bool = False
    """see `contact_solver.Impulses`"""


class FrictionScratch(NamedTuple):
    """Scratch."""

    rubbing: Rubbing
    spin: Array
    """(N + walls,) rad/s, through this step; walls do not turn"""
    before: Array
    """(N + walls,) rad/s, before contacts"""


def make_friction_scratch(
    part: Friction, parameters: Parameters, state: State, workspace: Workspace
) -> FrictionScratch:
    """Room for as many contacts as the workspace has."""
    everyone = len(parameters.kick.mobility)
    return FrictionScratch(coulomb.make_rubbing(len(workspace.contacts.gap)), np.zeros(everyone), np.zeros(everyone))


@compiled
def memory_of(state: State) -> Memory:
    """The impulses of the step before."""
    return Memory(state.touches, state.touching, state.push)


@compiled
def solve_with_friction(
    part: Friction, rubbing: Rubbing, bodies: Bodies, contacts: Contacts, motion: Motion, goal: Goal
) -> int:
    """Contacts with friction, on these velocities and spins: how many sweeps their solution takes."""
    touching.weigh(contacts, bodies.mobility)
    coulomb.prepare(contacts, rubbing, bodies.radius, part.friction, motion)
    return coulomb.solve(contacts, rubbing, motion, goal)


@compiled
def stop_with_friction(
    part: Friction, own: FrictionScratch, bodies: Bodies, contacts: Contacts, velocity: Array, goal: Goal
) -> int:
    """Stop everyone, from no impulses."""
    for row in range(contacts.total[0]):
        own.rubbing.impulse[row] = 0.0
    motion = Motion(velocity, own.before, bodies.mobility, part.ease)
    return solve_with_friction(part, own.rubbing, bodies, contacts, motion, goal)


@compiled
def push_with_friction(
    part: Friction, own: FrictionScratch, bodies: Bodies, contacts: Contacts, midstep_velocity: Array
) -> None:
    """The impulses of bounces, on the passage and on the spins."""
    rubbing = own.rubbing
    for row in range(contacts.total[0]):
        contacts.impulse[row] *= contacts.scratch[row]
        rubbing.impulse[row] *= contacts.scratch[row]
    motion = Motion(midstep_velocity, own.spin, bodies.mobility, part.ease)
    coulomb.push_all(contacts, rubbing, (contacts.impulse, rubbing.impulse), motion)


@compiled
def continue_with_friction(
    part: Friction, own: FrictionScratch, bodies: Bodies, contacts: Contacts, velocity: Array, goal: Goal
) -> int:
    """Solve on a velocity and the spins through the step, from the impulses that stand there."""
    motion = Motion(velocity, own.spin, bodies.mobility, part.ease)
    return solve_with_friction(part, own.rubbing, bodies, contacts, motion, goal)


@compiled
def recall_friction(part: Friction, own: FrictionScratch, state: State, workspace: Workspace) -> None:
    """Start from the impulses along the surfaces of the step before."""
    coulomb.recall(workspace.contacts, own.rubbing, memory_of(state), state.rub)


@compiled
def remember_friction(part: Friction, own: FrictionScratch, state: State, workspace: Workspace) -> None:
    """Keep the impulses along the surfaces for the next step."""
    coulomb.remember(workspace.contacts, own.rubbing, memory_of(state), state.rub)


@compiled
def load_friction_spins(part: Friction, own: FrictionScratch, parameters: Parameters, state: State, last: bool) -> None:
    """The spins through the step, after their kick; velocity Verlet's have the other half of it at the end."""
    kicked = not last or parameters.scheme.half_kicks
    for i in range(len(state.turning)):
        own.spin[i] = state.turning[i, 1] * (part.decay[i] if kicked else 1.0)
        own.before[i] = own.spin[i]


@compiled
def store_friction_spins(
    part: Friction, own: FrictionScratch, parameters: Parameters, state: State, last: bool
) -> None:
    """Spins become the state's; angles go through the step with them."""
    for i in range(len(state.turning)):
        state.turning[i, 1] = own.spin[i]
        if not last:
            state.turning[i, 0] += parameters.time_step * own.spin[i]


def friction_of(parameters: Parameters, scene: FloatingScene, interactions: tuple[Any, ...]) -> Built:
    """Floats that rub; what depends on the time step comes later."""
    kinds, number = distinct_kinds(scene)
    inertia = np.array([float_inertia(kind) for kind in kinds])[number]
    friction = np.array([turning_friction_of(kind, scene) for kind in kinds])[number]
    coefficients = scene.contacts.friction, scene.dish.friction if scene.dish is not None else 0.0
    return Built(Friction(coefficients, inertia, friction, friction))


def friction_at_step(part: Friction, parameters: Parameters, turned: Array | None) -> Friction:
    """The part with the kicks of its spins. Where interactions turn the floats, too, these take care of drag."""
    friction = part.decay if turned is None else np.zeros_like(part.decay)
    decay, ease = spin_kick(parameters, part.inertia, friction)
    walls = np.zeros(len(parameters.kick.mobility) - len(ease))
    return part._replace(decay=decay, ease=np.concatenate([ease, walls]))


def float_inertia(kind: FloatKind) -> float:
    """The moment of inertia of one of a kind about the vertical (kg m^2); added mass is not a part of it."""
    if isinstance(kind.body, flotation.Disc):
        return rotation.disc_inertia(kind.mass, kind.body.radius)
    return rotation.sphere_inertia(kind.density * 4.0 / 3.0 * math.pi * kind.radius**3, kind.radius)


def turning_friction_of(kind: FloatKind, scene: FloatingScene) -> float:
    """The torque per spin of the liquid on one of a kind (N m s)."""
    viscosity = scene.liquid.viscosity if scene.motion.drag else 0.0
    if isinstance(kind.body, flotation.Disc):
        return drag.disc_turning_friction(kind.body.radius, viscosity)
    depth = min(max(math.pi - kind.equilibrium.filling_angle, 0.0), math.pi)
    return rotation.sphere_turning_friction(kind.radius, viscosity, float(rotation.turning_factor(depth)))


def spin_kick(parameters: Parameters, inertia: Array, friction: Array) -> tuple[Array, Array]:
    """What drag leaves of each spin over a kick of the scheme, and spin per angular impulse over it."""
    time = 0.5 * parameters.time_step if parameters.scheme.half_kicks else parameters.time_step
    if not parameters.scheme.inertia:
        return np.zeros_like(inertia), 1.0 / (friction * time)
    rate = friction / inertia * time
    with np.errstate(invalid="ignore", divide="ignore"):
        held = np.where(rate > 0.0, -np.expm1(-rate) / rate, 1.0)
    return np.exp(-rate), held / inertia
