"""One contact: film and surface in series, and its linear response within a stage.

The state of a contact is the logarithm q of its gap and the direction n of its gap vector G = (R_i + R_j + h) n. The
positions of the spheres determine the deflection of its surfaces, delta = X_j - X_i - G. The force of the deflection
drives the film, dG/dt = Z^-1 F.

The Jacobian is the response to changes of these variables and of the positions. In the coordinates of n and the shear
direction a contact has four variables: q, the rotation of n, and the normal
and shear components of X_ij. Forces are on sphere i, from i to j: tension is positive here.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ecume._jit import admit, compiled_inside, selection
from ecume.laws import friction, interfaces, long_range, soft_contacts, soft_pair, surfaces
from ecume.laws.friction import FRICTIONS
from ecume.laws.interfaces import INTERFACES, Resistance
from ecume.laws.long_range import REMOTE
from ecume.laws.soft_contacts import TANGENTIAL, TENSION, Bending, Draw, Widening
from ecume.laws.soft_pair import Prefactors
from ecume.laws.surfaces import SURFACES, Body, Surface
from ecume.models.law_codes import codes
from ecume.models.soft.parameters import Contacts

admit(soft_contacts, soft_pair, long_range, surfaces, interfaces, friction)

FAINTEST = 1e-3
"""The fraction of its friction that a faded film keeps. Its surfaces then relax at once, so that the force does not
jump.
"""

OF_SURFACE = ("body", "gap", "stretch", "prefactors", "contacts")
OF_GAP = ("gap", "reduced_radius", "contacts")
surface_by = selection("surface_by", codes(SURFACES, lambda row: row.surface), __name__, __file__, OF_SURFACE)
energy_by = selection("energy_by", codes(SURFACES, lambda row: row.energy), __name__, __file__, OF_SURFACE)
gap_energy_by = selection("gap_energy_by", codes(SURFACES, lambda row: row.gap_energy), __name__, __file__, OF_SURFACE)
remote_energy_by = selection("remote_energy_by", codes(REMOTE, lambda row: row.energy), __name__, __file__, OF_GAP)
remote_force_by = selection("remote_force_by", codes(REMOTE, lambda row: row.force), __name__, __file__, OF_GAP)
remote_slope_by = selection("remote_slope_by", codes(REMOTE, lambda row: row.slope), __name__, __file__, OF_GAP)
resistance_by = selection(
    "resistance_by", codes(INTERFACES, lambda row: row), __name__, __file__,
    ("contact_size", "gap", "film_prefactors", "compression", "slip_force", "body", "contacts"),
)  # fmt: skip
rubbing_by = selection(
    "rubbing_by", codes(FRICTIONS, lambda row: row.rubbing), __name__, __file__,
    ("gap", "compression", "pull", "contacts"),
)  # fmt: skip
widening_by = selection(
    "widening_by", codes(TENSION, lambda row: row.widening), __name__, __file__, ("stretch", "contacts")
)
draw_by = selection(
    "draw_by", codes(TENSION, lambda row: row.draw), __name__, __file__, ("tension", "contact_size", "contacts")
)
bending_by = selection(
    "bending_by", codes(TANGENTIAL, lambda row: row.bending), __name__, __file__,
    ("widening", "shear", "ratio", "contacts"),
)  # fmt: skip
sheared_energy_by = selection(
    "sheared_energy_by", codes(TANGENTIAL, lambda row: row.energy), __name__, __file__,
    ("stiffness", "shear_squared", "contacts"),
)  # fmt: skip


class Elastic(NamedTuple):
    """The elastic response of a contact at its total deflection."""

    size: float
    """a, the radius of the contact, which is also that of the film"""
    size_by_gap: float
    """d ln(a) / d ln(gap)"""
    size_by_stretch: float
    """d ln(a) / d delta_n (1/m)"""
    normal: float
    tangential: float
    """force over deflection (N/m)"""
    normal_by_gap: float
    normal_by_stretch: float
    normal_by_shear: float
    tangential_by_gap: float
    tangential_by_stretch: float
    tangential_by_shear: float
    """derivatives of the logarithms of both stiffnesses by ln(gap), delta_n (1/m) and delta_t (1/m)"""


class Film(NamedTuple):
    """All quantities of one contact."""

    gap: float
    reach: float
    """the length of the gap vector"""
    pull: float
    """X_ij along n"""
    shear: float
    """the component of X_ij along the surface"""
    stretch: float
    """normal deflection"""
    surface: Elastic
    resistance: Resistance
    faded: float
    """the fraction of its friction that the film still has"""
    fade_slope: float
    """d ln(friction) / d q by fading"""
    remote_force: float
    remote_slope: float
    draw: Draw
    """the tension that opens the film, and its derivatives"""
    held: float
    """the fraction of the tangential force that the film carries: 1 without contact friction"""
    slide_by_pull: float
    slide_by_limit: float
    """derivatives of the force that the film carries, by the tangential force and by the limit of contact friction"""
    limit_by_normal: float
    limit_by_gap: float
    """derivatives of that limit, by the normal force and by q"""


@compiled_inside
def fading(gap: float, contacts: Contacts) -> tuple[float, float]:
    """The factor by which the friction of a film has faded, and the derivative of its logarithm by ln(gap)."""
    if gap <= contacts.fade_from:
        return 1.0, 0.0
    u = min((gap - contacts.fade_from) / (contacts.fade_to - contacts.fade_from), 1.0)
    part = FAINTEST + (1.0 - FAINTEST) * (1.0 - u) ** 2 * (1.0 + 2.0 * u)
    slope = -(1.0 - FAINTEST) * 6.0 * u * (1.0 - u) / (contacts.fade_to - contacts.fade_from)
    return part, slope * gap / part


@compiled_inside
def remote_force_and_slope(gap: float, reduced_radius: float, contacts: Contacts) -> tuple[float, float]:
    """The long-range force, positive if it repels, and its derivative by the gap."""
    force: float = remote_force_by(gap, reduced_radius, contacts, contacts.remote)
    slope: float = remote_slope_by(gap, reduced_radius, contacts, contacts.remote)
    return force, slope


@compiled_inside
def prefactors_in(contacts: Contacts) -> Prefactors:
    """The six prefactors of film and surface, as the laws take them."""
    return Prefactors(
        contacts.squeeze, contacts.shear, contacts.normal, contacts.tangential, contacts.gap_weight,
        contacts.deflection_weight,
    )  # fmt: skip


@compiled_inside
def surface_of(contacts: Contacts, body: Body, gap: float, stretch: float) -> Surface:
    """The stiffnesses and the size of a contact's surfaces."""
    surface: Surface = surface_by(body, gap, stretch, prefactors_in(contacts), contacts, contacts.surface)
    return surface


@compiled_inside
def bent_by(
    contacts: Contacts, body: Body, gap: float, stretch: float, shear: float
) -> tuple[Widening, Bending, Surface]:
    """The widening and bending of a contact by a deflection, and the stiffnesses and size of its widened surfaces."""
    widening: Widening = widening_by(stretch, contacts, contacts.tension_law)
    surface = surface_of(contacts, body, gap, widening.deflection)
    ratio = surface.tangential / surface.normal
    bending: Bending = bending_by(widening.deflection, shear, ratio, contacts, contacts.tangential_law)
    return widening, bending, surface


@compiled_inside
def elastic_of(contacts: Contacts, body: Body, gap: float, stretch: float, shear: float) -> Elastic:
    """The elastic response of a contact. Both stiffnesses are those at the bending deflection; where tension does not
    widen the contact, the normal stiffness is that without deflection.
    """
    widening, bending, film = bent_by(contacts, body, gap, stretch, shear)
    bent, follows = surface_of(contacts, body, gap, bending.deflection), widening.follows
    by_gap, slope = bent.stiffening * bent.size_by_gap, bent.stiffening * bent.size_by_stretch
    by_stretch, by_shear = slope * bending.by_widening * follows, slope * bending.by_shear
    return Elastic(
        size=film.size,
        size_by_gap=film.size_by_gap,
        size_by_stretch=film.size_by_stretch * follows,
        normal=follows * bent.normal + (1.0 - follows) * film.normal,
        tangential=bent.tangential,
        normal_by_gap=follows * by_gap + (1.0 - follows) * film.stiffening * film.size_by_gap,
        normal_by_stretch=follows * by_stretch,
        normal_by_shear=follows * by_shear,
        tangential_by_gap=by_gap,
        tangential_by_stretch=by_stretch,
        tangential_by_shear=by_shear,
    )


@compiled_inside
def contact_energy(contacts: Contacts, body: Body, gap: float, stretch: float, shear_squared: float) -> float:
    """The elastic energy of a contact (J). With the paper's tangential law, it is that at the present tangential
    stiffness.
    """
    widening, bending, film = bent_by(contacts, body, gap, stretch, math.sqrt(shear_squared))
    beside = 0.5 * film.normal * (stretch * stretch - widening.deflection * widening.deflection)
    sheared: float = sheared_energy_by(film.tangential, shear_squared, contacts, contacts.tangential_law)
    return normal_energy(contacts, body, gap, bending.deflection) + beside + sheared


@compiled_inside
def contact_gap_energy(contacts: Contacts, body: Body, gap: float, stretch: float, shear_squared: float) -> float:
    """The derivative of the elastic energy by ln(gap), at constant deflections (J). With the paper's tangential law,
    the tangential part is omitted.
    """
    widening, bending, film = bent_by(contacts, body, gap, stretch, math.sqrt(shear_squared))
    beside = 0.5 * film.normal * (stretch * stretch - widening.deflection * widening.deflection)
    return gap_energy_of(contacts, body, gap, bending.deflection) + film.stiffening * film.size_by_gap * beside


@compiled_inside
def normal_energy(contacts: Contacts, body: Body, gap: float, stretch: float) -> float:
    """The energy of a normal deflection (J)."""
    energy: float = energy_by(body, gap, stretch, prefactors_in(contacts), contacts, contacts.surface)
    return energy


@compiled_inside
def gap_energy_of(contacts: Contacts, body: Body, gap: float, stretch: float) -> float:
    """The derivative of the normal elastic energy by ln(gap), at a constant deflection (J)."""
    energy: float = gap_energy_by(body, gap, stretch, prefactors_in(contacts), contacts, contacts.surface)
    return energy


@compiled_inside
def film_of(contacts: Contacts, body: Body, log_gap: float, pull: float, shear: float) -> Film:
    """All quantities of a contact, from ln(gap) and the components of X_ij."""
    gap = math.exp(log_gap)
    stretch = pull - body.radius_sum - gap
    surface = elastic_of(contacts, body, gap, stretch, shear)
    faded, fade_slope = fading(gap, contacts)
    built_in, by_gap = remote_force_and_slope(gap, body.reduced_radius, contacts)
    remote_force, remote_slope = built_in + body.force, by_gap + body.slope
    compression, along = -(surface.normal * stretch), surface.tangential * shear
    draw: Draw = draw_by(remote_force - compression, surface.size, contacts, contacts.tension_law)
    tips = rubbing_by(gap, compression, along, contacts, contacts.friction)
    resistance = resistance_by(
        surface.size, gap, (contacts.squeeze, contacts.shear), compression, tips.held * along, body, contacts,
        contacts.interface,
    )  # fmt: skip
    return Film(
        gap=gap,
        reach=body.radius_sum + gap,
        pull=pull,
        shear=shear,
        stretch=stretch,
        surface=surface,
        resistance=resistance,
        faded=faded,
        fade_slope=fade_slope,
        remote_force=remote_force,
        remote_slope=remote_slope,
        draw=draw,
        held=tips.held,
        slide_by_pull=tips.by_pull,
        slide_by_limit=tips.by_limit,
        limit_by_normal=tips.limit_by_normal,
        limit_by_gap=tips.limit_by_gap,
    )


Vector = tuple[float, float, float]

ROUNDING = 2e-15
"""The rounding error of a force, over stiffness times coordinates."""
STILL = 1e-14
"""The smallest shear, over the center distance, whose direction is used."""


@compiled_inside
def rates(film: Film) -> tuple[float, float]:
    """The rate of ln(gap), and the angular velocity of n towards the shear (1/s). The force of the surfaces drives the
    film.
    """
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
def solve_contact(film: Film, span: float, lean: float, opening: float, sliding: float) -> tuple[float, float]:
    """The changes (dq, turn) that solve the linearized equations of a contact with these residuals, for the time span
    of the stage.
    """
    opening_q, sliding_q, _, _ = tangent(film, 1.0, 0.0, 0.0, 0.0)
    opening_t, sliding_t, _, _ = tangent(film, 0.0, 1.0, 0.0, 0.0)
    qq, qt = 1.0 - span * opening_q, -span * opening_t
    tq, tt = -span * sliding_q, lean - span * sliding_t
    determinant = qq * tt - qt * tq
    return (tt * opening - qt * sliding) / determinant, (qq * sliding - tq * opening) / determinant


@compiled_inside
def shear_direction(x: float, y: float, z: float, n: Vector, flat: bool) -> Vector:
    """A unit vector along the surface in the direction of the shear of the centers; in 2D, n rotated by 90 degrees to
    the left.
    """
    if flat:
        return -n[1], n[0], 0.0
    length = math.sqrt(x * x + y * y + z * z)
    still = STILL * length
    # Gram-Schmidt twice: for nearly parallel vectors the result of the first pass is not perpendicular to the last
    # digits.
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
    """Three unit vectors: the normal, the shear direction, and the one perpendicular to both."""

    n: Vector
    t: Vector
    s: Vector


@compiled_inside
def frame_of(x: Vector, n: Vector, flat: bool) -> Frame:
    """The frame of a contact with the center distance x."""
    t = shear_direction(x[0], x[1], x[2], n, flat)
    return Frame(n, t, (n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2], n[0] * t[1] - n[1] * t[0]))


@compiled_inside
def dot(a: Vector, b: Vector) -> float:
    """The scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled_inside
def square_across(x: Vector, n: Vector) -> float:
    """The square of the part of a vector perpendicular to a unit vector, without the cancellation in x^2 - (x.n)^2."""
    along = dot(x, n)
    across = (x[0] - along * n[0], x[1] - along * n[1], x[2] - along * n[2])
    return dot(across, across)


class Start(NamedTuple):
    """The state of a contact at the start of its stage, relative to the current one."""

    span: float
    """s: the implicit time span of the stage"""
    log_gap: float
    """ln(gap) at the start, minus the current value"""
    lean: float
    along: float
    across: float
    """the components of the direction at the start in the current frame"""


class LinearContact(NamedTuple):
    """The linear response of a contact in its frame: along the normal (n), the shear (t), and perpendicular to both
    (s).
    """

    force_n: float
    force_t: float
    correction_n: float
    correction_t: float
    correction_s: float
    """the change of the force by the solution of the contact's equations"""
    nn: float
    nt: float
    tn: float
    tt: float
    ss: float
    """stiffness: force along the first axis over displacement along the second"""
    dq: float
    turn_t: float
    turn_s: float
    """the change of ln(gap) and direction by this solution"""
    q_n: float
    q_t: float
    t_n: float
    t_t: float
    s_s: float
    """their change per displacement"""
    opening: float
    sliding: float
    """rates of ln(gap) and direction (1/s)"""


@compiled_inside
def linearized(film: Film, start: Start) -> LinearContact:
    """Linearize a contact over the implicit time span of its stage."""
    span, lean = start.span, start.lean
    opening, sliding = rates(film)
    dq, turn = solve_contact(film, span, lean, start.log_gap + span * opening, start.along + span * sliding)
    _, _, correction_n, correction_t = tangent(film, dq, turn, 0.0, 0.0)
    # The responses to a unit normal and a unit shear displacement.
    by_pull, by_shear = tangent(film, 0.0, 0.0, 1.0, 0.0), tangent(film, 0.0, 0.0, 0.0, 1.0)
    q_n, t_n = solve_contact(film, span, lean, span * by_pull[0], span * by_pull[1])
    q_t, t_t = solve_contact(film, span, lean, span * by_shear[0], span * by_shear[1])
    _, _, nn, tn = tangent(film, q_n, t_n, 1.0, 0.0)
    _, _, nt, tt = tangent(film, q_t, t_t, 0.0, 1.0)
    # Perpendicular to the plane of n and the shear, only the rotation of n has an effect.
    normal_stiffness, tangential_stiffness = film.surface.normal, film.surface.tangential
    relax = span * film.held * tangential_stiffness / (film.faded * film.resistance.shear * film.reach)
    s_s = relax / (lean + relax * film.pull)
    turn_s = start.across / (lean + relax * film.pull)
    normal = normal_stiffness * film.stretch
    ss = normal * s_s + tangential_stiffness * (1.0 - film.pull * s_s)
    correction_s = (normal - tangential_stiffness * film.pull) * turn_s
    along = tangential_stiffness * film.shear
    return LinearContact(
        normal, along, correction_n, correction_t, correction_s, nn, nt, tn, tt, ss, dq, turn, turn_s, q_n, q_t, t_n,
        t_t, s_s, opening, sliding,
    )  # fmt: skip
