"""Parameters, state and workspace of the floating model.

The state is what the physics changes. Operations on rows of vectors are here as well.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine import neighbors
from ecume.engine.cells import Integers
from ecume.engine.contact import contacts
from ecume.engine.walls import Walls
from ecume.laws.pair_laws import PairParameters
from ecume.units import Array

__all__ = ["PairParameters"]


class Floats(NamedTuple):
    """Properties of the floats, all (N,)."""

    radius: Array
    mass: Array
    charge: Array
    """m: the amplitude of the far field"""
    relaxation_time: Array
    """s: mass over friction; infinite without drag"""
    density: Array
    contact_angle: Array
    species: Integers


class Scheme(NamedTuple):
    """The order of kicks, drift and contacts in a time step. Compiled code reads these fields, so that all schemes with
    kicks share one compilation.
    """

    half_kicks: bool
    """half a kick before the drift and half a kick after it, as in velocity Verlet; otherwise one whole kick"""
    inertia: bool
    """false if velocities follow from forces and drag alone"""
    drifts_first: bool
    """the drift uses the velocity before the kick, as in the explicit Euler scheme"""
    contacts_at_end: bool
    """contacts are solved a second time, on the velocity at the end of the step"""
    forces_at_end: bool
    """forces are evaluated at the end of each step"""
    drags_along: bool = True
    """a current acts as a force, its drag; otherwise the integrator adds it to the velocities"""


class Kick(NamedTuple):
    """One kick of the scheme, with exact drag for a constant force: v = decay v + gain F."""

    decay: Array
    gain: Array
    mobility: Array
    """(N + walls,) velocity per impulse over the kick: gain / time, 1/m without drag; zero for walls"""


DRAG_LAWS = ("stokes", "schiller-naumann")


class Sway(NamedTuple):
    """Motion of the dish, which is the frame of reference of the floats."""

    moves: bool
    velocity: Array
    """(2,) m/s, constant"""
    amplitude: Array
    """(2,) m, of the oscillation"""
    turning: float
    """rad/s, of the oscillation"""
    slip: float
    """the fraction of its motion that the liquid does not follow"""


class Drift(NamedTuple):
    """Flow of the surface, thermal noise and motion of the dish."""

    flow: Array
    """(6,) u_x, u_y at the origin (m/s), then du_x/dx, du_x/dy, du_y/dx, du_y/dy (1/s)"""
    nodes: Array
    """(2, X, Y) m/s: a flow at nodes, in addition; (2, 0, 0) without one"""
    frame: Array
    """(4,) of the nodes: the least x and y (m), then nodes for each meter along x and y"""
    flows: bool
    thermal: float
    """J: kT"""
    seed: int
    thickness: float
    """s/m^2: density over viscosity of the liquid if the drag depends on the speed; zero for Stokes drag"""
    jump: float
    """m: the longest displacement of a float in one step by noise (all but one in a billion) and by the dish"""
    sway: Sway
    active: bool = False
    """whether floats have active forces, or forces by waves or a magnetic field"""


class VaryingDrift(NamedTuple):
    """A drift with velocities from a file. It is a separate type, so that other scenes do not compile its functions."""

    flow: Array
    nodes: Array
    frame: Array
    flows: bool
    thermal: float
    seed: int
    thickness: float
    jump: float
    sway: Sway
    active: bool
    table: Any
    """of a type of `gridded_flows.GRIDDED_VELOCITIES`"""


class Parameters(NamedTuple):
    """The parameters of a scene: see `ecume.models.model`."""

    time_step: float
    steps_per_frame: int
    scheme: Scheme
    floats: Floats
    kick: Kick
    pair_law: int
    """the index of the row in `ecume.laws.pair_laws.PAIR_LAWS`"""
    pair: Array
    """constants of the pair law, packed: see `pack_pair`"""
    cutoff: float
    skin: float
    """m: of neighbor lists, for floats as fast as the time step expects; see `State.skin`"""
    reach: float
    """range of the neighbor lists: the cutoff or the widest touching pair, plus the skin"""
    walls: Walls
    wall_law: int
    """see `dishes.wall_law_of`"""
    wall_strength: Array
    """(walls, N) J"""
    wall_table: Array
    """see `dishes.heights_and_images`; empty if there are formulas"""
    image_strength: float
    """N: 2 pi gamma, if walls mirror menisci"""
    restitution: float
    wall_restitution: float
    slop: float
    """m: overlaps up to this value are tolerated"""
    drift: Drift
    shortest_time: float = math.inf
    """s: the shortest time scale of the parts, which limits the time step beside the pair law"""
    stiffness_factor: float = 1.0
    """the stiffness of the parts over that of superposition, at most"""
    raft_mobility: float = 1.0
    """the speed of a raft of all floats over that of a single one under the same force per float, at most"""
    single: bool = False
    """whether pair forces are computed in single precision"""
    periods: Array = np.zeros((2, 2))
    """of the cell: see `ecume.engine.cells`; zero without a cell"""
    passing: bool = False
    """whether floats pass through one another; the walls of a dish stop them all the same"""
    parts: Any = ()
    """the `Parts` of the model, whose types select compiled code; empty in the parameters that compiled code gets"""


class Parts(NamedTuple):
    """The selected rows of the tables of the model: each part is a NamedTuple of constants, whose type selects the
    functions that are compiled.
    """

    integrator: Any
    """of `integrators.INTEGRATORS`"""
    interactions: tuple[Any, ...]
    """of `interactions.INTERACTIONS`; their forces are added up in this order"""
    resistances: tuple[Any, ...]
    """of `interactions.RESISTANCES`: they slow velocities after a kick"""
    contacts: Any
    """of `contact_models.CONTACTS`"""


class Scratch(NamedTuple):
    """The workspaces of the parts."""

    integrator: Any
    interactions: tuple[Any, ...]
    resistances: tuple[Any, ...]
    contacts: Any


class ClockedScratch(NamedTuple):
    """The workspaces of the parts where forces depend on the time: a separate type, so that other scenes compile no
    clock.
    """

    integrator: Any
    interactions: tuple[Any, ...]
    resistances: tuple[Any, ...]
    contacts: Any
    clock: Array
    """(1,) s: the time at which forces are evaluated"""


def part_of(parameters: Parameters, constants: type) -> Any:
    """The part of this type among the interactions, or None."""
    return next((part for part in parameters.parts.interactions if isinstance(part, constants)), None)


STRENGTH, CAPILLARY_LENGTH, CUTOFF, SURFACE_TENSION, INVERSE_SQUARE, OWN = range(6)


def distinct_rows(*columns: Array) -> Array:
    """The distinct rows of some columns (kinds, columns), in ascending order. Equal floats are adjacent, which makes
    this fast for millions of floats.

    >>> distinct_rows(np.array([2.0, 2.0, 1.0, 2.0]), np.array([5.0, 5.0, 5.0, 5.0])).tolist()
    [[1.0, 5.0], [2.0, 5.0]]
    """
    rows = np.stack(columns, axis=1)
    first = np.ones(len(rows), dtype=bool)
    first[1:] = (rows[1:] != rows[:-1]).any(axis=1)
    return np.asarray(np.unique(rows[first], axis=0))


def pack_pair(strength: float, capillary_length: float, cutoff: float, surface_tension: float, own: Any) -> Array:
    """The constants of pairs as one array: those that do not depend on the pair law, then the constants of the law."""
    # The inverse square is precomputed, since a literal in the loop would be in double precision.
    return np.array([strength, capillary_length, cutoff, surface_tension, capillary_length**-2, *own])


COLLISIONS, SWEEPS, UNCONVERGED, DEEPEST, WORK = range(5)
"""Indices of `State.tally`."""
PUSHES = WORK + 1
"""Behind them, in dishes with a barrier, the impulse of contacts on each wall in this step (N s): see `forces.barrier`.
"""


class State(NamedTuple):
    """All data that affect later bits."""

    position: Array
    """(N, 2) m"""
    velocity: Array
    """(N, 2) m/s"""
    step: Integers
    """(1,)"""
    reference: Array
    """(N, 2) the positions at which the neighbor lists were made: they determine the order of sums"""
    touches: Integers
    """(1,) number of stored contacts"""
    touching: Integers
    """(4 N + 16, 2) the stored contacts (i, j); wall number k is N + k"""
    contact_impulse: Array
    """(4 N + 16,) impulses of these contacts, from which the next solve starts"""
    friction_impulse: Array
    """(4 N + 16,) tangential impulses, and as many of rolling friction behind them; (0,) without friction"""
    amplitudes: Array
    """(N, 2 (order + 1)) real and imaginary parts of the multipoles, from which the next solution starts; (N, 0)
    without multipoles
    """
    turning: Array
    """(N, 2) angle (rad) and spin (rad/s) of floats that turn; (N, 0) if no float turns"""
    tally: Array
    """collisions, contact sweeps, steps whose contacts did not converge, deepest overlap so far (m), and the work
    done from outside (J)"""
    skin: Array = np.zeros(1)
    """(1,) m: the skin of the neighbor lists, if wider than that of the parameters"""
    active: Array = np.zeros((0, 3))
    """(N, 3) the random force on each active float along x and y, over its root mean square, and the heading (rad);
    (0, 3) without activity"""


class SurfactantState(NamedTuple):
    """The state with a surfactant at the surface: a separate type, so that other scenes compile no code for it."""

    position: Array
    velocity: Array
    step: Integers
    reference: Array
    touches: Integers
    touching: Integers
    contact_impulse: Array
    friction_impulse: Array
    amplitudes: Array
    turning: Array
    tally: Array
    skin: Array
    active: Array
    concentration: Array
    """(X, Y) kg/m^2, on the grid of the surfactant"""
    surfactant: Array
    """(6,) masses and energies since the start: see `forces.surfactant`"""


def compiled_state(state: State) -> State:
    """The part of a state that is passed to compiled code, with the same arrays."""
    return State._make(state[: len(State._fields)])


@compiled
def memory_of(state: State) -> contacts.Memory:
    """Return the impulses of the previous step."""
    return contacts.Memory(state.touches, state.touching, state.contact_impulse)


class Workspace(NamedTuple):
    """Scratch memory; a new one gives the same results."""

    lists: neighbors.NeighborLists
    candidates: contacts.Candidates
    contacts: Any
    """rows of a type of `impulse_solvers.ROWS`"""
    force: Array
    """(N, 2) N, at the current positions"""
    torque: Array
    """(N,) N m, on floats with a shape"""
    midstep_velocity: Array
    """(N + walls, 2) m/s: displacement over time step; zero for walls. (N + walls, 3) with spins (rad/s) of bodies"""
    before: Array
    """of the same shape: the midstep velocity before contacts"""
    restitution: Array
    """(N,) the restitution of each float in a collision"""
    stages: Array
    """(5, N, 2) of the Runge-Kutta scheme; see also `DRIVEN` and `PUSHED`"""
    travel: Array
    """(1,) m: the longest possible displacement in this step"""
    ready: Integers
    """(1,) whether `force` is valid at the current positions"""
    scratch: Any = ()
    """the `Scratch` of the parts; empty in the workspace that compiled code gets"""


def is_driven(parameters: Parameters) -> bool:
    """Whether external forces do work on the floats."""
    drift = parameters.drift
    return bool(drift.flows or drift.sway.moves or drift.thermal > 0.0 or drift.active)


def is_diffusing(parameters: Parameters) -> bool:
    """Whether thermal noise moves floats that have no inertia."""
    return bool(parameters.drift.thermal > 0.0 and not parameters.scheme.inertia)


def is_langevin(parameters: Parameters) -> bool:
    """Whether floats have inertia and thermal noise: drag then acts together with the noise, not in the kicks."""
    return bool(parameters.drift.thermal > 0.0 and parameters.scheme.inertia)


def make_state(position: Array, velocity: Array) -> State:
    """Return a state at time 0; parts may replace the empty arrays."""
    count = len(position)
    return State(
        position=np.array(position, dtype=np.float64),
        velocity=np.array(velocity, dtype=np.float64),
        step=np.zeros(1, np.int64),
        reference=np.array(position, dtype=np.float64),
        touches=np.zeros(1, np.int64),
        touching=np.zeros((4 * count + 16, 2), np.int64),
        contact_impulse=np.zeros(4 * count + 16),
        friction_impulse=np.zeros(0),
        amplitudes=np.zeros((count, 0)),
        turning=np.zeros((count, 0)),
        tally=np.zeros(5),
        skin=np.zeros(1),
    )


DRIVEN = 1
"""The index in `Workspace.stages` of the midstep velocities without noise, of Brownian floats."""
PUSHED = 2
"""The index in `Workspace.stages` of the forces at the beginning of a step, of floats with hydrodynamic interaction."""

FIRST_GUESS = 64
"""Number of neighbors per float for which a first workspace has room."""


def make_workspace(parameters: Parameters, state: State, room: float, velocities: int = 2) -> Workspace:
    """Allocate a workspace for about the current density; the run enlarges it if necessary. Floats have two
    midstep velocities, or three with a spin.
    """
    count = len(state.position)
    walls = len(parameters.kick.mobility) - count
    pairs = int(room * (24 * count + 64))
    return Workspace(
        lists=neighbors.make_lists(count, 2, int(room * count * min(count, FIRST_GUESS)), parameters.periods),
        candidates=contacts.make_candidates(count, pairs),
        contacts=contacts.make_contacts(pairs + count * walls),
        force=np.zeros((count, 2)),
        torque=np.zeros(count),
        midstep_velocity=np.zeros((count + walls, velocities)),
        before=np.zeros((count + walls, velocities)),
        restitution=np.zeros(count),
        stages=np.zeros((5, count, 2)),
        travel=np.zeros(1),
        ready=np.zeros(1, np.int64),
    )


@compiled
def advance_rows(position: Array, velocity: Array, time: float) -> None:
    """Add `time` times the velocities to the positions. Midstep velocities have additional rows for walls."""
    for i in range(min(position.shape[0], velocity.shape[0])):
        position[i, 0] += time * velocity[i, 0]
        position[i, 1] += time * velocity[i, 1]


@compiled
def copy_rows(target: Array, source: Array) -> None:
    """Copy the first rows of `source` to `target`."""
    for i in range(min(target.shape[0], source.shape[0])):
        target[i, 0], target[i, 1] = source[i, 0], source[i, 1]


@compiled
def clear(rows: Array) -> None:
    """Set all rows to zero."""
    for i in range(rows.shape[0]):
        rows[i, 0], rows[i, 1] = 0.0, 0.0


@compiled
def add_rows(to: Array, others: Array) -> None:
    """Add the first rows of `others` to the rows of `to`."""
    for i in range(len(to)):
        to[i, 0] += others[i, 0]
        to[i, 1] += others[i, 1]
