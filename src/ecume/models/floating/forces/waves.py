"""Floats that oscillate vertically: mean forces and torques by the waves of other floats.

Each float has points that press on the liquid, fixed in the frame of the float. The table contains the slope of the
wave of a unit force times the distance; this product is smooth at small distances.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecume._jit import admit, compiled, compiled_inside
from ecume.engine.cells import Integers
from ecume.engine.neighbors import NeighborLists
from ecume.engine.philox import counter_of, normals
from ecume.engine.walls.surfaces import farthest
from ecume.errors import BadInput
from ecume.laws import brownian_motion, radiated_waves
from ecume.laws.brownian_motion import diffusivity
from ecume.laws.radiated_waves import Ripples, slope_per_force
from ecume.models.floating.contacts.collisions import float_inertia
from ecume.models.floating.forces.activity import HEADINGS
from ecume.models.floating.options import Built, scene_error
from ecume.models.floating.parameters import WORK, Parameters, State, Workspace
from ecume.models.floating.setup.kinds import distinct_kinds, turning_frictions
from ecume.models.floating.time_integration.step_size import RAFT_NEIGHBORS
from ecume.models.liquids import is_under_liquid, liquid_of
from ecume.units import Array, with_prefix

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene

admit(brownian_motion)

PER_WAVELENGTH = 64
"""Nodes of the table."""
MOST_WAVELENGTHS = 400.0
"""Length of the table, in wavelengths, at most."""
STEEP = 0.3
"""Wavenumber times amplitude above which waves are not small."""
CLOSEST, SHALLOW = 1.0 / 16.0, 0.25
"""The distance of two sources at the rims of their floats, in wavelengths or radii, down to which the time step
resolves their force; that of other sources is at least their gap at contact.
"""


class Waves(NamedTuple):
    """Constants of floats that oscillate."""

    owner: Integers
    """(M,) the float of each source"""
    place: Array
    """(M, 2) m, in the frame of the float"""
    press: Array
    """(M, 2) N: real and imaginary part of the force on the liquid"""
    table: Array
    """(2, K) m/N: real and imaginary part of distance times slope"""
    spacing: float
    """m, of the table"""
    inertia: Array
    """(N,) kg m^2"""
    friction: Array
    """(N,) N m s, against turning"""
    wavelength: float
    """m"""
    decay_length: float
    """m"""
    steepness: float
    """the largest wavenumber times amplitude, one wavelength from a source"""
    advances_angles: bool
    """whether neither contacts with friction nor the kicks of bodies advance the angles"""
    kicks: bool
    """whether the waves kick the spins; those of floats with a shape are in the kicks of bodies"""


class WavesScratch(NamedTuple):
    """Arrays of the state, and forces and torques."""

    turning: Array
    active: Array
    spot: Array
    """(M, 2) m: where the sources are"""
    force: Array
    """(N, 2) N"""
    torque: Array
    """(N,) N m"""
    on_bodies: Array
    """(N,) N m: the torques of the workspace"""
    before: Array
    """(N, 6) force and torque at the start of the step, the way in the step, the angle at its start"""


def make_waves_scratch(part: Waves, parameters: Parameters, state: State, workspace: Workspace) -> WavesScratch:
    """Return the workspace."""
    count = len(state.position)
    spots, zeros = np.zeros((len(part.owner), 2)), np.zeros
    forces = zeros((count, 2)), zeros(count), workspace.torque
    return WavesScratch(state.turning, state.active, spots, *forces, zeros((count, 6)))


def with_headings(part: Waves, state: State) -> State:
    """Return the state with the headings of propulsion along the headings of the floats."""
    active = state.active.copy()
    active[:, 2] = 0.0
    return state._replace(active=active)


@compiled_inside
def tabled(table: Array, place: float) -> tuple[float, float]:
    """The complex number at a place of the table (in nodes), by cubic interpolation; zero beyond its end."""
    nodes = table.shape[1]
    first = min(max(int(place) - 1, 0), nodes - 4)
    s = place - first
    if s > 3.0:
        return 0.0, 0.0
    a, b, c = s - 1.0, s - 2.0, s - 3.0
    w0, w1, w2, w3 = -a * b * c / 6.0, 0.5 * s * b * c, -0.5 * s * a * c, s * a * b / 6.0
    real = w0 * table[0, first] + w1 * table[0, first + 1] + w2 * table[0, first + 2] + w3 * table[0, first + 3]
    imaginary = w0 * table[1, first] + w1 * table[1, first + 1] + w2 * table[1, first + 2] + w3 * table[1, first + 3]
    return real, imaginary


@compiled
def wave_forces(
    part: Waves, scratch: WavesScratch, parameters: Parameters, position: Array, lists: NeighborLists, force: Array
) -> None:
    """Add the mean forces by waves, and store the torques: of each pair of sources on different floats."""
    owner, place, press, table, spot = part.owner, part.place, part.press, part.table, scratch.spot
    for i in range(len(scratch.torque)):
        scratch.force[i, 0], scratch.force[i, 1], scratch.torque[i] = 0.0, 0.0, 0.0
    for a in range(len(owner)):
        i = owner[a]
        angle = scratch.turning[i, 0] + (scratch.active[i, 2] if len(scratch.active) > 0 else 0.0)
        c, s = math.cos(angle), math.sin(angle)
        spot[a, 0] = position[i, 0] + c * place[a, 0] - s * place[a, 1]
        spot[a, 1] = position[i, 1] + s * place[a, 0] + c * place[a, 1]
    for a in range(len(owner)):
        i = owner[a]
        for b in range(a + 1, len(owner)):
            j = owner[b]
            if i == j:
                continue
            x, y = spot[b, 0] - spot[a, 0], spot[b, 1] - spot[a, 1]
            square = x * x + y * y
            if square == 0.0:
                continue
            real, imaginary = tabled(table, math.sqrt(square) / part.spacing)
            # conj(F_b) F_a; the table contains distance times slope, x and y are distance times direction.
            along = (press[b, 0] * press[a, 0] + press[b, 1] * press[a, 1]) * real / square
            across = (press[b, 0] * press[a, 1] - press[b, 1] * press[a, 0]) * imaginary / square
            push, back = -0.5 * (along - across), 0.5 * (along + across)
            add_at(scratch, j, spot[b, 0] - position[j, 0], spot[b, 1] - position[j, 1], push * x, push * y)
            add_at(scratch, i, spot[a, 0] - position[i, 0], spot[a, 1] - position[i, 1], back * x, back * y)
    for i in range(len(scratch.torque)):
        force[i, 0] += scratch.force[i, 0]
        force[i, 1] += scratch.force[i, 1]
        if not part.kicks:
            scratch.on_bodies[i] += scratch.torque[i]


@compiled_inside
def add_at(scratch: WavesScratch, i: int, arm_x: float, arm_y: float, x: float, y: float) -> None:
    """Add a force (x, y) on float i at a point away from its center."""
    scratch.force[i, 0] += x
    scratch.force[i, 1] += y
    scratch.torque[i] += arm_x * y - arm_y * x


@compiled
def kick_wave_spins(part: Waves, scratch: WavesScratch, parameters: Parameters, state: State, first: bool) -> None:
    """Apply half a kick to the spins, solved exactly with drag. After the first half, advance angles unless contacts
    do so; after the second, add the work of the step by the mean of the forces at both ends.
    """
    time, count = parameters.time_step, len(scratch.torque)
    for i in range(count if part.kicks else 0):
        friction, inertia, spin = part.friction[i], part.inertia[i], scratch.turning[i, 1]
        if parameters.scheme.inertia:
            rate = 0.5 * time * friction / inertia
            held = -math.expm1(-rate) / rate if rate > 0.0 else 1.0
            scratch.turning[i, 1] = math.exp(-rate) * spin + held * 0.5 * time * scratch.torque[i] / inertia
        else:
            scratch.turning[i, 1] = scratch.torque[i] / friction
    before = scratch.before
    if first:
        for i in range(count):
            before[i, 0], before[i, 1], before[i, 2] = scratch.force[i, 0], scratch.force[i, 1], scratch.torque[i]
            before[i, 5] = scratch.turning[i, 0]
            scratch.turning[i, 0] += time * scratch.turning[i, 1] if part.advances_angles else 0.0
        # The headings of active floats diffuse already.
        if parameters.drift.thermal > 0.0 and len(scratch.active) == 0 and part.kicks:
            turn_by_noise(part, scratch, parameters, int(state.step[0]))
        return
    work = 0.0
    for i in range(count):
        work += 0.5 * (before[i, 0] + scratch.force[i, 0]) * before[i, 3]
        work += 0.5 * (before[i, 1] + scratch.force[i, 1]) * before[i, 4]
        # The heat of noise on the angle is minus the work of the torque.
        if not parameters.drift.thermal > 0.0:
            work += 0.5 * (before[i, 2] + scratch.torque[i]) * (scratch.turning[i, 0] - before[i, 5])
    state.tally[WORK] += work


@compiled
def keep_ways(part: Waves, scratch: WavesScratch, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Store the ways of all floats in a step, without the removal of overlaps after it, which does no work."""
    for i in range(len(scratch.torque)):
        for axis in range(2):
            scratch.before[i, 3 + axis] = parameters.time_step * workspace.midstep_velocity[i, axis]


@compiled
def turn_by_noise(part: Waves, scratch: WavesScratch, parameters: Parameters, step: int) -> None:
    """Rotate each float by a normally distributed angle of variance 2 kT/zeta dt, with the rotational friction zeta."""
    for i in range(len(scratch.torque)):
        far = math.sqrt(2.0 * diffusivity(parameters.drift.thermal, part.friction[i]) * parameters.time_step)
        scratch.turning[i, 0] += far * normals(counter_of(i, step, HEADINGS), parameters.drift.seed)[0]


def no_wave_energy(
    part: Waves, scratch: WavesScratch, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """Return zero: forces by waves have no potential."""
    return 0.0, 0.0


def waves_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """Return the waves of a scene."""
    given, radius = scene.waves, parameters.floats.radius
    assert given is not None  # noqa: S101  # for the type checker: the scene has chosen it
    liquid = liquid_of(scene)
    if is_under_liquid(liquid):
        message = (
            f"got waves under {liquid.gas_density:g} kg/m^3; expected a gas: the law of these waves has the "
            "inertia and viscosity of the lower liquid alone"
        )
        raise scene_error("waves", message)
    try:
        found = radiated_waves.ripples(
            given.frequency, liquid.density, liquid.surface_tension, liquid.viscosity, scene.gravity
        )
    except BadInput as error:
        raise scene_error("waves.frequency", str(error)) from None
    _require_headings(scene)
    owner, place, press = _sources(parameters, scene)
    kinds, number = distinct_kinds(scene)
    inertia = np.array([kind.figure.inertia if scene.shaped else float_inertia(kind) for kind in kinds])[number]
    friction = turning_frictions(scene)
    if scene.shaped:
        friction = np.array([kind.figure.friction[2] for kind in kinds])[number]
    table, spacing = _table(found, parameters, scene)
    strongest = float(np.max(np.bincount(owner, np.hypot(*press.T))))
    part = Waves(
        owner, place, press, table, spacing, inertia, friction, found.wavelength, found.decay_length,
        radiated_waves.steepness(float(np.hypot(*press.T).max()), found),
        not (scene.rubs or scene.shaped), not scene.shaped,
    )  # fmt: skip
    arm = float(np.hypot(*place.T).max())
    smallest = float(radius[owner].min())
    gap = max(2.0 * (smallest - arm), min(CLOSEST * found.wavelength, SHALLOW * smallest))
    return Built(part, _quickest(parameters, part, strongest, arm, gap))


def _sources(parameters: Parameters, scene: FloatingScene) -> tuple[Integers, Array, Array]:
    """The sources of all floats, float by float."""
    given, floats = scene.waves, parameters.floats
    assert given is not None  # noqa: S101  # for the type checker: the scene has chosen it
    names = [name for name, *_ in scene.kinds]
    owner, place, press = [], [], []
    for index, source in enumerate(given.sources):
        if source.species and source.species not in names:
            raise scene_error(
                f"waves.sources[{index}].species",
                f"got {source.species!r}; expected one of {', '.join(map(repr, names))}",
            )
        for i, kind in enumerate(floats.species):
            if source.species in ("", names[kind]):
                if math.hypot(*source.place) > floats.radius[i]:
                    far, path = math.hypot(*source.place), f"waves.sources[{index}].place"
                    raise scene_error(
                        path, f"is {far:g} m from the center; expected at most the radius, {floats.radius[i]:g} m"
                    )
                owner.append(i)
                place.append(source.place)
                press.append((source.force * math.cos(source.phase), source.force * math.sin(source.phase)))
    order = np.argsort(owner, kind="stable")
    return np.array(owner, np.int64)[order], np.array(place, np.float64)[order], np.array(press, np.float64)[order]


def _require_headings(scene: FloatingScene) -> None:
    """Raise SceneError unless each float has a heading, or none has."""
    given, count = scene.waves.headings if scene.waves is not None else (), sum(one.count for one in scene.given)
    if given and len(given) != count:
        raise scene_error("waves.headings", f"got {len(given)} headings; expected one for each of {count} floats")


def _table(found: Ripples, parameters: Parameters, scene: FloatingScene) -> tuple[Array, float]:
    """The table of distance times slope at equal distances, and its spacing. It ends where viscosity has reduced the
    slope to `interaction.accuracy` of that at one wavelength, or at the size of the dish.
    """
    far = found.wavelength + found.decay_length * math.log(1.0 / scene.interaction.accuracy)
    spacing = found.wavelength / PER_WAVELENGTH
    far = min(far, MOST_WAVELENGTHS * found.wavelength)
    walls = parameters.walls
    across = 2.0 * farthest(walls)
    far = min(far, across + 4.0 * spacing)
    given, liquid = scene.waves, liquid_of(scene)
    assert given is not None  # noqa: S101  # for the type checker: the scene has chosen it
    nodes = max(math.ceil(far / spacing), 8)
    table = _slopes(given.frequency, liquid.density, liquid.surface_tension, liquid.viscosity, scene.gravity, nodes)
    return table.copy(), spacing


@lru_cache(maxsize=8)
def _slopes(
    frequency: float, density: float, surface_tension: float, viscosity: float, gravity: float, nodes: int
) -> Array:
    """The table with this number of nodes. Computing it takes a second, once for all scenes with the same waves."""
    found = radiated_waves.ripples(frequency, density, surface_tension, viscosity, gravity)
    spacing = found.wavelength / PER_WAVELENGTH
    distance = np.asarray(spacing * np.arange(nodes), np.float64)
    distance[0] = 1e-3 * spacing
    slope = distance * slope_per_force(distance, found)
    return np.ascontiguousarray([slope.real, slope.imag])


def _quickest(parameters: Parameters, part: Waves, strongest: float, arm: float, gap: float) -> float:
    """The shortest time scale of floats in the waves of their neighbors, for distances of sources from `gap` on."""
    floats = parameters.floats
    distance = np.maximum(part.spacing * np.arange(part.table.shape[1]), gap)
    slope = float(np.max(np.hypot(*part.table) / distance))
    curvature = max(2.0 * math.pi / part.wavelength, 1.0 / gap) * slope
    spring = RAFT_NEIGHBORS * 0.5 * strongest**2 * curvature
    turned = np.unique(part.owner)
    if not parameters.scheme.inertia:
        friction = floats.mass / floats.relaxation_time
        times = [friction / spring, part.friction[turned] / (spring * max(arm, 1e-30) ** 2)]
    else:
        times = [np.sqrt(floats.mass / spring), np.sqrt(part.inertia[turned] / (spring * max(arm, 1e-30) ** 2))]
    return min(float(np.min(each)) for each in times)


def wave_lines(part: Waves, parameters: Parameters) -> list[tuple[str, str, str]]:
    """Lines of `ecume check`: the wave, its range, and whether it is small."""
    small = "small" if part.steepness <= STEEP else f"not small: the theory needs less than {STEEP:g}"
    sizes = 2.0 * parameters.floats.radius.max() / part.wavelength
    return [
        ("waves", with_prefix(part.wavelength, "m"), f"wavelength; the widest float has {sizes:.2g} wavelengths"),
        ("range of waves", with_prefix(part.decay_length, "m"), "viscosity reduces their amplitude by e"),
        ("steepness of waves", f"{part.steepness:.2g}", f"slope one wavelength from a source: {small}"),
    ]
