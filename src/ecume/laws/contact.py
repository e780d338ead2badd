"""Collisions, as scalar laws for the contact solver. A speed of approach is positive when the gap closes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

from ecume.units import Mass, Number, Speed, Unit

Impulse = Annotated[float, Unit("N*s")]


def impulse(approach_speed: Speed, mass_i: Mass, mass_j: Mass, restitution: Number) -> Impulse:
    """Impulse along the line of centers that makes two bodies part; zero when they part already.

    J = (1 + e) v m_i m_j / (m_i + m_j), taken from one body and given to the other, so that momentum is kept.
    [moreau1988]; [canbraun2022, eq. 32 to 34] is the elastic case, e = 1.

    >>> impulse(2.0, 1.0, 1.0, 1.0)
    2.0
    """
    return (1.0 + restitution) * max(approach_speed, 0.0) * (mass_i * mass_j / (mass_i + mass_j))


def wall_impulse(approach_speed: Speed, mass: Mass, restitution: Number) -> Impulse:
    """Impulse of a wall, away from it: J = (1 + e) v m; zero for a body that leaves. [moreau1988].

    >>> wall_impulse(2.0, 1.0, 0.5)
    3.0
    """
    return (1.0 + restitution) * max(approach_speed, 0.0) * mass


def rebound(approach_speed: Speed, restitution: Number) -> Speed:
    """Speed of approach after a collision: -e v when approaching, unchanged otherwise. [moreau1988].

    Erratum: [canbraun2022, eq. 35 and 36] turn the speed round without asking for its sign, and slow the tangential
    part as well.

    >>> rebound(2.0, 0.5), rebound(-2.0, 0.5)
    (-1.0, -2.0)
    """
    return -restitution * approach_speed if approach_speed > 0.0 else approach_speed


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
