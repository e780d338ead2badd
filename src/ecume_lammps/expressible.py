"""Features that a deck for LAMMPS can contain: one record for each choice of a floating scene.

A scene is refused if one of its choices is not accepted; one error contains all reasons.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from ecume.errors import Fault, SceneError
from ecume.laws.pair_laws import PAIR_LAWS
from ecume.models.floating.dishes import name_of
from ecume.models.floating.setup.kinds import distinct_kinds, moments_of

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene

MOST_KINDS = 32
"""The largest number of kinds of floats in a deck: each pair of them has a table."""

MOST_GROUPS = 31
"""The largest number of groups of LAMMPS beside `all`."""

LEAST_RESTITUTION = math.ceil(1e3 * math.exp(-2.0)) * 1e-3
"""The least restitution of contacts in LAMMPS, which are damped below the critical damping; at critical damping the
restitution is exp(-2).
"""

UNEQUAL = tuple(name for name, law in PAIR_LAWS.items() if not law.reciprocal)


def shape_of(scene: FloatingScene) -> str:
    """The shape of the dish; "none" without one."""
    return "none" if scene.dish is None else name_of(scene.dish)


class Expressible(NamedTuple):
    """One choice of a scene, the values that a deck can express, and the reason why others are refused."""

    path: str
    """the key of the scene"""
    got: Callable[[Any], Any]
    """the value of the scene"""
    accepts: Callable[[Any], bool]
    """whether a deck can express this value"""
    expected: str
    reason: str
    external: bool = False
    """whether LAMMPS can call ecume's forces instead, through `fix external`"""


def _names(*names: str) -> Callable[[Any], bool]:
    return lambda got: got in names


def _zero(got: Any) -> bool:
    return bool(got == 0)


NONE = _names("none")


def _whether(there: bool, name: str) -> str:
    """The given name if an optional choice exists, otherwise "none"."""
    return name if there else "none"


def _optional(path: str, name: str) -> Callable[[FloatingScene], str]:
    """The name of an optional part of a scene, given by its key."""

    def got(scene: FloatingScene) -> str:
        part: Any = scene
        for key in path.split("."):
            part = None if part is None else getattr(part, key)
        return _whether(part is not None, name)

    return got


def _of_dish(key: str, default: Any) -> Callable[[FloatingScene], Any]:
    """The value of a key of the dish; the default without a dish."""
    return lambda scene: default if scene.dish is None else getattr(scene.dish, key)


def _rotation(scene: FloatingScene) -> str:
    """The reason why rotation cannot be expressed: a moment of inertia other than that of a sphere."""
    other = bool(scene.hydrodynamics.added_mass) or any(one.disc is not None for one in scene.given)
    return _whether(scene.rubs and other, "friction of discs or with added mass")


def _overdamped_kinds(scene: FloatingScene) -> int:
    """The number of kinds of floats without inertia, each of which has another friction."""
    return len(distinct_kinds(scene)[0]) if scene.integration.integrator == "overdamped" else 0


def _noise_with_inertia(scene: FloatingScene) -> str:
    """The kind of noise that a deck lacks, or "none"."""
    slow = scene.integration.integrator == "overdamped"
    return _whether(scene.hydrodynamics.brownian and not slow, "noise with inertia")


def _bounces(scene: FloatingScene) -> float:
    """The restitution of contacts between floats; 1 without contacts."""
    return 1.0 if scene.contacts.law == "none" else scene.contacts.restitution


def _above_critical(restitution: Any) -> bool:
    return bool(restitution >= LEAST_RESTITUTION)


FLOATS = (
    Expressible("interaction.law", lambda scene: str(scene.interaction.law), lambda law: law not in UNEQUAL,
                "a law with equal and opposite forces", "tables of LAMMPS act on both floats alike"),
    Expressible("interaction.method", lambda scene: scene.interaction.method, _names("superposition"),
                "superposition", "tables of LAMMPS know pairs only"),
    Expressible("particles.shape", lambda scene: sum(one.shape is not None for one in scene.given), _zero,
                "none with a shape", "atoms of the deck are spheres"),
    Expressible("particles.magnetic_moment", lambda scene: int((moments_of(scene) != 0.0).sum()), _zero,
                "none with a magnetic moment", "the tables hold the capillary law alone"),
    Expressible("particles", lambda scene: len(distinct_kinds(scene)[0]), lambda count: count <= MOST_KINDS,
                f"at most {MOST_KINDS} kinds of floats", "each pair of kinds has its own table", external=True),
    Expressible("integration.integrator", _overdamped_kinds, lambda count: count <= MOST_GROUPS,
                f"at most {MOST_GROUPS} kinds of overdamped floats", "each kind has a group, and LAMMPS has no more"),
    Expressible("user_laws", lambda scene: len(scene.user_laws), _zero,
                "none", "its function is not part of the scene"),
    Expressible("hydrodynamics.drag", lambda scene: scene.drag, _names("stokes", "none"),
                "stokes or none", "fix viscous is proportional to the velocity"),
    Expressible("hydrodynamics.lubrication", _optional("hydrodynamics.lubrication", "films"), NONE,
                "none", "the films of LAMMPS are those of spheres deep in a liquid"),
    Expressible("hydrodynamics.interaction", lambda scene: scene.hydrodynamics.interaction, NONE,
                "none", "the drag of each atom is its own"),
    Expressible("hydrodynamics.brownian", _noise_with_inertia, NONE,
                "the integrator overdamped", "the deck has noise of overdamped motion only"),
    Expressible("magnetic_field", _optional("magnetic_field", "a field"), NONE,
                "none", "the tables hold the capillary law alone"),
    Expressible("surfactant", _optional("surfactant", "a surfactant"), NONE,
                "none", "LAMMPS has no concentration at the surface"),
    Expressible("waves", _optional("waves", "waves"), NONE, "none", "LAMMPS has no such forces"),
    Expressible("activity", _optional("activity", "active forces"), NONE,
                "none", "LAMMPS has no such forces with persistence"),
    Expressible("flow.nodes", _optional("flow.nodes", "a table"), NONE,
                "a uniform or linear flow", "a formula of LAMMPS has no table over two coordinates", external=True),
    Expressible("flow.field", _optional("flow.field", "a file"), NONE,
                "a uniform or linear flow", "a formula of LAMMPS has no table over two coordinates", external=True),
    Expressible("dish.law", _of_dish("law", "none"), _names("meniscus", "linear", "none"),
                "meniscus, linear or none", "the deck contains formulas of far fields only", external=True),
    Expressible("dish.image", _of_dish("image", "none"), NONE,
                "none", "the deck contains formulas of far fields only", external=True),
    Expressible("dish.shape", shape_of, _names("none", "round", "rectangle"),
                "round or rectangle", "other walls have no region in the deck"),
    Expressible("dish.motion", _optional("dish.motion", "a moving dish"), NONE,
                "a dish at rest", "the deck describes the frame of the dish without inertial forces"),
    Expressible("dish.tilt", _optional("dish.tilt", "a tilted dish"), NONE,
                "an upright dish", "the deck has vertical walls, whose menisci are equal all around"),
    Expressible("dish.barrier", _optional("dish.barrier", "a barrier"), NONE,
                "sides at rest", "the deck does not record the force on a wall"),
    Expressible("contacts.legacy_coefficient", lambda scene: scene.contacts.legacy_coefficient, lambda got: got is None,
                "none, and a restitution", "springs separate floats; these contacts let them sink into one another"),
    Expressible("contacts.restitution", _bounces, _above_critical, f"{LEAST_RESTITUTION:g} or more",
                "the dashpots of LAMMPS's granular contacts stay below critical damping"),
    Expressible("dish.restitution", _of_dish("restitution", 1.0), _above_critical, f"{LEAST_RESTITUTION:g} or more",
                "the dashpots of LAMMPS's granular contacts stay below critical damping"),
    Expressible("contacts.friction", _rotation, NONE, "friction of spheres without added mass",
                "rotation in LAMMPS has the moment of inertia of a homogeneous sphere"),
    Expressible("contacts.rolling_friction", lambda scene: _whether(scene.rolls, "rolling friction"), NONE, "none",
                "rolling friction in LAMMPS is a spring and a dashpot, whose constants the scene lacks"),
)  # fmt: skip
"""All choices of a scene that LAMMPS may lack."""


def faults_of(scene: Any, rows: Sequence[Expressible] = FLOATS) -> list[Fault]:
    """A fault for each choice of the scene that a deck cannot express."""
    checked = [(row, row.got(scene)) for row in rows]
    return [
        Fault(row.path, f"got {got}, which a deck for LAMMPS cannot express; expected {row.expected}: {row.reason}")
        for row, got in checked
        if not row.accepts(got)
    ]


def require_expressible(scene: Any, rows: Sequence[Expressible] = FLOATS) -> None:
    """Raise SceneError with everything that a deck cannot express."""
    if faults := faults_of(scene, rows):
        raise SceneError(faults)


def calls_us(scene: FloatingScene) -> bool:
    """Whether LAMMPS has to call the forces of ecume, and can do so: for floats with inertia and without contact
    friction.
    """
    missing = {fault.path for fault in faults_of(scene)}
    lifted = {row.path for row in FLOATS if row.external}
    inertia = scene.integration.integrator != "overdamped"
    return bool(missing) and missing <= lifted and inertia and not scene.rubs


def require_simulable(scene: FloatingScene) -> None:
    """Raise SceneError with everything that runs in LAMMPS cannot express."""
    if not calls_us(scene):
        require_expressible(scene)
