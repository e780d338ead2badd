"""What no machine could do, refused before it is begun."""

from __future__ import annotations

from typing import TypeVar

import psutil

from ecume.errors import Fault, SceneError
from ecume.scenes.common import Common
from ecume.scenes.quantities import MOST_STEPS

Parameters = TypeVar("Parameters")


def within_steps(scene: Common, parameters: Parameters) -> Parameters:
    """The same parameters, if a run with their time step comes to an end. Raises SceneError."""
    step: float = parameters.time_step  # type: ignore[attr-defined]  # every model's have one
    if scene.duration / step > MOST_STEPS:
        message = f"is {scene.duration / step:.3g} steps of {step:.3g} s, more than {MOST_STEPS:.0e}; make it shorter"
        raise SceneError([Fault("duration", message)])
    return parameters


def require_memory(path: str, what: str, wanted: float, way_out: str = "use fewer") -> None:
    """Raise SceneError if this machine has less memory (bytes) than something needs."""
    there = psutil.virtual_memory().total
    if wanted > there:
        message = f"{what} need about {wanted / 1e9:.3g} GB, this machine has {there / 1e9:.3g} GB; {way_out}"
        raise SceneError([Fault(path, message)])
