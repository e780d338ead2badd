"""What never changes while the liquid moves."""

from __future__ import annotations

from typing import NamedTuple

from ecume.engine.cells import Integers
from ecume.engine.images import Sides
from ecume.units import Array

INTEGRATORS = ("symplectic", "verlet")
SYMPLECTIC, VERLET = range(2)
SHIFTINGS = ("none", "delta-plus")
NO_SHIFTING, DELTA_PLUS = range(2)


class Material(NamedTuple):
    """The liquid."""

    density: float
    """kg/m^3, the reference"""
    sound_speed: float
    exponent: float
    viscosity: float
    surface_tension: float
    atmospheric_pressure: float
    fastest: float
    """m/s, the fastest speed expected"""


class Dummies(NamedTuple):
    """The particles that walls are made of."""

    position: Array
    """(d, D)"""
    velocity: Array
    """(d, D) of the wall"""
    viscosity: Array
    """(D,) zero where the wall does not hold the liquid"""


class Boundary(NamedTuple):
    """What holds the liquid."""

    sides: Sides
    """planes with images behind them"""
    table: Array
    """the same with velocities, as `columns.fill_images` reads it"""
    dummies: Dummies
    low: Array
    """(d,) of the tank; minus infinity where it is open"""
    high: Array
    restitution: float


class Liquid(NamedTuple):
    """The liquid's particles at the start: `State` holds where they are later."""

    position: Array
    """(d, N)"""
    velocity: Array
    density: Array
    mass: Array
    region: Integers
    """(N,) which table of the scene each came from"""


class Parameters(NamedTuple):
    """See `ecume.models.model`. Python reads this tuple; compiled loops are handed single arrays of it."""

    time_step: float
    steps_per_frame: int
    dimension: int
    spacing: float
    material: Material
    constants: Array
    """(3,) sound speed, exponent, reference density"""
    gravity: Array
    """(d,) what pulls"""
    hydrostatic: Array
    """(d,) what a modified pressure leaves out, zero otherwise"""
    surface: float
    """m along y, from where a modified pressure's hydrostatic part counts"""
    numbers: Array
    choices: Integers
    support: float
    skin: float
    boundary: Boundary
    integrator: int
    shifting: int
    background: float
    """Pa, of the transport velocity; zero without"""
    courant: float
    walls_clip: bool
    precision: str
