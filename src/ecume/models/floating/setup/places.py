"""Initial positions and velocities of floats that a scene specifies, and the region of floats at random positions."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecume.engine.placement import Region, place_on_lattice, place_on_ring
from ecume.engine.walls import rings
from ecume.models.floating.parameters import Parameters
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene, FloatSpec

OPEN_COVERAGE = 0.15
"""The fraction of the square that floats cover when placed at random without a dish."""


class Places(NamedTuple):
    """The initial position and velocity of each float of the scene; NaN if they are random."""

    position: Array
    velocity: Array


def given_places(scene: FloatingScene) -> Places:
    """The positions and velocities in the scene: first the tables of floats, then the rows."""
    positions = [_places_of(species, middle_of(scene)) for species in scene.particles]
    velocities = [_velocities_of(species) for species in scene.particles]
    if scene.rows:
        positions.append(np.array([(row.x, row.y) for row in scene.rows]))
        velocities.append(np.array([(row.vx, row.vy) for row in scene.rows]))
    return Places(np.concatenate(positions), np.concatenate(velocities))


def _velocities_of(species: FloatSpec) -> Array:
    return np.array(species.velocities) if species.velocities else np.tile(species.velocity, (species.count, 1))


def middle_of(scene: FloatingScene) -> tuple[float, float]:
    """The center of the cell (m); without a cell, the origin, which is the center of dishes."""
    width, height = scene.sides
    return 0.5 * width, 0.5 * height


def _places_of(species: FloatSpec, middle: tuple[float, float]) -> Array:
    if species.positions:
        return np.array(species.positions)
    if species.placement == "lattice" and species.spacing is not None:
        return place_on_lattice(species.count, species.spacing, species.center or middle)
    if species.placement == "ring" and species.ring_radius is not None:
        return place_on_ring(species.count, species.ring_radius, species.center or middle)
    return np.full((species.count, 2), np.nan)


def region_of(parameters: Parameters) -> Region:
    """The region in which floats can be placed at random."""
    low, high = rings.bounds(parameters.walls)
    side = 0.5 * math.sqrt(math.pi * float(np.sum(parameters.floats.radius**2)) / OPEN_COVERAGE)
    if np.all(parameters.periods[0] > 0.0):
        width, height = parameters.periods[0].tolist()
        return Region((0.0, 0.0), (width, height), parameters.walls, periodic=True)
    if math.inf in high:
        low, high = (-side, -side), (side, side)
    return Region(low, high, parameters.walls)


def outermost_places(parameters: Parameters, scene: FloatingScene) -> Array:
    """The given positions of floats, and the corners of the region of those that are placed at random (M, 2)."""
    found = given_places(scene).position
    free = np.isnan(found[:, 0])
    if not np.any(free):
        return found
    region = region_of(parameters)
    corners = [(x, y) for x in (region.low[0], region.high[0]) for y in (region.low[1], region.high[1])]
    return np.concatenate([found[~free], corners])
