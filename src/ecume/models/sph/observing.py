"""From a state to a frame: particles in their order at the start, and the numbers of the whole."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ecume.laws.enthalpy import tait_energy
from ecume.laws.states import tait_pressure
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.state import GUARD_HITS, MOST_SUBSTEPS, SUBSTEPS, State, Workspace
from ecume.trajectories.frame import Frame
from ecume.units import Array

ARRAY_UNITS = {
    "position": "m",
    "velocity": "m/s",
    "density": "kg/m^3",
    "pressure": "Pa",
    "mass": "kg",
    "species": "1",
}
NUMBER_UNITS = {
    "kinetic_energy": "J",
    "potential_energy": "J",
    "elastic_energy": "J",
    "total_energy": "J",
    "momentum_x": "kg*m/s",
    "momentum_y": "kg*m/s",
    "momentum_z": "kg*m/s",
    "center_x": "m",
    "center_y": "m",
    "center_z": "m",
    "front": "m",
    "top": "m",
    "largest_speed": "m/s",
    "largest_pressure": "Pa",
    "density_change": "1",
    "volume": "m^3",
    "guard_hits": "1",
    "substeps": "1",
    "most_substeps": "1",
}


def observe(parameters: Parameters, state: State, workspace: Workspace) -> Frame:
    """The frame of this instant. In two dimensions energies, momenta and volumes are per meter of depth."""
    order = np.argsort(state.identity)
    arrays = {
        "position": np.ascontiguousarray(state.position[:, order].T),
        "velocity": np.ascontiguousarray(state.velocity[:, order].T),
        "density": state.density[order],
        "pressure": gauge_pressure(parameters, state)[order],
        "mass": state.mass[order],
        "species": state.region[order],
    }
    numbers = {**energies(parameters, state), **motion(state), **extremes(parameters, state)}
    time = int(state.step[0]) * parameters.time_step
    return Frame(time, arrays, {name: float(numbers[name]) for name in NUMBER_UNITS}, {**ARRAY_UNITS, **NUMBER_UNITS})


def gauge_pressure(parameters: Parameters, state: State) -> Array:
    """(N,) Pa: Tait's, and the hydrostatic part where the forces leave it out."""
    material = parameters.material
    pressure: Array = tait_pressure(state.density, material.density, material.sound_speed, material.exponent)
    depth = parameters.surface - state.position[1]
    pressure -= material.density * parameters.hydrostatic[1] * depth
    return pressure


def energies(parameters: Parameters, state: State) -> Mapping[str, float]:
    """Of motion, in gravity, and of compression."""
    material = parameters.material
    laws = material.density, material.sound_speed, material.exponent
    kinetic = 0.5 * float(np.sum(state.mass * (state.velocity**2).sum(axis=0)))
    potential = -float(np.sum(state.mass * (parameters.gravity @ state.position)))
    elastic = float(np.sum(state.mass * tait_energy(state.density, *laws)))
    return {
        "kinetic_energy": kinetic,
        "potential_energy": potential,
        "elastic_energy": elastic,
        "total_energy": kinetic + potential + elastic,
    }


def motion(state: State) -> Mapping[str, float]:
    """Momentum and center of mass; z is zero in two dimensions."""
    total = float(np.sum(state.mass))
    momentum, center = np.zeros(3), np.zeros(3)
    momentum[: len(state.velocity)] = state.velocity @ state.mass
    center[: len(state.position)] = state.position @ state.mass / total
    names = "xyz"
    return {
        **{f"momentum_{name}": momentum[axis] for axis, name in enumerate(names)},
        **{f"center_{name}": center[axis] for axis, name in enumerate(names)},
    }


def extremes(parameters: Parameters, state: State) -> Mapping[str, float]:
    """How far, how high, how fast, how dense; and what the step had to do."""
    change = np.abs(state.density / parameters.material.density - 1.0)
    return {
        "front": state.position[0].max(),
        "top": state.position[1].max(),
        "largest_speed": np.sqrt((state.velocity**2).sum(axis=0).max()),
        "largest_pressure": gauge_pressure(parameters, state).max(),
        "density_change": change.max(),
        "volume": np.sum(state.mass / state.density),
        "guard_hits": state.tally[GUARD_HITS],
        "substeps": state.tally[SUBSTEPS],
        "most_substeps": state.tally[MOST_SUBSTEPS],
    }
