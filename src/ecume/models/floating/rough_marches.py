"""The marches of floats whose surfaces rub: one for each way in which their menisci act."""

from __future__ import annotations

from typing import Any

from ecume._jit import compiled
from ecume.models.floating import corrected, many
from ecume.models.floating.corrected import corrected_forces
from ecume.models.floating.forces import forces
from ecume.models.floating.many import give_turns, many_forces
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.rubbing import meet_rough, rest_rough
from ecume.models.floating.schemes import predict
from ecume.models.floating.state import State, Workspace
from ecume.models.floating.stepping import keep_lists, march_touching_with
from ecume.models.model import DONE


@compiled
def march_rough(law: Any, parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """By superposition."""
    return march_touching_with(predict, forces, meet_rough, rest_rough, law, parameters, state, workspace, steps)


@compiled
def march_rough_corrected(law: Any, parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """By corrected pair forces."""
    return march_touching_with(
        predict, corrected_forces, meet_rough, rest_rough, law, parameters, state, workspace, steps
    )


@compiled
def march_rough_many(law: Any, parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """By multipoles."""
    return march_touching_with(predict, many_forces, meet_rough, rest_rough, law, parameters, state, workspace, steps)


@compiled
def march_rough_turning(law: Any, parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """By multipoles whose torques turn the floats as well: half a kick of the spins before and after each step."""
    time, crowd = parameters.time_step, workspace.sorted_floats
    march_rough_many(law, parameters, state, workspace, 0)
    for _ in range(steps):
        status = keep_lists(parameters, state, workspace)
        if status != DONE:
            return status
        give_turns(parameters.many, crowd.torque, state.turning, 0.5 * time)
        status = march_rough_many(law, parameters, state, workspace, 1)
        if status != DONE:
            return status
        give_turns(parameters.many, crowd.torque, state.turning, 0.5 * time)
    return DONE


def advance(law: Any, parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """See `ecume.models.model.Model.advance`."""
    if isinstance(parameters.many, many.Many):
        turned = len(parameters.many.inertia) > 0
        return (march_rough_turning if turned else march_rough_many)(law, parameters, state, workspace, steps)
    if isinstance(parameters.many, corrected.Corrected):
        return march_rough_corrected(law, parameters, state, workspace, steps)
    return march_rough(law, parameters, state, workspace, steps)
