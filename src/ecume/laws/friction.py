"""Friction between rough surfaces: below a gap as wide as their roughness, tips touch and hold each other.

What pulls along the surface is borne by film and tips side by side. Tips bear up to a limit in proportion to what
presses, and the film slides under the rest: it bears nothing, and does not slide, as long as the tips can hold. So
friction never drives.
"""

from __future__ import annotations

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


FRICTIONS = ("none", "coulomb")
"""Contact friction: none, or `holding_force`."""
