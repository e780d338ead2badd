"""Surface tension between the liquid's particles: the continuum surface force, or cohesion.

There is no gas: the color is 1 in the liquid, walls and their images, so that a wall is met at a right angle. The
gradient of the smoothed color crosses a surface on the liquid's side alone, which is half of it: hence the force is
twice that of Brackbill et al. (1992). The pressure's own sum pushes at a free surface in the same way, with 2 p per
gradient: a disc at rest balances the two particle by particle, at p = sigma kappa. [morris2000]
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ecume._jit import admit, compiled_inside, prange, summing
from ecume.laws import tension
from ecume.models.sph.fields import DIMENSION, INVERSE, KERNEL, LIQUID, RHO, SCALE, VOLUME, H, X
from ecume.models.sph.parameters import COHESION, CSF, Parameters
from ecume.models.sph.state import State, Workspace
from ecume.models.sph.weights import slope_of, value_of
from ecume.units import Array

admit(tension)

INDEX = np.uint64
STRENGTHS = {2: tension.cohesion_strength_in_plane, 3: tension.cohesion_strength_in_space}
COUNTED = {2: 0.331, 3: 0.236}
"""The part of cohesion's own tension that is left beside the pressure it calls up, which keeps what the sum for
continuity makes of div v at zero, up to a flat surface. Worked out for Wendland's C2 and evenly spread liquid: see the
page on the physics, and `tests/models/sph/test_tension.py`.
"""
LENGTH, CURVATURE = 3, 4
"""Rows of a surface: first its direction, into the liquid; then the length of the color's gradient, zero inside."""


def pull(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Add the acceleration by surface tension to the state's."""
    if parameters.tension == CSF:
        surface = surface_at(parameters, workspace)
        strength = parameters.material.surface_tension
        pull_by_curvature(*_crowd(parameters, workspace), surface, strength, state.acceleration)
    elif parameters.tension == COHESION:
        strength = cohesion_strength(parameters)
        pull_by_cohesion(*_crowd(parameters, workspace), parameters.support, strength, state.acceleration)


def surface_energy(parameters: Parameters, workspace: Workspace) -> float:
    """J: of all pairs under cohesion, whose forces are its slopes; of the continuum surface force the area by the
    color's gradient times the tension, from which its forces do not derive exactly.
    """
    energy = np.zeros(len(workspace.rates[0]))
    if parameters.tension == COHESION:
        sum_cohesion(*_crowd(parameters, workspace), parameters.support, cohesion_strength(parameters), energy)
    elif parameters.tension == CSF:
        surface = np.zeros((CURVATURE + 1, workspace.fields.shape[1]))
        fill_normals(*_crowd(parameters, workspace), len(energy), surface)
        area = 2.0 * surface[LENGTH, : len(energy)] * workspace.fields[VOLUME, : len(energy)]
        energy[...] = parameters.material.surface_tension * area
    return float(energy.sum())


def cohesion_strength(parameters: Parameters) -> float:
    """With which the tension is the liquid's."""
    material, law = parameters.material, STRENGTHS[parameters.dimension]
    wanted = material.surface_tension / COUNTED[parameters.dimension]
    return law(wanted, material.density, parameters.support)


def surface_at(parameters: Parameters, workspace: Workspace) -> Array:
    """(5, columns) of the liquid and its images; zero for walls."""
    surface, liquid = np.zeros((CURVATURE + 1, workspace.fields.shape[1])), len(workspace.rates[0])
    fill_normals(*_crowd(parameters, workspace), liquid, surface)
    continue_to_images(parameters, workspace, surface)
    fill_curvatures(*_crowd(parameters, workspace), liquid, surface)
    continue_to_images(parameters, workspace, surface)
    return surface


def continue_to_images(parameters: Parameters, workspace: Workspace, surface: Array) -> None:
    """What the liquid has, its images have; mirrors turn directions around."""
    images, sides, real = workspace.images, parameters.boundary.sides, len(workspace.lists.counts)
    for side in range(len(sides.normal)):
        here = slice(images.start[side], images.start[side + 1])
        surface[:, real:][:, here] = surface[:, images.source[here]]
        if sides.mirrors[side]:
            axis = sides.normal[side]
            turned = surface[: parameters.dimension, real:][:, here]
            turned -= 2.0 * axis[:, None] * (axis @ turned)


def _crowd(parameters: Parameters, workspace: Workspace) -> tuple[Any, Any, Any, Any, Any]:
    lists = workspace.lists
    return workspace.fields, lists.counts, lists.neighbor, parameters.numbers, parameters.choices


@summing
def fill_normals(fields: Any, count: Any, neighbor: Any, numbers: Any, choices: Any, liquid: int, surface: Any) -> None:
    """The color's gradient sum_j V_j grad W at the liquid's columns: its direction, and its length where that tells."""
    kernel, deep, inverse = choices[KERNEL], choices[DIMENSION] == 3, numbers[INVERSE]
    for particle in prange(liquid):
        i = INDEX(particle)
        x, y, z = fields[X, i], fields[X + 1, i], fields[X + 2, i]
        sx, sy, sz = 0.0, 0.0, 0.0
        for k in range(INDEX(count[i])):
            j = INDEX(neighbor[i, k])
            dx, dy, dz = fields[X, j] - x, fields[X + 1, j] - y, fields[X + 2, j] - z
            square = dx * dx + dy * dy
            if deep:
                square += dz * dz
            share = slope_of(math.sqrt(square) * inverse, kernel) * fields[VOLUME, j]
            sx -= share * dx
            sy -= share * dy
            if deep:
                sz -= share * dz
        length = numbers[SCALE] * math.sqrt(sx * sx + sy * sy + sz * sz)
        if tension.normal_is_reliable(length, numbers[H]):
            surface[0, i] = numbers[SCALE] * sx / length
            surface[1, i] = numbers[SCALE] * sy / length
            surface[2, i] = numbers[SCALE] * sz / length
            surface[LENGTH, i] = length


@summing
def fill_curvatures(
    fields: Any, count: Any, neighbor: Any, numbers: Any, choices: Any, liquid: int, surface: Any
) -> None:
    """From how directions turn along the surface; neighbors count by the lengths of their gradients."""
    kernel, inverse, dimension = choices[KERNEL], numbers[INVERSE], choices[DIMENSION]
    for particle in prange(liquid):
        i = INDEX(particle)
        if surface[LENGTH, i] == 0.0:
            continue
        x, y, z = fields[X, i], fields[X + 1, i], fields[X + 2, i]
        nx, ny, nz = surface[0, i], surface[1, i], surface[2, i]
        turned, spread = 0.0, 0.0
        for k in range(INDEX(count[i])):
            j = INDEX(neighbor[i, k])
            dx, dy, dz = fields[X, j] - x, fields[X + 1, j] - y, fields[X + 2, j] - z
            if dimension == 2:
                dz = 0.0
            weight = -slope_of(math.sqrt(dx * dx + dy * dy + dz * dz) * inverse, kernel) * fields[VOLUME, j]
            weight *= surface[LENGTH, j]
            through = dx * nx + dy * ny + dz * nz
            dx, dy, dz = dx - through * nx, dy - through * ny, dz - through * nz
            turned += weight * ((surface[0, j] - nx) * dx + (surface[1, j] - ny) * dy + (surface[2, j] - nz) * dz)
            spread += weight * (dx * dx + dy * dy + dz * dz)
        surface[CURVATURE, i] = tension.curvature_of_turning(turned, spread, dimension)


@summing
def pull_by_curvature(
    fields: Any, count: Any, neighbor: Any, numbers: Any, choices: Any, surface: Any, strength: float, acceleration: Any
) -> None:
    """Add 2 sigma kappa grad(color) / rho, kappa being the mean over the surface around."""
    kernel, inverse, deep = choices[KERNEL], numbers[INVERSE], choices[DIMENSION] == 3
    for particle in prange(acceleration.shape[1]):
        i = INDEX(particle)
        length = surface[LENGTH, i]
        if length == 0.0:
            continue
        x, y, z = fields[X, i], fields[X + 1, i], fields[X + 2, i]
        own = value_of(0.0, kernel) * fields[VOLUME, i] * length
        total, whole = own * surface[CURVATURE, i], own
        for k in range(INDEX(count[i])):
            j = INDEX(neighbor[i, k])
            dx, dy, dz = fields[X, j] - x, fields[X + 1, j] - y, fields[X + 2, j] - z
            square = dx * dx + dy * dy
            if deep:
                square += dz * dz
            weight = value_of(math.sqrt(square) * inverse, kernel) * fields[VOLUME, j] * surface[LENGTH, j]
            total += weight * surface[CURVATURE, j]
            whole += weight
        force = 2.0 * tension.surface_force(strength, total / whole, length) / fields[RHO, i]
        add(acceleration, i, (force * surface[0, i], force * surface[1, i], force * surface[2, i]))


@summing
def pull_by_cohesion(
    fields: Any, count: Any, neighbor: Any, numbers: Any, choices: Any, support: float, strength: float,
    acceleration: Any,
) -> None:  # fmt: skip
    """Add sum_j gamma m_j C(r) x_ij/r, alike for both of a pair; walls and images pull like the liquid."""
    deep = choices[DIMENSION] == 3
    for particle in prange(acceleration.shape[1]):
        i = INDEX(particle)
        x, y, z = fields[X, i], fields[X + 1, i], fields[X + 2, i]
        ax, ay, az = 0.0, 0.0, 0.0
        for k in range(INDEX(count[i])):
            j = INDEX(neighbor[i, k])
            dx, dy, dz = fields[X, j] - x, fields[X + 1, j] - y, fields[X + 2, j] - z
            square = dx * dx + dy * dy
            if deep:
                square += dz * dz
            distance = math.sqrt(square)
            share = fields[VOLUME, j] * fields[RHO, j] * tension.cohesion_kernel(distance, support) / distance
            ax += share * dx
            ay += share * dy
            if deep:
                az += share * dz
        add(acceleration, i, (strength * ax, strength * ay, strength * az))


@summing
def sum_cohesion(
    fields: Any, count: Any, neighbor: Any, numbers: Any, choices: Any, support: float, strength: float, energy: Any
) -> None:  # fmt: skip
    """Half of each pair's energy goes to either particle, an image included; a wall's particle leaves all of it."""
    for particle in prange(len(energy)):
        i = INDEX(particle)
        total = 0.0
        for k in range(INDEX(count[i])):
            j = INDEX(neighbor[i, k])
            square = 0.0
            for axis in range(choices[DIMENSION]):
                square += (fields[X + axis, j] - fields[X + axis, i]) ** 2
            share = 1.0 - 0.5 * fields[LIQUID, j]
            total += share * fields[VOLUME, j] * fields[RHO, j] * tension.cohesion_energy(math.sqrt(square), support)
        energy[i] = strength * fields[VOLUME, i] * fields[RHO, i] * total


@compiled_inside
def add(acceleration: Any, i: Any, more: tuple[float, float, float]) -> None:
    """To one particle's."""
    for axis in range(acceleration.shape[0]):
        acceleration[axis, i] += more[axis]
