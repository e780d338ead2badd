"""From a scene to parameters and the first state."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ecume.engine.linear_solvers import cholmod
from ecume.engine.linear_solvers.solvers import SOLVERS
from ecume.engine.walls import planes
from ecume.errors import BadInput, Fault, SceneError
from ecume.laws.arguments import chosen
from ecume.laws.deflections import TANGENTIAL, TENSION
from ecume.laws.drag import stokes_friction
from ecume.laws.friction import FRICTIONS
from ecume.laws.interfaces import INTERFACES
from ecume.laws.long_range import REMOTE
from ecume.laws.soft_pair import PREFACTORS, Prefactors
from ecume.laws.surfaces import SURFACES
from ecume.models.liquids import material_of
from ecume.models.soft.contacts.contact_list import open_all
from ecume.models.soft.integration.dirk import accept
from ecume.models.soft.integration.dirk_schemes import SCHEMES
from ecume.models.soft.integration.linear_solvers import AT_ONCE, balance
from ecume.models.soft.loading.cell import box_of, shape_at
from ecume.models.soft.loading.protocol import Protocol, drive_at, protocol_of, rules_at
from ecume.models.soft.parameters import CONTACT_LISTS, Contacts, Laws, Parameters, Planes
from ecume.models.soft.setup.packing import places
from ecume.models.soft.setup.start_checks import (
    require_balance,
    require_gaps,
    require_hold,
    require_moderate_forces,
    require_no_torque,
    require_room,
)
from ecume.models.soft.state import LENGTH, State, make_state, store, workspace
from ecume.models.step_counts import last_step
from ecume.models.tables import code_of
from ecume.scenes.soft import SIDES, FilmSpec, SoftScene, SphereSpec, dimensions_of, sides_of, tension_law_of
from ecume.units import Array

TICKS = 1024
"""Ticks between two frames, in which progress is reported; there are far fewer time steps."""
FADE = 1.25
"""A film fades from the reach to this many reaches."""
ROUNDING = 1e-12
"""Of the smallest radius: deflections below it have a smooth magnitude."""
FIRST_STEP = 1e-6
"""Of the time between frames, or between moments of the protocol."""
FIRST_SHEAR = 0.1
"""Of what the tolerance may make of the narrowest gap, where something is sheared: forces that only begin are so large
after the first step already that rounding is nothing beside them.
"""
REACH = 0.5
"""Of the smallest radius: how far films reach in a box, when the scene does not say."""
ROOM = {2: 16, 3: 40}
"""Contacts a sphere that a state has room for, in each dimension."""


def parameters_of(scene: SoftScene) -> Parameters:
    """The parameters of a scene. Raises SceneError."""
    faults = _unknown_names(scene) or _missing_needs(scene, laws_chosen(scene))
    if faults:
        raise SceneError(faults)
    counts = [species.count or len(species.positions) for species in scene.particles]
    dimensions = dimensions_of(scene)
    radius = np.repeat([species.radius for species in scene.particles], counts)
    liquid = material_of(scene.liquid)
    force = np.repeat([species.force or (0.0,) * dimensions for species in scene.particles], counts, axis=0)
    drag = np.array(
        [stokes_friction(r, liquid.viscosity, 1.0) * (scene.hydrodynamics.drag == "stokes") for r in radius]
    )
    box = np.zeros(3)
    if scene.cell is not None:
        box[:dimensions] = sides_of(scene)
    walls = _planes(scene)
    box[walls.surfaces.place.any(axis=0)] = 0.0
    parameters = Parameters(
        time_step=scene.frame_every / TICKS,
        steps_per_frame=TICKS,
        end=scene.duration if scene.rest else math.inf,
        last_tick=last_step(scene, TICKS, least=2),
        dimensions=dimensions,
        radius=radius,
        modulus=np.repeat([_modulus(scene, species) for species in scene.particles], counts),
        species=np.repeat(np.arange(len(counts)), counts),
        drag=drag,
        force=np.ascontiguousarray(force, np.float64),
        spin_drag=4.0 / 3.0 * drag,
        torque=_torques(scene, counts),
        weight=_weights(scene, radius, counts),
        box=box,
        walls=walls,
        contacts=_contacts(scene, float(radius.min())),
        laws=laws_chosen(scene),
        protocol=protocol_of(scene.protocol),
        listed=scene.films.output,
        scheme=scene.integration.integrator,
        tolerance=scene.integration.tolerance,
        solver=scene.integration.solver,
    )
    require_moderate_forces(parameters)
    require_room(parameters)
    require_balance(parameters)
    return parameters


def start(scene: SoftScene, parameters: Parameters) -> State:
    """The state at time 0: spheres in place, films without flow, and the first forces balanced by deflections."""
    position = places(scene, parameters)
    drive = drive_at(parameters.protocol, 0.0)
    require_gaps(parameters, position, box_of(parameters.box, shape_at(parameters.box, drive), parameters.dimensions))
    count = len(position)
    room = min(ROOM[parameters.dimensions] * count, count * (count - 1) // 2)
    if parameters.box.any() or math.isinf(parameters.contacts.fade_to):
        room = ROOM[parameters.dimensions] * count if parameters.box.any() else count * (count - 1) // 2
    state = make_state(parameters, position, room)
    state.cell[:] = shape_at(parameters.box, drive_at(parameters.protocol, 0.0))
    open_all(parameters, state)
    state.pace[LENGTH] = _first_length(scene, parameters, state)
    if not parameters.drag.any():
        require_hold(parameters, state)
        require_no_torque(parameters, state)
    if not parameters.drag.any() or any(rules_at(parameters.protocol, 0)) or len(parameters.walls.free):
        _balance(parameters, state)
    return state


def _first_length(scene: SoftScene, parameters: Parameters, state: State) -> float:
    """The first step (s)."""
    longest = min(scene.frame_every, *_spans(parameters.protocol, scene.frame_every))
    drive, wave = drive_at(parameters.protocol, 0.0), parameters.protocol.waves[0]
    rate = abs(drive.rate) + abs(drive.growth) + abs(drive.height_rate) + float(wave[0] * wave[2])
    speed = 2.0 * float(parameters.radius.max()) * rate + float(
        np.abs(parameters.walls.surfaces.velocity).max(initial=0.0)
    )
    gaps = np.append(state.log_gap[: state.contacts[0]], state.wall_gap[state.touching.astype(bool)])
    if speed == 0.0 or len(gaps) == 0:
        return FIRST_STEP * longest
    part = FIRST_SHEAR * parameters.tolerance ** (1.0 / SCHEMES[parameters.scheme].tableau.order)
    return float(min(max(FIRST_STEP * longest, part * math.exp(gaps.min()) / speed), longest))


def _balance(parameters: Parameters, state: State) -> None:
    drive, rules = drive_at(parameters.protocol, 0.0), rules_at(parameters.protocol, 0)
    scratch = workspace(parameters, state, 1.0)
    span = AT_ONCE * float(state.pace[LENGTH]) if parameters.drag.any() else 0.0
    if not balance(parameters, scratch, (drive, drive, rules), state.effort, span):
        message = "the surfaces cannot balance these forces or stresses; reduce them"
        raise SceneError([Fault("protocol" if any(rules) else "particles", message)])
    accept(scratch.step)
    store(parameters, state, scratch.step)


def _planes(scene: SoftScene) -> Planes:
    """The walls, and what moves them."""
    dimensions, count = dimensions_of(scene), len(scene.walls)
    point, normal, velocity = np.zeros((3, count, dimensions))
    force = np.zeros((count, 3))
    free: list[tuple[int, int]] = []
    sides = np.ones(3)
    if scene.cell is not None:
        sides[:dimensions] = sides_of(scene)
    for index, wall in enumerate(scene.walls):
        across, outward = SIDES[wall.side]
        end = 0.0 if outward < 0.0 else sides[across]
        point[index, across] = end if wall.position is None else wall.position
        normal[index, across] = -outward
        velocity[index] = wall.velocity or 0.0
        area = float(np.prod(np.delete(sides[:dimensions], across)))
        for stress, along, sign in ((wall.pressure, across, -outward), (wall.shear_stress, 0, 1.0)):
            if stress is not None:
                force[index, along] = sign * stress * area
                free.append((index, along))
    modulus = np.array([math.inf if wall.modulus is None else wall.modulus for wall in scene.walls])
    return Planes(planes(point, normal, velocity), modulus, force, np.array(free, np.int64).reshape(-1, 2))


def _weights(scene: SoftScene, radius: Array, counts: list[int]) -> Array:
    """Gravity less buoyancy of each sphere (N)."""
    if scene.gravity is None:
        return np.zeros((len(radius), dimensions_of(scene)))
    liquid = material_of(scene.liquid).density
    heavier = np.array([(species.density or 0.0) - liquid for species in scene.particles])
    mass = np.repeat(heavier, counts) * 4.0 / 3.0 * math.pi * radius**3
    return np.asarray(mass[:, None] * np.array(scene.gravity))


def _torques(scene: SoftScene, counts: list[int]) -> Array:
    """The torque on each sphere, as a force at its equator (N); without components for spheres without spin."""
    width = 0 if not scene.rotation else 1 if dimensions_of(scene) == 2 else 3
    given = np.array([species.torque or (0.0,) * width for species in scene.particles]).reshape(len(counts), width)
    at_equator = given / np.array([species.radius for species in scene.particles])[:, None]
    return np.repeat(at_equator, counts, axis=0)


def _spans(protocol: Protocol, otherwise: float) -> list[float]:
    spans = [float(span) for span in np.diff(protocol.times) if span > 0.0]
    return spans or [otherwise]


def prefactors_of(films: FilmSpec) -> Prefactors:
    """The set that a scene names, and what it overrules."""
    known = chosen(PREFACTORS, films.prefactors, "set of prefactors")
    given = {name: getattr(films, name) for name in Prefactors._fields}
    return known._replace(**{name: value for name, value in given.items() if value is not None})


def _contacts(scene: SoftScene, smallest: float) -> Contacts:
    remote, films, reach = scene.long_range_forces, scene.films, scene.films.cutoff
    liquid = material_of(scene.liquid)
    if reach is None:
        reach = math.inf if scene.cell is None else REACH * smallest
    return Contacts(
        liquid.viscosity,
        *prefactors_of(scene.films),
        fade_from=reach,
        fade_to=FADE * reach,
        rounding=ROUNDING * smallest,
        remote=code_of(REMOTE, remote.law),
        strength=remote.steric_strength,
        steric_length=remote.steric_length,
        hamaker=remote.hamaker_constant,
        layer_strength=remote.double_layer_strength,
        debye_length=remote.debye_length,
        surface=code_of(SURFACES, films.surface),
        surface_tension=liquid.surface_tension,
        interface=code_of(INTERFACES, films.interface),
        viscosity_ratio=films.viscosity_ratio,
        friction=code_of(FRICTIONS, films.friction),
        coefficient=films.friction_coefficient,
        roughness=films.roughness or 0.0,
        critical_load=films.critical_load or 0.0,
        tangential_law=code_of(TANGENTIAL, films.tangential_law),
        tension_law=code_of(TENSION, tension_law_of(scene)),
        cavitation_pressure=films.cavitation_pressure or 0.0,
    )


def laws_chosen(scene: SoftScene) -> Laws:
    """The rows that a scene names."""
    films = scene.films
    return Laws(
        SURFACES[films.surface],
        INTERFACES[films.interface],
        REMOTE[scene.long_range_forces.law],
        FRICTIONS[films.friction],
        TANGENTIAL[films.tangential_law],
        TENSION[tension_law_of(scene)],
    )


def _missing_needs(scene: SoftScene, laws: Laws) -> list[Fault]:
    """The required parameters of the chosen laws that are missing."""
    spheres: list[tuple[str, object]] = [(f"particles[{index}]", one) for index, one in enumerate(scene.particles)]
    holders: dict[str, list[tuple[str, object]]] = {
        "surface_tension": [("liquid", scene.liquid)],
        "modulus": spheres,
        "roughness": [("films", scene.films)],
        "critical_load": [("films", scene.films)],
        "cavitation_pressure": [("films", scene.films)],
    }
    return [
        Fault(f"{path}.{name}", said)
        for needs in (laws.surface.needs, laws.friction.needs, laws.tension.needs)
        for name, said in needs.items()
        for path, given in holders[name]
        if getattr(given, name) is None
    ]


def _modulus(scene: SoftScene, species: SphereSpec) -> float:
    """The modulus of the material; for bubbles the equivalent, surface tension over radius."""
    return material_of(scene.liquid).surface_tension / species.radius if species.modulus is None else species.modulus


def _unknown_names(scene: SoftScene) -> list[Fault]:
    """Faults for names of laws and schemes that do not exist."""
    asked: list[tuple[str, Any, str, str]] = [
        ("films.prefactors", PREFACTORS, scene.films.prefactors, "set of prefactors"),
        ("films.surface", SURFACES, scene.films.surface, "elastic law"),
        ("films.interface", INTERFACES, scene.films.interface, "interface"),
        ("films.friction", FRICTIONS, scene.films.friction, "contact friction"),
        ("films.output", dict.fromkeys(CONTACT_LISTS), scene.films.output, "list of contacts"),
        ("films.tangential_law", TANGENTIAL, scene.films.tangential_law, "tangential law"),
        ("films.tension_law", TENSION, tension_law_of(scene), "tension law"),
        ("long_range_forces.law", REMOTE, scene.long_range_forces.law, "remote law"),
        ("integration.integrator", SCHEMES, scene.integration.integrator, "scheme"),
        ("integration.solver", {"auto": None, **SOLVERS}, scene.integration.solver, "solver"),
    ]
    faults = []
    for path, table, name, what in asked:
        try:
            chosen(table, name, what)
        except BadInput as error:
            faults.append(Fault(path, str(error)))
    if scene.integration.solver == "cholmod":
        try:
            cholmod.library()
        except BadInput as error:
            faults.append(Fault("integration.solver", str(error)))
    return faults
