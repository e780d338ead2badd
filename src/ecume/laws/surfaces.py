"""The deformation of the surfaces of a contact: bubbles and drops, and the table of elastic laws
(`films.surface`).

A scene chooses a row of the table at the end. A row holds everything that depends on the choice. Its formulas are
compiled into the contacts. Their arguments are the contact (`body`), its `gap`, its normal deflection (`stretch`,
positive in tension), the `prefactors`, and constants of the scene, by their names in the `Contacts` of
`ecume.models.soft`. The formulas of Hertz's row are in `soft_pair`, those of bubbles and drops are here.

Surface tension keeps bubbles round, and a contact flattens them. Between two bubbles under compression is a flat facet.
The liquid in it is at the mean of the pressures inside them, gamma (1/R_i + 1/R_j) above that outside, so that its area
grows with the force. Around a facet of radius a the deformation is a logarithm of R/a: bubbles are softer at smaller
forces, without a power law. Contacts are independent: the effects of other contacts of the
same bubble and of its constant volume are ignored. A wall is a flat, rigid partner; it has the sum of radii and the
reduced radius of the sphere.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from ecume.laws import soft_pair
from ecume.laws.soft_pair import Prefactors, SoftPair, Stiffness, crossover_gap, passage_time, viscous_time
from ecume.units import Area, Energy, Force, Length, Number, Pressure, SurfaceTension, Unit, with_prefix

SquaredArea = Annotated[float, Unit("m^4")]

EDGE = 4.0 * math.exp(-5.0 / 6.0)
"""The factor of R^2 in the logarithm: the deflection of a bubble contains 2 ln(2R/a) - 5/6."""
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
    """Function L = sum over the bubbles of ln(1 + 4 exp(-5/6) R^2/a^2): deflection times 4 pi gamma
    over force.

    The area is a^2. For a << R this is the sum of 2 ln(2R/a) - 5/6 of the theory; the 1 keeps it positive for larger a,
    for which it is only known that bubbles become stiff. [morse1993].

    >>> round(softness(1e-4, 2.0, 0.5) / 2 - (2 * math.log(2 / 0.01) - 5 / 6), 4)
    0.0001
    """
    if reduced_radius > 0.5 * radius_sum:
        return math.log(1.0 + EDGE * radius_sum**2 / area)
    product = (EDGE * reduced_radius * radius_sum / area) ** 2
    return math.log(1.0 + EDGE * radius_sum * (radius_sum - 2.0 * reduced_radius) / area + product)


def stiffening(area: Area, radius_sum: Length, reduced_radius: Length) -> Number:
    """Derivative -dL/d ln(a^2) of `softness`: 1 per bubble for small contacts. [morse1993].

    >>> round(stiffening(1e-6, 2.0, 0.5), 4)
    2.0
    """
    if reduced_radius > 0.5 * radius_sum:
        return 1.0 / (1.0 + area / (EDGE * radius_sum**2))
    total, product = EDGE * radius_sum * (radius_sum - 2.0 * reduced_radius), (EDGE * reduced_radius * radius_sum) ** 2
    return (total * area + 2.0 * product) / (area * area + total * area + product)


def flattened(deflection: Length, film_area: Area, radius_sum: Length, reduced_radius: Length) -> Area:
    """Increase p of a^2 beyond that of the film by a deflection of either sign: the root of delta =
    p L(a_h^2 + p)/l.

    a_h^2 is that of the film without deflection, l the `flattening_length`. Infinite at deflections above the size of
    the bubbles, l L p -> 4 exp(-5/6) (R_i^2 + R_j^2)/l, which no force reaches. [morse1993].

    >>> p = flattened(0.1, 0.01, 2.0, 0.5)
    >>> round(p * softness(0.01 + p, 2.0, 0.5) / 2.0, 12)
    0.1
    """
    target = abs(deflection) * flattening_length(radius_sum, reduced_radius)
    partner = 0.0 if reduced_radius > 0.5 * radius_sum else 2.0 * reduced_radius
    found = 0.0 * film_area
    if target >= EDGE * radius_sum * (radius_sum - partner):
        return math.inf * film_area
    # The left side is concave: from below, Newton's method converges without overshoot.
    for _ in range(MOST_ITERATIONS):
        area = film_area + found
        soft = softness(area, radius_sum, reduced_radius)
        slope = soft - found / area * stiffening(area, radius_sum, reduced_radius)
        change = (target - found * soft) / slope
        found += change
        if change <= CLOSE * found:
            return found
    return math.inf * film_area


def bubble_stiffness(
    area: Area, radius_sum: Length, reduced_radius: Length, surface_tension: SurfaceTension
) -> Stiffness:
    """Stiffness k = 4 pi gamma / L(a^2): force over deflection of both surfaces. [morse1993].

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

    At a constant gap, at which the film has a^2 = a_h^2 without a force. It is the pressure gamma/R* on the area
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
    """Energy of the deflection, the integral of `bubble_force` at a constant gap: F^2 ln(1/F) for
    small forces.

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
    """Function K(b) = p^2/2 - b p + b^2 ln(1 + p/b), the integral of p^2/(b + p) over p up to the
    facet's area over pi.

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
    """Slope a_h^2 dU/d(a_h^2) of `bubble_energy`, at a constant deflection; it equals that over the
    gap, h dU/dh.

    4 pi gamma/l^2 a_h^2 times the sum over the bubbles of J(a_h^2) - J(a_h^2 + c), J of `spread_moment`: minus the
    slope of the complementary energy at a constant force. [morse1993].

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
    """Function J(b) = p - b ln(1 + p/b), the integral of p/(b + p) over p up to the facet's area
    over pi.

    >>> round(spread_moment(1e-4, 1.0) / (1e-8 / 2), 4), round(spread_moment(1.0, 1.0), 6)
    (0.9999, 0.306853)
    """
    x = facet_area / rest
    if x < 0.01:
        return facet_area * x * (1 / 2 - x * (1 / 3 - x * (1 / 4 - x * (1 / 5 - x / 6))))
    return rest * (x - math.log1p(x))


LARGE, FAINT = 0.1, 1e-7
"""Deflection over radius above which Hertz's law is inaccurate; reduced force that is lost in rounding."""


class Body(NamedTuple):
    """Two spheres in contact, or a sphere at a wall."""

    radius_sum: Length
    reduced_radius: Length
    modulus: Pressure
    force: Force = 0.0
    """of user-defined laws across the film at the present gap; positive repels"""
    slope: Stiffness = 0.0
    """of this force over the gap"""


class Surface(NamedTuple):
    """The stiffnesses and size of both surfaces of a contact at its present deflection."""

    size: Length
    """a, the contact size"""
    normal: Stiffness
    tangential: Stiffness
    """force over deflection"""
    stiffening: Number
    """d ln(stiffness) / d ln(a)"""
    size_by_gap: Number
    """d ln(a) / d ln(gap) at a constant deflection"""
    size_by_stretch: float
    """d ln(a) / d(stretch) (1/m)"""


class Expected(NamedTuple):
    """The largest expected force between two typical spheres, for `ecume check`."""

    pair: SoftPair
    force: Force
    """zero if none can be predicted"""
    source: str
    gap: Length
    surface_tension: SurfaceTension


@dataclass(frozen=True)
class SurfaceLaw:
    """A row of the table: an elastic law and everything that depends on it."""

    surface: Callable[..., Surface]
    """stiffness and contact size at a gap and a deflection"""
    energy: Callable[..., float]
    """of a normal deflection at a constant gap (J); its derivative is the normal force"""
    gap_energy: Callable[..., float]
    """the derivative of that energy by ln(gap), at a constant deflection (J)"""
    papers: tuple[Callable[..., Any], ...]
    """functions whose docstrings name the references that `ecume cite` lists"""
    check_lines: Callable[[Expected], list[tuple[str, str, str]]]
    """lines of `ecume check`: name, value with unit, remark"""
    needs: Mapping[str, str]
    """`surface_tension` of the liquid or `modulus` of each species, if the law needs it, and the message if it is
    missing
    """
    doubts: Callable[[Expected], list[str]] | None = None
    """warnings of `ecume check`"""


def hertz_surface(body: Body, gap: Length, stretch: Length, prefactors: Prefactors, rounding: Length) -> Surface:
    """Elastic spheres: a^2 = R* (c_h h + c_d |delta|), stiffness alpha E a. [rognon2009, eq. 5 to 9]."""
    # |delta| is smoothed at zero: a step across its kink would not converge.
    magnitude = math.sqrt(stretch * stretch + rounding * rounding)
    gap_weight, deflection_weight = prefactors.gap_weight, prefactors.deflection_weight
    size = soft_pair.contact_size(body.reduced_radius, gap, magnitude, gap_weight, deflection_weight)
    per_size = body.reduced_radius / (size * size)
    return Surface(
        size=size,
        normal=soft_pair.surface_stiffness(size, body.modulus, prefactors.normal),
        tangential=soft_pair.surface_stiffness(size, body.modulus, prefactors.tangential),
        stiffening=1.0,
        size_by_gap=per_size * gap_weight * gap,
        size_by_stretch=per_size * deflection_weight * stretch / magnitude,
    )


def hertz_energy(body: Body, gap: Length, stretch: Length, prefactors: Prefactors) -> Energy:
    """Energy of the normal force of `hertz_surface`. [rognon2009]."""
    stiffness, ratio = _rest_stiffness(body, gap, stretch, prefactors)
    return soft_pair.bent_energy(stretch, stiffness, ratio)


def hertz_gap_energy(body: Body, gap: Length, stretch: Length, prefactors: Prefactors) -> Energy:
    """Derivative of `hertz_energy` by ln(gap). [rognon2009]."""
    stiffness, ratio = _rest_stiffness(body, gap, stretch, prefactors)
    return soft_pair.gap_energy(stretch, stiffness, ratio)


def _rest_stiffness(body: Body, gap: Length, stretch: Length, prefactors: Prefactors) -> tuple[Stiffness, Number]:
    """The normal stiffness without deflection, and the relative increase of a^2 by the deflection."""
    rest = 2.0 * body.reduced_radius * prefactors.gap_weight * gap
    ratio = prefactors.deflection_weight * abs(stretch) / (prefactors.gap_weight * gap)
    return soft_pair.surface_stiffness(math.sqrt(rest), body.modulus, prefactors.normal), ratio


def bubble_surface(
    body: Body, gap: Length, stretch: Length, prefactors: Prefactors, surface_tension: SurfaceTension, rounding: Length
) -> Surface:
    """Bubbles and drops: see `ecume.laws.surfaces`. [morse1993]."""
    radius_sum, reduced_radius = body.radius_sum, body.reduced_radius
    magnitude = math.sqrt(stretch * stretch + rounding * rounding)
    rest = 2.0 * reduced_radius * prefactors.gap_weight * gap
    area = rest + flattened(magnitude, rest, radius_sum, reduced_radius)
    normal = bubble_stiffness(area, radius_sum, reduced_radius, surface_tension)
    soft = softness(area, radius_sum, reduced_radius)
    bend = stiffening(area, radius_sum, reduced_radius)
    free = 2.0 * (area * soft - (area - rest) * bend)
    length = flattening_length(radius_sum, reduced_radius)
    return Surface(
        size=math.sqrt(area),
        normal=normal,
        tangential=normal * prefactors.tangential / prefactors.normal,
        stiffening=2.0 * bend / soft,
        size_by_gap=rest * soft / free,
        size_by_stretch=length / free * stretch / magnitude,
    )


def bubble_stored_energy(
    body: Body, gap: Length, stretch: Length, prefactors: Prefactors, surface_tension: SurfaceTension
) -> Energy:
    """Energy of the normal force of `bubble_surface`. [morse1993]."""
    rest = 2.0 * body.reduced_radius * prefactors.gap_weight * gap
    return bubble_energy(stretch, rest, body.radius_sum, body.reduced_radius, surface_tension)


def bubble_stored_gap_energy(
    body: Body, gap: Length, stretch: Length, prefactors: Prefactors, surface_tension: SurfaceTension
) -> Energy:
    """Derivative of `bubble_stored_energy` by ln(gap). [morse1993]."""
    rest = 2.0 * body.reduced_radius * prefactors.gap_weight * gap
    return bubble_gap_energy(stretch, rest, body.radius_sum, body.reduced_radius, surface_tension)


def hertz_check_lines(expected: Expected) -> list[tuple[str, str, str]]:
    """Lines on deflections, times and the regime of the expected force."""
    pair, force, source, gap, _ = expected
    surface = ("relaxation time", with_prefix(pair.viscosity / pair.modulus, "s", 3), "viscosity over modulus")
    if not force > 0.0:
        return [surface]
    kappa, crossover = force / (pair.modulus * pair.radius**2), crossover_gap(pair, force)
    regime = (
        "Poiseuille regime: gaps are larger than deflections"
        if gap > crossover
        else "Hertz regime: deflections are larger than gaps"
    )
    rows = [
        ("force", with_prefix(force, "N", 3), f"expected on a pair: {source}"),
        ("reduced force", f"{kappa:.3g}", "force / (modulus x radius^2)"),
        (
            "deflection",
            with_prefix(crossover, "m", 3),
            f"by that force; at gaps of {with_prefix(gap, 'm', 3)}: {regime}",
        ),
        surface,
        ("viscous time", with_prefix(viscous_time(pair, force), "s", 3), "growth of a large gap by a factor e"),
    ]
    if gap < pair.radius:
        duration = with_prefix(passage_time(pair, force, gap, pair.radius), "s", 3)
        rows.append(("separation time", duration, f"from a gap of {with_prefix(gap, 'm', 3)} to one radius"))
    return rows


def hertz_doubts(expected: Expected) -> list[str]:
    """Warnings on forces for which the law or the arithmetic is inaccurate."""
    kappa = expected.force / (expected.pair.modulus * expected.pair.radius**2)
    found = {
        "the force is so small that it is lost in rounding, and time steps become short": 0.0 < kappa < FAINT,
    }
    return [said for said, wrong in found.items() if wrong]


def bubble_check_lines(expected: Expected) -> list[tuple[str, str, str]]:
    """The line on the expected force over the surface tension."""
    if not expected.force > 0.0:
        return []
    reduced = expected.force / (expected.surface_tension * expected.pair.radius)
    remark = "force / (surface tension x radius); facets are small compared with bubbles well below 1"
    return [
        ("force", with_prefix(expected.force, "N", 3), f"expected on a pair: {expected.source}"),
        ("reduced force", f"{reduced:.3g}", remark),
    ]


SURFACES = {
    "hertz": SurfaceLaw(
        hertz_surface, hertz_energy, hertz_gap_energy, (soft_pair.surface_force, soft_pair.surface_energy),
        hertz_check_lines, {"modulus": "elastic spheres have one; got none"}, hertz_doubts,
    ),
    "bubble": SurfaceLaw(
        bubble_surface, bubble_stored_energy, bubble_stored_gap_energy, (bubble_force, bubble_energy),
        bubble_check_lines, {"surface_tension": "bubbles have one; got none"},
    ),
}  # fmt: skip
"""`hertz`: elastic spheres; `bubble`: bubbles and drops."""
