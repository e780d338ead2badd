"""Floats whose surfaces rub: contacts with Coulomb's friction, and the spins that it makes.

A bounce gives (1 + e) times the impulses that would stop everyone, those along the surfaces included: these do no work
on what they stop, so that the bounce mirrors a part of what they take, and energy can only fall. What slides in a lone
collision is braked by mu times its normal impulse, as it should be; what sticks springs back by e along the surface.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.contact import contacts as touching
from ecume.engine.contact import friction as rubs
from ecume.engine.contact.friction import Motion, Rubbing
from ecume.engine.contact.projected_gauss_seidel import Goal
from ecume.models.floating.meeting import bounce_with, meet_with, memory_of, rest_with, solve_contacts_with
from ecume.models.floating.parameters import VELOCITY_VERLET, Parameters
from ecume.models.floating.state import State, Workspace
from ecume.units import Array


class Rough(NamedTuple):
    """What never changes where surfaces rub."""

    friction: tuple[float, float]
    """coefficients between two floats, and at walls"""
    inertia: Array
    """(N,) kg m^2"""
    decay: Array
    """(N,) what drag leaves of a spin over the scheme's kick"""
    ease: Array
    """(N + walls,) spin per angular impulse over the kick"""


class Rubbed(NamedTuple):
    """Scratch."""

    rubbing: Rubbing
    spin: Array
    """(N + walls,) rad/s, through this step; walls do not turn"""
    before: Array
    """(N + walls,) rad/s, before contacts"""


def make_rubbed(parameters: Parameters, workspace: Workspace) -> Rubbed:
    """Room for as many contacts as the workspace has."""
    everyone = len(parameters.kick.mobility)
    return Rubbed(rubs.make_rubbing(len(workspace.contacts.gap)), np.zeros(everyone), np.zeros(everyone))


@compiled
def solve_rough(parameters: Parameters, workspace: Workspace, velocity: Array, spin: Array, goal: Goal) -> int:
    """Contacts with friction, on these velocities and spins: how many sweeps their solution takes."""
    contacts, rubbing = workspace.contacts, workspace.rough.rubbing
    mobility = parameters.kick.mobility
    motion = Motion(velocity, spin, mobility, parameters.rough.ease)
    touching.weigh(contacts, mobility)
    rubs.prepare(contacts, rubbing, parameters.floats.radius, parameters.rough.friction, motion)
    return rubs.solve(contacts, rubbing, motion, goal)


@compiled
def stop_rough(parameters: Parameters, workspace: Workspace, velocity: Array, goal: Goal) -> int:
    """Stop everyone, from no impulses."""
    rubbed = workspace.rough
    for row in range(workspace.contacts.total[0]):
        rubbed.rubbing.impulse[row] = 0.0
    return solve_rough(parameters, workspace, velocity, rubbed.before, goal)


@compiled
def push_rough(parameters: Parameters, workspace: Workspace) -> None:
    """The impulses of bounces, on the passage and on the spins."""
    contacts, rubbing = workspace.contacts, workspace.rough.rubbing
    for row in range(contacts.total[0]):
        contacts.impulse[row] *= contacts.scratch[row]
        rubbing.impulse[row] *= contacts.scratch[row]
    motion = Motion(workspace.passage, workspace.rough.spin, parameters.kick.mobility, parameters.rough.ease)
    rubs.push_all(contacts, rubbing, (contacts.impulse, rubbing.impulse), motion)


@compiled
def bounce_rough(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """`bounce_with` friction."""
    bounce_with(stop_rough, push_rough, parameters, state, workspace)


@compiled
def resume_rough(parameters: Parameters, workspace: Workspace, velocity: Array, goal: Goal) -> int:
    """Solve on a velocity and the spins through the step, from the impulses that stand there."""
    return solve_rough(parameters, workspace, velocity, workspace.rough.spin, goal)


@compiled
def solve_contacts_rough(parameters: Parameters, state: State, workspace: Workspace, velocity: Array) -> None:
    """`solve_contacts_with` friction."""
    contacts, rubbing = workspace.contacts, workspace.rough.rubbing
    rubs.recall(contacts, rubbing, memory_of(state), state.rub)
    solve_contacts_with(resume_rough, parameters, state, workspace, velocity)
    rubs.remember(contacts, rubbing, memory_of(state), state.rub)


@compiled
def meet_rough(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """`meet_with` friction; the spins have their kick before, and angles go through the step after it."""
    spin, before, decay, turning = workspace.rough.spin, workspace.rough.before, parameters.rough.decay, state.turning
    for i in range(len(turning)):
        spin[i] = decay[i] * turning[i, 1]
        before[i] = spin[i]
    meet_with(bounce_rough, solve_contacts_rough, parameters, state, workspace)
    for i in range(len(turning)):
        turning[i, 1] = spin[i]
        turning[i, 0] += parameters.time_step * spin[i]


@compiled
def rest_rough(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """`rest_with` friction; velocity Verlet's spins have the other half of their kick before."""
    spin, decay, turning = workspace.rough.spin, parameters.rough.decay, state.turning
    for i in range(len(turning)):
        spin[i] = turning[i, 1] * (decay[i] if parameters.scheme == VELOCITY_VERLET else 1.0)
    rest_with(solve_contacts_rough, parameters, state, workspace)
    for i in range(len(turning)):
        turning[i, 1] = spin[i]
