"""The laws behind a scene of a tank, whose docstrings cite the papers."""

from __future__ import annotations

from typing import Any

from ecume.laws import diffusion, kernels, states, time_step_limits, viscous
from ecume.models.liquids import correlations_of
from ecume.models.model import Source
from ecume.models.sph import defaults, methods
from ecume.models.sph.substances import filled
from ecume.models.sph.tension import TENSIONS


def laws_of(scene: Any) -> list[Source]:
    """Kernel, pressure, diffusion, friction, tension, steps: as the model chooses them."""
    liquid, name = filled(scene.liquid), defaults.diffusion_of(scene, defaults.gravity_of(scene))
    excess = methods.DIFFUSIONS[name].excess
    form = kernels.KERNELS[scene.method.kernel]
    laws: list[Source] = [form.value, states.tait_pressure, states.numerical_sound_speed]
    laws += [diffusion.strength, excess] if excess is not None else []
    laws += [viscous.artificial_viscosity] if scene.method.artificial_viscosity else []
    if liquid.viscosity or defaults.turbulent(scene):
        laws += [defaults.friction_of(scene).law]
    laws += TENSIONS[defaults.tension_of(scene)].laws
    laws += [viscous.eddy_viscosity, viscous.subparticle_stress] if defaults.turbulent(scene) else []
    return [*laws, time_step_limits.acoustic_limit, time_step_limits.force_limit, *correlations_of(scene.liquid.name)]
