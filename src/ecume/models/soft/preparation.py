"""The initial state of a packing that is compressed and relaxed before time 0."""

from __future__ import annotations

import math

import numpy as np

from ecume.engine.cells import Integers
from ecume.errors import Fault, SceneError
from ecume.models.model import DIVERGED
from ecume.models.soft import setup
from ecume.models.soft.integration.linear_solvers import begin_step
from ecume.models.soft.integration.time_stepping import advance
from ecume.models.soft.parameters import Parameters, Planes
from ecume.models.soft.protocol import at_frames, drive_at, protocol_of, rules_at
from ecume.models.soft.report.diagnosis import diagnosis
from ecume.models.soft.report.observation import AXES, observe
from ecume.models.soft.state import CLOCK, LENGTH, PAST_ERROR, UPRIGHT, State, resting_layers, waiting_rates, workspace
from ecume.scenes.soft import SIDES, PreparationSpec, SoftScene, StageSpec, dimensions_of, first_fraction, sides_of
from ecume.units import Array

DENSEST = 1.4
"""The largest volume fraction of a compression to a given pressure."""
LONGEST = 1000
"""The longest relaxation, in units of 1/rate."""
FAINT = 1e-9
"""The force below which a contact counts as open, over the largest modulus times radius squared."""


def start(scene: SoftScene, parameters: Parameters) -> State:
    """The state at time 0. Raises SceneError."""
    if scene.preparation is None:
        return setup.start(scene, parameters)
    state = _prepared(scene, scene.preparation, parameters)
    state = state._replace(**resting_layers(parameters, len(state.position)))
    if not parameters.drag.any():
        setup.require_hold(parameters, state)
        setup.require_no_torque(parameters, state)
    state.wall_rate[:] = parameters.walls.surfaces.velocity
    _rewind(scene, parameters, state)
    for since_then in (state.velocity, state.spin, state.tally, state.budget):
        since_then[:] = 0
    state.orientation[:] = UPRIGHT[parameters.torque.shape[1]]
    return state._replace(**waiting_rates(parameters))


def unprepared(scene: SoftScene, parameters: Parameters) -> State:
    """The state at which a preparation begins, or that at time 0 without one. Raises SceneError."""
    if scene.preparation is None:
        return setup.start(scene, parameters)
    return setup.start(scene, _pressing(scene, scene.preparation, parameters))


def _pressing(scene: SoftScene, spec: PreparationSpec, parameters: Parameters) -> Parameters:
    """The parameters of the compression: of the cell, or by the wall that has a pressure."""
    quiet = _unloaded(scene, parameters)
    if not scene.walls:
        protocol = protocol_of(compression(scene, spec))
        return quiet._replace(protocol=at_frames(protocol, quiet.steps_per_frame, quiet.time_step, quiet.end))
    inward, (axis, _) = quiet.walls.surfaces.place * pressed_wall(scene, parameters), section_of(scene)
    velocity = inward * sides_of(scene)[axis] * setup.compression_rate(scene, parameters)
    return quiet._replace(walls=_moved(quiet.walls, velocity), protocol=protocol_of(()))


def _unloaded(scene: SoftScene, parameters: Parameters) -> Parameters:
    """The parameters without loads and without an end, with frames at intervals of 1/rate, with walls at rest, and
    without permeation: the liquid has time to flow.
    """
    nothing = {name: np.zeros_like(getattr(parameters, name)) for name in ("force", "torque", "weight")}
    walls = parameters.walls._replace(force=np.zeros_like(parameters.walls.force), free=np.zeros((0, 2), np.int64))
    walls = _moved(walls, np.zeros_like(walls.surfaces.velocity))
    tick = 1.0 / setup.compression_rate(scene, parameters) / parameters.steps_per_frame
    return parameters._replace(time_step=tick, end=math.inf, walls=walls, permeation=(), **nothing)


def _moved(walls: Planes, velocity: Array) -> Planes:
    """The walls with these velocities."""
    return walls._replace(surfaces=walls.surfaces._replace(velocity=np.ascontiguousarray(velocity)))


def pressed_wall(scene: SoftScene, parameters: Parameters) -> Array:
    """1 for the wall that has a pressure, which compresses the packing; 0 for others; (W, 1)."""
    return np.array([[float(wall.pressure is not None)] for wall in scene.walls]).reshape(-1, 1)


def _prepared(scene: SoftScene, spec: PreparationSpec, parameters: Parameters) -> State:
    """The packing at the end of its preparation."""
    resting = pressing = _pressing(scene, spec, parameters)
    state, last = setup.start(scene, pressing), _latest(scene, spec, pressing)
    while state.pace[CLOCK] < last and not _presses(scene, pressing, state):
        _go(pressing, state, 0)
    passed = float(state.pace[CLOCK])
    if spec.pressure is not None:
        if not _presses(scene, pressing, state):
            cause = f"is not reached at a volume fraction of {DENSEST:g}; expected a lower one"
            raise SceneError([Fault("preparation.pressure", cause)])
        resting = _pressed(scene, spec.pressure, parameters)
        _rewind(scene, resting, state)
    change = _relax(resting, state, spec.relaxed)
    return state._replace(prepared=np.array([passed + float(state.pace[CLOCK]), change]))


def _latest(scene: SoftScene, spec: PreparationSpec, pressing: Parameters) -> float:
    """The time (s) at which the compression ends at the latest."""
    if not scene.walls:
        return float(pressing.protocol.times[-1])
    return (1.0 - first_fraction(scene) / DENSEST) / setup.compression_rate(scene, pressing)


def _pressed(scene: SoftScene, pressure: float, parameters: Parameters) -> Parameters:
    """The parameters of a rest at this pressure, which is that of the cell, or of the wall that has a pressure."""
    quiet = _unloaded(scene, parameters)
    if not scene.walls:
        return quiet._replace(protocol=protocol_of((StageSpec(time=0.0, pressure=pressure),)))
    wall, (axis, area) = int(pressed_wall(scene, parameters).argmax()), section_of(scene)
    force = np.zeros_like(quiet.walls.force)
    force[wall, axis] = pressure * area * parameters.walls.surfaces.place[wall, axis]
    walls = quiet.walls._replace(force=force, free=np.array([[wall, axis]], np.int64))
    return quiet._replace(walls=walls, protocol=protocol_of(()))


def section_of(scene: SoftScene) -> tuple[int, float]:
    """The axis of the wall that has a pressure, and the area of the section across it (m^2; in a layer m)."""
    axis = next(SIDES[wall.side][0] for wall in scene.walls if wall.pressure is not None)
    sides = sides_of(scene)
    return axis, math.prod(sides) / sides[axis]


def _presses(scene: SoftScene, parameters: Parameters, state: State) -> bool:
    """Whether the requested pressure is reached; False if none is requested."""
    if scene.preparation is None or scene.preparation.pressure is None:
        return False
    numbers = observe(parameters, state, workspace(parameters, state, 1.0)).numbers
    if not scene.walls:
        return numbers["pressure"] >= scene.preparation.pressure
    axis, area = section_of(scene)
    side = next(wall.side for wall in scene.walls if wall.pressure is not None)
    return abs(numbers[f"{side}_force_{AXES[axis]}"]) >= scene.preparation.pressure * area


def compression(scene: SoftScene, spec: PreparationSpec) -> tuple[StageSpec, StageSpec]:
    """The scale of the cell over time, from the volume fraction of the placement to the requested one, or, for a
    requested pressure, to DENSEST.
    """
    rate = setup.compression_rate(scene, setup.parameters_of(scene)) if spec.rate is None else spec.rate
    ratio = ((spec.volume_fraction or DENSEST) / first_fraction(scene)) ** (1.0 / dimensions_of(scene))
    first, last = (ratio, 1.0) if spec.pressure is None else (1.0, 1.0 / ratio)
    return StageSpec(time=0.0, scale=first), StageSpec(time=math.log(ratio) / rate, scale=last)


def _rewind(scene: SoftScene, parameters: Parameters, state: State) -> None:
    """Set the clock to 0, and balance the forces that start then."""
    state.step[:], state.pace[CLOCK], state.pace[PAST_ERROR], state.cell_rate[:] = 0, 0.0, 0.0, 0.0
    state.pace[LENGTH] = setup.first_length(scene, parameters, state)
    if not parameters.drag.any() or any(rules_at(parameters.protocol, 0)):
        setup.balance_first(parameters, state)


def _relax(parameters: Parameters, state: State, part: float) -> float:
    """Integrate until contact forces change by less than the fraction `part` within 1/rate. Returns the fraction of the
    last change. Raises SceneError.
    """
    frame, least = parameters.steps_per_frame, FAINT * float((parameters.modulus * parameters.radius**2).max())
    before = _forces(parameters, state)
    for _ in range(LONGEST):
        end = (int(state.step[0]) // frame + 1) * frame
        while state.step[0] < end:
            _go(parameters, state, end - int(state.step[0]))
        now = _forces(parameters, state)
        typical = float(np.sqrt((now[1] ** 2).sum() / max(len(now[1]), 1)))
        changed = _changed(before, now) / typical if typical > 0.0 else 0.0
        if typical < least or changed <= part:
            return changed
        before = now
    cause = f"forces still change by more than that part after {LONGEST} times 1/rate; expected a larger one"
    raise SceneError([Fault("preparation.relaxed", cause)])


def _go(parameters: Parameters, state: State, steps: int) -> None:
    """Advance by `steps` ticks, or until contacts change. Raises SceneError if no step is short enough."""
    if advance(parameters, state, workspace(parameters, state, 1.0), steps) == DIVERGED:
        raise SceneError([Fault("preparation", diagnosis(parameters, state))])


def _forces(parameters: Parameters, state: State) -> tuple[Integers, Array]:
    """The contacts, as spheres and image, and their forces (N)."""
    scratch, count = workspace(parameters, state, 1.0), int(state.contacts[0])
    begin_step(parameters, scratch.step, drive_at(parameters.protocol, float(state.pace[CLOCK])))
    return np.hstack([state.pair[:count], state.image[:count]]), scratch.step.responses.force.copy()


def _changed(before: tuple[Integers, Array], now: tuple[Integers, Array]) -> float:
    """The root mean square change of contact forces (N), including contacts that opened or closed."""
    contact, place = np.unique(np.concatenate([before[0], now[0]]), axis=0, return_inverse=True)
    change = np.zeros((len(contact), before[1].shape[1]))
    np.add.at(change, place.ravel()[: len(before[0])], -before[1])
    np.add.at(change, place.ravel()[len(before[0]) :], now[1])
    return float(np.sqrt((change**2).sum() / max(len(contact), 1)))
