"""Impacts on walls and obstacles: the braking of liquid that approaches them.

Images complete the sums of liquid that fills the surroundings of a particle. The first particles of a jet have few
neighbors, so that few images stand for the wall, and a sum over images would brake them too late: they would stop in a
water hammer. The dissipation of the Riemann problem at the wall is therefore summed over the half-space behind it,
which depends on the distance alone. Full tanks have no impacts, and incompressible liquids no water hammer.
"""

from __future__ import annotations

import numpy as np

from ecume._jit import admit, compiled_inside, prange, spread
from ecume.engine.cells import Integers
from ecume.engine.walls.sheets import SPEED, inward_normal, piece_gap
from ecume.laws import wall_forces
from ecume.models.sph.boundaries.walls import Repelled, sheet_of
from ecume.models.sph.parameters import Guard, Parameters
from ecume.models.sph.state import State
from ecume.units import Array

admit(wall_forces)


@compiled_inside
def weight_at(gap: float, support: float, weights: Array) -> float:
    """The kernel summed over a plane at this distance (1/m), interpolated."""
    last = len(weights) - 1
    place = max(gap, 0.0) / support * last
    below = min(int(place), last - 1)
    found: float = weights[below] + (place - below) * (weights[below + 1] - weights[below])
    return found


@spread
def brake(
    position: Array, velocity: Array, kind: Integers, number: Array, support: float, weights: Array, sound_speed: float,
    acceleration: Array,
) -> None:  # fmt: skip
    """Add the braking by walls and obstacles: see `wall_impact.impact_braking`."""
    dimension = position.shape[0]
    for i in prange(position.shape[1]):
        k, z = 0, position[2, i] if dimension == 3 else 0.0
        x = position[0, i], position[1, i], z
        while k < kind.shape[0]:
            gap, nearest, k = piece_gap(kind, number, k, x, 0.0)
            if gap >= support:
                continue
            normal, approach = inward_normal(kind, number, nearest, x, 0.0), 0.0
            for axis in range(dimension):
                approach += (number[nearest, SPEED + axis] - velocity[axis, i]) * normal[axis]
            if approach > 0.0:
                push = wall_forces.impact_braking(approach, weight_at(gap, support, weights), sound_speed)
                for axis in range(dimension):
                    acceleration[axis, i] += push * normal[axis]


def add_braking(parameters: Parameters, state: State, guard: Guard, acceleration: Array) -> None:
    """Add the present braking by the surfaces of a guard to an acceleration."""
    if len(guard.weights) and len(guard.owner):
        sheet, sound = guard.sheet, parameters.material.sound_speed
        brake(state.position, state.velocity, *sheet[:2], guard.support, guard.weights, sound, acceleration)


def brake_at_walls(parameters: Parameters, state: State) -> None:
    """Add the present braking by walls and obstacles to the acceleration of the liquid."""
    add_braking(parameters, state, parameters.boundary.guard, state.acceleration)


def braked_by_wall(parameters: Parameters, state: State, owner: int) -> Repelled:
    """Particles braked by a wall or an obstacle."""
    guard, push = parameters.boundary.guard, np.zeros_like(state.position)
    mine = guard._replace(sheet=sheet_of(guard, owner), owner=guard.owner[guard.owner == owner])
    add_braking(parameters, state, mine, push)
    who = np.flatnonzero(push.any(axis=0))
    return Repelled(owner, who, push[:, who])


def all_braked(parameters: Parameters, state: State) -> list[Repelled]:
    """Braked particles by walls and obstacles."""
    guard = parameters.boundary.guard
    if not len(guard.weights):
        return []
    return [braked_by_wall(parameters, state, int(owner)) for owner in np.unique(guard.owner)]
