"""One contact as numbers: film and surface in series, their rates, and how they answer small changes.

A contact's own state is the logarithm q of its gap and the direction n of its gap vector G = (R_i + R_j + h) n. Where
the spheres are says how far its surfaces are deflected: delta = X_j - X_i - G. The force of the deflection drives
the film, dG/dt = Z^-1 F.

In the plane of n and the surface's shear direction a contact has four numbers: q, the turn of n, and the pull and shear
of X_ij along them. Forces are on sphere i, from i to j: tension is positive here.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ecume._jit import admit, compiled_inside
from ecume.laws import elasticity, lubrication, remote
from ecume.models.soft.parameters import Contacts

admit(elasticity, lubrication, remote)

Vector = tuple[float, float, float]

FAINTEST = 1e-3
"""Of a film's friction where it has faded: the surfaces then relax at once, and nothing is left to jump."""
STILL = 1e-14
"""A shear below this part of the centers' distance has no direction."""


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
    """Where a contact's stage starts from."""

    span: float
    """s: treated implicitly"""
    log_gap: float
    """of the start, less that of now"""
    lean: float
    along: float
    across: float
    """the start's direction in the frame of now"""


class Link(NamedTuple):
    """What a contact answers, in its frame: along the normal (n), the shear (t), and across (s)."""

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
    relax = span * film.shear_mobility * film.tangential_stiffness / film.reach
    s_s = relax / (lean + relax * film.pull)
    turn_s = start.across / (lean + relax * film.pull)
    normal = film.normal_stiffness * film.stretch
    ss = normal * s_s + film.tangential_stiffness * (1.0 - film.pull * s_s)
    more_s = (normal - film.tangential_stiffness * film.pull) * turn_s
    along = film.tangential_stiffness * film.shear
    return Link(
        normal, along, more_n, more_t, more_s, nn, nt, tn, tt, ss, dq, turn, turn_s, q_n, q_t, t_n, t_t, s_s,
        opening, sliding,
    )  # fmt: skip
