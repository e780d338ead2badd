"""The torques of the liquid on floats that turn about the vertical."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ecume.laws import drag, flotation
from ecume.models.floating.setup.kinds import FloatKind, distinct_kinds
from ecume.models.liquids import liquid_of
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene


def turning_friction_of(kind: FloatKind, scene: FloatingScene) -> float:
    """The torque of the liquid on one float, per spin (N m s)."""
    viscosity = liquid_of(scene).viscosity if scene.hydrodynamics.resists else 0.0
    if isinstance(kind.body, flotation.Disc):
        return drag.disc_turning_friction(kind.body.radius, viscosity)
    depth = min(max(math.pi - kind.equilibrium.filling_angle, 0.0), math.pi)
    return drag.sphere_turning_friction(kind.radius, viscosity, float(drag.turning_factor(depth)))


def turning_frictions(scene: FloatingScene) -> Array:
    """The torque of the liquid per spin on each float (N m s)."""
    kinds, number = distinct_kinds(scene)
    return np.array([turning_friction_of(kind, scene) for kind in kinds])[number]
