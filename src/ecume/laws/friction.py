"""Friction between rough surfaces: below a gap as wide as their roughness, tips touch and hold each other.

What pulls along the surface is borne by film and tips side by side. Tips bear up to a limit in proportion to what
presses, and the film slides under the rest: it bears nothing, and does not slide, as long as the tips can hold. So
friction never drives.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ecume.units import Force, Length, Number

SOFTLY = 0.02
"""Of the limit: over so much more pull the film takes up its part gradually, so that the sliding has a slope."""


def touching(gap: Length, roughness: Length) -> Number:
    """What part of the load lies on the tips: 1 below half of the roughness, 0 above the roughness, smooth between.

    >>> touching(0.4, 1.0), touching(0.75, 1.0), touching(1.0, 1.0)
    (1.0, 0.5, 0.0)
    """
    u = min(max(2.0 * gap / roughness - 1.0, 0.0), 1.0)
    return (1.0 - u) ** 2 * (1.0 + 2.0 * u)


def touching_power(gap: Length, roughness: Length) -> Number:
    """The slope h d(touching)/dh, which is negative.

    >>> touching_power(0.75, 1.0)
    -2.25
    """
    u = min(max(2.0 * gap / roughness - 1.0, 0.0), 1.0)
    return -12.0 * u * (1.0 - u) * gap / roughness


def holding_force(compression: Force, gap: Length, coefficient: Number, roughness: Length) -> Force:
    """The most that tips hold along the surface: mu N w(h), Coulomb's law of what presses. [coulomb1785].

    N is the normal force, positive where it presses; w is `touching`.

    >>> holding_force(2.0, 0.1, 0.5, 1.0), holding_force(-2.0, 0.1, 0.5, 1.0)
    (1.0, 0.0)
    """
    return coefficient * max(compression, 0.0) * touching(gap, roughness)


def sliding_force(pull: Force, limit: Force) -> Force:
    """What the film bears of a pull along the surface, of its sign, and slides under: none below the limit.

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
    """The slope of `sliding_force` over the pull: from 0 to 1.

    >>> sliding_slope(0.9, 1.0), sliding_slope(2.0, 1.0), sliding_slope(0.0, 0.0)
    (0.0, 1.0, 1.0)
    """
    over, width = abs(pull) - limit, SOFTLY * limit
    if over >= width:
        return 1.0
    return max(over, 0.0) / width


def limit_slope(pull: Force, limit: Force) -> Number:
    """The slope of `sliding_force` over the limit, for a positive pull; negative.

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
    """What the film bears of a pull along the surface, and how that changes."""

    held: Number
    """over the pull; 1 without contact friction"""
    by_pull: Number
    by_limit: Number
    """derivatives of what the film bears, with respect to the pull and to the limit of contact friction"""
    limit_by_normal: Number
    limit_by_gap: Force
    """derivatives of that limit, with respect to the normal force (tension) and to ln(gap)"""


def no_rubbing(gap: Length, compression: Force, pull: Force) -> Rubbing:
    """Without contact friction, the film bears all of the pull.

    >>> no_rubbing(1e-6, 1.0, 0.5).held
    1.0
    """
    return Rubbing(1.0, 1.0, 0.0, 0.0, 0.0)


def coulomb_rubbing(gap: Length, compression: Force, pull: Force, coefficient: Number, roughness: Length) -> Rubbing:
    """Coulomb's friction of the tips, `holding_force`, beside the film. [coulomb1785].

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
    """Friction above a critical load N_c: tips hold up to mu (N - N_c) w(h). Below N_c a layer on the surfaces keeps
    them apart, and nothing is held.

    The critical load model of suspensions that thicken under shear; w is `touching`. [mari2014].

    >>> critical_rubbing(0.1, 2.0, 0.9, 0.5, 1.0, 1.5).held == coulomb_rubbing(0.1, 0.5, 0.9, 0.5, 1.0).held
    True
    >>> critical_rubbing(0.1, 2.0, 0.9, 0.5, 1.0, 2.0).held
    1.0
    """
    return coulomb_rubbing(gap, compression - critical_load, pull, coefficient, roughness)


def _roughness_doubts(gap: Length, roughness: Length, smallest_radius: Length) -> list[str]:
    """Roughness that does not matter, or is too large."""
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
    """options of the films that the law needs, and what to say if one is missing"""
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
