"""What a table or another run says of single particles of liquid, over what follows from their places."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume.engine.shapes import Flags
from ecume.models.sph.parameters import Liquid
from ecume.scenes.sph import RegionSpec
from ecume.units import Array


class Said(NamedTuple):
    """Of a region's particles; not a number where nothing was said."""

    velocity: Array
    """(n, d), zero where nothing was said: it is added to the region's own"""
    density: Array
    mass: Array


def said_of(region: RegionSpec, kept: Flags) -> Said:
    """Of those that were kept."""
    given, count = region.particles, int(kept.sum())
    unsaid = np.full(count, np.nan)
    if given is None:
        return Said(np.zeros((count, 1)), unsaid, unsaid)
    velocity, density, mass = (
        np.array(each)[kept] if each else None for each in (given.velocities, given.densities, given.masses)
    )
    return Said(
        np.zeros((count, 1)) if velocity is None else velocity,
        unsaid if density is None else density,
        unsaid if mass is None else mass,
    )


def with_said(liquid: Liquid, told: list[Said]) -> Liquid:
    """The liquid with what was said of its regions, one after the other."""
    dimension = len(liquid.position)
    velocity = np.concatenate([np.broadcast_to(each.velocity, (len(each.density), dimension)) for each in told])
    density, mass = np.concatenate([each.density for each in told]), np.concatenate([each.mass for each in told])
    dense = np.where(np.isnan(density), liquid.density, density)
    return liquid._replace(
        velocity=np.ascontiguousarray(liquid.velocity + velocity.T),
        density=dense,
        mass=np.where(np.isnan(mass), liquid.mass / liquid.density * dense, mass),
    )
