"""Rigid bodies against sides, obstacles and one another: impulses at the deepest point of every contact, over again
until nobody approaches; who overlaps is moved apart.

A contact's normal points out of the other thing, towards the body. Impulses are Newton's with Coulomb's friction
(Mirtich and Canny 1995, who resolve all contacts by such impulses). [mirtich1995]
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ecume._portable import dot, length, product, solve
from ecume.engine.shapes import Shape
from ecume.engine.walls import Sheet
from ecume.engine.walls.sheets import SIZE, SPEED
from ecume.engine.walls.surfaces import PLANE
from ecume.models.sph.bodies import give, inverse_inertia_of, rotations
from ecume.models.sph.parameters import Bodies
from ecume.units import Array

SWEEPS = 12
NOTHING = -1


class Contact(NamedTuple):
    """One body in another, or in something that does not give way."""

    body: int
    other: int
    """or NOTHING"""
    point: Array
    """(3,)"""
    normal: Array
    """(3,)"""
    depth: float
    velocity: Array
    """(3,) of a wall"""


def collide(bodies: Bodies, sheet: Sheet, state: tuple[Array, Array], calm: float) -> tuple[int, float]:
    """Resolve all contacts of bodies with poses and motions, in place; how many there were at first, and what walls
    that move did (J). What approaches more slowly than `calm` does not bounce.
    """
    first, work = 0, 0.0
    for sweep in range(SWEEPS):
        found = list(contacts(bodies, sheet, state[0]))
        first = first if sweep else len(found)
        if not found:
            break
        for contact in found:
            _separate(bodies, state[0], contact)
            work += dot(_strike(bodies, state, contact, calm), contact.velocity)
    return first, work


def contacts(bodies: Bodies, sheet: Sheet, pose: Array) -> Iterator[Contact]:
    """The deepest point of every pair that overlaps."""
    rims = [pose[:3, b] + product(rim, rotations(pose[:, b : b + 1])[0].T) for b, rim in enumerate(bodies.rims)]
    none = np.zeros(3)
    for body, rim in enumerate(rims):
        for k in np.flatnonzero((sheet.kind[:, 0] == PLANE) & (sheet.kind[:, 2] == 0)):
            gap = product(rim, sheet.number[k, :3]) - sheet.number[k, SIZE]
            deep = int(np.argmin(gap))
            if gap[deep] < 0.0:
                velocity = sheet.number[k, SPEED : SPEED + 3]
                yield Contact(body, NOTHING, rim[deep], sheet.number[k, :3], -float(gap[deep]), velocity)
        for shape, its in zip(bodies.obstacles, bodies.obstacle_rims, strict=True):
            yield from _between(body, NOTHING, rim, (shape, None), none)
            yield from _flipped(_inside(bodies, body, pose, its), body)
        for other in range(body):
            if _close(bodies, pose, body, other):
                yield from _between(body, other, rim, (bodies.shapes[other], pose[:, other : other + 1]), none)
                yield from _between(other, body, rims[other], (bodies.shapes[body], pose[:, body : body + 1]), none)


def _between(
    body: int, other: int, rim: Array, solid: tuple[Shape, Array | None], velocity: Array
) -> Iterator[Contact]:
    """The deepest of a body's points inside a solid."""
    shape, pose = solid
    d = len(shape.middle())
    turn = np.eye(3) if pose is None else rotations(pose)[0]
    own = rim if pose is None else product(rim - pose[:3, 0], turn)
    gap, normal = shape.nearest(own[:, :d])
    deep = int(np.argmin(gap))
    if gap[deep] < 0.0:
        out = product(turn[:, :d], normal[deep])
        yield Contact(body, other, rim[deep], out, -float(gap[deep]), velocity)


def _inside(bodies: Bodies, body: int, pose: Array, rim: Array) -> Iterator[Contact]:
    yield from _between(NOTHING, body, rim, (bodies.shapes[body], pose[:, body : body + 1]), np.zeros(3))


def _flipped(found: Iterator[Contact], body: int) -> Iterator[Contact]:
    for contact in found:
        yield contact._replace(body=body, other=NOTHING, normal=-contact.normal)


def _close(bodies: Bodies, pose: Array, one: int, other: int) -> bool:
    reach = sum(np.sqrt((bodies.rims[body] ** 2).sum(axis=1).max()) for body in (one, other))
    return bool(length(pose[:3, one] - pose[:3, other]) < reach)


def _separate(bodies: Bodies, pose: Array, contact: Contact) -> None:
    if contact.other == NOTHING:
        pose[:3, contact.body] += contact.depth * contact.normal
        return
    mine, theirs = bodies.mass[contact.body], bodies.mass[contact.other]
    pose[:3, contact.body] += contact.depth * theirs / (mine + theirs) * contact.normal
    pose[:3, contact.other] -= contact.depth * mine / (mine + theirs) * contact.normal


def _strike(bodies: Bodies, state: tuple[Array, Array], contact: Contact, calm: float) -> Array:
    """The impulse on the body."""
    pose, motion = state
    pair = [contact.body] if contact.other == NOTHING else [contact.body, contact.other]
    arms = [contact.point - pose[:3, body] for body in pair]
    speeds = [motion[:3, body] + np.cross(motion[3:, body], arm) for body, arm in zip(pair, arms, strict=True)]
    approach = speeds[0] - (contact.velocity if contact.other == NOTHING else speeds[1])
    normal_speed = dot(approach, contact.normal)
    if normal_speed >= 0.0:
        return np.zeros(3)
    give_way = sum(_compliance(bodies, body, pose, arm) for body, arm in zip(pair, arms, strict=True))
    bounce = min(bodies.restitution[body] for body in pair) if normal_speed < -calm else 0.0
    # Sticking, unless friction is too weak for it: then the tangential part is cut to Coulomb's cone.
    wanted = solve(give_way, -approach - bounce * normal_speed * contact.normal)
    along = dot(wanted, contact.normal)
    across = wanted - along * contact.normal
    limit = min(bodies.friction[body] for body in pair) * along
    size = length(across)
    if size > limit or along <= 0.0:
        slip = across / size if size > 0.0 else across
        way = contact.normal + min(bodies.friction[body] for body in pair) * slip
        along = -(1.0 + bounce) * normal_speed / dot(contact.normal, product(give_way, way))
        wanted = along * way
    give(bodies, pair[0], state, (wanted, arms[0]))
    if len(pair) == 2:
        give(bodies, pair[1], state, (-wanted, arms[1]))
    return wanted


def _compliance(bodies: Bodies, body: int, pose: Array, arm: Array) -> Array:
    """(3, 3) the velocity at the arm's end of a unit impulse there."""
    cross = np.cross(np.eye(3), arm)
    inverse = inverse_inertia_of(bodies, body, pose)
    found: Array = np.eye(3) / bodies.mass[body] + product(product(cross, inverse), cross.T)
    return found
