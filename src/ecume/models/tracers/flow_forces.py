"""Forces of a liquid whose velocity varies, beside drag: its acceleration, Faxen's correction, and Saffman's lift.

They are those of Maxey and Riley's equation without Basset's history [maxey1983], half a step ahead, and constant
during a step. `ecume check` states the size of the history.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ecume._jit import admit, compiled
from ecume.engine.cells import Integers
from ecume.engine.walls.sheets import cross, length
from ecume.laws import unsteady_forces
from ecume.models.tracers.flow_loops import ACCELERATION, CURVATURE, VORTICITY
from ecume.units import Array

admit(unsteady_forces)


class Forces(NamedTuple):
    """The selected forces, 1 or 0 each."""

    acceleration: float = 0.0
    faxen: float = 0.0
    lift: float = 0.0

    @property
    def any(self) -> bool:
        """Whether any force is selected."""
        return max(self) > 0.0


@compiled
def add_forces(
    velocity: Array,
    status: Integers,
    bodies: tuple[Array, Array, Array],
    liquid: tuple[Array, Array],
    numbers: tuple[float, float, float, float, float, float],
    found: Array,
) -> None:
    """Set the accelerations by these forces (m/s^2). bodies = (mass, radius, friction); liquid = (velocities,
    gradients); numbers = (density, viscosity, added mass over displaced mass, and the three of `Forces`).
    """
    (mass, radius, friction), (flow, gradients) = bodies, liquid
    density, viscosity, added, moves, curved, lifted = numbers
    d = velocity.shape[1]
    for i in range(len(status)):
        if status[i] != 0:
            continue
        displaced = 4.0 / 3.0 * math.pi * radius[i] ** 3 * density
        slip = (
            flow[i, 0] - velocity[i, 0],
            flow[i, 1] - velocity[i, 1],
            flow[i, 2] - velocity[i, 2] if d > 2 else 0.0,
        )
        turn = (gradients[i, VORTICITY], gradients[i, VORTICITY + 1], gradients[i, VORTICITY + 2])
        spin = length(turn)
        push = cross(slip, turn)
        strength = unsteady_forces.saffman_lift(1.0, radius[i], density, viscosity, spin) / spin if spin > 0.0 else 0.0
        for axis in range(d):
            force = moves * unsteady_forces.liquid_inertia(displaced, gradients[i, ACCELERATION + axis], added)
            bent = unsteady_forces.faxen_velocity(radius[i], gradients[i, CURVATURE + axis])
            force += curved * friction[i] * bent + lifted * strength * push[axis]
            found[i, axis] = force / mass[i]


@compiled
def work_of_forces(
    mass: Array, status: Integers, hits: Integers, forces: Array, ends: tuple[Array, Array, Array]
) -> float:
    """The work of accelerations along the paths of a step, without the part that is thermal noise (J); ends = (origin,
    position, random displacement).
    """
    origin, position, shift = ends
    total = 0.0
    for i in range(len(status)):
        if status[i] == 0 or status[i] == -1:
            for axis in range(position.shape[1]):
                way = position[i, axis] - origin[i, axis] - (shift[i, axis] if hits[i] == 0 else 0.0)
                total += mass[i] * forces[i, axis] * way
    return total
