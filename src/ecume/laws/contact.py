"""Collisions of two bodies, by impulses or by springs and dashpots. Speeds of approach are positive as a gap closes.

The contact solver (`ecume.engine.contact`) finds the impulses of all contacts at once; for two bodies alone they are
those of `impulse`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated

from ecume.units import Energy, Force, Friction, Length, Mass, Number, Speed, Unit

Impulse = Annotated[float, Unit("N*s")]
Stiffness = Annotated[float, Unit("N/m")]


def impulse(approach_speed: Speed, mass_i: Mass, mass_j: Mass, restitution: Number) -> Impulse:
    """Impulse along the line of centers that makes two bodies part; zero when they part already.

    J = (1 + e) v m_i m_j / (m_i + m_j), taken from one body and given to the other, so that momentum is kept.
    A wall is the limit of an infinite mass. [moreau1988]; [canbraun2022, eq. 32 to 34] is the elastic case, e = 1.

    Erratum: [canbraun2022, eq. 35 and 36], for a wall, reverse the speed without asking for its sign, and slow the
    tangential part as well.

    >>> impulse(2.0, 1.0, 1.0, 1.0)
    2.0
    """
    return (1.0 + restitution) * max(approach_speed, 0.0) * (mass_i * mass_j / (mass_i + mass_j))


def legacy_restitution(coefficient: Number) -> Number:
    """The restitution e = 2C - 1 that the original project's coefficient C amounts to.

    It multiplies the elastic impulse by C; below C = 1/2 the bodies still approach after the collision, and sink
    into one another. [canbraun2022, eq. 32 to 34].

    >>> round(legacy_restitution(0.3), 12)
    -0.4
    """
    return 2.0 * coefficient - 1.0


def legacy_coefficient(restitution: Number) -> Number:
    """C = (1 + e)/2, the inverse of `legacy_restitution`. [canbraun2022, eq. 32 to 34].

    >>> legacy_coefficient(1.0)
    1.0
    """
    return 0.5 * (1.0 + restitution)


def spring_push(overlap: Length, approach_speed: Speed, stiffness: Stiffness, friction: Friction) -> Force:
    """Push of a spring and a dashpot between two that overlap; positive repels, and nothing ever draws them together.

    F = max(k delta + c v, 0), delta > 0 the overlap and v its rate. [cundall1979].

    >>> spring_push(0.1, -2.0, 10.0, 1.0), spring_push(0.1, 2.0, 10.0, 1.0)
    (0.0, 3.0)
    """
    return max(stiffness * overlap + friction * approach_speed, 0.0)


def spring_energy(overlap: Length, stiffness: Stiffness) -> Energy:
    """Energy of the spring alone, k delta^2/2; zero where nothing overlaps. [cundall1979].

    >>> spring_energy(0.1, 10.0), spring_energy(-0.1, 10.0)
    (0.05000000000000001, 0.0)
    """
    return 0.5 * stiffness * max(overlap, 0.0) ** 2


def dashpot_restitution(damping: Number) -> Number:
    """Restitution of a lone collision over a spring k and a dashpot c = 2 zeta sqrt(k m), m the reduced mass.

    It ends when the push has come down to zero, not when the overlap has: with s = sqrt(|1 - zeta^2|)
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
    """The restitution e as it is given: 0 sticks, 1 bounces without loss.

    >>> restitution_itself(0.2)
    0.2
    """
    return restitution


RESTITUTIONS: dict[str, Callable[[float], float]] = {
    "restitution": restitution_itself,
    "legacy_coefficient": legacy_restitution,
}
