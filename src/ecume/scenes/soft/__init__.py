"""The scene of the soft model: spheres, the films between them, walls, and the protocol of deformation.

Start with `scene.SoftScene`, the whole scene. `protocol` describes the deformation over time.
"""

from ecume.scenes.soft.protocol import OscillationSpec, RateStepsSpec, StageSpec, expanded
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
    "sides_of",
    "tension_law_of",
]
