"""Parameters and initial state from a scene: random packings, and checks of the start."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ecume.engine.linear_solvers import cholmod
from ecume.engine.linear_solvers.solvers import SOLVERS
from ecume.engine.walls import nearest_points, planes
from ecume.errors import BadInput, Fault, SceneError
from ecume.laws.arguments import chosen
from ecume.laws.drag import stokes_friction
from ecume.laws.friction import FRICTIONS
from ecume.laws.interfaces import INTERFACES
from ecume.laws.long_range import REMOTE
from ecume.laws.permeability import PERMEABILITIES
from ecume.laws.soft_contacts import TANGENTIAL, TENSION
from ecume.laws.soft_pair import PREFACTORS, Prefactors
from ecume.laws.surfaces import SURFACES
from ecume.models.law_codes import code_of
from ecume.models.liquids import material_of
from ecume.models.soft.cell import Box, box_of, shape_at
from ecume.models.soft.contacts.connected_pieces import UNBALANCED, loose_spheres, pieces
from ecume.models.soft.contacts.contact_list import new_pairs, open_all, wall_films, wall_gaps
from ecume.models.soft.contacts.tree_search import box_in, neighbors
from ecume.models.soft.integration.dirk import accept
from ecume.models.soft.integration.dirk_schemes import SCHEMES
from ecume.models.soft.integration.linear_solvers import balance
from ecume.models.soft.medium import medium_of
from ecume.models.soft.parameters import CONTACT_LISTS, Contacts, Laws, Parameters, Planes
from ecume.models.soft.protocol import LOAD, SCALE, Drive, Protocol, Rules, at_frames, drive_at, protocol_of, rules_at
from ecume.models.soft.report.balance_report import floppy, remedies, unbalanced, unborne, unmet_wall, unresisted
from ecume.models.soft.state import LENGTH, State, drained, make_state, store, workspace
from ecume.models.step_counts import last_step
from ecume.scenes.sizes import radii_of
from ecume.scenes.soft import SIDES, FilmSpec, SoftScene, dimensions_of, sides_of, tension_law_of
from ecume.units import Array, with_prefix

GAP = 1e-2
"""The initial gap over the smallest radius."""
WIDER = 1.05
"""Overlapping spheres are separated as if the gap were larger by this factor, so that a minimization that is not quite
converged suffices.
"""
WAY_OUT = "expected a larger cell.size, a smaller cell.volume_fraction or a smaller cell.minimum_gap"
ROUNDS, PUSHES = 20, 400
"""The largest number of rounds of the minimization, and of evaluations in each."""


def places(scene: SoftScene, parameters: Parameters) -> Array:
    """The initial positions: as given, or random from the seed of the scene."""
    given = [place for species in scene.particles for place in species.positions]
    if all(species.count is None for species in scene.particles):
        return np.array(given, np.float64)
    random = np.random.default_rng(scene.seed)
    box = box_of(parameters.box, shape_at(parameters.box, drive_at(parameters.protocol, 0.0)), parameters.dimensions)
    ends = np.where(box.sides > 0.0, box.sides, sides_of(scene) or 0.0)
    position = random.uniform(size=(len(parameters.radius), parameters.dimensions)) * ends
    begin = 0
    for species in scene.particles:
        end = begin + (species.count or len(species.positions))
        if species.positions:
            position[begin:end] = species.positions
        begin = end
    stand_on_walls(scene, parameters, position)
    least = (
        GAP * float(parameters.radius.min())
        if scene.cell is None or scene.cell.minimum_gap is None
        else scene.cell.minimum_gap
    )
    _require_room(parameters, np.where(box.sides > 0.0, ends, ends + 2.0 * parameters.radius.max()), least)
    return pushed_apart(parameters, position, box, least)


def stand_on_walls(scene: SoftScene, parameters: Parameters, position: Array) -> None:
    """Move glued spheres that are placed at random to their walls, which they touch."""
    walls, begin = parameters.walls.surfaces, 0
    for species in scene.particles:
        mine = slice(begin, begin := begin + species.number)
        if species.glued is not None and not species.positions:
            wall = [one.side for one in scene.walls].index(species.glued)
            axis, outward = SIDES[species.glued]
            plane = nearest_points(walls)[wall, axis]
            position[mine, axis] = plane - outward * parameters.radius[mine]


def _require_room(parameters: Parameters, ends: Array, least: float) -> None:
    """Raise SceneError if the spheres, each enlarged by half of the smallest gap, would fill more than the whole
    region.
    """
    unit = math.pi if parameters.dimensions == 2 else 4.0 / 3.0 * math.pi
    filled = unit * float(((parameters.radius + 0.5 * least) ** parameters.dimensions).sum()) / float(np.prod(ends))
    if filled > 1.0:
        message = f"spheres with gaps of {with_prefix(least, 'm', 3)} would fill {filled:.3g} times the region"
        raise SceneError([Fault("cell.size", f"{message}; {WAY_OUT}")])


def pushed_apart(parameters: Parameters, position: Array, box: Box, least: float) -> Array:
    """Positions near the given ones without gaps below `least`, found by minimizing the sum of squared overlaps. Raises
    SceneError.
    """
    wide = parameters._replace(contacts=parameters.contacts._replace(fade_from=WIDER * least))
    unit, walls, glue = float(parameters.radius.min()), parameters.walls.surfaces, parameters.walls.glue
    points = nearest_points(walls)
    along = 1.0 - (glue > 0.0) @ np.abs(walls.place[:, : position.shape[1]])  # glued spheres move along their wall

    def cost(flat: Array) -> tuple[float, Array]:
        pair, _, between = neighbors(wide, flat.reshape(position.shape) * unit, box)
        length = np.linalg.norm(between, axis=1)
        overlap = (parameters.radius[pair].sum(axis=1) + WIDER * least - length) / unit
        push = (overlap / np.maximum(length, 1e-12 * unit))[:, None] * between
        slope = np.zeros_like(position)
        np.add.at(slope, pair[:, 0], push)
        np.add.at(slope, pair[:, 1], -push)
        to_wall = wall_gaps(parameters, flat.reshape(position.shape) * unit, points)
        inside = np.where(glue > 0.0, 0.0, np.maximum(WIDER * least - to_wall, 0.0))
        for wall, normal in enumerate(walls.place[:, : position.shape[1]]):
            slope -= inside[:, wall, None] / unit * normal
        return 0.5 * float((overlap**2).sum() + ((inside / unit) ** 2).sum()), (slope * along).ravel()

    from scipy.optimize import minimize

    flat = position.ravel() / unit
    tight = parameters._replace(contacts=parameters.contacts._replace(fade_from=least))
    for _ in range(ROUNDS):
        flat = minimize(
            cost, flat, jac=True, method="L-BFGS-B", options={"maxiter": PUSHES, "ftol": 0.0, "gtol": 1e-12}
        ).x
        found = np.asarray(flat.reshape(position.shape) * unit)
        if (
            not len(neighbors(tight, found, box)[0])
            and ((wall_gaps(parameters, found, points) >= least) | (glue > 0.0)).all()
        ):
            return found
    message = f"no places were found with gaps of {with_prefix(least, 'm', 3)} everywhere"
    raise SceneError([Fault("cell.size", f"{message}; {WAY_OUT}")])


MOST_FORCE = 2.0
"""The largest external force over modulus times radius squared: it deflects a surface by more than a radius."""
MOST_FILLED = 1.5
"""The largest volume fraction, of undeformed spheres."""


def require_balance(parameters: Parameters) -> None:
    """Raise SceneError if external forces accelerate all spheres together."""
    if parameters.drag.any() or len(parameters.walls.modulus):
        return
    force = parameters.force + parameters.weight
    total, largest = np.abs(force.sum(axis=0)).max(), np.abs(force).max()
    if total > UNBALANCED * largest * len(force):
        raise SceneError(
            [
                Fault(
                    "particles",
                    f"the forces on all spheres sum to {with_prefix(total, 'N', 3)}, and nothing holds them; "
                    "expected a sum of zero, walls, or hydrodynamics.drag = 'stokes'",
                )
            ]
        )


def require_no_torque(parameters: Parameters, state: State) -> None:
    """Raise SceneError if torques rotate freely rotating spheres together without resistance."""
    if parameters.torque.shape[1] == 0 or parameters.box.any() or len(parameters.walls.modulus):
        return
    arm, force = np.zeros((2, len(state.position), 3))
    arm[:, : parameters.dimensions], force[:, : parameters.dimensions] = state.position, parameters.force
    own = parameters.torque * parameters.radius[:, None]
    moment = np.cross(arm - arm.mean(axis=0), force)[:, -own.shape[1] :] + own
    total, largest = np.abs(moment.sum(axis=0)).max(), np.abs(moment).max()
    size = np.abs(parameters.force).max() * parameters.radius.max()
    if total > UNBALANCED * max(largest, size) * len(moment):
        cause = f"the total torque on all spheres is {with_prefix(total, 'N m', 3)}, and nothing balances it"
        raise SceneError([Fault("particles", f"{cause}; expected 0, or hydrodynamics.drag = 'stokes'")])


def require_gaps(parameters: Parameters, position: Array, box: Box) -> None:
    """Raise SceneError if undeformed spheres overlap: there is no film between them."""
    touching = parameters._replace(contacts=parameters.contacts._replace(fade_from=0.0))
    pair, _, between = neighbors(touching, position, box)
    if len(pair):
        first, second = pair[0]
        overlap = with_prefix(parameters.radius[pair[0]].sum() - np.linalg.norm(between[0]), "m", 3)
        message = f"spheres {first} and {second} overlap by {overlap} before they are deformed"
        raise SceneError([Fault("particles", f"{message}; expected a gap for the film")])
    gap = wall_gaps(parameters, position, nearest_points(parameters.walls.surfaces))
    through = ~(gap > 0.0) & (parameters.walls.glue == 0.0)
    if through.any():
        sphere, wall = (int(index[0]) for index in np.nonzero(through))
        message = f"sphere {sphere} is in wall {wall} or beyond it; expected a gap for the film"
        raise SceneError([Fault("particles", message)])


def require_hold(parameters: Parameters, state: State) -> None:
    """Raise SceneError for spheres without drag on which a force acts and which no film connects to other spheres."""
    pair = state.pair[: state.contacts[0]]
    _, pulled = loose_spheres(parameters, pair, state.touching)
    if len(pulled):
        walled = state.touching.shape[1] > 0
        piece = pieces(pair, state.touching)
        others = [one for one in pulled if walled or piece[one] != piece[0]]
        alone = int((others or pulled)[0])
        message = f"sphere {alone} has no film to {'any wall' if walled else 'sphere 0'}, and nothing else holds it"
        raise SceneError([Fault("particles", f"{message}; set films.cutoff higher, or hydrodynamics.drag = 'stokes'")])


def require_moderate_forces(parameters: Parameters) -> None:
    """Raise SceneError for external forces that would deflect a surface by more than a radius."""
    load = float(np.abs(parameters.protocol.courses[:, LOAD, 0]).max())
    forces = {"particles": load * parameters.force, "gravity": parameters.weight}
    for path, force in forces.items():
        part = np.sqrt((force**2).sum(axis=1)) / (parameters.modulus * parameters.radius**2)
        sphere = int(np.argmax(part))
        if part[sphere] > MOST_FORCE:
            size = with_prefix(float(np.linalg.norm(force[sphere])), "N", 3)
            most = with_prefix(float(MOST_FORCE * parameters.modulus[sphere] * parameters.radius[sphere] ** 2), "N", 3)
            message = f"a force of {size} on sphere {sphere} would deflect its surface by more than a radius"
            raise SceneError([Fault(path, f"{message}; expected at most {most}, twice the modulus times radius^2")])


def fillings(parameters: Parameters) -> float:
    """The largest volume fraction in the protocol, if it prescribes the size of the box; 0 without a box."""
    box, dimensions = parameters.box[: parameters.dimensions], parameters.dimensions
    if not box.all():
        return 0.0
    unit, power = (math.pi, 2) if dimensions == 2 else (4.0 / 3.0 * math.pi, 3)
    times = parameters.protocol.times
    scale = min(drive_at(parameters.protocol, float(time)).scale for time in times)
    return float(unit * (parameters.radius**power).sum() / np.prod(box) / scale**dimensions)


def require_room(parameters: Parameters) -> None:
    """Raise SceneError for boxes that are too small for the spheres at any deformation."""
    filled = fillings(parameters)
    if filled > MOST_FILLED:
        path = "protocol" if parameters.protocol.courses[:, SCALE, 0].min() < 1.0 else "cell.size"
        message = f"spheres would fill {filled:.3g} times the cell; expected at most {MOST_FILLED:g} times"
        raise SceneError([Fault(path, message)])


TICKS = 1024
"""The number of ticks between two frames. Ticks are the unit of progress; time steps are far fewer."""
FADE = 1.25
"""A film fades at gaps from the reach to FADE times the reach."""
ROUNDING = 1e-12
"""The deflection, over the smallest radius, below which its magnitude is smoothed."""
FIRST_STEP = 1e-6
"""The first step over the time between frames, or between moments of the protocol."""
FIRST_SHEAR = 0.1
"""The shear of the first step over the error that the tolerance permits for the smallest gap, so that forces exceed
rounding errors from the first step on.
"""
REACH = 0.5
"""The default reach of films in a box, over the smallest radius."""
ROOM = {2: 16, 3: 40}
"""The contacts per sphere for which a state has room, by dimension."""


def parameters_of(scene: SoftScene) -> Parameters:
    """The parameters of a scene. Raises SceneError."""
    faults = _unknown_names(scene) or _missing_needs(scene, laws_chosen(scene))
    if faults:
        raise SceneError(faults)
    counts = [species.count or len(species.positions) for species in scene.particles]
    dimensions = dimensions_of(scene)
    radius = radii_in(scene)
    liquid = material_of(scene.liquid)
    force = np.repeat([species.force or (0.0,) * dimensions for species in scene.particles], counts, axis=0)
    drag = np.array(
        [stokes_friction(r, liquid.viscosity, 1.0) * (scene.hydrodynamics.drag == "stokes") for r in radius]
    )
    box = np.zeros(3)
    if scene.cell is not None:
        box[:dimensions] = sides_of(scene)
    modulus = _moduli(scene, radius, counts)
    walls = _planes(scene, modulus * radius)
    box[walls.surfaces.place.any(axis=0)] = 0.0
    tick, end = scene.frame_every / TICKS, scene.duration if scene.rest else math.inf
    parameters = Parameters(
        time_step=tick,
        steps_per_frame=TICKS,
        end=end,
        last_tick=last_step(scene, TICKS, least=2),
        dimensions=dimensions,
        radius=radius,
        modulus=modulus,
        species=np.repeat(np.arange(len(counts)), counts),
        drag=drag,
        force=np.ascontiguousarray(force, np.float64),
        spin_drag=4.0 / 3.0 * drag,
        torque=_torques(scene, radius, counts),
        weight=_weights(scene, radius, counts),
        box=box,
        walls=walls,
        contacts=_contacts(scene, float(radius.min())),
        laws=laws_chosen(scene),
        protocol=at_frames(protocol_of(scene.protocol), TICKS, tick, end),
        listed=scene.films.output,
        scheme=scene.integration.integrator,
        tolerance=scene.integration.tolerance,
        solver=scene.integration.solver,
        permeation=medium_of(scene, radius),
    )
    require_moderate_forces(parameters)
    require_room(parameters)
    require_balance(parameters)
    return parameters


def start(scene: SoftScene, parameters: Parameters) -> State:
    """The initial state without a preparation: spheres at their positions, films at rest, and the initial forces
    balanced by deflections.
    """
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
    state.pace[LENGTH] = first_length(scene, parameters, state)
    if not parameters.drag.any():
        require_hold(parameters, state)
        require_no_torque(parameters, state)
    if cause := unmet_wall(parameters, state):
        raise SceneError([Fault("walls", cause)])
    if not parameters.drag.any() or any(rules_at(parameters.protocol, 0)) or len(parameters.walls.free):
        balance_first(parameters, state)
    return state


def first_length(scene: SoftScene, parameters: Parameters, state: State) -> float:
    """The length of the first step (s)."""
    longest = min(scene.frame_every, *_spans(parameters.protocol, scene.frame_every))
    drive, wave = drive_at(parameters.protocol, 0.0), parameters.protocol.waves[0]
    rate = abs(drive.rate) + abs(drive.growth) + abs(drive.height_rate) + float(wave[0] * wave[2])
    speed = 2.0 * float(parameters.radius.max()) * rate + float(
        np.abs(parameters.walls.surfaces.velocity).max(initial=0.0)
    )
    gaps = np.append(state.log_gap[: state.contacts[0]], state.wall_gap[wall_films(parameters, state)])
    if speed == 0.0 or len(gaps) == 0:
        return FIRST_STEP * longest
    part = FIRST_SHEAR * parameters.tolerance ** (1.0 / SCHEMES[parameters.scheme].tableau.order)
    return float(min(max(FIRST_STEP * longest, part * math.exp(gaps.min()) / speed), longest))


def balance_first(parameters: Parameters, state: State) -> None:
    """Balance the initial state. Raises SceneError with the reason if that is impossible."""
    drive, rules = drive_at(parameters.protocol, 0.0), rules_at(parameters.protocol, 0)
    at, scratch = (drive, drive, rules), drained(workspace(parameters, state, 1.0))
    path = "protocol" if any(rules) else "particles"
    if cause := (
        unborne(parameters, state, rules)
        or floppy(parameters, state, scratch, at[1:])
        or unresisted(parameters, state, scratch, drive)
    ):
        raise SceneError([Fault(path, cause)])
    if not balance(parameters, scratch, at, state.effort):
        raise SceneError([Fault(*_without_balance(parameters, state, at, path))])
    accept(scratch.step)
    store(parameters, state, scratch.step)
    if cause := rolled_into(parameters, state):
        raise SceneError([Fault(path, cause)])


def rolled_into(parameters: Parameters, state: State) -> str:
    """A sentence if forces have moved spheres into each other at constant gaps, since nothing resists rolling around a
    single film without drag; otherwise empty.
    """
    known = state.pair[: state.contacts[0]], state.image[: state.contacts[0]]
    pair, _, between = new_pairs(parameters, state.position, box_in(parameters, state), known)
    overlap = parameters.radius[pair].sum(axis=1) - np.linalg.norm(between, axis=1)
    if not (overlap >= 0.0).any():
        return ""
    first, second = pair[int(np.argmax(overlap))]
    moved = "roll" if parameters.torque.shape[1] else "move"
    cause = f"forces {moved} spheres around their films at once, with no film resisting, until {first} is in {second}"
    return f"{cause}; {remedies(parameters)}"


def _without_balance(
    parameters: Parameters, state: State, at: tuple[Drive, Drive, Rules], path: str
) -> tuple[str, str]:
    """The key to change, and the reason: the chosen solver if another one finds a balance, otherwise the physical
    reason.
    """
    if parameters.solver != "auto":
        usual = parameters._replace(solver="auto")
        if balance(usual, drained(workspace(usual, state, 1.0)), at, state.effort.copy()):
            cause = f"{parameters.solver} found no balance of forces where auto finds one"
            return "integration.solver", f'{cause}; expected "auto"'
    pressed = path == "particles" and len(parameters.walls.free) > 0
    cause = unbalanced(parameters, drained(workspace(parameters, state, 1.0)), at[1:])
    return "walls" if pressed else path, cause


GLUE = 1e3
"""The stiffness of glue over modulus times radius: glued spheres move by a thousandth of what surfaces deflect."""


def _planes(scene: SoftScene, stiffness: Array) -> Planes:
    """The walls, their motions and their forces, and the spheres that are glued to them; `stiffness` is the modulus of
    each sphere times its radius.
    """
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
    counts = [species.number for species in scene.particles]
    glued = np.array([[species.glued == wall.side for wall in scene.walls] for species in scene.particles])
    glue = GLUE * stiffness[:, None] * np.repeat(glued.reshape(len(counts), count), counts, axis=0)
    return Planes(planes(point, normal, velocity), modulus, force, np.array(free, np.int64).reshape(-1, 2), glue)


SLOW, SLOWEST = 1e-3, 1e-6
"""The default rate of compression over pressure / viscosity, and over modulus / viscosity."""


def compression_rate(scene: SoftScene, parameters: Parameters) -> float:
    """The rate of compression (1/s): the given one, or one so low that films bear little of the load. By default the
    viscous number eta rate / P is SLOW, with the requested pressure P; for a volume fraction, eta rate over the largest
    modulus is SLOWEST.
    """
    spec, viscosity = scene.preparation, parameters.contacts.viscosity
    if spec is None or spec.rate is not None:
        return math.inf if spec is None or spec.rate is None else spec.rate
    if spec.pressure is None:
        return SLOWEST * float(parameters.modulus.max()) / viscosity
    diameter = 2.0 * float(parameters.radius.mean()) if parameters.dimensions == 2 else 1.0
    return SLOW * spec.pressure / diameter / viscosity


def _weights(scene: SoftScene, radius: Array, counts: list[int]) -> Array:
    """Gravity minus buoyancy of each sphere (N)."""
    if scene.gravity is None:
        return np.zeros((len(radius), dimensions_of(scene)))
    liquid = material_of(scene.liquid).density
    heavier = np.array([(species.density or 0.0) - liquid for species in scene.particles])
    mass = np.repeat(heavier, counts) * 4.0 / 3.0 * math.pi * radius**3
    return np.asarray(mass[:, None] * np.array(scene.gravity))


def _torques(scene: SoftScene, radius: Array, counts: list[int]) -> Array:
    """The torque on each sphere, as a force at its equator (N); without components for spheres without spin."""
    width = 0 if not scene.rotation else 1 if dimensions_of(scene) == 2 else 3
    given = np.array([species.torque or (0.0,) * width for species in scene.particles]).reshape(len(counts), width)
    return np.asarray(np.repeat(given, counts, axis=0) / radius[:, None])


def _spans(protocol: Protocol, otherwise: float) -> list[float]:
    spans = [float(span) for span in np.diff(protocol.times) if span > 0.0]
    return spans or [otherwise]


def prefactors_of(films: FilmSpec) -> Prefactors:
    """The prefactors of the named set, with the changes of the scene."""
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
        smallest_separation=remote.smallest_separation,
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
    """The rows of the tables of laws that a scene names."""
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
    return _missing_permeability(scene) + [
        Fault(f"{path}.{name}", said)
        for needs in (laws.surface.needs, laws.friction.needs, laws.tension.needs)
        for name, said in needs.items()
        for path, given in holders[name]
        if getattr(given, name) is None
    ]


def _missing_permeability(scene: SoftScene) -> list[Fault]:
    """A fault if the permeability law needs a permeability that is missing, or does not use the given one."""
    if scene.permeation is None:
        return []
    row, given = PERMEABILITIES[scene.permeation.law], scene.permeation.permeability is not None
    if given and "permeability" not in row.needs:
        cause = f'{scene.permeation.law} computes it; expected none, or law = "constant"'
        return [Fault("permeation.permeability", cause)]
    return [Fault(f"permeation.{name}", said) for name, said in row.needs.items() if not given]


def _moduli(scene: SoftScene, radius: Array, counts: list[int]) -> Array:
    """The modulus of the material of each sphere; for bubbles the equivalent, surface tension over radius."""
    given = np.repeat([math.nan if one.modulus is None else one.modulus for one in scene.particles], counts)
    return np.where(np.isnan(given), material_of(scene.liquid).surface_tension / radius, given)


def radii_in(scene: SoftScene) -> Array:
    """The radius of each sphere (m), species by species."""
    species = enumerate(scene.particles)
    return np.concatenate([radii_of(one, one.number, (scene.seed, index)) for index, one in species])


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
        ("permeation.law", PERMEABILITIES, scene.permeation.law if scene.permeation else "constant", "permeability"),
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
