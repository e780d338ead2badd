"""From a state to a frame: particles in their order at the start, and the numbers of the whole."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ecume.laws.states import tait_pressure
from ecume.models.invariants import INJECTED
from ecume.models.sph.boundaries.forces_on_solids import loads
from ecume.models.sph.boundaries.prescribed_motion import drive_at, instant
from ecume.models.sph.boundaries.wall_impacts import all_braked
from ecume.models.sph.boundaries.walls import Repelled, all_repelled, energy_of, repulsion_load
from ecume.models.sph.integration.passive_particles import surroundings
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.rates.right_hand_side import fill
from ecume.models.sph.rates.surface_tension import surface_energy
from ecume.models.sph.report.energy_budget import energies, has_external_work, liquid_alone
from ecume.models.sph.report.gauges import readings
from ecume.models.sph.state import (
    CAME,
    GUARD_HITS,
    ITERATIONS,
    LEFT,
    LOST,
    MOST_ITERATIONS,
    MOST_SUBSTEPS,
    SUBSTEPS,
    WORK,
    State,
    Workspace,
)
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
    "surface_energy": "J",
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
    "leaning": "1",
    "came": "1",
    "left": "1",
    "lost": "1",
    "substeps": "1",
    "most_substeps": "1",
}


BODY_UNITS = {
    **dict.fromkeys("xyz", "m"),
    **{f"velocity_{axis}": "m/s" for axis in "xyz"},
    **{f"spin_{axis}": "1/s" for axis in "xyz"},
    "angle": "rad",
    "position": "m",
}
PER_DEPTH = {"J": "J/m", "N": "N/m", "N*m": "N*m/m", "kg": "kg/m", "kg*m/s": "kg/s", "m^3": "m^2"}
"""What 2D tanks report in the place of each unit: quantities are per meter of depth."""


def in_dimension(units: Mapping[str, str], dimension: int) -> dict[str, str]:
    """The units of a tank's quantities in 2D or 3D."""
    return {name: PER_DEPTH.get(unit, unit) if dimension == 2 else unit for name, unit in units.items()}


def observe(parameters: Parameters, state: State, workspace: Workspace) -> Frame:
    """The frame of this instant. In 2D energies, masses, momenta, forces and volumes are per meter of depth."""
    still = parameters.gravity
    parameters = instant(parameters, state)
    leaning = all_repelled(parameters, state)
    solid, units = of_solids(parameters, state, workspace, [*leaning, *all_braked(parameters, state)])
    propped = sum(energy_of(parameters, state, each) for each in leaning)
    state = liquid_alone(parameters, state)
    order = np.argsort(state.identity)
    arrays = {
        "position": np.ascontiguousarray(state.position[:, order].T),
        "velocity": np.ascontiguousarray(state.velocity[:, order].T),
        "density": state.density[order],
        "pressure": gauge_pressure(parameters, state)[order],
        "mass": state.mass[order],
        "species": state.region[order],
    }
    if parameters.passive_tracers.start[-1]:
        arrays = {
            name: np.concatenate([arrays[name], more])
            for name, more in passive_arrays(parameters, state, workspace).items()
        }
    surface = surface_energy(parameters, workspace)
    energy = energies(parameters._replace(gravity=still), state, propped, surface)
    numbers = {**energy, **motion(state), **extremes(parameters, state)}
    numbers["leaning"] = float(sum(len(each.who) for each in leaning))
    pressure = gauge_pressure(parameters, state)
    read, read_units = readings(parameters.gauges, state, pressure, parameters.support, parameters.pressure_reference)
    time = int(state.step[0]) * parameters.time_step
    listed = {name: float(numbers[name]) for name in NUMBER_UNITS}
    if parameters.bodies.shapes:
        listed["bodies_energy"] = energy["bodies_energy"]
    if parameters.projection is not None:
        listed |= of_solver(parameters, state)
        units |= dict.fromkeys(of_solver(parameters, state), "1")
    if has_external_work(parameters):
        listed[INJECTED] = float(state.budget[WORK])
    units |= {name: "J" for name in (INJECTED, "bodies_energy") if name in listed}
    units = in_dimension({**ARRAY_UNITS, **NUMBER_UNITS, **units, **read_units}, parameters.dimension)
    return Frame(time, arrays, {**listed, **solid, **read}, units)


def passive_arrays(parameters: Parameters, state: State, workspace: Workspace) -> dict[str, Array]:
    """Arrays with the passive particles after the liquid, as further species. They have no mass; their pressure is that
    of the liquid around, zero outside.
    """
    tracers, material, count = parameters.passive_tracers, parameters.material, state.passive_position.shape[1]
    group = np.repeat(np.arange(len(tracers.groups)), np.diff(tracers.start))
    density = np.array([each.density for each in tracers.groups])[group]
    return {
        "position": state.passive_position.T,
        "velocity": state.passive_velocity.T,
        "density": np.where(density > 0.0, density, material.density),
        "pressure": surroundings(parameters, workspace, state.passive_position).pressure
        - material.density * parameters.hydrostatic[1] * (parameters.surface - state.passive_position[1]),
        "mass": np.zeros(count),
        "species": tracers.regions + group,
    }


def of_solids(
    parameters: Parameters, state: State, workspace: Workspace, pushed: list[Repelled]
) -> tuple[dict[str, float], dict[str, str]]:
    """Forces and torques on walls, obstacles and bodies, hits of the guard, and poses of bodies, with units. In 2D
    forces are per meter of depth, and torques about z.
    """
    fill(parameters, state, workspace)
    axes, turns = "xyz"[: parameters.dimension], "z" if parameters.dimension == 2 else "xyz"
    numbers, units = dict[str, float](), dict[str, str]()
    more = [(parameters.boundary.names[each.owner], *repulsion_load(parameters, state, each)) for each in pushed]
    for name, force, torque in loads(parameters, workspace):
        force = sum((own for owner, own, _ in more if owner == name), start=force)
        torque = sum((own for owner, _, own in more if owner == name), start=torque)
        numbers |= {f"{name}_force_{axis}": float(force[k]) for k, axis in enumerate(axes)}
        numbers |= {f"{name}_torque_{axis}": float(torque["xyz".index(axis)]) for axis in turns}
        units |= dict.fromkeys((key for key in numbers if key.startswith(f"{name}_force")), "N")
        units |= dict.fromkeys((key for key in numbers if key.startswith(f"{name}_torque")), "N*m")
    names = parameters.boundary.names
    guarded = {names[k] for k in parameters.boundary.guard.owner}
    numbers |= {f"{name}_hits": float(state.hits[k]) for k, name in enumerate(names) if name in guarded}
    for body in range(len(parameters.bodies.shapes)):
        numbers |= pose_of(state, body, axes, turns)
    for side, drive in parameters.drives:
        numbers[f"{names[side]}_position"] = float(drive_at(drive, float(state.clock[0]))[0][0])
    return numbers, {name: units.get(name) or BODY_UNITS.get(name.split("_", 1)[1], "1") for name in numbers}


def pose_of(state: State, body: int, axes: str, turns: str) -> dict[str, float]:
    """Position, velocity, orientation and spin of a body; the orientation is an angle in 2D, a quaternion in 3D."""
    pose, move, name = state.pose[:, body], state.motion[:, body], f"body{body}"
    found = {f"{name}_{axis}": float(pose[k]) for k, axis in enumerate(axes)}
    found |= {f"{name}_velocity_{axis}": float(move[k]) for k, axis in enumerate(axes)}
    found |= {f"{name}_spin_{axis}": float(move[3 + "xyz".index(axis)]) for axis in turns}
    if len(axes) == 2:
        return {**found, f"{name}_angle": 2.0 * math.atan2(pose[6], pose[3])}
    return {**found, **{f"{name}_q{part}": float(pose[3 + k]) for k, part in enumerate("wxyz")}}


def of_solver(parameters: Parameters, state: State) -> dict[str, float]:
    """Iterations since the start, the most in a substep, and the mean of what the density is too large by."""
    excess = np.maximum(state.density / parameters.material.density - 1.0, 0.0)
    return {
        "iterations": float(state.tally[ITERATIONS]),
        "most_iterations": float(state.tally[MOST_ITERATIONS]),
        "density_error": float(np.mean(excess)),
    }


def pressure_in(parameters: Parameters, state: State) -> Array:
    """(N,) Pa: Tait's, or that of the solver for incompressible liquids."""
    material = parameters.material
    if parameters.projection is not None:
        return state.pressure.copy()
    found: Array = tait_pressure(state.density, material.density, material.sound_speed, material.exponent)
    return found


def gauge_pressure(parameters: Parameters, state: State) -> Array:
    """(N,) Pa: Tait's, and the hydrostatic part where the forces leave it out."""
    material = parameters.material
    pressure = pressure_in(parameters, state)
    depth = parameters.surface - state.position[1]
    pressure -= material.density * parameters.hydrostatic[1] * depth
    return pressure


def motion(state: State) -> Mapping[str, float]:
    """Momentum and center of mass; z is zero in two dimensions."""
    total = float(np.sum(state.mass))
    momentum, center = np.zeros(3), np.zeros(3)
    momentum[: len(state.velocity)] = np.sum(state.velocity * state.mass, axis=1)
    center[: len(state.position)] = np.sum(state.position * state.mass, axis=1) / total
    names = "xyz"
    return {
        **{f"momentum_{name}": momentum[axis] for axis, name in enumerate(names)},
        **{f"center_{name}": center[axis] for axis, name in enumerate(names)},
    }


def extremes(parameters: Parameters, state: State) -> Mapping[str, float]:
    """Extent, largest speed, pressure and density change, and counts of substeps and exchanged particles."""
    change = np.abs(state.density / parameters.material.density - 1.0)
    return {
        "front": state.position[0].max(),
        "top": state.position[1].max(),
        "largest_speed": np.sqrt((state.velocity**2).sum(axis=0).max()),
        "largest_pressure": gauge_pressure(parameters, state).max(),
        "density_change": change.max(),
        "volume": np.sum(state.mass / state.density),
        "guard_hits": state.tally[GUARD_HITS],
        "came": state.population[CAME],
        "left": state.population[LEFT],
        "lost": state.population[LOST],
        "substeps": state.tally[SUBSTEPS],
        "most_substeps": state.tally[MOST_SUBSTEPS],
    }
