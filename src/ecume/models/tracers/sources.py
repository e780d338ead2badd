"""The laws behind a scene of tracers, whose docstrings cite the papers."""

from __future__ import annotations

from typing import Any

from ecume.laws import brownian
from ecume.models.liquids import correlations_of
from ecume.models.model import Source
from ecume.models.tracers.parameters import DRAGS


def laws_of(scene: Any) -> list[Source]:
    """Drag and heat."""
    heat: list[Source] = [brownian.diffusivity, brownian.displacement_variance] if scene.motion.brownian else []
    return [*DRAGS[scene.motion.drag].papers, *heat, *correlations_of(scene.liquid.name)]
