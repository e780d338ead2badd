"""Forces and torques of the liquid on sides, obstacles and bodies. They are summed pair by pair like the forces on the
liquid, so that action equals reaction.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple, cast

import numpy as np

from ecume._jit import compiled_inside, prange, spread
from ecume.engine.cells import Images, Integers
from ecume.engine.neighbor_rows import Lists
from ecume.models.sph.fields import FIELD, Constants, Floats
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.rates.kernel_loops import slope_of
from ecume.models.sph.rates.sums import damping
from ecume.models.sph.state import Workspace
from ecume.units import Array

Vector = tuple[float, float, float]
BODY_AND_LIQUID = 2.0
"""The force across a mirror, over the force of the image of a body's dummy on the liquid: an equal force acts on the
dummy, by the image of the liquid.
"""


class PairForces(NamedTuple):
    """The terms of the force between two particles: see `PressureForce` and `Friction`."""

    transported: bool
    viscous: bool
    radial: bool
    corrected: bool
    """whether the pressure acts along B_i x_ij and B_j x_ij"""
    spreading: float
    """Pa: the part of the pressure that is not completed"""
    completed: bool
    """whether friction is increased where neighbors are missing at a surface"""
    contrast: float
    """of two liquids: see `sums_of_two`; zero for one liquid"""


@compiled_inside
def _transported(fields: Floats, i: int, j: int, apart: Vector, pull: float) -> Vector:
    """The force by density-weighted pressure and by the momentum of the transport velocity (see
    `sums.pair_transported_pressure`).
    """
    both = (
        0.5
        * pull
        * (fields[FIELD.volume, i] * fields[FIELD.volume, i] + fields[FIELD.volume, j] * fields[FIELD.volume, j])
    )
    mean = fields[FIELD.density, j] * fields[FIELD.pressure, i] + fields[FIELD.density, i] * fields[FIELD.pressure, j]
    mean *= 2.0 / (fields[FIELD.density, i] + fields[FIELD.density, j])
    dx, dy, dz = apart
    own = fields[FIELD.density, i] * (
        fields[FIELD.transport, i] * dx + fields[FIELD.transport + 1, i] * dy + fields[FIELD.transport + 2, i] * dz
    )
    flux = fields[FIELD.density, j] * (
        fields[FIELD.transport, j] * dx + fields[FIELD.transport + 1, j] * dy + fields[FIELD.transport + 2, j] * dz
    )
    return (
        both * (mean * dx - own * fields[FIELD.velocity, i] - flux * fields[FIELD.velocity, j]),
        both * (mean * dy - own * fields[FIELD.velocity + 1, i] - flux * fields[FIELD.velocity + 1, j]),
        both * (mean * dz - own * fields[FIELD.velocity + 2, i] - flux * fields[FIELD.velocity + 2, j]),
    )


@compiled_inside
def completed(fields: Floats, i: int, x: float, y: float, z: float) -> Vector:
    """The vector B_i x."""
    xx, yy, zz = fields[FIELD.correction, i], fields[FIELD.correction + 1, i], fields[FIELD.correction + 2, i]
    xy, xz, yz = fields[FIELD.correction + 3, i], fields[FIELD.correction + 4, i], fields[FIELD.correction + 5, i]
    return xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z


@compiled_inside
def between(share: float, x: Vector, other: Vector) -> Vector:
    """The linear interpolation from the vector x, where the share is zero, to the other one, where it is one."""
    (a, b, c), (d, e, f) = x, other
    return a + share * (d - a), b + share * (e - b), c + share * (f - c)


@compiled_inside
def completion(fields: Floats, i: int, j: int, apart: Vector) -> float:
    """The factor x.(B_i + B_j) x / 2 of a pair. It is r^2 where a particle has all its neighbors, and larger where
    neighbors are missing.
    """
    x, y, z = apart
    (ax, ay, az), (bx, by, bz) = completed(fields, i, x, y, z), completed(fields, j, x, y, z)
    return ((ax + bx) * x + (ay + by) * y + (az + bz) * z) / 2


@compiled_inside
def _corrected(fields: Floats, i: int, j: int, apart: Vector, pair: tuple[float, float, float]) -> Vector:
    """The pressure force with completed gradients, or without them if one of the particles is a dummy (see
    `corrections.pair_corrected_pressure`).
    """
    (weight, damp, spreading), liquid = pair, 1.0
    if fields[FIELD.liquid, i] * fields[FIELD.liquid, j] == 0.0:
        liquid = 0.0
    uniform = spreading * liquid
    own, push = fields[FIELD.force_term, i] - uniform, fields[FIELD.force_term, j] - uniform
    damp += 2.0 * uniform
    x, y, z = apart
    ax, ay, az = between(liquid, apart, completed(fields, i, x, y, z))
    bx, by, bz = between(liquid, apart, completed(fields, j, x, y, z))
    return (
        weight * (own * ax + push * bx + damp * x),
        weight * (own * ay + push * by + damp * y),
        weight * (own * az + push * bz + damp * z),
    )


@compiled_inside
def _rubbed(fields: Floats, i: int, j: int, apart: Vector, law: tuple[float, int, float]) -> Vector:
    """The viscous force of a pair: along the difference of velocities, or along the line of centers with the factor d +
    2.
    """
    pull, radially, soft = law
    held, (dx, dy, dz) = fields[FIELD.viscosity, i] * fields[FIELD.viscosity, j], apart
    drag = (
        4.0
        * pull
        * fields[FIELD.volume, i]
        * fields[FIELD.volume, j]
        * held
        / (fields[FIELD.viscosity, i] + fields[FIELD.viscosity, j])
    )
    du, dv = (
        fields[FIELD.friction_velocity, i] - fields[FIELD.friction_velocity, j],
        fields[FIELD.friction_velocity + 1, i] - fields[FIELD.friction_velocity + 1, j],
    )
    dw = fields[FIELD.friction_velocity + 2, i] - fields[FIELD.friction_velocity + 2, j]
    if radially > 0:
        along = radially * (du * dx + dv * dy + dw * dz) / max(dx * dx + dy * dy + dz * dz, soft)
        du, dv, dw = along * dx, along * dy, along * dz
    return drag * du, drag * dv, drag * dw


@spread
def press(
    fields: Floats,
    mine: Integers,
    group: Integers,
    lists: Lists,
    constants: Constants,
    forces: PairForces,
    force: Array,
) -> None:
    """Sum the forces on each of the columns `mine` by its neighbors in each group, (groups, 3, columns); the group -1
    is ignored.
    """
    kernel, scale, inverse = constants[0].kernel, constants[0].slope_factor, constants[0].inverse_length
    damper = constants[0].smoothing_length, constants[0].damping_divisor, constants[0].sound_speed, constants[0].alpha
    transported, deep = forces.transported, constants[0].dimension == 3
    rubs, corrected, completes = forces.viscous, forces.corrected, forces.completed
    radially = (constants[0].dimension + 2) * (forces.radial)
    counts, start, neighbor = lists
    for place in prange(len(mine)):
        i = mine[place]
        for k in range(counts[i]):
            j = neighbor[start[i] + k]
            g = group[j]
            if g < 0:
                continue
            dx, dy = (
                fields[FIELD.position, j] - fields[FIELD.position, i],
                fields[FIELD.position + 1, j] - fields[FIELD.position + 1, i],
            )
            dz = fields[FIELD.position + 2, j] - fields[FIELD.position + 2, i] if deep else 0.0
            square = dx * dx + dy * dy + dz * dz
            pull = scale * slope_of(math.sqrt(square) * inverse, kernel)
            if transported:
                fx, fy, fz = _transported(fields, i, j, (dx, dy, dz), pull)
            else:
                radial = (fields[FIELD.velocity, j] - fields[FIELD.velocity, i]) * dx + (
                    fields[FIELD.velocity + 1, j] - fields[FIELD.velocity + 1, i]
                ) * dy
                radial += (fields[FIELD.velocity + 2, j] - fields[FIELD.velocity + 2, i]) * dz
                damps = fields[FIELD.liquid, i] * fields[FIELD.liquid, j] * damping(radial, square, damper)
                both = pull * fields[FIELD.weight, i] * fields[FIELD.weight, j]
                if corrected:
                    fx, fy, fz = _corrected(fields, i, j, (dx, dy, dz), (both, damps, forces.spreading))
                else:
                    share = forces.contrast * (fields[FIELD.kind, i] - fields[FIELD.kind, j])
                    own, push = fields[FIELD.force_term, i], fields[FIELD.force_term, j]
                    both *= own + push + share * (own - push) + damps
                    fx, fy, fz = both * dx, both * dy, both * dz
            if rubs and fields[FIELD.viscosity, i] * fields[FIELD.viscosity, j] > 0.0:
                if completes:
                    pull *= completion(fields, i, j, (dx, dy, dz)) / max(square, constants[0].softening)
                rx, ry, rz = _rubbed(fields, i, j, (dx, dy, dz), (pull, radially, constants[0].softening))
                fx, fy, fz = fx + rx, fy + ry, fz + rz
            force[g, 0, place] += fx
            force[g, 1, place] += fy
            force[g, 2, place] += fz


def forces_on(
    parameters: Parameters, workspace: Workspace, mine: Integers, group: Integers, lists: Lists | None = None
) -> Array:
    """The forces on some columns by each group of neighbors, (groups, 3, columns) in N, from a filled workspace."""
    lists, force = lists or workspace.lists, np.zeros((int(group.max(initial=0)) + 1, 3, len(mine)))
    constants, friction = parameters.constants, parameters.friction
    forces = PairForces(
        transported=parameters.pressure_force.transported,
        viscous=friction is not None,
        radial=friction is not None and friction.radial,
        corrected=parameters.pressure_force.corrected,
        spreading=parameters.spreading_pressure,
        completed=friction is not None and friction.corrected,
        contrast=cast(float, (*parameters.contrast, parameters.precision(0.0))[0]),
    )
    press(workspace.fields.table, mine, group, lists, constants, forces, force)
    return force


def forces_on_dummies(parameters: Parameters, workspace: Workspace, first: int) -> tuple[Array, Array]:
    """The force on each dummy from number `first` on, by the liquid and its images, and the position of each dummy; (3,
    n) each.

    The image of a particle behind a mirror acts on a dummy with the mirrored reaction to the force of the dummy's image
    on the particle, so that the momentum of liquid, bodies and walls is conserved. A force from the pressure of the
    dummy itself would differ by the weight of the liquid between the two (2 % of the weight of a tank, with a body on
    its floor). The component parallel to the mirror is a force on the dummy. The component normal to it acts on both
    and is balanced by the mirror if the dummy is part of a body (see `BODY_AND_LIQUID`); an obstacle is fixed.
    """
    images, real, liquid = workspace.images, len(workspace.lists.counts), workspace.rates.shape[1]
    mine, root = np.arange(liquid + first, real), roots_of(images, real)
    turned = chains_of(images, real) & _bits_of_mirrors(parameters) != 0
    group = np.full(workspace.fields.shape[1], -1)
    group[:liquid] = 0
    group[real:][(root < liquid) & ~turned] = 0
    force = forces_on(parameters, workspace, mine, group)[0]
    reflected = np.flatnonzero(turned & (root >= liquid + first))
    if len(reflected):
        _add_reflected(parameters, workspace, reflected, force)
    return force, _places(parameters, workspace, mine)


def _add_reflected(parameters: Parameters, workspace: Workspace, reflected: Integers, force: Array) -> None:
    """Add the forces on the images of dummies, which are some of the images, to the forces on the dummies
    themselves.
    """
    images, real, liquid = workspace.images, len(workspace.lists.counts), workspace.rates.shape[1]
    near = np.unique(images.source[images.source < liquid])
    columns, group = real + reflected, np.zeros(workspace.fields.shape[1], np.int64)
    lists = reversed_lists(workspace.lists, near, columns, len(group))
    push = forces_on(parameters, workspace, columns, group, lists)[0]
    chain, root = chains_of(images, real)[reflected], roots_of(images, real)[reflected]
    fixed, (kinds, kind) = root < liquid + parameters.bodies.first, np.unique(chain, return_inverse=True)
    crossed = [_crossed(parameters.boundary.image_owner, int(each)) for each in kinds]
    for axis in range(parameters.dimension):
        turns = np.array([axis in each for each in crossed])[kind]
        own = np.where(turns, np.where(fixed, 0.0, -push[axis]), push[axis])
        force[axis] += np.bincount(root - (real - force.shape[1]), own, force.shape[1])


def reversed_lists(lists: Lists, rows: Integers, columns: Integers, size: int) -> Lists:
    """The reversed lists: for each of the `columns`, out of `size`, the given rows in whose list it occurs."""
    length = np.diff(lists.start)[rows]
    place = np.arange(int(length.sum())) + np.repeat(lists.start[rows] - np.cumsum(length) + length, length)
    mine, other = np.repeat(rows, length), lists.neighbor[place]
    selected = np.zeros(size, np.bool_)
    selected[columns] = True
    listed = selected[other] & (place - lists.start[mine] < lists.counts[mine])
    mine, other = mine[listed], other[listed]
    order = np.argsort(other, kind="stable")
    counts = np.bincount(other, minlength=size)
    start = np.concatenate([[0], np.cumsum(counts)])
    return Lists(counts.astype(np.int32), start, mine[order].astype(np.int32))


def _bits_of_mirrors(parameters: Parameters) -> int:
    """The sides that are mirrors, as bits: see `chains_of`."""
    return sum(1 << int(side) for side in np.flatnonzero(parameters.boundary.sides.mirrors))


def total(force: Array, place: Array, center: Array) -> tuple[Array, Array]:
    """The sum of forces at places, each (3, n), and their torque about a center."""
    (x, y, z), (along, up, deep) = place - center[:, None], force
    torque = np.stack([y * deep - z * up, z * along - x * deep, x * up - y * along], axis=1).sum(axis=0)
    return force.sum(axis=1), torque


def loads(parameters: Parameters, workspace: Workspace) -> Iterator[tuple[str, Array, Array]]:
    """Yield the name, the force and the torque of each wall, obstacle and body. Torques of walls are about the middle
    of the tank, those of other solids about their center.
    """
    for number, load in loads_of(parameters, workspace, forces_on_dummies(parameters, workspace, 0)):
        yield parameters.boundary.names[number], *load


def loads_of(
    parameters: Parameters, workspace: Workspace, on_dummies: tuple[Array, Array]
) -> Iterator[tuple[int, tuple[Array, Array]]]:
    """Yield the number, and the force and torque, of each wall, obstacle and body, from the forces on dummies and their
    positions.
    """
    boundary, (force, place), d = parameters.boundary, on_dummies, parameters.dimension
    mirrored, at = forces_of_images(parameters, workspace)
    for number in range(len(boundary.names)):
        borne = boundary.dummies.bearer == number
        mine = borne.any(axis=0)
        if number in mirrored:
            yield number, total(-mirrored[number], at, boundary.centers[number])
        elif mine.any():
            own = force[:, mine]
            own[:d] *= borne[:, mine]
            yield number, total(own, place[:, mine], boundary.centers[number])


OBSTACLE, BODY = 1, 2
"""Kinds of sources of images: obstacle and body; 0 is liquid."""


def forces_of_images(parameters: Parameters, workspace: Workspace) -> tuple[dict[int, Array], Array]:
    """The force of each mirror on the liquid in front of it, by side; and the indices of that
    liquid.

    An image in a corner was mirrored by two or three sides; each side receives the component along its normal.
    """
    images, boundary = workspace.images, parameters.boundary
    liquid, real = workspace.rates.shape[1], len(workspace.lists.counts)
    root, body = roots_of(images, real), liquid + parameters.bodies.first
    of_solids = np.where(root >= body, BODY, np.where(root >= liquid, OBSTACLE, 0))
    kinds, kind = np.unique(4 * chains_of(images, real) + of_solids, return_inverse=True)
    group = np.full(workspace.fields.shape[1], -1)
    group[real:] = kind.ravel()
    mine = np.unique(images.source[images.source < liquid])
    force = forces_on(parameters, workspace, mine, group)
    found = {int(side): np.zeros((3, len(mine))) for side in boundary.image_owner if side >= 0}
    for g, code in enumerate(kinds):
        chain, solid = int(code) >> 2, int(code) & 3
        crossed = _crossed(boundary.image_owner, chain)
        for axis in range(3):
            side = _bearer(boundary.image_owner, chain, axis)
            # Along a mirror, the force on the image of a dummy equals that on the dummy.
            if side >= 0 and (axis in crossed or not solid):
                found[side][axis] += (BODY_AND_LIQUID if solid == BODY else 1.0) * force[g, axis]
    return found, _places(parameters, workspace, mine)


def force_of_mirror(parameters: Parameters, workspace: Workspace, mine: Integers, what: tuple[int, int]) -> float:
    """The force (N) of one mirror on some of the liquid along one axis, as in `forces_of_images`; `what` contains the
    side of the mirror and the axis.
    """
    images, owner, (side, axis) = workspace.images, parameters.boundary.image_owner, what
    real = len(workspace.lists.counts)
    chains, root, liquid = chains_of(images, real), roots_of(images, real), workspace.rates.shape[1]
    borne, crossed = np.zeros((2, 1 << len(owner)), np.bool_)
    for chain in np.flatnonzero(np.bincount(chains, minlength=1)):
        borne[chain] = _bearer(owner, int(chain), axis) == side
        crossed[chain] = axis in _crossed(owner, int(chain))
    group = np.full(workspace.fields.shape[1], -1)
    group[real:][borne[chains] & (crossed[chains] | (root < liquid))] = 0
    group[real:][(group[real:] == 0) & (root >= liquid + parameters.bodies.first)] = 1
    force = forces_on(parameters, workspace, mine, group)[:, axis].sum(axis=1)
    return float(force[0] + BODY_AND_LIQUID * force[1:].sum())


def roots_of(images: Images, real: int) -> Integers:
    """The original particle of each image."""
    roots = images.source
    while (roots >= real).any():
        roots = np.where(roots >= real, images.source[np.maximum(roots - real, 0)], roots)
    return roots


def _crossed(owner: Integers, chain: int) -> set[int]:
    """The axes that a chain of mirrors reverses."""
    found = set[int]()
    for bit, side in enumerate(owner):
        if chain >> bit & 1 and side >= 0:
            found ^= {int(side) // 2}
    return found


def chains_of(images: Images, real: int) -> Integers:
    """The sides that mirrored each image, as bits."""
    chains = np.zeros(len(images.source), np.int64)
    for side in range(len(images.start) - 1):
        here = slice(images.start[side], images.start[side + 1])
        earlier = images.source[here] - real
        chains[here] = np.where(earlier >= 0, chains[np.maximum(earlier, 0)], 0) | (1 << side)
    return chains


def _bearer(owner: Integers, chain: int, axis: int) -> int:
    """The side on which a component of the force acts: the side of the chain that is normal to it, or else the last
    side; -1 if the chain contains no wall.
    """
    through = [int(side) for bit, side in enumerate(owner) if chain >> bit & 1 and side >= 0]
    return next((side for side in through if side // 2 == axis), through[-1] if through else -1)


def _places(parameters: Parameters, workspace: Workspace, mine: Integers) -> Array:
    place = workspace.fields.position[:3, mine].astype(np.float64)
    place[parameters.dimension :] = 0.0
    place[: parameters.dimension] += parameters.origin[:, None]
    return place
