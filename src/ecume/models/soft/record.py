"""The record of the soft model: the functions that a run calls."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ecume.laws import friction, interfaces, long_range, permeability, soft_pair, surfaces
from ecume.laws.soft_contacts import TANGENTIAL, TENSION
from ecume.models.actions import Access
from ecume.models.costs import require_memory
from ecume.models.invariants import DISSIPATED, ENERGY, INJECTED, Invariant, NumberHistory, part_of
from ecume.models.layouts import Layout
from ecume.models.model import DIVERGED, Model, Row, Source
from ecume.models.soft.integration import dirk_schemes, time_stepping
from ecume.models.soft.integration.dirk_schemes import error_of_run
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.preparation import start, unprepared
from ecume.models.soft.report import diagnosis as reason
from ecume.models.soft.report.check_report import advice, bytes_of
from ecume.models.soft.report.observation import LARGE, SIZE_WORK, STAKE, main_stresses, observe
from ecume.models.soft.setup import parameters_of
from ecume.models.soft.state import (
    ACCEPTED,
    CLOCK,
    NO_BUDGET,
    State,
    Workspace,
    at_present,
    make_state,
    waiting_of,
    workspace,
)
from ecume.models.soft.waiting import STATIONARY, take
from ecume.scenes.soft import SoftScene, tension_law_of
from ecume.trajectories.frame import Frame

if TYPE_CHECKING:
    from ecume.models.user_laws import BoundLaw


def checked_parameters(scene: SoftScene) -> Parameters:
    """The parameters of a scene that fits into the memory of the machine."""
    count = sum(species.count or len(species.positions) for species in scene.particles)
    every = scene.films.cutoff is None and scene.cell is None
    contacts = count * (count - 1) / 2 if every else 20.0 * count
    require_memory("particles", f"{count} spheres", bytes_of(contacts), "use fewer spheres, or set films.cutoff")
    return parameters_of(scene)


def layout(scene: SoftScene, parameters: Parameters, state: State) -> Layout:
    """The layout of a state of this scene; contacts contain indices of spheres."""
    count, room = len(parameters.radius), state.pair.size // 2
    blank = make_state(parameters, np.zeros((count, parameters.dimensions)), room)
    if not state.budget.size:
        blank = blank._replace(budget=NO_BUDGET)
    if scene.preparation is not None and state.prepared.size:
        blank = blank._replace(prepared=np.zeros(2))
    indices = {"contacts": (0, room), "pair": (0, count - 1), "touching": (0, 1)}
    if len(blank.rate_ends):
        indices |= {"rate_reached": (0, STATIONARY), "rate_frames": (0, len(blank.rate_stresses))}
    return Layout(blank, indices, {"order": count})


def advance(parameters: Parameters, state: State, scratch: Workspace, steps: int) -> int:
    """Integrate as `time_stepping.advance`. At frames, rates end whose stress has become stationary."""
    before, now = int(state.step[0]), at_present(parameters, state)
    status = time_stepping.advance(now, state, scratch, steps)
    at_frame = state.step[0] != before and state.step[0] % parameters.steps_per_frame == 0
    if len(state.rate_ends) and status != DIVERGED and at_frame:
        fits = scratch.generation == state.generation[0]
        stresses = main_stresses(now, state, scratch if fits else workspace(now, state, 1.0))
        take(waiting_of(state), now.protocol, float(state.pace[CLOCK]), stresses)
    return status


def frame(parameters: Parameters, state: State, scratch: Workspace) -> Frame:
    """The frame of this instant."""
    return observe(at_present(parameters, state), state, scratch)


def diagnosis(parameters: Parameters, state: State) -> str:
    """The reason why no step succeeds."""
    return reason.diagnosis(at_present(parameters, state), state)


def extended(laws: Sequence[BoundLaw]) -> Model:
    """The model of soft spheres with user laws."""
    from ecume.models.soft import user_laws

    return user_laws.extended(SOFT, laws)


def summary(scene: SoftScene) -> list[Row]:
    """Derived numbers: name, value with unit, remark. Raises SceneError if the run could not start."""
    parameters = checked_parameters(scene)
    return advice(scene, parameters, unprepared(scene, parameters))


# --- Invariants of soft spheres: balanced forces, positive gaps, and energy


DEEP_CONTACT = "the largest of a contact, over the smaller radius, beyond which the contact laws are inaccurate"
UNBALANCED = 1e-7
"""The largest residual force over the typical force; steps leave less than a tenth of it, unless deflections are lost
in rounding.
"""


def invariants(scene: SoftScene, parameters: Parameters) -> list[Invariant]:
    """The invariants of a scene."""
    balance = "what a step leaves on a sphere, over the typical force"
    allowed = error_of_run(parameters.scheme, parameters.tolerance)
    return [
        Invariant("gap", "whether any is closed", 0.0, _closed),
        Invariant("force balance", balance, UNBALANCED, _left),
        Invariant("deflection", DEEP_CONTACT, LARGE, _deflected),
        Invariant(ENERGY, "what its budget misses, over what moved", allowed, _missing),
    ]


def _missing(seen: NumberHistory) -> float:
    """The residual of the energy budget: the work minus the changes of stored, dissipated and
    surface energy.

    It is relative to the exchanged energy plus `stake`, since the tolerance refers to ln(gap) and directions.
    """
    if INJECTED not in seen.now:
        return 0.0
    first, now = seen.first, seen.now
    spent = sum(now[key] - first.get(key, 0.0) for key in ("total_energy", DISSIPATED, SIZE_WORK))
    moved = now[DISSIPATED] + seen.largest["total_energy"] - seen.least["total_energy"]
    return part_of(abs(now[INJECTED] - first.get(INJECTED, 0.0) - spent), moved + seen.largest[STAKE])


def _deflected(seen: NumberHistory) -> float:
    """The largest deflection; zero in runs of earlier versions."""
    return seen.now.get("largest_deflection", 0.0)


def _closed(seen: NumberHistory) -> float:
    return 0.0 if seen.now["smallest_gap"] > 0.0 else 1.0


def _left(seen: NumberHistory) -> float:
    return seen.now["imbalance"]


# --- The laws behind a scene of soft spheres, whose docstrings cite the papers


def laws_of(scene: Any) -> list[Source]:
    """The sources of the laws of films, surfaces and tangential forces."""
    films = scene.films
    laws: list[Source] = [soft_pair.squeeze_friction, soft_pair.shear_friction, soft_pair.contact_size]
    laws += [*surfaces.SURFACES[films.surface].papers, interfaces.INTERFACES[films.interface]]
    laws += friction.FRICTIONS[films.friction].papers
    laws += [*TANGENTIAL[films.tangential_law].papers, *TENSION[tension_law_of(scene)].papers]
    if scene.permeation is not None:
        laws += [permeability.seepage_gradient, *permeability.PERMEABILITIES[scene.permeation.law].papers]
    row = long_range.REMOTE[scene.long_range_forces.law]
    return [*laws, row.energy, row.force, row.slope, dirk_schemes.SCHEMES[scene.integration.integrator].paper]


def steps_taken(state: State) -> int:
    """The number of accepted steps."""
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
    observe=frame,
    constant=frozenset(["radius", "species"]),
    main_numbers=("total_energy", "smallest_gap", "contacts", "imbalance", "strain", "shear_stress", "pressure"),
    diagnosis=diagnosis,
    invariants=invariants,
    laws=laws_of,
    summary=summary,
    extended=extended,
)
"""Soft spheres in a viscous liquid: Soft Dynamics."""
