"""The table of contact models, from which a scene chooses one row (`contacts.law`).

Contacts as springs and dashpots instead of impulses. They are stable only for short time steps.

The force of a contact is that of the spring at the positions, and of the dashpot at the velocities, at the beginning of
the step. In velocity Verlet, half of the force acts at the beginning and half at the end. At the end, dashpots use the
midstep velocities: with the final velocities, a pair would not come to rest at its equilibrium. Forces are equal and
opposite along the line of centers, so that momentum and angular momentum are conserved to rounding. Only the stiffness
limits overlaps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume._jit import admit, selected
from ecume._tables import by_constants
from ecume.engine.contact.contacts import Contacts
from ecume.engine.contact.torque_contacts import make_torque_contacts
from ecume.laws import friction
from ecume.models.floating.contacts.collisions import (
    VARIANTS,
    Friction,
    Impulses,
    Outlined,
    collide,
    constrain_velocities,
    friction_at_step,
    friction_of,
    impulses_at_step,
    make_friction_scratch,
    separate,
    with_friction_impulses,
)
from ecume.models.floating.coupled.hydrodynamics import (
    CoupledImpulses,
    collide_coupled,
    rubbing_impulses_of,
    smooth_impulses_of,
)
from ecume.models.floating.options import Built, Option
from ecume.models.floating.parameters import Parameters, State, Workspace
from ecume.models.floating.setup.overlaps import Gaps, gaps_of_outlines, separated_outlines
from ecume.models.floating.shaped.bodies import (
    Shaped,
    collide_outlines,
    constrain_outline_velocities,
    find_outline_contacts,
    separate_outlines,
)
from ecume.models.model import DONE
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene
from ecume.models.floating.contacts.springs import Springs, push_at_end, push_before_drift, spring_energies, springs_of

admit(friction)


class NoContacts(NamedTuple):
    """No contacts: floats can overlap."""


def no_energy(
    part: Any, scratch: Any, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """Return zero: impulses store no energy."""
    return 0.0, 0.0


def no_scratch(part: Any, parameters: Parameters, state: State, workspace: Workspace, moving: Any) -> Any:
    """Return an empty workspace for contacts without friction."""
    return ()


def shared_scratch(part: Any, parameters: Parameters, state: State, workspace: Workspace, moving: Any) -> Any:
    """Return the workspace of the integrator."""
    return moving


def unchanged_state(part: Any, state: State) -> State:
    """Return the state unchanged."""
    return state


def with_coupled_friction(part: CoupledImpulses, state: State) -> State:
    """Return the state with an array of tangential impulses."""
    return state._replace(friction_impulse=np.zeros(len(state.contact_impulse)))


@dataclass(frozen=True, kw_only=True)
class ContactModel(Option):
    """A row of the table, and everything that depends on it."""

    slot: str = "contacts"
    constants: type
    """the type of the part, a NamedTuple"""
    make: Callable[[Parameters, FloatingScene, tuple[Any, ...]], Built]
    """make(parameters without parts, scene, interactions). Raises SceneError"""
    at_step: Callable[[Any, Parameters, Array | None, bool], Any] = lambda part, parameters, turned, pushed: part
    """at_step(part, parameters, turned, pushed): the part for the chosen time step; `turned` is the inertia of floats
    that interactions turn, or None; `pushed` says whether walls move
    """
    before_drift: Callable[..., None] | None = None
    """before_drift(part, scratch, parameters, state, workspace): change `workspace.midstep_velocity`"""
    after_drift: Callable[..., None] | None = None
    """after_drift(part, scratch, parameters, state, workspace): change positions"""
    at_end: Callable[..., None] | None = None
    """at_end(part, scratch, parameters, state, workspace): change velocities at the end of the step"""
    find: Callable[..., int] | None = None
    """find(part, scratch, parameters, state, workspace): list possible contacts of this step; `DONE` or `CROWDED`. None
    if candidates are listed with the neighbors
    """
    scratch: Callable[..., Any] = no_scratch
    """scratch(part, parameters, state, workspace, workspace of the integrator): the workspace"""
    state: Callable[[Any, State], State] = unchanged_state
    """state(part, state): the state with the data of the part"""
    inertia: Callable[[Any], Array | None] = lambda part: None
    """inertia(part): of floats that contacts turn (kg m^2), (N,)"""
    energy: Callable[..., tuple[float, float]] = no_energy
    """energy(part, scratch, parameters, state, workspace): among floats and at walls (J)"""
    rows: Callable[[Any, Contacts], Any] = lambda part, rows: rows
    """rows(part, rows of discs): the rows of a workspace that has room for as many contacts of discs"""
    gaps: Callable[..., Gaps] | None = None
    """gaps(part, parameters, (positions, angles), reach): for floats that are no discs"""
    separated: Callable[..., tuple[Array, Array]] | None = None
    """separated(part, parameters, (positions, angles), gaps): positions and angles without the overlaps in `gaps`; None
    for discs, whose overlaps `setup.overlaps.separated` removes
    """
    stores_overlaps: bool = False
    """whether overlaps store energy, so that those of the start stay"""
    laws: tuple[Callable[..., Any], ...] = (friction.impulse,)
    """functions whose docstrings name the references that `ecume cite` lists"""


def _outlined(parameters: Parameters, scene: FloatingScene, interactions: tuple[Any, ...]) -> Built:
    shapes: Shaped = interactions[0]
    return Built(Outlined(shapes.outlines, shapes.places))


def _simple(part: Any) -> Callable[..., Built]:
    return lambda parameters, scene, interactions: Built(part)


ENDS = "contacts act on the velocity at the ends of a step"
CONTACTS = {
    "none": ContactModel(
        path="contacts.law", name="'none'", constants=NoContacts, make=_simple(NoContacts()),
        gives=frozenset({"lubricated", "full mobility", "no spins"}), laws=(),
    ),
    "impulse": ContactModel(
        path="contacts.law", name="'impulse'", constants=Impulses, make=_simple(Impulses(False)),
        at_step=impulses_at_step,
        before_drift=collide, after_drift=separate, at_end=constrain_velocities,
        gives=frozenset({"apart", "lubricated", "full mobility", "no spins"}),
    ),
    "legacy": ContactModel(
        path="contacts.legacy_coefficient", name="the original collisions", constants=Impulses,
        make=_simple(Impulses(True)), at_step=impulses_at_step,
        before_drift=collide, after_drift=separate, at_end=constrain_velocities,
        gives=frozenset({"apart", "lubricated", "no spins"}),
        needs={"round": "the original program knows spheres only"},
    ),
    "friction": ContactModel(
        path="contacts.friction", name="friction", constants=Friction, make=friction_of, at_step=friction_at_step,
        before_drift=collide, after_drift=separate, at_end=constrain_velocities, scratch=make_friction_scratch,
        state=with_friction_impulses,
        inertia=lambda part: np.asarray(part.inertia), gives=frozenset({"apart", "lubricated", "full mobility"}),
        needs={
            "round": "friction of one body at several points at once is not solved",
        },
    ),
    "spring-dashpot": ContactModel(
        path="contacts.law", name="'spring-dashpot'", constants=Springs, make=springs_of,
        before_drift=push_before_drift, at_end=push_at_end, energy=spring_energies, stores_overlaps=True,
        laws=(friction.spring_push, friction.dashpot_restitution), gives=frozenset({"apart", "no spins"}),
        needs={
            "springs": "others gain energy from springs, or see their forces within a step",
            "round": "two edges in contact at two points would be twice as stiff as at one",
        },
    ),
    "outlines": ContactModel(
        path="particles", name="a float with a shape", constants=Outlined, make=_outlined,
        at_step=impulses_at_step, before_drift=collide_outlines, after_drift=separate_outlines,
        at_end=constrain_outline_velocities, find=find_outline_contacts, scratch=shared_scratch, gaps=gaps_of_outlines,
        rows=lambda part, rows: make_torque_contacts(2 * len(rows.gap), part.places),
        separated=separated_outlines,
    ),
    "coupled": ContactModel(
        path="contacts.law", name="contacts of floats that interact through the liquid", constants=CoupledImpulses,
        make=smooth_impulses_of, before_drift=collide_coupled, after_drift=separate,
        scratch=shared_scratch, state=with_coupled_friction,
        inertia=lambda part: np.asarray(part.inertia) if len(part.inertia) else None,
    ),
}  # fmt: skip
"""The contact models by name."""
CONTACTS["rolling friction"] = replace(
    CONTACTS["friction"], path="contacts.rolling_friction", name="rolling friction",
    needs={
        **CONTACTS["friction"].needs, "single drag": "the couple of a contact turns neighbors through the liquid, too",
    },
    laws=(friction.impulse, friction.rolling_limit),
)  # fmt: skip
CONTACTS["coupled friction"] = replace(CONTACTS["coupled"], path="contacts.friction", make=rubbing_impulses_of)
OF_THE_CHOICE = frozenset({"name", "path", "make", "gives", "needs", "laws"})
"""Fields that are read from the row that a scene chooses: rows with constants of one type may differ in them."""
BY_CONSTANTS = by_constants(CONTACTS.values(), OF_THE_CHOICE)
BY_CONSTANTS |= {
    kind: replace(BY_CONSTANTS[plain], constants=kind) for plain, kinds in VARIANTS.items() for kind in kinds
}


def contacts_of(parameters: Parameters) -> ContactModel:
    """The row of the parameters' contacts."""
    return BY_CONSTANTS[type(parameters.parts.contacts)]


def rows_for(parameters: Parameters, rows: Contacts) -> Any:
    """The contacts of a workspace, for as many as these rows of discs have room for."""
    return contacts_of(parameters).rows(parameters.parts.contacts, rows)


def gaps_between(parameters: Parameters, position: Array, angle: Array, reach: float) -> Gaps:
    """Triples (i, j, gap) of floats with outlines closer than `reach`; the number N + k denotes wall k."""
    gaps = contacts_of(parameters).gaps
    return [] if gaps is None else gaps(parameters.parts.contacts, parameters, (position, angle), reach)


contacts_before_drift = selected(BY_CONSTANTS, "before_drift")
contacts_after_drift = selected(BY_CONSTANTS, "after_drift")
contacts_at_end = selected(BY_CONSTANTS, "at_end")
find_contacts = selected(BY_CONSTANTS, "find", DONE)
