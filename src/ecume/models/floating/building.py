"""From a scene to parameters: names of laws, then floats, walls, pair law and time step, put together."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ecume.engine.walls import wall_count
from ecume.errors import BadInput, Fault, SceneError
from ecume.laws import capillarity, flotation, images
from ecume.laws.contact import legacy_restitution
from ecume.laws.pair_laws import PAIR_LAWS, Setting
from ecume.models.floating.choices import TABLES, Chosen, chosen_by, options_of
from ecume.models.floating.drifting import drift_of
from ecume.models.floating.forces import Superposed
from ecume.models.floating.interactions import BY_CONSTANTS, INTERACTIONS
from ecume.models.floating.kinds import floats_of
from ecume.models.floating.options import Built, require_compatible
from ecume.models.floating.pair_choice import NAMES, law_in_precision, row_of
from ecume.models.floating.parameters import DRAG_LAWS, Parameters, Parts, pack_pair
from ecume.models.floating.schemes import SCHEMES
from ecume.models.floating.shaped.bodies import RigidKicks
from ecume.models.floating.stepping import EveryRow
from ecume.models.floating.summing import DEEPEST_TOUCH, cut_off, split_of
from ecume.models.floating.time_steps import good_step, kick_of, step_of
from ecume.models.floating.walls.shapes import wall_law_of, wall_strengths, wall_table_of, walls_of
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import FloatingScene
from ecume.units import Array

SLOP = 1e-4
"""Overlaps up to this part of the smallest radius are left alone."""


def parameters_of(scene: FloatingScene) -> Parameters:
    """Everything a run needs and never changes. Raises SceneError."""
    _check_names(scene)
    chosen = chosen_by(scene)
    require_compatible(options_of(scene, chosen), TABLES)
    parameters, asked = _parameters_with(scene, chosen, 1.0), scene.integration.time_step
    longer = 1.0 if asked is None else asked / good_step(parameters, scene)
    # Who goes farther in a step than usual needs lists that reach as much farther.
    return parameters if longer <= 1.0 else _parameters_with(scene, chosen, longer)


def _parameters_with(scene: FloatingScene, chosen: Chosen, longer: float) -> Parameters:
    """The same, with lists for steps that many times as long as the usual ones."""
    plain = _without_parts(scene, chosen, longer)
    eligible = chosen.may_take_grid and row_of(plain).menisci
    split = split_of(plain, scene, eligible=eligible) if chosen.sums_menisci else None
    if split is not None:
        plain = cut_off(plain, split[1])
    built = [row.make(plain, scene) for row in chosen.interactions if row is not INTERACTIONS["grid"]]
    if split is not None:
        short = Superposed(law_in_precision(plain, split[0].short))
        built = [Built(short), Built(split[0]), *built[1:]]
    parts = tuple(each.part for each in built)
    slowing = [row.make(plain, scene) for row in chosen.resistances]
    touching = chosen.contacts.make(plain, scene, parts)
    every = [*built, *slowing, touching]
    limited = plain._replace(
        quickest=min(plain.quickest, *(each.quickest for each in every)),
        stiffer=max(each.stiffer for each in every),
        reach=max(plain.reach, *(each.reach + plain.skin for each in every)),
    )
    timed = limited._replace(**step_of(limited, scene)._asdict())
    turned = next((found for row, each in zip(chosen.interactions, built, strict=False)
                   if (found := inertia_by(each.part)) is not None), None)  # fmt: skip
    contacts = chosen.contacts.at_step(touching.part, timed, turned)
    integrator = chosen.integrator.constants()
    if scene.shaped:
        integrator = RigidKicks(parts[0].inertia, parts[0].friction)
    return timed._replace(parts=Parts(integrator, parts, tuple(each.part for each in slowing), contacts, EveryRow()))


def inertia_by(part: Any) -> Array | None:
    """Of floats that an interaction turns."""
    return BY_CONSTANTS[type(part)].inertia(part)


def _without_parts(scene: FloatingScene, chosen: Chosen, longer: float) -> Parameters:
    """All that does not depend on the choice of parts."""
    drift = drift_of(scene)
    floats, liquid = floats_of(scene), liquid_of(scene)
    length, row = liquid.capillary_length, PAIR_LAWS[str(scene.interaction.law)]
    cutoff = capillarity.truncation_radius(scene.interaction.accuracy) * length
    smallest, largest = float(floats.radius.min()), float(floats.radius.max())
    setting = Setting(length, liquid.surface_tension, 2.0 * DEEPEST_TOUCH * smallest, cutoff + largest)
    try:
        law = row.make_constants(setting)
    except BadInput as error:
        raise _fault("particles", str(error)) from None
    strength = law.strength if row.menisci else 0.0
    mirrored = scene.dish is not None and scene.dish.image != "none"
    walls, scheme = walls_of(scene.dish), chosen.integrator.scheme
    skin = longer * max(0.2 * largest, min(0.4 * length, largest))
    swings = drift.sway.turning if np.any(drift.sway.amplitude) else 0.0
    return Parameters(
        time_step=0.0,
        steps_per_frame=1,
        scheme=scheme,
        floats=floats,
        kick=kick_of(scheme, 1.0, floats, wall_count(walls)),
        pair_law=NAMES.index(str(scene.interaction.law)),
        pair=pack_pair(strength, length, cutoff, liquid.surface_tension, law),
        cutoff=cutoff,
        skin=skin,
        reach=max(cutoff, 2.0 * largest) + skin,
        walls=walls,
        wall_law=wall_law_of(scene),
        wall_strength=wall_strengths(scene, floats),
        wall_table=wall_table_of(scene, smallest),
        image_strength=capillarity.pair_strength(liquid.surface_tension, 1.0, 1.0) if mirrored else 0.0,
        restitution=_restitution(scene),
        wall_restitution=scene.dish.restitution if scene.dish is not None else 0.0,
        slop=SLOP * smallest,
        drift=drift,
        quickest=1.0 / swings if swings > 0.0 else math.inf,
        single=scene.interaction.precision == "single",
    )


def _restitution(scene: FloatingScene) -> float:
    coefficient = scene.contacts.legacy_coefficient
    return scene.contacts.restitution if coefficient is None else legacy_restitution(coefficient)


def _check_names(scene: FloatingScene) -> None:
    """The names of laws, against the laws' tables."""
    choices = [
        ("integration.integrator", scene.integration.integrator, SCHEMES),
        ("hydrodynamics.drag", str(scene.hydrodynamics.drag), (*DRAG_LAWS, "none")),
        ("contacts.law", scene.contacts.law, ("impulse", "spring-dashpot", "none")),
        ("interaction.law", str(scene.interaction.law), NAMES),
        ("interaction.charge", str(scene.interaction.charge), tuple(flotation.CHARGES)),
        ("interaction.method", scene.interaction.method, ("superposition", "pair-corrected", "multipole")),
        ("interaction.summation", scene.interaction.summation, ("auto", "cells", "grid")),
        ("interaction.precision", scene.interaction.precision, ("double", "single")),
    ]
    if scene.dish is not None:
        choices.append(("dish.law", str(scene.dish.law), (*capillarity.WALLS, "profile")))
        choices.append(("dish.image", scene.dish.image, ("none", *images.WALLS)))
    faults = [
        Fault(path, f"no such law as {name!r}; {_suggestion(name, known)}")
        for path, name, known in choices
        if name not in known
    ]
    if faults:
        raise SceneError(faults)


def _suggestion(name: str, known: tuple[str, ...]) -> str:
    import difflib

    close = difflib.get_close_matches(name, known, 1)
    return f"did you mean {close[0]!r}?" if close else "there are " + ", ".join(repr(each) for each in known)


def _fault(path: str, message: str) -> SceneError:
    return SceneError([Fault(path, message)])
