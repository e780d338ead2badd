"""The floating model, as the driver sees it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from ecume.models.floating.extending import advance_extended
from ecume.models.floating.interacting import advance, scratch_for
from ecume.models.floating.invariants import invariants
from ecume.models.floating.observing import observe
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.room import ROOMIER, checked_parameters
from ecume.models.floating.starting import start
from ecume.models.floating.state import State, Workspace, make_workspace
from ecume.models.floating.stepping import renew_lists
from ecume.models.floating.telling import summary
from ecume.models.model import Model


def workspace(parameters: Parameters, state: State, room: float) -> Workspace:
    """Scratch with neighbor lists that hold at the state's reference positions."""
    while True:
        made = make_workspace(parameters, state, room)
        room_there = 2 * len(made.contacts.first)
        made = made._replace(sorted_floats=scratch_for(parameters, state, made.sorted_floats, room_there))
        if parameters.rough != ():
            from ecume.models.floating.rubbing import make_rubbed

            made = made._replace(rough=make_rubbed(parameters, made))
        if renew_lists(parameters, state.reference, made.lists, made.candidates, made.sorted_floats):
            return made
        room *= ROOMIER


def diagnosis(parameters: Parameters, state: State) -> str:
    """Who left the range where it means anything, when, and what to do."""
    speed = np.hypot(state.velocity[:, 0], state.velocity[:, 1])
    broken = ~np.isfinite(speed) | ~np.isfinite(state.position).all(axis=1)
    worst = int(np.flatnonzero(broken)[0]) if broken.any() else int(np.argmax(speed))
    time = int(state.step[0]) * parameters.time_step
    what = "has no finite position any more" if broken.any() else f"goes {speed[worst]:.3g} m/s"
    x, y = state.position[worst]
    return (
        f"at t = {time:.6g} s float {worst} {what} (at {x:.4g} m, {y:.4g} m): too far for one time step of "
        f"{parameters.time_step:.3g} s. Set motion.time_step = {0.25 * parameters.time_step:.2g}, "
        "or look for overlapping floats"
    )


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
    summary=summary,
)
