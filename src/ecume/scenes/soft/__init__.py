"""The scene of the soft model: spheres, the films between them, walls, and the protocol of deformation.

`scene.SoftScene` is the whole; start there. `walls` describes plane walls, `protocol` what is done over time.
"""

from ecume.scenes.soft.protocol import OscillationSpec, RateStepsSpec, StageSpec, expanded
from ecume.scenes.soft.scene import (
    CellSpec,
    FilmSpec,
    IntegrationSpec,
    LongRangeSpec,
    SoftHydrodynamicsSpec,
    SoftLiquid,
    SoftScene,
    SphereSpec,
    dimensions_of,
    sides_of,
    tension_law_of,
)
from ecume.scenes.soft.walls import SIDES, WallSpec

__all__ = [
    "SIDES",
    "CellSpec",
    "FilmSpec",
    "IntegrationSpec",
    "LongRangeSpec",
    "OscillationSpec",
    "RateStepsSpec",
    "SoftHydrodynamicsSpec",
    "SoftLiquid",
    "SoftScene",
    "SphereSpec",
    "StageSpec",
    "WallSpec",
    "dimensions_of",
    "expanded",
    "sides_of",
    "tension_law_of",
]
