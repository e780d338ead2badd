"""Forces of the liquid on obstacles and bodies that touch a wall or one another.

Pairs of particles say what all solids together do to the liquid. Which of two that touch bears it they do not say:
around the contact a dummy has dummies instead of liquid beside it, which exert nothing, so that a disc on the floor
was pulled down. There the force of the pressure on a solid is its surface integral,

    F = -sum_k p_k n_k A_k,    p_k = sum_j w_kj [p_j + rho g.(x_k - x_j)] / sum_j w_kj,

over panels k of its surface; the error is of first order in the spacing, and zero in liquid at rest but for the panels
[monaghan1994]. The weights are w_kj = V_j W_kj f_j^4, with the sum f_j of V W over the liquid around j, and a kernel
that reaches one and a half supports: single particles in a wedge have dummies instead of liquid around them, which hold
them at a pressure that may differ by that of a third of a spacing. Without these weights they cost a disc on the floor,
five particles across, 6 % of its weight. What a solid gets more than by pairs the other one gets less, so that the sum
stays that of pairs. A gap too narrow for particles is wet, with the pressure of the nearest liquid. An obstacle's face
on a wall is dry. The integral fades out where the gap is between half a support and a whole one.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ecume._portable import product
from ecume.engine.interpolation import added, near
from ecume.engine.shapes import Flags, Shape
from ecume.engine.walls.sheets import SIZE
from ecume.engine.walls.surfaces import PLANE
from ecume.laws.kernels import kernel
from ecume.models.sph.boundaries.forces_on_solids import forces_on_dummies, total
from ecume.models.sph.boundaries.rigid_bodies import rotations
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.state import State, Workspace
from ecume.units import Array

FINE = 0.25
"""Width of panels, in spacings."""
SEALED = 1e-6
"""In spacings: an obstacle's panel this close to a wall is dry."""
KERNEL = "wendland-c2"
FAR = 1.5
"""Supports within which liquid has a say on the pressure at a panel."""
TRUST = 4
"""The power of the liquid part of a particle's surroundings by which it has that say."""


class Solid(NamedTuple):
    """An obstacle or a body where it is."""

    owner: int
    """a place in `Boundary.names`"""
    shape: Shape
    turn: Array
    """(d, d) from the axes of the shape to those of the tank"""
    middle: Array
    """(d,) the origin of the axes of the shape"""
    moves: bool

    def gap(self, points: Array) -> Array:
        """(N,) how far points are outside of it."""
        return self.shape.nearest(product(points - self.middle, self.turn))[0]


def solids_now(now: Parameters, pose: Array) -> list[Solid]:
    """Obstacles, then bodies."""
    d, bodies = now.dimension, now.bodies
    first = len(now.boundary.names) - len(bodies.shapes) - len(bodies.obstacles)
    shapes = enumerate(bodies.obstacles, first)
    found = [Solid(owner, shape, np.eye(d), np.zeros(d), moves=False) for owner, shape in shapes]
    turns = rotations(pose) if bodies.shapes else np.zeros((0, 3, 3))
    for body, shape in enumerate(bodies.shapes):
        owner = first + len(bodies.obstacles) + body
        found.append(Solid(owner, shape, turns[body][:d, :d], pose[:d, body], moves=True))
    return found


def gaps_of(now: Parameters, solids: list[Solid], mine: Solid, points: Array) -> dict[int, Array]:
    """By owner, how far points are from walls and other solids."""
    guard, d = now.boundary.guard, now.dimension
    kind, number, found = guard.sheet.kind, guard.sheet.number, dict[int, Array]()
    for k in np.flatnonzero((kind[:, 0] == PLANE) & (kind[:, 2] == 0)):
        found[int(guard.owner[k])] = product(points, number[k, :d]) - number[k, SIZE]
    for other in solids:
        if other.owner != mine.owner:
            found[other.owner] = other.gap(points)
    return found


def pressures_at(now: Parameters, state: State, workspace: Workspace, points: Array, narrow: Flags) -> Array:
    """(N,) Pa at points of a surface: zero where it is dry. In narrow gaps, that of the nearest liquid."""
    count, fields = state.position.shape[1], workspace.fields
    density = fields.density[:count].astype(np.float64)
    push = fields.force_term[:count].astype(np.float64) * (density**2 if now.pressure_force.by_mass else 1.0)
    reach = FAR * now.support
    low, high = points.min(axis=0) - reach, points.max(axis=0) + reach
    close = ((low < state.position.T) & (high > state.position.T)).all(axis=1)
    found = np.zeros(len(points))
    if not close.any():
        return found
    place, push = state.position[:, close].T, push[close]
    volume = fields.volume[:count][close].astype(np.float64)
    pairs, shape = near(points, place, reach), kernel(KERNEL, dim=now.dimension)
    weight = (volume * filling(place, volume, now.support) ** TRUST)[pairs.particle]
    weight *= np.asarray(shape.value(pairs.distance, reach / shape.support))
    gravity = now.gravity - now.pull_rate**2 * (points - now.pull_center)
    rise = now.material.density * (gravity[pairs.point] * -pairs.away).sum(axis=1)
    there = added(pairs, weight)
    wet = np.zeros(len(points), np.bool_)
    wet[pairs.point[pairs.distance < now.support]] = True
    wet &= there > 0.0
    found[wet] = added(pairs, weight * (push[pairs.particle] + rise))[wet] / there[wet]
    lonely = np.flatnonzero(~wet & narrow)
    if len(lonely):
        from scipy.spatial import cKDTree

        _, nearest = cKDTree(place).query(points[lonely])
        way = points[lonely] - place[nearest]
        found[lonely] = push[nearest] + now.material.density * (gravity[lonely] * way).sum(axis=1)
    return np.maximum(found, 0.0) if now.walls_clip else found


def filling(place: Array, volume: Array, support: float) -> Array:
    """(N,) the kernel's sum over the liquid around each particle, itself included."""
    pairs, shape = near(place, place, support), kernel(KERNEL, dim=place.shape[1])
    return added(pairs, volume[pairs.particle] * np.asarray(shape.value(pairs.distance, support / shape.support)))


Load = tuple[Array, Array]
"""Force and torque, (3,) each."""


def exchanged_loads(now: Parameters, state: State, workspace: Workspace, movers: bool = False) -> dict[int, Load]:
    """By owner, the force and torque to add to what pairs give; of bodies and what they touch alone, if `movers`."""
    solids, found, sums = solids_now(now, state.pose), dict[int, Load](), dict[int, Load]()
    for mine in solids:
        if movers and not mine.moves:
            continue
        local, normal, area = mine.shape.panels(FINE * now.spacing)
        points = mine.middle + product(local, mine.turn.T)
        gaps = gaps_of(now, solids, mine, points)
        least = {owner: float(gap.min()) for owner, gap in gaps.items()}
        share = min(1.0, 2.0 - 2.0 * min(least.values(), default=np.inf) / now.support)
        if share <= 0.0:
            continue
        gap = np.min(list(gaps.values()), axis=0)
        pressure = pressures_at(now, state, workspace, points, gap < now.spacing)
        if not mine.moves:
            pressure[gap < SEALED * now.spacing] = 0.0
        force = np.zeros((3, len(points)))
        force[: now.dimension] = -(pressure * area) * product(normal, mine.turn.T).T
        place = np.zeros((3, len(points)))
        place[: now.dimension] = points.T
        integral = total(force, place, now.boundary.centers[mine.owner])
        sums = sums or pair_loads(now, workspace, movers)
        by_pairs = sums[mine.owner]
        more = share * (integral[0] - by_pairs[0]), share * (integral[1] - by_pairs[1])
        for owner, load in _shared(now, mine, least, more):
            had = found.get(owner, (np.zeros(3), np.zeros(3)))
            found[owner] = had[0] + load[0], had[1] + load[1]
    return found


def pair_loads(now: Parameters, workspace: Workspace, movers: bool) -> dict[int, Load]:
    """By owner, what the pressures of pairs do to obstacles and bodies, about their centers."""
    boundary = now.boundary
    first = now.bodies.first if movers else int(np.count_nonzero(boundary.dummies.owner < 2 * now.dimension))
    force, place = forces_on_dummies(now._replace(friction=None), workspace, first)
    owner = boundary.dummies.owner[first:]
    owners = range(2 * now.dimension, len(boundary.names))
    return {k: total(force[:, owner == k], place[:, owner == k], boundary.centers[k]) for k in owners}


def _shared(now: Parameters, mine: Solid, least: dict[int, float], more: Load) -> Iterator[tuple[int, Load]]:
    """What a solid gets and what those beside it lose: along each axis the nearest wall across it within a support, or
    else the nearest neighbor. Of two solids each gets half of the difference it has, and half of the other's.
    """
    centers, (force, torque) = now.boundary.centers, more
    nearest = min(least, key=lambda owner: least[owner])
    for axis in range(3):
        walls = [owner for owner in (2 * axis, 2 * axis + 1) if least.get(owner, np.inf) < now.support]
        other = min(walls, key=lambda owner: least[owner]) if walls and axis < now.dimension else nearest
        part = np.zeros(3)
        part[axis] = force[axis] * (1.0 if other < 2 * now.dimension else 0.5)
        yield mine.owner, (part, np.zeros(3))
        yield other, (-part, -np.cross(centers[mine.owner] - centers[other], part))
    turn = torque * (1.0 if nearest < 2 * now.dimension else 0.5)
    yield mine.owner, (np.zeros(3), turn)
    yield nearest, (np.zeros(3), -turn)


def power_on_bodies(now: Parameters, state: State, workspace: Workspace) -> float:
    """Power (W) of the exchanged loads on bodies, which no pair of particles pays for."""
    bodies, first = len(now.bodies.shapes), len(now.boundary.names) - len(now.bodies.shapes)
    if not bodies:
        return 0.0
    found = exchanged_loads(now, state, workspace, movers=True)
    power = 0.0
    for body in range(bodies):
        force, torque = found.get(first + body, (np.zeros(3), np.zeros(3)))
        power += float(np.sum(force * state.motion[:3, body]) + np.sum(torque * state.motion[3:, body]))
    return power
