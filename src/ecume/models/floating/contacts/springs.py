"""Contacts as springs and dashpots instead of impulses."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

from ecume._jit import compiled
from ecume.engine.contact import contacts as touching
from ecume.engine.contact.contacts import Contacts
from ecume.laws.friction import dashpot_restitution, spring_energy, spring_push
from ecume.models.floating.contacts.collisions import (
    contact_bodies,
)
from ecume.models.floating.forces.pair_forces import law_of, row_of, two_floats
from ecume.models.floating.options import Built, scene_error
from ecume.models.floating.parameters import CAPILLARY_LENGTH, DEEPEST, Parameters, State, Workspace, copy_rows
from ecume.models.floating.time_integration.step_size import RAFT_NEIGHBORS, fastest_start
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene


class Springs(NamedTuple):
    """Constants of contacts with springs."""

    stiffness: float
    """N/m"""
    damping: float
    """of the dashpots between floats, over the critical one"""
    wall_damping: float


SHALLOW = 1e-3
"""Overlap caused by the strongest attraction, over the smallest radius, if a scene gives no stiffness."""
STRUCK = 1e-2
"""Overlap in a collision at the highest speed of the start or of the current, over the smallest radius."""
LEAST_RESTITUTION = 0.05
"""Below this value dashpots would be far above critical damping, and would require short time steps."""


def springs_of(parameters: Parameters, scene: FloatingScene, interactions: tuple[Any, ...]) -> Built:
    """Return contacts with springs. Raises SceneError if the restitution requires too much damping."""
    slow = not parameters.scheme.inertia
    stiffness = scene.contacts.stiffness or stiffness_of(parameters, fastest_start(parameters, scene))
    at_walls = parameters.wall_restitution if scene.dish is not None else 1.0
    dampings = [0.0 if slow else damping_of(each) for each in (parameters.restitution, at_walls)]
    floats = parameters.floats
    shortest_time = math.pi * math.sqrt(0.5 * float(floats.mass.min()) / stiffness) / max(1.0, 2.0 * max(dampings))
    if slow:
        shortest_time = float((floats.mass / floats.relaxation_time).min()) / (2.0 * RAFT_NEIGHBORS * stiffness)
    return Built(Springs(stiffness, *dampings), shortest_time)


def stiffness_of(parameters: Parameters, speed: float) -> float:
    """The stiffness (N/m) at which the pressure of six neighbors and of the walls, and the drag of a current on a
    raft that it presses against a wall, cause a relative overlap of SHALLOW, and a collision at this speed (m/s) one of
    STRUCK. Raises SceneError.
    """
    floats, length = parameters.floats, float(parameters.pair[CAPILLARY_LENGTH])
    smallest, strongest = float(floats.radius.min()), float(abs(floats.charge).max())
    touching = two_floats(parameters, (smallest, smallest), (strongest, strongest))
    pull = abs(float(row_of(parameters).force(2.0 * smallest, touching, law_of(parameters))))
    walls = float(abs(parameters.wall_strength).max(initial=0.0)) / length
    if pull + walls == 0.0:
        raise scene_error(
            "contacts.stiffness", "got none, and no force presses the floats together; expected a stiffness in N/m"
        )
    pressed = math.sqrt(len(floats.mass)) * float((floats.mass / floats.relaxation_time).max()) * speed
    resting = (RAFT_NEIGHBORS * pull + walls + pressed) / (SHALLOW * smallest)
    # A float with the speed v bounces off a wall from the depth v sqrt(m/k).
    struck = float(floats.mass.max()) * (speed / (STRUCK * smallest)) ** 2 if parameters.scheme.inertia else 0.0
    return max(resting, struck)


def damping_of(restitution: float) -> float:
    """The damping of the dashpot over the critical one, at which an isolated collision has this restitution. Raises
    SceneError.
    """
    if restitution < LEAST_RESTITUTION:
        raise scene_error(
            "contacts.restitution",
            f"got {restitution:g}; expected {LEAST_RESTITUTION:g} or more with dashpots, also for dish.restitution",
        )
    from scipy.optimize import brentq

    return float(brentq(lambda damping: dashpot_restitution(damping) - restitution, 0.0, 4.0, xtol=1e-14))


@compiled
def reduced_mass(mass: Array, i: int, j: int) -> float:
    """The reduced mass of a contact (kg); a wall has infinite mass."""
    return float(mass[i] * mass[j] / (mass[i] + mass[j]) if j < len(mass) else mass[i])


@compiled
def push_apart(springs: Springs, parameters: Parameters, state: State, contacts: Contacts, time: float) -> None:
    """Compute the impulses of springs and dashpots during `time`, from the approach speeds in `contacts.change`."""
    mass = parameters.floats.mass
    for row in range(contacts.total[0]):
        j, overlap = contacts.second[row], -contacts.gap[row]
        damping = springs.damping if j < len(mass) else springs.wall_damping
        critical = 2.0 * math.sqrt(springs.stiffness * reduced_mass(mass, contacts.first[row], j))
        push = spring_push(overlap, -contacts.change[row], springs.stiffness, damping * critical)
        contacts.impulse[row] = time * push
        state.tally[DEEPEST] = max(state.tally[DEEPEST], overlap)


@compiled
def push_before_drift(part: Springs, scratch: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Apply the forces at the start of the step to the midstep velocities and to the velocities."""
    contacts, midstep_velocity = workspace.contacts, workspace.midstep_velocity
    touching.gather(contacts, workspace.candidates, state.position, contact_bodies(parameters), 0.0)
    touching.normal_velocities(contacts, workspace.before, contacts.change)
    half = 0.5 if parameters.scheme.half_kicks else 1.0
    push_apart(part, parameters, state, contacts, half * parameters.time_step)
    touching.apply_impulses(contacts, contacts.impulse, midstep_velocity, parameters.kick.mobility)
    copy_rows(state.velocity, midstep_velocity)


@compiled
def push_at_end(part: Springs, scratch: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Apply the forces at the end of a step of velocity Verlet."""
    contacts, midstep_velocity = workspace.contacts, workspace.midstep_velocity
    touching.gather(contacts, workspace.candidates, state.position, contact_bodies(parameters), 0.0)
    touching.normal_velocities(contacts, midstep_velocity, contacts.change)
    push_apart(part, parameters, state, contacts, 0.5 * parameters.time_step)
    copy_rows(midstep_velocity, state.velocity)
    touching.apply_impulses(contacts, contacts.impulse, midstep_velocity, parameters.kick.mobility)
    copy_rows(state.velocity, midstep_velocity)


@compiled
def spring_energies(
    springs: Springs, scratch: Any, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """The energy of all contacts (J): among floats, and with walls."""
    contacts, among, at_walls = workspace.contacts, 0.0, 0.0
    touching.gather(contacts, workspace.candidates, state.position, contact_bodies(parameters), 0.0)
    for row in range(contacts.total[0]):
        energy = spring_energy(-contacts.gap[row], springs.stiffness)
        if contacts.second[row] < len(state.position):
            among += energy
        else:
            at_walls += energy
    return among, at_walls
