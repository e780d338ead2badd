"""Elementwise updates of all particles, and maxima over them, in threads."""

from __future__ import annotations

import math

import numpy as np

from ecume._jit import compiled_inside, prange, spread, summing
from ecume.units import Array

BLOCKS = 16
"""The number of blocks of particles whose maxima are taken separately."""


@spread
def kick(velocity: Array, acceleration: Array, time: float) -> None:
    """Advance velocities with constant accelerations, v += a t."""
    for i in prange(velocity.shape[1]):
        for axis in range(velocity.shape[0]):
            velocity[axis, i] += time * acceleration[axis, i]


@spread
def drift(position: Array, velocity: Array, time: float) -> None:
    """Advance positions with constant velocities, x += v t."""
    for i in prange(position.shape[1]):
        for axis in range(position.shape[0]):
            position[axis, i] += time * velocity[axis, i]


@spread
def advance_density(density: Array, density_rate: Array, time: float) -> None:
    """Advance densities with constant rates, rho += (drho/dt) t."""
    for i in prange(len(density)):
        density[i] += time * density_rate[i]


@spread
def predict(
    velocity: Array, acceleration: Array, density: Array, density_rate: Array, before: Array, time: float
) -> None:
    """Predict densities and velocities with the present rates, and copy the rates to `before`. The velocities are
    already half a step ahead.
    """
    dimension, count = velocity.shape
    for i in prange(count):
        for axis in range(dimension):
            before[axis, i] = acceleration[axis, i]
            velocity[axis, i] += 0.5 * time * acceleration[axis, i]
        before[dimension, i] = density_rate[i]
        density[i] += time * density_rate[i]


@spread
def correct(
    velocity: Array, acceleration: Array, density: Array, density_rate: Array, before: Array, time: float
) -> None:
    """Correct the predicted values by half the difference between the present rates and those in `before`."""
    dimension, count = velocity.shape
    for i in prange(count):
        for axis in range(dimension):
            velocity[axis, i] += 0.5 * time * (acceleration[axis, i] - before[axis, i])
        density[i] += 0.5 * time * (density_rate[i] - before[dimension, i])


def largest(vectors: Array) -> float:
    """The largest length of the columns; not finite if any column is not."""
    most = np.zeros(BLOCKS)
    largest_squares(vectors, most)
    return math.sqrt(most.max())


@summing
def largest_squares(vectors: Array, most: Array) -> None:
    """Write the largest square of each block of particles."""
    dimension, count = vectors.shape
    each = (count + len(most) - 1) // len(most)
    for block in prange(len(most)):
        found, total = 0.0, 0.0
        for i in range(np.uint64(block * each), np.uint64(min(count, (block + 1) * each))):
            square = 0.0
            for axis in range(dimension):
                square += vectors[axis, i] * vectors[axis, i]
            found = square if square > found else found
            total += square
        most[block] = larger_or_nowhere(found, total)


def farthest(position: Array, reference: Array) -> float:
    """The largest displacement from the reference; not finite if any position is not."""
    most = np.zeros(BLOCKS)
    farthest_squares(position, reference, most)
    return math.sqrt(most.max())


@summing
def farthest_squares(position: Array, reference: Array, most: Array) -> None:
    """Write the largest square of each block of particles."""
    dimension, count = position.shape
    each = (count + len(most) - 1) // len(most)
    for block in prange(len(most)):
        found, total = 0.0, 0.0
        for i in range(np.uint64(block * each), np.uint64(min(count, (block + 1) * each))):
            square = 0.0
            for axis in range(dimension):
                along = position[axis, i] - reference[axis, i]
                square += along * along
            found = square if square > found else found
            total += square
        most[block] = larger_or_nowhere(found, total)


@compiled_inside
def larger_or_nowhere(found: float, total: float) -> float:
    """The largest of some squares, or their sum if it is not finite, since comparisons ignore NaN."""
    return found if total < math.inf else total
