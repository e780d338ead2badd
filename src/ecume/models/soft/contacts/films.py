"""The linear response of all contacts to displacements of the spheres within one step.

Over a stage of an implicit step, (q, n) = start + dt f(q, n, X) is linearized and solved for each contact separately
(`contact`). Substituting the solutions into the forces leaves a linear system in the displacements of the spheres
alone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside, prange, shared
from ecume.engine.cells import Integers
from ecume.laws.surfaces import Body
from ecume.models.soft.contacts.contact import (
    Frame,
    LinearContact,
    Start,
    Vector,
    contact_energy,
    dot,
    film_of,
    frame_of,
    linearized,
    square_across,
)
from ecume.models.soft.contacts.user_forces import Across, set_user_forces
from ecume.models.soft.parameters import Contacts
from ecume.units import Array


class Pairs(NamedTuple):
    """The constants of all contacts, and the rotation of their pairs; each array has one row per contact."""

    first: Integers
    second: Integers
    image: Array
    """(C, 3) the periodic image of the second sphere, in boxes"""
    offset: Array
    """(C, 3) m: the displacement of that image at present"""
    turn: Array
    """(C, 3) rad: the rotation of the pair by spins since the start of the step; (0, 3) where spheres do not spin"""
    radius_sum: Array
    reduced_radius: Array
    modulus: Array
    laws: Across | tuple[()]
    """the user's laws; empty without any, so that their code is not compiled"""
    across: Array
    """(C, 2) the force of the user's law of each contact (N), and its slope over the gap (N/m)"""


class Films(NamedTuple):
    """The state of all contacts in a stage, and at its start."""

    log_gap: Array
    direction: Array
    """(C, 3)"""
    log_gap_start: Array
    direction_start: Array


class ContactResponses(NamedTuple):
    """The linearized response of each contact in a stage."""

    force: Array
    """(C, 3) N on the first sphere, before the solution"""
    correction: Array
    """(C, 3) N: the change of this force by the solution of the contact's equations"""
    stiffness: Array
    """(C, 3, 3) N/m: force over the displacement of the second against the first"""
    shift: Array
    """(C, 4) the change of ln(gap) and direction by this solution"""
    response: Array
    """(C, 4, 3) their change per displacement of the second sphere"""
    slope: Array
    """(C, 4) rates of ln(gap) and direction (1/s)"""


def count_pairs(contacts: Contacts, pairs: Pairs, *_: object) -> int:
    """The number of contacts, for the choice between serial and threaded loops."""
    return len(pairs.first)


@shared(count_pairs)
def contact_response(
    contacts: Contacts, pairs: Pairs, films: Films, position: Array, span: float, responses: ContactResponses
) -> None:
    """Linearize each contact over the implicit time span of its stage.

    Each contact is solved in a frame that rotates with its pair; the result is in the fixed frame.
    """
    first, second, offset = pairs.first, pairs.second, pairs.offset
    radius_sum, reduced_radius, modulus = pairs.radius_sum, pairs.reduced_radius, pairs.modulus
    log_gap, direction = films.log_gap, films.direction
    log_gap_start, direction_start = films.log_gap_start, films.direction_start
    force, correction, stiffness = responses.force, responses.correction, responses.stiffness
    shift, response, slope = responses.shift, responses.response, responses.slope
    flat, spinning = position.shape[1] == 2, len(pairs.turn) > 0
    turn, across = pairs.turn, pairs.across
    set_user_forces(pairs.laws, log_gap, across)
    for c in prange(len(first)):
        x = center_distance(position, offset, first[c], second[c], c)
        if spinning:
            x = turned(x, (-turn[c, 0], -turn[c, 1], -turn[c, 2]))
        n = (direction[c, 0], direction[c, 1], direction[c, 2])
        frame = frame_of(x, n, flat)
        body = Body(radius_sum[c], reduced_radius[c], modulus[c], across[c, 0], across[c, 1])
        film = film_of(contacts, body, log_gap[c], dot(x, n), dot(x, frame.t))
        b = (direction_start[c, 0], direction_start[c, 1], direction_start[c, 2])
        begin = Start(span, log_gap_start[c] - log_gap[c], dot(n, b), dot(frame.t, b), dot(frame.s, b))
        linear = linearized(film, begin)
        seen = frame
        if spinning:
            angle = (turn[c, 0], turn[c, 1], turn[c, 2])
            seen = Frame(turned(frame.n, angle), turned(frame.t, angle), turned(frame.s, angle))
        store_forces(linear, seen, c, (force, correction, stiffness))
        store_motion(linear, (frame, seen), c, (shift, response, slope))


@compiled_inside
def center_distance(position: Array, offset: Array, i: int, j: int, c: int) -> Vector:
    """The vector from the center of one sphere to the periodic image of the other that it touches; in 2D its third
    component is 0.
    """
    x = position[j, 0] - position[i, 0] + offset[c, 0]
    y = position[j, 1] - position[i, 1] + offset[c, 1]
    z = 0.0 if position.shape[1] == 2 else position[j, 2] - position[i, 2] + offset[c, 2]
    return x, y, z


@compiled_inside
def turned(x: Vector, angle: Vector) -> Vector:
    """A vector rotated about an axis by an angle: the length of the axis vector (Rodrigues' formula)."""
    square = dot(angle, angle)
    if square == 0.0:
        return x
    size, along = math.sqrt(square), dot(angle, x)
    straight, around = math.cos(size), math.sin(size) / size
    lift = along * 0.5 * (math.sin(0.5 * size) / (0.5 * size)) ** 2
    return (
        straight * x[0] + around * (angle[1] * x[2] - angle[2] * x[1]) + lift * angle[0],
        straight * x[1] + around * (angle[2] * x[0] - angle[0] * x[2]) + lift * angle[1],
        straight * x[2] + around * (angle[0] * x[1] - angle[1] * x[0]) + lift * angle[2],
    )


@compiled_inside
def store_forces(linear: LinearContact, frame: Frame, c: int, to: tuple[Array, Array, Array]) -> None:
    """Store the force, correction and stiffness of a contact in the fixed frame."""
    force, correction, stiffness = to
    n, t, s = frame
    for k in range(3):
        force[c, k] = linear.force_n * n[k] + linear.force_t * t[k]
        correction[c, k] = linear.correction_n * n[k] + linear.correction_t * t[k] + linear.correction_s * s[k]
        by_pull, by_shear = linear.nn * n[k] + linear.tn * t[k], linear.nt * n[k] + linear.tt * t[k]
        for m in range(3):
            stiffness[c, k, m] = by_pull * n[m] + by_shear * t[m] + linear.ss * s[k] * s[m]


@compiled_inside
def store_motion(linear: LinearContact, frames: tuple[Frame, Frame], c: int, to: tuple[Array, Array, Array]) -> None:
    """Store the changes and rates of ln(gap) and of the direction of a contact, in the frame that rotates with the
    pair.
    """
    shift, response, slope = to
    _, t, s = frames[0]
    n_seen, t_seen, s_seen = frames[1]
    shift[c, 0], slope[c, 0] = linear.dq, linear.opening
    for k in range(3):
        shift[c, 1 + k] = linear.turn_t * t[k] + linear.turn_s * s[k]
        slope[c, 1 + k] = linear.sliding * t[k]
        response[c, 0, k] = linear.q_n * n_seen[k] + linear.q_t * t_seen[k]
        for m in range(3):
            turns = linear.t_n * n_seen[m] + linear.t_t * t_seen[m]
            response[c, 1 + k, m] = t[k] * turns + linear.s_s * s[k] * s_seen[m]


def make_responses(count: int) -> ContactResponses:
    """Arrays of zeros for the responses of `count` contacts."""
    shapes = ((3,), (3,), (3, 3), (4,), (4, 3), (4,))
    return ContactResponses(*(np.zeros((count, *shape)) for shape in shapes))


def make_films(count: int) -> Films:
    """Arrays of zeros for the states of `count` contacts."""
    return Films(np.zeros(count), np.zeros((count, 3)), np.zeros(count), np.zeros((count, 3)))


@compiled
def stored_energy(contacts: Contacts, pairs: Pairs, films: Films, position: Array) -> float:
    """The elastic energy of the deflections (J)."""
    total = 0.0
    for c in range(len(pairs.first)):
        x = center_distance(position, pairs.offset, pairs.first[c], pairs.second[c], c)
        n = (films.direction[c, 0], films.direction[c, 1], films.direction[c, 2])
        body = Body(pairs.radius_sum[c], pairs.reduced_radius[c], pairs.modulus[c], 0.0, 0.0)
        gap = math.exp(films.log_gap[c])
        total += contact_energy(contacts, body, gap, dot(x, n) - body.radius_sum - gap, square_across(x, n))
    return total
