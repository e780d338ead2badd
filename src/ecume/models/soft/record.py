"""The soft model, as the driver sees it."""

from __future__ import annotations

import numpy as np

from ecume._portable import exp
from ecume.models.advice import Row
from ecume.models.blame import DEEP, first_broken
from ecume.models.limits import require_memory
from ecume.models.model import Model
from ecume.models.soft.advice import advice
from ecume.models.soft.building import parameters_of, start
from ecume.models.soft.cost import bytes_of
from ecume.models.soft.invariants import invariants
from ecume.models.soft.meeting import box_in
from ecume.models.soft.observing import observe
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.sources import laws_of
from ecume.models.soft.state import ACCEPTED, CLOCK, LENGTH, State, workspace
from ecume.models.soft.stepping import advance
from ecume.scenes.soft import SoftScene


def checked_parameters(scene: SoftScene) -> Parameters:
    """The parameters of a scene that fits into the machine."""
    count = sum(species.count or len(species.positions) for species in scene.spheres)
    everyone = scene.films.reach is None and scene.box is None
    contacts = count * (count - 1) / 2 if everyone else 20.0 * count
    require_memory("spheres", f"{count} spheres", bytes_of(contacts), "use fewer spheres, or set films.reach")
    return parameters_of(scene)


def diagnosis(parameters: Parameters, state: State) -> str:
    """Who left the range where it means anything, when, and what to do."""
    when = f"at t = {state.pace[CLOCK]:.6g} s (step {state.tally[ACCEPTED]})"
    broken = first_broken({"position": state.position, "velocity": state.velocity, "spin": state.spin})
    told = f"sphere {broken.particle} has no finite {broken.term} any more" if broken else _closest(parameters, state)
    return (
        f"{when} no step is short enough, {state.pace[LENGTH]:.3g} s neither; {told}: "
        "look for forces that the surfaces cannot balance, or set stepping.tolerance lower"
    )


def _closest(parameters: Parameters, state: State) -> str:
    """The film whose gap is no number, the spheres that are in one another, or the narrowest gap."""
    contacts, box = int(state.contacts[0]), box_in(parameters, state)
    if contacts == 0:
        return "no sphere has a film with another"
    pair, image = state.pair[:contacts], state.image[:contacts]
    with np.errstate(over="ignore"):
        gap = exp(state.log_gap[:contacts])
    between = state.position[pair[:, 1]] - state.position[pair[:, 0]] + image * box.sides
    between[:, 0] += box.tilt * image[:, 1]
    depth = parameters.radius[pair].sum(axis=1) - np.linalg.norm(between, axis=1)
    none, deepest = first_broken({"gap": gap}), int(np.argmax(depth))
    if none is None and depth[deepest] > DEEP * parameters.radius.min():
        return f"spheres {pair[deepest, 0]} and {pair[deepest, 1]} overlap by {depth[deepest]:.3g} m"
    at = int(np.argmin(gap)) if none is None else none.particle
    what = f"the narrowest gap, {gap[at]:.3g} m, is" if none is None else "there is no finite gap any more"
    return f"{what} between spheres {pair[at, 0]} and {pair[at, 1]}"


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
    invariants=invariants,
    laws=laws_of,
    summary=summary,
)
"""Soft spheres in a viscous liquid: Soft Dynamics."""
