"""Nobody lies on a wall: who comes closer to a wall, an obstacle or a body than a tenth of a spacing is pushed off.

Images and dummies press by their pressure, and by nothing where a particle coincides with its image; and the density of
continuity forgets how close a thin layer came. So layers one particle thick would lie on the guard for good.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume._jit import admit, prange, spread
from ecume._portable import dot, product
from ecume.engine.cells import Integers
from ecume.engine.walls import Sheet
from ecume.engine.walls.sheets import inward_normal, piece_gap
from ecume.laws import wall_repulsion
from ecume.models.sph.bodies import rotations
from ecume.models.sph.forces_on_solids import total
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.state import State
from ecume.models.sph.wall_reflection import Guard
from ecume.units import Array

admit(wall_repulsion)

FASTEST = 0.1
"""In sound speeds, as fast as a weakly compressible liquid may be: who comes so fast just touches the wall."""


class Leaning(NamedTuple):
    """Particles that something pushes off."""

    owner: int
    """what pushes: a place in `Boundary.names`"""
    who: Integers
    """(n,)"""
    push: Array
    """(d, n) m/s^2"""


@spread
def push_off(position: Array, kind: Integers, number: Array, reach: float, speed: float, acceleration: Array) -> None:
    """Add what walls and obstacles do."""
    for i in prange(position.shape[1]):
        k, z = 0, position[2, i] if position.shape[0] == 3 else 0.0
        x = position[0, i], position[1, i], z
        while k < kind.shape[0]:
            gap, nearest, k = piece_gap(kind, number, k, x, 0.0)
            if gap < reach:
                push, normal = (
                    wall_repulsion.standoff_push(gap, reach, speed),
                    inward_normal(kind, number, nearest, x, 0.0),
                )
                for axis in range(position.shape[0]):
                    acceleration[axis, i] += push * normal[axis]


def speed_of(parameters: Parameters) -> float:
    """Whom the push just stops (m/s)."""
    return FASTEST * parameters.material.sound_speed


def push_off_walls(parameters: Parameters, state: State) -> None:
    """Add to the liquid's acceleration what walls and obstacles do, at this instant."""
    guard = parameters.boundary.guard
    if guard.reach > 0.0 and len(guard.owner):
        push_off(state.position, *guard.sheet[:2], guard.reach, speed_of(parameters), state.acceleration)


def push_off_bodies(parameters: Parameters, state: State) -> tuple[Array, Array]:
    """Add what bodies do; force and torque on each, (B, 3), are the liquid's loss."""
    bodies = len(parameters.bodies.shapes)
    force, torque = np.zeros((bodies, 3)), np.zeros((bodies, 3))
    first = len(parameters.boundary.names) - bodies
    for body in range(bodies):
        leaning = at_body(parameters, state, body)
        state.acceleration[:, leaning.who] += leaning.push
        force[body], torque[body] = load_of(parameters, state, leaning._replace(owner=first + body))
    return force, torque


def at_body(parameters: Parameters, state: State, body: int) -> Leaning:
    """Who leans on a body."""
    bodies, reach = parameters.bodies, parameters.boundary.guard.reach
    shape, d = bodies.shapes[body], len(state.position)
    away = state.position - state.pose[:d, body : body + 1]
    size = float(np.sqrt((bodies.rims[body] ** 2).sum(axis=1).max()))
    close = np.flatnonzero((away**2).sum(axis=0) < (size + reach) ** 2)
    turn = rotations(state.pose[:, body : body + 1])[0][:d, :d]
    gap, normal = shape.nearest(product(away[:, close].T, turn))
    near = gap < reach
    push = [wall_repulsion.standoff_push(own, reach, speed_of(parameters)) for own in gap[near]]
    owner = len(parameters.boundary.names) - len(bodies.shapes) + body
    return Leaning(owner, close[near], np.array(push) * product(turn, normal[near].T))


def everyone_leaning(parameters: Parameters, state: State) -> list[Leaning]:
    """On walls and obstacles one after the other, then on bodies."""
    guard, found = parameters.boundary.guard, []
    if guard.reach == 0.0:
        return []
    for owner in np.unique(guard.owner):
        found.append(leaning_on(parameters, state, int(owner)))
    return found + [at_body(parameters, state, body) for body in range(len(parameters.bodies.shapes))]


def leaning_on(parameters: Parameters, state: State, owner: int) -> Leaning:
    """Who leans on a wall or an obstacle."""
    guard, push = parameters.boundary.guard, np.zeros_like(state.position)
    if guard.reach > 0.0:
        push_off(state.position, *_sheet_of(guard, owner)[:2], guard.reach, speed_of(parameters), push)
    who = np.flatnonzero(push.any(axis=0))
    return Leaning(owner, who, push[:, who])


def _sheet_of(guard: Guard, owner: int) -> Sheet:
    """The surfaces of one wall or obstacle; an obstacle's planes say where theirs begin and end."""
    mine = np.flatnonzero(guard.owner == owner)
    kind = guard.sheet.kind[mine].copy()
    kind[:, 1:] -= mine[0] * (kind[:, 2:] > 0)
    return guard.sheet._replace(kind=kind, number=guard.sheet.number[mine])


def load_of(parameters: Parameters, state: State, leaning: Leaning) -> tuple[Array, Array]:
    """Force and torque, (3,) each, that those who lean press with."""
    d, who = len(state.position), leaning.who
    force, place = np.zeros((3, len(who))), np.zeros((3, len(who)))
    force[:d], place[:d] = -state.mass[who] * leaning.push, state.position[:, who]
    return total(force, place, parameters.boundary.centers[leaning.owner])


def energy_of(parameters: Parameters, state: State, leaning: Leaning) -> float:
    """What those who lean are given back when they leave (J)."""
    reach, speed = parameters.boundary.guard.reach, speed_of(parameters)
    gap = reach - np.sqrt((leaning.push**2).sum(axis=0)) * (reach / speed) ** 2
    energy = [wall_repulsion.standoff_energy(own, reach, speed) for own in gap]
    return dot(state.mass[leaning.who], energy)
