"""Bodies that follow a prescribed path, whatever the forces on them: gates, pistons, flaps, stirrers, rolling tanks.

A body is displaced by u and rotated by the angle q about an axis a through a pivot P, which moves with the body. With w
= q' a and the arm r of a point from the pivot, x = P + u + r, the point has the velocity u' + w x r and the
acceleration u'' + q'' a x r + w x (w x r). The mass of such a body is infinite: collisions do not change its path.

The body does the work -integral (F.v + T.w) dt on the liquid, where F and T are the force and the torque of the liquid
on the body by pressure, friction and repulsion.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ecume._portable import dot
from ecume.models.sph.boundaries.forces_on_solids import forces_on_dummies, total
from ecume.models.sph.boundaries.rigid_bodies import drive_at, rotated, turned
from ecume.models.sph.boundaries.walls import repelled_by_body, repulsion_load
from ecume.models.sph.parameters import BodyPath, Parameters
from ecume.models.sph.state import State, Workspace
from ecume.units import Array


def on_path(path: BodyPath, time: float) -> tuple[Array, Array, Array]:
    """The pose (7,), the motion (6,) and the acceleration (6,) of a body on its path."""
    value, rate, second = drive_at(path.drive, time)
    turn = value[3] * path.axis
    arm = rotated(turn, path.pose[:3] - path.pivot)
    spin, spun = rate[3] * path.axis, second[3] * path.axis
    pose = np.concatenate([path.pivot + value[:3] + arm, turned(path.pose[3:], turn)])
    motion = np.concatenate([rate[:3] + np.cross(spin, arm), spin])
    own = second[:3] + np.cross(spun, arm) + np.cross(spin, np.cross(spin, arm))
    return pose, motion, np.concatenate([own, spun])


def drive_bodies(parameters: Parameters, state: State) -> None:
    """Set the driven bodies to the present points of their paths. Kicks do not change their motion."""
    for body, path in parameters.bodies.paths:
        pose, motion, acceleration = on_path(path, float(state.clock[0]))
        state.pose[:, body], state.motion[:, body] = pose, motion
        state.body_acceleration[:, body] = 0.0
        state.delayed_body_acceleration[:, body] = acceleration


def power_of_driven_bodies(now: Parameters, state: State, workspace: Workspace) -> float:
    """The power (W) of driven bodies on the liquid, from a filled workspace."""
    if not now.bodies.paths:
        return 0.0
    force, place = forces_on_dummies(now, workspace, now.bodies.first)
    owner, power = now.boundary.dummies.owner[now.bodies.first :], 0.0
    for body, number in owners_of_driven(now):
        mine = owner == number
        pressed = total(force[:, mine], place[:, mine], state.pose[:3, body])
        pushed = repulsion_load(now, state, repelled_by_body(now, state, body))
        for one, torque in (pressed, pushed):
            power -= dot(one, state.motion[:3, body]) + dot(torque, state.motion[3:, body])
    return power


def owners_of_driven(parameters: Parameters) -> Iterator[tuple[int, int]]:
    """The driven bodies, and their indices in `Boundary.names`."""
    first = len(parameters.boundary.names) - len(parameters.bodies.shapes)
    for body, _ in parameters.bodies.paths:
        yield body, first + body
