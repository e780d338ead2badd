"""The laws behind a scene of tracers, whose docstrings cite the papers."""

from __future__ import annotations

from typing import Any

from ecume.laws import brownian, drag
from ecume.models.liquids import correlations_of
from ecume.models.model import Source


def laws_of(scene: Any) -> list[Source]:
    """Drag and heat."""
    laws: dict[str, list[Source]] = {
        "stokes": [drag.stokes_friction],
        "schiller-naumann": [drag.stokes_friction, drag.schiller_naumann_factor],
    }
    heat: list[Source] = [brownian.diffusivity, brownian.displacement_variance] if scene.motion.brownian else []
    return [*laws.get(scene.motion.drag, []), *heat, *correlations_of(scene.liquid.name)]
