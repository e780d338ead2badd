"""What the surface carries of a floating body, slope by slope, and which slope carries a given weight.

Lengths are in L, weights in gamma L (per length of a lying cylinder: in gamma). A body's weight on a flat surface is
that of the liquid it displaces; whatever it weighs more the surface must carry, by its slope at the contact line.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from ecume.laws.flotation.young_laplace import STEEPEST, OuterMeniscus, outer_meniscus

TURNS = 80
EXACT = 1e-12
"""A root is found when Newton's next step is this share of the slope angle."""
STALLED = 1e-9
"""Steps this small that no longer shrink are rounding."""
ROUNDING = 1e-14
"""Rounding error of a weight, over its unit: it limits the accuracy of a nearly neutral body."""
NARROW = 1e-6
"""The load is quadratic around its maximum: known to the square of this."""
SCAN = 12
"""Slopes that are tried for the maximum of the load."""


class Contact(NamedTuple):
    """Where the contact line of a round, upright body runs when the surface leaves it with a slope angle;
    `..._change` is over that angle.
    """

    radius: float
    radius_change: float
    volume: float
    """of the body below the contact line"""
    volume_change: float
    height: float
    """of the contact line over the body's center"""


class Load(NamedTuple):
    """The load that a slope angle at the contact line carries, in the unit of the weight of the body, and its
    derivative.
    """

    slope_angle: float
    carried: float
    change: float
    meniscus: OuterMeniscus


class Floating(NamedTuple):
    """One floating body, in L; heights are those over the undisturbed surface."""

    slope_angle: float
    filling_angle: float
    contact_radius: float
    contact_height: float
    center_height: float
    charge: float


def round_load(contact: Contact, slope_angle: float, unit: float) -> Load:
    """Surface tension's vertical part and the generalized buoyancy, 2 pi r sin(psi) + V - pi r^2 z, over `unit`.

    V is the body's volume below the contact line, -pi r^2 z that of the dip above it. [keller1998].
    """
    radius, sine, cosine = contact.radius, math.sin(slope_angle), math.cos(slope_angle)
    surface = outer_meniscus(radius, slope_angle, contact.radius_change)
    dip, deepening = -surface.height, -surface.height_change
    carried = 2.0 * math.pi * radius * sine + contact.volume + math.pi * radius**2 * dip
    change = 2.0 * math.pi * (contact.radius_change * sine + radius * cosine) + contact.volume_change
    change += 2.0 * math.pi * radius * contact.radius_change * dip + math.pi * radius**2 * deepening
    return Load(slope_angle, carried / unit, change / unit, surface)


def stable_load(
    load: Callable[[float], Load], wanted: float, neutral: float, limit: float, guess: float
) -> Load | None:
    """The root between the flat surface, which carries `neutral`, and the steepest slope that still carries more.

    Newton's method inside a bracket that ends at the slope angle `limit`; None where nothing carries what is `wanted`.
    """
    excess = wanted - neutral
    inner, outer = 0.0, max(-STEEPEST, min(STEEPEST, limit))
    psi, crossed, last = guess, False, math.inf
    for _ in range(TURNS):
        if not crossed and abs(outer - inner) <= NARROW * abs(outer):
            break
        found = load(psi)
        rising = found.change > 0.0
        # Where the load no longer rises, the bracket is halved without a Newton step.
        step = (found.carried - wanted) / found.change if rising else 0.0
        enough = EXACT * abs(psi) + ROUNDING * (1.0 + abs(wanted)) / found.change if rising else 0.0
        if rising and (abs(step) <= enough or last <= abs(step) <= STALLED * abs(psi)):
            return found
        last = abs(step)
        above = rising and step * excess >= 0.0
        crossed = crossed or above
        inner, outer = (inner, psi) if above or not rising else (psi, outer)
        ahead = psi - step
        psi = ahead if rising and min(inner, outer) < ahead < max(inner, outer) else 0.5 * (inner + outer)
    return None


def greatest_load(load: Callable[[float], Load], limit: float) -> Load:
    """The load at its first maximum between the flat surface and the slope angle `limit`, or at the limit."""
    end = min(limit, STEEPEST)
    below = end / SCAN
    for k in range(1, SCAN + 1):
        above = k * end / SCAN
        if load(above).change < 0.0:
            # The load rises at the flat surface, where the first slope that is tried may be too far already.
            start = below if below < above else 1e-3 * above
            return load(slope_of_greatest(load, start, above))
        below = above
    return load(end)


def slope_of_greatest(load: Callable[[float], Load], rising: float, falling: float) -> float:
    """The slope angle of the greatest load between one at which it rises and one at which it falls.

    The zero of its derivative by false position, in the Illinois variant, to 1e-7 rad: at a maximum the error of the
    load is of second order. (The import of SciPy's root finders takes longer than all of it.)
    """
    low, high = load(rising).change, load(falling).change
    psi, side = rising, 0
    while abs(falling - rising) > 1e-7 and low * high < 0.0:
        before, psi = psi, (rising * high - falling * low) / (high - low)
        change = load(psi).change
        if change == 0.0 or abs(psi - before) < 1e-8:
            return psi
        if change * low > 0.0:
            rising, low, high, side = psi, change, 0.5 * high if side > 0 else high, 1
        else:
            falling, high, low, side = psi, change, 0.5 * low if side < 0 else low, -1
    return rising if low == 0.0 else falling if high == 0.0 else psi
