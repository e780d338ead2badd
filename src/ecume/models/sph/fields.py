"""Arrays that the sums over neighbors read and write, by name: one array for each quantity, one entry for each
particle.

Entries of `Fields`: first the liquid, then the dummies of walls and bodies, then images (mirrored or shifted
particles). `Rates` have entries for the liquid alone. Vectors have three components in 2D too; the third stays zero.

All arrays are rows of one table. The argument of compiled loops is this table, which is faster than many arrays. Its
rows have names in `FIELD` and `RATE`: `fields[FIELD.density, i]` is the density of particle i, and
`fields[FIELD.position + 1, i]` its y. (Numba loses what a threaded loop writes into an array that is part of a tuple.)
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol, cast

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.floating]
"""Arrays in the precision of a scene's sums."""
Precision = type[np.float64] | type[np.float32]


class Fields(NamedTuple):
    """The quantities of a particle and its neighbors that sums read."""

    table: Floats
    """all of the following, one row each: the rows that an image copies from its source"""
    position: Floats
    velocity: Floats
    friction_velocity: Floats
    """the velocity for the viscous force: on a no-slip wall it differs from `velocity`"""
    transport: Floats
    """the transport velocity less the velocity"""
    density_gradient: Floats
    density: Floats
    pressure: Floats
    """gauge pressure"""
    volume: Floats
    viscosity: Floats
    enthalpy: Floats
    """J/kg"""
    liquid: Floats
    """1 for the liquid and its images, 0 for dummies"""
    force_term: Floats
    """the term of each of two particles in the pressure force: pressure and damping, over the squared density where
    neighbors count by mass (see `PressureForce.by_mass`)
    """
    weight: Floats
    """the weight of a neighbor in sums: its volume, or its mass"""
    damping: Floats
    """Pa, (zeta/rho) drho/dt of the acoustic damping, with the rate of the last evaluation: part of the force term"""
    kind: Floats
    """1 or 2, the liquid and its images in tanks with two liquids; otherwise 0"""
    correction: Floats
    """(6, entries) xx, yy, zz, xy, xz, yz of the matrix that completes gradients; (0, entries) where none is used"""

    @property
    def shape(self) -> tuple[int, ...]:
        """(3, entries)."""
        return self.position.shape


class FieldRows(NamedTuple):
    """The first row of each field in the table; a vector takes three rows."""

    position: int = 0
    velocity: int = 3
    friction_velocity: int = 6
    transport: int = 9
    density_gradient: int = 12
    density: int = 15
    pressure: int = 16
    volume: int = 17
    viscosity: int = 18
    enthalpy: int = 19
    liquid: int = 20
    force_term: int = 21
    weight: int = 22
    damping: int = 23
    kind: int = 24
    correction: int = 25


FIELD = FieldRows()
FIELDS, CORRECTED_FIELDS = 25, 31
"""Rows of a table, without and with the matrices that complete gradients."""


def fields_in(table: Floats) -> Fields:
    """The fields of a table, by name."""
    vectors = [table[first : first + 3] for first in FIELD[:5]]
    more = [*(table[row] for row in FIELD[5:-1]), table[FIELD.correction :]]
    return Fields(table, *vectors, *more)


def zero_fields(count: int, precision: Precision, corrected: bool = False) -> Fields:
    """Zero fields of this number of particles, with unit matrices where gradients are completed."""
    fields = fields_in(np.zeros((CORRECTED_FIELDS if corrected else FIELDS, count), precision))
    fields.correction[:3] = 1.0
    return fields


class Rates(NamedTuple):
    """Sums over the neighbors of each particle of the liquid."""

    table: Floats
    """all of the following, one row each"""
    continuity: Floats
    """sum of w_j F (v_j - v_i).x_ij: the rate of density, over density where neighbors count by volume"""
    diffusion: Floats
    """the rate of density by diffusion"""
    fullness: Floats
    """the divergence of position: d in full surroundings"""
    acceleration: Floats
    """(3, N) the acceleration by the pressure force or by the viscous force, before the scaling in
    `sums.store_acceleration`
    """
    concentration_gradient: Floats
    """(3, N) minus the gradient of the particle concentration"""
    even_concentration_gradient: Floats
    """(3, N) the same vector with equal weights of all neighbors"""

    @property
    def shape(self) -> tuple[int, ...]:
        """(3, N)."""
        return self.acceleration.shape


class RateRows(NamedTuple):
    """The first row of each rate in the table; a vector takes three rows."""

    continuity: int = 0
    diffusion: int = 1
    fullness: int = 2
    acceleration: int = 3
    concentration_gradient: int = 6
    even_concentration_gradient: int = 9


RATE = RateRows()
RATES = 12


def rates_in(table: Floats) -> Rates:
    """The rates of a table, by name."""
    scalars = (table[row] for row in RATE[:3])
    return Rates(table, *scalars, *(table[first : first + 3] for first in RATE[3:]))


def zero_rates(count: int, precision: Precision) -> Rates:
    """Zero rates of this number of particles."""
    return rates_in(np.zeros((RATES, count), precision))


class Numbers(Protocol):
    """Constants of the sums, in their precision: literals would be double in a single-precision loop."""

    dimension: int
    kernel: int
    """its code in `KERNEL_CODES`"""
    zero: float
    smoothing_length: float
    """h"""
    inverse_length: float
    """1/h"""
    slope_factor: float
    """the factor of `slope_of` that gives F = (1/r) dW/dr"""
    softening: float
    """0.01 h^2"""
    sound_speed: float
    alpha: float
    """of the artificial viscosity"""
    damping_divisor: float
    """the divisor of the artificial viscosity: a density where pressures are divided by densities squared"""
    delta: float
    """factor of the density diffusion"""
    rise_x: float
    """the derivatives of the diffusing field along x, y and z in a liquid at rest"""
    rise_y: float
    rise_z: float
    reference_value: float
    """the kernel's value at one spacing, for shifting; zero: all neighbors have equal weights"""


class Constants(Protocol):
    """The constants `Numbers` as an array of one record. Loops read them from memory each time a formula uses them.

    If they were a tuple, the compiler would treat them as constants of the loop and sum the terms in another order.
    """

    def __getitem__(self, place: int) -> Numbers:
        """Return the record."""

    def copy(self) -> Constants:
        """Return a copy."""


def constants_from(precision: Precision, values: Mapping[str, float]) -> Constants:
    """The constants with these values, one for each name of `Numbers`."""
    kinds = [(name, np.int64 if kind == "int" else precision) for name, kind in Numbers.__annotations__.items()]
    found: Any = np.array([tuple(values[name] for name, _ in kinds)], np.dtype((np.record, kinds)))
    return cast(Constants, found)


def number(constants: Constants, name: str) -> Any:
    """One of the constants, in its precision. In loops over steps this is faster than the attribute of a record."""
    column: Any = constants
    return column[name][0]


class Tait(NamedTuple):
    """Constants of the equation of state."""

    sound_speed: float
    exponent: float
    density: float
    """at zero gauge pressure"""


class ConstantDensity(NamedTuple):
    """A liquid whose density does not depend on the pressure. Its fields have the names of those of `Tait`."""

    sound_speed: float
    """infinite"""
    exponent: float
    density: float


class TwoLiquids(NamedTuple):
    """The constants of `Tait` for two liquids; those of liquid 1 come first."""

    sound_speed: float
    exponent: float
    density: float
    second_sound_speed: float
    second_exponent: float
    second_density: float


Liquid = Tait | ConstantDensity
EquationOfState = Liquid | TwoLiquids
