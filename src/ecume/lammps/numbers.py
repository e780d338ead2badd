"""The numbers of a deck: kinds of floats, contacts as springs and dashpots, time step, the first state, and pair laws.

Pair laws are tables of distance, energy and force, dense enough for the stated accuracy.

The walls of a dish in LAMMPS: the region of each shape, and the formula of each meniscus.

`REGIONS` is keyed by the shape of the dish, `MENISCI` by the compiled law of the walls. To add a shape or a law, add a
row.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from scipy.interpolate import CubicSpline

from ecume.engine.cells import Integers
from ecume.lammps.expressible import shape_of
from ecume.laws.special import scaled_bessel_i1
from ecume.models.floating.contacts import contact_models
from ecume.models.floating.contacts.collisions import float_inertia
from ecume.models.floating.contacts.springs import Springs
from ecume.models.floating.dishes import DISH, NO_WALL_LAW, PLANE
from ecume.models.floating.forces.pair_forces import law_of, row_of, two_floats
from ecume.models.floating.parameters import CAPILLARY_LENGTH, PairParameters, Parameters, State
from ecume.models.floating.setup.initial_state import start
from ecume.models.floating.setup.kinds import FloatKind, distinct_kinds, turning_friction_of
from ecume.models.floating.setup.scene_parameters import parameters_of
from ecume.models.step_counts import last_step
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene

DRAG_STEP = 0.1
"""The longest time step over the shortest relaxation time: LAMMPS applies drag as an explicit force."""

ROLLING = 2.0 / 7.0
"""Tangential over normal stiffness and damping: the reduced mass at the surface of a homogeneous sphere is 2/7 of that
of its center, and this stiffness lets a sticking contact rebound along the surface within the time of the normal one.
"""


class Contacts(NamedTuple):
    """Contacts as springs and dashpots."""

    stiffness: float
    """N/m"""
    among: float
    """the number e* of `damping coeff_restitution` between floats"""
    at_walls: float
    """the same at walls"""
    friction: tuple[float, float]
    """Coulomb's coefficients between floats and at walls"""


class Turning(NamedTuple):
    """Rotation of floats by friction."""

    friction: list[float]
    """N m s, of each kind"""
    shortest_time: float
    """s: the shortest time in which the liquid slows a spin"""


class DeckNumbers(NamedTuple):
    """All that a deck says about a scene."""

    scene: FloatingScene
    parameters: Parameters
    """with springs and dashpots, and the time step that they need"""
    state: State
    kinds: list[FloatKind]
    kind: Integers
    """(N,) the kind of each float, from 0"""
    first: Integers
    """the first float of each kind: its properties are those of the kind"""
    contacts: Contacts | None
    turning: Turning | None
    time_step: float
    steps: int
    steps_per_frame: int


class TurningSprings(NamedTuple):
    """`Springs` with friction, which LAMMPS computes."""

    stiffness: float
    damping: float
    wall_damping: float
    inertia: Array
    """(N,) kg m^2"""


contact_models.BY_CONSTANTS[TurningSprings] = dataclasses.replace(
    contact_models.CONTACTS["spring-dashpot"],
    constants=TurningSprings, inertia=lambda part: np.asarray(part.inertia), gives=frozenset(),
)  # fmt: skip


def parameters_for(scene: FloatingScene) -> Parameters:
    """The parameters of the deck of a scene that a deck can express, with its time step. Raises SceneError."""
    parameters = parameters_of(with_springs(scene))
    kinds, kind = distinct_kinds(scene)
    per_frame = _steps_per_frame(scene, parameters, _turning(scene, kinds))
    springs = parameters.parts.contacts
    if scene.rubs and isinstance(springs, Springs):
        inertia = np.array([float_inertia(each) for each in kinds])[kind]
        parameters = parameters._replace(parts=parameters.parts._replace(contacts=TurningSprings(*springs, inertia)))
    return parameters._replace(time_step=scene.frame_every / per_frame, steps_per_frame=per_frame)


def numbers_of(scene: FloatingScene, parameters: Parameters | None = None, state: State | None = None) -> DeckNumbers:
    """The numbers of a deck that begins with a state; default: that of the scene. Raises SceneError."""
    parameters = parameters_for(scene) if parameters is None else parameters
    kinds, kind = distinct_kinds(scene)
    return DeckNumbers(
        scene=scene,
        parameters=parameters,
        state=start(scene, parameters) if state is None else state,
        kinds=kinds,
        kind=kind,
        first=np.unique(kind, return_index=True)[1].astype(np.int64),
        contacts=_contacts(scene, parameters),
        turning=_turning(scene, kinds),
        time_step=parameters.time_step,
        steps=last_step(scene, parameters.steps_per_frame),
        steps_per_frame=parameters.steps_per_frame,
    )


def with_springs(scene: FloatingScene) -> FloatingScene:
    """The scene with springs and dashpots in place of rigid contacts, and with the integrator of LAMMPS."""
    law = "none" if scene.contacts.law == "none" else "spring-dashpot"
    slow = scene.integration.integrator == "overdamped"
    return dataclasses.replace(
        scene,
        contacts=dataclasses.replace(scene.contacts, law=law, friction=0.0),
        dish=None if scene.dish is None else dataclasses.replace(scene.dish, friction=0.0),
        integration=dataclasses.replace(
            scene.integration, integrator="overdamped" if slow else "velocity-verlet", time_step=None
        ),
        interaction=dataclasses.replace(scene.interaction, summation="cells", precision="double"),
    )


def _contacts(scene: FloatingScene, parameters: Parameters) -> Contacts | None:
    """The springs and dashpots of the scene; None without contacts."""
    springs = parameters.parts.contacts
    if not isinstance(springs, Springs | TurningSprings):
        return None
    rubbing = scene.contacts.friction, scene.dish.friction if scene.dish is not None else 0.0
    return Contacts(springs.stiffness, nominal(springs.damping), nominal(springs.wall_damping), rubbing)


def nominal(damping: float) -> float:
    """The number e* = exp(-pi zeta/sqrt(1 - zeta^2)) with which LAMMPS gets the damping zeta over the critical one.

    It is the restitution of a contact that ends when the overlap does. Contacts of the deck end when their force does
    (`limit_damping`), with a larger restitution: `ecume.laws.friction.dashpot_restitution`.

    >>> nominal(0.0), round(nominal(0.5), 6)
    (1.0, 0.163034)
    """
    return math.exp(-math.pi * damping / math.sqrt(1.0 - damping * damping))


def _turning(scene: FloatingScene, kinds: list[FloatKind]) -> Turning | None:
    """The drag on spins; None if no float turns."""
    if not scene.rubs:
        return None
    friction = [turning_friction_of(kind, scene) for kind in kinds]
    times = [float_inertia(kind) / each for kind, each in zip(kinds, friction, strict=True) if each > 0.0]
    return Turning(friction, min(times, default=math.inf))


def _steps_per_frame(scene: FloatingScene, parameters: Parameters, turning: Turning | None) -> int:
    """Steps from frame to frame, short enough for springs and for explicit drag."""
    if not parameters.scheme.inertia:
        return parameters.steps_per_frame
    shortest_time = min(float(parameters.floats.relaxation_time.min()), turning.shortest_time if turning else math.inf)
    longest = min(parameters.time_step, DRAG_STEP * shortest_time)
    times = math.ceil(parameters.time_step / longest * (1.0 - 1e-9))
    return times * parameters.steps_per_frame


ACCURACY = 1e-7
"""Error of the force of a table over the force at the same distance."""

OVERLAP = 0.1
"""Overlap over the sum of two radii at which tables begin. LAMMPS stops at shorter distances."""

BEYOND = 1.1
"""The end of the tables over the cutoff: LAMMPS estimates the slopes at the ends, with an effect on a few rows."""

FEWEST, MOST = 250, 64_000
"""Rows of a table."""

PER_NEAREST = 100
"""Values of a table in memory from r^2 = 0 to that of the nearest pair: LAMMPS's spline between them errs by 1e-8."""

MOST_VALUES = 100_000
"""Values of a table in memory. Wider tables than these resolve are spaced by octaves."""

BITS_PER_OCTAVE = 11
"""LAMMPS interpolates linearly between 2^11 values from one r^2 to twice of it, with an error below 1e-7."""


class PairTable(NamedTuple):
    """The table of two kinds of floats."""

    kinds: tuple[int, int]
    name: str
    distance: Array
    energy: Array
    force: Array
    """N, positive if it repels"""


def lookup_of(parameters: Parameters) -> str:
    """How LAMMPS keeps the tables: a spline over r^2, or by the bits of r^2 where the widest table spans too much."""
    nearest = 2.0 * (1.0 - OVERLAP) * float(parameters.floats.radius.min())
    ratio = (BEYOND * max(parameters.cutoff, nearest) / nearest) ** 2
    if PER_NEAREST * ratio <= MOST_VALUES:
        return f"spline {math.ceil(PER_NEAREST * ratio)}"
    return f"bitmap {BITS_PER_OCTAVE + math.ceil(math.log2(math.log2(ratio))) + 1}"


def pair_tables(deck: DeckNumbers) -> Iterator[PairTable]:
    """A table for each pair of kinds; none if the pair law has no force."""
    if not row_of(deck.parameters).has_force:
        return
    for i, j in itertools.combinations_with_replacement(range(len(deck.kinds)), 2):
        yield pair_table(deck, i, j)


def pair_table(deck: DeckNumbers, i: int, j: int) -> PairTable:
    """The table of two kinds, at distances that are evenly spaced in their logarithm."""
    count = FEWEST
    while True:
        nodes = _nodes(deck, i, j, count)
        force = _forces(deck, i, j, nodes)
        between = np.sqrt(nodes[1:] * nodes[:-1])
        exact = _forces(deck, i, j, between)
        error = np.abs(CubicSpline(nodes, force)(between) - exact)
        used = (between > (1.0 - 0.5 * OVERLAP) / (1.0 - OVERLAP) * nodes[0]) & (between <= deck.parameters.cutoff)
        if count >= MOST or np.all(error[used] <= 0.5 * ACCURACY * np.abs(exact[used])):
            return PairTable((i, j), f"K{i + 1}_K{j + 1}", nodes, _energies(deck, i, j, nodes, force), force)
        count *= 2


def _nodes(deck: DeckNumbers, i: int, j: int, count: int) -> Array:
    radius = deck.parameters.floats.radius[deck.first]
    near = (1.0 - OVERLAP) * float(radius[i] + radius[j])
    return np.geomspace(near, BEYOND * max(deck.parameters.cutoff, near), count)


def _forces(deck: DeckNumbers, i: int, j: int, distance: Array) -> Array:
    """The law of the scene at these distances."""
    row, law, own = row_of(deck.parameters), law_of(deck.parameters), _two(deck, i, j)
    return np.array([float(row.force(each, own, law)) for each in distance.tolist()])


def _energies(deck: DeckNumbers, i: int, j: int, distance: Array, force: Array) -> Array:
    """The energy of the law, zero at the cutoff; the integral of the force if the law has none."""
    row, law, own, cutoff = row_of(deck.parameters), law_of(deck.parameters), _two(deck, i, j), deck.parameters.cutoff
    if row.energy is None:
        integral = CubicSpline(distance, force).antiderivative()
        return np.asarray(integral(cutoff) - integral(distance))
    at_cutoff = float(row.energy(cutoff, own, law))
    return np.array([float(row.energy(each, own, law)) - at_cutoff for each in distance.tolist()])


def _two(deck: DeckNumbers, i: int, j: int) -> PairParameters:
    floats, (a, b) = deck.parameters.floats, deck.first[[i, j]]
    radius, charge = floats.radius.tolist(), floats.charge.tolist()
    return two_floats(deck.parameters, (radius[a], radius[b]), (charge[a], charge[b]))


def text_of(table: PairTable) -> str:
    """The section of a table in a file of LAMMPS."""
    columns = zip(table.distance.tolist(), table.energy.tolist(), table.force.tolist(), strict=True)
    rows = [f"{number} {r!r} {energy!r} {force!r}" for number, (r, energy, force) in enumerate(columns, 1)]
    return "\n".join([table.name, f"N {len(rows)}", "", *rows, "", ""])


ROUNDED = 5.0
"""b of s^2 = r^2 + (b L)^2, in which the fit of the meniscus has few terms."""

ERROR = 5e-10
"""Largest relative error of the fitted meniscus of a dish."""

SHORTEST, LONGEST = 4, 20
"""Degree of the fit."""


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


class DishFit(NamedTuple):
    """(a/r) I1(r/L)/I1(a/L) = exp((s - s_a)/L) s^(-3/2) sum_j c_j k^j with k = slope/s + shift, s^2 = r^2 + (5 L)^2."""

    slope: float
    """m"""
    shift: float
    coefficients: list[float]
    """m^(3/2)"""


def _tail(z: float) -> float:
    """exp(-s) s^(3/2) I1(z)/z with s^2 = z^2 + 25, a smooth function of 1/s: I1 grows as exp(z)/sqrt(z)."""
    s = math.hypot(z, ROUNDED)
    over = 0.5 * math.exp(-z) if z < 1e-6 else float(scaled_bessel_i1(z)) / z
    return float(over * math.exp(z - s) * s**1.5)


def dish_fit(radius: float, length: float) -> DishFit:
    """The shortest fit within `ERROR`, at Chebyshev's nodes in 1/s between the wall and the center."""
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
    """`_tail` between the wall, k = -1, and the center, k = 1."""
    s = ROUNDED / (lowest + 0.5 * (1.0 - lowest) * (k + 1.0))
    z = np.sqrt(np.maximum(s * s - ROUNDED * ROUNDED, 0.0))
    return np.array([_tail(each) for each in z.tolist()])


def _round_meniscus(deck: DeckNumbers) -> Formula:
    """F = S/L I1(r/L)/I1(a/L) toward the center: see `ecume.laws.capillarity.dish_force`."""
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
    """c_0 + k (c_1 + k (...))."""
    text = repr(terms[-1])
    for term in reversed(terms[:-1]):
        text = f"{term!r}+v_meniscus_k*({text})"
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
