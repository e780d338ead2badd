"""Small scenes are checked in plain Python: to load compiled code takes longer than the few loops that a check runs."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ecume.scenes.schema import Scene

FEW = 200
"""Floats that are placed at random in plain Python as soon as compiled code is loaded."""

own_process: list[bool] = []
"""Not empty where this process runs one command and ends."""


def without_compiler(scene: Scene) -> None:
    """Have no code compiled from now on, if the check of a scene needs little computation and nothing comes after."""
    if own_process and "numba" not in sys.modules and is_small(scene):
        os.environ["NUMBA_DISABLE_JIT"] = "1"


def is_small(scene: Scene) -> bool:
    """Whether few floats are placed; a tank's lattices are NumPy's."""
    from ecume.scenes.floating import FloatingScene
    from ecume.scenes.sph import SphScene

    if isinstance(scene, FloatingScene):
        return sum(species.count for species in scene.particles) + len(scene.rows) <= FEW
    return isinstance(scene, SphScene) and not any(
        region.particles or region.triangles or region.vertices for region in scene.fluid
    )
