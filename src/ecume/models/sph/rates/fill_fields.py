"""Filling the tables that sums read: the entries of the liquid, of its images, and of the dummies
of walls and bodies.

Pressure and velocity of dummies are interpolated from the liquid in front of them: Adami, Hu and Adams, J. Comput.
Phys. 231 (2012) 7057, eqs. 22, 23 and 27. [adami2012]
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np

from ecume._jit import admit, by_type, compiled_inside, inlined, prange, spread
from ecume.engine.cells import Images, Integers
from ecume.engine.neighbor_rows import Lists
from ecume.laws import states
from ecume.models.sph.fields import FIELD, ConstantDensity, Constants, EquationOfState, Floats, Liquid, Tait, TwoLiquids
from ecume.models.sph.rates.kernel_loops import value_of
from ecume.units import Array

admit(states)


@compiled_inside
def tait_state(density: float, pressure: float, tait: Tait) -> tuple[float, float, float]:
    """Density, pressure and enthalpy at this density."""
    c0, gamma, rho0 = tait.sound_speed, tait.exponent, tait.density
    enthalpy = states.tait_enthalpy(density, rho0, c0, gamma)
    return density, states.tait_pressure(density, rho0, c0, gamma), enthalpy


@compiled_inside
def constant_state(density: float, pressure: float, liquid: ConstantDensity) -> tuple[float, float, float]:
    """Density, pressure and enthalpy at this pressure, which the pressure solver computed."""
    return liquid.density, pressure, pressure / liquid.density


@compiled_inside
def tait_at_enthalpy(enthalpy: float, tait: Tait) -> tuple[float, float]:
    """Density and pressure at this enthalpy."""
    c0, gamma, rho0 = tait.sound_speed, tait.exponent, tait.density
    density = states.density_at_enthalpy(enthalpy, rho0, c0, gamma)
    return density, states.tait_pressure(density, rho0, c0, gamma)


@compiled_inside
def constant_at_enthalpy(enthalpy: float, liquid: ConstantDensity) -> tuple[float, float]:
    """Density and pressure at this enthalpy."""
    return liquid.density, liquid.density * enthalpy


@compiled_inside
def the_liquid(kind: float, liquid: Liquid) -> Liquid:
    """The only liquid of a tank."""
    return liquid


@compiled_inside
def one_of_two(kind: float, liquids: TwoLiquids) -> Tait:
    """The liquid of this kind, 1 or 2."""
    if kind > 1.5:
        return Tait(liquids.second_sound_speed, liquids.second_exponent, liquids.second_density)
    return Tait(liquids.sound_speed, liquids.exponent, liquids.density)


STATES: dict[type, Callable[..., tuple[float, float, float]]] = {Tait: tait_state, ConstantDensity: constant_state}
STATES_AT_ENTHALPY: dict[type, Callable[..., tuple[float, float]]] = {
    Tait: tait_at_enthalpy, ConstantDensity: constant_at_enthalpy,
}  # fmt: skip
LIQUIDS: dict[type, Callable[..., Liquid]] = {
    Tait: the_liquid, ConstantDensity: the_liquid, TwoLiquids: one_of_two,
}  # fmt: skip
liquid_at = by_type(LIQUIDS.__getitem__)
state_of = by_type(STATES.__getitem__)
state_at_enthalpy = by_type(STATES_AT_ENTHALPY.__getitem__)


@spread
def fill_liquid(
    fields: Floats, position: Array, velocity: Array, density: Array, density_rate: Array, pressure: Array, mass: Array,
    origin: Array, by_mass: bool, bulk_viscosity: float, liquid: EquationOfState,
) -> None:  # fmt: skip
    """Fill the entries of the liquid from its state."""
    dimension, count = position.shape
    for i in prange(count):
        for axis in range(dimension):
            fields[FIELD.position + axis, i] = position[axis, i] - origin[axis]
            fields[FIELD.velocity + axis, i] = velocity[axis, i]
            fields[FIELD.friction_velocity + axis, i] = velocity[axis, i]
        own, push, enthalpy = state_of(density[i], pressure[i], liquid_at(fields[FIELD.kind, i], liquid))
        fields[FIELD.density, i] = own
        fields[FIELD.volume, i] = mass[i] / own
        fields[FIELD.pressure, i] = push
        fields[FIELD.enthalpy, i] = enthalpy
        damping = bulk_viscosity * density_rate[i] / own
        fields[FIELD.damping, i] = damping
        fields[FIELD.force_term, i] = (push + damping) / (own * own) if by_mass else push + damping
        fields[FIELD.weight, i] = mass[i] if by_mass else mass[i] / own


@spread
def fill_images(
    source: Integers, fields: Floats, first: int, start: Integers, sides: Array, pull: Array, liquid: EquationOfState
) -> None:
    """Fill the images, side by side in order, since the source of an image may be an image of an earlier side.

    `sides` is (sides, 4 d + 2): point, normal, shift (of a periodic side) or velocity (of a mirror); whether it is a
    mirror; whether it has no slip; acceleration.
    """
    dimension = len(pull)
    for side in range(len(start) - 1):
        mirrors, holds = sides[side, 3 * dimension] != 0.0, sides[side, 3 * dimension + 1] != 0.0
        for k in prange(start[side], start[side + 1]):
            if mirrors:
                _mirror(fields, source[k], first + k, sides[side], holds, pull, liquid)
            else:
                _shift(fields, source[k], first + k, sides[side], dimension)


@inlined
def _shift(fields: Floats, i: int, image: int, side: Array, dimension: int) -> None:
    for row in range(fields.shape[0]):
        fields[row, image] = fields[row, i]
    for axis in range(dimension):
        fields[FIELD.position + axis, image] += side[2 * dimension + axis]


@inlined
def _mirror(fields: Floats, i: int, image: int, side: Array, holds: bool, pull: Array, liquid: EquationOfState) -> None:
    """Fill the entries of a mirrored particle. Its enthalpy is that of its source plus the hydrostatic difference. For
    friction, a no-slip wall reverses the whole velocity; for the equation of continuity, only the normal component is
    reversed.
    """
    dimension, mine = len(pull), liquid_at(fields[FIELD.kind, i], liquid)
    c0, rho0 = mine.sound_speed, mine.density
    away, through, drift, pull_through, steep = 0.0, 0.0, 0.0, 0.0, 0.0
    for axis in range(dimension):
        normal = side[dimension + axis]
        away += (fields[FIELD.position + axis, i] - side[axis]) * normal
        through += (fields[FIELD.velocity + axis, i] - side[2 * dimension + axis]) * normal
        drift += fields[FIELD.transport + axis, i] * normal
        pull_through += (pull[axis] - side[3 * dimension + 2 + axis]) * normal
        steep += fields[FIELD.density_gradient + axis, i] * normal
    for axis in range(dimension):
        normal = side[dimension + axis]
        fields[FIELD.position + axis, image] = fields[FIELD.position + axis, i] - 2.0 * away * normal
        fields[FIELD.velocity + axis, image] = fields[FIELD.velocity + axis, i] - 2.0 * through * normal
        fields[FIELD.transport + axis, image] = fields[FIELD.transport + axis, i] - 2.0 * drift * normal
        turned = 2.0 * side[2 * dimension + axis] - fields[FIELD.friction_velocity + axis, i]
        fields[FIELD.friction_velocity + axis, image] = turned if holds else fields[FIELD.velocity + axis, image]
        # The hydrostatic part continues through the wall; the remainder is mirrored.
        fields[FIELD.density_gradient + axis, image] = (
            fields[FIELD.density_gradient + axis, i] - 2.0 * (steep - rho0 / (c0 * c0) * pull_through) * normal
        )
    if fields.shape[0] > FIELD.correction:
        _mirror_correction(fields, i, image, side, dimension)
    enthalpy = fields[FIELD.enthalpy, i] - 2.0 * away * pull_through
    mass = fields[FIELD.volume, i] * fields[FIELD.density, i]
    density, push = state_at_enthalpy(enthalpy, mine)
    fields[FIELD.enthalpy, image] = enthalpy
    fields[FIELD.density, image] = density
    fields[FIELD.pressure, image] = push
    fields[FIELD.volume, image] = mass / density
    fields[FIELD.viscosity, image] = fields[FIELD.viscosity, i]
    fields[FIELD.damping, image] = fields[FIELD.damping, i]
    fields[FIELD.liquid, image] = fields[FIELD.liquid, i]
    fields[FIELD.kind, image] = fields[FIELD.kind, i]


@inlined
def _mirror_correction(fields: Floats, i: int, image: int, side: Array, dimension: int) -> None:
    """Mirror the matrix of a particle at a side across an axis: components with one index along this axis change
    sign.
    """
    across_x, across_y, across_z = math.fabs(side[dimension]), math.fabs(side[dimension + 1]), 0.0
    if dimension > 2:
        across_z = math.fabs(side[dimension + 2])
    for row in range(3):
        fields[FIELD.correction + row, image] = fields[FIELD.correction + row, i]
    fields[FIELD.correction + 3, image] = fields[FIELD.correction + 3, i] * (1.0 - 2.0 * (across_x + across_y))
    fields[FIELD.correction + 4, image] = fields[FIELD.correction + 4, i] * (1.0 - 2.0 * (across_x + across_z))
    fields[FIELD.correction + 5, image] = fields[FIELD.correction + 5, i] * (1.0 - 2.0 * (across_y + across_z))


@spread
def fill_weights(fields: Floats, first: int, by_mass: bool) -> None:
    """Fill the pressure term and the weight of neighbors, from column `first` on: see `Fields`."""
    for i in prange(first, fields.shape[1]):
        density, push = fields[FIELD.density, i], fields[FIELD.pressure, i] + fields[FIELD.damping, i]
        fields[FIELD.force_term, i] = push / (density * density) if by_mass else push
        fields[FIELD.weight, i] = fields[FIELD.volume, i] * density if by_mass else fields[FIELD.volume, i]


NOTHING = 1e-12
"""The sum of kernels, over W(0), below which no liquid is near."""
INDEX = np.uint64


@spread
def read_liquid(
    fields: Floats,
    first: int,
    lists: Lists,
    constants: Constants,
    pull: Array,
    clip: bool,
    liquid: EquationOfState,
) -> None:
    """Fill the columns of dummies, from `first` on, by interpolation from the liquid in their rows.

    A dummy has the mean damping of the liquid in front of it; without damping, water in a narrow gap between dummies
    did not come to rest. Their positions, wall velocities and slip (their viscosity is zero on slippery walls) are set
    already. `pull` is (d, dummies): gravity less each one's own acceleration (eq. 27).
    """
    kernel, dimension, inverse = constants[0].kernel, len(pull), 1.0 / constants[0].smoothing_length
    counts, start, neighbor = lists
    for dummy in prange(first, len(counts)):
        total, enthalpy, damping, speed = 0.0, 0.0, 0.0, np.zeros(3)
        for k in range(counts[dummy]):
            j = neighbor[start[dummy] + k]
            square, depth = 0.0, 0.0
            for axis in range(dimension):
                along = fields[FIELD.position + axis, j] - fields[FIELD.position + axis, dummy]
                square += along * along
                depth -= pull[axis, dummy - first] * along
            weight = value_of(math.sqrt(square) * inverse, kernel) * fields[FIELD.liquid, j]
            total += weight
            enthalpy += weight * (fields[FIELD.enthalpy, j] + depth)
            damping += weight * fields[FIELD.damping, j]
            for axis in range(dimension):
                speed[axis] += weight * fields[FIELD.friction_velocity + axis, j]
        near = total > NOTHING
        enthalpy = enthalpy / total if near else 0.0
        fields[FIELD.damping, dummy] = damping / total if near else 0.0
        _set_state(fields, dummy, max(enthalpy, 0.0) if clip else enthalpy, liquid)
        for axis in range(dimension):
            wall = fields[FIELD.velocity + axis, dummy]
            fields[FIELD.friction_velocity + axis, dummy] = 2.0 * wall - speed[axis] / total if near else wall


def read_from_sources(field: Floats, images: Images, real: int) -> None:
    """Copy the values of their sources to the images, which follow the `real` particles; a source may be an image."""
    for first, last in itertools.pairwise(images.start):
        field[real + first : real + last] = field[images.source[first:last]]


@spread
def read_means(fields: Floats, values: Floats, first: int, lists: Lists, constants: Constants) -> None:
    """Fill the values of dummies, from column `first` on, with the mean over the liquid in their rows."""
    kernel, inverse = constants[0].kernel, 1.0 / constants[0].smoothing_length
    counts, start, neighbor = lists
    for dummy in prange(first, len(counts)):
        total, mean = 0.0, 0.0
        for k in range(counts[dummy]):
            j = neighbor[start[dummy] + k]
            square = 0.0
            for axis in range(3):
                along = fields[FIELD.position + axis, j] - fields[FIELD.position + axis, dummy]
                square += along * along
            weight = value_of(math.sqrt(square) * inverse, kernel) * fields[FIELD.liquid, j]
            total += weight
            mean += weight * values[j]
        values[dummy] = mean / total if total > NOTHING else 0.0


@compiled_inside
def _set_state(fields: Floats, i: int, enthalpy: float, liquid: EquationOfState) -> None:
    density, push = state_at_enthalpy(enthalpy, liquid)
    fields[FIELD.enthalpy, i] = enthalpy
    fields[FIELD.density, i] = density
    fields[FIELD.pressure, i] = push
