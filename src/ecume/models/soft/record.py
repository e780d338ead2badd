"""The soft model, as the driver sees it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ecume._portable import exp
from ecume.laws import friction, interfaces, long_range, soft_pair, surfaces
from ecume.laws.soft_contacts import TANGENTIAL, TENSION
from ecume.models.actions import Access
from ecume.models.costs import require_memory
from ecume.models.diagnosis import DEEP, first_broken
from ecume.models.invariants import DISSIPATED, ENERGY, INJECTED, Invariant, NumberHistory, part_of
from ecume.models.layouts import Layout
from ecume.models.model import Model, Row, Source
from ecume.models.soft.contacts.tree_search import box_in
from ecume.models.soft.integration import dirk_schemes
from ecume.models.soft.integration.dirk_schemes import error_of_run
from ecume.models.soft.integration.time_stepping import advance
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.protocol import interval_at, rules_at
from ecume.models.soft.report.balance_report import remedies, unborne
from ecume.models.soft.report.check_report import advice, bytes_of
from ecume.models.soft.report.observation import LARGE, SIZE_WORK, STAKE, deflections, observe, remedy, worst_contact
from ecume.models.soft.setup import parameters_of, start
from ecume.models.soft.state import ACCEPTED, CLOCK, LENGTH, NO_BUDGET, State, make_state, workspace
from ecume.scenes.soft import SoftScene, tension_law_of
from ecume.units import with_prefix

if TYPE_CHECKING:
    from ecume.models.user_laws import BoundLaw


def checked_parameters(scene: SoftScene) -> Parameters:
    """The parameters of a scene that fits into the machine."""
    count = sum(species.count or len(species.positions) for species in scene.particles)
    every = scene.films.cutoff is None and scene.cell is None
    contacts = count * (count - 1) / 2 if every else 20.0 * count
    require_memory("particles", f"{count} spheres", bytes_of(contacts), "use fewer spheres, or set films.cutoff")
    return parameters_of(scene)


def layout(scene: SoftScene, parameters: Parameters, state: State) -> Layout:
    """What a state of this scene looks like; contacts name spheres."""
    count, room = len(parameters.radius), state.pair.size // 2
    blank = make_state(parameters, np.zeros((count, parameters.dimensions)), room)
    if not state.budget.size:
        blank = blank._replace(budget=NO_BUDGET)
    indices = {"contacts": (0, room), "pair": (0, count - 1), "touching": (0, 1)}
    return Layout(blank, indices, {"order": count})


def diagnosis(parameters: Parameters, state: State) -> str:
    """The sphere that left the range of validity, the time, and the remedy."""
    when = f"at t = {state.pace[CLOCK]:.6g} s (step {state.tally[ACCEPTED]})"
    broken = first_broken({"position": state.position, "velocity": state.velocity, "spin": state.spin})
    report = f"sphere {broken.particle} has no finite {broken.term} any more" if broken else _closest(parameters, state)
    found = deflections(parameters, state)
    rules = rules_at(parameters.protocol, interval_at(parameters.protocol, float(state.pace[CLOCK])))
    if not broken and (cause := unborne(parameters, state, rules)):
        return f"{when} no step is short enough; {cause}"
    if broken or not np.isfinite(found.magnitude).all():
        cure = "look for forces that the surfaces cannot balance, or set integration.tolerance lower"
    else:
        report = "; ".join(filter(None, (report, worst_contact(found))))
        cure = remedy(found, parameters.contacts)
    if any(rules) and not parameters.drag.any():
        cure += f"; a packing too loose for its stress: {remedies(parameters)}"
    return f"{when} no step is short enough, {state.pace[LENGTH]:.3g} s neither; {report}: {cure}"


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
        return f"spheres {pair[deepest, 0]} and {pair[deepest, 1]} overlap by {with_prefix(depth[deepest], 'm', 3)}"
    at = int(np.argmin(gap)) if none is None else none.particle
    what = (
        f"the narrowest gap, {with_prefix(gap[at], 'm', 3)}, is" if none is None else "there is no finite gap any more"
    )
    return f"{what} between spheres {pair[at, 0]} and {pair[at, 1]}"


def extended(laws: Sequence[BoundLaw]) -> Model:
    """Soft spheres with laws of the user."""
    from ecume.models.soft import user_laws

    return user_laws.extended(SOFT, laws)


def summary(scene: SoftScene) -> list[Row]:
    """Derived numbers: name, value with unit, remark. Raises SceneError for whatever would keep a run from starting."""
    parameters = checked_parameters(scene)
    return advice(scene, parameters, start(scene, parameters))


# --- What soft spheres must not lose: the balance of forces on each, the films between them, and energy


DEEP_CONTACT = "the largest of a contact, over the smaller radius, beyond which the contact laws are inaccurate"
UNBALANCED = 1e-7
"""Of the typical force: steps leave less than a tenth of it, but where deflections are lost in rounding."""


def invariants(scene: SoftScene, parameters: Parameters) -> list[Invariant]:
    """The rows of a scene."""
    balance = "what a step leaves on a sphere, over the typical force"
    allowed = error_of_run(parameters.scheme, parameters.tolerance)
    return [
        Invariant("gap", "whether any is closed", 0.0, _closed),
        Invariant("force balance", balance, UNBALANCED, _left),
        Invariant("deflection", DEEP_CONTACT, LARGE, _deflected),
        Invariant(ENERGY, "what its budget misses, over what moved", allowed, _missing),
    ]


def _missing(seen: NumberHistory) -> float:
    """The defect of the energy budget: work less the change of stored energy, dissipation, and the part of contact
    sizes. The tolerance is one of ln(gap) and directions, so where little moved, of what moving as much would do.
    """
    if INJECTED not in seen.now:
        return 0.0
    first, now = seen.first, seen.now
    spent = sum(now[key] - first.get(key, 0.0) for key in ("total_energy", DISSIPATED, SIZE_WORK))
    moved = now[DISSIPATED] + seen.largest["total_energy"] - seen.least["total_energy"]
    return part_of(abs(now[INJECTED] - first.get(INJECTED, 0.0) - spent), moved + seen.largest[STAKE])


def _deflected(seen: NumberHistory) -> float:
    """Zero in runs of an earlier version."""
    return seen.now.get("largest_deflection", 0.0)


def _closed(seen: NumberHistory) -> float:
    return 0.0 if seen.now["smallest_gap"] > 0.0 else 1.0


def _left(seen: NumberHistory) -> float:
    return seen.now["imbalance"]


# --- The laws behind a scene of soft spheres, whose docstrings cite the papers


def laws_of(scene: Any) -> list[Source]:
    """Films, surfaces, what acts across."""
    films = scene.films
    laws: list[Source] = [soft_pair.squeeze_friction, soft_pair.shear_friction, soft_pair.contact_size]
    laws += [*surfaces.SURFACES[films.surface].papers, interfaces.INTERFACES[films.interface]]
    laws += friction.FRICTIONS[films.friction].papers
    laws += [*TANGENTIAL[films.tangential_law].papers, *TENSION[tension_law_of(scene)].papers]
    row = long_range.REMOTE[scene.long_range_forces.law]
    return [*laws, row.energy, row.force, row.slope, dirk_schemes.SCHEMES[scene.integration.integrator].paper]


def steps_taken(state: State) -> int:
    """The steps that were accepted."""
    return int(state.tally[ACCEPTED])


SOFT = Model(
    name="soft",
    adaptive=True,
    steps_taken=steps_taken,
    state=State,
    parameters=checked_parameters,
    start=start,
    layout=layout,
    workspace=workspace,
    advance=advance,
    access=Access(refusal="positions of soft spheres follow from the balance of forces; use [[protocol]] and walls"),
    observe=observe,
    constant=frozenset(["radius", "species"]),
    main_numbers=("total_energy", "smallest_gap", "contacts", "imbalance", "strain", "shear_stress", "pressure"),
    diagnosis=diagnosis,
    invariants=invariants,
    laws=laws_of,
    summary=summary,
    extended=extended,
)
"""Soft spheres in a viscous liquid: Soft Dynamics."""
