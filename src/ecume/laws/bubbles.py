"""Surfaces of bubbles and drops: surface tension holds them round, and a contact flattens them.

A flat facet lies between two bubbles that are pressed together. The liquid in it is at the mean of the pressures
inside them, gamma (1/R_i + 1/R_j) above that outside, so that its area grows with the force. Around a facet of radius
a the deformation is a logarithm of R/a: bubbles are the softer, the less they are pressed, and no power law describes
them. Each contact stands for itself here: the effects of other contacts of the same bubble and of its constant volume
are ignored. A wall is a flat, rigid partner; it has the sum of radii and the reduced radius of the sphere.
"""

from __future__ import annotations

import math
from typing import Annotated

from ecume.laws.elasticity import Stiffness
from ecume.units import Area, Energy, Force, Length, Number, SurfaceTension, Unit

SquaredArea = Annotated[float, Unit("m^4")]

EDGE = 4.0 * math.exp(-5.0 / 6.0)
"""What R^2 is multiplied by in the logarithm: 2 ln(2R/a) - 5/6 is how far a bubble's facet recedes."""
CLOSE = 1e-15
MOST_ITERATIONS = 60


def flattening_length(radius_sum: Length, reduced_radius: Length) -> Length:
    """The facet's area over the logarithm and the deflection: 4 R* for two bubbles, 2 R for one at a wall.

    From the pressures gamma/R* and 2 gamma/R in the facet. [morse1993].

    >>> flattening_length(2.0, 0.5), flattening_length(1.0, 1.0)
    (2.0, 2.0)
    """
    return (2.0 if reduced_radius > 0.5 * radius_sum else 4.0) * reduced_radius


def softness(area: Area, radius_sum: Length, reduced_radius: Length) -> Number:
    """L = sum over the bubbles of ln(1 + 4 exp(-5/6) R^2/a^2): deflection times 4 pi gamma over force.

    The area is a^2. For a << R this is the sum of 2 ln(2R/a) - 5/6, the theory's; the 1 keeps it positive beyond, where
    nothing is known but that bubbles get stiff. [morse1993].

    >>> round(softness(1e-4, 2.0, 0.5) / 2 - (2 * math.log(2 / 0.01) - 5 / 6), 4)
    0.0001
    """
    if reduced_radius > 0.5 * radius_sum:
        return math.log(1.0 + EDGE * radius_sum**2 / area)
    product = (EDGE * reduced_radius * radius_sum / area) ** 2
    return math.log(1.0 + EDGE * radius_sum * (radius_sum - 2.0 * reduced_radius) / area + product)


def stiffening(area: Area, radius_sum: Length, reduced_radius: Length) -> Number:
    """-dL/d ln(a^2) of `softness`: 1 a bubble where contacts are small. [morse1993].

    >>> round(stiffening(1e-6, 2.0, 0.5), 4)
    2.0
    """
    if reduced_radius > 0.5 * radius_sum:
        return 1.0 / (1.0 + area / (EDGE * radius_sum**2))
    total, product = EDGE * radius_sum * (radius_sum - 2.0 * reduced_radius), (EDGE * reduced_radius * radius_sum) ** 2
    return (total * area + 2.0 * product) / (area * area + total * area + product)


def flattened(deflection: Length, film_area: Area, radius_sum: Length, reduced_radius: Length) -> Area:
    """The a^2 that a deflection of either sign adds to that of the film: the root p of delta = p L(a_h^2 + p)/l.

    a_h^2 is the film's own at no deflection, l the `flattening_length`. Infinite where bubbles would be deflected by
    more than their size, l L p -> 4 exp(-5/6) (R_i^2 + R_j^2)/l, which no force does. [morse1993].

    >>> p = flattened(0.1, 0.01, 2.0, 0.5)
    >>> round(p * softness(0.01 + p, 2.0, 0.5) / 2.0, 12)
    0.1
    """
    wanted = abs(deflection) * flattening_length(radius_sum, reduced_radius)
    partner = 0.0 if reduced_radius > 0.5 * radius_sum else 2.0 * reduced_radius
    found = 0.0 * film_area
    if wanted >= EDGE * radius_sum * (radius_sum - partner):
        return math.inf * film_area
    # The left side is concave: from below, Newton's method comes up to the root and never beyond.
    for _ in range(MOST_ITERATIONS):
        area = film_area + found
        soft = softness(area, radius_sum, reduced_radius)
        slope = soft - found / area * stiffening(area, radius_sum, reduced_radius)
        change = (wanted - found * soft) / slope
        found += change
        if change <= CLOSE * found:
            return found
    return math.inf * film_area


def bubble_stiffness(
    area: Area, radius_sum: Length, reduced_radius: Length, surface_tension: SurfaceTension
) -> Stiffness:
    """K = 4 pi gamma / L(a^2): force over deflection of both surfaces. [morse1993].

    Two equal bubbles without a film: delta = F/(2 pi gamma) (ln(8 pi gamma R/F) - 5/6).

    >>> force = 1e-3
    >>> k = bubble_stiffness(force / (2 * math.pi), 2.0, 0.5, 1.0)
    >>> round(force / k / (force / (2 * math.pi) * (math.log(8 * math.pi / force) - 5 / 6)), 4)
    1.0
    """
    return 4.0 * math.pi * surface_tension / softness(area, radius_sum, reduced_radius)


def bubble_force(
    compression: Length, film_area: Area, radius_sum: Length, reduced_radius: Length, surface_tension: SurfaceTension
) -> Force:
    """Normal force of two bubbles, or of one at a wall; positive repels, and so does a positive compression.

    At a gap that is held, where the film has a^2 = a_h^2 without a force. It is the pressure gamma/R* on the area
    pi (a^2 - a_h^2). [morse1993].

    >>> force = bubble_force(0.1, film_area=0.01, radius_sum=2.0, reduced_radius=0.5, surface_tension=1.0)
    >>> round(force / (2.0 * math.pi * flattened(0.1, 0.01, 2.0, 0.5)), 12)
    1.0
    """
    area = film_area + flattened(compression, film_area, radius_sum, reduced_radius)
    return bubble_stiffness(area, radius_sum, reduced_radius, surface_tension) * compression


def bubble_energy(
    compression: Length, film_area: Area, radius_sum: Length, reduced_radius: Length, surface_tension: SurfaceTension
) -> Energy:
    """Energy of the deflection, the integral of `bubble_force` at a gap that is held: F^2 ln(1/F) for small forces.

    U = 4 pi gamma/l^2 (p^2 L - sum over the bubbles of [K(a_h^2) - K(a_h^2 + c)])/2 with p the facet's area over pi,
    c = 4 exp(-5/6) R^2, and K of `excess_moment`.

    >>> body = {"film_area": 0.01, "radius_sum": 2.0, "reduced_radius": 0.5, "surface_tension": 1.0}
    >>> step = bubble_energy(0.1001, **body) - bubble_energy(0.0999, **body)
    >>> round(step / 2e-4 / bubble_force(0.1, **body), 6)
    1.0
    """
    length, scale = flattening_length(radius_sum, reduced_radius), 4.0 * math.pi * surface_tension
    found = flattened(compression, film_area, radius_sum, reduced_radius)
    spent = found**2 * softness(film_area + found, radius_sum, reduced_radius)
    wide = excess_moment(found, film_area)
    if reduced_radius > 0.5 * radius_sum:
        return 0.5 * scale / length**2 * (spent - wide + excess_moment(found, film_area + EDGE * radius_sum**2))
    difference = math.sqrt(max(0.25 * radius_sum**2 - reduced_radius * radius_sum, 0.0))
    for radius in (0.5 * radius_sum - difference, 0.5 * radius_sum + difference):
        spent -= wide - excess_moment(found, film_area + EDGE * radius**2)
    return 0.5 * scale / length**2 * spent


def excess_moment(facet_area: Area, rest: Area) -> SquaredArea:
    """The K(b) = p^2/2 - b p + b^2 ln(1 + p/b), the integral of p^2/(b + p) over p up to the facet's area over pi.

    >>> round(excess_moment(1e-4, 1.0) / (1e-12 / 3), 4), round(excess_moment(1.0, 1.0), 6)
    (0.9999, 0.193147)
    """
    x = facet_area / rest
    if x < 0.01:
        return rest * facet_area * x * x * (1 / 3 - x * (1 / 4 - x * (1 / 5 - x * (1 / 6 - x / 7))))
    return rest**2 * (0.5 * x * x - x + math.log1p(x))


def bubble_gap_energy(
    compression: Length, film_area: Area, radius_sum: Length, reduced_radius: Length, surface_tension: SurfaceTension
) -> Energy:
    """The slope a_h^2 dU/d(a_h^2) of `bubble_energy`, at a deflection that is held; that over the gap, h dU/dh.

    4 pi gamma/l^2 a_h^2 times the sum over the bubbles of J(a_h^2) - J(a_h^2 + c), J of `spread_moment`: minus the
    slope of the complementary energy at a force that is held. [morse1993].

    >>> body = {"radius_sum": 2.0, "reduced_radius": 0.5, "surface_tension": 1.0}
    >>> step = bubble_energy(0.1, 0.01001, **body) - bubble_energy(0.1, 0.00999, **body)
    >>> round(step / 2e-5 * 0.01 / bubble_gap_energy(0.1, 0.01, **body), 5)
    1.0
    """
    length, scale = flattening_length(radius_sum, reduced_radius), 4.0 * math.pi * surface_tension * film_area
    found = flattened(compression, film_area, radius_sum, reduced_radius)
    narrow = spread_moment(found, film_area)
    if reduced_radius > 0.5 * radius_sum:
        return scale / length**2 * (narrow - spread_moment(found, film_area + EDGE * radius_sum**2))
    difference = math.sqrt(max(0.25 * radius_sum**2 - reduced_radius * radius_sum, 0.0))
    near = spread_moment(found, film_area + EDGE * (0.5 * radius_sum - difference) ** 2)
    far = spread_moment(found, film_area + EDGE * (0.5 * radius_sum + difference) ** 2)
    return scale / length**2 * (2.0 * narrow - near - far)


def spread_moment(facet_area: Area, rest: Area) -> Area:
    """The J(b) = p - b ln(1 + p/b), the integral of p/(b + p) over p up to the facet's area over pi.

    >>> round(spread_moment(1e-4, 1.0) / (1e-8 / 2), 4), round(spread_moment(1.0, 1.0), 6)
    (0.9999, 0.306853)
    """
    x = facet_area / rest
    if x < 0.01:
        return facet_area * x * (1 / 2 - x * (1 / 3 - x * (1 / 4 - x * (1 / 5 - x / 6))))
    return rest * (x - math.log1p(x))
