"""The walls of a dish in LAMMPS: the region of each shape, and the formula of each meniscus."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from ecume.laws.special import scaled_bessel_i1
from ecume.models.floating.dishes import DISH, NO_WALL_LAW, PLANE
from ecume.models.floating.parameters import CAPILLARY_LENGTH
from ecume.units import Array
from ecume_lammps.expressible import shape_of

if TYPE_CHECKING:
    pass
from ecume_lammps.numbers import LONGEST, SHORTEST, DeckNumbers

ROUNDED = 5.0
"""The constant b in s^2 = r^2 + (b L)^2, for which the fit of the meniscus has few terms."""
ERROR = 5e-10
"""Largest relative error of the fitted meniscus of a dish."""


class Formula(NamedTuple):
    """A force on atoms as formulas."""

    properties: tuple[str, ...]
    """names of the properties of atoms that the formulas use"""
    values: tuple[list[float], ...]
    """these properties, for each kind"""
    lines: tuple[str, ...]
    """commands that define the variables `name_x` and `name_y`, in N"""


def region_of(deck: DeckNumbers) -> str:
    """The command for the region inside the dish."""
    return REGIONS[shape_of(deck.scene)](deck)


def _round_region(deck: DeckNumbers) -> str:
    return f"region dish cylinder z 0 0 {deck.parameters.walls.disc_radius!r} INF INF side in"


def _rectangle_region(deck: DeckNumbers) -> str:
    x, y = half_sides(deck)
    return f"region dish block {-x!r} {x!r} {-y!r} {y!r} INF INF side in"


REGIONS: Mapping[str, Callable[[DeckNumbers], str]] = {"round": _round_region, "rectangle": _rectangle_region}
"""The functions that write regions, by `dish.shape`."""


def half_sides(deck: DeckNumbers) -> tuple[float, float]:
    """Half of the width and the height of the dish (m)."""
    dish = deck.scene.dish
    assert dish is not None  # noqa: S101  # only called with a dish
    width, height = dish.size or (2.0 * deck.parameters.walls.disc_radius,) * 2
    return 0.5 * width, 0.5 * height


class DishFit(NamedTuple):
    """Fit of (a/r) I1(r/L)/I1(a/L) = exp((s - s_a)/L) s^(-3/2) sum_j c_j k^j with k = slope/s + shift, s^2 = r^2 + (5
    L)^2.
    """

    slope: float
    """m"""
    shift: float
    coefficients: list[float]
    """m^(3/2)"""


def _tail(z: float) -> float:
    """Function exp(-s) s^(3/2) I1(z)/z with s^2 = z^2 + 25, which is smooth in 1/s, since I1 grows as
    exp(z)/sqrt(z).
    """
    s = math.hypot(z, ROUNDED)
    over = 0.5 * math.exp(-z) if z < 1e-6 else float(scaled_bessel_i1(z)) / z
    return float(over * math.exp(z - s) * s**1.5)


def dish_fit(radius: float, length: float) -> DishFit:
    """The fit with the fewest terms that is within `ERROR`, at Chebyshev nodes in 1/s between the
    wall and the center.
    """
    end, rounded = math.hypot(radius, ROUNDED * length), ROUNDED * length
    lowest = rounded / end
    between = np.linspace(-1.0, 1.0, 1000)
    exact = _tails(between, lowest)
    for degree in range(SHORTEST, LONGEST + 1):
        nodes = chebyshev.chebpts1(degree + 1)
        fitted = chebyshev.chebfit(nodes, _tails(nodes, lowest), degree)
        if np.all(np.abs(chebyshev.chebval(between, fitted) - exact) <= ERROR * exact):
            break
    at_wall = length / radius * float(scaled_bessel_i1(radius / length))
    scale = length**1.5 * math.exp((end - radius) / length) / at_wall
    slope, shift = 2.0 * rounded / (1.0 - lowest), (lowest + 1.0) / (lowest - 1.0)
    return DishFit(slope, shift, (scale * chebyshev.cheb2poly(fitted)).tolist())


def _tails(k: Array, lowest: float) -> Array:
    """The values of `_tail` between the wall, k = -1, and the center, k = 1."""
    s = ROUNDED / (lowest + 0.5 * (1.0 - lowest) * (k + 1.0))
    z = np.sqrt(np.maximum(s * s - ROUNDED * ROUNDED, 0.0))
    return np.array([_tail(each) for each in z.tolist()])


def _round_meniscus(deck: DeckNumbers) -> Formula:
    """The force F = S/L I1(r/L)/I1(a/L) toward the center: see `ecume.laws.capillarity.dish_force`."""
    radius, length = float(deck.parameters.walls.disc_radius), float(deck.parameters.pair[CAPILLARY_LENGTH])
    fit, rounded = dish_fit(radius, length), ROUNDED * length
    end = math.hypot(radius, rounded)
    lines = [
        f"variable meniscus_s atom sqrt(x*x+y*y+{rounded * rounded!r})",
        f"variable meniscus_k atom {fit.slope!r}/v_meniscus_s{fit.shift:+.17g}",
        f"variable meniscus_0 atom exp((v_meniscus_s-{end!r})/{length!r})*({_horner(fit.coefficients)})"
        "/(v_meniscus_s*sqrt(v_meniscus_s))",
        # The properties are S/(L a).
        *(f"variable meniscus_{axis} atom -d_meniscus*{axis}*v_meniscus_0" for axis in "xy"),
    ]
    strength = deck.parameters.wall_strength[0, deck.first] / (length * radius)
    return Formula(("d_meniscus",), (strength.tolist(),), tuple(lines))


def _horner(terms: list[float]) -> str:
    """The formula of a polynomial in Horner's form, c_0 + k (c_1 + k (...))."""
    text = repr(terms[-1])
    for term in reversed(terms[:-1]):
        text = f"{term!r}+v_meniscus_k*({text})"
    return text


def _facing_meniscus(deck: DeckNumbers) -> Formula:
    """The force F = S/L exp(-d/L) away from each wall: see `ecume.laws.capillarity.plane_wall_force`."""
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
"""The functions that write menisci, by `Parameters.wall_law`."""


def meniscus_of(deck: DeckNumbers) -> Formula | None:
    """The force by the menisci of the walls; None without them."""
    made = MENISCI[deck.parameters.wall_law]
    return None if made is None else made(deck)


def flow_of(deck: DeckNumbers) -> Formula | None:
    """The drag zeta u by a flowing surface; None if it is at rest."""
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
    """The limits of the box: lowest and highest x, then y (m). The box is the periodic cell, or contains the dish or
    all floats.
    """
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
