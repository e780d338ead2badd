"""Contact friction between rough surfaces, and collisions.

Below a gap as wide as the roughness, asperities touch. They bear tangential forces up to a limit proportional to the
normal force, in parallel with the film. The film bears the excess over this limit and slides; below the limit it does
not slide. Friction therefore never does positive work.

Collisions of two bodies are computed by impulses or by springs and dashpots. Speeds of approach are positive as a gap
closes. The contact solver (`ecume.engine.contact`) finds the impulses of all contacts at once; for two bodies alone
they are those of `impulse`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from ecume.units import Angle, Energy, Force, Friction, Length, Mass, Number, Speed, Unit

SOFTLY = 0.02
"""The range of tangential forces above the limit, over the limit, in which the force on the film grows smoothly, so
that sliding is differentiable.
"""


def touching(gap: Length, roughness: Length) -> Number:
    """Fraction of the load that asperities carry: 1 below half of the roughness, 0 above it, with a smooth transition.

    >>> touching(0.4, 1.0), touching(0.75, 1.0), touching(1.0, 1.0)
    (1.0, 0.5, 0.0)
    """
    u = min(max(2.0 * gap / roughness - 1.0, 0.0), 1.0)
    return (1.0 - u) ** 2 * (1.0 + 2.0 * u)


def touching_power(gap: Length, roughness: Length) -> Number:
    """Slope h d(touching)/dh, which is negative.

    >>> touching_power(0.75, 1.0)
    -2.25
    """
    u = min(max(2.0 * gap / roughness - 1.0, 0.0), 1.0)
    return -12.0 * u * (1.0 - u) * gap / roughness


def holding_force(compression: Force, gap: Length, coefficient: Number, roughness: Length) -> Force:
    """Largest tangential force of asperities, mu N w(h): Coulomb's law with the load that they
    carry. [coulomb1785].

    N is the normal force, positive where it presses; w is `touching`.

    >>> holding_force(2.0, 0.1, 0.5, 1.0), holding_force(-2.0, 0.1, 0.5, 1.0)
    (1.0, 0.0)
    """
    return coefficient * max(compression, 0.0) * touching(gap, roughness)


def sliding_force(pull: Force, limit: Force) -> Force:
    """Tangential force that the film carries, with the sign of the pull: the excess over the limit of contact friction,
    zero below it.

    It is |T| - L (1 + e/2) well above the limit L, and (|T| - L)^2/(2 e L) from L to L (1 + e), with e = 0.02.
    [coulomb1785].

    >>> sliding_force(0.9, 1.0), sliding_force(-3.0, 0.0), round(sliding_force(2.0, 1.0), 6)
    (0.0, -3.0, 0.99)
    """
    size = abs(pull)
    if size <= limit:
        return 0.0 * pull
    over = size - limit
    width = SOFTLY * limit
    borne = over * over / (2.0 * width) if over < width else over - 0.5 * width
    return borne if pull > 0.0 else -borne


def sliding_slope(pull: Force, limit: Force) -> Number:
    """Slope of `sliding_force` over the tangential force: from 0 to 1.

    >>> sliding_slope(0.9, 1.0), sliding_slope(2.0, 1.0), sliding_slope(0.0, 0.0)
    (0.0, 1.0, 1.0)
    """
    over, width = abs(pull) - limit, SOFTLY * limit
    if over >= width:
        return 1.0
    return max(over, 0.0) / width


def limit_slope(pull: Force, limit: Force) -> Number:
    """Slope of `sliding_force` over the limit, for a positive tangential force; negative.

    >>> limit_slope(0.9, 1.0), round(limit_slope(2.0, 1.0), 6)
    (0.0, -1.01)
    """
    over, width = abs(pull) - limit, SOFTLY * limit
    if over <= 0.0:
        return 0.0
    if over >= width:
        return -1.0 - 0.5 * SOFTLY
    return -over / width - 0.5 * SOFTLY * (over / width) ** 2


class Rubbing(NamedTuple):
    """The tangential force that the film carries, and its derivatives."""

    held: Number
    """over the tangential force; 1 without contact friction"""
    by_pull: Number
    by_limit: Number
    """derivatives of what the film bears, with respect to the pull and to the limit of contact friction"""
    limit_by_normal: Number
    limit_by_gap: Force
    """derivatives of that limit, with respect to the normal force (tension) and to ln(gap)"""


def no_rubbing(gap: Length, compression: Force, pull: Force) -> Rubbing:
    """Law without contact friction: the film carries the whole tangential force.

    >>> no_rubbing(1e-6, 1.0, 0.5).held
    1.0
    """
    return Rubbing(1.0, 1.0, 0.0, 0.0, 0.0)


def coulomb_rubbing(gap: Length, compression: Force, pull: Force, coefficient: Number, roughness: Length) -> Rubbing:
    """Law with Coulomb friction of the asperities, `holding_force`, in parallel with the film.
    [coulomb1785].

    >>> coulomb_rubbing(0.1, 2.0, 0.9, 0.5, 1.0).held
    0.0
    """
    if compression <= 0.0 or gap >= roughness:
        return no_rubbing(gap, compression, pull)
    limit, size = holding_force(compression, gap, coefficient, roughness), abs(pull)
    by_pull = sliding_slope(size, limit)
    held = sliding_force(size, limit) / size if size > 0.0 else by_pull
    by_limit = limit_slope(size, limit) * (1.0 if pull > 0.0 else -1.0)
    by_normal = -coefficient * touching(gap, roughness)
    return Rubbing(held, by_pull, by_limit, by_normal, coefficient * compression * touching_power(gap, roughness))


def critical_rubbing(
    gap: Length, compression: Force, pull: Force, coefficient: Number, roughness: Length, critical_load: Force
) -> Rubbing:
    """Law with friction above a critical load N_c: asperities hold up to mu (N - N_c) w(h). Below N_c a layer on the
    surfaces keeps them apart, and there is no friction.

    The critical load model of suspensions that thicken under shear; w is `touching`. [mari2014].

    >>> critical_rubbing(0.1, 2.0, 0.9, 0.5, 1.0, 1.5).held == coulomb_rubbing(0.1, 0.5, 0.9, 0.5, 1.0).held
    True
    >>> critical_rubbing(0.1, 2.0, 0.9, 0.5, 1.0, 2.0).held
    1.0
    """
    return coulomb_rubbing(gap, compression - critical_load, pull, coefficient, roughness)


def _roughness_doubts(gap: Length, roughness: Length, smallest_radius: Length) -> list[str]:
    """Warnings on a roughness that has no effect or is too large."""
    found = {
        "gaps are wider than the roughness: there is no contact friction as yet": gap > roughness,
        "the roughness is a tenth of a radius or more: tips on a sphere are smaller": roughness > 0.1 * smallest_radius,
    }
    return [said for said, wrong in found.items() if wrong]


@dataclass(frozen=True)
class ContactFriction:
    """A row of the table: a law of contact friction and everything that depends on it."""

    rubbing: Callable[..., Rubbing]
    """what the film bears; beside gap, compression and pull it takes constants of the scene, by their names in
    `ecume.models.soft`'s `Contacts`
    """
    papers: tuple[Callable[..., Any], ...] = ()
    """functions whose docstrings name the references that `ecume cite` lists"""
    needs: Mapping[str, str] = field(default_factory=dict)
    """options of the films that the law needs, and the message if one is missing"""
    doubts: Callable[..., list[str]] | None = None
    """what `ecume check` warns of, by the gap, the roughness and the smallest radius"""


FRICTIONS = {
    "none": ContactFriction(no_rubbing),
    "coulomb": ContactFriction(
        coulomb_rubbing, (holding_force,),
        {"roughness": "contact friction acts below a gap as wide as it; got none"}, _roughness_doubts,
    ),
    "critical-load": ContactFriction(
        critical_rubbing, (critical_rubbing, holding_force),
        {
            "roughness": "contact friction acts below a gap as wide as it; got none",
            "critical_load": "friction begins above this compression; got none",
        },
        _roughness_doubts,
    ),
}  # fmt: skip
"""Contact friction: `films.friction` of a scene."""


Impulse = Annotated[float, Unit("N*s")]
Torque = Annotated[float, Unit("N*m")]
Stiffness = Annotated[float, Unit("N/m")]


def impulse(approach_speed: Speed, mass_i: Mass, mass_j: Mass, restitution: Number) -> Impulse:
    """Impulse along the line of centers that makes two bodies separate; zero if they separate
    already.

    J = (1 + e) v m_i m_j / (m_i + m_j), with opposite signs on the two bodies, so that momentum is conserved.
    A wall is the limit of an infinite mass. [moreau1988]; [canbraun2022, eq. 32 to 34] is the elastic case, e = 1.

    Erratum: [canbraun2022, eq. 35 and 36], for a wall, reverse the velocity also if the body moves away, and reduce the
    tangential part as well.

    >>> impulse(2.0, 1.0, 1.0, 1.0)
    2.0
    """
    return (1.0 + restitution) * max(approach_speed, 0.0) * (mass_i * mass_j / (mass_i + mass_j))


def legacy_restitution(coefficient: Number) -> Number:
    """Restitution e = 2C - 1 that is equivalent to the original project's coefficient C.

    It multiplies the elastic impulse by C; below C = 1/2 the bodies still approach after the collision, and overlap.
    [canbraun2022, eq. 32 to 34].

    >>> round(legacy_restitution(0.3), 12)
    -0.4
    """
    return 2.0 * coefficient - 1.0


def legacy_coefficient(restitution: Number) -> Number:
    """Coefficient C = (1 + e)/2, the inverse of `legacy_restitution`. [canbraun2022, eq. 32 to 34].

    >>> legacy_coefficient(1.0)
    1.0
    """
    return 0.5 * (1.0 + restitution)


def spring_push(overlap: Length, approach_speed: Speed, stiffness: Stiffness, friction: Friction) -> Force:
    """Force of a spring and a dashpot between two overlapping bodies; repulsive (positive) or zero.

    F = max(k delta + c v, 0), delta > 0 the overlap and v its rate. [cundall1979].

    >>> spring_push(0.1, -2.0, 10.0, 1.0), spring_push(0.1, 2.0, 10.0, 1.0)
    (0.0, 3.0)
    """
    return max(stiffness * overlap + friction * approach_speed, 0.0)


def spring_energy(overlap: Length, stiffness: Stiffness) -> Energy:
    """Energy of the spring, k delta^2/2; zero without overlap. [cundall1979].

    >>> spring_energy(0.1, 10.0), spring_energy(-0.1, 10.0)
    (0.05000000000000001, 0.0)
    """
    return 0.5 * stiffness * max(overlap, 0.0) ** 2


def dashpot_restitution(damping: Number) -> Number:
    """Restitution of a single collision with a spring k and a dashpot c = 2 zeta sqrt(k m), m the
    reduced mass.

    The collision ends when the force vanishes, not when the overlap does: with s = sqrt(|1 - zeta^2|)
    e = exp(-(zeta/s) atan2(2 zeta s, 2 zeta^2 - 1)) below zeta = 1, exp(-2) there, and beyond it
    e = exp(-(zeta/s) ln((zeta + s)/(zeta - s))). [schwager2007].

    >>> dashpot_restitution(0.0), round(dashpot_restitution(1.0) / math.exp(-2.0), 12)
    (1.0, 1.0)
    """
    square = 1.0 - damping * damping
    if abs(square) < 1e-12:
        return math.exp(-2.0)
    s = math.sqrt(abs(square))
    if square > 0.0:
        return math.exp(-damping / s * math.atan2(2.0 * damping * s, 2.0 * damping * damping - 1.0))
    return math.exp(-damping / s * math.log((damping + s) / (damping - s)))


def restitution_itself(restitution: Number) -> Number:
    """Return the restitution e as given: 0 is a plastic collision, 1 an elastic one.

    >>> restitution_itself(0.2)
    0.2
    """
    return restitution


def effective_radius(radius_i: Length, radius_j: Length) -> Length:
    """Effective radius R* = R_i R_j/(R_i + R_j) of a contact of two spheres; that of a sphere at a wall is its radius.
    [ai2011].

    >>> effective_radius(1.0, 1.0)
    0.5
    """
    return radius_i * radius_j / (radius_i + radius_j)


def rolling_limit(compression: Force, coefficient: Number, radius_i: Length, radius_j: Length) -> Torque:
    """Largest couple mu_r N R* between two spheres that roll on each other; it opposes their relative spin.

    N is the normal force, positive where it presses, and R* the `effective_radius`. The model is that of constant
    directional torque: the couple has this magnitude while the spheres roll. Otherwise it is the couple that keeps them
    at rest, as in Coulomb's law. [ai2011, model A].

    >>> rolling_limit(2.0, 0.1, 1.0, 1.0), rolling_limit(-2.0, 0.1, 1.0, 1.0)
    (0.1, 0.0)
    """
    return coefficient * max(compression, 0.0) * effective_radius(radius_i, radius_j)


def holding_rolling_friction(bend: Angle, contact_force: Force, end_force: Force) -> Number:
    """Smallest coefficient of rolling friction at which a chain of three equal spheres stays bent; psi is the angle
    between the directions from the middle sphere to the other two.

    mu_r = 2 F_e cos(psi/2)/(F_c + F_e sin(psi/2)), F_c is the attraction of two spheres in contact and F_e that of the
    two end spheres. F_e has the component T = F_e cos(psi/2) along the surface of the middle sphere; the normal force
    is N = F_c + F_e sin(psi/2). The end is at rest if friction bears T, with mu >= mu_r/2, and a couple balances its
    torque T R about the center of the end; the largest couple is mu_r N R/2, `rolling_limit`. [ai2011, model A]; the
    chains are those of [dalbe2011].

    >>> round(holding_rolling_friction(math.pi / 2, 1.0, 0.5), 6)
    0.522408
    >>> round(holding_rolling_friction(math.pi, 1.0, 0.5), 12)
    0.0
    """
    half = 0.5 * bend
    return 2.0 * end_force * math.cos(half) / (contact_force + end_force * math.sin(half))


RESTITUTIONS: dict[str, Callable[[float], float]] = {
    "restitution": restitution_itself,
    "legacy_coefficient": legacy_restitution,
}
