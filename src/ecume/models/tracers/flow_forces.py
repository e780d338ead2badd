"""Forces on tracers that follow from the variation of the liquid's velocity: its acceleration, Faxen's correction, and
Saffman's lift.

They are those of Maxey and Riley's equation without Basset's history [maxey1983], evaluated at the middle of a step and
constant during it. `ecume check` states the size of the history force.
"""

from __future__ import annotations

import math

from ecume._jit import admit, compiled
from ecume.engine.cells import Integers
from ecume.engine.walls.sheets import axpy, cross, length
from ecume.laws import brownian_motion, unsteady_forces
from ecume.models.tracers.drag_laws import DragChoice
from ecume.models.tracers.flow_loops import ACCELERATION, CURVATURE, VORTICITY
from ecume.models.tracers.time_stepping import friction_at
from ecume.units import Array

admit(brownian_motion, unsteady_forces)


@compiled
def add_forces(
    velocity: Array,
    status: Integers,
    bodies: tuple[Array, Array, Array, Array, Array],
    liquid: tuple[Array, Array, DragChoice],
    numbers: tuple[float, float, float, float, float, float, float],
    laws: Array,
    found: Array,
) -> None:
    """Set the accelerations (m/s^2) by the forces of an accelerating and curved flow. bodies = (mass, radius, friction,
    apparent gravity, sphericity); liquid = (velocities, gradients, drag law); numbers = (time step, density, viscosity,
    added mass over displaced mass, and the three flags of `Forces`); `laws` are the accelerations by user laws.

    Lift uses the slip in the middle of the step, predicted from drag and the forces at its start, so that it is of
    second order.
    """
    (mass, radius, friction, weight, sphericity), (flow, gradients, law) = bodies, liquid
    h, density, viscosity, added, moves, curved, lifted = numbers
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
        for axis in range(d):
            force = moves * unsteady_forces.liquid_inertia(displaced, gradients[i, ACCELERATION + axis], added)
            bent = unsteady_forces.faxen_velocity(radius[i], gradients[i, CURVATURE + axis])
            found[i, axis] = (force + curved * friction[i] * bent) / mass[i]
        turn = (gradients[i, VORTICITY], gradients[i, VORTICITY + 1], gradients[i, VORTICITY + 2])
        spin = length(turn)
        if lifted == 0.0 or spin == 0.0:
            continue
        strength = lifted * unsteady_forces.saffman_lift(1.0, radius[i], density, viscosity, spin) / spin / mass[i]
        rate = friction_at(length(slip), (radius[i], friction[i], sphericity[i]), (law, density, viscosity))
        rate /= mass[i]
        gain, push = 0.5 * h * brownian_motion.velocity_gain(0.5 * h * rate), cross(slip, turn)
        fall = weight[i]
        start = (
            rate * slip[0] + strength * push[0] + found[i, 0] + laws[i, 0],
            rate * slip[1] + strength * push[1] + found[i, 1] + laws[i, 1] - (fall if d == 2 else 0.0),
            rate * slip[2] + strength * push[2] + found[i, 2] + laws[i, 2] - fall if d > 2 else 0.0,
        )
        push = cross(axpy(slip, -gain, start), turn)
        for axis in range(d):
            found[i, axis] += strength * push[axis]


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
