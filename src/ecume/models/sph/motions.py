"""What moves beside the liquid, at an instant."""

from __future__ import annotations

from ecume.models.sph.bodies import placed
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.state import State
from ecume.units import Array


def instant(parameters: Parameters, state: State) -> Parameters:
    """The parameters with everything where it is now."""
    return at(parameters, float(state.clock[0]), state.pose, state.motion)


def at_reference(parameters: Parameters, state: State) -> Parameters:
    """With everything where it was when the lists were made."""
    return at(parameters, float(state.clock[1]), state.pose_reference, state.motion)


def at(parameters: Parameters, time: float, pose: Array, motion: Array) -> Parameters:
    """With everything where it is at a time."""
    if not parameters.moves:
        return parameters
    boundary = parameters.boundary
    dummies = placed(parameters.bodies, boundary.dummies, pose, motion)
    return parameters._replace(boundary=boundary._replace(dummies=dummies))
