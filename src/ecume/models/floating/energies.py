"""Energies of superposed menisci: of all pairs of floats by the pair law, and of floats at the walls."""

from __future__ import annotations

import math
from typing import Any

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.engine.neighbors import Slots
from ecume.engine.walls import wall_count
from ecume.models.floating.forces import Sorted, Superposed
from ecume.models.floating.pair_choice import in_double, row_of_law
from ecume.models.floating.parameters import (
    CAPILLARY_LENGTH,
    CUTOFF,
    SURFACE_TENSION,
    Floats,
    PairParameters,
    Parameters,
)
from ecume.models.floating.pulling import pair_energy
from ecume.models.floating.state import State, Workspace
from ecume.models.floating.walls.wall_laws import acts, wall_energy
from ecume.units import Array


def superposed_energy(
    part: Superposed, own: Sorted, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """Energies (J) of all pairs and of all walls."""
    rows, pairs = (workspace.lists.rows.first, workspace.lists.rows.neighbor, workspace.lists.cells.order), 0.0
    if row_of_law(part.law).energy is not None:
        law = in_double(part.law, parameters)
        pairs = float(sum_of_pair_energies(law, state.position, parameters.floats, parameters.pair, rows))
    return pairs, float(sum_of_wall_energies(parameters, state.position))


@compiled
def sum_of_pair_energies(
    law: Any, position: Array, floats: Floats, pair: Array, rows: tuple[Integers, Slots, Integers]
) -> float:
    """Exact energies of all pairs within the cutoff, each less its value there, so that a pair that parts changes
    nothing.
    """
    first, neighbor, order = rows
    length, tension, cutoff = pair[CAPILLARY_LENGTH], pair[SURFACE_TENSION], pair[CUTOFF]
    radius, charge, total = floats.radius, floats.charge, 0.0
    for slot in range(len(order)):
        i = order[slot]
        own = 0.0
        for place in range(first[slot], first[slot + 1]):
            j = order[neighbor[place]]
            x, y = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
            distance = math.sqrt(x * x + y * y)
            if i < j and 0.0 < distance < cutoff:
                two = PairParameters(radius[i], radius[j], charge[i], charge[j], length, tension)
                own += pair_energy(distance, two, law) - pair_energy(cutoff, two, law)
        total += own
    return total


@compiled
def sum_of_wall_energies(parameters: Parameters, position: Array) -> float:
    """Energies of all floats in the walls' menisci, mirror images included."""
    strength, charge, total = parameters.wall_strength, parameters.floats.charge, 0.0
    if not acts(parameters):
        return total
    for i in range(position.shape[0]):
        place = (position[i, 0], position[i, 1])
        for number in range(wall_count(parameters.walls)):
            meniscus, image = wall_energy(parameters, number, place, strength[number, i], charge[i])
            total += meniscus
            total += image
    return total
