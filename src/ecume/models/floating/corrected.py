"""Pair forces corrected for what two bodies do to one another: between superposition and multipoles.

Each pair of kinds has a table of the energy that two bodies have beyond superposition, from the multipole solution,
with its slopes; between them it is a cubic, whose derivative is the force. What a third body does is left out.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.engine.neighbors import NeighborLists
from ecume.laws.flotation import Disc, Liquid, Sphere
from ecume.laws.special import bessel_k0, bessel_k1
from ecume.models.floating.many import Many, make_many
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.state import State, Workspace
from ecume.units import Array

Kind = tuple[Disc | Sphere, float]
"""A body and its charge (m)."""
NODES = 97
MOST_KINDS = 24
ORDER = 24
FARTHEST = 50.0
"""Reach of the two-body solutions, in capillary lengths."""


class Corrected(NamedTuple):
    """Tables for all pairs of kinds, over s = sqrt(distance/touching - 1)."""

    kind: Integers
    """(N,)"""
    touching: Array
    """(K, K) sum of the contact lines' radii (m)"""
    step: Array
    """(K, K) of s"""
    energy: Array
    """(K, K, NODES) J"""
    slope: Array
    """(K, K, NODES) dE/ds"""


def make_corrected(kinds: list[Kind], kind: Integers, liquid: Liquid, cutoff: float) -> Corrected:
    """The tables, each with a solution of two bodies at every node."""
    count, length = len(kinds), liquid.capillary_length
    many = make_many(kinds, liquid, ORDER, cutoff)
    radius = many.rims.radius * length
    touching = radius[:, None] + radius[None, :]
    step = np.sqrt(np.maximum(cutoff / touching - 1.0, 1.0)) / (NODES - 1)
    energy, slope = np.zeros((count, count, NODES)), np.zeros((count, count, NODES))
    for a in range(count):
        for b in range(a, count):
            s = step[a, b] * np.arange(NODES)
            distance = touching[a, b] * (1.0 + s * s)
            two = make_many([kinds[a], kinds[b]], liquid, ORDER, FARTHEST * length)
            product = 2.0 * math.pi * kinds[a][1] * kinds[b][1] / length**2
            found = np.array([_beyond(two, product, float(apart)) for apart in distance])
            energy[a, b] = energy[b, a] = found[:, 0] - found[-1, 0]
            slope[a, b] = slope[b, a] = -found[:, 1] * 2.0 * s * touching[a, b]
    return Corrected(kind, touching, step, energy, slope)


def _beyond(many: Many, product: float, apart: float) -> tuple[float, float]:
    """Energy and force (positive repels) of two bodies less those of superposition, K0 and K1 times `product`."""
    from ecume.laws.multipole import graf, solving

    x = apart / many.length
    at = np.array([[0.0, 0.0], [x, 0.0]])
    amplitudes = solving.eliminate(many.rims, many.echoes, at, many.rims.source)
    waves, force = np.zeros((2, ORDER + 2), np.complex128), np.zeros((2, 2))
    graf.receive_all(many.rims, many.echoes.mirrors, at, amplitudes, waves)
    graf.forces(many.rims, amplitudes, waves, force)
    energy = graf.energy(many.rims, amplitudes, waves, np.zeros_like(waves))
    return (
        many.tension * many.length**2 * (energy + product * bessel_k0(x)),
        many.tension * many.length * (float(force[1, 0]) + product * bessel_k1(x)),
    )


@compiled
def correction(tables: Corrected, i: int, j: int, distance: float) -> tuple[float, float]:
    """Energy and force (positive repels) beyond superposition; zero beyond the table, straight on below it."""
    a, b = tables.kind[i], tables.kind[j]
    touching, step = tables.touching[a, b], tables.step[a, b]
    s = math.sqrt(max(distance / touching - 1.0, 0.0))
    place = s / step
    if place >= NODES - 1:
        return 0.0, 0.0
    energy, slope = tables.energy[a, b], tables.slope[a, b]
    node = int(place)
    t, low, high = place - node, energy[node], energy[node + 1]
    left, right = step * slope[node], step * slope[node + 1]
    bend, twist = 3.0 * (high - low) - 2.0 * left - right, 2.0 * (low - high) + left + right
    value = low + t * (left + t * (bend + t * twist))
    # dE/ds over s, which has a limit at touching
    rising = left + t * (2.0 * bend + 3.0 * t * twist)
    change = rising / (step * s) if s > 1e-9 else 2.0 * bend / (step * step)
    repelled = -change / (2.0 * touching)
    return value - repelled * min(distance - touching, 0.0), repelled


@compiled
def add_corrections(tables: Corrected, position: Array, lists: NeighborLists, force: Array) -> float:
    """Add the corrections of all pairs of the lists to the forces; their energy."""
    order, first, neighbor = lists.cells.order, lists.rows.first, lists.rows.neighbor
    total = 0.0
    for slot in range(len(order)):
        i = order[slot]
        for place in range(first[slot], first[slot + 1]):
            j = order[neighbor[place]]
            x, y = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
            distance = math.sqrt(x * x + y * y)
            energy, repelled = correction(tables, i, j, distance)
            force[i, 0] -= repelled * x / distance
            force[i, 1] -= repelled * y / distance
            total += 0.5 * energy
    return total


@compiled
def corrected_forces(
    part: Corrected, own: Any, parameters: Parameters, position: Array, lists: NeighborLists, force: Array
) -> None:
    """Add the corrections of all pairs."""
    add_corrections(part, position, lists, force)


def corrected_energy(
    part: Corrected, own: Any, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """The energy of the corrections (J)."""
    return float(add_corrections(part, state.position, workspace.lists, np.zeros_like(state.position))), 0.0
