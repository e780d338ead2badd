"""The table of elastic laws: how the surfaces of a contact deform. A scene chooses one of them (`films.surface`).

A row holds everything that depends on the choice. Its formulas are compiled into the contacts. Their arguments are the
contact (`body`), its `gap`, its normal deflection (`stretch`, positive in tension), the `prefactors`, and constants of
the scene, by their names in the `Contacts` of `ecume.models.soft`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from ecume.laws import bubbles, elasticity
from ecume.laws.elasticity import Prefactors, Stiffness
from ecume.laws.soft_pair import SoftPair, crossover_gap, passage_time, viscous_time
from ecume.units import Energy, Force, Length, Number, Pressure, SurfaceTension
from ecume.value_texts import with_prefix

LARGE, FAINT = 0.1, 1e-7
"""Deflection over radius above which Hertz's law means little; reduced force that is lost in rounding."""


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
    """How both surfaces of a contact yield at its present deflection."""

    size: Length
    """a, the contact size"""
    normal: Stiffness
    tangential: Stiffness
    """force over deflection"""
    stiffening: Number
    """d ln(stiffness) / d ln(a)"""
    size_by_gap: Number
    """d ln(a) / d ln(gap) at a deflection that is held"""
    size_by_stretch: float
    """d ln(a) / d(stretch) (1/m)"""


class Expected(NamedTuple):
    """The largest force that is expected between two typical spheres, for `ecume check`."""

    pair: SoftPair
    force: Force
    """zero where none can be foreseen"""
    source: str
    gap: Length
    surface_tension: SurfaceTension


@dataclass(frozen=True)
class SurfaceLaw:
    """A row of the table: an elastic law and everything that depends on it."""

    surface: Callable[..., Surface]
    """stiffness and contact size at a gap and a deflection"""
    energy: Callable[..., float]
    """of a normal deflection at a gap that is held (J); its derivative is the normal force"""
    gap_energy: Callable[..., float]
    """the derivative of that energy with respect to ln(gap), at a deflection that is held (J)"""
    papers: tuple[Callable[..., Any], ...]
    """functions whose docstrings name the references that `ecume cite` lists"""
    check_lines: Callable[[Expected], list[tuple[str, str, str]]]
    """lines of `ecume check`: name, value with unit, remark"""
    needs: Mapping[str, str]
    """`surface_tension` of the liquid or `modulus` of each species, if the law needs it, and what to say if missing"""
    doubts: Callable[[Expected], list[str]] | None = None
    """what `ecume check` warns of"""


def hertz_surface(body: Body, gap: Length, stretch: Length, prefactors: Prefactors, rounding: Length) -> Surface:
    """Elastic spheres: a^2 = R* (c_h h + c_d |delta|), stiffness alpha E a. [rognon2009, eq. 5 to 9]."""
    # The kink of |delta| at zero is rounded off: a step across it would not converge.
    magnitude = math.sqrt(stretch * stretch + rounding * rounding)
    gap_weight, deflection_weight = prefactors.gap_weight, prefactors.deflection_weight
    size = elasticity.contact_size(body.reduced_radius, gap, magnitude, gap_weight, deflection_weight)
    per_size = body.reduced_radius / (size * size)
    return Surface(
        size=size,
        normal=elasticity.surface_stiffness(size, body.modulus, prefactors.normal),
        tangential=elasticity.surface_stiffness(size, body.modulus, prefactors.tangential),
        stiffening=1.0,
        size_by_gap=per_size * gap_weight * gap,
        size_by_stretch=per_size * deflection_weight * stretch / magnitude,
    )


def hertz_energy(body: Body, gap: Length, stretch: Length, prefactors: Prefactors) -> Energy:
    """The energy of `hertz_surface`'s normal force. [rognon2009]."""
    stiffness, ratio = _rest_stiffness(body, gap, stretch, prefactors)
    return elasticity.bent_energy(stretch, stiffness, ratio)


def hertz_gap_energy(body: Body, gap: Length, stretch: Length, prefactors: Prefactors) -> Energy:
    """The derivative of `hertz_energy` with respect to ln(gap). [rognon2009]."""
    stiffness, ratio = _rest_stiffness(body, gap, stretch, prefactors)
    return elasticity.gap_energy(stretch, stiffness, ratio)


def _rest_stiffness(body: Body, gap: Length, stretch: Length, prefactors: Prefactors) -> tuple[Stiffness, Number]:
    """The normal stiffness without a deflection, and how much the deflection adds to a^2, relatively."""
    rest = 2.0 * body.reduced_radius * prefactors.gap_weight * gap
    ratio = prefactors.deflection_weight * abs(stretch) / (prefactors.gap_weight * gap)
    return elasticity.surface_stiffness(math.sqrt(rest), body.modulus, prefactors.normal), ratio


def bubble_surface(
    body: Body, gap: Length, stretch: Length, prefactors: Prefactors, surface_tension: SurfaceTension, rounding: Length
) -> Surface:
    """Bubbles and drops: see `ecume.laws.bubbles`. [morse1993]."""
    radius_sum, reduced_radius = body.radius_sum, body.reduced_radius
    magnitude = math.sqrt(stretch * stretch + rounding * rounding)
    rest = 2.0 * reduced_radius * prefactors.gap_weight * gap
    area = rest + bubbles.flattened(magnitude, rest, radius_sum, reduced_radius)
    normal = bubbles.bubble_stiffness(area, radius_sum, reduced_radius, surface_tension)
    soft = bubbles.softness(area, radius_sum, reduced_radius)
    bend = bubbles.stiffening(area, radius_sum, reduced_radius)
    free = 2.0 * (area * soft - (area - rest) * bend)
    length = bubbles.flattening_length(radius_sum, reduced_radius)
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
    """The energy of `bubble_surface`'s normal force. [morse1993]."""
    rest = 2.0 * body.reduced_radius * prefactors.gap_weight * gap
    return bubbles.bubble_energy(stretch, rest, body.radius_sum, body.reduced_radius, surface_tension)


def bubble_stored_gap_energy(
    body: Body, gap: Length, stretch: Length, prefactors: Prefactors, surface_tension: SurfaceTension
) -> Energy:
    """The derivative of `bubble_stored_energy` with respect to ln(gap). [morse1993]."""
    rest = 2.0 * body.reduced_radius * prefactors.gap_weight * gap
    return bubbles.bubble_gap_energy(stretch, rest, body.radius_sum, body.reduced_radius, surface_tension)


def hertz_check_lines(expected: Expected) -> list[tuple[str, str, str]]:
    """Deflections, times and the regime of the expected force."""
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
    """Forces for which the law, or the arithmetic, means little."""
    kappa = expected.force / (expected.pair.modulus * expected.pair.radius**2)
    found = {
        "the force is large: Hertz's law holds for deflections well below a radius": kappa ** (2 / 3) > LARGE,
        "the force is so small that it is lost in rounding, and time steps become short": 0.0 < kappa < FAINT,
    }
    return [said for said, wrong in found.items() if wrong]


def bubble_check_lines(expected: Expected) -> list[tuple[str, str, str]]:
    """The expected force over the surface tension."""
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
        hertz_surface, hertz_energy, hertz_gap_energy, (elasticity.surface_force, elasticity.surface_energy),
        hertz_check_lines, {"modulus": "elastic spheres have one; got none"}, hertz_doubts,
    ),
    "bubble": SurfaceLaw(
        bubble_surface, bubble_stored_energy, bubble_stored_gap_energy, (bubbles.bubble_force, bubbles.bubble_energy),
        bubble_check_lines, {"surface_tension": "bubbles have one; got none"},
    ),
}  # fmt: skip
"""`hertz`: elastic spheres; `bubble`: bubbles and drops. Another law is another row."""
