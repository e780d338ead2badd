"""The simulation of a scene: an iterator of frames."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from ecume.errors import BadInput, Diverged
from ecume.models import MODELS
from ecume.models.last_frame import last_step
from ecume.models.model import CROWDED, DIVERGED, EXCHANGE, Model
from ecume.trajectories.frame import Frame

if TYPE_CHECKING:
    from ecume.scenes.common import Common
    from ecume.scenes.schema import Scene

ROOMIER = 1.6
"""A workspace that overflowed is made again with every capacity times this."""


class Moment(NamedTuple):
    """A pause of the integration: always a whole state, and a frame where one is due."""

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

    @property
    def ended(self) -> bool:
        """Whether this is the end of the scene."""
        return self.step >= self.steps

    @property
    def done(self) -> float:
        """The fraction of the simulated time that is behind us."""
        return self.step / self.steps if self.steps else 1.0


def simulate(scene: Scene, *, extra_laws: Sequence[Callable[..., float]] = ()) -> Iterator[Frame]:
    """The frames of a scene, the first at t = 0. Raises Diverged with the time, the particle and the cure."""
    for moment in moments(scene, extra_laws=extra_laws):
        if moment.frame is not None:
            yield moment.frame


def moments(
    scene: Scene,
    *,
    state: Any = None,
    extra_laws: Sequence[Callable[..., float]] = (),
    patience: float = 0.25,
    engine: Callable[[Model], Model] | None = None,
    constants: Callable[[Any], Any] | None = None,
) -> Iterator[Moment]:
    """Integrate a scene and pause at every frame, and at least about every `patience` seconds of wall time.

    With `state` (of a checkpoint) the integration continues from there. Pauses change no bit of the result.
    The state of a moment is moved on by the next one: copy it to keep it. `engine` makes of the scene's model one that
    integrates in another way to the same bits. `constants` gets the parameters that follow from the scene and returns
    those to use: a resumed run keeps the constants that it was begun with.
    """
    model = MODELS[scene.model]
    if engine is not None:
        if extra_laws:
            raise BadInput("extra_laws go with the usual engine only")
        model = engine(model)
    parameters = model.parameters(scene)
    if constants is not None:
        parameters = constants(parameters)
    if state is None:
        state = model.start(scene, parameters)
    if extra_laws:
        model = model.extended(extra_laws)
    integration = Integration(model, parameters, state, patience)
    per_frame = parameters.steps_per_frame
    # Adaptive steps before the end need a place of their own on the clock.
    total = last_step(scene, per_frame, least=2 if model.adaptive else 1)
    while True:
        state = integration.state
        step = int(state.step[0])
        due = step % per_frame == 0 or step >= total
        taken = model.steps_taken(state)
        planned = None if model.adaptive and step < total else taken if model.adaptive else total
        frame = _on_time(scene, integration.observe(), step / per_frame) if due else None
        yield Moment(state, frame, step, total, parameters, taken, planned)
        if step >= total:
            return
        integration.go(min(per_frame - step % per_frame, total - step))


def _on_time(scene: Common, frame: Frame, number: float) -> Frame:
    """The frame with the decimal time at which it is due, where its own differs from it by rounding only."""
    due = scene.frame_time(math.ceil(number)) if number <= scene.frames else frame.time
    return frame._replace(time=due) if math.isclose(frame.time, due, rel_tol=1e-9) else frame


class Integration:
    """The open loop of one simulation: a workspace that grows, and how many steps fit into the patience."""

    def __init__(self, model: Model, parameters: Any, state: Any, patience: float) -> None:
        self.model, self.parameters, self.state, self.patience = model, parameters, state, patience
        self.room = 1.0
        self.batch = 1
        self.workspace = model.workspace(parameters, state, self.room)

    def observe(self) -> Frame:
        """The frame of this instant."""
        return self.model.observe(self.parameters, self.state, self.workspace)

    def go(self, most: int) -> None:
        """Advance by `most` steps, or by as many as the patience allows."""
        steps = min(most, self.batch)
        before, began = int(self.state.step[0]), time.perf_counter()
        status = self.model.advance(self.parameters, self.state, self.workspace, steps)
        if status == DIVERGED:
            raise Diverged(self.model.diagnosis(self.parameters, self.state))
        if status == CROWDED:
            self.room *= ROOMIER
            self.workspace = self.model.workspace(self.parameters, self.state, self.room)
        if status == EXCHANGE:
            self.state = self.model.exchange(self.parameters, self.state)
            self.workspace = self.model.workspace(self.parameters, self.state, self.room)
        took = time.perf_counter() - began
        done = int(self.state.step[0]) - before
        if done == steps:
            self.batch = max(1, min(4 * self.batch, int(steps * self.patience / max(took, 1e-9))))
