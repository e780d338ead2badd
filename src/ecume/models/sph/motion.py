"""The elementwise parts of a step, over threads."""

from __future__ import annotations

import math
from typing import Any

from ecume._jit import compiled, prange, spread
from ecume.models.sph.fields import ACC, DIFFUSED, DRHO


@spread
def kick(velocity: Any, acceleration: Any, time: float) -> None:
    """V += a t."""
    for i in prange(velocity.shape[1]):
        for axis in range(velocity.shape[0]):
            velocity[axis, i] += time * acceleration[axis, i]


@spread
def drift(position: Any, velocity: Any, time: float) -> None:
    """X += v t."""
    for i in prange(position.shape[1]):
        for axis in range(position.shape[0]):
            position[axis, i] += time * velocity[axis, i]


@spread
def thicken(density: Any, thickening: Any, time: float) -> None:
    """Rho += (d rho/dt) t."""
    for i in prange(len(density)):
        density[i] += time * thickening[i]


@spread
def store_thickening(thickening: Any, rates: Any, density: Any, by_mass: bool) -> None:
    """D rho/dt: the sum is per density where neighbors count by their volumes."""
    for i in prange(len(density)):
        share = 1.0 if by_mass else density[i]
        thickening[i] = share * rates[DRHO, i] + rates[DIFFUSED, i]


@spread
def store_acceleration(acceleration: Any, rates: Any, density: Any, pull: Any, per_volume: bool) -> None:
    """A = what neighbors do, and gravity."""
    for i in prange(acceleration.shape[1]):
        share = 1.0 / density[i] if per_volume else 1.0
        for axis in range(acceleration.shape[0]):
            acceleration[axis, i] = share * rates[ACC + axis, i] + pull[axis]


@compiled
def largest(vectors: Any) -> float:
    """The largest length among the columns; NaN where one is."""
    most = 0.0
    for i in range(vectors.shape[1]):
        square = 0.0
        for axis in range(vectors.shape[0]):
            square += vectors[axis, i] * vectors[axis, i]
        if not square <= most:
            most = square
            if square != square:
                break
    return math.sqrt(most)


@compiled
def farthest(position: Any, reference: Any) -> float:
    """How far the fastest went from its place in the reference."""
    most = 0.0
    for i in range(position.shape[1]):
        square = 0.0
        for axis in range(position.shape[0]):
            along = position[axis, i] - reference[axis, i]
            square += along * along
        most = max(most, square)
    return math.sqrt(most)
