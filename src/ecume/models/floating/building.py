"""From a scene to parameters: equilibria, charges, drag, walls, and the time step."""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.engine.walls import Walls
from ecume.engine.walls import dishes as wall_shapes
from ecume.errors import BadInput, EcumeError, Fault, SceneError
from ecume.laws import capillarity, drag, flotation, images, meniscus
from ecume.laws.contact import legacy_restitution
from ecume.laws.screened import fit_k1
from ecume.models.floating.drifting import drift_of
from ecume.models.floating.pace import LARGEST_OVER_CHOSEN, LOOSEST_OVER_CHOSEN, chosen_step
from ecume.models.floating.parameters import (
    CAPILLARY,
    CONTACT_LAWS,
    DISH,
    DRAG_LAWS,
    LEGACY,
    LEGACY_DISH,
    NO_WALL_LAW,
    OVERDAMPED,
    PAIR_LAWS,
    PLANE,
    RK4,
    SCHEMES,
    TABLED,
    VELOCITY_VERLET,
    Floats,
    Kick,
    Parameters,
    pack_pair,
)
from ecume.models.floating.wall_tables import WallKind, wall_table
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import DiscSpec, FloatingScene, FloatRow, FloatSpec, species_of
from ecume.units import Array

DEEPEST_TOUCH = 0.9
"""The pair law is fitted down to this part of the smallest touching distance."""
FARTHEST_CHANCE = 6.5
"""Standard deviations that chance is allowed for when neighbors are listed."""
SLOP = 1e-4
"""Overlaps up to this part of the smallest radius are left alone."""


class StepWarning(UserWarning):
    """The time step is longer than is good for the result."""


class Afloat(NamedTuple):
    """One kind of float as it floats: what it is made of, and what the laws make of it."""

    body: flotation.Sphere | flotation.Disc
    density: float
    contact_angle: float
    """of a disc NaN: its edge takes any"""
    equilibrium: flotation.Equilibrium
    charge: float
    mass: float
    friction: float
    rim: tuple[int, float] = (2, 0.0)
    """mode of an undulated rim, and its height (m)"""


def contact_angle_of(given: FloatSpec | FloatRow, liquid: flotation.Liquid) -> float:
    """The contact angle as a number: given, by Young's law, or by the original project's closure."""
    if given.surface_energies is not None:
        energies = given.surface_energies
        return flotation.young_contact_angle(
            solid_gas=energies.solid_gas, solid_liquid=energies.solid_liquid, liquid_gas=liquid.surface_tension
        )
    if isinstance(given.contact_angle, str):
        bare = flotation.Sphere(given.radius, given.density, 0.5 * math.pi)
        return flotation.closure_contact_angle(
            bond_number=flotation.bond_number(bare, liquid), density_ratio=flotation.density_ratio(bare, liquid)
        )
    assert given.contact_angle is not None  # noqa: S101  # the schema asks for exactly one of the two
    return given.contact_angle


def afloat(given: FloatSpec | FloatRow, scene: FloatingScene) -> Afloat:
    """How one kind of float floats. Raises BadInput where it does not."""
    liquid = liquid_of(scene)
    if isinstance(given, FloatSpec) and given.disc is not None:
        return disc_afloat(given, given.disc, scene)
    sphere = flotation.Sphere(given.radius, given.density, contact_angle_of(given, liquid))
    balance = flotation.equilibrium(sphere, liquid)
    assert scene.interaction.charge is not None  # noqa: S101  # the scene has filled it in
    charge = flotation.capillary_charge(sphere, liquid, scene.interaction.charge)
    factor = float(drag.factor_at_filling(balance.filling_angle))
    mass = given.density * 4.0 / 3.0 * math.pi * given.radius**3
    if scene.motion.added_mass:
        mass += drag.added_mass(given.radius, balance.filling_angle, liquid.density)
    friction = drag.stokes_friction(given.radius, liquid.viscosity, factor)
    return Afloat(sphere, given.density, sphere.contact_angle, balance, charge, mass, friction)


def disc_afloat(given: FloatSpec, disc: DiscSpec, scene: FloatingScene) -> Afloat:
    """How a disc floats, pinned to one of its edges. Raises BadInput where it does not."""
    liquid = liquid_of(scene)
    solid = flotation.VerticalCylinder(given.radius, disc.thickness, given.density, 0.5 * math.pi)
    body = dataclasses.replace(flotation.disc_of_cylinder(solid, liquid, disc.rim), tilting=disc.tilting)
    balance = flotation.equilibrium(body, liquid)
    charge = flotation.capillary_charge(body, liquid, str(scene.interaction.charge))
    mass = given.density * math.pi * given.radius**2 * disc.thickness
    friction = drag.disc_friction(given.radius, liquid.viscosity)
    rim = disc.mode, disc.undulation
    return Afloat(body, given.density, math.nan, balance, charge, mass, friction, rim)


def kinds_afloat(scene: FloatingScene) -> list[Afloat]:
    """Each of the scene's float tables and rows, afloat; all faults at once."""
    faults: list[Fault] = []
    found: list[Afloat] = []
    known: dict[Any, Afloat | BadInput] = {}
    for where, given in _given(scene):
        disc = given.disc if isinstance(given, FloatSpec) else None
        key = (given.radius, given.density, given.contact_angle, given.surface_energies, disc)
        if key not in known:
            try:
                known[key] = afloat(given, scene)
            except BadInput as error:
                known[key] = error
        kind = known[key]
        if isinstance(kind, BadInput):
            faults.append(Fault(where, str(kind)))
        else:
            found.append(kind)
    if faults:
        raise SceneError(faults)
    return found


def _given(scene: FloatingScene) -> list[tuple[str, FloatSpec | FloatRow]]:
    tables = [(f"floats[{k}]", given) for k, given in enumerate(scene.floats)]
    return [*tables, *((f"rows[{k}]", row) for k, row in enumerate(scene.rows))]


def floats_of(scene: FloatingScene) -> Floats:
    """Float by float: the tables' first, then the rows."""
    kinds = kinds_afloat(scene)
    counts = [given.count if isinstance(given, FloatSpec) else 1 for _, given in _given(scene)]
    names = [name for name, _ in species_of(scene)]
    species = [
        names.index(given.name if isinstance(given, FloatSpec) else given.species_name) for _, given in _given(scene)
    ]

    def each(of: Callable[[Afloat], float]) -> Array:
        return np.repeat(np.array([of(kind) for kind in kinds]), counts)

    return Floats(
        radius=each(lambda kind: kind.body.radius),
        mass=each(lambda kind: kind.mass),
        charge=each(lambda kind: kind.charge),
        relaxation_time=each(lambda kind: drag.relaxation_time(kind.mass, kind.friction))
        if scene.motion.drag
        else np.full(sum(counts), np.inf),
        density=each(lambda kind: kind.density),
        contact_angle=each(lambda kind: kind.contact_angle),
        species=np.repeat(np.array(species, dtype=np.int64), counts),
    )


def walls_of(scene: FloatingScene) -> Walls:
    """The dish as walls that centers keep a radius away from."""
    if scene.dish is None:
        return wall_shapes.no_walls()
    if scene.dish.radius is not None:
        return wall_shapes.disc(scene.dish.radius)
    assert scene.dish.size is not None  # noqa: S101  # the schema asks for exactly one of the two
    width, height = scene.dish.size
    return wall_shapes.box((-0.5 * width, -0.5 * height), (0.5 * width, 0.5 * height))


def wall_law_of(scene: FloatingScene) -> int:
    """Which compiled law the walls follow."""
    dish = scene.dish
    if dish is None or (dish.law == "none" and dish.image == "none"):
        return NO_WALL_LAW
    if dish.law == "two-point-legacy":
        if dish.radius is None:
            raise _fault("dish.law", f"{dish.law!r} is for round dishes; a rectangular one has the others")
        if dish.image != "none":
            raise _fault("dish.image", f"{dish.law!r} knows no images; leave them out, or take another law")
        return LEGACY_DISH
    if dish.image != "none" or dish.law == "profile":
        return TABLED
    return PLANE if dish.radius is None else DISH


def wall_strengths(scene: FloatingScene, floats: Floats) -> Array:
    """(walls, N) in J: how strongly each wall's meniscus acts on each float."""
    law, liquid = wall_law_of(scene), liquid_of(scene)
    count = wall_shapes.wall_count(walls_of(scene))
    if law == NO_WALL_LAW or scene.dish is None:
        return np.zeros((count, len(floats.radius)))
    tension = liquid.surface_tension
    if law == LEGACY_DISH:
        bonds = (floats.radius / liquid.capillary_length) ** 2
        wall_ratio = (scene.dish.density - liquid.gas_density) / liquid.density_difference
        weight = flotation.weight_number(wall_ratio, scene.dish.contact_angle)
        rows = [
            capillarity.legacy_wall_strength(tension, radius, bond, weight)
            for radius, bond in zip(floats.radius, bonds, strict=True)
        ]
        return np.array([rows])
    amplitudes = _amplitudes(scene, liquid) if scene.dish.law != "none" else [0.0] * count
    return np.array(
        [[capillarity.wall_strength(tension, charge, wall) for charge in floats.charge] for wall in amplitudes]
    )


def _amplitudes(scene: FloatingScene, liquid: flotation.Liquid) -> list[float]:
    """Far amplitude of each wall's meniscus (m); a table of a round dish is in capillary lengths."""
    dish = scene.dish
    assert dish is not None  # noqa: S101  # only asked with a dish
    angle, theory = dish.contact_angle, "linear" if dish.law == "linear" else "amplitude"
    try:
        if dish.size is None:
            alone = meniscus.AMPLITUDES[theory](angle, liquid)
            return [liquid.capillary_length if wall_law_of(scene) == TABLED else alone]
        across, along = (meniscus.facing_amplitude(side, angle, liquid, theory) for side in dish.size)
    except BadInput as error:
        raise _fault("dish.law", str(error)) from None
    return [across, along, across, along]


def wall_table_of(scene: FloatingScene, smallest: float) -> Array:
    """The walls' table, or an empty one."""
    dish = scene.dish
    if dish is None or wall_law_of(scene) != TABLED:
        return np.zeros((6, 2))
    assert dish.law is not None  # noqa: S101  # the scene has filled it in
    kind = WallKind(dish.contact_angle, dish.law, dish.image, dish.radius)
    return wall_table(kind, liquid_of(scene), 0.5 * smallest)


def kick_of(scheme: int, time_step: float, floats: Floats, walls: int) -> Kick:
    """One kick of the scheme: half a step for velocity Verlet, a whole one for the others."""
    time = 0.5 * time_step if scheme == VELOCITY_VERLET else time_step
    if scheme == OVERDAMPED:
        gain = floats.relaxation_time / floats.mass
        return Kick(np.zeros_like(gain), gain, np.concatenate([gain / time, np.zeros(walls)]))
    ratio = time / floats.relaxation_time
    decay = np.exp(-ratio)
    with np.errstate(invalid="ignore", divide="ignore"):
        held = np.where(ratio > 0.0, -np.expm1(-ratio) / ratio, 1.0)
    gain = time / floats.mass * held
    mobility = np.concatenate([gain / time, np.zeros(walls)])
    return Kick(decay, gain, mobility)


def parameters_of(scene: FloatingScene) -> Parameters:
    """Everything a run needs and never changes. Raises SceneError."""
    _check_names(scene)
    drift = drift_of(scene)
    floats, liquid = floats_of(scene), liquid_of(scene)
    length, pair_law = liquid.capillary_length, PAIR_LAWS.index(str(scene.interaction.law))
    cutoff = capillarity.truncation_radius(scene.interaction.accuracy) * length
    smallest, largest = float(floats.radius.min()), float(floats.radius.max())
    try:
        fit = fit_k1(2.0 * DEEPEST_TOUCH * smallest / length, (cutoff + largest) / length)
    except BadInput as error:
        raise _fault("floats", str(error)) from None
    tension = liquid.surface_tension if pair_law == CAPILLARY else 0.0
    mirrored = scene.dish is not None and scene.dish.image != "none"
    walls, scheme = walls_of(scene), SCHEMES.index(scene.motion.integrator)
    skin = max(0.2 * largest, min(0.4 * length, largest))
    parameters = Parameters(
        time_step=0.0,
        steps_per_frame=1,
        scheme=scheme,
        floats=floats,
        kick=kick_of(scheme, 1.0, floats, wall_shapes.wall_count(walls)),
        pair_law=pair_law,
        pair=pack_pair(capillarity.pair_strength(tension, 1.0, 1.0), length, cutoff, liquid.surface_tension, fit),
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
    )
    return with_step(with_method(parameters, scene), scene)


def with_method(parameters: Parameters, scene: FloatingScene) -> Parameters:
    """What goes beyond superposition, where the scene asks for it."""
    if scene.interaction.method != "multipole" and any(one.disc and one.disc.undulation for one in scene.floats):
        raise _fault("interaction.method", "discs with an undulation need 'multipole'")
    if scene.interaction.method == "superposition":
        return parameters
    # Imported when asked for: its loops are compiled on import.
    from ecume.models.floating.interacting import METHODS, require_capillary

    require_capillary(parameters)
    kinds, numbers = _distinct(scene)
    return METHODS[scene.interaction.method](parameters, scene, kinds, numbers)


def _distinct(scene: FloatingScene) -> tuple[list[Afloat], Integers]:
    """The kinds of floats there are, and which of them each float is."""
    found = kinds_afloat(scene)
    counts = [given.count if isinstance(given, FloatSpec) else 1 for _, given in _given(scene)]
    kinds = list(dict.fromkeys(found))
    return kinds, np.repeat(np.array([kinds.index(kind) for kind in found], dtype=np.int64), counts)


def good_step(parameters: Parameters, scene: FloatingScene) -> float:
    """The longest time step that is good (s)."""
    return chosen_step(parameters, _speeds(scene))


def with_step(parameters: Parameters, scene: FloatingScene) -> Parameters:
    """The time step: the scene's own, or the longest that is good, a whole number of times in the time between
    frames.
    """
    good, frame = good_step(parameters, scene), scene.frame_every
    asked = scene.motion.time_step
    if asked is not None:
        _judge(asked, good)
    steps = max(1, math.ceil(frame / (asked if asked is not None else good) * (1.0 - 1e-9)))
    if asked is not None and abs(steps * asked - frame) > 1e-9 * frame:
        raise _fault(
            "motion.time_step", f"{asked:g} s does not divide frame_every = {frame:g} s; {frame / steps:.9g} s would do"
        )
    time_step = frame / steps
    kick = kick_of(
        parameters.scheme, time_step, parameters.floats, len(parameters.kick.mobility) - len(parameters.floats.mass)
    )
    stiffest = float(parameters.floats.relaxation_time.min())
    if parameters.scheme == RK4 and time_step > 2.0 * stiffest:
        raise _fault(
            "motion.integrator", f"'rk4' needs a time step below {2.0 * stiffest:.3g} s in so viscous a liquid; "
            f"it is {time_step:.3g} s. Set motion.time_step, or use 'velocity-verlet'"
        )  # fmt: skip
    jump = FARTHEST_CHANCE * math.sqrt(2.0 * parameters.drift.thermal * float(kick.gain.max()) * time_step)
    drift = parameters.drift._replace(jump=jump if parameters.drift.thermal > 0.0 else 0.0)
    return parameters._replace(time_step=time_step, steps_per_frame=steps, kick=kick, drift=drift)


def _judge(asked: float, good: float) -> None:
    """Refuse or warn of a step too large, with the number that would do."""
    if asked > LARGEST_OVER_CHOSEN * good:
        raise _fault(
            "motion.time_step", f"{asked:.3g} s is unstable here; wanted at most {LARGEST_OVER_CHOSEN * good:.3g} s, "
            f"{good:.3g} s is good"
        )  # fmt: skip
    if asked > LOOSEST_OVER_CHOSEN * good:
        warnings.warn(f"motion.time_step: {asked:.3g} s is coarse; {good:.3g} s is good", StepWarning, stacklevel=2)


def _speeds(scene: FloatingScene) -> float:
    """The fastest start, or the fastest that the surface flows in the dish."""
    reach = max((math.hypot(*place) for species in scene.floats for place in species.positions), default=0.0)
    if scene.dish is not None:
        reach = (
            scene.dish.radius if scene.dish.radius is not None else 0.5 * math.hypot(*(scene.dish.size or (0.0, 0.0)))
        )
    flow = drift_of(scene).flow
    flowing = math.hypot(flow[0], flow[1]) + reach * float(np.abs(flow[2:]).sum())
    speeds = [math.hypot(*species.velocity) for species in scene.floats]
    return max([flowing, *speeds, *(math.hypot(row.vx, row.vy) for row in scene.rows)])


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
        ("contacts.law", scene.contacts.law, ("impulse", "none")),
        ("interaction.law", str(scene.interaction.law), PAIR_LAWS),
        ("interaction.charge", str(scene.interaction.charge), tuple(flotation.CHARGES)),
        ("interaction.method", scene.interaction.method, ("superposition", "pair-corrected", "multipole")),
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


def _fault(path: str, message: str) -> EcumeError:
    return SceneError([Fault(path, message)])
