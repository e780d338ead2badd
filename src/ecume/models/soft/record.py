"""The soft model, as the driver sees it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import psutil

from ecume.errors import BadInput, Fault, SceneError
from ecume.laws.soft_pair import SoftPair, crossover_gap, viscous_time
from ecume.models.model import Model
from ecume.models.soft.building import parameters_of, prefactors_of, start
from ecume.models.soft.observing import observe
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.state import CLOCK, LENGTH, State, workspace
from ecume.models.soft.stepping import advance
from ecume.scenes.soft import SoftScene

BYTES_PER_CONTACT = 1200


def checked_parameters(scene: SoftScene) -> Parameters:
    """The parameters of a scene that fits into the machine."""
    count = sum(species.count or len(species.positions) for species in scene.spheres)
    everyone = scene.films.reach is None and scene.box is None
    contacts = count * (count - 1) / 2 if everyone else 20.0 * count
    wanted, there = contacts * BYTES_PER_CONTACT, psutil.virtual_memory().total
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


def summary(scene: SoftScene) -> list[tuple[str, str, str]]:
    """Derived numbers: name, value with unit, remark. Raises SceneError for whatever would keep a run from starting."""
    parameters = checked_parameters(scene)
    state = start(scene, parameters)
    rows = [
        ("spheres", str(len(parameters.radius)), f"{len(scene.spheres)} species"),
        ("contacts", str(int(state.contacts[0])), "at the start"),
        (
            "narrowest gap",
            f"{math.exp(state.log_gap[: state.contacts[0]].min(initial=math.inf)):.4g} m",
            "at the start",
        ),
    ]
    force = float(np.abs(parameters.force).max())
    if force > 0.0:
        rows += _regimes(scene, parameters, force)
    return [*rows, ("accuracy", f"{parameters.tolerance:.1g}", "of each gap, relative, in a step")]


def _regimes(scene: SoftScene, parameters: Parameters, force: float) -> list[tuple[str, str, str]]:
    """What the largest force means between two typical spheres."""
    radius, modulus = float(np.median(parameters.radius)), float(np.median(parameters.modulus))
    if scene.films.surface == "bubble":
        tension = scene.liquid.surface_tension or math.nan
        told = "largest force over surface tension times radius: well below 1 for facets smaller than bubbles"
        return [("reduced force", f"{force / (tension * radius):.4g}", told)]
    reduced = force / (modulus * radius**2)
    lost = "; below 1e-7 it is lost in rounding, and steps get short" if reduced < 1e-7 else ""
    pair = SoftPair(radius, modulus, scene.liquid.viscosity, prefactors_of(scene.films))
    return [
        ("reduced force", f"{reduced:.4g}", "largest force over modulus times radius squared" + lost),
        ("crossover gap", f"{crossover_gap(pair, force):.4g} m", "Poiseuille's regime above, Hertz's below"),
        ("viscous time", f"{viscous_time(pair, force):.4g} s", "in which a wide gap opens by a factor of e"),
    ]


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
    summary=summary,
)
"""Soft spheres in a viscous liquid: Soft Dynamics."""
