"""The simulation of a scene: an iterator of frames."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume.errors import BadInput, Diverged
from ecume.models import MODELS
from ecume.models.actions import Action, View, energy_of, perform, place, with_injected_work, write
from ecume.models.layouts import misfit
from ecume.models.model import CROWDED, DIVERGED, EXCHANGE, Engine, Model
from ecume.models.step_counts import BEFORE, last_step, sample_clock
from ecume.trajectories.frame import Frame

if TYPE_CHECKING:
    from ecume.scenes.common import Common
    from ecume.scenes.schema import Scene

ROOMIER = 1.6
"""A workspace that overflowed is made again with every capacity times this."""


class Moment(NamedTuple):
    """A pause of the integration: always with a complete state, and with a frame if one is due."""

    state: Any
    frame: Frame | None
    step: int
    """The position on the model's clock: time steps, or fractions of a frame where time steps adapt."""
    steps: int
    """The position at the end."""
    parameters: Any
    taken: int
    """Time steps since time 0."""
    planned: int | None
    """Time steps of the whole run; None while that is unknown."""
    sample: Frame | None = None
    """The frame of a sample, if one is due."""

    @property
    def ended(self) -> bool:
        """Whether this is the end of the scene."""
        return self.step >= self.steps

    @property
    def done(self) -> float:
        """The completed fraction of the simulated time."""
        return self.step / self.steps if self.steps else 1.0


def simulate(
    scene: Scene, *, extra_laws: Sequence[Callable[..., float]] = (), actions: Sequence[Action] = ()
) -> Iterator[Frame]:
    """The frames of a scene, the first at t = 0. Raises Diverged with the time, the particle and the cure.

    `actions` are functions decorated with `ecume.every`.
    """
    for moment in moments(scene, extra_laws=extra_laws, actions=actions):
        if moment.frame is not None:
            yield moment.frame


def moments(
    scene: Scene,
    *,
    state: Any = None,
    extra_laws: Sequence[Callable[..., float]] = (),
    actions: Sequence[Action] = (),
    patience: float = 0.25,
    engine: Engine | None = None,
    constants: Callable[[Any], Any] | None = None,
    sampled: int | None = None,
) -> Iterator[Moment]:
    """Integrate a scene and pause at every frame, and at least about every `patience` seconds of wall time.

    With `state` (of a checkpoint) the integration continues from there. Pauses change no bit of the result. The next
    moment changes the state of this one: copy it if you need it later. `engine` integrates instead of the model of the
    scene. `constants` is a function from the parameters that follow from the scene to the parameters to use: a resumed
    run uses the constants with which it started. `sampled` is the position of the last sample, `BEFORE` at the
    beginning; by default there are no samples.
    """
    model = MODELS[scene.model]
    if engine is not None:
        if extra_laws or actions:
            laws = "user-defined laws or actions"
            raise BadInput(f"--engine {engine.name}: got {laws}; expected none, or --engine local")
        model = engine.model(model)
    model = extended(model, scene, extra_laws)
    parameters = model.parameters(scene)
    if constants is not None:
        parameters = constants(parameters)
    if state is None:
        state = model.start(scene, parameters)
    elif fault := misfit(state, model.layout(scene, parameters, state)):
        raise BadInput(f"the state of the checkpoint does not fit the scene: {fault}")
    integration = Integration(model, parameters, state, patience)
    schedule = Schedule(actions, scene, integration)
    per_frame = parameters.steps_per_frame
    # Adaptive steps before the end need at least one tick before the last one.
    total = last_step(scene, per_frame, least=2 if model.adaptive else 1)
    if not 0 <= (begun := int(state.step[0])) <= total:
        raise BadInput(f"the state of the checkpoint is at step {begun}; expected 0 to {total}")
    clock = None if sampled is None else sample_clock(scene, model, per_frame)
    last = BEFORE if sampled is None else sampled
    while True:
        state = integration.state
        step = int(state.step[0])
        due = step % per_frame == 0 or step >= total
        taken = model.steps_taken(state)
        planned = None if model.adaptive and step < total else taken if model.adaptive else total
        frame = _on_time(scene, schedule.observe(), step / per_frame) if due else None
        sample = None
        if clock is not None and clock.is_due(step, last):
            sample, last = frame or schedule.observe(), step
        yield Moment(state, frame, step, total, parameters, taken, planned, sample)
        frame = sample = None  # not kept during the steps
        if step >= total:
            return
        ahead = min(per_frame - step % per_frame, total - step, schedule.ahead())
        integration.go(ahead if clock is None else min(ahead, clock.next_after(step) - step))
        schedule.perform_due()


def extended(model: Model, scene: Scene, extra_laws: Sequence[Callable[..., float]]) -> Model:
    """The model with the user-defined laws of a scene. Raises SceneError for laws that are not given."""
    if not (extra_laws or scene.user_laws):
        return model
    from ecume.models.user_laws import bind

    return model.extended(bind(scene, extra_laws))


def _on_time(scene: Common, frame: Frame, number: float) -> Frame:
    """The frame with the decimal time at which it is due, if its time differs from this only by rounding."""
    due = scene.frame_time(math.ceil(number)) if number <= scene.frames else frame.time
    return frame._replace(time=due) if math.isclose(frame.time, due, rel_tol=1e-9) else frame


class Integration:
    """The state of one simulation: its workspace, which grows on demand, and the number of steps per pause."""

    def __init__(self, model: Model, parameters: Any, state: Any, patience: float) -> None:
        from ecume._jit import require_threads

        require_threads(max(state.position.shape, default=0))
        self.model, self.parameters, self.state, self.patience = model, parameters, state, patience
        self.room = 1.0
        self.batch = 1
        self.workspace = model.workspace(parameters, state, self.room)

    def observe(self) -> Frame:
        """The frame of this instant."""
        return self.model.observe(self.parameters, self.state, self.workspace)

    def renew(self) -> None:
        """Allocate a new workspace after a change of the state."""
        self.workspace = None  # its memory
        self.workspace = self.model.workspace(self.parameters, self.state, self.room)

    def go(self, most: int) -> None:
        """Advance by `most` steps, or by as many as the patience permits."""
        steps = min(most, self.batch)
        before, began = int(self.state.step[0]), time.perf_counter()
        status = self.model.advance(self.parameters, self.state, self.workspace, steps)
        if status == DIVERGED:
            raise Diverged(self.model.diagnosis(self.parameters, self.state))
        if status == CROWDED:
            self.room *= ROOMIER
            self.renew()
        if status == EXCHANGE:
            self.state = self.model.exchange(self.parameters, self.state)
            self.renew()
        took = time.perf_counter() - began
        done = int(self.state.step[0]) - before
        if done == steps:
            self.batch = max(1, min(4 * self.batch, int(steps * self.patience / max(took, 1e-9))))


FAR = 1 << 62


class Schedule:
    """The actions of a simulation. They are due at fixed steps, so that a resumed run performs the same actions."""

    def __init__(self, actions: Sequence[Action], scene: Scene, integration: Integration) -> None:
        for action in actions:
            if not isinstance(action, Action):
                raise BadInput(f"actions: got {action!r}; expected a function decorated with ecume.every(steps=...)")
        self._actions, self._scene, self._at = tuple(actions), scene, integration
        self._counts = self._due()

    def observe(self) -> Frame:
        """The frame of this instant, with the injected work of actions."""
        frame = self._at.observe()
        return with_injected_work(frame, self._at.model.access, self._at.state) if self._actions else frame

    def ahead(self) -> int:
        """The largest number of steps before an action is due; 0, for a single step, if steps are adaptive."""
        model, step = self._at.model, int(self._at.state.step[0])
        if model.adaptive and self._actions:
            return 0
        return min((action.ahead(step, self._at.parameters.time_step) for action in self._actions), default=FAR)

    def perform_due(self) -> None:
        """Perform the actions that have become due, in their order."""
        counts = self._due()
        for action, before, now in zip(self._actions, self._counts, counts, strict=True):
            if now > before:
                self._perform(action)
        self._counts = counts

    def _due(self) -> list[int]:
        state, time_step = self._at.state, self._at.parameters.time_step
        taken, clock = self._at.model.steps_taken(state), float(state.step[0])
        return [action.count(taken, clock, time_step) for action in self._actions]

    def _perform(self, action: Action) -> None:
        state, model, parameters = self._at.state, self._at.model, self._at.parameters
        access, moment = model.access, (float(state.step[0]) * parameters.time_step, model.steps_taken(state))
        ids = access.ids(state)
        view = View(self._scene, moment, self._at.observe, np.sort(ids[ids >= 0]), list(access.arrays(state)))
        changes = perform(action, view, access)
        if not changes:
            return
        before = energy_of(view.frame)
        write(action, view, access, state, changes)
        moved = "position" in changes
        if moved and (faults := access.faults(self._scene, parameters, state)):
            more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
            raise BadInput(f"{place(action, view)}: {faults[0]}{more}")
        access.changed(state, moved)
        if moved:
            self._at.renew()
        access.work(state)[:1] += energy_of(self._at.observe()) - before
