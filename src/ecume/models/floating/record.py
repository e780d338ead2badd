"""The floating model, as the driver sees it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from ecume.models.diagnosis import DEEP, first_broken, when
from ecume.models.floating.extending import advance_extended
from ecume.models.floating.invariants import invariants
from ecume.models.floating.observing import observe
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.room import ROOMIER, checked_parameters
from ecume.models.floating.sources import laws_of
from ecume.models.floating.starting import start
from ecume.models.floating.state import DEEPEST, State, Workspace, make_workspace
from ecume.models.floating.stepping import advance, fill_lists, make_scratch
from ecume.models.floating.telling import summary
from ecume.models.model import Model


def workspace(parameters: Parameters, state: State, room: float) -> Workspace:
    """Scratch with neighbor lists that hold at the state's reference positions."""
    while True:
        made = make_workspace(parameters, state, room)
        made = made._replace(scratch=make_scratch(parameters, state, made))
        if fill_lists(parameters, state, made):
            return made
        room *= ROOMIER


def diagnosis(parameters: Parameters, state: State) -> str:
    """Who left the range where it means anything, when, and what to do."""
    return (
        f"{when(parameters, state)} {_who_and_what(parameters, state)}: too far for one time step of "
        f"{parameters.time_step:.3g} s. Set integration.time_step = {0.25 * parameters.time_step:.2g}, "
        "or look for overlapping floats"
    )


def _who_and_what(parameters: Parameters, state: State) -> str:
    """Whose number is none, who were put apart, or who is the fastest."""
    broken = first_broken({"position": state.position, "velocity": state.velocity})
    if broken is not None:
        return f"float {broken.particle} has no finite {broken.term} any more"
    if state.tally[DEEPEST] > DEEP * parameters.floats.radius.min():
        # Contacts have moved them out of each other: farther than anybody goes by itself.
        one, other = np.argsort(-np.linalg.norm(state.position - state.reference, axis=1))[:2]
        return f"floats {one} and {other} were put apart, from an overlap of {state.tally[DEEPEST]:.3g} m"
    with np.errstate(over="ignore"):
        speed = np.hypot(state.velocity[:, 0], state.velocity[:, 1])
    fastest = int(np.argmax(speed))
    x, y = state.position[fastest]
    return f"float {fastest} goes {speed[fastest]:.3g} m/s (at {x:.4g} m, {y:.4g} m)"


def extended(extra_laws: Sequence[Callable[..., float]]) -> Model:
    """The floating model with a user's own pair laws."""
    return dataclasses.replace(FLOATING, advance=advance_extended(extra_laws))


FLOATING = Model(
    name="floating",
    state=State,
    parameters=checked_parameters,
    start=start,
    workspace=workspace,
    advance=advance,
    observe=observe,
    diagnosis=diagnosis,
    extended=extended,
    invariants=invariants,
    laws=laws_of,
    summary=summary,
)
