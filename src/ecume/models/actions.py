"""Actions: functions of the user that read and change the state of a run at fixed steps.

The input of an action is the arrays of a frame. The values that it writes are checked and copied to the state; its work
is added to the injected work, so that the energy budget stays closed.
"""

from __future__ import annotations

import math
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ecume.errors import BadInput, EcumeError
from ecume.models.invariants import INJECTED, OWN, with_own
from ecume.trajectories.frame import Frame
from ecume.units import Array, parse

if TYPE_CHECKING:
    from ecume.engine.cells import Integers

ROUNDING = 1e-6
"""The fraction of a time step by which an action may be early."""


@dataclass(frozen=True, kw_only=True)
class Access:
    """The parts of a model's state that actions may change; none by default."""

    arrays: Callable[[Any], Mapping[str, Array]] = lambda state: {}
    """arrays(state): views of the state's own arrays, (N, d), by their names in frames"""
    ids: Callable[[Any], Integers] = lambda state: np.arange(len(state.position))
    """ids(state): (N,) the permanent number of each particle; -1 for those that frames do not contain"""
    faults: Callable[[Any, Any, Any], Sequence[str]] = lambda scene, parameters, state: ()
    """faults(scene, parameters, state): what is wrong with the positions"""
    changed: Callable[[Any, bool], None] = lambda state, moved: None
    """changed(state, moved): invalidate what follows from velocities, and from positions if particles moved"""
    work: Callable[[Any], Array] = lambda state: np.zeros(0)
    """work(state): a view of the injected work (J), (1,)"""
    sides: Callable[[Any], Array] = lambda parameters: np.zeros(3)
    """sides(parameters): (d,) the sides of the periodic box (m); zero along other axes"""
    place: Callable[[Any, Any, Array], None] = lambda parameters, state, position: np.copyto(state.position, position)
    """place(parameters, state, position): set the positions (N, d), which may be beyond a periodic box"""
    refusal: str = ""
    """why nothing can be changed"""


@dataclass(frozen=True)
class Action:
    """A function that is called every so many steps, or every so many seconds of simulated time."""

    function: Callable[[View], object]
    steps: int | None = None
    time: float | None = None

    @property
    def name(self) -> str:
        """The name of the function."""
        return str(getattr(self.function, "__name__", repr(self.function)))

    @property
    def period(self) -> dict[str, float]:
        """The period, for the manifest."""
        return {"steps": self.steps} if self.steps is not None else {"time": float(self.time or 0.0)}

    def count(self, steps: int, clock: float, time_step: float) -> int:
        """The number of times that the action was due until this step and time, in units of `time_step`; it is never
        due at time 0.
        """
        if self.steps is not None:
            return steps // self.steps
        return math.floor((clock + ROUNDING) * time_step / float(self.time or math.inf))

    def ahead(self, step: int, time_step: float) -> int:
        """The number of equal steps until the action is due."""
        if self.steps is not None:
            return self.steps - step % self.steps
        number = self.count(step, step, time_step) + 1
        return max(1, math.ceil(number * float(self.time or math.inf) / time_step - ROUNDING) - step)


def every(*, steps: int | None = None, time: float | str | None = None) -> Callable[[Callable[[View], object]], Action]:
    """A decorator that makes a function an action, every `steps` steps or every `time` (s, or text as "10 ms").

    >>> @every(steps=100)
    ... def cool(view):
    ...     view.velocity *= 0.9
    >>> cool.name, cool.steps
    ('cool', 100)
    """
    if (steps is None) == (time is None):
        raise BadInput("every: got neither or both of steps and time; expected one, such as every(steps=100)")
    if steps is not None and (isinstance(steps, bool) or not isinstance(steps, int) or steps < 1):
        raise BadInput(f"every: got steps={steps!r}; expected a whole number of at least 1")
    seconds = parse(time, "s") if isinstance(time, str) else time
    if seconds is not None and not 0.0 < seconds < math.inf:
        raise BadInput(f"every: got time={time!r}; expected a time above zero, in s")

    def decorated(function: Callable[[View], object]) -> Action:
        return Action(function, steps, seconds)

    return decorated


class View:
    """The state of a run, as passed to an action.

    `time` (s), `step`, `scene`, `numbers` and `units` are those of a frame; so are the arrays: `view.position` (N, d),
    `view.velocity`, ..., in the order of `view.ids`, the permanent numbers of particles. Positions and velocities can
    be changed where the model allows it.
    """

    __slots__ = ("_arrays", "_frame", "_observe", "_writable", "ids", "scene", "step", "time")

    def __init__(
        self, scene: Any, at: tuple[float, int], observe: Callable[[], Frame], ids: Integers, writable: Sequence[str]
    ) -> None:
        self.scene, (self.time, self.step) = scene, at
        self._observe, self._writable = observe, tuple(writable)
        self.ids = ids
        self._frame: Frame | None = None
        self._arrays: dict[str, NDArray[Any]] = {}

    @property
    def frame(self) -> Frame:
        """The frame before any change."""
        if self._frame is None:
            self._frame = self._observe()
        return self._frame

    @property
    def numbers(self) -> Mapping[str, float]:
        """The numbers of the frame, such as energies."""
        return self.frame.numbers

    @property
    def units(self) -> Mapping[str, str]:
        """The units of arrays and numbers."""
        return self.frame.units

    def __getattr__(self, name: str) -> NDArray[Any]:
        """An array of the frame; read-only unless the model allows changes."""
        if name.startswith("_"):
            raise AttributeError(name)
        if name not in self._arrays:
            if name not in self.frame.arrays:
                raise AttributeError(f"there is no {name!r}; expected one of {', '.join(self.frame.arrays)}")
            array = self.frame.arrays[name].copy()
            array.flags.writeable = name in self._writable
            self._arrays[name] = array
        return self._arrays[name]

    def __setattr__(self, name: str, value: Any) -> None:
        """`view.velocity = ...` copies the values into the array."""
        if name in View.__slots__:
            object.__setattr__(self, name, value)
        elif (array := getattr(self, name)) is not value:
            array[...] = value

    def __dir__(self) -> list[str]:
        return [*object.__dir__(self), *self.frame.arrays]

    def __repr__(self) -> str:
        return f"<View at t = {self.time:.6g} s, step {self.step}: {', '.join(self.frame.arrays)}>"

    def changes(self) -> dict[str, NDArray[Any]]:
        """The arrays that an action has changed."""
        before = self.frame.arrays if self._arrays else {}
        return {
            name: array
            for name, array in self._arrays.items()
            if array.flags.writeable and array.tobytes() != np.ascontiguousarray(before[name]).tobytes()
        }


def perform(action: Action, view: View, access: Access) -> dict[str, NDArray[Any]]:
    """Call an action. Returns the arrays that it changed. Raises BadInput with the line where the action failed."""
    try:
        action.function(view)
        changes = view.changes()
    except EcumeError:
        raise
    except Exception as error:  # a user function may raise any exception
        code = getattr(action.function, "__code__", None)
        lines = [
            frame.lineno
            for frame in traceback.extract_tb(error.__traceback__)
            if code is not None and frame.filename == code.co_filename and frame.name == code.co_name
        ]
        where = f", line {lines[-1]}" if lines else ""
        what = f"{type(error).__name__}: {error}"
        if "read-only" in str(error):
            what += f"; {access.refusal or 'positions and velocities can be changed'}"
        raise BadInput(f"{place(action, view)}{where}: {what}") from error
    for name, array in changes.items():
        if not np.isfinite(array).all():
            row = int(np.argwhere(~np.isfinite(array))[0][0])
            raise BadInput(f"{place(action, view)}: {name} of particle {row} is not finite")
    return changes


def place(action: Action, view: View) -> str:
    """The action, the time and the step, for messages."""
    return f"actions: {action.name}: at t = {view.time:.6g} s (step {view.step})"


def write(action: Action, view: View, access: Access, state: Any, changes: Mapping[str, NDArray[Any]]) -> None:
    """Copy changed arrays to the state. Raises BadInput for passive tracers."""
    ids, views = access.ids(state), access.arrays(state)
    order = np.argsort(ids, kind="stable")[np.count_nonzero(ids < 0) :]
    for name, array in changes.items():
        if array[len(order) :].tobytes() != np.ascontiguousarray(view.frame.arrays[name][len(order) :]).tobytes():
            raise BadInput(f"{place(action, view)}: {name} of passive tracers cannot be changed")
        views[name][order] = array[: len(order)]


def energy_of(frame: Frame) -> float:
    """The energy minus the injected work (J); zero for a model without an energy."""
    return with_own(dict(frame.numbers)).get(OWN, 0.0)


def with_injected_work(frame: Frame, access: Access, state: Any) -> Frame:
    """The frame with the injected work, also where the model reports it for driven scenes only."""
    work = access.work(state)
    if INJECTED in frame.numbers or not len(work):
        return frame
    unit = frame.units.get("total_energy", "J")
    return frame._replace(numbers={**frame.numbers, INJECTED: float(work[0])}, units={**frame.units, INJECTED: unit})
