"""The contacts: film and surface in series, and what they answer to a displacement of the spheres within one step.

A contact's own state is the logarithm q of its gap and the direction n of its gap vector G = (R_i + R_j + h) n. Where
the spheres are says how far its surfaces are deflected: delta = X_j - X_i - G. The force of the deflection drives
the film, dG/dt = Z^-1 F. Over a stage of an implicit step, (q, n) = start + dt f(q, n, X) is solved contact by contact,
linearized, and put into the forces: what is left is a linear system in the displacements of the spheres alone.

In the plane of n and the surface's shear direction a contact has four numbers: q, the turn of n, and the pull and shear
of X_ij along them. Forces are on sphere i, from i to j: tension is positive here.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import admit, compiled, compiled_inside
from ecume.engine.cells import Integers
from ecume.laws import elasticity, lubrication, remote
from ecume.models.soft.parameters import Contacts, Drive
from ecume.units import Array

admit(elasticity, lubrication, remote)

FAINTEST = 1e-3
"""Of a film's friction where it has faded: the surfaces then relax at once, and nothing is left to jump."""
STILL = 1e-14
"""A shear below this part of the centers' distance has no direction."""


class Pairs(NamedTuple):
    """The contacts there are; all arrays of their number."""

    first: Integers
    second: Integers
    image: Array
    """(C, 3) how many boxes the second is away, in the copy that is met"""
    offset: Array
    """(C, 3) m: what this adds to its place, at present"""
    radius_sum: Array
    reduced_radius: Array
    modulus: Array


class Films(NamedTuple):
    """Where the contacts are in a stage, and where its start lies."""

    log_gap: Array
    direction: Array
    """(C, 3)"""
    log_gap_start: Array
    direction_start: Array


class Answers(NamedTuple):
    """What contacts answer in a stage, linearized."""

    force: Array
    """(C, 3) N on the first, as it is"""
    correction: Array
    """(C, 3) N: what solving the contact adds"""
    stiffness: Array
    """(C, 3, 3) N/m: force over the displacement of the second against the first"""
    shift: Array
    """(C, 4) what solving the contact adds to ln(gap) and direction"""
    response: Array
    """(C, 4, 3) what a displacement adds"""
    slope: Array
    """(C, 4) rates of ln(gap) and direction (1/s)"""


class Film(NamedTuple):
    """One contact as numbers."""

    gap: float
    reach: float
    """length of the gap vector"""
    pull: float
    """X_ij along n"""
    shear: float
    """and along the surface"""
    stretch: float
    """normal deflection"""
    normal_stiffness: float
    tangential_stiffness: float
    size_by_gap: float
    """d ln a / d q at a deflection that is held"""
    size_by_stretch: float
    """d ln a / d delta_n"""
    squeeze_mobility: float
    shear_mobility: float
    fade_slope: float
    """d ln(friction) / d q by fading"""
    remote_force: float
    remote_slope: float


@compiled_inside
def fading(gap: float, contacts: Contacts) -> tuple[float, float]:
    """What part of its friction a film still has, and the slope of its logarithm over ln(gap)."""
    if gap <= contacts.fade_from:
        return 1.0, 0.0
    u = min((gap - contacts.fade_from) / (contacts.fade_to - contacts.fade_from), 1.0)
    part = FAINTEST + (1.0 - FAINTEST) * (1.0 - u) ** 2 * (1.0 + 2.0 * u)
    slope = -(1.0 - FAINTEST) * 6.0 * u * (1.0 - u) / (contacts.fade_to - contacts.fade_from)
    return part, slope * gap / part


@compiled_inside
def remote_answer(gap: float, reduced_radius: float, contacts: Contacts) -> tuple[float, float]:
    """The remote force, positive repels, and its slope."""
    if contacts.remote == 1:
        given = (contacts.steric_strength, contacts.steric_length)
        return remote.steric_force(gap, *given), remote.steric_slope(gap, *given)
    if contacts.remote == 2:
        layer = (reduced_radius, contacts.hamaker, contacts.layer_strength, contacts.debye_length)
        return remote.dlvo_force(gap, *layer), remote.dlvo_slope(gap, *layer)
    return 0.0, 0.0


@compiled_inside
def film_of(contacts: Contacts, body: tuple[float, float, float], log_gap: float, pull: float, shear: float) -> Film:
    """A contact's numbers; `body` is the sum of radii, the reduced radius and the modulus of the pair."""
    radius_sum, reduced_radius, modulus = body
    gap = math.exp(log_gap)
    stretch = pull - radius_sum - gap
    # The kink of |delta| at zero is rounded off: a step across it would not converge.
    magnitude = math.sqrt(stretch * stretch + contacts.rounding * contacts.rounding)
    size = elasticity.contact_size(reduced_radius, gap, magnitude, contacts.gap_weight, contacts.deflection_weight)
    part, fade_slope = fading(gap, contacts)
    squeeze = part * lubrication.squeeze_friction(size, gap, contacts.viscosity, contacts.squeeze)
    sliding = part * lubrication.shear_friction(size, gap, contacts.viscosity, contacts.shear)
    remote_force, remote_slope = remote_answer(gap, reduced_radius, contacts)
    per_size = reduced_radius / (size * size)
    return Film(
        gap=gap,
        reach=radius_sum + gap,
        pull=pull,
        shear=shear,
        stretch=stretch,
        normal_stiffness=elasticity.surface_stiffness(size, modulus, contacts.normal),
        tangential_stiffness=elasticity.surface_stiffness(size, modulus, contacts.tangential),
        size_by_gap=per_size * contacts.gap_weight * gap,
        size_by_stretch=per_size * contacts.deflection_weight * stretch / magnitude,
        squeeze_mobility=1.0 / squeeze,
        shear_mobility=1.0 / sliding,
        fade_slope=fade_slope,
        remote_force=remote_force,
        remote_slope=remote_slope,
    )


@compiled_inside
def rates(film: Film) -> tuple[float, float]:
    """D ln(gap)/dt and the rate at which n turns towards the shear: the film flows under the surfaces' force."""
    opening = film.squeeze_mobility * (film.normal_stiffness * film.stretch + film.remote_force)
    sliding = film.shear_mobility * film.tangential_stiffness * film.shear
    return opening / film.gap, sliding / film.reach


@compiled_inside
def tangent(film: Film, dq: float, turn: float, dpull: float, dshear: float) -> tuple[float, float, float, float]:
    """What small changes of a contact's four numbers change: both rates, and the force along n and along the surface.

    A turn of n moves the shear into the pull and the pull into the shear.
    """
    opening, sliding = rates(film)
    stretch = dpull + film.shear * turn - film.gap * dq
    shear = dshear - film.pull * turn
    size = film.size_by_gap * dq + film.size_by_stretch * stretch
    normal = film.normal_stiffness * (stretch + film.stretch * size)
    along = film.tangential_stiffness * (shear + film.shear * size)
    per_gap = film.squeeze_mobility / film.gap
    d_opening = per_gap * (normal + film.remote_slope * film.gap * dq)
    d_opening += opening * ((2.0 - film.fade_slope) * dq - 4.0 * size)
    per_reach = film.shear_mobility / film.reach
    d_sliding = per_reach * along + sliding * ((1.0 - film.fade_slope - film.gap / film.reach) * dq - 2.0 * size)
    pulled = normal - film.tangential_stiffness * film.shear * turn
    sheared = along + film.normal_stiffness * film.stretch * turn
    return d_opening, d_sliding, pulled, sheared


@compiled_inside
def solved(film: Film, span: float, lean: float, opening: float, sliding: float) -> tuple[float, float]:
    """The (dq, turn) that answer what is missing in the contact's two equations, over a span dt of the stage."""
    opening_q, sliding_q, _, _ = tangent(film, 1.0, 0.0, 0.0, 0.0)
    opening_t, sliding_t, _, _ = tangent(film, 0.0, 1.0, 0.0, 0.0)
    qq, qt = 1.0 - span * opening_q, -span * opening_t
    tq, tt = -span * sliding_q, lean - span * sliding_t
    determinant = qq * tt - qt * tq
    return (tt * opening - qt * sliding) / determinant, (qq * sliding - tq * opening) / determinant


@compiled_inside
def shear_direction(
    x: float, y: float, z: float, n: tuple[float, float, float], flat: bool
) -> tuple[float, float, float]:
    """A unit vector along the surface in which the centers are sheared; in a layer, n turned left."""
    if flat:
        return -n[1], n[0], 0.0
    length = math.sqrt(x * x + y * y + z * z)
    still = STILL * length
    # Twice: what is left of nearly parallel vectors after the first time is not perpendicular to the last digits.
    for _ in range(2):
        along = x * n[0] + y * n[1] + z * n[2]
        x, y, z = x - along * n[0], y - along * n[1], z - along * n[2]
        length = math.sqrt(x * x + y * y + z * z)
        if length > still:
            x, y, z, still = x / length, y / length, z / length, 0.5
    if still == 0.5:
        return x, y, z
    if abs(n[0]) < 0.6:
        scale = math.sqrt(n[1] * n[1] + n[2] * n[2])
        return 0.0, n[2] / scale, -n[1] / scale
    scale = math.sqrt(n[0] * n[0] + n[2] * n[2])
    return -n[2] / scale, 0.0, n[0] / scale


@compiled
def place_images(pairs: Pairs, box: Array, drive: Drive) -> None:
    """Where copies of the box are now."""
    image, offset = pairs.image, pairs.offset
    for c in range(len(image)):
        for k in range(3):
            offset[c, k] = image[c, k] * box[k] * drive.scale
        offset[c, 0] += drive.strain * offset[c, 1]


@compiled
def answer(contacts: Contacts, pairs: Pairs, films: Films, position: Array, span: float, answers: Answers) -> None:
    """Linearize every contact over a span of time that its stage treats implicitly."""
    first, second, offset = pairs.first, pairs.second, pairs.offset
    radius_sum, reduced_radius, modulus = pairs.radius_sum, pairs.reduced_radius, pairs.modulus
    log_gap, direction = films.log_gap, films.direction
    log_gap_start, direction_start = films.log_gap_start, films.direction_start
    force, correction, stiffness = answers.force, answers.correction, answers.stiffness
    shift, response, slope = answers.shift, answers.response, answers.slope
    dimensions = position.shape[1]
    flat = dimensions == 2
    for c in range(len(first)):
        i, j = first[c], second[c]
        x = position[j, 0] - position[i, 0] + offset[c, 0]
        y = position[j, 1] - position[i, 1] + offset[c, 1]
        z = 0.0 if flat else position[j, 2] - position[i, 2] + offset[c, 2]
        n = (direction[c, 0], direction[c, 1], direction[c, 2])
        t = shear_direction(x, y, z, n, flat)
        s = (n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2], n[0] * t[1] - n[1] * t[0])
        pull = x * n[0] + y * n[1] + z * n[2]
        shear = x * t[0] + y * t[1] + z * t[2]
        film = film_of(contacts, (radius_sum[c], reduced_radius[c], modulus[c]), log_gap[c], pull, shear)
        opening, sliding = rates(film)
        b = (direction_start[c, 0], direction_start[c, 1], direction_start[c, 2])
        lean = n[0] * b[0] + n[1] * b[1] + n[2] * b[2]
        aside = t[0] * b[0] + t[1] * b[1] + t[2] * b[2] + span * sliding
        across = s[0] * b[0] + s[1] * b[1] + s[2] * b[2]
        dq, turn = solved(film, span, lean, log_gap_start[c] + span * opening - log_gap[c], aside)
        _, _, more_n, more_t = tangent(film, dq, turn, 0.0, 0.0)
        # Columns: a unit pull, and a unit shear.
        by_pull, by_shear = tangent(film, 0.0, 0.0, 1.0, 0.0), tangent(film, 0.0, 0.0, 0.0, 1.0)
        q_n, t_n = solved(film, span, lean, span * by_pull[0], span * by_pull[1])
        q_t, t_t = solved(film, span, lean, span * by_shear[0], span * by_shear[1])
        _, _, nn, tn = tangent(film, q_n, t_n, 1.0, 0.0)
        _, _, nt, tt = tangent(film, q_t, t_t, 0.0, 1.0)
        # Across the plane of n and shear only the turn counts.
        relax = span * film.shear_mobility * film.tangential_stiffness / film.reach
        s_s = relax / (lean + relax * pull)
        turn_s = across / (lean + relax * pull)
        normal = film.normal_stiffness * film.stretch
        ss = normal * s_s + film.tangential_stiffness * (1.0 - pull * s_s)
        more_s = (normal - film.tangential_stiffness * pull) * turn_s
        along = film.tangential_stiffness * shear
        shift[c, 0] = dq
        slope[c, 0] = opening
        for k in range(3):
            force[c, k] = normal * n[k] + along * t[k]
            correction[c, k] = more_n * n[k] + more_t * t[k] + more_s * s[k]
            shift[c, 1 + k] = turn * t[k] + turn_s * s[k]
            slope[c, 1 + k] = sliding * t[k]
            response[c, 0, k] = q_n * n[k] + q_t * t[k]
            for m in range(3):
                response[c, 1 + k, m] = t[k] * (t_n * n[m] + t_t * t[m]) + s_s * s[k] * s[m]
                stiffness[c, k, m] = (nn * n[k] + tn * t[k]) * n[m] + (nt * n[k] + tt * t[k]) * t[m] + ss * s[k] * s[m]


def make_answers(count: int) -> Answers:
    """Room for the answers of so many contacts."""
    shapes = ((3,), (3,), (3, 3), (4,), (4, 3), (4,))
    return Answers(*(np.zeros((count, *shape)) for shape in shapes))


def make_films(count: int) -> Films:
    """Room for the places of so many contacts."""
    return Films(np.zeros(count), np.zeros((count, 3)), np.zeros(count), np.zeros((count, 3)))


@compiled
def stored_energy(contacts: Contacts, pairs: Pairs, films: Films, position: Array) -> float:
    """What the surfaces' deflections hold (J): exact along the normal; along the surface at its present stiffness."""
    total = 0.0
    for c in range(len(pairs.first)):
        i, j = pairs.first[c], pairs.second[c]
        pull, square = 0.0, 0.0
        for k in range(position.shape[1]):
            between = position[j, k] - position[i, k] + pairs.offset[c, k]
            pull += between * films.direction[c, k]
            square += between * between
        body = (pairs.radius_sum[c], pairs.reduced_radius[c], pairs.modulus[c])
        film = film_of(contacts, body, films.log_gap[c], pull, 0.0)
        ratio = contacts.deflection_weight * abs(film.stretch) / (contacts.gap_weight * film.gap)
        stiffness = film.normal_stiffness / math.sqrt(1.0 + ratio)
        total += elasticity.bent_energy(film.stretch, stiffness, ratio)
        total += 0.5 * film.tangential_stiffness * max(square - pull * pull, 0.0)
    return total
