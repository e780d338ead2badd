"""Jacobian of one contact within a stage: its response to changes of its internal variables and of the positions.

Within the plane of n and the surface's shear direction a contact has four variables: q, the rotation of n, and the
normal and shear components of X_ij. Forces are on sphere i, from i to j: tension is positive here.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ecume._jit import compiled_inside
from ecume.models.soft.contacts.contact import Film

Vector = tuple[float, float, float]

ROUNDING = 2e-15
"""What rounding leaves of a force, over stiffness times coordinates."""
STILL = 1e-14
"""A shear below this part of the centers' distance has no direction."""


@compiled_inside
def rates(film: Film) -> tuple[float, float]:
    """D ln(gap)/dt and the rate at which n turns towards the shear: the film flows under the surfaces' force."""
    sheared = film.surface.tangential * film.shear * film.held
    opening = film.draw.tension / (film.faded * film.resistance.squeeze * film.gap)
    return opening, sheared / (film.faded * film.resistance.shear * film.reach)


@compiled_inside
def tangent(film: Film, dq: float, turn: float, dpull: float, dshear: float) -> tuple[float, float, float, float]:
    """The Jacobian of a contact's four variables: both rates, and the force along n and along the surface.

    A rotation of n exchanges normal and shear components.
    """
    surface, resistance = film.surface, film.resistance
    opening, sliding = rates(film)
    stretch = dpull + film.shear * turn - film.gap * dq
    shear = dshear - film.pull * turn
    size = surface.size_by_gap * dq + surface.size_by_stretch * stretch
    firmer = surface.normal_by_gap * dq + surface.normal_by_stretch * stretch + surface.normal_by_shear * shear
    stiffer = surface.tangential_by_gap * dq + surface.tangential_by_stretch * stretch
    stiffer += surface.tangential_by_shear * shear
    normal = surface.normal * (stretch + film.stretch * firmer)
    along = surface.tangential * (shear + film.shear * stiffer)
    drawn = film.draw.by_tension * (normal + film.remote_slope * film.gap * dq) + film.draw.by_size * size
    d_opening = drawn / (film.faded * resistance.squeeze * film.gap)
    thicker = film.fade_slope * dq
    d_opening -= opening * (thicker + (resistance.squeeze_by_gap + 1.0) * dq + resistance.squeeze_by_size * size)
    limit = film.limit_by_normal * normal + film.limit_by_gap * dq
    borne = film.slide_by_pull * along + film.slide_by_limit * limit
    d_sliding = borne * (1.0 - resistance.shear_by_force) / (film.faded * resistance.shear * film.reach)
    thicker += (resistance.shear_by_gap + film.gap / film.reach) * dq + resistance.shear_by_size * size
    thicker -= resistance.shear_by_load * normal
    d_sliding -= sliding * thicker
    pulled = normal - surface.tangential * film.shear * turn
    sheared = along + surface.normal * film.stretch * turn
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
def shear_direction(x: float, y: float, z: float, n: Vector, flat: bool) -> Vector:
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


class Frame(NamedTuple):
    """Three unit vectors: the normal, along the shear, and across both."""

    n: Vector
    t: Vector
    s: Vector


@compiled_inside
def frame_of(x: Vector, n: Vector, flat: bool) -> Frame:
    """The frame of a contact whose centers are x apart."""
    t = shear_direction(x[0], x[1], x[2], n, flat)
    return Frame(n, t, (n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2], n[0] * t[1] - n[1] * t[0]))


@compiled_inside
def dot(a: Vector, b: Vector) -> float:
    """The scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


class Start(NamedTuple):
    """The state of a contact at the start of its stage."""

    span: float
    """s: treated implicitly"""
    log_gap: float
    """of the start, less that of now"""
    lean: float
    along: float
    across: float
    """the start's direction in the frame of now"""


class Link(NamedTuple):
    """The linear response of a contact in its frame: along the normal (n), the shear (t), and across (s)."""

    force_n: float
    force_t: float
    more_n: float
    more_t: float
    more_s: float
    """what solving the contact adds to the force"""
    nn: float
    nt: float
    tn: float
    tt: float
    ss: float
    """stiffness: force along the first over displacement along the second"""
    dq: float
    turn_t: float
    turn_s: float
    """what solving the contact adds to ln(gap) and direction"""
    q_n: float
    q_t: float
    t_n: float
    t_t: float
    s_s: float
    """what a displacement adds"""
    opening: float
    sliding: float
    """rates of ln(gap) and direction (1/s)"""


@compiled_inside
def linked(film: Film, start: Start) -> Link:
    """Linearize a contact over a span of time that its stage treats implicitly."""
    span, lean = start.span, start.lean
    opening, sliding = rates(film)
    dq, turn = solved(film, span, lean, start.log_gap + span * opening, start.along + span * sliding)
    _, _, more_n, more_t = tangent(film, dq, turn, 0.0, 0.0)
    # Columns: a unit pull, and a unit shear.
    by_pull, by_shear = tangent(film, 0.0, 0.0, 1.0, 0.0), tangent(film, 0.0, 0.0, 0.0, 1.0)
    q_n, t_n = solved(film, span, lean, span * by_pull[0], span * by_pull[1])
    q_t, t_t = solved(film, span, lean, span * by_shear[0], span * by_shear[1])
    _, _, nn, tn = tangent(film, q_n, t_n, 1.0, 0.0)
    _, _, nt, tt = tangent(film, q_t, t_t, 0.0, 1.0)
    # Across the plane of n and shear only the turn counts.
    normal_stiffness, tangential_stiffness = film.surface.normal, film.surface.tangential
    relax = span * film.held * tangential_stiffness / (film.faded * film.resistance.shear * film.reach)
    s_s = relax / (lean + relax * film.pull)
    turn_s = start.across / (lean + relax * film.pull)
    normal = normal_stiffness * film.stretch
    ss = normal * s_s + tangential_stiffness * (1.0 - film.pull * s_s)
    more_s = (normal - tangential_stiffness * film.pull) * turn_s
    along = tangential_stiffness * film.shear
    return Link(
        normal, along, more_n, more_t, more_s, nn, nt, tn, tt, ss, dq, turn, turn_s, q_n, q_t, t_n, t_t, s_s,
        opening, sliding,
    )  # fmt: skip
