"""Hydrodynamic interaction of floats: the velocities of all floats of a surface by forces.

A moving float drags the liquid around it, and with it the other floats. Between half-immersed spheres at a flat,
stress-free surface the mobilities are twice those of whole spheres in unbounded liquid, by mirror symmetry; with a
second liquid above, those in a liquid of half the sum of the viscosities. Other depths enter through a hydrodynamic
radius 2 f R with the factor f of `ecume.laws.immersion.immersion_factor`, which gives the drag of a single float
exactly and is an approximation for pairs.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from ecume.errors import BadInput
from ecume.units import Array, Length, Lengths, Number, Viscosity

MOST_SOLVED = 300
"""Floats of the largest raft whose speed is computed, from a dense system of twice as many unknowns."""


class PairMobility(NamedTuple):
    """Velocity per force (m/(N s)) of one sphere by a force on another."""

    across: Array
    """for a force perpendicular to the line of centers"""
    along: Array
    """for a force along the line of centers"""


def pair_mobility(separation: Lengths, radius: Lengths, other_radius: Lengths, viscosity: Viscosity) -> PairMobility:
    """The Rotne-Prager-Yamakawa mobility of two spheres in unbounded liquid: `rotne_prager` over 6 pi eta.

    Numbers or arrays; `separation` of the centers, zero or positive. [rotne1969; zuk2014].

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
    across, along = np.vectorize(rotne_prager, otypes=[np.float64, np.float64])(r, a, b)
    unit = 1.0 / (6.0 * math.pi * viscosity)
    return PairMobility(unit * across, unit * along)


def rotne_prager(separation: Length, radius: Length, other_radius: Length) -> tuple[float, float]:
    """Velocity of one sphere per force on another, times 6 pi eta (1/m): for forces perpendicular to the line of
    centers, and along it.

    3/(4 r) [(1 + s/(3 r^2)) I + (1 - s/r^2) e e^T] with s = a^2 + b^2 for separate spheres [rotne1969]; the forms for
    unequal spheres that overlap, and for one inside the other, are those of [zuk2014]. Positive definite at any
    separation. Errors are of order (a/r)^4: 5 % for two touching spheres that move together. Approaching spheres need
    a film in addition.

    >>> rotne_prager(2.0, 1.0, 1.0), rotne_prager(0.0, 2.0, 1.0)
    ((0.4375, 0.625), (0.5, 0.5))
    """
    r, a, b = separation, radius, other_radius
    if r > a + b:
        squares = (a * a + b * b) / (r * r)
        return 0.75 / r * (1.0 + squares / 3.0), 0.75 / r * (2.0 - 2.0 * squares / 3.0)
    if r > abs(a - b):
        cube, difference = 32.0 * r * r * r * (a * b), (a - b) * (a - b)
        across = (16.0 * r * r * r * (a + b) - (difference + 3.0 * r * r) ** 2) / cube
        return across, across + 3.0 * (difference - r * r) ** 2 / cube
    return 1.0 / max(a, b), 1.0 / max(a, b)


def surface_divergence(separation: Length, radius: Length, other_radius: Length) -> float:
    """Divergence of the mobility of two spheres whose centers remain in one plane, times 6 pi eta
    (1/m^2).

    (M_across - M_along)/r, for the velocity of one sphere by forces on the other, with respect to the place of the
    other and along the direction to it. In 3D the divergence is zero, since liquid is incompressible: dM_along/dr =
    -2 (M_along - M_across)/r. In a plane one of the two transverse directions is missing. The result is negative: the
    drift kT div M is repulsive. [rotne1969].

    >>> surface_divergence(2.0, 1.0, 1.0)
    -0.09375
    """
    if separation == 0.0:
        return 0.0
    across, along = rotne_prager(separation, radius, other_radius)
    return (across - along) / separation


def spin_by_force(separation: Length, radius: Length, other_radius: Length) -> float:
    """Angular velocity of a sphere per force on another, perpendicular to the line of centers,
    times 6 pi eta (1/m^2).

    3/(4 r^2) for separate spheres; `radius` is that of the rotating sphere. The velocity of the other by a torque on
    this one has the same coefficient. Overlapping spheres as in [zuk2014].

    >>> spin_by_force(2.0, 1.0, 1.0)
    0.1875
    """
    r, a, b = separation, radius, other_radius
    if r > a + b:
        return 0.75 / (r * r)
    if r > abs(a - b):
        shape = (a - b + r) ** 2 * (b * b + 2.0 * b * (a + r) - 3.0 * (a - r) ** 2)
        return 0.375 * shape / (8.0 * r * r * a * a * a * b)
    return 0.75 * r / (a * a * a) if a > b else 0.0


def spin_by_torque(separation: Length, radius: Length, other_radius: Length) -> float:
    """Angular velocity of a sphere per torque on another, both about an axis perpendicular to the line of centers,
    times 6 pi eta (1/m^3).

    -3/(8 r^3) for separate spheres; overlapping ones as in [zuk2014].

    >>> spin_by_torque(2.0, 1.0, 1.0), spin_by_torque(0.0, 1.0, 1.0)
    (-0.046875, 0.75)
    """
    r, a, b = separation, radius, other_radius
    if r > a + b:
        return -0.375 / (r * r * r)
    if r > abs(a - b):
        squares, cubes, difference = a * a + b * b, a * a * a + b * b * b, (a - b) * (a - b)
        shape = 5.0 * r**6 - 27.0 * r**4 * squares + 32.0 * r**3 * cubes - 9.0 * r * r * difference * (a + b) ** 2
        shape -= difference * difference * (squares + 4.0 * a * b)
        return 0.75 * shape / (64.0 * r**3 * (a * b) ** 3)
    return 0.75 / max(a, b) ** 3


def surface_mobility(position: Array, hydrodynamic_radius: Array, viscosity: Viscosity) -> Array:
    """Mobility matrix (2N, 2N) of floats at positions (N, 2): velocities (x, y of each float) by
    forces.

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
    # Distances in the hexagonal norm, so that complete layers are hexagons.
    thirds = np.arange(6) * math.pi / 3.0 + math.pi / 6.0
    layer = np.round((sites @ np.stack([np.cos(thirds), np.sin(thirds)])).max(axis=1) / math.sqrt(3.0))
    return np.asarray(sites[np.lexsort((np.arctan2(sites[:, 1], sites[:, 0]), layer))][:count])


@functools.cache
def raft_speed_factor(count: int) -> Number:
    """Ratio of the speed of a compact raft of touching equal floats to that of one float, each
    under the same force.

    It is N over the resistance of the raft, in units of that of one float, with equal velocities of all floats. It
    grows
    with the square root of the number of floats; rafts of more than `MOST_SOLVED` floats are extrapolated in this way.
    Without hydrodynamic interaction it is 1. Rotne and Prager's mobilities are those of separate spheres to the third
    order in a/r: for spheres that touch, the factor is larger than that of fully resolved Stokes flow, by 4.2 % for 2
    floats, 7.4 % for 3, 7.1 % for 7 (where it is 3.22), 5.3 % for 19 and 4.4 % for 37.

    >>> [round(raft_speed_factor(count), 2) for count in (1, 7, 19)]
    [1.0, 3.45, 6.08]
    """
    if count > MOST_SOLVED:
        return raft_speed_factor(MOST_SOLVED) * math.sqrt(count / MOST_SOLVED)
    mobility = surface_mobility(compact_raft(count), np.ones(count), 1.0)
    motion = np.tile([1.0, 0.0], count)
    return float(count * 3.0 * math.pi / (motion @ np.linalg.solve(mobility, motion)))
