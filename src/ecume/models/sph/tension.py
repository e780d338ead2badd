"""Surface tension between the liquid's particles: the continuum surface force (see `color`), or cohesion.

There is no gas. Walls' images count as liquid, so that a mirror is met at a right angle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from ecume._jit import admit, compiled_inside, prange, summing
from ecume.engine.neighbor_rows import Lists
from ecume.laws import tension
from ecume.laws.kernels import shapes
from ecume.models.sph.color import contour_energy, contour_forces
from ecume.models.sph.fields import FIELD, Constants, Floats
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.state import State, Workspace
from ecume.units import Array

admit(tension)

INDEX = np.uint64
STRENGTHS = {2: tension.cohesion_strength_in_plane, 3: tension.cohesion_strength_in_space}
COUNTED = {2: 0.331, 3: 0.236}
"""The part of cohesion's own tension that is left beside the pressure it calls up, which keeps what the sum for
continuity makes of div v at zero, up to a flat surface. Worked out for Wendland's C2 and evenly spread liquid: see the
page on the physics, and `tests/models/sph/test_tension.py`.
"""


def pull(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Add the acceleration by surface tension to the state's."""
    TENSIONS[parameters.tension].pull(parameters, state, workspace)


def surface_energy(parameters: Parameters, workspace: Workspace) -> float:
    """J: of all pairs under cohesion, of the color's contours otherwise; forces are its slopes."""
    return TENSIONS[parameters.tension].energy(parameters, workspace)


def no_pull(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Add nothing."""


def no_energy(parameters: Parameters, workspace: Workspace) -> float:
    """Zero."""
    return 0.0


def pull_by_contours(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Add the acceleration by the continuum surface force."""
    state.acceleration[...] += contour_forces(parameters, workspace, state.mass) / state.mass


def pull_by_pairs(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Add the acceleration by cohesion."""
    strength = cohesion_strength(parameters)
    pull_by_cohesion(*_crowd(parameters, workspace), parameters.support, strength, state.acceleration)


def energy_of_pairs(parameters: Parameters, workspace: Workspace) -> float:
    """J, of cohesion."""
    energy = np.zeros(workspace.rates.shape[1])
    sum_cohesion(*_crowd(parameters, workspace), parameters.support, cohesion_strength(parameters), energy)
    return float(energy.sum())


def cohesion_strength(parameters: Parameters) -> float:
    """With which the tension is the liquid's."""
    material, law = parameters.material, STRENGTHS[parameters.dimension]
    wanted = material.surface_tension / COUNTED[parameters.dimension]
    return law(wanted, material.density, parameters.support)


def _crowd(parameters: Parameters, workspace: Workspace) -> tuple[Floats, Lists, Constants]:
    return workspace.fields.table, workspace.lists, parameters.constants


@summing
def pull_by_cohesion(
    fields: Floats, lists: Lists, constants: Constants, support: float, strength: float,
    acceleration: Array,
) -> None:  # fmt: skip
    """Add sum_j gamma m_j C(r) x_ij/r, alike for both of a pair; walls and images pull like the liquid."""
    deep = constants[0].dimension == 3
    counts, neighbor = lists
    for particle in prange(acceleration.shape[1]):
        i = INDEX(particle)
        x, y, z = fields[FIELD.position, i], fields[FIELD.position + 1, i], fields[FIELD.position + 2, i]
        ax, ay, az = 0.0, 0.0, 0.0
        for k in range(INDEX(counts[i])):
            j = INDEX(neighbor[i, k])
            dx, dy, dz = (
                fields[FIELD.position, j] - x,
                fields[FIELD.position + 1, j] - y,
                fields[FIELD.position + 2, j] - z,
            )
            square = dx * dx + dy * dy
            if deep:
                square += dz * dz
            distance = math.sqrt(square)
            share = (
                fields[FIELD.volume, j]
                * fields[FIELD.density, j]
                * tension.cohesion_kernel(distance, support)
                / distance
            )
            ax += share * dx
            ay += share * dy
            if deep:
                az += share * dz
        add(acceleration, i, (strength * ax, strength * ay, strength * az))


@summing
def sum_cohesion(
    fields: Floats, lists: Lists, constants: Constants, support: float, strength: float, energy: Array
) -> None:  # fmt: skip
    """Half of each pair's energy goes to either particle, an image included; a wall's particle leaves all of it."""
    counts, neighbor = lists
    for particle in prange(len(energy)):
        i = INDEX(particle)
        total = 0.0
        for k in range(INDEX(counts[i])):
            j = INDEX(neighbor[i, k])
            square = 0.0
            for axis in range(constants[0].dimension):
                square += (fields[FIELD.position + axis, j] - fields[FIELD.position + axis, i]) ** 2
            share = 1.0 - 0.5 * fields[FIELD.liquid, j]
            total += (
                share
                * fields[FIELD.volume, j]
                * fields[FIELD.density, j]
                * tension.cohesion_energy(math.sqrt(square), support)
            )
        energy[i] = strength * fields[FIELD.volume, i] * fields[FIELD.density, i] * total


@compiled_inside
def add(acceleration: Array, i: np.uint64, more: tuple[float, float, float]) -> None:
    """To one particle's."""
    for axis in range(acceleration.shape[0]):
        acceleration[axis, i] += more[axis]


class Tension(NamedTuple):
    """A model of surface tension."""

    pull: Callable[[Parameters, State, Workspace], None]
    """adds its acceleration to the state's"""
    energy: Callable[[Parameters, Workspace], float]
    """J, whose slopes its forces are"""
    color_reaches: Mapping[int, float]
    """how far its color field looks, in spacings, by dimension; zero without one"""
    inner_pressure: float
    """a quarter of the pressure inside that it causes beside Laplace's, in tensions over supports"""
    accuracy: Mapping[int, str]
    """how well it does, by dimension"""
    laws: tuple[Callable[..., float], ...]
    """what it rests on, for citations"""


TENSIONS: Mapping[str, Tension] = {
    "none": Tension(no_pull, no_energy, {2: 0.0, 3: 0.0}, inner_pressure=0.0, accuracy={}, laws=()),
    "cohesion": Tension(
        pull_by_pairs, energy_of_pairs, {2: 0.0, 3: 0.0}, inner_pressure=6.0,
        accuracy={
            2: "swings below a tenth are too fast, wide ones right within 5 %",
            3: "draws round, but does not swing: particles that keep their neighbors hold each other",
        },
        laws=(tension.cohesion_kernel, tension.cohesion_strength_in_plane),
    ),
    # A narrower color kernel sees single particles, a wider one flattens what is curved.
    "csf": Tension(
        pull_by_contours, contour_energy, {2: 4.8, 3: 4.0}, inner_pressure=0.0,
        accuracy={
            2: "periods and pressures within some percent at ten particles a radius",
            3: "periods within 9 % at five particles a radius, 5 % at six; pressures within 14 %",
        },
        laws=(tension.surface_weight, tension.steepness, shapes.wendland_c4_bend),
    ),
}  # fmt: skip
"""By name."""
