"""Many-body capillary forces by a common multipole solution, or by tables of pair corrections.

Multipoles: each solution starts from the amplitudes of the last one, which are part of the state.

Pair corrections: each pair of kinds has a table of the energy of two bodies beyond superposition, from their
multipole solution, and of its slopes. Between the nodes it is a cubic, whose derivative is the force. The effect of a
third body is ignored.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._jit import compiled
from ecume._portable import phase_factor
from ecume.engine.cells import Integers
from ecume.engine.contact.contacts import apart
from ecume.engine.neighbors import NeighborLists
from ecume.errors import BadInput
from ecume.laws import drag, flotation
from ecume.laws.flotation import Disc, Liquid, Sphere
from ecume.laws.meniscus import facing_amplitude, plane_amplitude
from ecume.laws.multipole.closures import Undulated, closure_of, outgoing_ladder, regular_ladder
from ecume.laws.multipole.many import Basin, images
from ecume.laws.multipole.solving import (
    Echoes,
    Krylov,
    Rims,
    Waves,
    echo_heights,
    energy,
    forces,
    incoming,
    iterate,
    make_echoes,
    make_krylov,
    make_rims,
    make_round_echoes,
    sent,
    torques,
)
from ecume.laws.special import bessel_k0, bessel_k1, scaled_bessel_i1
from ecume.models.floating.dishes import MultipoleWalls, acts, meniscus_of
from ecume.models.floating.options import Built, scene_error
from ecume.models.floating.parameters import Parameters, State, Workspace, make_state, part_of
from ecume.models.floating.setup.kinds import distinct_kinds
from ecume.models.floating.time_integration.step_size import RAFT_NEIGHBORS
from ecume.models.liquids import liquid_of
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene
    from ecume.trajectories.frame import Frame


TOLERANCE = 1e-9
"""Relative tolerance of the amplitudes in each time step."""

WAVES_PER_ORDER = 4.0
"""Orders of the response of a round wall, over (order of the bodies) times (wall radius) / (body radius)."""

MOST_WAVES = 400
TINY = 1e-200
STIFFNESS_FACTOR = 10.0
"""Stiffness of rafts of pinned discs over that of superposition, at most: their attraction is up to ten times larger.
"""


class Multipoles(NamedTuple):
    """Constants of multipoles: bodies, walls, units."""

    rims: Rims
    echoes: Echoes
    menisci: Array
    """(W, 4) of plane walls: amplitude, direction towards the wall, distance from the origin; in capillary lengths"""
    dish: float
    """amplitude of a round wall's meniscus over exp(-brim) I_1(brim); zero without one"""
    length: float
    """the capillary length, m"""
    tension: float
    """N/m"""
    inertia: Array
    """(N,) kg m^2, of floats that turn; empty if no float turns"""
    friction: Array
    """(N,) N m s, rotational friction"""
    advances_angles: bool = True
    """whether angles advance here instead of with the contacts"""


class MultipoleScratch(NamedTuple):
    """Workspace of multipoles."""

    force: Array
    """(N, 2) in units of tension times capillary length"""
    amplitudes: Waves
    """(N, order + 1) those of the state, viewed as complex numbers"""
    krylov: Krylov
    at: Array
    """(N, 2) in capillary lengths"""
    waves: Waves
    """(N, order + 2)"""
    outer: Waves
    """(N, order + 2) the part of the walls"""
    right: Waves
    torque: Array
    """(N,) N m"""
    turning: Array
    """(N, 2) that of the state"""


def make_multipoles(
    kinds: Sequence[tuple[Disc | Sphere | Undulated, float]],
    liquid: Liquid,
    order: int,
    reach: float,
    number: NDArray[np.int64] | None = None,
) -> Multipoles:
    """Return bodies with these capillary charges (m) in the far field, on an unbounded surface.

    One body of each kind, or as many as there are numbers of kinds.
    """
    length = liquid.capillary_length
    closures = []
    for body, charge in kinds:
        found = closure_of(body, liquid, order)
        source_strength = -charge / length * bessel_k0(found.radius)
        source = found.source.copy()
        source[0] = source_strength
        closures.append(found._replace(source=source))
    rims = make_rims(closures, reach / length, number)
    echoes = make_echoes(images(None, liquid), order + 1, rims.reference)
    none = np.zeros(0)
    return Multipoles(rims, echoes, np.zeros((0, 4)), 0.0, length, liquid.surface_tension, none, none)


def with_basin(multipoles: Multipoles, size: tuple[float, float], contact_angle: float, liquid: Liquid) -> Multipoles:
    """Return the multipoles between four plane walls."""
    menisci = [
        (
            facing_amplitude(side, contact_angle, liquid) / multipoles.length,
            *(sign * np.eye(2)[axis]),
            0.5 * side / multipoles.length,
        )
        for axis, side in enumerate(size)
        for sign in (-1.0, 1.0)
    ]
    mirrors = images(Basin(*size, contact_angle), liquid)
    near = np.hypot(mirrors[:, 1], mirrors[:, 3]) <= 2.0 * max(size) / multipoles.length + multipoles.rims.range
    return multipoles._replace(menisci=np.array(menisci), echoes=multipoles.echoes._replace(mirrors=mirrors[near]))


def with_dish(multipoles: Multipoles, radius: float, contact_angle: float) -> Multipoles:
    """Return the multipoles inside a round wall."""
    brim, orders = radius / multipoles.length, multipoles.rims.response.shape[1]
    waves = min(MOST_WAVES, math.ceil(WAVES_PER_ORDER * orders * brim / multipoles.rims.radius.min()))
    round_echoes = make_round_echoes(brim, waves, orders, multipoles.rims.reference, pinned=False)
    strength = plane_amplitude(contact_angle) / scaled_bessel_i1(brim)
    return multipoles._replace(dish=strength, echoes=round_echoes)


WALLS = MultipoleWalls(with_dish, with_basin)


def make_multipole_scratch(part: Multipoles, parameters: Parameters, state: State, workspace: Any) -> MultipoleScratch:
    """Return the workspace with the amplitudes and angles of the state."""
    return multipole_scratch(state.amplitudes, state.turning)


def multipole_scratch(amplitudes: Array, turning: Array) -> MultipoleScratch:
    """Return a workspace with these amplitudes and angles."""
    waves: NDArray[np.complex128] = amplitudes.view(np.complex128)
    count, orders = waves.shape
    wide = (count, orders + 1)
    return MultipoleScratch(
        np.zeros((count, 2)),
        waves,
        make_krylov(count, orders),
        np.zeros((count, 2)),
        np.zeros(wide, np.complex128),
        np.zeros(wide, np.complex128),
        np.zeros((count, orders), np.complex128),
        np.zeros(count),
        turning if turning.shape[1] else np.zeros((count, 2)),
    )


@compiled
def fill_outer(multipoles: Multipoles, at: Array, outer: Waves) -> None:
    """Fill in the menisci of the walls around each body: see `ecume.laws.multipole.many.outer_waves`."""
    rims, brim, orders = multipoles.rims, multipoles.echoes.brim, outer.shape[1]
    ladder = np.zeros(orders)
    outer[:] = 0.0
    for i in range(len(at)):
        x, y, a = at[i, 0], at[i, 1], rims.radius[i]
        # I_m(a) = exp(a) regular_m (s/2)^m/m!
        for wall in range(len(multipoles.menisci)):
            amplitude, to_x, to_y, away = multipoles.menisci[wall]
            inside, turn = amplitude * math.exp(to_x * x + to_y * y - away + a), complex(to_x, -to_y)
            phase = complex(inside, 0.0)
            for m in range(orders):
                outer[i, m] += phase * rims.regular[i, m]
                phase *= turn * 0.5 * rims.reference / (m + 1.0)
        if multipoles.dish != 0.0:
            out = math.sqrt(x * x + y * y)
            turn = complex(x / out, -y / out) if out > 0.0 else complex(1.0, 0.0)
            regular_ladder(out, brim, ladder)
            phase = complex(multipoles.dish * math.exp(out - brim + a), 0.0)
            for m in range(orders):
                outer[i, m] += phase * ladder[m] * rims.regular[i, m]
                phase *= turn * 0.25 * rims.reference * brim / ((m + 1.0) * (m + 1.0))


@compiled
def resolve(multipoles: Multipoles, position: Array, scratch: MultipoleScratch) -> int:
    """Solve for amplitudes and waves at these positions; return a negative number if the solution failed."""
    rims, orders = multipoles.rims, scratch.amplitudes.shape[1]
    for i in range(len(position)):
        scratch.at[i, 0], scratch.at[i, 1] = position[i, 0] / multipoles.length, position[i, 1] / multipoles.length
    fill_outer(multipoles, scratch.at, scratch.outer)
    for i in range(len(position)):
        angle, phase = scratch.turning[i, 0], complex(1.0, 0.0)
        turn = complex(math.cos(angle), -math.sin(angle))
        for m in range(orders):
            scratch.right[i, m] = phase * rims.source[i, m] + rims.response[i, m] * scratch.outer[i, m]
            phase *= turn
    taken = iterate(rims, multipoles.echoes, scratch.at, scratch.right, scratch.amplitudes, scratch.krylov, TOLERANCE)
    incoming(rims, multipoles.echoes, scratch.at, scratch.amplitudes, scratch.waves)
    for i in range(len(position)):
        for m in range(orders + 1):
            scratch.waves[i, m] += scratch.outer[i, m]
    return taken


@compiled
def multipole_forces(
    part: Multipoles,
    scratch: MultipoleScratch,
    parameters: Parameters,
    position: Array,
    lists: NeighborLists,
    force: Array,
) -> None:
    """Add the forces on all floats at these positions, including walls; NaN if the solution failed."""
    taken = resolve(part, position, scratch)
    forces(part.rims, scratch.amplitudes, scratch.waves, scratch.force)
    scale = part.tension * part.length if taken >= 0 else math.nan
    torques(part.rims, scratch.amplitudes, scratch.waves, scratch.torque)
    for i in range(len(force)):
        force[i, 0] += scale * scratch.force[i, 0]
        force[i, 1] += scale * scratch.force[i, 1]
        scratch.torque[i] *= scale * part.length


def multipole_energy(
    part: Multipoles, scratch: MultipoleScratch, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """The energy of all floats and walls (J), minus the energy of each isolated float."""
    fresh = make_multipole_scratch(part, parameters, state._replace(amplitudes=state.amplitudes.copy()), workspace)
    resolve(part, state.position, fresh)
    orders = fresh.amplitudes.shape[1]
    turned = part.rims.source * phase_factor(-np.arange(orders) * fresh.turning[:, :1])
    rims = part.rims._replace(source=turned)
    return part.tension * part.length**2 * energy(rims, fresh.amplitudes, fresh.waves, fresh.outer), 0.0


@compiled
def kick_multipole_spins(
    part: Multipoles, scratch: MultipoleScratch, parameters: Parameters, state: State, first: bool
) -> None:
    """Apply half a kick to the spins of floats that menisci turn; after the first half, advance the angles unless
    contacts do so.
    """
    time = parameters.time_step
    if len(part.inertia) == 0:
        return
    kick_spins_with_drag(part, scratch.torque, state.turning, 0.5 * time)
    if first and part.advances_angles:
        for i in range(len(state.turning)):
            state.turning[i, 0] += time * state.turning[i, 1]


@compiled
def kick_spins_with_drag(multipoles: Multipoles, torque: Array, turning: Array, time: float) -> None:
    """Change the spins by drag and a torque that is constant during `time`, solved exactly."""
    for i in range(len(torque)):
        rate = multipoles.friction[i] / multipoles.inertia[i] * time
        held = -math.expm1(-rate) / rate if rate > 0.0 else 1.0
        turning[i, 1] = math.exp(-rate) * turning[i, 1] + held * time * torque[i] / multipoles.inertia[i]


Kind = tuple[Disc | Sphere, float]
"""A body and its capillary charge (m)."""

NODES = 97
MOST_KINDS = 24
ORDER = 24
FARTHEST = 50.0
"""Cutoff of the two-body solutions, in capillary lengths."""


class PairTables(NamedTuple):
    """Tables for all pairs of kinds, over s = sqrt(distance/touching - 1)."""

    kind: Integers
    """(N,)"""
    touching: Array
    """(K, K) sum of the contact lines' radii (m)"""
    step: Array
    """(K, K) of s"""
    energy: Array
    """(K, K, NODES) J"""
    slope: Array
    """(K, K, NODES) dE/ds"""


def make_pair_tables(kinds: list[Kind], kind: Integers, liquid: Liquid, cutoff: float) -> PairTables:
    """Compute the tables from a solution of two bodies at every node."""
    count, length = len(kinds), liquid.capillary_length
    multipoles = make_multipoles(kinds, liquid, ORDER, cutoff)
    radius = multipoles.rims.radius * length
    touching = radius[:, None] + radius[None, :]
    step = np.sqrt(np.maximum(cutoff / touching - 1.0, 1.0)) / (NODES - 1)
    energy, slope = np.zeros((count, count, NODES)), np.zeros((count, count, NODES))
    for a in range(count):
        for b in range(a, count):
            s = step[a, b] * np.arange(NODES)
            distance = touching[a, b] * (1.0 + s * s)
            two = make_multipoles([kinds[a], kinds[b]], liquid, ORDER, FARTHEST * length)
            product = 2.0 * math.pi * kinds[a][1] * kinds[b][1] / length**2
            found = np.array([_beyond(two, product, float(apart)) for apart in distance])
            energy[a, b] = energy[b, a] = found[:, 0] - found[-1, 0]
            slope[a, b] = slope[b, a] = -found[:, 1] * 2.0 * s * touching[a, b]
    return PairTables(kind, touching, step, energy, slope)


def _beyond(multipoles: Multipoles, product: float, apart: float) -> tuple[float, float]:
    """Energy and force (positive repels) of two bodies, minus superposition: K0 and K1 times `product`."""
    from ecume.laws.multipole import solving

    x = apart / multipoles.length
    at = np.array([[0.0, 0.0], [x, 0.0]])
    amplitudes = solving.eliminate(multipoles.rims, multipoles.echoes, at, multipoles.rims.source)
    waves, force = np.zeros((2, ORDER + 2), np.complex128), np.zeros((2, 2))
    solving.receive_all(multipoles.rims, multipoles.echoes.mirrors, at, amplitudes, waves)
    solving.forces(multipoles.rims, amplitudes, waves, force)
    energy = solving.energy(multipoles.rims, amplitudes, waves, np.zeros_like(waves))
    return (
        multipoles.tension * multipoles.length**2 * (energy + product * bessel_k0(x)),
        multipoles.tension * multipoles.length * (float(force[1, 0]) + product * bessel_k1(x)),
    )


@compiled
def correction(tables: PairTables, i: int, j: int, distance: float) -> tuple[float, float]:
    """Energy and force (positive repels) beyond superposition; zero beyond the table, linear below it."""
    a, b = tables.kind[i], tables.kind[j]
    touching, step = tables.touching[a, b], tables.step[a, b]
    s = math.sqrt(max(distance / touching - 1.0, 0.0))
    place = s / step
    if place >= NODES - 1:
        return 0.0, 0.0
    energy, slope = tables.energy[a, b], tables.slope[a, b]
    node = int(place)
    t, low, high = place - node, energy[node], energy[node + 1]
    left, right = step * slope[node], step * slope[node + 1]
    bend, twist = 3.0 * (high - low) - 2.0 * left - right, 2.0 * (low - high) + left + right
    value = low + t * (left + t * (bend + t * twist))
    # dE/ds over s, which is finite at contact
    rising = left + t * (2.0 * bend + 3.0 * t * twist)
    change = rising / (step * s) if s > 1e-9 else 2.0 * bend / (step * step)
    repelled = -change / (2.0 * touching)
    return value - repelled * min(distance - touching, 0.0), repelled


@compiled
def add_corrections(tables: PairTables, position: Array, lists: NeighborLists, force: Array) -> float:
    """Add the corrections of all listed pairs to the forces; return their energy (J)."""
    order, first, neighbor = lists.cells.order, lists.rows.first, lists.rows.neighbor
    total, periods = 0.0, lists.rows.periods
    for slot in range(len(order)):
        i = order[slot]
        for place in range(first[slot], first[slot + 1]):
            j = order[neighbor[place]]
            x, y = apart(position, i, j, periods)
            distance = math.sqrt(x * x + y * y)
            energy, repelled = correction(tables, i, j, distance)
            force[i, 0] -= repelled * x / distance
            force[i, 1] -= repelled * y / distance
            total += 0.5 * energy
    return total


@compiled
def correction_forces(
    part: PairTables, scratch: Any, parameters: Parameters, position: Array, lists: NeighborLists, force: Array
) -> None:
    """Add the corrections of all pairs to the forces."""
    add_corrections(part, position, lists, force)


def correction_energy(
    part: PairTables, scratch: Any, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """The energy of the corrections (J)."""
    return float(add_corrections(part, state.position, workspace.lists, np.zeros_like(state.position))), 0.0


Bodies = list[tuple[Any, float]]


def multipoles_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """Return the multipoles of all floats."""
    kinds, number = distinct_kinds(scene)
    dish, bodies, liquid = scene.dish, bodies_and_charges(kinds), liquid_of(scene)
    found = _made(lambda: make_multipoles(bodies, liquid, scene.interaction.order, parameters.cutoff, number))
    if dish is not None and acts(parameters):
        between = meniscus_of(dish).multipoles
        assert between is not None  # noqa: S101  # the option `wall` requires it
        found = between(WALLS, found, dish, liquid)
    polarized = time_of_polarization(found, parameters)
    if not any(kind.rim[1] > 0.0 for kind in kinds):
        return Built(found, polarized, _stiffness_factor(bodies))
    moment, friction, turning = _turning(parameters, scene, [kinds[k] for k in number])
    turned = found._replace(inertia=moment, friction=friction, advances_angles=not scene.rubs)
    return Built(turned, min(polarized, turning), _stiffness_factor(bodies))


def time_of_polarization(multipoles: Multipoles, parameters: Parameters) -> float:
    """The shortest time scale (s) of touching floats at a wall, whose meniscus polarizes them.

    In a slope s a rim deforms the surface by T s a^2 cos(phi)/r, as a dipole. At the distance l = 2 a the energy of two
    of them, up to 2 pi gamma (T s a^2/l)^2, is a spring of stiffness 12 pi gamma (T s)^2/16. Higher modes are those of
    an undulated rim: see `_turning`. Small discs without mass have T = 1, level ones -1, righted ones and spheres
    nearly 0.
    """
    floats, slope = parameters.floats, steepest_modes(multipoles)
    if not np.any(slope):
        return math.inf
    # A spring of a wall far away may underflow.
    spring = np.maximum(RAFT_NEIGHBORS * 12.0 * math.pi * multipoles.tension * slope**2, TINY)
    times = floats.mass / floats.relaxation_time / spring
    if parameters.scheme.inertia:
        times = np.maximum(times, np.sqrt(floats.mass / spring))
    return float(times.min())


def steepest_modes(multipoles: Multipoles) -> Array:
    """The steepest mode (N,) by which each rim answers the meniscus where it touches a wall: m |T_m c_m|/a for m > 1,
    and |T_1 c_1|/(sqrt(2) a) of the dipole.
    """
    rims = multipoles.rims
    outer = np.zeros((len(rims.radius), rims.response.shape[1] + 1), np.complex128)
    found = np.zeros(len(rims.radius))
    orders = np.arange(1.0, rims.response.shape[1])
    weight = np.where(orders > 1.0, orders, math.sqrt(0.5))
    for place in _touching_places(multipoles):
        fill_outer(multipoles, place, outer)
        modes = weight * np.abs(rims.response[:, 1:] * outer[:, 1:-1]) / rims.radius[:, None]
        found = np.maximum(found, modes.max(axis=1, initial=0.0))
    return found


def _touching_places(multipoles: Multipoles) -> list[Array]:
    """The places (N, 2) in capillary lengths at which floats touch a wall with a meniscus: one of each plane wall, and
    one of a round wall.
    """
    radius = multipoles.rims.radius
    places = [(wall[3] - radius)[:, None] * wall[1:3] for wall in multipoles.menisci]
    if multipoles.dish != 0.0:
        places.append((multipoles.echoes.brim - radius)[:, None] * np.array([1.0, 0.0]))
    return places


def _turning(parameters: Parameters, scene: FloatingScene, every: Sequence[Any]) -> tuple[Any, Any, float]:
    """The moments of inertia m a^2/2, the rotational friction, and the shortest time scale (s) of floats that turn.

    For a rim of height H, a touching neighbor acts as a spring of stiffness 12 pi gamma (m H/2)^2 against rotation, and
    of this over a^2 against displacement. This is four times the law of quadrupoles at l = 2 a: of a disc with its six
    neighbors the stiffest rotation is exactly 1.8 (m = 2), 11.5 (m = 3) and 4.7 (m = 4) times that law.
    """
    liquid = liquid_of(scene)
    mass, radius = parameters.floats.mass, parameters.floats.radius
    viscosity = liquid.viscosity_of_both if scene.hydrodynamics.resists else 0.0
    resisting = [drag.disc_turning_friction(float(a), viscosity) for a in radius]
    moment, friction = 0.5 * mass * radius**2, np.array(resisting)
    height = max(kind.rim[0] * kind.rim[1] for kind in every)
    spring = RAFT_NEIGHBORS * 12.0 * math.pi * liquid.surface_tension * (0.5 * height) ** 2
    turning = np.maximum(np.sqrt(moment / spring), friction / spring)
    shifting = np.sqrt(mass / spring) * radius
    return moment, friction, float(min(turning.min(), shifting.min()))


def corrections_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """The tables of pair corrections. Raises SceneError for too many kinds of floats."""
    kinds, number = distinct_kinds(scene)
    if len(kinds) > MOST_KINDS:
        raise scene_error(
            "interaction.method",
            f"'pair-corrected' needs a table for each pair of kinds, and there are {len(kinds)} of them, more than "
            f"{MOST_KINDS}; use 'multipole' or 'superposition'",
        )
    bodies = bodies_and_charges(kinds)
    tables = _made(lambda: make_pair_tables(bodies, number, liquid_of(scene), parameters.cutoff))
    return Built(tables, stiffness_factor=_stiffness_factor(bodies))


def bodies_and_charges(kinds: Sequence[Any]) -> Bodies:
    """The bodies of these kinds, with their capillary charges (m)."""
    return [
        (Undulated(kind.body, ((*kind.rim, 0.0),)) if kind.rim[1] > 0.0 else kind.body, kind.charge) for kind in kinds
    ]


def _made(make: Callable[[], Any]) -> Any:
    try:
        return make()
    except BadInput as error:
        raise scene_error("interaction.method", str(error)) from None


def _stiffness_factor(bodies: Bodies) -> float:
    discs = [body.disc if isinstance(body, Undulated) else body for body, _ in bodies]
    pinned = any(isinstance(disc, flotation.Disc) and disc.tilting for disc in discs)
    return STIFFNESS_FACTOR if pinned else 2.0


def multipoles_in(parameters: Parameters) -> Multipoles:
    """The multipoles of the parameters."""
    multipoles: Multipoles = part_of(parameters, Multipoles)
    return multipoles


def solved(parameters: Parameters, frame: Frame) -> MultipoleScratch:
    """The multipoles of the floats in a frame, solved again because frames do not contain them."""
    multipoles = multipoles_in(parameters)
    count, orders = multipoles.rims.response.shape
    angle = frame.arrays.get("angle", np.zeros(count))
    turning = np.stack([angle, np.zeros(count)], axis=1)
    position = np.ascontiguousarray(frame.arrays["position"])
    state = make_state(position, np.zeros((count, 2)))
    state = state._replace(amplitudes=np.zeros((count, 2 * orders)), turning=turning)
    scratch = make_multipole_scratch(multipoles, parameters, state, None)
    resolve(multipoles, position, scratch)
    return scratch


def heights_at(multipoles: Multipoles, scratch: MultipoleScratch, points: Array) -> Array:
    """The heights (P,) in m at `points` (P, 2) in m: the deformation by the floats, including the response of the
    walls, without the menisci of the walls; it is constant inside the contact line of a float.
    """
    places = points / multipoles.length
    heights = np.zeros(len(points))
    add_waves(multipoles.rims, multipoles.echoes.mirrors, scratch.at, scratch.amplitudes, places, heights)
    if len(multipoles.echoes.answer):
        heights += echo_heights(multipoles.rims, multipoles.echoes, scratch.at, scratch.amplitudes, places)
    return np.asarray(multipoles.length * heights)


def bends(multipoles: Multipoles, scratch: MultipoleScratch) -> Array:
    """The deformation (N,) in m of the surface by each float alone, as the root mean square around its edge."""
    squares = np.abs(scratch.amplitudes) ** 2
    return np.asarray(multipoles.length * np.sqrt(squares[:, 0] + 2.0 * squares[:, 1:].sum(axis=1)))


@compiled
def add_waves(rims: Rims, mirrors: Array, at: Array, amplitudes: Waves, places: Array, heights: Array) -> None:
    """Add the sum over bodies and images of A_m K_m(r)/K_m(a) exp(i m phi), for m and -m, in capillary lengths; inside
    a contact line the value at the contact line applies.
    """
    orders = amplitudes.shape[1]
    ladder, turned = np.zeros(orders), np.zeros(orders, np.complex128)
    for t in range(len(mirrors)):
        mirror = mirrors[t]
        for j in range(len(at)):
            sent(amplitudes[j], mirror, turned)
            a = rims.radius[j]
            for k in range(len(places)):
                x = places[k, 0] - mirror[0] * at[j, 0] - mirror[1]
                y = places[k, 1] - mirror[2] * at[j, 1] - mirror[3]
                distance = math.sqrt(x * x + y * y)
                if distance - a > rims.range:
                    continue
                turn = complex(x / distance, y / distance) if distance > 0.0 else complex(1.0, 0.0)
                out = max(distance, a)
                outgoing_ladder(out, rims.reference, ladder)
                own, phase = turned[0].real * rims.inverse[j, 0] * ladder[0], turn
                for m in range(1, orders):
                    own += 2.0 * (turned[m] * phase).real * rims.inverse[j, m] * ladder[m]
                    phase *= turn
                heights[k] += math.exp(a - out) * own
