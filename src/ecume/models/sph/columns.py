"""Filling the tables that sums read: the liquid's own columns, and those of its images."""

from __future__ import annotations

from typing import Any

from ecume._jit import admit, inlined, prange, spread
from ecume.laws import enthalpy as enthalpies
from ecume.laws import states
from ecume.models.sph.fields import ENTHALPY, LIQUID, MU, PUSH, RHO, VOLUME, WEIGHT, G, P, U, V, W, X

admit(states, enthalpies)

C0, GAMMA, RHO0 = 0, 1, 2
"""Places in the table of the material: sound speed, Tait's exponent, reference density."""


@spread
def fill_liquid(
    fields: Any, position: Any, velocity: Any, density: Any, mass: Any, material: Any, origin: Any, by_mass: bool
) -> None:  # fmt: skip
    """Everything that sums read of the liquid, from its state."""
    dimension, count = position.shape
    c0, gamma, rho0 = material[C0], material[GAMMA], material[RHO0]
    for i in prange(count):
        for axis in range(dimension):
            fields[X + axis, i] = position[axis, i] - origin[axis]
            fields[V + axis, i] = velocity[axis, i]
            fields[U + axis, i] = velocity[axis, i]
        own = density[i]
        pressure = states.tait_pressure(own, rho0, c0, gamma)
        fields[RHO, i] = own
        fields[VOLUME, i] = mass[i] / own
        fields[P, i] = pressure
        fields[ENTHALPY, i] = enthalpies.tait_enthalpy(own, rho0, c0, gamma)
        fields[PUSH, i] = pressure / (own * own) if by_mass else pressure
        fields[WEIGHT, i] = mass[i] if by_mass else mass[i] / own


@spread
def fill_images(source: Any, fields: Any, first: int, start: Any, sides: Any, pull: Any, material: Any) -> None:
    """Images, side by side in order: an image may be the source of another.

    `sides` is (sides, 4 d + 2): point, normal, shift (of a periodic side) or velocity (of a mirror); whether it
    mirrors; whether it holds the liquid (no slip); acceleration.
    """
    dimension = len(pull)
    for side in range(len(start) - 1):
        mirrors, holds = sides[side, 3 * dimension] != 0.0, sides[side, 3 * dimension + 1] != 0.0
        for k in prange(start[side], start[side + 1]):
            if mirrors:
                _mirror(fields, source[k], first + k, sides[side], holds, pull, material)
            else:
                _shift(fields, source[k], first + k, sides[side], dimension)


@inlined
def _shift(fields: Any, i: int, image: int, side: Any, dimension: int) -> None:
    for row in range(fields.shape[0]):
        fields[row, image] = fields[row, i]
    for axis in range(dimension):
        fields[X + axis, image] += side[2 * dimension + axis]


@inlined
def _mirror(fields: Any, i: int, image: int, side: Any, holds: bool, pull: Any, material: Any) -> None:
    """The mirrored particle, at rest under gravity where its source is: its enthalpy is the source's, and what the
    way between adds. A wall that holds the liquid turns the velocity around for friction, and lets only the normal
    part turn for the equation of continuity.
    """
    dimension = len(pull)
    c0, gamma, rho0 = material[C0], material[GAMMA], material[RHO0]
    away, through, drift, pull_through, steep = 0.0, 0.0, 0.0, 0.0, 0.0
    for axis in range(dimension):
        normal = side[dimension + axis]
        away += (fields[X + axis, i] - side[axis]) * normal
        through += (fields[V + axis, i] - side[2 * dimension + axis]) * normal
        drift += fields[W + axis, i] * normal
        pull_through += (pull[axis] - side[3 * dimension + 2 + axis]) * normal
        steep += fields[G + axis, i] * normal
    for axis in range(dimension):
        normal = side[dimension + axis]
        fields[X + axis, image] = fields[X + axis, i] - 2.0 * away * normal
        fields[V + axis, image] = fields[V + axis, i] - 2.0 * through * normal
        fields[W + axis, image] = fields[W + axis, i] - 2.0 * drift * normal
        turned = 2.0 * side[2 * dimension + axis] - fields[U + axis, i]
        fields[U + axis, image] = turned if holds else fields[V + axis, image]
        # The hydrostatic part goes on through the wall, the rest is mirrored.
        fields[G + axis, image] = fields[G + axis, i] - 2.0 * (steep - rho0 / (c0 * c0) * pull_through) * normal
    enthalpy = fields[ENTHALPY, i] - 2.0 * away * pull_through
    mass = fields[VOLUME, i] * fields[RHO, i]
    density = enthalpies.density_at_enthalpy(enthalpy, rho0, c0, gamma)
    fields[ENTHALPY, image] = enthalpy
    fields[RHO, image] = density
    fields[P, image] = states.tait_pressure(density, rho0, c0, gamma)
    fields[VOLUME, image] = mass / density
    fields[MU, image] = fields[MU, i]
    fields[LIQUID, image] = fields[LIQUID, i]


@spread
def fill_weights(fields: Any, first: int, by_mass: bool) -> None:
    """What each neighbor's pressure adds, and what it counts, from column `first` on: see `PUSH` and `WEIGHT`."""
    for i in prange(first, fields.shape[1]):
        density = fields[RHO, i]
        fields[PUSH, i] = fields[P, i] / (density * density) if by_mass else fields[P, i]
        fields[WEIGHT, i] = fields[VOLUME, i] * density if by_mass else fields[VOLUME, i]
