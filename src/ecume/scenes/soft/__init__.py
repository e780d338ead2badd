"""The scene of the soft model: spheres, the films between them, walls, and the protocol of deformation.

Start with `scene.SoftScene`, the whole scene. `protocol` describes the deformation over time.
"""

from ecume.scenes.soft.protocol import (
    NO_WAIT,
    OscillationSpec,
    RateStepsSpec,
    StageSpec,
    expanded,
    known_moments,
    waits,
    waits_of,
)
from ecume.scenes.soft.scene import (
    SIDES,
    CellSpec,
    FilmSpec,
    IntegrationSpec,
    LongRangeSpec,
    PermeationSpec,
    PreparationSpec,
    SoftHydrodynamicsSpec,
    SoftLiquid,
    SoftScene,
    SphereSpec,
    WallSpec,
    dimensions_of,
    first_fraction,
    sides_of,
    tension_law_of,
)

__all__ = [
    "NO_WAIT",
    "SIDES",
    "CellSpec",
    "FilmSpec",
    "IntegrationSpec",
    "LongRangeSpec",
    "OscillationSpec",
    "PermeationSpec",
    "PreparationSpec",
    "RateStepsSpec",
    "SoftHydrodynamicsSpec",
    "SoftLiquid",
    "SoftScene",
    "SphereSpec",
    "StageSpec",
    "WallSpec",
    "dimensions_of",
    "expanded",
    "first_fraction",
    "known_moments",
    "sides_of",
    "tension_law_of",
    "waits",
    "waits_of",
]
