"""What never changes while floats drift: their radii, masses and charges, and every constant of the laws."""

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
    """Float by float, all (N,)."""

    radius: Array
    mass: Array
    charge: Array
    """m: the far field's amplitude"""
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
    """false where drag rules and velocities follow from forces at once"""
    drifts_first: bool
    """the drift goes by the velocity before the kick, as in the explicit Euler scheme"""
    contacts_at_end: bool
    """contacts are solved a second time, on the velocity at the end of the step"""
    forces_at_end: bool
    """forces are evaluated at the end of each step"""


class Kick(NamedTuple):
    """What one kick of the scheme does to a float, with drag solved exactly under a force that stays: v = decay v +
    gain F.
    """

    decay: Array
    gain: Array
    mobility: Array
    """(N + walls,) velocity per impulse over the kick: gain / time, 1/m without drag; zero for walls"""


DRAG_LAWS = ("stokes", "schiller-naumann")


class Sway(NamedTuple):
    """How the dish is moved; floats are seen from it."""

    moves: bool
    velocity: Array
    """(2,) m/s, that stays"""
    amplitude: Array
    """(2,) m, of the swing"""
    turning: float
    """rad/s, of the swing"""
    slip: float
    """the part of its motion that the liquid does not go along with"""


class Drift(NamedTuple):
    """What carries floats along beside forces: the flowing surface, and chance."""

    flow: Array
    """(6,) u_x, u_y at the origin (m/s), then du_x/dx, du_x/dy, du_y/dx, du_y/dy (1/s)"""
    nodes: Array
    """(2, X, Y) m/s: a flow at nodes, beside that; (2, 0, 0) where there is none"""
    frame: Array
    """(4,) of the nodes: the least x and y (m), then nodes for each meter along x and y"""
    flows: bool
    thermal: float
    """J: kT"""
    seed: int
    thickness: float
    """s/m^2: the liquid's density over its viscosity where drag grows with the speed; zero where it is Stokes's"""
    jump: float
    """m: farther than this chance, but for one in a billion, and the dish carry nobody in a step"""
    sway: Sway


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
    """how far neighbor lists look: the cutoff or the widest touching pair, and the skin"""
    walls: Walls
    wall_law: int
    """see `walls.menisci`"""
    wall_strength: Array
    """(walls, N) J"""
    wall_table: Array
    """see `walls.menisci.wall_table`; empty where formulas do"""
    image_strength: float
    """N: 2 pi gamma, where walls mirror menisci"""
    restitution: float
    wall_restitution: float
    slop: float
    """overlaps up to this are left alone"""
    drift: Drift
    quickest: float = math.inf
    """s: the shortest time scale of the parts, which limits the time step beside the pair law"""
    stiffer: float = 1.0
    """the stiffness of the parts over that of superposition, at most"""
    single: bool = False
    """whether pair forces are computed in single precision"""
    parts: Any = ()
    """the `Parts` of the model, whose types select compiled code; empty in the parameters that compiled code gets"""


class Parts(NamedTuple):
    """What a scene has chosen from the tables of the model: each part is a NamedTuple of constants, and its type is
    the key of its record. Compiled code contains the functions of these records and no others.
    """

    integrator: Any
    """of `schemes.INTEGRATORS`"""
    interactions: tuple[Any, ...]
    """of `interactions.INTERACTIONS`; their forces are added up in this order"""
    resistances: tuple[Any, ...]
    """of `interactions.RESISTANCES`: they slow velocities after a kick"""
    contacts: Any
    """of `contacts.CONTACTS`"""
    lists: Any
    """how neighbor lists are made: a key of `stepping.LISTS`"""


class Scratch(NamedTuple):
    """The workspace of each part."""

    integrator: Any
    interactions: tuple[Any, ...]
    resistances: tuple[Any, ...]
    contacts: Any


def part_of(parameters: Parameters, constants: type) -> Any:
    """The interaction of this type; None if there is none."""
    return next((part for part in parameters.parts.interactions if isinstance(part, constants)), None)


STRENGTH, CAPILLARY_LENGTH, CUTOFF, SURFACE_TENSION, INVERSE_SQUARE, OWN = range(6)


def pack_pair(strength: float, capillary_length: float, cutoff: float, surface_tension: float, own: Any) -> Array:
    """The constants of pairs as one array: those that do not depend on the pair law, then the constants of the law."""
    # The inverse square of the length stands here since a loop in single precision has no literal of its own.
    return np.array([strength, capillary_length, cutoff, surface_tension, capillary_length**-2, *own])
