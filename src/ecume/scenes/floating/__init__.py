"""The scene of the floating model: liquid, floats, dish, and the laws of their interaction.

Start with `scene.FloatingScene`, the whole scene, with species and shapes. `surroundings` describes the liquid, the
dish, currents, contacts and interactions, `barriers` the moving side of a dish, and `sources` reads floats from tables
and other runs.
"""

from ecume.scenes.floating.barriers import BarrierSpec
from ecume.scenes.floating.scene import (
    DiscSpec,
    FloatingScene,
    FloatRow,
    FloatSpec,
    ShapeSpec,
    SurfaceEnergies,
    species_of,
)
from ecume.scenes.floating.surroundings import (
    ActivitySpec,
    CellSpec,
    ContactSpec,
    DishMotionSpec,
    DishSpec,
    DishTiltSpec,
    FlowSpec,
    HydrodynamicsSpec,
    IntegrationSpec,
    InteractionSpec,
    LiquidSpec,
    LubricationSpec,
    MagneticFieldSpec,
    NodesSpec,
    SurfactantDropSpec,
    SurfactantSourceSpec,
    SurfactantSpec,
    WaveSourceSpec,
    WavesSpec,
)

__all__ = [
    "ActivitySpec",
    "BarrierSpec",
    "CellSpec",
    "ContactSpec",
    "DiscSpec",
    "DishMotionSpec",
    "DishSpec",
    "DishTiltSpec",
    "FloatRow",
    "FloatSpec",
    "FloatingScene",
    "FlowSpec",
    "HydrodynamicsSpec",
    "IntegrationSpec",
    "InteractionSpec",
    "LiquidSpec",
    "LubricationSpec",
    "MagneticFieldSpec",
    "NodesSpec",
    "ShapeSpec",
    "SurfaceEnergies",
    "SurfactantDropSpec",
    "SurfactantSourceSpec",
    "SurfactantSpec",
    "WaveSourceSpec",
    "WavesSpec",
    "species_of",
]
