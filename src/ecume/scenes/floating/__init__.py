"""The scene of the floating model: liquid, floats, dish, and which laws rule them."""

from ecume.scenes.floating.bodies import DiscSpec, FloatRow, FloatSpec, SurfaceEnergies
from ecume.scenes.floating.scene import FloatingScene, species_of
from ecume.scenes.floating.surroundings import (
    ContactSpec,
    DishSpec,
    FlowSpec,
    InteractionSpec,
    LiquidSpec,
    MotionSpec,
)

__all__ = [
    "ContactSpec",
    "DiscSpec",
    "DishSpec",
    "FloatRow",
    "FloatSpec",
    "FloatingScene",
    "FlowSpec",
    "InteractionSpec",
    "LiquidSpec",
    "MotionSpec",
    "SurfaceEnergies",
    "species_of",
]
