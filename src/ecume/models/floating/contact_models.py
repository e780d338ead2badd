"""The table of contacts: what happens where floats touch, one row of which a scene chooses (`contacts.law`)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume._jit import composed, selected
from ecume.laws import contact
from ecume.models.floating.meeting import Impulses, meet, rest, settle
from ecume.models.floating.options import Built, Option
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.roughness import friction_at_step, friction_of
from ecume.models.floating.rubbing import Rough, make_rubbed
from ecume.models.floating.shaped.bodies import Outlined, Shaped
from ecume.models.floating.shaped.building import overlaps
from ecume.models.floating.shaped.meeting import find_outlined, meet_outlined, rest_outlined, settle_outlined
from ecume.models.floating.springs import Springs, meet_springs, rest_springs, spring_energies, springs_of
from ecume.models.floating.state import State, Workspace
from ecume.models.model import DONE
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene


class NoContacts(NamedTuple):
    """Floats pass through one another."""


@composed
def no_contacts(part: Any, own: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Nothing happens."""


@composed
def all_listed(part: Any, own: Any, parameters: Parameters, state: State, workspace: Workspace) -> int:
    """Candidates are listed with the neighbors."""
    return DONE


def no_energy(part: Any, own: Any, parameters: Parameters, state: State, workspace: Workspace) -> tuple[float, float]:
    """Impulses store no energy."""
    return 0.0, 0.0


def no_scratch(part: Any, parameters: Parameters, state: State, workspace: Workspace, interactions: Any) -> Any:
    """Contacts without friction need no more than the workspace has."""
    return ()


def friction_scratch(part: Rough, parameters: Parameters, state: State, workspace: Workspace, interactions: Any) -> Any:
    """Impulses along surfaces, and spins."""
    return make_rubbed(part, parameters, state, workspace)


def shared_scratch(part: Any, parameters: Parameters, state: State, workspace: Workspace, interactions: Any) -> Any:
    """That of the floats with a shape."""
    return interactions[0]


def as_they_are(state: State) -> State:
    """The state needs no more."""
    return state


def with_friction_impulses(state: State) -> State:
    """The state with room for impulses along the surfaces."""
    return state._replace(rub=np.zeros(len(state.push)))


@dataclass(frozen=True, kw_only=True)
class ContactModel(Option):
    """A row of the table, and everything that depends on it."""

    slot: str = "contacts"
    constants: type
    """the type of the part, a NamedTuple"""
    make: Callable[[Parameters, FloatingScene, tuple[Any, ...]], Built]
    """make(parameters without parts, scene, interactions). Raises SceneError"""
    at_step: Callable[[Any, Parameters, Array | None], Any] = lambda part, parameters, turned: part
    """at_step(part, parameters, turned): the part for the chosen time step; `turned` is the inertia of floats that
    interactions turn, or None
    """
    meet: Callable[..., None] = no_contacts
    """meet(part, scratch, parameters, state, workspace): before the drift, on the passage"""
    settle: Callable[..., None] = no_contacts
    """settle(part, scratch, parameters, state, workspace): after the drift, on positions"""
    rest: Callable[..., None] = no_contacts
    """rest(part, scratch, parameters, state, workspace): on velocities at the end of the step"""
    find: Callable[..., int] = all_listed
    """find(part, scratch, parameters, state, workspace): who may meet in this step; DONE or CROWDED"""
    scratch: Callable[..., Any] = no_scratch
    state: Callable[[State], State] = as_they_are
    inertia: Callable[[Any], Array | None] = lambda part: None
    """inertia(part): of floats that contacts turn (kg m^2), (N,)"""
    energy: Callable[..., tuple[float, float]] = no_energy
    """energy(part, scratch, parameters, state, workspace): among floats and at walls (J)"""
    gaps: Callable[..., list[tuple[int, int, float]]] | None = None
    """gaps(part, parameters, positions, angles, reach): for floats that are no discs"""
    laws: tuple[Callable[..., Any], ...] = (contact.impulse,)
    """functions whose docstrings name the references that `ecume cite` lists"""


def _outline_gaps(
    part: Any, parameters: Parameters, position: Array, angle: Array, reach: float
) -> list[tuple[int, int, float]]:
    return overlaps(part.outlines, part.places, parameters, (position, angle), reach)


def _outlined(parameters: Parameters, scene: FloatingScene, interactions: tuple[Any, ...]) -> Built:
    shapes: Shaped = interactions[0]
    return Built(Outlined(shapes.outlines, shapes.places, scene.contacts.law != "none"))


def _simple(part: Any) -> Callable[..., Built]:
    return lambda parameters, scene, interactions: Built(part)


ENDS = "contacts act on the velocity at the ends of a step"
CONTACTS = {
    "none": ContactModel(
        path="contacts.law", name="'none'", constants=NoContacts, make=_simple(NoContacts()),
        gives=frozenset({"shared contacts", "lubricated"}), laws=(),
    ),
    "impulse": ContactModel(
        path="contacts.law", name="'impulse'", constants=Impulses, make=_simple(Impulses(False)),
        meet=meet, settle=settle, rest=rest, gives=frozenset({"shared contacts", "lubricated"}),
    ),
    "legacy": ContactModel(
        path="contacts.legacy_coefficient", name="the original collisions", constants=Impulses,
        make=_simple(Impulses(True)), meet=meet, settle=settle, rest=rest,
        gives=frozenset({"shared contacts", "lubricated"}),
        needs={"round": "the original program knows spheres only"},
    ),
    "friction": ContactModel(
        path="contacts.friction", name="friction", constants=Rough, make=friction_of, at_step=friction_at_step,
        meet=meet, settle=settle, rest=rest, scratch=friction_scratch, state=with_friction_impulses,
        inertia=lambda part: np.asarray(part.inertia), gives=frozenset({"lubricated"}),
        needs={
            "reciprocal": "spins take what the law's momentum lacks",
            "kicks spins": "angles and spins go with the kicks of the velocities",
            "round": "the solver for outlines knows smooth surfaces only",
        },
    ),
    "spring-dashpot": ContactModel(
        path="contacts.law", name="'spring-dashpot'", constants=Springs, make=springs_of,
        meet=meet_springs, rest=rest_springs, energy=spring_energies,
        laws=(contact.spring_push, contact.dashpot_restitution),
        needs={
            "reciprocal": "its energy is compared with that of the pair law",
            "springs": "others gain energy from springs, or see their forces within a step",
            "round": "a spring between outlines would need the depth of their overlap",
        },
    ),
    "outlines": ContactModel(
        path="particles", name="a float with a shape", constants=Outlined, make=_outlined, meet=meet_outlined,
        settle=settle_outlined, rest=rest_outlined, find=find_outlined, scratch=shared_scratch, gaps=_outline_gaps,
    ),
}  # fmt: skip
"""By the name of the choice."""
BY_CONSTANTS: dict[type, ContactModel] = {row.constants: row for row in reversed(CONTACTS.values())}


def contacts_of(parameters: Parameters) -> ContactModel:
    """The row of the parameters' contacts."""
    return BY_CONSTANTS[type(parameters.parts.contacts)]


def gaps_between(parameters: Parameters, position: Array, angle: Array, reach: float) -> list[tuple[int, int, float]]:
    """Pairs (i, j, gap) of floats with outlines that are nearer than `reach`; a wall number k stands as N + k."""
    gaps = contacts_of(parameters).gaps
    return [] if gaps is None else gaps(parameters.parts.contacts, parameters, position, angle, reach)


meet_contacts = selected(lambda kind: BY_CONSTANTS[kind].meet)
settle_contacts = selected(lambda kind: BY_CONSTANTS[kind].settle)
rest_contacts = selected(lambda kind: BY_CONSTANTS[kind].rest)
find_contacts = selected(lambda kind: BY_CONSTANTS[kind].find)
