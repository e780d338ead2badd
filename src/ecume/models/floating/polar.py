"""Floats that are magnets, too: upright dipoles repel one another beside what their menisci do."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ecume._jit import admit, compiled
from ecume.engine.cells import Integers
from ecume.engine.neighbors import NeighborLists, Slots
from ecume.laws import dipoles
from ecume.laws.dipoles import dipole_energy, dipole_strength
from ecume.laws.pair_laws import Dipoles
from ecume.models.floating.forces import Sorted, forces
from ecume.models.floating.parameters import (
    CAPILLARY_LENGTH,
    CUTOFF,
    STRENGTH,
    SURFACE_TENSION,
    Parameters,
)
from ecume.models.floating.pulling import pairs_of, pull
from ecume.models.floating.schemes import predict, predict_rarely_with
from ecume.models.floating.state import State, Workspace
from ecume.models.floating.stepping import march_with
from ecume.units import Array

admit(dipoles)


class Polar(NamedTuple):
    """Moments: `Parameters.many` of a scene that has some."""

    moment: Array
    """(N,) A m^2, upwards"""
    pair: Array
    """the law's constants, the first of them as in `parameters.pack_pair`: strength of two unit moments, cutoff"""


class Magnets(NamedTuple):
    """Scratch in the order of the slots: that of all floats, and the moments."""

    charge: Array
    radius: Array
    force: Array
    pair: Array
    moment: Array
    push: Array
    """(2, N) N: forces of the dipoles"""


def make_polar(moment: Array, cutoff: float) -> Polar:
    """Moments that act up to a cutoff (m)."""
    pair = np.zeros(max(STRENGTH, CUTOFF, SURFACE_TENSION) + 1)
    pair[STRENGTH], pair[CUTOFF], pair[CAPILLARY_LENGTH] = dipole_strength(1.0, 1.0), cutoff, 1.0
    return Polar(np.asarray(moment, np.float64), pair)


def make_magnets(plain: Sorted, polar: Polar) -> Magnets:
    """Scratch."""
    return Magnets(*plain, np.zeros_like(polar.moment), np.zeros_like(plain.force))


@compiled
def polar_forces(
    law: Any, parameters: Parameters, position: Array, lists: NeighborLists, scratch: tuple[Magnets, Array]
) -> None:
    """Menisci, walls and dipoles."""
    magnets, force = scratch
    forces(law, parameters, position, lists, (magnets, force))
    order, rows, moment, push = lists.cells.order, lists.rows, magnets.moment, magnets.push
    pair, everyone = parameters.many.pair, parameters.many.moment
    count = len(order)
    for slot in range(count):
        moment[slot] = everyone[order[slot]]
    pull(Dipoles(pair[STRENGTH]), pairs_of(rows), (moment, magnets.radius), pair, push)
    for slot in range(count):
        force[order[slot], 0] += push[0, slot]
        force[order[slot], 1] += push[1, slot]


@compiled
def sum_of_dipole_energies(position: Array, polar: Polar, listed: tuple[Integers, Slots, Integers]) -> float:
    """Energies (J) of all pairs within the cutoff, each less its value there."""
    first, neighbor, order = listed
    moment, cutoff, total = polar.moment, polar.pair[CUTOFF], 0.0
    for slot in range(len(order)):
        i, own = order[slot], 0.0
        for place in range(first[slot], first[slot + 1]):
            j = order[neighbor[place]]
            x, y = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
            distance = math.sqrt(x * x + y * y)
            if i < j and 0.0 < distance < cutoff:
                strength = dipole_strength(moment[i], moment[j])
                own += dipole_energy(distance, strength) - dipole_energy(cutoff, strength)
        total += own
    return total


@compiled
def march_polar(law: Any, parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """The march of floats that are magnets."""
    return march_with(predict, polar_forces, law, parameters, state, workspace, steps)


@compiled
def predict_polar_rarely(law: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """For schemes that ask for forces on the way."""
    predict_rarely_with(polar_forces, law, parameters, state, workspace)


@compiled
def march_polar_rarely(law: Any, parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """The march for these schemes."""
    return march_with(predict_polar_rarely, polar_forces, law, parameters, state, workspace, steps)
