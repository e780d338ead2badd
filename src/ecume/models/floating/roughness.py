"""What a scene says of friction: coefficients, and how easily its floats turn."""

from __future__ import annotations

import math

import numpy as np

from ecume.errors import Fault, SceneError
from ecume.laws import drag, flotation, rotation
from ecume.models.floating.kinds import Afloat, distinct_kinds
from ecume.models.floating.pair_choice import require
from ecume.models.floating.parameters import IMPULSE, OVERDAMPED, RARE, VELOCITY_VERLET, Parameters
from ecume.models.floating.rubbing import Rough
from ecume.scenes.floating import FloatingScene
from ecume.units import Array


def with_friction(parameters: Parameters, scene: FloatingScene) -> Parameters:
    """The parameters of floats that rub. Raises SceneError where they cannot."""
    among, at_walls = scene.contacts.friction, scene.dish.friction if scene.dish is not None else 0.0
    key = "contacts.friction" if among > 0.0 else "dish.friction"
    require(parameters, key, "friction", "reciprocal")
    if parameters.contact_law != IMPULSE:
        raise _fault(key, "friction needs contacts.law = 'impulse', without a legacy coefficient")
    if parameters.scheme in RARE:
        raise _fault(key, "friction goes with 'velocity-verlet', the Euler schemes and 'overdamped'")
    kinds, number = distinct_kinds(scene)
    inertia = np.array([inertia_of(kind) for kind in kinds])[number]
    friction = np.array([turning_friction_of(kind, scene) for kind in kinds])[number]
    if getattr(parameters.many, "inertia", np.zeros(0)).size:
        friction = np.zeros_like(friction)  # drag at what turns by its rim is in that march
    decay, ease = spin_kick(parameters, inertia, friction)
    ease = np.concatenate([ease, np.zeros(len(parameters.kick.mobility) - len(ease))])
    return parameters._replace(rough=Rough((among, at_walls), inertia, decay, ease))


def inertia_of(kind: Afloat) -> float:
    """The moment of inertia of one of a kind about the vertical (kg m^2); added mass is not a part of it."""
    if isinstance(kind.body, flotation.Disc):
        return rotation.disc_inertia(kind.mass, kind.body.radius)
    return rotation.sphere_inertia(kind.density * 4.0 / 3.0 * math.pi * kind.radius**3, kind.radius)


def turning_friction_of(kind: Afloat, scene: FloatingScene) -> float:
    """The torque per spin of the liquid on one of a kind (N m s)."""
    viscosity = scene.liquid.viscosity if scene.motion.drag else 0.0
    if isinstance(kind.body, flotation.Disc):
        return drag.disc_turning_friction(kind.body.radius, viscosity)
    depth = min(max(math.pi - kind.equilibrium.filling_angle, 0.0), math.pi)
    return rotation.sphere_turning_friction(kind.radius, viscosity, float(rotation.turning_factor(depth)))


def spin_kick(parameters: Parameters, inertia: Array, friction: Array) -> tuple[Array, Array]:
    """What drag leaves of each spin over a kick of the scheme, and spin per angular impulse over it."""
    time = 0.5 * parameters.time_step if parameters.scheme == VELOCITY_VERLET else parameters.time_step
    if parameters.scheme == OVERDAMPED:
        return np.zeros_like(inertia), 1.0 / (friction * time)
    rate = friction / inertia * time
    with np.errstate(invalid="ignore", divide="ignore"):
        held = np.where(rate > 0.0, -np.expm1(-rate) / rate, 1.0)
    return np.exp(-rate), held / inertia


def _fault(path: str, message: str) -> SceneError:
    return SceneError([Fault(path, message)])
