"""Parameters from a scene: names of laws, selected rows of tables, their compatibility, and memory."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ecume.engine.walls import rings, wall_count
from ecume.errors import Fault, SceneError
from ecume.laws import capillarity, flotation, meniscus
from ecume.laws.friction import legacy_restitution
from ecume.laws.pair_laws import PAIR_LAWS, PairLaw, Setting
from ecume.models.costs import require_memory, within_steps
from ecume.models.floating.contacts.contact_models import CONTACTS, ContactModel
from ecume.models.floating.dishes import (
    echoes_known,
    is_far_field,
    wall_law_of,
    wall_strengths,
    wall_table_of,
    walls_of,
)
from ecume.models.floating.forces.ewald_grid import DEEPEST_TOUCH, cut_off, split_of
from ecume.models.floating.forces.flow_and_noise import drift_of, shortest_change
from ecume.models.floating.forces.interactions import (
    BY_CONSTANTS,
    INTERACTIONS,
    METHODS,
    Interaction,
    Resistance,
    interactions_of,
)
from ecume.models.floating.forces.pair_forces import (
    NAMES,
    Superposed,
    constants_of,
    law_in_precision,
    pair_option,
    require_finite_forces,
    row_of,
    warn_of_long_range,
)
from ecume.models.floating.options import Built, Option, require_compatible, scene_error
from ecume.models.floating.parameters import DRAG_LAWS, Parameters, Parts, pack_pair
from ecume.models.floating.setup.hydrodynamic_interaction import (
    HYDRODYNAMICS,
    HydrodynamicInteraction,
    hydrodynamics_of,
    warn_of_dense_gas,
    warn_of_fast_floats,
)
from ecume.models.floating.setup.initial_state import boundary_of, periods_in, require_room
from ecume.models.floating.setup.kinds import distinct_kinds, floats_of, moments_of
from ecume.models.floating.setup.places import given_places, region_of
from ecume.models.floating.shaped.bodies import RigidKicks
from ecume.models.floating.shaped.shapes import covered_by_outline
from ecume.models.floating.time_integration.integrators import (
    INTEGRATORS,
    INTEGRATORS_BY_CONSTANTS,
    SCHEMES,
    Integrator,
    kicks_of,
)
from ecume.models.floating.time_integration.step_size import GOOD, NOISE_DEVIATIONS, good_step, kick_of, step_of
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import FloatingScene
from ecume.units import Array

SKIN_OVER_NOISE = 5.0 * NOISE_DEVIATIONS * GOOD
"""The skin of neighbor lists with thermal noise, over the largest radius: a float moves at most a fifth of it in one of
the longest steps by noise.
"""

SLOP = 1e-4
"""Tolerated overlap, over the smallest radius."""


def parameters_of(scene: FloatingScene, further: tuple[Interaction, ...] = ()) -> Parameters:
    """Return the parameters of a scene, with further interactions. Raises SceneError."""
    _check_names(scene)
    chosen = chosen_by(scene)
    if further:
        chosen = chosen._replace(interactions=(*chosen.interactions, *further), grid_allowed=False)
    require_compatible(options_of(scene, chosen), TABLES)
    _require_elastic(scene, chosen)
    parameters, requested = _parameters_with(scene, chosen, 1.0), scene.integration.time_step
    longer = 1.0 if requested is None else requested / good_step(parameters, scene)
    # Floats that move farther in a step require lists with a longer range.
    warn_of_fast_floats(chosen.hydrodynamics, parameters, scene)
    warn_of_long_range(parameters, scene)
    warn_of_dense_gas(scene)
    return parameters if longer <= 1.0 else _parameters_with(scene, chosen, longer)


def _parameters_with(scene: FloatingScene, chosen: Chosen, longer: float) -> Parameters:
    """Return parameters with neighbor lists for time steps that are `longer` times the default."""
    plain = _without_parts(scene, chosen, longer)
    require_finite_forces(plain, scene)
    eligible = chosen.grid_allowed and row_of(plain).menisci and scene.cell is None
    split = (
        split_of(plain, scene.interaction, lambda: initial_area(plain, scene), eligible=eligible)
        if chosen.sums_menisci
        else None
    )
    if split is not None:
        plain = cut_off(plain, split[1])
    _require_memory(len(plain.floats.mass), _memory_of_lists(plain))  # test before the parts allocate large arrays
    built = [row.make(plain, scene) for row in chosen.interactions if row is not INTERACTIONS["grid"]]
    if split is not None:
        short = Superposed(law_in_precision(plain, split[0].short))
        built = [Built(short), Built(split[0]), *built[1:]]
    parts = tuple(each.part for each in built)
    slowing = [row.make(plain, scene) for row in chosen.resistances]
    touching = chosen.contacts.make(plain, scene, parts)
    every = [*built, *slowing, touching]
    require_room(plain, scene, zip((*chosen.interactions, *chosen.resistances), (*built, *slowing), strict=False))
    limited = plain._replace(
        shortest_time=min(plain.shortest_time, *(each.shortest_time for each in every)),
        stiffness_factor=max(each.stiffness_factor for each in every),
        reach=max(plain.reach, *(each.reach + plain.skin for each in every)),
    )
    timed = limited._replace(**step_of(limited, scene)._asdict())
    _require_stable_drag(chosen.integrator, timed)
    turned = next((found for row, each in zip(chosen.interactions, built, strict=False)
                   if (found := inertia_by(each.part)) is not None), None)  # fmt: skip
    contacts = chosen.contacts.at_step(
        touching.part, timed, turned, any(row.moved_walls is not None for row in chosen.interactions)
    )
    spinning = turned is not None or chosen.contacts.inertia(contacts) is not None
    integrator = chosen.hydrodynamics.make(timed, scene, spinning) or kicks_of(chosen.integrator, timed)
    if scene.shaped:
        integrator = RigidKicks(parts[0].inertia, parts[0].friction, parts[0].elongation)
    return timed._replace(parts=Parts(integrator, parts, tuple(each.part for each in slowing), contacts))


def _require_elastic(scene: FloatingScene, chosen: Chosen) -> None:
    """Raise SceneError if collisions would cool floats with inertia and thermal noise below the temperature."""
    if not scene.hydrodynamics.brownian or not chosen.integrator.scheme.inertia:
        return
    key = "restitution" if scene.contacts.legacy_coefficient is None else "legacy_coefficient"
    given = [(f"contacts.{key}", _restitution(scene))] if scene.contacts.law != "none" else []
    given += [("dish.restitution", scene.dish.restitution)] if scene.dish is not None else []
    faults = [
        Fault(path, f"got a restitution of {got:g}; expected 1 for hydrodynamics.brownian with inertia: "
              "collisions that lose energy cool floats below liquid.temperature. "
              "With integration.integrator = 'overdamped' they do not rebound")
        for path, got in given if got < 1.0
    ]  # fmt: skip
    if faults:
        raise SceneError(faults)


def initial_area(parameters: Parameters, scene: FloatingScene) -> float:
    """The area (m^2) that the floats cover at the start."""
    region = region_of(parameters)
    area = (region.high[0] - region.low[0]) * (region.high[1] - region.low[1])
    area = min(area, rings.area(parameters.walls))
    places = given_places(scene).position
    if np.isnan(places).any():
        return area
    spans = np.ptp(places, axis=0) + 2.0 * float(parameters.floats.radius.max())
    return float(np.prod(spans))


def _require_stable_drag(integrator: Integrator, parameters: Parameters) -> None:
    """Raise SceneError if the integrator is unstable with the drag of the lightest float."""
    longest = integrator.drag_limit * float(parameters.floats.relaxation_time.min())
    if parameters.time_step > longest:
        raise scene_error(
            "integration.integrator", f"{integrator.name} needs a time step below {longest:.3g} s in so viscous a "
            f"liquid; it is {parameters.time_step:.3g} s. Set integration.time_step, or use 'velocity-verlet'"
        )  # fmt: skip


def inertia_by(part: Any) -> Array | None:
    """The inertia of floats that an interaction turns, or None."""
    return BY_CONSTANTS[type(part)].inertia(part)


def _without_parts(scene: FloatingScene, chosen: Chosen, longer: float) -> Parameters:
    """Return parameters without parts."""
    drift = drift_of(scene)
    floats, liquid = floats_of(scene), liquid_of(scene)
    length, row = liquid.capillary_length, PAIR_LAWS[str(scene.interaction.law)]
    smallest, largest = float(floats.radius.min()), float(floats.radius.max())
    cutoff = _reach_of_pairs(scene, row, length, largest)
    setting = Setting(length, liquid.surface_tension, 2.0 * DEEPEST_TOUCH * smallest, cutoff + largest)
    law = constants_of(scene, setting)
    strength = law.strength if row.menisci else 0.0
    mirrored = scene.dish is not None and scene.dish.image != "none"
    walls, scheme = walls_of(scene.dish), chosen.hydrodynamics.moves(chosen.integrator).scheme
    brownian = drift.thermal > 0.0
    apart = scene.shaped or (brownian and scheme.inertia)
    scheme = scheme._replace(drags_along=scheme.drags_along and not apart)
    noisy = SKIN_OVER_NOISE * largest if brownian and not scheme.inertia else 0.0
    skin = longer * max(0.2 * largest, min(0.4 * length, largest), noisy)
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
        reach=cutoff + skin,
        walls=walls,
        wall_law=wall_law_of(scene),
        wall_strength=wall_strengths(scene, floats),
        wall_table=wall_table_of(scene, (min([smallest, *_covers(scene)]), largest)),
        image_strength=capillarity.pair_strength(liquid.surface_tension, 1.0, 1.0) if mirrored else 0.0,
        restitution=_restitution(scene),
        wall_restitution=scene.dish.restitution if scene.dish is not None else 0.0,
        slop=SLOP * smallest,
        drift=drift,
        shortest_time=min(1.0 / swings if swings > 0.0 else math.inf, shortest_change(drift)),
        raft_mobility=chosen.hydrodynamics.raft_mobility(len(floats.mass)),
        single=scene.interaction.precision == "single",
        periods=periods_in(scene),
        passing=scene.contacts.law == "none",
    )


def _covers(scene: FloatingScene) -> list[float]:
    """The smallest distances of charges inside floats with a shape from walls (m): below the radius of such a float."""
    figures = [kind.figure for kind in distinct_kinds(scene)[0]] if scene.shaped else []
    return [covered_by_outline(figure) for figure in figures if figure is not None]


def _reach_of_pairs(scene: FloatingScene, row: PairLaw, length: float, largest: float) -> float:
    """The distance (m) up to which floats act on each other; without forces, that of a contact."""
    if not row.has_force and scene.interaction.method == "superposition":
        return 2.0 * largest
    return capillarity.truncation_radius(scene.interaction.accuracy, 2.0 * largest / length) * length


def _restitution(scene: FloatingScene) -> float:
    coefficient = scene.contacts.legacy_coefficient
    return scene.contacts.restitution if coefficient is None else legacy_restitution(coefficient)


def _check_names(scene: FloatingScene) -> None:
    """Raise SceneError for names of laws that are not in the tables."""
    choices = [
        ("integration.integrator", scene.integration.integrator, SCHEMES),
        ("hydrodynamics.drag", scene.drag, (*DRAG_LAWS, "none")),
        ("hydrodynamics.interaction", scene.hydrodynamics.interaction, tuple(HYDRODYNAMICS)),
        ("contacts.law", scene.contacts.law, ("impulse", "spring-dashpot", "none")),
        ("interaction.law", str(scene.interaction.law), NAMES),
        ("interaction.charge", str(scene.interaction.charge), tuple(flotation.CHARGES)),
        ("interaction.method", scene.interaction.method, METHODS),
        ("interaction.summation", scene.interaction.summation, ("auto", "cells", "grid")),
        ("interaction.precision", scene.interaction.precision, ("double", "single")),
    ]
    if scene.dish is not None:
        choices.append(("dish.law", str(scene.dish.law), (*capillarity.WALLS, "profile")))
        choices.append(("dish.image", scene.dish.image, ("none", *meniscus.WALLS)))
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


TABLES: Mapping[str, Iterable[Option]] = {
    "pair law": [pair_option(name) for name in NAMES],
    "integrator": list(INTEGRATORS.values()),
}
"""Choices by name, for error messages."""


class Chosen(NamedTuple):
    """The rows of the tables that a scene chooses."""

    integrator: Integrator
    interactions: tuple[Interaction, ...]
    """the first is the base, the others add forces to it"""
    resistances: tuple[Resistance, ...]
    contacts: ContactModel
    """the contacts in the scene; floats with a shape have other contacts"""
    requested_contacts: ContactModel
    hydrodynamics: HydrodynamicInteraction
    grid_allowed: bool
    """whether a grid can be chosen automatically"""

    @property
    def sums_menisci(self) -> bool:
        """Whether the forces between floats are the sum of a pair law."""
        return self.interactions[0] is INTERACTIONS["superposition"]


def chosen_by(scene: FloatingScene) -> Chosen:
    """The rows that a scene chooses."""
    integrator, method = INTEGRATORS[scene.integration.integrator], scene.interaction.method
    names = ["shapes"] if scene.shaped else []
    names += ["superposition"] if INTERACTIONS[method].adds_to_pairs and not scene.shaped else []
    names += [] if method == "superposition" and scene.shaped else [method]
    names += ["grid"] if scene.interaction.summation == "grid" else []
    field = scene.magnetic_field is not None
    names += ["magnetic field"] if field else ["dipoles"] if np.any(moments_of(scene)) else []
    names += ["activity"] if scene.activity is not None else []
    names += ["waves"] if scene.waves is not None else []
    names += ["surfactant"] if scene.surfactant is not None else []
    names += ["barrier"] if scene.dish is not None and scene.dish.barrier is not None else []
    hydrodynamics, touching = hydrodynamics_of(scene), _contacts_of(scene)
    films = [hydrodynamics.resistance("films")] if scene.hydrodynamics.lubrication is not None else []
    requested = CONTACTS[touching]
    # Without contacts between floats, those with the walls of a dish remain.
    solved = "impulse" if touching == "none" and scene.dish is not None else touching
    plain = names == ["superposition"] and not films and "no spins" in requested.gives
    return Chosen(
        integrator=integrator,
        interactions=tuple(INTERACTIONS[name] for name in names),
        resistances=tuple(films),
        contacts=CONTACTS["outlines"] if scene.shaped else hydrodynamics.contact_model(solved),
        requested_contacts=requested,
        hydrodynamics=hydrodynamics,
        # If the integrator evaluates forces within a step, four direct sums per step are faster than a grid.
        grid_allowed=plain and "kicks at the ends" in integrator.gives,
    )


def _contacts_of(scene: FloatingScene) -> str:
    """The contacts of a scene. Raises SceneError for keys that exclude each other."""
    law, legacy = scene.contacts.law, scene.contacts.legacy_coefficient is not None
    if law != "spring-dashpot" and scene.contacts.stiffness is not None:
        raise scene_error("contacts.stiffness", "means something only with contacts.law = 'spring-dashpot'")
    if scene.rubs and (law != "impulse" or legacy):
        key = "contacts.friction" if scene.contacts.friction > 0.0 else "dish.friction"
        raise scene_error(
            key, "friction needs contacts that are solved as impulses, to which it adds those along the surfaces: "
            "contacts.law = 'impulse', without a legacy coefficient"
        )  # fmt: skip
    if law == "impulse":
        return ("rolling friction" if scene.rolls else "friction") if scene.rubs else "legacy" if legacy else "impulse"
    return law


def options_of(scene: FloatingScene, chosen: Chosen) -> list[Option]:
    """All options of a scene that have capabilities or needs."""
    hydrodynamics, law = scene.hydrodynamics, str(scene.interaction.law)
    rows = [chosen.integrator, *chosen.interactions, *chosen.resistances, chosen.requested_contacts]
    surroundings = [pair_option(law), _drag_of(scene), _wall_of(scene), chosen.hydrodynamics]
    active = [
        (hydrodynamics.brownian, NOISE),
        (hydrodynamics.brownian and "keeps inertia" in chosen.integrator.gives, LANGEVIN),
        (scene.drag == DRAG_LAWS[1], FAST_DRAG),
        (scene.flow is not None, FLOW),
        (scene.dish is not None and scene.dish.motion is not None, SWAY),
        (bool(hydrodynamics.added_mass), ADDED_MASS),
        (scene.magnetic_field is not None and scene.magnetic_field.susceptibility > 0.0, INDUCED),
        (any(one.disc is not None and one.disc.undulation > 0.0 for one in scene.given), UNDULATION),
        (_turned_by_menisci(scene), TURNING),
        (scene.activity is not None and scene.activity.torque != 0.0, TORQUE),
        (scene.activity is not None and scene.activity.rotational_diffusion != 0.0, ROTATION),
    ]
    return [*rows, *surroundings, *boundary_of(scene), *(option for there, option in active if there)]


NOISE = Option(
    slot="noise", path="hydrodynamics.brownian", name="Brownian motion",
    needs={
        "takes noise": "noise has no derivative, on which the order of such a scheme rests",
        "stokes": "fluctuations are known for a drag that is proportional to the velocity",
        "drag": "noise and drag belong together",
        "independent": "floats that share films are moved by noise that is correlated",
    },
)  # fmt: skip

LANGEVIN = Option(
    slot="noise with inertia", path="integration.integrator", name="Brownian motion with inertia",
    needs={
        "round": "with inertia, the noise of two velocities of each float is known, but not that of its spin",
        "no torques": "spins would need noise, too",
        "no spins": "spins would need noise, too",
        "at rest": "the liquid of a dish in motion is not in equilibrium, from which the noise is known",
    },
)  # fmt: skip

FAST_DRAG = Option(
    slot="drag law", path="hydrodynamics.drag", name="'schiller-naumann'",
    needs={
        "drag": "it moves floats by drag",
        "fast drag": "a float so fast that its drag is not Stokes's keeps its inertia, and its drag follows its speed",
        "round": "the formula is that of spheres",
    },
)  # fmt: skip

FLOW = Option(
    slot="flow", path="flow", name="a flowing surface",
    needs={"drag": "it moves floats by drag"},
)  # fmt: skip

SWAY = Option(
    slot="dish", path="dish.motion", name="a dish in motion",
    needs={
        "sways": "its acceleration is given by the kicks",
        "stokes": "its velocity acts by Stokes's drag",
        "independent": "the liquid between two floats moves with the dish, too",
    },
)  # fmt: skip

ADDED_MASS = Option(
    slot="mass", path="hydrodynamics.added_mass", name="added mass", needs={"round": "it is known of spheres only"}
)

INDUCED = Option(
    slot="field", path="magnetic_field.susceptibility", name="an induced moment",
    needs={"round": "induced moments are those of spheres; a long body has another demagnetizing field"},
)  # fmt: skip

UNDULATION = Option(
    slot="particles", path="interaction.method", name="a disc with an undulation",
    needs={"undulations": "superposed charges have no direction"},
)  # fmt: skip

TURNING = Option(
    slot="particles", path="integration.integrator", name="a float that its meniscus turns",
    needs={
        "kicks spins": "its spin goes with the kicks of the velocities",
        "keeps inertia": "the law for its spin has a moment of inertia",
        "no torques": "the torques of menisci and of waves on one float are not added up",
        "no noise": "its spin would need noise, too",
    },
)  # fmt: skip


TORQUE = Option(
    slot="torque", path="activity.torque", name="a torque",
    needs={
        "single drag": "the flow of a float that turns moves its neighbors",
        "no spins": "a torque on floats that rub is transmitted by their contacts",
        "round": "it turns the heading of a float, but not its outline",
    },
)  # fmt: skip

ROTATION = Option(
    slot="torque", path="activity.rotational_diffusion", name="rotational diffusion",
    needs={"round": "it turns the heading of a float, but not its outline"},
)  # fmt: skip


def _turned_by_menisci(scene: FloatingScene) -> bool:
    undulated = any(one.disc is not None and one.disc.undulation > 0.0 for one in scene.given)
    return scene.interaction.method == "multipole" and undulated


def _drag_of(scene: FloatingScene) -> Option:
    """The drag of a scene, with its capabilities."""
    there = scene.hydrodynamics.resists and liquid_of(scene).viscosity_of_both > 0.0
    gives = {"drag"} if there else set()
    gives |= {"stokes"} if scene.drag != DRAG_LAWS[1] else set()
    return Option(
        slot="drag", path="hydrodynamics.drag", name=repr(scene.drag) if there else "no drag",
        gives=frozenset(gives),
        needs={},
    )  # fmt: skip


def _wall_of(scene: FloatingScene) -> Option:
    """The menisci at the walls, with their capabilities."""
    law = scene.dish.law if scene.dish is not None else None
    image = scene.dish.image if scene.dish is not None else "none"
    path, name = ("dish.law", law) if image == "none" else ("dish.image", image)
    simple = is_far_field(wall_law_of(scene))
    gives = {"point charges"} if simple or (law == "profile" and image == "none") else set()
    gives |= {"multipoles"} if simple and law != "linear" and echoes_known(scene.dish) else set()
    return Option(slot="wall", path=path, name=repr(name), gives=frozenset(gives))


ROOMIER = 1.6
"""Factor by which rows of neighbor lists grow when they are too short."""

BYTES_PER_FLOAT = 1200
BYTES_PER_NEIGHBOR = 4
BYTES_PER_POINT = 60
"""Bytes per grid point: charges, their transform, waves, and two fields."""


def checked_parameters(scene: FloatingScene, further: tuple[Interaction, ...] = ()) -> Parameters:
    """Return the parameters of a scene that fits into memory, with further interactions."""
    count = len(scene.rows) + sum(species.count for species in scene.particles)
    # Test before any allocation, since a scene may specify a hundred million floats by mistake.
    _require_memory(count, BYTES_PER_FLOAT * count)
    parameters = parameters_of(scene, further)
    _require_memory(count, memory_estimate(parameters))
    return within_steps(scene, parameters)


def memory_estimate(parameters: Parameters) -> float:
    """Bytes of a run when the floats form rafts."""
    grid = BYTES_PER_POINT * sum(row.points(part) for part, row in interactions_of(parameters))
    moving = INTEGRATORS_BY_CONSTANTS[type(parameters.parts.integrator)].memory(parameters.parts.integrator)
    return grid + moving + _memory_of_lists(parameters)


def _memory_of_lists(parameters: Parameters) -> float:
    """Bytes of the state and the neighbor lists when the floats form rafts."""
    count = len(parameters.floats.radius)
    packed = 0.92 * (parameters.reach / float(parameters.floats.radius.min())) ** 2
    return count * (BYTES_PER_FLOAT + BYTES_PER_NEIGHBOR * ROOMIER * min(packed, count))


def _require_memory(count: int, needed: float) -> None:
    way_out = "use fewer floats, or a larger interaction.accuracy, which shortens the cutoff"
    require_memory("particles", f"{count} floats", needed, way_out)
