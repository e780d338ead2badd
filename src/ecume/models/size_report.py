"""The rows of `ecume check` for particles of several sizes."""

from __future__ import annotations

import numpy as np

from ecume.models.model import Row
from ecume.units import Array, with_prefix


def sizes_rows(radius: Array) -> list[Row]:
    """The rows on the moments of unequal radii: by number, and weighted by the surface and the volume of spheres. Empty
    if all are equal.
    """
    if float(np.ptp(radius)) == 0.0:
        return []
    mean, third = float(radius.mean()), float((radius**3).mean())
    spread = f"{100.0 * float(radius.std()) / mean:.3g} % of it, from {with_prefix(float(radius.min()), 'm', 3)}"
    surface, volume = third / float((radius**2).mean()), float((radius**4).mean()) / third
    return [
        ("mean radius", with_prefix(mean, "m", 4), f"spread {spread} to {with_prefix(float(radius.max()), 'm', 3)}"),
        ("mean by surface", with_prefix(surface, "m", 4), "<R^3>/<R^2>, of the volume per surface"),
        ("mean by volume", with_prefix(volume, "m", 4), "<R^4>/<R^3>, of the radius of the sphere around a point"),
    ]
