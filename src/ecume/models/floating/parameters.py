"""Parameters of the floating model: radii, masses and charges of floats, and the constants of all laws."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ecume.engine.cells import Integers
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
    """The order of kicks, drift and contacts in a time step. Compiled code reads these, so that all schemes with kicks
    share one compilation.
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
    """One kick of the scheme, with drag solved exactly for a constant force: v = decay v + gain F."""

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


class Parameters(NamedTuple):
    """See `ecume.models.model`."""

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
    reach: float
    """range of the neighbor lists: the cutoff or the widest touching pair, plus the skin"""
    walls: Walls
    wall_law: int
    """see `walls.menisci`"""
    wall_strength: Array
    """(walls, N) J"""
    wall_table: Array
    """see `walls.menisci.wall_table`; empty if there are formulas"""
    image_strength: float
    """N: 2 pi gamma, if walls mirror menisci"""
    restitution: float
    wall_restitution: float
    slop: float
    """m: overlaps up to this value are tolerated"""
    drift: Drift
    quickest: float = math.inf
    """s: the shortest time scale of the parts, which limits the time step beside the pair law"""
    stiffer: float = 1.0
    """the stiffness of the parts over that of superposition, at most"""
    collective: float = 1.0
    """the speed of a raft of all floats over that of a single one under the same force per float, at most"""
    single: bool = False
    """whether pair forces are computed in single precision"""
    periods: Array = np.zeros((2, 2))
    """of the cell: see `ecume.engine.cells`; zero without a cell"""
    parts: Any = ()
    """the `Parts` of the model, whose types select compiled code; empty in the parameters that compiled code gets"""


class Parts(NamedTuple):
    """What a scene has chosen from the tables of the model: each part is a NamedTuple of constants, and its type is
    the key of its record. Compiled code contains the functions of these records and no others.
    """

    integrator: Any
    """of `integrators.INTEGRATORS`"""
    interactions: tuple[Any, ...]
    """of `interactions.INTERACTIONS`; their forces are added up in this order"""
    resistances: tuple[Any, ...]
    """of `interactions.RESISTANCES`: they slow velocities after a kick"""
    contacts: Any
    """of `contact_models.CONTACTS`"""
    lists: Any
    """how neighbor lists are made: a key of `integration.LISTS`"""


class Scratch(NamedTuple):
    """The workspaces of the parts."""

    integrator: Any
    interactions: tuple[Any, ...]
    resistances: tuple[Any, ...]
    contacts: Any


def part_of(parameters: Parameters, constants: type) -> Any:
    """The interaction of this type, or None."""
    return next((part for part in parameters.parts.interactions if isinstance(part, constants)), None)


STRENGTH, CAPILLARY_LENGTH, CUTOFF, SURFACE_TENSION, INVERSE_SQUARE, OWN = range(6)


def distinct_rows(*columns: Array) -> Array:
    """The distinct rows of some columns (kinds, columns), in ascending order. Floats of a species follow one another,
    which makes this quick for millions.

    >>> distinct_rows(np.array([2.0, 2.0, 1.0, 2.0]), np.array([5.0, 5.0, 5.0, 5.0])).tolist()
    [[1.0, 5.0], [2.0, 5.0]]
    """
    rows = np.stack(columns, axis=1)
    first = np.ones(len(rows), dtype=bool)
    first[1:] = (rows[1:] != rows[:-1]).any(axis=1)
    return np.asarray(np.unique(rows[first], axis=0))


def pack_pair(strength: float, capillary_length: float, cutoff: float, surface_tension: float, own: Any) -> Array:
    """The constants of pairs as one array: those that do not depend on the pair law, then the constants of the law."""
    # The inverse square of the length stands here since a literal in the loop would be in double precision.
    return np.array([strength, capillary_length, cutoff, surface_tension, capillary_length**-2, *own])
