"""What a scene says of friction: coefficients, and how easily its floats turn."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ecume.laws import drag, flotation, rotation
from ecume.models.floating.kinds import Afloat, distinct_kinds
from ecume.models.floating.options import Built
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.rubbing import Rough
from ecume.models.liquids import liquid_of
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene


def friction_of(parameters: Parameters, scene: FloatingScene, interactions: tuple[Any, ...]) -> Built:
    """Floats that rub; what depends on the time step comes later."""
    kinds, number = distinct_kinds(scene)
    inertia = np.array([inertia_of(kind) for kind in kinds])[number]
    friction = np.array([turning_friction_of(kind, scene) for kind in kinds])[number]
    coefficients = scene.contacts.friction, scene.dish.friction if scene.dish is not None else 0.0
    return Built(Rough(coefficients, inertia, friction, friction))


def friction_at_step(part: Rough, parameters: Parameters, turned: Array | None) -> Rough:
    """The part with the kicks of its spins. Where interactions turn the floats, too, these take care of drag."""
    friction = part.decay if turned is None else np.zeros_like(part.decay)
    decay, ease = spin_kick(parameters, part.inertia, friction)
    walls = np.zeros(len(parameters.kick.mobility) - len(ease))
    return part._replace(decay=decay, ease=np.concatenate([ease, walls]))


def inertia_of(kind: Afloat) -> float:
    """The moment of inertia of one of a kind about the vertical (kg m^2); added mass is not a part of it."""
    if isinstance(kind.body, flotation.Disc):
        return rotation.disc_inertia(kind.mass, kind.body.radius)
    return rotation.sphere_inertia(kind.density * 4.0 / 3.0 * math.pi * kind.radius**3, kind.radius)


def turning_friction_of(kind: Afloat, scene: FloatingScene) -> float:
    """The torque per spin of the liquid on one of a kind (N m s)."""
    viscosity = liquid_of(scene).viscosity if scene.hydrodynamics.resists else 0.0
    if isinstance(kind.body, flotation.Disc):
        return drag.disc_turning_friction(kind.body.radius, viscosity)
    depth = min(max(math.pi - kind.equilibrium.filling_angle, 0.0), math.pi)
    return rotation.sphere_turning_friction(kind.radius, viscosity, float(rotation.turning_factor(depth)))


def spin_kick(parameters: Parameters, inertia: Array, friction: Array) -> tuple[Array, Array]:
    """What drag leaves of each spin over a kick of the scheme, and spin per angular impulse over it."""
    time = 0.5 * parameters.time_step if parameters.scheme.half_kicks else parameters.time_step
    if not parameters.scheme.inertia:
        return np.zeros_like(inertia), 1.0 / (friction * time)
    rate = friction / inertia * time
    with np.errstate(invalid="ignore", divide="ignore"):
        held = np.where(rate > 0.0, -np.expm1(-rate) / rate, 1.0)
    return np.exp(-rate), held / inertia
