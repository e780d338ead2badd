"""What energy the liquid and the bodies in it have."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ecume._jit import admit, compiled
from ecume._portable import product
from ecume.laws import enthalpy
from ecume.laws.enthalpy import tait_energy
from ecume.models.sph.bodies import energy_of_bodies
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.state import PER_PARTICLE, State
from ecume.units import Array

admit(enthalpy)


def energies(parameters: Parameters, state: State, propped: float, surface: float) -> Mapping[str, float]:
    """Of motion, in gravity (a shake's pull is told as work), of compression, that of what leans on walls included, of
    the surface, and of the bodies.
    """
    material = parameters.material
    laws = material.density, material.sound_speed, material.exponent
    kinetic = 0.5 * float(np.sum(state.mass * (state.velocity**2).sum(axis=0)))
    potential = potential_of(parameters, state.mass, state.position)
    elastic = float(np.sum(state.mass * elastic_energies(state.density, *laws))) + propped
    bodies = energy_of_bodies(parameters, state.pose, state.motion)
    return {
        "kinetic_energy": kinetic,
        "potential_energy": potential,
        "elastic_energy": elastic,
        "surface_energy": surface,
        "bodies_energy": bodies,
        "total_energy": kinetic + potential + elastic + surface + bodies,
    }


@compiled
def elastic_energies(density: Array, reference_density: float, sound_speed: float, exponent: float) -> Array:
    """`tait_energy` of each particle (J/kg), by the C library's power function."""
    found = np.empty_like(density)
    for i in range(len(density)):
        found[i] = tait_energy(density[i], reference_density, sound_speed, exponent)
    return found


def potential_of(parameters: Parameters, mass: Array, position: Array) -> float:
    """Of places (d, N), in gravity and in the pull to a point (J)."""
    potential = -float(np.sum(mass * product(parameters.gravity, position)))
    away = position - parameters.pull_center[:, None]
    return potential + 0.5 * parameters.pull_rate**2 * float(np.sum(mass * (away**2).sum(axis=0)))


def energy_of(parameters: Parameters, state: State, who: Any) -> float:
    """Of motion, in gravity and of compression, of some of the particles (J)."""
    some = those(state, who)
    alone = energies(parameters, some, 0.0, 0.0)
    return alone["total_energy"] - alone["bodies_energy"]


def liquid_alone(parameters: Parameters, state: State) -> State:
    """Without the buffers behind in- and outflows."""
    return those(state, state.zone == 0) if parameters.gates else state


def those(state: State, who: Any) -> State:
    """The state of some of the particles."""
    return state._replace(**{name: getattr(state, name)[..., who] for name in PER_PARTICLE})
