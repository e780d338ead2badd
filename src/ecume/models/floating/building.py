"""From a scene to parameters: names of laws, then floats, walls, pair law and time step, put together."""

from __future__ import annotations

import math

import numpy as np

from ecume.engine.walls import wall_count
from ecume.errors import BadInput, Fault, SceneError
from ecume.laws import capillarity, flotation, images
from ecume.laws.contact import legacy_restitution
from ecume.laws.pair_laws import PAIR_LAWS, Setting
from ecume.models.floating.drifting import drift_of
from ecume.models.floating.kinds import distinct_kinds, floats_of, moments_of
from ecume.models.floating.pair_choice import NAMES, require
from ecume.models.floating.parameters import (
    CONTACT_LAWS,
    DRAG_LAWS,
    LEGACY,
    SCHEMES,
    SPRINGS,
    Parameters,
    pack_pair,
)
from ecume.models.floating.summing import DEEPEST_TOUCH, summed
from ecume.models.floating.time_steps import good_step, kick_of, with_step
from ecume.models.floating.walls.shapes import wall_law_of, wall_strengths, wall_table_of, walls_of
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import FloatingScene

SLOP = 1e-4
"""Overlaps up to this part of the smallest radius are left alone."""


def parameters_of(scene: FloatingScene) -> Parameters:
    """Everything a run needs and never changes. Raises SceneError."""
    _check_names(scene)
    parameters, asked = _parameters_with(scene, 1.0), scene.motion.time_step
    longer = 1.0 if asked is None else asked / good_step(parameters, scene)
    # Who goes farther in a step than usual needs lists that reach as much farther.
    return parameters if longer <= 1.0 else _parameters_with(scene, longer)


def _parameters_with(scene: FloatingScene, longer: float) -> Parameters:
    """The same, with lists for steps that many times as long as the usual ones."""
    drift = drift_of(scene)
    floats, liquid = floats_of(scene), liquid_of(scene)
    length, row = liquid.capillary_length, PAIR_LAWS[str(scene.interaction.law)]
    cutoff = capillarity.truncation_radius(scene.interaction.accuracy) * length
    smallest, largest = float(floats.radius.min()), float(floats.radius.max())
    setting = Setting(length, liquid.surface_tension, 2.0 * DEEPEST_TOUCH * smallest, cutoff + largest)
    try:
        law = row.make_constants(setting)
    except BadInput as error:
        raise _fault("floats", str(error)) from None
    strength = law.strength if row.menisci else 0.0
    mirrored = scene.dish is not None and scene.dish.image != "none"
    walls, scheme = walls_of(scene.dish), SCHEMES.index(scene.motion.integrator)
    skin = longer * max(0.2 * largest, min(0.4 * length, largest))
    swings = drift.sway.turning if np.any(drift.sway.amplitude) else 0.0
    parameters = Parameters(
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
        contact_law=_contact_law(scene),
        restitution=_restitution(scene),
        wall_restitution=scene.dish.restitution if scene.dish is not None else 0.0,
        slop=SLOP * smallest,
        drift=drift,
        quickest=1.0 / swings if swings > 0.0 else math.inf,
        single=scene.interaction.precision == "single",
    )
    together = _with_springs(summed(with_method(parameters, scene), scene), scene)
    return _with_friction(with_step(together, scene), scene)


def with_method(parameters: Parameters, scene: FloatingScene) -> Parameters:
    """What goes beyond superposition, where the scene asks for it."""
    if scene.interaction.method != "multipole" and any(one.disc and one.disc.undulation for one in scene.given):
        raise _fault("interaction.method", "discs with an undulation need 'multipole'")
    moment = moments_of(scene)
    if scene.shaped:
        if np.any(moment):
            raise _fault("floats", "magnets do not go with floats that have a shape")
        if scene.motion.films is not None:
            raise _fault("motion.films", "films do not go with floats that have a shape")
        # Imported when asked for, as are the methods below: their loops are compiled on import.
        from ecume.models.floating.shaped.building import with_shapes

        return with_shapes(parameters, scene, *distinct_kinds(scene))
    if np.any(moment) and scene.motion.films is None:
        # Imported when asked for: its loops are compiled on import.
        from ecume.models.floating.interacting import with_dipoles

        return with_dipoles(parameters, scene, moment)
    if scene.motion.films is not None:
        if np.any(moment):
            raise _fault("motion.films", "films do not go with magnets")
        from ecume.models.floating.interacting import with_films

        return with_films(parameters, scene)
    if scene.interaction.method == "superposition":
        return parameters
    from ecume.models.floating.interacting import METHODS

    require(parameters, "interaction.method", repr(scene.interaction.method), "menisci")
    kinds, numbers = distinct_kinds(scene)
    return METHODS[scene.interaction.method](parameters, scene, kinds, numbers)


def _with_springs(parameters: Parameters, scene: FloatingScene) -> Parameters:
    """What soft contacts need beside all else."""
    if parameters.contact_law != SPRINGS:
        if scene.contacts.stiffness is not None:
            raise _fault("contacts.stiffness", "means something only with contacts.law = 'spring-dashpot'")
        return parameters
    # Imported when asked for: its march is compiled for those who want soft contacts only.
    from ecume.models.floating.springs import with_springs

    return with_springs(parameters, scene)


def _with_friction(parameters: Parameters, scene: FloatingScene) -> Parameters:
    """What surfaces that rub need beside all else."""
    if not scene.rubs:
        return parameters
    # Imported when asked for: its march is compiled for those who rub only.
    from ecume.models.floating.roughness import with_friction

    return with_friction(parameters, scene)


def _contact_law(scene: FloatingScene) -> int:
    if scene.contacts.law == "impulse" and scene.contacts.legacy_coefficient is not None:
        return LEGACY
    return CONTACT_LAWS.index(scene.contacts.law)


def _restitution(scene: FloatingScene) -> float:
    coefficient = scene.contacts.legacy_coefficient
    return scene.contacts.restitution if coefficient is None else legacy_restitution(coefficient)


def _check_names(scene: FloatingScene) -> None:
    """The names of laws, against the laws' tables."""
    choices = [
        ("motion.integrator", scene.motion.integrator, SCHEMES),
        ("motion.drag_law", scene.motion.drag_law, DRAG_LAWS),
        ("contacts.law", scene.contacts.law, ("impulse", "spring-dashpot", "none")),
        ("interaction.law", str(scene.interaction.law), NAMES),
        ("interaction.charge", str(scene.interaction.charge), tuple(flotation.CHARGES)),
        ("interaction.method", scene.interaction.method, ("superposition", "pair-corrected", "multipole")),
        ("interaction.sum", scene.interaction.sum, ("auto", "cells", "grid")),
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
