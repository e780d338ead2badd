"""How long a step may be: what sound, viscosity, surface tension and light bodies allow."""

from __future__ import annotations

import math

from ecume.errors import Fault, SceneError
from ecume.laws.time_step_limits import (
    acoustic_limit,
    body_drag_limit,
    body_sound_limit,
    radial_excess,
    tension_limit,
    viscous_limit,
)
from ecume.models.sph.bodies import mass_of
from ecume.models.sph.boundaries import holds
from ecume.models.sph.defaults import friction_of, kernel_of, smoothing_of, tension_of
from ecume.models.sph.parameters import Material
from ecume.models.sph.solids import shape_of
from ecume.scenes.sph import BodySpec, SphScene

LENIENT = 4.0
"""How many times longer than the laws of thumb allow a step may be that somebody asks for."""
BODIES = "the lightest body"


def limits_of(scene: SphScene, material: Material) -> dict[str, float]:
    """The longest step (s), by what limits it; infinite where nothing does."""
    h, courant = smoothing_of(scene), scene.integration.courant_number
    tension = material.surface_tension if tension_of(scene) != "none" else 0.0
    return {
        "sound": acoustic_limit(h, material.sound_speed, material.fastest, courant),
        "viscosity": viscous_limit(h, material.viscosity / material.density),
        "surface tension": tension_limit(h, material.density, tension),
        BODIES: min((body_limit(scene, spec, material) for spec in scene.bodies), default=math.inf),
    }


def body_limit(scene: SphScene, spec: BodySpec, material: Material) -> float:
    """The longest step (s) in which a body does not overreact to the liquid before it."""
    shape, kernel, h = shape_of(spec), kernel_of(scene), smoothing_of(scene)
    areal_mass = mass_of(spec, shape) / shape.surface()
    pressed = body_sound_limit(areal_mass, material.density, material.sound_speed, kernel.overlap / h)
    viscosity = material.viscosity * holds(spec, material)
    if friction_of(scene).radial:
        viscosity *= radial_excess(kernel.dim)
    return min(pressed, body_drag_limit(areal_mass, viscosity, float(kernel.over_plane(0.0)) / h))


def steps_of(scene: SphScene, material: Material) -> tuple[float, int]:
    """The time step and how many fit between two frames."""
    limits = limits_of(scene, material)
    longest = min(limits.values())
    wanted = scene.integration.time_step or longest
    # The others are laws of thumb with much to spare; a body that is too light for its step diverges.
    if wanted > min(LENIENT * longest, limits[BODIES]):
        message = f"came {wanted:g} s; {limiter(limits)} asks for {longest:.3g} s or less"
        raise SceneError([Fault("integration.time_step", message)])
    per_frame = max(1, math.ceil(scene.frame_every / wanted * (1.0 - 1e-9)))
    return scene.frame_every / per_frame, per_frame


def limiter(limits: dict[str, float]) -> str:
    """What sets the step."""
    return min(limits, key=lambda name: limits[name])
