"""Hydrodynamic interaction of floats: the velocities that forces give to all floats of a surface.

A float that moves carries the liquid around it along, and with it the other floats. Between half-immersed spheres at a
flat, stress-free surface the mobilities are twice those of whole spheres in unbounded liquid, by mirror symmetry. Other
depths enter through a hydrodynamic radius 2 f R with the factor f of `ecume.laws.drag.immersion_factor`, which gives
the drag of a single float exactly and is an approximation for pairs.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from ecume.errors import BadInput
from ecume.units import Array, Lengths, Number, Viscosity

MOST_SOLVED = 300
"""Floats of the largest raft whose speed is computed: a dense system of twice as many unknowns."""


class PairMobility(NamedTuple):
    """Velocity per force (m/(N s)) of one sphere by a force on another."""

    across: Array
    """for a force across the line of centers"""
    along: Array
    """for a force along the line of centers"""


def pair_mobility(separation: Lengths, radius: Lengths, other_radius: Lengths, viscosity: Viscosity) -> PairMobility:
    """The Rotne-Prager-Yamakawa mobility of two spheres in unbounded liquid, positive definite at any separation.

    (1/(8 pi eta r)) [(1 + s/(3 r^2)) I + (1 - s/r^2) e e^T] with s = a^2 + b^2 for separate spheres
    [rotne1969]; the forms for unequal spheres that overlap, and for one inside the other, are those of [zuk2014].
    Errors are of order (a/r)^4: 5 % for two touching spheres that move together. Approaching spheres need a film in
    addition. `separation` of the centers, zero or positive; numbers or arrays.

    >>> near = pair_mobility(2.0, 1.0, 1.0, 1.0)
    >>> round(float(6.0 * math.pi * near.along), 12), round(float(6.0 * math.pi * near.across), 12)
    (0.625, 0.4375)
    """
    r, a, b = np.broadcast_arrays(*(np.asarray(each, np.float64) for each in (separation, radius, other_radius)))
    if not (np.all(r >= 0.0) and np.all(a > 0.0) and np.all(b > 0.0) and viscosity > 0.0):
        raise BadInput(
            f"got separation {separation!r}, radii {radius!r} and {other_radius!r}, viscosity {viscosity!r}; "
            "expected positive numbers"
        )
    unit, nearest = 1.0 / (math.pi * viscosity), np.where(r > np.abs(a - b), r, a + b)
    strength, squares = unit / (8.0 * nearest), (a * a + b * b) / nearest**2
    separate = strength * (1.0 + squares / 3.0), strength * (1.0 - squares)
    strength, difference = unit / (6.0 * (a * b)) / (32.0 * nearest**3), (a - b) ** 2
    overlapping = (
        strength * (16.0 * nearest**3 * (a + b) - (difference + 3.0 * nearest**2) ** 2),
        strength * 3.0 * (difference - nearest**2) ** 2,
    )
    inside = unit / (6.0 * np.maximum(a, b)), np.zeros_like(r)
    cases = [r > a + b, r > np.abs(a - b)]
    across, beyond = (
        np.select(cases, [one, other], last) for one, other, last in zip(separate, overlapping, inside, strict=True)
    )
    return PairMobility(across, across + beyond)


def surface_mobility(position: Array, hydrodynamic_radius: Array, viscosity: Viscosity) -> Array:
    """The mobility matrix (2N, 2N) of floats at positions (N, 2): velocities (x, y of each float) by forces.

    Twice `pair_mobility`, since the surface is a plane of mirror symmetry; 1/(3 pi eta a) on the diagonal. Symmetric
    and positive definite. The radii are 2 f R: see this module.
    """
    count = len(position)
    apart = position[None, :, :] - position[:, None, :]
    distance = np.hypot(apart[..., 0], apart[..., 1])
    line = apart / np.where(distance > 0.0, distance, 1.0)[..., None]
    pair = pair_mobility(distance, hydrodynamic_radius[:, None], hydrodynamic_radius[None, :], viscosity)
    dyad = line[..., :, None] * line[..., None, :]
    blocks = 2.0 * (pair.across[..., None, None] * np.eye(2) + (pair.along - pair.across)[..., None, None] * dyad)
    return np.asarray(blocks.swapaxes(1, 2).reshape(2 * count, 2 * count))


def compact_raft(count: int) -> Array:
    """The centers (N, 2) of a compact raft of touching floats, in radii: the sites of a triangular lattice that are
    nearest to one of them. Hexagons for 7, 19, 37, 61 and 91 floats.
    """
    layers = math.ceil(math.sqrt(count)) + 1
    first, second = np.meshgrid(np.arange(-layers, layers + 1), np.arange(-layers, layers + 1), indexing="ij")
    sites = np.stack([2.0 * first + second, math.sqrt(3.0) * second], axis=-1).reshape(-1, 2)
    # Hexagonal layers, so that complete ones are hexagons.
    thirds = np.arange(6) * math.pi / 3.0 + math.pi / 6.0
    layer = np.round((sites @ np.stack([np.cos(thirds), np.sin(thirds)])).max(axis=1) / math.sqrt(3.0))
    return np.asarray(sites[np.lexsort((np.arctan2(sites[:, 1], sites[:, 0]), layer))][:count])


@functools.cache
def raft_speed_factor(count: int) -> Number:
    """How many times faster a compact raft of touching equal floats moves than one of them, each under the same force.

    N over the resistance of the raft, in resistances of one float, when all floats have the same velocity. It grows
    with the square root of the number of floats; rafts of more than `MOST_SOLVED` floats are extrapolated in this way.
    Without hydrodynamic interaction it is 1. Within a few percent of fully resolved flow.

    >>> [round(raft_speed_factor(count), 2) for count in (1, 7, 19)]
    [1.0, 3.45, 6.08]
    """
    if count > MOST_SOLVED:
        return raft_speed_factor(MOST_SOLVED) * math.sqrt(count / MOST_SOLVED)
    mobility = surface_mobility(compact_raft(count), np.ones(count), 1.0)
    motion = np.tile([1.0, 0.0], count)
    return float(count * 3.0 * math.pi / (motion @ np.linalg.solve(mobility, motion)))
