"""The family of elastic laws: how the surfaces of a contact give way along its normal, by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from ecume.laws.bubbles import bubble_energy, bubble_force
from ecume.laws.elasticity import surface_energy, surface_force


class SurfaceLaw(NamedTuple):
    """A law: force of a compression at a gap that is held, positive repels, and the energy that it is the slope of."""

    force: Callable[..., Any]
    energy: Callable[..., Any]


SURFACES = {"hertz": SurfaceLaw(surface_force, surface_energy), "bubble": SurfaceLaw(bubble_force, bubble_energy)}
"""`hertz`: elastic spheres; `bubble`: bubbles and drops. One more is a row here, its formulas in a file of their own,
and a branch in `surface_of` and `normal_energy` of `ecume.models.soft`."""
