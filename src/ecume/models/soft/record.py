"""The soft model, as the driver sees it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import psutil

from ecume.errors import BadInput, Fault, SceneError
from ecume.models.advice import Row
from ecume.models.model import Model
from ecume.models.soft.advice import advice
from ecume.models.soft.building import parameters_of, start
from ecume.models.soft.cost import bytes_of
from ecume.models.soft.invariants import invariants
from ecume.models.soft.observing import observe
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.state import CLOCK, LENGTH, State, workspace
from ecume.models.soft.stepping import advance
from ecume.scenes.soft import SoftScene


def checked_parameters(scene: SoftScene) -> Parameters:
    """The parameters of a scene that fits into the machine."""
    count = sum(species.count or len(species.positions) for species in scene.spheres)
    everyone = scene.films.reach is None and scene.box is None
    contacts = count * (count - 1) / 2 if everyone else 20.0 * count
    wanted, there = bytes_of(contacts), psutil.virtual_memory().total
    if wanted > there:
        told = f"{count} spheres need about {wanted / 1e9:.3g} GB, this machine has {there / 1e9:.3g} GB"
        raise SceneError([Fault("spheres", f"{told}; use fewer spheres, or set films.reach")])
    return parameters_of(scene)


def diagnosis(parameters: Parameters, state: State) -> str:
    """Who left the range where it means anything, when, and what to do."""
    contacts = int(state.contacts[0])
    narrowest = int(np.argmin(state.log_gap[:contacts]))
    first, second = state.pair[narrowest]
    return (
        f"at t = {state.pace[CLOCK]:.6g} s no step is short enough, {state.pace[LENGTH]:.3g} s neither; "
        f"the narrowest gap, {math.exp(state.log_gap[narrowest]):.3g} m, is between spheres {first} and {second}: "
        "look for forces that the surfaces cannot balance, or set stepping.tolerance lower"
    )


def extended(extra_laws: Sequence[Callable[..., float]]) -> Model:
    """There are no laws of a user's own here: a pair of soft spheres has a state besides its distance."""
    raise BadInput("the soft model takes no extra_laws; choose a remote.law, or pull at spheres with a force")


def summary(scene: SoftScene) -> list[Row]:
    """Derived numbers: name, value with unit, remark. Raises SceneError for whatever would keep a run from starting."""
    parameters = checked_parameters(scene)
    return advice(scene, parameters, start(scene, parameters))


SOFT = Model(
    name="soft",
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
"""Soft spheres in a viscous liquid: Soft Dynamics."""
