"""What a model is: a record of functions that the driver calls; with engines, diagnosis and layouts of states.

Whether a state fits the parameters of a scene: sizes and indices, which compiled loops trust. States come from
checkpoints, and run directories may come from anyone. A state that does not fit would be read beyond the ends of its
arrays.

From a table of laws to compiled code, which knows a row by its code: its place in the table.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ecume.errors import BadInput
from ecume.models.actions import Access
from ecume.models.invariants import Invariant, nothing
from ecume.trajectories.frame import Frame
from ecume.units import Array

Row = tuple[str, str, str]
"""Name, value with unit, remark."""
LONG = 86400.0
"""Seconds of a run from which on `ecume check` suggests how to shorten it."""
LONGEST_RUN = 30.0 * 86400.0
"""Seconds of wall time, 30 days: runs that are expected to take longer are refused unless their user allows it."""


DONE, CROWDED, DIVERGED, EXCHANGE = 0, 1, 2, 3


Source = Callable[..., Any]
"""A law whose docstring cites its paper."""


def no_laws(scene: Any) -> list[Source]:
    """The laws of a model without papers: none."""
    return []


def _no_extra_laws(laws: Any) -> Model:
    """Raise BadInput: the model has no user-defined laws."""
    raise BadInput("extra_laws: this model has no user-defined laws")


def no_summary(scene: Any) -> list[tuple[str, str, str]]:
    """No derived numbers."""
    return []


def _as_it_is(scene: Any, parameters: Any, state: Any) -> Layout:
    """The layout of a state whose sizes and values are all valid."""
    return Layout(state)


def _same(parameters: Any, state: Any) -> Any:
    """The state itself, for models whose particles never change."""
    return state


def clock_of(state: Any) -> int:
    """The number of steps of a model with equal time steps."""
    return int(state.step[0])


@dataclass(frozen=True)
class Model:
    """A physical system. Scenes go in, frames come out.

    Parameters, State and Workspace are NamedTuples of the model's own: what never changes during a run, what the
    physics moves (and whatever else can change a later bit), and scratch. Scene and State together are enough to go on
    bit for bit.
    """

    name: str
    state: type
    """The NamedTuple type of the state: every field a NumPy array, `position` (N, d) first, `step` (1,) int64 among
    them.
    """
    parameters: Callable[[Any], Any]
    """parameters(scene): frozen, with `time_step` (s) and `steps_per_frame` among its fields. Raises SceneError."""
    start: Callable[[Any, Any], Any]
    """start(scene, parameters): the state at time 0. Raises SceneError."""
    workspace: Callable[[Any, Any, float], Any]
    """workspace(parameters, state, room): scratch; `room` >= 1 multiplies every capacity."""
    advance: Callable[[Any, Any, Any, int], int]
    """advance(parameters, state, workspace, steps): moves the state in place by that many steps; DONE, `CROWDED`,
    DIVERGED or EXCHANGE. Where steps adapt, 0 takes a single one.

    A state that is returned `CROWDED` is intact: make a larger workspace and do the remaining steps. One that
    is returned EXCHANGE has particles that enter or leave: continue with `exchange` of it, and a new workspace.
    """
    observe: Callable[[Any, Any, Any], Frame]
    """observe(parameters, state, workspace): the frame of this instant."""
    diagnosis: Callable[[Any, Any], str]
    """diagnosis(parameters, state): particle, time, cause and cure, for a state that is returned DIVERGED."""
    layout: Callable[[Any, Any, Any], Layout] = field(kw_only=True, default=_as_it_is)
    """layout(scene, parameters, state): what a state with as many particles and as much room looks like. A state from a
    file is compared with it, since compiled loops trust sizes and indices.
    """
    steps_taken: Callable[[Any], int] = field(kw_only=True, default=clock_of)
    """steps_taken(state): the time steps since time 0. Where steps adapt, `step` only counts fractions of frames."""
    adaptive: bool = field(kw_only=True, default=False)
    """Whether time steps adapt, so that their total number is unknown before the end."""
    extended: Callable[[Any], Model] = field(kw_only=True, default=_no_extra_laws)
    """extended(laws): the same model with the user's laws, `user_laws.BoundLaw`, compiled into it. Raises BadInput."""
    scene: Any = field(kw_only=True, default=None)
    """The type of its scenes, for a model that has no row in `ecume.scenes.load.SCENES`."""
    constant: frozenset[str] = field(kw_only=True, default=frozenset())
    """The arrays of frames that never change while no particle is added or removed."""
    main_numbers: tuple[str, ...] = field(kw_only=True, default=("kinetic_energy", "total_energy"))
    """The numbers of frames that summarize a run, as far as a scene has them."""
    exchange: Callable[[Any, Any], Any] = field(kw_only=True, default=_same)
    """exchange(parameters, state): the state with new particles and without those that left."""
    access: Access = field(kw_only=True, default=Access())
    """What actions may change: see `ecume.models.actions`."""
    invariants: Callable[[Any, Any], list[Invariant]] = field(kw_only=True, default=nothing)
    """invariants(scene, parameters): the conditions from frame to frame, on the numbers of `observe`."""
    laws: Callable[[Any], list[Source]] = field(kw_only=True, default=no_laws)
    """laws(scene): the laws that a scene uses, for `ecume cite`."""
    summary: Callable[[Any], list[tuple[str, str, str]]] = field(kw_only=True, default=no_summary)
    """summary(scene): derived numbers for `ecume check`, as (name, value with unit, remark)."""


LOCAL = "local"
"""The name of the engine that consists of the model's own loops."""
LAMMPS = "lammps"


def _no_facts() -> Mapping[str, str | int]:
    """No facts beside the versions that each session records."""
    return {}


@dataclass(frozen=True)
class Engine:
    """Integrates the states of a scene; frames and checkpoints are those of its model."""

    model: Callable[[Model], Model]
    """makes of the scene's model one that integrates in another way"""
    name: str = LOCAL
    """as in `--engine`; the manifest of a run states it, since states of one engine fit no other"""
    repeats: bool = True
    """whether frames that are computed again have the same bits"""
    facts: Callable[[], Mapping[str, str | int]] = _no_facts
    """version and number of ranks, for the manifest; called after the first step"""


DEEP = 0.1
"""The overlap, in radii, that is reported; larger ones do not occur in a correct run."""


def when(parameters: Any, state: Any) -> str:
    """The time of a state with equal steps."""
    step = int(state.step[0])
    return f"at t = {step * parameters.time_step:.6g} s (step {step})"


class Broken(NamedTuple):
    """A number that is NaN or infinite."""

    particle: int
    term: str


def first_broken(terms: Mapping[str, Array]) -> Broken | None:
    """The particle with NaN or infinity in the first of these terms that contains one; rows are particles.

    >>> first_broken({"position": np.zeros((3, 2)), "velocity": np.array([0.0, 1.0, np.nan])})
    Broken(particle=2, term='velocity')
    """
    for term, numbers in terms.items():
        broken = ~np.isfinite(numbers.reshape(len(numbers), -1)).all(axis=1)
        if broken.any():
            return Broken(int(np.argmax(broken)), term)
    return None


class Layout(NamedTuple):
    """The arrays of a state of a scene."""

    blank: Any
    """a state with as many particles and as much room; its values do not matter"""
    indices: Mapping[str, tuple[float, float]] = {}
    """lowest and highest value of the fields whose values are counts or indices"""
    sets: Mapping[str, int] = {}
    """fields that contain each number below this one once"""


def misfit(state: Any, layout: Layout) -> str:
    """The first fault of a state, with its field; empty if it fits."""
    return next(_faults(state, layout), "")


def _faults(state: Any, layout: Layout) -> Iterator[str]:
    for name, expected in layout.blank._asdict().items():
        got = getattr(state, name)
        if got.shape != expected.shape or got.dtype != expected.dtype:
            yield f"{name} is {got.dtype}{list(got.shape)}; expected {expected.dtype}{list(expected.shape)}"
    for name, (low, high) in layout.indices.items():
        values = getattr(state, name)
        wrong = values[(values < low) | (values > high)]
        if len(wrong):
            yield f"{name} contains {wrong.flat[0]:g}; expected {low:g} to {high:g}"
    for name, count in layout.sets.items():
        if not np.array_equal(np.sort(getattr(state, name)), np.arange(count)):
            yield f"{name} does not number the particles; expected each number below {count} once"


LawRow = TypeVar("LawRow")


def code_of(table: Mapping[str, object], name: str) -> int:
    """The code of a row. Raises ValueError for a name without a row.

    >>> code_of({"none": None, "coulomb": None}, "coulomb")
    1
    """
    return list(table).index(name)


def codes(table: Mapping[str, LawRow], part: Callable[[LawRow], Callable[..., Any]]) -> dict[int, Callable[..., Any]]:
    """A function of each row by the row's code, for `ecume._jit.selection`."""
    return {code: part(row) for code, row in enumerate(table.values())}
