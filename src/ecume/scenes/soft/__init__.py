"""The scene of the soft model: spheres, the films between them, what holds them, and what is done to them."""

from ecume.scenes.soft.protocol import OscillationSpec, StageSpec
from ecume.scenes.soft.scene import (
    BoxSpec,
    FilmSpec,
    RemoteSpec,
    SoftLiquid,
    SoftScene,
    SphereSpec,
    SteppingSpec,
    dimensions_of,
)

__all__ = [
    "BoxSpec",
    "FilmSpec",
    "OscillationSpec",
    "RemoteSpec",
    "SoftLiquid",
    "SoftScene",
    "SphereSpec",
    "StageSpec",
    "SteppingSpec",
    "dimensions_of",
]
