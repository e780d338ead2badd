"""The record of functions that a model consists of, and engines that integrate its states."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ecume.errors import BadInput
from ecume.models.actions import Access
from ecume.models.invariants import Invariant, nothing
from ecume.models.layouts import Layout
from ecume.trajectories.frame import Frame

Row = tuple[str, str, str]
"""Name, value with unit, remark."""
LONG = 86400.0
"""The duration of a run in seconds from which `ecume check` suggests how to shorten it."""
LONGEST_RUN = 30.0 * 86400.0
"""Seconds of wall time, 30 days: runs that are expected to take longer are refused unless their user allows it."""
DONE, CROWDED, DIVERGED, EXCHANGE = 0, 1, 2, 3
Source = Callable[..., Any]
"""A law whose docstring cites its paper."""


def no_laws(scene: Any) -> list[Source]:
    """Return no laws, for a model without papers."""
    return []


def _no_extra_laws(laws: Any) -> Model:
    """Raise BadInput: the model has no user-defined laws."""
    raise BadInput("extra_laws: this model has no user-defined laws")


def no_summary(scene: Any) -> list[tuple[str, str, str]]:
    """Return no derived numbers."""
    return []


def _as_it_is(scene: Any, parameters: Any, state: Any) -> Layout:
    """The layout of a state that is always valid."""
    return Layout(state)


def _same(parameters: Any, state: Any) -> Any:
    """The unchanged state, for models whose particles never change."""
    return state


def _no_further_state(scene: Any) -> type | None:
    """Return None: the model has no further fields."""
    return None


def clock_of(state: Any) -> int:
    """The number of steps of a model with equal time steps."""
    return int(state.step[0])


@dataclass(frozen=True)
class Model:
    """A physical model: functions from scenes to frames.

    Each model defines Parameters, State and Workspace as NamedTuples. Parameters never change during a run, State is
    what the physics changes (and whatever else affects later bits), and Workspace is scratch. A run can be resumed bit
    for bit from Scene and State.
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
    further_state: Callable[[Any], type | None] = field(kw_only=True, default=_no_further_state)
    """further_state(scene): the type of the state of a scene that requires further fields, or None"""
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
    """The type of its scenes, for a model that has no row in `ecume.scenes.schema.SCENES`."""
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
    """Return no facts in addition to the versions that each session records."""
    return {}


@dataclass(frozen=True)
class Engine:
    """A function that integrates the states of a scene; frames and checkpoints are those of its model."""

    model: Callable[[Model], Model]
    """makes of the scene's model one that integrates in another way"""
    name: str = LOCAL
    """as in `--engine`; the manifest of a run states it, since states of one engine fit no other"""
    repeats: bool = True
    """whether frames that are computed again have the same bits"""
    facts: Callable[[], Mapping[str, str | int]] = _no_facts
    """version and number of ranks, for the manifest; called after the first step"""
