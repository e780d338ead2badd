"""The first state of a packing that is compressed and relaxed before time 0."""

from __future__ import annotations

import math

import numpy as np

from ecume.engine.cells import Integers
from ecume.errors import Fault, SceneError
from ecume.models.model import DIVERGED
from ecume.models.soft import setup
from ecume.models.soft.integration.linear_solvers import begin_step
from ecume.models.soft.integration.time_stepping import advance
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.protocol import at_frames, drive_at, protocol_of, rules_at
from ecume.models.soft.report.diagnosis import diagnosis
from ecume.models.soft.report.observation import observe
from ecume.models.soft.state import CLOCK, LENGTH, PAST_ERROR, UPRIGHT, State, workspace
from ecume.scenes.soft import PreparationSpec, SoftScene, StageSpec, dimensions_of, first_fraction
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
    if not parameters.drag.any():
        setup.require_hold(parameters, state)
        setup.require_no_torque(parameters, state)
    _rewind(scene, parameters, state)
    for since_then in (state.velocity, state.spin, state.tally, state.budget):
        since_then[:] = 0
    state.orientation[:] = UPRIGHT[parameters.torque.shape[1]]
    return state


def unprepared(scene: SoftScene, parameters: Parameters) -> State:
    """The state at which a preparation begins, or that at time 0 without one. Raises SceneError."""
    if scene.preparation is None:
        return setup.start(scene, parameters)
    return setup.start(scene, _pressing(scene, scene.preparation, parameters))


def _pressing(scene: SoftScene, spec: PreparationSpec, parameters: Parameters) -> Parameters:
    """The parameters of the compression."""
    unloaded = _unloaded(spec, parameters)
    protocol = protocol_of(compression(scene, spec))
    return unloaded._replace(protocol=at_frames(protocol, unloaded.steps_per_frame, unloaded.time_step, unloaded.end))


def _unloaded(spec: PreparationSpec, parameters: Parameters) -> Parameters:
    """The parameters without loads and without an end, with frames at intervals of 1/rate."""
    nothing = {name: np.zeros_like(getattr(parameters, name)) for name in ("force", "torque", "weight")}
    return parameters._replace(time_step=1.0 / spec.rate / parameters.steps_per_frame, end=math.inf, **nothing)


def _prepared(scene: SoftScene, spec: PreparationSpec, parameters: Parameters) -> State:
    """The packing at the end of its preparation."""
    resting = pressing = _pressing(scene, spec, parameters)
    state, last = setup.start(scene, pressing), float(pressing.protocol.times[-1])
    while state.pace[CLOCK] < last and not _presses(spec, pressing, state):
        _go(pressing, state, 0)
    if spec.pressure is not None:
        if not _presses(spec, pressing, state):
            cause = f"is not reached at a volume fraction of {DENSEST:g}; expected a lower one"
            raise SceneError([Fault("preparation.pressure", cause)])
        resting = pressing._replace(protocol=protocol_of((StageSpec(time=0.0, pressure=spec.pressure),)))
        _rewind(scene, resting, state)
    _relax(resting, state, spec.relaxed)
    return state


def _presses(spec: PreparationSpec, parameters: Parameters, state: State) -> bool:
    """Whether the requested pressure is reached; False without one."""
    if spec.pressure is None:
        return False
    return observe(parameters, state, workspace(parameters, state, 1.0)).numbers["pressure"] >= spec.pressure


def compression(scene: SoftScene, spec: PreparationSpec) -> tuple[StageSpec, StageSpec]:
    """The scale of the cell over time, from the volume fraction of the placement to the requested one, or, for a
    requested pressure, to DENSEST.
    """
    ratio = ((spec.volume_fraction or DENSEST) / first_fraction(scene)) ** (1.0 / dimensions_of(scene))
    first, last = (ratio, 1.0) if spec.pressure is None else (1.0, 1.0 / ratio)
    return StageSpec(time=0.0, scale=first), StageSpec(time=math.log(ratio) / spec.rate, scale=last)


def _rewind(scene: SoftScene, parameters: Parameters, state: State) -> None:
    """Set the clock to 0, and balance the forces that begin there."""
    state.step[:], state.pace[CLOCK], state.pace[PAST_ERROR], state.cell_rate[:] = 0, 0.0, 0.0, 0.0
    state.pace[LENGTH] = setup.first_length(scene, parameters, state)
    if not parameters.drag.any() or any(rules_at(parameters.protocol, 0)):
        setup.balance_first(parameters, state)


def _relax(parameters: Parameters, state: State, part: float) -> None:
    """Integrate until contact forces change by less than the fraction `part` within 1/rate. Raises SceneError."""
    frame, least = parameters.steps_per_frame, FAINT * float((parameters.modulus * parameters.radius**2).max())
    before = _forces(parameters, state)
    for _ in range(LONGEST):
        end = (int(state.step[0]) // frame + 1) * frame
        while state.step[0] < end:
            _go(parameters, state, end - int(state.step[0]))
        now = _forces(parameters, state)
        typical = float(np.sqrt((now[1] ** 2).sum() / max(len(now[1]), 1)))
        if typical < least or _changed(before, now) <= part * typical:
            return
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
