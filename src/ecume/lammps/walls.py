"""The walls of a dish in LAMMPS: the region of each shape, and the formula of each meniscus.

`REGIONS` is keyed by the shape of the dish, `MENISCI` by the compiled law of the walls. To add a shape or a law, add a
row.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from ecume.lammps.expressible import shape_of
from ecume.lammps.numbers import DeckNumbers
from ecume.laws.special import scaled_bessel_i1
from ecume.models.floating.parameters import CAPILLARY_LENGTH
from ecume.models.floating.walls.wall_laws import DISH, NO_WALL_LAW, PLANE

NEGLIGIBLE = 1e-10
"""Terms of the series that are smaller than this fraction of its largest value at the wall are omitted."""

PER_VARIABLE = 6
"""Terms of the series in one formula."""


class Formula(NamedTuple):
    """A force on atoms as formulas."""

    properties: tuple[str, ...]
    """names of numbers of each atom"""
    values: tuple[list[float], ...]
    """these numbers, of each kind"""
    lines: tuple[str, ...]
    """commands that define the variables `name_x` and `name_y`, in N"""


def region_of(deck: DeckNumbers) -> str:
    """The inside of the dish as a command."""
    return REGIONS[shape_of(deck.scene)](deck)


def _round_region(deck: DeckNumbers) -> str:
    return f"region dish cylinder z 0 0 {deck.parameters.walls.disc_radius!r} INF INF side in"


def _rectangle_region(deck: DeckNumbers) -> str:
    x, y = half_sides(deck)
    return f"region dish block {-x!r} {x!r} {-y!r} {y!r} INF INF side in"


REGIONS: Mapping[str, Callable[[DeckNumbers], str]] = {"round": _round_region, "rectangle": _rectangle_region}
"""By the names of `dish.shape`."""


def half_sides(deck: DeckNumbers) -> tuple[float, float]:
    """Half of the width and the height of the dish (m)."""
    dish = deck.scene.dish
    assert dish is not None  # noqa: S101  # only called with a dish
    width, height = dish.size or (2.0 * deck.parameters.walls.disc_radius,) * 2
    return 0.5 * width, 0.5 * height


def dish_series(radius_over_length: float) -> list[float]:
    """The coefficients c_k of I1(r/L)/I1(a/L) = (r/a) sum_k c_k (r/a)^(2k), whose terms are all positive.

    c_k = (a/2L)^(2k+1)/(k! (k+1)! I1(a/L)), from the power series of I1.
    """
    half = 0.5 * radius_over_length
    scale = math.log(float(scaled_bessel_i1(radius_over_length))) + radius_over_length
    found: list[float] = []
    while len(found) <= half or found[-1] > NEGLIGIBLE:
        k = len(found)
        found.append(math.exp((2 * k + 1) * math.log(half) - math.lgamma(k + 1) - math.lgamma(k + 2) - scale))
    return found


def _round_meniscus(deck: DeckNumbers) -> Formula:
    """F = S/L I1(r/L)/I1(a/L) toward the center: see `ecume.laws.capillarity.dish_force`."""
    radius, length = float(deck.parameters.walls.disc_radius), float(deck.parameters.pair[CAPILLARY_LENGTH])
    terms = dish_series(radius / length)
    blocks = [terms[start : start + PER_VARIABLE] for start in range(0, len(terms), PER_VARIABLE)]
    lines = [f"variable meniscus_u atom (x*x+y*y)/{radius * radius!r}"]
    rest = ""
    for number in reversed(range(len(blocks))):
        lines.append(f"variable meniscus_{number} atom {_horner(blocks[number], rest)}")
        rest = f"v_meniscus_{number}"
    # The properties are S/(L a).
    lines += [f"variable meniscus_{axis} atom -d_meniscus*{axis}*v_meniscus_0" for axis in "xy"]
    strength = deck.parameters.wall_strength[0, deck.first] / (length * radius)
    return Formula(("d_meniscus",), (strength.tolist(),), tuple(lines))


def _horner(terms: list[float], rest: str) -> str:
    """c_0 + u (c_1 + u (...)), where `rest` is the sum of the terms that follow, or empty."""
    text = rest
    for term in reversed(terms):
        text = f"{term!r}+v_meniscus_u*({text})" if text else repr(term)
    return text


def _facing_meniscus(deck: DeckNumbers) -> Formula:
    """F = S/L exp(-d/L) away from each wall: see `ecume.laws.capillarity.plane_wall_force`."""
    length, strength = float(deck.parameters.pair[CAPILLARY_LENGTH]), deck.parameters.wall_strength
    lines = []
    for axis, half in zip("xy", half_sides(deck), strict=True):
        low, high = (f"exp(-({half!r}{sign}{axis})/{length!r})" for sign in "+-")
        lines.append(f"variable meniscus_{axis} atom d_meniscus_{axis}*({low}-{high})")
    values = tuple((strength[wall, deck.first] / length).tolist() for wall in range(2))
    return Formula(("d_meniscus_x", "d_meniscus_y"), values, tuple(lines))


MENISCI: Mapping[int, Callable[[DeckNumbers], Formula] | None] = {
    NO_WALL_LAW: None,
    DISH: _round_meniscus,
    PLANE: _facing_meniscus,
}
"""By `Parameters.wall_law`."""


def meniscus_of(deck: DeckNumbers) -> Formula | None:
    """The force of the walls from afar; None if they have no meniscus."""
    made = MENISCI[deck.parameters.wall_law]
    return None if made is None else made(deck)


def flow_of(deck: DeckNumbers) -> Formula | None:
    """The drag zeta u of a flowing surface; None if it rests."""
    if not deck.parameters.drift.flows:
        return None
    floats = deck.parameters.floats
    u, v, u_x, u_y, v_x, v_y = deck.parameters.drift.flow.tolist()
    friction = (floats.mass / floats.relaxation_time)[deck.first]
    lines = (
        f"variable flow_x atom d_friction*({u!r}+({u_x!r})*x+({u_y!r})*y)",
        f"variable flow_y atom d_friction*({v!r}+({v_x!r})*x+({v_y!r})*y)",
    )
    return Formula(("d_friction",), (friction.tolist(),), lines)


def box_of(deck: DeckNumbers) -> tuple[float, float, float, float]:
    """The box: lowest and highest x, then y (m). It is the periodic cell, or surrounds the dish or all floats."""
    if deck.scene.cell is not None:
        width, height = deck.parameters.periods[0].tolist()
        return 0.0, width, 0.0, height
    margin = 2.0 * float(deck.parameters.floats.radius.max())
    if deck.scene.dish is not None:
        x, y = (half + margin for half in half_sides(deck))
        return -x, x, -y, y
    margin = max(margin, 0.1 * deck.parameters.cutoff)
    low, high = np.min(deck.state.position, axis=0) - margin, np.max(deck.state.position, axis=0) + margin
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])
