"""Inflows and outflows, and the loss of particles through open sides.

Behind each inflow or outflow there is a buffer as long as the support. Its particles are neighbors like others, so that
the liquid has full support at the side. Behind an inflow they have the specified velocity, and the pressure of the
liquid at the side; a particle that enters is replaced by a new one in the buffer. Behind an outflow they start with the
velocity with which they left, are accelerated together like the liquid beside them, and have the specified pressure; at
the end of the buffer they are removed.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from ecume._jit import admit, compiled
from ecume.engine.cells import Integers
from ecume.engine.shapes import fitted_axis
from ecume.laws import states
from ecume.laws.flows import channel_speed
from ecume.models.sph.fields import Tait
from ecume.models.sph.parameters import OpenBoundary, Parameters, up_axis
from ecume.models.sph.report.energy_budget import exchanged_energy
from ecume.models.sph.state import (
    ENTERED,
    LEFT,
    LOST,
    NEXT,
    RENEWALS,
    SORT_EVERY,
    WORK,
    State,
    particle_arrays,
    skin_for,
    sort_state,
)
from ecume.units import Array

admit(states)


def speed_at(opening: OpenBoundary, points: Array) -> Array:
    """The speed (m/s) of the liquid through an open side at points (N, d), from its mean and its profile."""
    speed = np.full(len(points), opening.speed)
    for axis in np.flatnonzero(opening.curved):
        # With a free surface, the profile is half of the profile of a channel of twice the depth.
        width = float(opening.high[axis] - opening.low[axis]) * opening.curved[axis]
        speed *= [channel_speed(y - opening.low[axis], width, 1.0) for y in points[:, axis]]
    return speed


def with_buffers(parameters: Parameters, state: State) -> State:
    """The initial state with filled buffers: completely behind an inflow, and behind an outflow where it is adjacent to
    liquid.
    """
    for opening in parameters.open_boundaries:
        points, volume = _rows(opening, parameters.spacing)
        velocity = np.zeros_like(points)
        velocity[:, opening.axis] = opening.inward * speed_at(opening, points)
        if not opening.enters:
            points, velocity = _continued(opening, parameters.spacing, state)
        mass = np.full(len(points), parameters.material.density * volume)
        density = np.full(len(points), parameters.material.density)
        born = {"position": points.T, "velocity": velocity.T, "mass": mass, "density": density}
        state = _with(state, born, opening.zone)
    return state


def _rows(opening: OpenBoundary, spacing: float) -> tuple[Array, float]:
    """The rows of the lattice of a buffer, and the volume of its cells, which fit the width of the opening."""
    axes, volume = [], 1.0
    for axis in range(len(opening.low)):
        places, widths = fitted_axis(opening.low[axis], opening.high[axis], spacing)
        axes.append(places)
        volume *= spacing if axis == opening.axis else float(widths[0])
    axes[opening.axis] = opening.place - opening.inward * spacing * np.arange(0.5, opening.layers)
    return np.stack([grid.ravel() for grid in np.meshgrid(*axes, indexing="ij")], axis=1), volume


def _continued(opening: OpenBoundary, spacing: float, state: State) -> tuple[Array, Array]:
    """Positions and velocities of the particles behind an outflow: copies of the last row of liquid."""
    away = opening.inward * (state.position[opening.axis] - opening.place)
    row = (state.zone == 0) & (away < spacing) & (away >= 0.0)
    points, velocity = state.position[:, row].T, state.velocity[:, row].T
    step = np.zeros(points.shape[1])
    step[opening.axis] = -opening.inward * spacing
    behind = [points + (layer + 1) * step for layer in range(opening.layers)]
    return np.concatenate(behind), np.concatenate([velocity] * opening.layers)


def _with(state: State, born: dict[str, Array], zone: int) -> State:
    """The state with additional particles, which have new numbers."""
    count = born["position"].shape[1]
    state.population[NEXT] += count
    born = {
        **born,
        "identity": np.arange(state.population[NEXT] - count, state.population[NEXT]),
        "zone": np.full(count, zone),
    }
    grown = {}
    for name, array in particle_arrays(state).items():
        more = born.get(name, np.zeros((*array.shape[:-1], count), array.dtype))
        grown[name] = np.ascontiguousarray(np.concatenate([array, more.astype(array.dtype)], axis=-1))
    return state._replace(**grown, reference=grown["position"].copy())


def set_buffer_pressures(parameters: Parameters, state: State) -> None:
    """Set the pressures of buffers: hydrostatic, from the liquid at an inflow, or as specified at an outflow."""
    pull, tait = parameters.gravity, cast(Tait, parameters.equation_of_state)
    up = up_axis(parameters)
    for opening in parameters.open_boundaries:
        head = opening.pressure / parameters.material.density - float(pull[up] * opening.level)
        if opening.enters:
            reach = opening.place, opening.place + opening.inward * parameters.support
            head = mean_head(state.density, state.position, state.zone, pull, tait, opening.axis, reach)
        store_density(state.density, state.position, state.zone, pull, tait, opening.zone, head)


@compiled
def mean_head(
    density: Array, position: Array, zone: Integers, pull: Array, tait: Tait, axis: int, reach: tuple[float, float]
) -> float:
    """The mean of enthalpy plus potential energy of the liquid between two positions on an axis; 0 without liquid
    there.
    """
    total, count = 0.0, 0
    for i in range(len(density)):
        x = position[axis, i]
        if zone[i] == 0 and min(reach) <= x <= max(reach):
            total += states.tait_enthalpy(density[i], tait.density, tait.sound_speed, tait.exponent)
            for along in range(len(pull)):
                total -= pull[along] * position[along, i]
            count += 1
    return total / count if count else 0.0


@compiled
def store_density(
    density: Array, position: Array, zone: Integers, pull: Array, tait: Tait, own: int, head: float
) -> None:
    """Set the densities of the particles of a buffer to hydrostatic equilibrium under gravity."""
    for i in range(len(density)):
        if zone[i] == own:
            enthalpy = head
            for along in range(len(pull)):
                enthalpy += pull[along] * position[along, i]
            density[i] = states.density_at_enthalpy(enthalpy, tait.density, tait.sound_speed, tait.exponent)


def zero_buffer_rates(state: State) -> None:
    """Set the rates of buffer particles to zero: they are not accelerated, compressed or shifted."""
    held = np.flatnonzero(state.zone > 0)
    state.acceleration[:, held] = 0.0
    state.density_rate[held] = 0.0
    state.transport[:, held] = 0.0


def carry_outflows(parameters: Parameters, state: State) -> None:
    """Accelerate the buffer of each outflow like the liquid beside it, on average over its support, so that it makes
    room for liquid that starts or stops. In steady flow this is zero, and each particle keeps its own velocity.
    """
    for opening in parameters.open_boundaries:
        if not opening.enters:
            away = opening.inward * (state.position[opening.axis] - opening.place)
            beside = (state.zone == 0) & (away >= 0.0) & (away < parameters.support)
            if beside.any():
                state.acceleration[opening.axis, state.zone == opening.zone] = np.mean(
                    state.acceleration[opening.axis, beside]
                )


def exchange_due(parameters: Parameters, state: State) -> bool:
    """Whether a particle enters, leaves or is lost in this step."""
    if not parameters.open_boundaries:
        return bool(0 < number_beyond(state.position, parameters.bounds) < state.position.shape[1])
    comes, out, back, gone = _crossings(parameters, state)
    return bool(len(comes) or len(out) or len(back) or gone.any())


@compiled
def number_beyond(position: Array, bounds: Array) -> int:
    """The number of particles beyond the bounds (2, d)."""
    found = 0
    for i in range(position.shape[1]):
        beyond = False
        for axis in range(position.shape[0]):
            beyond |= position[axis, i] < bounds[0, axis] or position[axis, i] > bounds[1, axis]
        found += beyond
    return found


def _crossings(parameters: Parameters, state: State) -> tuple[Integers, Integers, Integers, Any]:
    """The particles that enter from a buffer, leave into one, and return from one; and flags of the particles that are
    removed.
    """
    low, high = parameters.bounds
    gone = ((state.position < low[:, None]) | (state.position > high[:, None])).any(axis=0)
    comes, out, back = (np.zeros(len(gone), bool) for _ in range(3))
    for opening in parameters.open_boundaries:
        away = opening.inward * (state.position[opening.axis] - opening.place)
        mine, length = state.zone == opening.zone, opening.layers * parameters.spacing
        if opening.enters:
            comes |= mine & (away >= 0.0)
        else:
            back |= mine & (away >= 0.0)
            out |= (state.zone == 0) & (away < 0.0)
            gone |= mine & (away < -length)
    if gone.all():
        # A run needs at least one particle, so the last ones are not removed.
        gone[:] = False
    return np.flatnonzero(comes), np.flatnonzero(out), np.flatnonzero(back), gone


def exchange(parameters: Parameters, state: State) -> State:
    """The state after particles entered and left; its lists must be renewed."""
    comes, out, back, gone = _crossings(parameters, state)
    enter, leave = np.zeros_like(gone), gone & (state.zone == 0)
    enter[comes], enter[back], leave[out] = True, True, True
    state.budget[WORK] += exchanged_energy(parameters, state, enter & ~gone, leave)
    for opening in parameters.open_boundaries:
        if not opening.enters:
            away = opening.inward * (state.position[opening.axis, out] - opening.place)
            mine = out[away < 0.0]
            state.zone[mine] = opening.zone
            across = np.arange(parameters.dimension) != opening.axis
            state.velocity[np.ix_(across, mine)] = 0.0
    state.zone[back] = 0
    state.population[LEFT] += np.count_nonzero(gone & (state.zone > 0))
    state.population[LOST] += np.count_nonzero(gone & (state.zone == 0))
    state.population[ENTERED] += len(comes)
    for opening in parameters.open_boundaries:
        mine = comes[state.zone[comes] == opening.zone]
        born = {name: getattr(state, name)[..., mine].copy() for name in ("position", "velocity", "density", "mass")}
        born["position"][opening.axis] -= opening.inward * opening.layers * parameters.spacing
        state.zone[mine] = 0
        if len(mine):
            state = _with(state, born, opening.zone)
            gone = np.concatenate([gone, np.zeros(len(mine), bool)])
    kept = {name: np.ascontiguousarray(array[..., ~gone]) for name, array in particle_arrays(state).items()}
    state = state._replace(**kept, reference=kept["position"].copy())
    if int(state.tally[RENEWALS]) % SORT_EVERY == 0:
        sort_state(parameters, state)
    state.tally[RENEWALS] += 1
    state.reference[...] = state.position
    state.skin[0] = skin_for(parameters, state)
    state.pose_reference[...] = state.pose
    state.clock[1] = state.clock[0]
    return state
