"""The interface of the multipole solver: many bodies in SI units, also between walls."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from numbers import Integral
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ecume.errors import BadInput
from ecume.laws.arguments import require_angle, require_positive
from ecume.laws.flotation.bodies import Liquid, Sphere
from ecume.laws.meniscus import dish_height, facing_amplitude, plane_amplitude
from ecume.laws.multipole.closures import Closure, closure_of
from ecume.units import Angle, Array, Length, with_prefix

if TYPE_CHECKING:
    from ecume.laws.multipole.solving import Echoes, Rims, Waves


REACH = 45.0
"""The gap in L beyond which interactions are ignored: exp(-45) is below 1e-19."""
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
    """The reflections by the walls. Raises BadInput if a contact line is not inside them."""
    from ecume.laws.multipole.solving import make_echoes, make_round_echoes

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
    """The distance of each place from the nearest wall."""
    length = liquid.capillary_length
    if walls is None:
        return np.full(len(at), np.inf)
    if isinstance(walls, Dish):
        return np.asarray(walls.radius / length - np.hypot(at[:, 0], at[:, 1]))
    half = 0.5 * np.array([walls.width, walls.depth]) / length
    return np.asarray((half - np.abs(at)).min(axis=1))


def images(walls: Walls, liquid: Liquid) -> Array:
    """The images that satisfy the condition on all four walls: repeated reflections within the range of the field."""
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
    """The menisci of the walls around each body, as amplitudes of I_m.

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
    """The height (in L) of the menisci of the walls alone."""
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
    """Amplitude, direction and distance from the origin of each wall, in capillary lengths."""
    length = liquid.capillary_length
    found = []
    for axis, side in enumerate((walls.width, walls.depth)):
        amplitude = facing_amplitude(side, walls.contact_angle, liquid) / length
        for sign in (-1.0, 1.0):
            found.append((amplitude, sign * np.eye(2)[axis], 0.5 * side / length))
    return found


DENSE = 2500
"""The number of unknowns up to which the system is solved by elimination."""
TOLERANCE = 1e-13
ROUNDING = 1e-9
MOST_ORDER = 150


@dataclass(frozen=True)
class Solution:
    """Forces, torques, heights and tilts of the bodies by the surface."""

    forces: Array
    """(N, 2) N, horizontal"""
    torques: Array
    """(N,) N m, about the vertical"""
    heights: Array
    """(N,) m, of the center of the contact line above the undisturbed surface"""
    tilts: Array
    """(N, 2) slope of the contact line's plane along x and y"""
    energy: float
    """J; zero without bodies; it decreases when bodies that attract approach"""
    iterations: int
    """0 for elimination"""
    amplitudes: NDArray[np.complex128] = field(repr=False)
    """(N, order + 1) A_m K_m(a) at each contact line, in capillary lengths; a start for the next solution"""
    setting: tuple[Any, Any, Array, Liquid] = field(repr=False)
    """the arguments of `height`"""


def solve(
    positions: ArrayLike,
    bodies: Sequence[Any],
    liquid: Liquid,
    order: int = 20,
    *,
    walls: Basin | Dish | None = None,
    method: str = "auto",
    start: NDArray[np.complex128] | None = None,
    tolerance: float = TOLERANCE,
) -> Solution:
    """Compute forces, torques, heights, tilts and energy of bodies on one surface, with all mutual
    interactions.

    Exact on the linearized surface in the limit of high order: errors decrease as (a/(a + gap))^order, so that order 8
    is accurate to 1e-3 at a gap of 2 % of a diameter; flat pinned rims converge faster. Slopes must be small, including
    the sum of many.
    `method`: "dense", "iterative" or "auto". The forces are the derivatives of the energy at any order. Bodies: `Disc`,
    `Sphere` and `VerticalCylinder` of `ecume.laws.flotation`, and `Undulated`. [vassileva2005, watson1944].
    """
    from ecume.laws.multipole import solving

    places, length = _places(positions, bodies), liquid.capillary_length
    order = _whole(order)
    known: dict[Any, Closure] = {}
    closures = [known.setdefault(body, closure_of(body, liquid, order)) for body in bodies]
    rims, at = solving.make_rims(closures, REACH), places / length
    widest = np.array([body.radius if isinstance(body, Sphere) else 0.0 for body in bodies])
    _require_apart(at, np.maximum(rims.radius, widest / length), length)
    raft = _Raft(rims, echoes_of(walls, liquid, rims, at), at)
    outer = outer_waves(walls, liquid, at, rims.radius, order + 2)
    right = rims.source + rims.response * outer[:, : order + 1]
    dense = chosen_method(method, right.shape[0] * (2 * order + 1))
    amplitudes, iterations = _amplitudes(raft, right, start, None if dense else tolerance)
    waves = np.zeros((len(closures), order + 2), np.complex128)
    solving.incoming(rims, raft.echoes, at, amplitudes, waves)
    waves += outer
    return _solution(
        (rims, walls, at, liquid),
        amplitudes,
        waves,
        sum(closure.energy for closure in closures) + solving.energy(rims, amplitudes, waves, outer),
        iterations,
    )


class _Raft(NamedTuple):
    """The coefficients of the linear system, in capillary lengths."""

    rims: Rims
    echoes: Echoes
    at: Array


def _amplitudes(raft: _Raft, right: Waves, start: Waves | None, tolerance: float | None) -> tuple[Waves, int]:
    """The amplitudes and the number of iterations; by elimination, without a tolerance. Raises BadInput."""
    from ecume.laws.multipole import solving

    if tolerance is None:
        return solving.eliminate(*raft, right), 0
    amplitudes = np.array(right if start is None else start, np.complex128)
    iterations = solving.iterate(*raft, right, amplitudes, solving.make_krylov(*right.shape), tolerance)
    if iterations < 0:
        raise BadInput(
            f"the multipoles of {len(right)} bodies were not found to {tolerance:g}; rims that nearly touch "
            "need a larger tolerance, a lower order, or method = 'dense'"
        )
    return amplitudes, iterations


def _solution(
    setting: tuple[Any, Any, Array, Liquid], amplitudes: Waves, waves: Waves, energy: float, iterations: int
) -> Solution:
    """The forces, torques, heights and tilts in SI that follow from the amplitudes and incoming waves."""
    from ecume.laws.multipole import solving

    rims, _, at, liquid = setting
    force, torque = np.zeros_like(at), np.zeros(len(at))
    solving.forces(rims, amplitudes, waves, force)
    solving.torques(rims, amplitudes, waves, torque)
    ring = amplitudes + waves[:, : amplitudes.shape[1]]
    tension, length = liquid.surface_tension, liquid.capillary_length
    return Solution(
        forces=tension * length * force,
        torques=tension * length**2 * torque,
        heights=length * ring[:, 0].real,
        tilts=2.0 * np.stack([ring[:, 1].real, -ring[:, 1].imag], axis=1) / rims.radius[:, None],
        energy=tension * length**2 * energy,
        iterations=iterations,
        amplitudes=amplitudes,
        setting=setting,
    )


def excess_over_superposition(body: Any, charge: float, liquid: Liquid, gap: float = 0.02) -> float:
    """Excess of the attraction of two equal bodies over superposition, as a fraction of the latter.

    `charge` is the capillary charge (m) that superposition uses, `gap` the distance of the bodies over their diameter.
    The surface is linearized, as in `solve`; use the charge of the closed-form theory, since nonlinear charges differ
    also for a single body. Raises BadInput for a body without charge.

    >>> from ecume.laws.flotation import Liquid, Sphere, capillary_charge
    >>> water, ball = Liquid(998.2, 0.0728, 1e-3), Sphere(5e-3, 250.0, 1.4)
    >>> round(excess_over_superposition(ball, capillary_charge(ball, water, "closed-form"), water), 1)
    0.6
    """
    from ecume.laws.capillarity import pair_force, pair_strength

    if charge == 0.0:
        raise BadInput("a body without capillary charge has no attraction; expected one whose charge is not 0")
    apart = 2.0 * float(body.radius) * (1.0 + gap)
    attraction = float(solve([[0.0, 0.0], [apart, 0.0]], [body, body], liquid, 12).forces[0, 0])
    strength = pair_strength(liquid.surface_tension, charge, charge)
    return -attraction / pair_force(apart, strength, liquid.capillary_length) - 1.0


def height(solution: Solution, x: ArrayLike, y: ArrayLike) -> Array:
    """Height of the surface (m) at points; inside a contact line, that of the plane through it."""
    from ecume.laws.multipole.solving import echo_heights

    rims, walls, at, liquid = solution.setting
    length = liquid.capillary_length
    px, py = (np.asarray(each, float) / length for each in np.broadcast_arrays(x, y))
    total = outer_height(walls, liquid, px, py)
    echoes = echoes_of(walls, liquid, rims, at)
    if len(echoes.answer):
        points = np.stack([px.ravel(), py.ravel()], axis=1)
        total = total + echo_heights(rims, echoes, at, solution.amplitudes, points).reshape(px.shape)
    for mirror in echoes.mirrors:
        for center, a, amplitude in zip(at, rims.radius, solution.amplitudes, strict=True):
            dx, dy = px - mirror[0] * center[0] - mirror[1], py - mirror[2] * center[1] - mirror[3]
            total = total + mirror[4] * _waves_of(amplitude, a, mirror[0] * dx, mirror[2] * dy)
    for center, a, z, tilt in zip(at, rims.radius, solution.heights, solution.tilts, strict=True):
        dx, dy = px - center[0], py - center[1]
        total = np.where(np.hypot(dx, dy) < a, z / length + tilt[0] * dx + tilt[1] * dy, total)
    return length * total


def _waves_of(amplitudes: Waves, radius: float, dx: Array, dy: Array) -> Array:
    """The field of a body at given distances from its center: A_m K_m(r)/K_m(a) e^{imφ} over m of both signs."""
    from scipy.special import kve

    r, angle = np.maximum(np.hypot(dx, dy), radius), np.arctan2(dy, dx)
    total = np.zeros_like(r)
    for m, amplitude in enumerate(amplitudes):
        share = kve(m, r) / kve(m, radius) * np.exp(radius - r)
        total += (1.0 if m == 0 else 2.0) * share * (amplitude * np.exp(1j * m * angle)).real
    return total


def chosen_method(method: str, unknowns: int) -> bool:
    """Whether the system is solved by elimination."""
    if method not in ("auto", "dense", "iterative"):
        raise BadInput(f"got method {method!r}; expected auto, dense or iterative")
    return method == "dense" or (method == "auto" and unknowns <= DENSE)


def _places(positions: ArrayLike, bodies: Sequence[Any]) -> Array:
    try:
        places = np.asarray(positions, dtype=np.float64)
    except (TypeError, ValueError):
        raise BadInput("positions: expected numbers (x, y) for each body, in meters") from None
    if places.shape != (len(bodies), 2) or len(bodies) == 0:
        raise BadInput(
            f"positions have the shape {places.shape}; expected one place (x, y) for each of {len(bodies)} bodies"
        )
    if not np.isfinite(places).all():
        raise BadInput("positions contain NaN or infinity; expected finite numbers, in meters")
    return places


def _whole(order: int) -> int:
    if not (isinstance(order, Integral) and 1 <= order <= MOST_ORDER):
        raise BadInput(f"the order is {order!r}; expected a whole number from 1 to {MOST_ORDER}")
    return int(order)


def _require_apart(at: Array, radius: Array, length: float) -> None:
    """Raise BadInput if bodies overlap; they may touch."""
    for i in range(len(at) - 1):
        gaps = np.hypot(*(at[i + 1 :] - at[i]).T) - radius[i] - radius[i + 1 :]
        worst = int(np.argmin(gaps))
        if gaps[worst] < -ROUNDING * radius[i]:
            overlap = with_prefix(-gaps[worst] * length, "m", 3)
            raise BadInput(f"bodies {i} and {i + 1 + worst} overlap by {overlap}; move them apart")
