"""Sides that liquid comes in and goes out through, and who is lost through open ones.

Behind each such side there is a buffer as long as the support. Its particles move evenly and are neighbors like others,
so that the liquid before them never sees an end. Behind an inflow they have the velocity that was asked for, and the
pressure of the liquid before them; one that comes in leaves its place to a new one. Behind an outflow they keep the
velocity with which they went out, and have the pressure that was asked for; at the buffer's end they are gone.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ecume._jit import admit, compiled
from ecume._portable import length
from ecume.engine.cells import Integers
from ecume.errors import Fault, SceneError
from ecume.laws import enthalpy as enthalpies
from ecume.laws.flows import channel_speed
from ecume.models.sph.fields import Tait
from ecume.models.sph.methods import PRESSURE_FORCES
from ecume.models.sph.parameters import Gate, Parameters
from ecume.models.sph.state import (
    CAME,
    LEFT,
    LOST,
    NEXT,
    PER_PARTICLE,
    RENEWALS,
    SORT_EVERY,
    WORK,
    State,
    skin_for,
    sort_state,
)
from ecume.models.sph.work import brought
from ecume.scenes.sph import SIDES, SphScene
from ecume.units import Array

admit(enthalpies)
ENDS = ("inflow", "outflow")


def gates_of(scene: SphScene, support: float) -> tuple[Gate, ...]:
    """The sides with a buffer behind them."""
    found, tank = [], scene.tank
    transported = PRESSURE_FORCES[scene.method.pressure_force].transported
    if transported and any(side_of(scene, k).kind in ENDS for k in range(len(SIDES))):
        message = "came 'transport', which is for closed flows; with in- and outflows use 'sum'"
        raise SceneError([Fault("method.pressure_force", message)])
    if scene.central_force is not None and any(side_of(scene, k).kind in ENDS for k in range(2 * len(tank.low))):
        message = "goes with no in- or outflow: the pressure of the liquid behind those follows from gravity alone"
        raise SceneError([Fault("central_force", message)])
    layers = int(np.ceil(support / scene.spacing - 1e-9))
    for number in range(2 * len(tank.low)):
        side, axis = side_of(scene, number), number // 2
        if side.kind not in ENDS:
            continue
        low, high = np.array(tank.low), np.array(tank.high)
        if side.level is not None:
            high[1] = min(high[1], side.level)
        walls = np.array([_walled(scene, k) and k != axis for k in range(len(low))])
        found.append(
            Gate(
                zone=number + 1,
                axis=axis,
                inward=1.0 if number % 2 == 0 else -1.0,
                place=float((low if number % 2 == 0 else high)[axis]),
                enters=side.kind == "inflow",
                speed=side.speed or 0.0,
                curved=np.where(walls, 1.0 + (np.arange(len(low)) == 1) * (side.level is not None), 0.0)
                * (side.profile == "parabolic"),
                low=low,
                high=high,
                layers=layers,
                pressure=side.pressure,
            )
        )
    return tuple(found)


def side_of(scene: SphScene, number: int) -> Any:
    """A side of the tank."""
    return getattr(scene.tank, SIDES[number])


def _walled(scene: SphScene, axis: int) -> bool:
    """Whether there is a wall at the low end; what is above a level is air."""
    return bool(side_of(scene, 2 * axis).kind == "wall")


def bounds_of(scene: SphScene) -> Array:
    """(2, d) beyond which liquid that went through an open side is lost: one diagonal of the tank away from it."""
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    ends, far = np.array([low, high]), length(high - low)
    for number in range(2 * len(low)):
        kind = side_of(scene, number).kind
        sign = 2.0 * (number % 2) - 1.0
        ends[number % 2, number // 2] += sign * (far if kind == "open" or kind in ENDS else np.inf)
    return ends


def speed_at(gate: Gate, points: Array) -> Array:
    """(N,) how fast liquid goes through a gate at points (N, d) that it is mean of."""
    speed = np.full(len(points), gate.speed)
    for axis in np.flatnonzero(gate.curved):
        # Below a surface it is half of a channel of twice the depth.
        width = float(gate.high[axis] - gate.low[axis]) * gate.curved[axis]
        speed *= [channel_speed(y - gate.low[axis], width, 1.0) for y in points[:, axis]]
    return speed


def filled(parameters: Parameters, scene: SphScene, state: State) -> State:
    """The state at the start with all buffers: full behind an inflow, as full as the liquid before it behind an
    outflow.
    """
    for gate in parameters.gates:
        points = _rows(gate, parameters.spacing)
        velocity = np.zeros_like(points)
        velocity[:, gate.axis] = gate.inward * speed_at(gate, points)
        if not gate.enters:
            points, velocity = _continued(gate, parameters.spacing, state)
        mass = np.full(len(points), parameters.material.density * parameters.spacing ** points.shape[1])
        density = np.full(len(points), parameters.material.density)
        born = {"position": points.T, "velocity": velocity.T, "mass": mass, "density": density}
        state = _with(state, born, gate.zone)
    return state


def _rows(gate: Gate, spacing: float) -> Array:
    """The lattice of a buffer, row behind row."""
    axes = []
    for axis in range(len(gate.low)):
        count = round(float(gate.high[axis] - gate.low[axis]) / spacing)
        axes.append(gate.low[axis] + spacing * (np.arange(count) + 0.5))
    axes[gate.axis] = gate.place - gate.inward * spacing * (np.arange(gate.layers) + 0.5)
    return np.stack([grid.ravel() for grid in np.meshgrid(*axes, indexing="ij")], axis=1)


def _continued(gate: Gate, spacing: float, state: State) -> tuple[Array, Array]:
    """The row of liquid before an outflow, repeated behind it."""
    away = gate.inward * (state.position[gate.axis] - gate.place)
    row = (state.zone == 0) & (away < spacing) & (away >= 0.0)
    points, velocity = state.position[:, row].T, state.velocity[:, row].T
    step = np.zeros(points.shape[1])
    step[gate.axis] = -gate.inward * spacing
    behind = [points + (layer + 1) * step for layer in range(gate.layers)]
    return np.concatenate(behind), np.concatenate([velocity] * gate.layers)


def _with(state: State, born: dict[str, Array], zone: int) -> State:
    """The state with more particles, each with a number of its own."""
    count = born["position"].shape[1]
    state.crowd[NEXT] += count
    born = {
        **born,
        "identity": np.arange(state.crowd[NEXT] - count, state.crowd[NEXT]),
        "zone": np.full(count, zone),
    }
    grown = {}
    for name in PER_PARTICLE:
        array = getattr(state, name)
        more = born.get(name, np.zeros((*array.shape[:-1], count), array.dtype))
        grown[name] = np.ascontiguousarray(np.concatenate([array, more.astype(array.dtype)], axis=-1))
    return state._replace(**grown, reference=grown["position"].copy())


def feed(parameters: Parameters, state: State) -> None:
    """Give the buffers their pressures: of the liquid before an inflow, with its weight; of an outflow as asked."""
    pull, tait = parameters.gravity, parameters.tait
    for gate in parameters.gates:
        head = gate.pressure / parameters.material.density - float(pull[1] * gate.high[1])
        if gate.enters:
            reach = gate.place, gate.place + gate.inward * parameters.support
            head = mean_head(state.density, state.position, state.zone, pull, tait, gate.axis, reach)
        store_density(state.density, state.position, state.zone, pull, tait, gate.zone, head)


@compiled
def mean_head(
    density: Array, position: Array, zone: Integers, pull: Array, tait: Tait, axis: int, reach: tuple[float, float]
) -> float:
    """Enthalpy less what gravity does, of the liquid between two places along an axis; 0 where there is none."""
    total, count = 0.0, 0
    for i in range(len(density)):
        x = position[axis, i]
        if zone[i] == 0 and min(reach) <= x <= max(reach):
            total += enthalpies.tait_enthalpy(density[i], tait.density, tait.sound_speed, tait.exponent)
            for along in range(len(pull)):
                total -= pull[along] * position[along, i]
            count += 1
    return total / count if count else 0.0


@compiled
def store_density(
    density: Array, position: Array, zone: Integers, pull: Array, tait: Tait, own: int, head: float
) -> None:
    """Of a buffer's particles, at rest under gravity."""
    for i in range(len(density)):
        if zone[i] == own:
            enthalpy = head
            for along in range(len(pull)):
                enthalpy += pull[along] * position[along, i]
            density[i] = enthalpies.density_at_enthalpy(enthalpy, tait.density, tait.sound_speed, tait.exponent)


def still(state: State) -> None:
    """Nothing pushes the buffers, thickens them or shifts them; nothing in an outflow's flows back by itself."""
    held = np.flatnonzero(state.zone > 0)
    state.acceleration[:, held] = 0.0
    state.thickening[held] = 0.0
    state.transport[:, held] = 0.0


def due(parameters: Parameters, state: State) -> bool:
    """Whether somebody comes, goes or is lost."""
    comes, out, back, gone = _crossings(parameters, state)
    return bool(len(comes) or len(out) or len(back) or gone.any())


def _crossings(parameters: Parameters, state: State) -> tuple[Integers, Integers, Integers, Any]:
    """Who comes in from a buffer; who goes out into which; who comes back from one; flags of who is gone."""
    low, high = parameters.bounds
    gone = ((state.position < low[:, None]) | (state.position > high[:, None])).any(axis=0)
    comes, out, back = (np.zeros(len(gone), bool) for _ in range(3))
    for gate in parameters.gates:
        away = gate.inward * (state.position[gate.axis] - gate.place)
        mine, length = state.zone == gate.zone, gate.layers * parameters.spacing
        if gate.enters:
            comes |= mine & (away >= 0.0)
        else:
            back |= mine & (away >= 0.0)
            out |= (state.zone == 0) & (away < 0.0)
            gone |= mine & (away < -length)
    if gone.all():
        # There is no run without a particle: the last ones stay.
        gone[:] = False
    return np.flatnonzero(comes), np.flatnonzero(out), np.flatnonzero(back), gone


def exchange(parameters: Parameters, state: State) -> State:
    """The state with who came, and without who went; its lists are to be made anew."""
    comes, out, back, gone = _crossings(parameters, state)
    enter, leave = np.zeros_like(gone), gone & (state.zone == 0)
    enter[comes], enter[back], leave[out] = True, True, True
    state.books[WORK] += brought(parameters, state, enter & ~gone, leave)
    for gate in parameters.gates:
        if not gate.enters:
            away = gate.inward * (state.position[gate.axis, out] - gate.place)
            mine = out[away < 0.0]
            state.zone[mine] = gate.zone
            across = np.arange(parameters.dimension) != gate.axis
            state.velocity[np.ix_(across, mine)] = 0.0
    state.zone[back] = 0
    state.crowd[LEFT] += np.count_nonzero(gone & (state.zone > 0))
    state.crowd[LOST] += np.count_nonzero(gone & (state.zone == 0))
    state.crowd[CAME] += len(comes)
    for gate in parameters.gates:
        mine = comes[state.zone[comes] == gate.zone]
        born = {name: getattr(state, name)[..., mine].copy() for name in ("position", "velocity", "density", "mass")}
        born["position"][gate.axis] -= gate.inward * gate.layers * parameters.spacing
        state.zone[mine] = 0
        if len(mine):
            state = _with(state, born, gate.zone)
            gone = np.concatenate([gone, np.zeros(len(mine), bool)])
    kept = {name: np.ascontiguousarray(getattr(state, name)[..., ~gone]) for name in PER_PARTICLE}
    state = state._replace(**kept, reference=kept["position"].copy())
    if int(state.tally[RENEWALS]) % SORT_EVERY == 0:
        sort_state(parameters, state)
    state.tally[RENEWALS] += 1
    state.reference[...] = state.position
    state.skin[0] = skin_for(parameters, state)
    state.pose_reference[...] = state.pose
    state.clock[1] = state.clock[0]
    return state
