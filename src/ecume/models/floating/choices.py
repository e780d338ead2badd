"""Which rows of the tables a scene chooses, and everything else of it that needs some capability of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from ecume.errors import Fault, SceneError
from ecume.models.floating.contact_models import CONTACTS, ContactModel
from ecume.models.floating.interactions import INTERACTIONS, RESISTANCES, Interaction, Resistance
from ecume.models.floating.kinds import moments_of
from ecume.models.floating.options import Option
from ecume.models.floating.pair_choice import NAMES, pair_option
from ecume.models.floating.parameters import DRAG_LAWS
from ecume.models.floating.schemes import INTEGRATORS, Integrator
from ecume.models.floating.walls.shapes import wall_law_of
from ecume.models.floating.walls.wall_laws import is_far_field
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import FloatingScene

TABLES: Mapping[str, Iterable[Option]] = {
    "pair law": [pair_option(name) for name in NAMES],
    "integrator": list(INTEGRATORS.values()),
}
"""Choices by name, for error messages."""


class Chosen(NamedTuple):
    """The rows that a scene chooses."""

    integrator: Integrator
    interactions: tuple[Interaction, ...]
    """the first is the base, the others add forces to it"""
    resistances: tuple[Resistance, ...]
    contacts: ContactModel
    """those that are asked for; floats with a shape have contacts of their own beside them"""
    asked_contacts: ContactModel
    may_take_grid: bool
    """whether a grid may be taken unasked"""

    @property
    def sums_menisci(self) -> bool:
        """Whether the base is the sum of a pair law."""
        return self.interactions[0] is INTERACTIONS["superposition"]


def chosen_by(scene: FloatingScene) -> Chosen:
    """The rows that a scene chooses."""
    integrator, method = INTEGRATORS[scene.integration.integrator], scene.interaction.method
    names = ["shapes"] if scene.shaped else []
    names += ["superposition"] if method == "pair-corrected" and not scene.shaped else []
    names += [] if method == "superposition" and scene.shaped else [method]
    names += ["grid"] if scene.interaction.summation == "grid" else []
    names += ["dipoles"] if np.any(moments_of(scene)) else []
    films = [RESISTANCES["films"]] if scene.hydrodynamics.lubrication is not None else []
    asked = CONTACTS[_contacts_of(scene)]
    plain = names == ["superposition"] and not films and asked is not CONTACTS["friction"]
    return Chosen(
        integrator=integrator,
        interactions=tuple(INTERACTIONS[name] for name in names),
        resistances=tuple(films),
        contacts=CONTACTS["outlines"] if scene.shaped else asked,
        asked_contacts=asked,
        # With forces on the way, four sums a step are still less work in compiled code.
        may_take_grid=plain and "kicks at the ends" in integrator.gives,
    )


def _contacts_of(scene: FloatingScene) -> str:
    """Which contacts a scene asks for. Raises SceneError for keys that exclude each other."""
    law, legacy = scene.contacts.law, scene.contacts.legacy_coefficient is not None
    if law != "spring-dashpot" and scene.contacts.stiffness is not None:
        raise _fault("contacts.stiffness", "means something only with contacts.law = 'spring-dashpot'")
    if scene.rubs and (law != "impulse" or legacy):
        key = "contacts.friction" if scene.contacts.friction > 0.0 else "dish.friction"
        raise _fault(
            key, "friction needs contacts that are solved as impulses, to which it adds those along the surfaces: "
            "contacts.law = 'impulse', without a legacy coefficient"
        )  # fmt: skip
    if law == "impulse":
        return "friction" if scene.rubs else "legacy" if legacy else "impulse"
    return law


def options_of(scene: FloatingScene, chosen: Chosen) -> list[Option]:
    """All options of a scene that can do something or need something."""
    hydrodynamics, law = scene.hydrodynamics, str(scene.interaction.law)
    rows = [chosen.integrator, *chosen.interactions, *chosen.resistances, chosen.asked_contacts]
    surroundings = [pair_option(law), _drag_of(scene), _wall_of(scene)]
    active = [
        (hydrodynamics.brownian, NOISE),
        (hydrodynamics.drag == DRAG_LAWS[1], FAST_DRAG),
        (scene.flow is not None, FLOW),
        (scene.dish is not None and scene.dish.motion is not None, SWAY),
        (bool(hydrodynamics.added_mass), ADDED_MASS),
        (any(one.disc is not None and one.disc.undulation > 0.0 for one in scene.given), UNDULATION),
        (_turned_by_menisci(scene), TURNING),
    ]
    return [*rows, *surroundings, *(option for there, option in active if there)]


NOISE = Option(
    slot="noise", path="hydrodynamics.brownian", name="Brownian motion",
    needs={
        "no inertia": "only there is the noise of a step a displacement of known variance",
        "drag": "noise and drag belong together",
        "round": "the noise of an elongated body differs along and across it",
        "independent": "floats that share films are moved by noise that is correlated",
    },
)  # fmt: skip
FAST_DRAG = Option(
    slot="drag law", path="hydrodynamics.drag", name="'schiller-naumann'",
    needs={
        "drag": "it moves floats by drag",
        "fast drag": "the drag of a kick follows from the speed at its beginning",
        "round": "the formula is that of spheres",
    },
)  # fmt: skip
FLOW = Option(
    slot="flow", path="flow", name="a flowing surface",
    needs={"drag": "it moves floats by drag", "round": "a current would turn an elongated body"},
)  # fmt: skip
SWAY = Option(
    slot="dish", path="dish.motion", name="a dish in motion",
    needs={
        "sways": "its acceleration is given by the kicks",
        "stokes": "its velocity acts by Stokes's drag",
        "round": "liquid that moves past an elongated body would turn it",
        "independent": "the liquid between two floats moves with the dish, too",
    },
)  # fmt: skip
ADDED_MASS = Option(
    slot="mass", path="hydrodynamics.added_mass", name="added mass", needs={"round": "it is known of spheres only"}
)
UNDULATION = Option(
    slot="particles", path="interaction.method", name="a disc with an undulation",
    needs={"undulations": "superposed charges have no direction"},
)  # fmt: skip
TURNING = Option(
    slot="particles", path="integration.integrator", name="a float that its meniscus turns",
    needs={
        "kicks spins": "its spin goes with the kicks of the velocities",
        "keeps inertia": "the law for its spin has a moment of inertia",
    },
)  # fmt: skip


def _turned_by_menisci(scene: FloatingScene) -> bool:
    undulated = any(one.disc is not None and one.disc.undulation > 0.0 for one in scene.given)
    return scene.interaction.method == "multipole" and undulated


def _drag_of(scene: FloatingScene) -> Option:
    """The drag of a scene, with its capabilities."""
    there = scene.hydrodynamics.resists and liquid_of(scene).viscosity > 0.0
    gives = {"drag"} if there else set()
    gives |= {"stokes"} if scene.hydrodynamics.drag != DRAG_LAWS[1] else set()
    return Option(
        slot="drag", path="hydrodynamics.drag", name=repr(scene.hydrodynamics.drag) if there else "no drag",
        gives=frozenset(gives),
        needs={},
    )  # fmt: skip


def _wall_of(scene: FloatingScene) -> Option:
    """The menisci at the walls, with their capabilities."""
    law = scene.dish.law if scene.dish is not None else None
    simple = is_far_field(wall_law_of(scene))
    gives = {"point charges"} if simple else set()
    gives |= {"multipoles"} if simple and law != "linear" else set()
    return Option(slot="wall", path="dish.law", name=repr(law), gives=frozenset(gives))


def _fault(path: str, message: str) -> SceneError:
    return SceneError([Fault(path, message)])
