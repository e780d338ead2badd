"""Compatibility of options: every option states its capabilities and its needs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ecume.errors import Fault, SceneError


@dataclass(frozen=True, kw_only=True)
class Option:
    """The common fields of all rows of tables."""

    slot: str
    """the kind of choice: integrator, interaction, resistance, contacts, ..."""
    path: str
    """the key of the scene that chooses it"""
    name: str
    """in messages"""
    gives: frozenset[str] = frozenset()
    """capabilities: keys of `CAPABILITIES`"""
    needs: Mapping[str, str] = field(default_factory=dict)
    """capabilities that it requires of the options in other slots, each with the physical reason"""


class Built(NamedTuple):
    """A part of a scene, and its requirements on time step and lists."""

    part: Any
    shortest_time: float = math.inf
    """s: its shortest time scale, which limits the time step"""
    stiffness_factor: float = 1.0
    """stiffness of contacts over that of superposition, at most"""
    reach: float = 0.0
    """m: the range of neighbor lists that it requires, without the skin"""


CAPABILITIES: dict[str, tuple[str, str]] = {
    "reciprocal": ("pair law", "a pair law that exerts equal and opposite forces on the two floats"),
    "menisci": ("pair law", "a pair law that is the superposition of menisci"),
    "charges": ("pair law", "a pair law that is the superposition of menisci"),
    "kicks at the ends": ("integrator", "an integrator whose forces act at the ends of a step"),
    "fast drag": ("integrator", "an integrator whose kicks solve drag exactly, with inertia"),
    "sways": ("integrator", "an integrator that includes the motion of the dish"),
    "kicks spins": ("integrator", "an integrator whose kicks change spins, too"),
    "takes noise": ("integrator", "an integrator whose order does not rest on smooth forces"),
    "keeps inertia": ("integrator", "an integrator with inertia"),
    "no inertia": ("integrator", "an integrator without inertia"),
    "springs": ("integrator", "an integrator that is stable for stiff springs"),
    "turns bodies": ("integrator", "an integrator that turns bodies of any shape"),
    "round": ("interaction", "round floats"),
    "superposed": ("interaction", "forces that are superposed"),
    "moving walls": ("interaction", "forces that do not depend on where the walls were"),
    "at rest": ("dish", "a dish at rest"),
    "no noise": ("noise", "floats without Brownian motion"),
    "undulations": ("interaction", "forces that know contact lines which undulate"),
    "grid": ("interaction", "pair forces whose long-range part is smooth"),
    "pair sum": ("interaction", "forces that are a sum of the pair law over pairs of floats"),
    "no torques": ("interaction", "forces that do not turn floats"),
    "independent": ("resistance", "floats that drag slows one by one"),
    "lubricated": ("contacts", "contacts that stop floats at once"),
    "single drag": ("hydrodynamic interaction", "floats that turn without turning others"),
    "lone": ("hydrodynamic interaction", "floats that do not feel the flow of others"),
    "no spins": ("contacts", "contacts without friction"),
    "apart": ("contacts", "contacts that keep floats apart"),
    "full mobility": ("contacts", "contacts that are solved as impulses"),
    "stokes": ("drag", "a drag that is proportional to the velocity"),
    "drag": ("drag", "drag: hydrodynamics.drag = 'stokes' and a liquid.viscosity above zero"),
    "point charges": ("wall", "a wall that acts on each charge by itself"),
    "multipoles": ("wall", "a wall whose meniscus is that of the surface"),
    "open": ("boundary", "a dish or an infinite surface"),
    "bounded": ("boundary", "a dish or a periodic cell"),
    "outer walls": ("boundary", "walls that bend away from floats"),
}
"""For each capability, the slot of the option that has it, and a phrase for messages."""


def faults_of(chosen: Iterable[Option], tables: Mapping[str, Iterable[Option]]) -> list[Fault]:
    """A fault for every need of an option that the chosen option of the other slot does not meet; `tables` has the
    choices of each slot.
    """
    options = list(chosen)
    return [
        Fault(option.path, f"{option.name} needs {_lacking(capability, other, tables)}: {why}")
        for option in options
        for capability, why in option.needs.items()
        for other in options
        if other is not option and other.slot == CAPABILITIES[capability][0] and capability not in other.gives
    ]


def _lacking(capability: str, other: Option, tables: Mapping[str, Iterable[Option]]) -> str:
    slot, required = CAPABILITIES[capability]
    fit = ", ".join(option.name for option in tables.get(slot, ()) if capability in option.gives)
    return (
        f"{required}: got {other.path} = {other.name}; expected one of {fit}"
        if fit
        else f"{required}: got {other.name} ({other.path})"
    )


def scene_error(path: str, message: str) -> SceneError:
    """An error with one fault of a scene."""
    return SceneError([Fault(path, message)])


def require_compatible(chosen: Iterable[Option], tables: Mapping[str, Iterable[Option]]) -> None:
    """Raise SceneError if options cannot be combined."""
    if faults := faults_of(chosen, tables):
        raise SceneError(faults)
