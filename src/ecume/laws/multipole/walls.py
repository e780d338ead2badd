"""Walls around many bodies: what they give the surface by themselves, and what they send back."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ecume.errors import BadInput
from ecume.laws.arguments import require_angle, require_positive
from ecume.laws.flotation.bodies import Liquid
from ecume.laws.meniscus import dish_height, facing_amplitude, plane_amplitude
from ecume.units import Angle, Array, Length
from ecume.value_texts import with_prefix

if TYPE_CHECKING:
    from ecume.laws.multipole.echoes import Echoes
    from ecume.laws.multipole.graf import Rims

REACH = 45.0
"""Gaps, in L, beyond which nothing is felt: exp(-45) is below 1e-19."""
EXACT = 1e-14
MOST_WAVES = 700


@dataclass(frozen=True)
class Basin:
    """Four plane walls around the origin, with the contact angle of the liquid on them, or with a pinned brim.

    pinned: the surface is held at its undisturbed height on the walls (images of the other sign) and has no meniscus;
    the contact angle is then not used.
    """

    width: Length
    depth: Length
    contact_angle: Angle = 0.5 * math.pi
    pinned: bool = False

    def __post_init__(self) -> None:
        require_positive("basin's width", self.width)
        require_positive("basin's depth", self.depth)
        require_angle("basin's contact_angle", self.contact_angle)


@dataclass(frozen=True)
class Dish:
    """A round wall around the origin; see `Basin`."""

    radius: Length
    contact_angle: Angle = 0.5 * math.pi
    pinned: bool = False

    def __post_init__(self) -> None:
        require_positive("dish's radius", self.radius)
        require_angle("dish's contact_angle", self.contact_angle)


Walls = Basin | Dish | None


def echoes_of(walls: Walls, liquid: Liquid, rims: Rims, at: Array) -> Echoes:
    """What the walls send back. Raises BadInput where a contact line is not inside them."""
    from ecume.laws.multipole.echoes import make_echoes, make_round_echoes

    orders = rims.response.shape[1]
    room = _room(walls, liquid, at) - rims.radius
    if room.min() <= 0.0:
        worst = int(np.argmin(room))
        depth = with_prefix(-room[worst] * liquid.capillary_length, "m", 3)
        raise BadInput(f"the contact line of body {worst} reaches {depth} into a wall")
    if isinstance(walls, Dish):
        brim = walls.radius / liquid.capillary_length
        waves = math.ceil(math.log(EXACT) / math.log(1.0 - room.min() / brim)) + 2 * orders
        most = min(MOST_WAVES, math.ceil(4.0 * orders * brim / rims.radius.min()) + 20)
        return make_round_echoes(brim, min(waves, most), orders, rims.reference, walls.pinned)
    return make_echoes(images(walls, liquid), orders, rims.reference)


def _room(walls: Walls, liquid: Liquid, at: Array) -> Array:
    """Each place's distance from the nearest wall."""
    length = liquid.capillary_length
    if walls is None:
        return np.full(len(at), np.inf)
    if isinstance(walls, Dish):
        return np.asarray(walls.radius / length - np.hypot(at[:, 0], at[:, 1]))
    half = 0.5 * np.array([walls.width, walls.depth]) / length
    return np.asarray((half - np.abs(at)).min(axis=1))


def images(walls: Walls, liquid: Liquid) -> Array:
    """The images that keep the condition on all four walls: reflections of reflections, as far as they are felt."""
    if not isinstance(walls, Basin):
        return np.array([[1.0, 0.0, 1.0, 0.0, 1.0]])
    sides = [side / liquid.capillary_length for side in (walls.width, walls.depth)]
    shown = []
    for side in sides:
        most = max(1, math.ceil(REACH / side))
        shown.append([((-1.0) ** k, k * side) for k in range(-most, most + 1)])
    sign = -1.0 if walls.pinned else 1.0
    every = [
        (sx, ox, sy, oy, (sign if sx < 0 else 1.0) * (sign if sy < 0 else 1.0))
        for sx, ox in shown[0]
        for sy, oy in shown[1]
        if math.hypot(max(abs(ox) - sides[0], 0.0), max(abs(oy) - sides[1], 0.0)) <= REACH
    ]
    every.sort(key=lambda mirror: (math.hypot(mirror[1], mirror[3]), mirror))
    return np.array(every)


def outer_waves(walls: Walls, liquid: Liquid, at: Array, radius: Array, orders: int) -> NDArray[np.complex128]:
    """The walls' own menisci around each body, as amplitudes of I_m.

    exp(n.x) = sum of I_m(r) exp(i m (phi - phi_n)), n towards a plane wall; and I_0 around the middle of a dish is
    the sum of I_m(r_0) exp(-i m phi_0) I_m(r) exp(i m phi).
    """
    from scipy.special import iv, ive

    waves = np.zeros((len(at), orders), np.complex128)
    m, inside = np.arange(orders), iv(np.arange(orders), radius[:, None])
    if isinstance(walls, Dish) and not walls.pinned:
        brim, out = walls.radius / liquid.capillary_length, np.hypot(at[:, 0], at[:, 1])[:, None]
        strength = plane_amplitude(walls.contact_angle) * ive(m, out) / ive(1, brim) * np.exp(out - brim)
        waves = strength * inside * np.exp(-1j * m * np.arctan2(at[:, 1], at[:, 0])[:, None])
    elif isinstance(walls, Basin) and not walls.pinned:
        for amplitude, normal, away in _menisci(walls, liquid):
            strength = amplitude * np.exp(at @ normal - away)
            waves += strength[:, None] * inside * np.exp(-1j * m * math.atan2(normal[1], normal[0]))
    return waves


def outer_height(walls: Walls, liquid: Liquid, x: Array, y: Array) -> Array:
    """The height (in L) that the walls alone give the surface."""
    length = liquid.capillary_length
    total = np.zeros(np.shape(x))
    if isinstance(walls, Dish) and not walls.pinned:
        out = np.minimum(np.hypot(x, y) * length, walls.radius)
        return np.asarray(dish_height(out, walls.radius, walls.contact_angle, liquid)) / length
    if isinstance(walls, Basin) and not walls.pinned:
        for amplitude, normal, away in _menisci(walls, liquid):
            total = total + amplitude * np.exp(normal[0] * x + normal[1] * y - away)
    return total


def _menisci(walls: Basin, liquid: Liquid) -> list[tuple[float, Array, float]]:
    """Of each wall: amplitude, direction towards it, distance from the origin; in capillary lengths."""
    length = liquid.capillary_length
    found = []
    for axis, side in enumerate((walls.width, walls.depth)):
        amplitude = facing_amplitude(side, walls.contact_angle, liquid) / length
        for sign in (-1.0, 1.0):
            found.append((amplitude, sign * np.eye(2)[axis], 0.5 * side / length))
    return found
