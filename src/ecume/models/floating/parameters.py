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

SCHEMES = ("velocity-verlet", "explicit-euler", "stormer-verlet", "semi-implicit-euler", "rk4", "overdamped")
VELOCITY_VERLET, EXPLICIT_EULER, STORMER_VERLET, SEMI_IMPLICIT_EULER, RK4, OVERDAMPED = range(6)
RARE = (STORMER_VERLET, RK4)
"""Schemes that ask for forces on the way; their march is compiled when one of them is used."""
KICKED_BEFORE = (SEMI_IMPLICIT_EULER, OVERDAMPED)
"""Schemes whose only kick comes before the drift: nothing is pressed together after contacts were solved for it."""

CONTACT_LAWS = ("none", "impulse", "legacy", "spring-dashpot")
NO_CONTACTS, IMPULSE, LEGACY, SPRINGS = range(4)


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
    scheme: int
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
    contact_law: int
    restitution: float
    wall_restitution: float
    slop: float
    """overlaps up to this are left alone"""
    drift: Drift
    many: Any = ()
    """nothing for superposed pairs; else a `many.Many`, a `corrected.Corrected`, a `summing.Split` ..., which makes a
    march of its own
    """
    quickest: float = math.inf
    """s: of what turns, or is drawn by how its rim undulates"""
    single: bool = False
    """whether pair forces are worked out in single precision"""
    rough: Any = ()
    """nothing where surfaces are smooth; else a `rubbing.Rough`, which makes a march of its own"""
    springs: Any = ()
    """nothing where contacts are impulses; else a `springs.Springs`, which makes a march of its own"""
    stiffer: float = 1.0
    """how much stiffer contacts are than superposition says, at most"""


STRENGTH, CAPILLARY_LENGTH, CUTOFF, SURFACE_TENSION, INVERSE_SQUARE, OWN = range(6)


def pack_pair(strength: float, capillary_length: float, cutoff: float, surface_tension: float, own: Any) -> Array:
    """The constants of pairs as one array: those that do not depend on the pair law, then the constants of the law."""
    # The inverse square of the length stands here since a loop in single precision has no literal of its own.
    return np.array([strength, capillary_length, cutoff, surface_tension, capillary_length**-2, *own])
