"""The march with the original program's pair law, which breaks Newton's third law; compiled when it is asked for."""

from __future__ import annotations

import math
from typing import Any

from ecume._jit import admit, compiled, compiled_inside
from ecume.engine.neighbors import NeighborLists
from ecume.laws import capillarity
from ecume.laws.capillarity import one_sided_legacy_force, pair_strength
from ecume.models.floating.forces import Sorted, forces_with
from ecume.models.floating.parameters import CAPILLARY_LENGTH, CUTOFF, SURFACE_TENSION, PairParameters, Parameters
from ecume.models.floating.schemes import predict, predict_rarely_with
from ecume.models.floating.state import State, Workspace
from ecume.models.floating.stepping import march_with
from ecume.units import Array

admit(capillarity)

LEAST_DISTANCE = 1e-300


@compiled_inside
def one_sided_pull(distance: float, own: PairParameters) -> float:
    """The pull (N) on i over the distance (m)."""
    strength = pair_strength(own.surface_tension, own.charge_j, own.charge_j)
    touching = own.radius_i + own.radius_j
    return -one_sided_legacy_force(distance, strength, own.capillary_length, touching) / distance


@compiled
def pull_one_sided(rows: Any, floats: Any, pair: Array, force: Array) -> None:
    """Forces on all slots. What two do to each other is not the same: every slot looks at all of its neighbors."""
    first, _, neighbor, x, y, _, _ = rows
    charge, radius = floats
    length, tension, cutoff = pair[CAPILLARY_LENGTH], pair[SURFACE_TENSION], pair[CUTOFF]
    for slot in range(force.shape[1]):
        total_x, total_y = 0.0, 0.0
        for place in range(first[slot], first[slot + 1]):
            j = neighbor[place]
            apart_x, apart_y = x[j] - x[slot], y[j] - y[slot]
            distance = max(math.sqrt(apart_x * apart_x + apart_y * apart_y), LEAST_DISTANCE)
            if distance < cutoff:
                own = PairParameters(radius[slot], radius[j], charge[slot], charge[j], length, tension)
                factor = one_sided_pull(distance, own)
                total_x += factor * apart_x
                total_y += factor * apart_y
        force[0, slot], force[1, slot] = total_x, total_y


@compiled
def forces_one_sided(
    parameters: Parameters, position: Array, lists: NeighborLists, scratch: tuple[Sorted, Array]
) -> None:
    """`forces_with` the original's pair law."""
    forces_with(pull_one_sided, parameters, position, lists, scratch)


@compiled
def predict_one_sided(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """`predict_rarely_with` the original's pair law."""
    predict_rarely_with(forces_one_sided, parameters, state, workspace)


@compiled
def march_one_sided(parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """The march with the original's pair law."""
    return march_with(predict, forces_one_sided, parameters, state, workspace, steps)


@compiled
def march_one_sided_rarely(parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """And with the schemes that are seldom asked for."""
    return march_with(predict_one_sided, forces_one_sided, parameters, state, workspace, steps)
