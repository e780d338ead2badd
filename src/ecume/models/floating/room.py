"""Whether a run fits into the machine."""

from __future__ import annotations

import psutil

from ecume.errors import Fault, SceneError
from ecume.models.floating.building import parameters_of
from ecume.models.floating.interactions import interactions_of
from ecume.models.floating.parameters import Parameters
from ecume.models.limits import within_steps
from ecume.scenes.floating import FloatingScene

ROOMIER = 1.6
"""How much longer rows of neighbors become when they were too short."""
BYTES_PER_FLOAT = 1200
BYTES_PER_NEIGHBOR = 4
BYTES_PER_POINT = 60
"""Of a grid: charges, their transform, waves, and two fields."""


def checked_parameters(scene: FloatingScene) -> Parameters:
    """The parameters of a scene that fits into the machine."""
    count = len(scene.rows) + sum(species.count for species in scene.particles)
    # Tested before anything is laid out: a hundred million floats are typed as quickly as a hundred.
    _require_memory(count, BYTES_PER_FLOAT * count)
    parameters = parameters_of(scene)
    _require_memory(count, memory_estimate(parameters))
    return within_steps(scene, parameters)


def memory_estimate(parameters: Parameters) -> float:
    """Bytes of a run, when the floats are packed to rafts."""
    count = len(parameters.floats.radius)
    packed = 0.92 * (parameters.reach / float(parameters.floats.radius.min())) ** 2
    grid = BYTES_PER_POINT * sum(row.points(part) for part, row in interactions_of(parameters))
    return grid + count * (BYTES_PER_FLOAT + BYTES_PER_NEIGHBOR * ROOMIER * min(packed, count))


def _require_memory(count: int, wanted: float) -> None:
    there = psutil.virtual_memory().total
    if wanted > there:
        raise SceneError(
            [
                Fault(
                    "particles",
                    f"{count} floats need about {wanted / 1e9:.3g} GB, this machine has {there / 1e9:.3g} GB; "
                    "use fewer floats, or a larger interaction.accuracy, which shortens the cutoff",
                )
            ]
        )
