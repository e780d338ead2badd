"""The refusal of solids that are far too large for the spacing: a drawing in millimeters that is read in meters."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from ecume.errors import Fault, SceneError
from ecume.scenes.sph.scene import SphScene

MOST_POINTS = 2e8
"""The largest number of spacings in the box around a solid: a table of so many takes about 10 GB."""


def require_modest(scene: Any) -> None:
    """Raise SceneError for solids of a tank whose points would not fit into memory."""
    if isinstance(scene, SphScene) and (faults := list(_faults(scene))):
        raise SceneError(faults)


def _faults(scene: SphScene) -> Iterator[Fault]:
    for table in ("obstacles", "bodies"):
        for index, shape in enumerate(getattr(scene, table)):
            sides = _sides(shape)
            count = math.prod(side / scene.spacing for side in sides)
            if count > MOST_POINTS:
                path = "tank" if shape.name == "tank" else f"{table}[{index}]"
                size = " × ".join(f"{side:.4g}" for side in sides)
                yield Fault(
                    path,
                    f"is {size} m, which are {count:.2g} points at this spacing; expected at most {MOST_POINTS:g}: "
                    'give the unit of the drawing, as in outline_unit = "mm", or a larger spacing',
                )


def _sides(shape: Any) -> list[float]:
    """The sides of the box around a drawn shape (m); of others none."""
    points = [*(shape.vertices or ()), *(corner for triangle in shape.triangles or () for corner in triangle)]
    return [max(values) - min(values) for values in zip(*points, strict=True)]
