"""Overlaps of given positions, which are removed before a run starts.

During a run contacts keep overlaps below the slop, and remove deeper ones by moving floats without changing velocities.
Such a displacement changes the energy of the floats without an entry in the energy budget. Positions from other
programs may have such overlaps. They are therefore reduced to less than the slop before the first step.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ecume.engine.cells import Integers
from ecume.engine.contact import torque_contacts as touching
from ecume.engine.contact.contacts import Candidates
from ecume.engine.contact.separation import separate
from ecume.engine.outlines import NEARNESS, Stance, bodies_near, turn_corners, wall_near
from ecume.engine.walls import Walls, wall_count
from ecume.engine.walls.rings import inner_radius_of, outer_walls
from ecume.models.floating.contacts.collisions import Outlined
from ecume.models.floating.parameters import Parameters
from ecume.units import Array

SLIGHT, MOST_SWEEPS = 0.02, 1000
"""The largest overlap of round floats, in radii, that is removed before a run, and the largest number of sweeps. Soft
contacts of other programs leave such overlaps.
"""
ENOUGH = 1e-10
"""The remaining overlap, over the radius, at which the separation ends."""
KEPT = 0.9
"""The overlap that is left unchanged, over the slop. Those that a run leaves are smaller, since it separates floats
down to half of the slop: its rafts are continued to the bit.
"""


def separated(position: Array, radius: Array, periods: Array, walls: Walls, slop: float) -> Array:
    """Return positions of floats with small overlaps after separating them along their lines of centers and from walls
    until they touch. Positions are unchanged if no overlap exceeds `KEPT` of the slop, or if one is larger than
    `SLIGHT`.
    """
    pairs = _near(position, radius, periods)
    deepest = _depths(position, radius, periods, pairs)[1]
    sunk_in = np.array([depth for depth, _ in _into_walls(position, radius, walls)] or [np.zeros(len(radius))])
    least = np.minimum(*radius[pairs.T])
    slight = (deepest <= SLIGHT * least).all() and (sunk_in <= SLIGHT * radius).all()
    if not slight or not ((deepest > KEPT * slop).any() or (sunk_in > KEPT * slop).any()):
        return position
    found, (i, j) = position.copy(), pairs.T
    for _ in range(MOST_SWEEPS):
        away, depth = _depths(found, radius, periods, pairs)
        shift, remaining = np.zeros_like(found), depth.max(initial=0.0)
        # Half of the displacement for a single pair, since a float with several overlaps is moved by each of them.
        push = 0.25 * np.maximum(depth, 0.0)[:, None] * away
        np.add.at(shift, i, -push)
        np.add.at(shift, j, push)
        for sunk, inward in _into_walls(found, radius, walls):
            shift += 0.5 * np.maximum(sunk, 0.0)[:, None] * inward
            remaining = max(remaining, sunk.max(initial=0.0))
        if remaining <= ENOUGH * radius.min():
            break
        found += shift
    return found


def _near(position: Array, radius: Array, periods: Array) -> Integers:
    """The pairs (P, 2) that overlap, or may overlap once other floats are moved."""
    if len(radius) < 2:
        return np.zeros((0, 2), np.int64)
    box = [side if side > 0.0 else None for side in periods[0].tolist()]
    wrapped = None if None in box else np.array(box)
    from scipy.spatial import cKDTree

    reach = 2.0 * float(radius.max()) * (1.0 + SLIGHT)
    there = position if wrapped is None else np.mod(position, wrapped)
    pairs = cKDTree(there, boxsize=wrapped).query_pairs(reach, output_type="ndarray").astype(np.int64)
    depth = _depths(position, radius, periods, pairs)[1]
    return np.asarray(pairs[depth > -SLIGHT * np.minimum(*radius[pairs.T])])


def _depths(position: Array, radius: Array, periods: Array, pairs: Integers) -> tuple[Array, Array]:
    """The unit vectors (P, 2) from the first to the second float of pairs, and the depths of their overlaps (m)."""
    away = position[pairs[:, 1]] - position[pairs[:, 0]]
    box = np.where(periods[0] > 0.0, periods[0], 1.0)
    away -= np.where(periods[0] > 0.0, np.round(away / box) * box, 0.0)
    distance = np.hypot(away[:, 0], away[:, 1])
    unit = np.divide(away, distance[:, None], out=np.zeros_like(away), where=distance[:, None] > 0.0)
    return unit, radius[pairs].sum(axis=1) - distance


def _into_walls(position: Array, radius: Array, walls: Walls) -> Iterator[tuple[Array, Array]]:
    """For each wall the depths (m) by which floats are in it, and its inward normals (N, 2)."""
    if walls.disc_radius < np.inf:
        distance = np.hypot(position[:, 0], position[:, 1])
        out = np.divide(position, distance[:, None], out=np.zeros_like(position), where=distance[:, None] > 0.0)
        yield radius + distance - walls.disc_radius, -out
    inner = inner_radius_of(walls)
    if inner > 0.0:
        distance = np.hypot(position[:, 0], position[:, 1])
        out = np.divide(position, distance[:, None], out=np.zeros_like(position), where=distance[:, None] > 0.0)
        yield radius + inner - distance, out
    lines = outer_walls(walls)
    for normal, offset in zip(lines.normal, lines.offset, strict=True):
        yield radius + offset - position @ normal, np.broadcast_to(normal, position.shape)


Gaps = list[tuple[int, int, float]]
"""Triples (i, j, gap) of bodies that are near; a wall number k stands as N + k."""


def gaps_of_outlines(part: Outlined, parameters: Parameters, at: tuple[Array, Array], reach: float) -> Gaps:
    """Pairs nearer than `reach`, for bodies at the positions and angles `at`, for initial states and frames. All pairs
    are tested.
    """
    (position, _), radius, count, outlines = at, parameters.floats.radius, len(at[0]), part.outlines
    stance = _stance(part, parameters, at)
    turn_corners(outlines, stance)
    near, found = np.zeros((part.places, NEARNESS)), []
    for i in range(count):
        pairs = np.column_stack([np.full(count - i - 1, i), np.arange(i + 1, count)])
        depth = _depths(position, radius, parameters.periods, pairs)[1]
        for j in i + 1 + np.flatnonzero(depth > -reach):
            total = bodies_near(outlines, stance, i, int(j), reach, near)
            if total:
                found.append((i, int(j), float(near[:total, 0].min())))
        for wall in range(wall_count(parameters.walls)):
            total = wall_near(outlines, stance, parameters.walls, (i, wall), reach, near)
            if total:
                found.append((i, count + wall, float(near[:total, 0].min())))
    return found


def separated_outlines(
    part: Outlined, parameters: Parameters, at: tuple[Array, Array], gaps: Gaps
) -> tuple[Array, Array]:
    """The positions and angles of bodies that overlapped slightly, without overlaps above `KEPT` of the slop. `gaps`
    are those of bodies at the positions and angles `at`.
    """
    count, slop = len(parameters.floats.radius), KEPT * parameters.slop
    stance, pairs = _stance(part, parameters, at), [(i, j) for i, j, _ in gaps if j < count]
    first = np.searchsorted([i for i, _ in pairs], np.arange(count + 1))
    candidates = Candidates(first.astype(np.int64), np.array([j for _, j in pairs], np.int64))
    weights = np.stack([1.0 / parameters.floats.mass] * 3, axis=1)
    weights[:, 2] *= 2.0 / parameters.floats.radius**2  # the inertia of a disc; it only distributes the displacement
    bodies = touching.OutlinedBodies(
        part.outlines, parameters.floats.radius, parameters.walls, weights, parameters.passing
    )
    contacts = touching.make_torque_contacts(len(gaps) * part.places, part.places)
    touching.gather(contacts, candidates, stance, bodies, 4.0 * slop)
    separate(contacts, candidates, stance, bodies, slop)
    return stance.position, stance.angle


def _stance(part: Outlined, parameters: Parameters, at: tuple[Array, Array]) -> Stance:
    return Stance(np.array(at[0]), np.array(at[1]), np.zeros_like(part.outlines.corner), parameters.periods)
