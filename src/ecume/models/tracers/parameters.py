"""Parameters, state and workspace of tracers, and what actions may change."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any, NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.engine.walls import Sheet, Surfaces, clearance, described, sheet
from ecume.errors import Fault, SceneError
from ecume.laws import brownian_motion, drag, gases, wall_drag
from ecume.models.actions import Access
from ecume.models.law_codes import code_of
from ecume.models.liquids import named_liquid
from ecume.models.step_counts import ending_on_a_step
from ecume.models.tracers.drag_laws import DRAGS, DragChoice
from ecume.models.tracers.liquid_flow import FlowScales, LiquidFlow, OwnFlow, varying_flow
from ecume.models.tracers.openings import Arrivals, Stream, arrivals_of, inflow_of
from ecume.models.tracers.place_diffusion import Surroundings
from ecume.models.tracers.tank import Periodic, bounds, coefficients_of, periodic_of, sticking_of, surfaces_of
from ecume.scenes.faults import suggestion
from ecume.scenes.sizes import radii_of
from ecume.scenes.tracers import FluidSpec, TracersScene
from ecume.units import Array

REGIMES = ("auto", "inertial", "overdamped")
ADDED_MASS = 0.5
"""The added mass of a sphere in an ideal liquid, over the displaced mass."""
SHORTEST = 4.0
"""Steps per relaxation time, with an automatic time step."""
LONGEST = 0.5
"""The longest step of the inertial regime, in relaxation times."""
MOST_STEPS = 50_000
"""The largest number of steps of a run with an automatic time step; particles that relax faster are overdamped."""
FINENESS = 0.05
"""The largest displacement of an overdamped step, over the tank or the sedimentation length."""


class Fluid(NamedTuple):
    """The liquid: its properties, and its velocity flow + shear_rate z, the shear along x at the height z."""

    density: float
    viscosity: float
    gravity: float
    thermal: float
    """kT (J); 0 without Brownian motion"""
    flow: tuple[float, float, float]
    shear_rate: float
    mean_free_path: float
    """m, of a gas; 0 of a liquid"""
    varies: bool = False
    """whether there is another flow, `Parameters.current`"""


class Bodies(NamedTuple):
    """The particles, one row each."""

    radius: Array
    mass: Array
    """kg, with the added mass"""
    apparent_gravity: Array
    """m/s^2, downwards: weight less buoyancy, over that mass"""
    friction: Array
    """N s/m, Stokes friction with the slip of gases"""
    settling: Array
    """m/s, downwards: the terminal speed"""
    overdamped: Integers
    """1 without inertia"""
    density: Array
    species: Integers
    sphericity: Array
    """the surface of the sphere of the same volume over that of the particle"""


class Forces(NamedTuple):
    """Flags, 1 or 0, of the forces of a liquid whose velocity varies."""

    acceleration: float = 0.0
    faxen: float = 0.0
    lift: float = 0.0

    @property
    def any(self) -> bool:
        """Whether any force acts."""
        return max(self) > 0.0


class Parameters(NamedTuple):
    """All constants of a time step."""

    time_step: float
    steps_per_frame: int
    seed: int
    dimensions: int
    drag: DragChoice
    fluid: Fluid
    bodies: Bodies
    """of the particles at the start, then of those that enter"""
    arrivals: Arrivals
    bouncing: Sheet
    """the walls and obstacles with their coefficients"""
    stopping: Sheet
    """the same without restitution: an overdamped particle that is driven against a wall stays there"""
    mirroring: Sheet
    """the same with full restitution: diffusion is reflected"""
    around: Any = ()
    """`place_diffusion.Surroundings` where the diffusivity depends on place; otherwise an empty tuple"""
    current: Any = ()
    """a flow that varies, `flow_loops.Current`; an empty tuple without one"""
    periodic: Periodic = Periodic((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    forces: Forces = Forces()
    """of a liquid whose velocity varies"""
    added_mass: bool = True
    deposits: int = 0
    """the number of sticking walls and obstacles, which are the last openings"""


def parameters_of(scene: TracersScene, own: OwnFlow | None = None) -> Parameters:
    """The parameters of a scene, with an optional user-defined flow. Raises SceneError for invalid scenes."""
    _require_names(scene)
    surfaces, fluid = surfaces_of(scene), fluid_of(scene)
    flow = varying_flow(scene, bounds(scene), own)
    fluid = fluid._replace(varies=flow.current != ())
    periodic = periodic_of(scene)
    _require_periodic(flow, bounds(scene), periodic, scene.duration)
    settling = np.array(
        [settling_speed(scene, fluid, (one.radius, one.density, one.sphericity)) for one in scene.particles]
    )
    stream = Stream(flow, np.where(np.isfinite(settling), settling, 0.0))
    inflow = inflow_of(scene, surfaces, stream)
    bodies = bodies_of(scene, fluid, inflow.species)
    step = time_step_of(scene, surfaces, fluid, bodies, flow.scales)
    late = np.where(bodies.friction > 0.0, bodies.mass / np.maximum(bodies.friction, 1e-300), math.inf) * LONGEST < step
    regime = scene.integration.integrator
    overdamped = (
        np.zeros(len(late), bool)
        if regime == "inertial"
        else (bodies.friction > 0.0) & (late | (regime == "overdamped"))
    )
    if regime == "inertial" and late.any():
        cause = f"{step:g} s is longer than half a relaxation time"
        cure = 'shorten it, or set integration.integrator = "auto"'
        raise SceneError([Fault("integration.time_step", f"{cause}; {cure}")])
    around = around_of(scene, surfaces)
    if scene.flow.turbulence is not None and not overdamped.all():
        message = 'acts on particles without inertia; set integration.integrator = "overdamped"'
        raise SceneError([Fault("flow.turbulence", message)])
    return Parameters(
        step,
        round(scene.frame_every / step),
        scene.seed,
        scene.dimensions,
        DragChoice(code_of(DRAGS, scene.hydrodynamics.drag), DRAGS[scene.hydrodynamics.drag].linear),
        fluid,
        bodies._replace(overdamped=overdamped.astype(np.int64)),
        arrivals_of(inflow, surfaces, bodies.radius[len(bodies.radius) - len(inflow.time) :], step),
        sheet(surfaces, *coefficients_of(scene)),
        sheet(surfaces, 0.0, 1.0),
        sheet(surfaces),
        around,
        flow.current,
        periodic,
        forces_of(scene),
        scene.hydrodynamics.added_mass,
        int(sticking_of(scene).sum()),
    )


def around_of(scene: TracersScene, surfaces: Surfaces) -> Any:
    """The walls and mixing on which the diffusivity depends; empty if it is uniform. Raises SceneError for unsuitable
    walls.
    """
    mixing, near = scene.flow.turbulence, scene.hydrodynamics.wall_drag
    if mixing is None and not near:
        return ()
    path = "hydrodynamics.wall_drag" if near else "flow.turbulence"
    tank, d = scene.tank, scene.dimensions
    faults = []
    if mixing is not None and near:
        faults.append(Fault(path, "got it beside flow.turbulence, which acts on far larger scales; expected one"))
    if tank is None or tank.high is None:
        raise SceneError([*faults, Fault(path, "needs a box: tank.high")])
    if near and scene.obstacles:
        faults.append(Fault(path, "got obstacles; the series holds for the walls of a box"))
    if not DRAGS[scene.hydrodynamics.drag].resists or fluid_of(scene).viscosity == 0.0:
        faults.append(Fault(path, "needs drag: hydrodynamics.drag and a liquid.viscosity above zero"))
    sides = periodic_of(scene).sides
    if mixing is not None and sides[d - 1] > 0.0 and len(set(mixing.diffusivities)) > 1:
        cause = "got the vertical axis, with a profile of flow.turbulence; expected walls, or one diffusivity"
        faults.append(Fault("tank.periodic", cause))
    walled = tuple(int(k < d and sides[k] == 0.0 and (near or k == d - 1)) for k in range(3))
    axes = [k for k in range(d) if sides[k] == 0.0] * 2
    across = {wall for wall, axis in enumerate(axes) if walled[axis]}
    if across & set(surfaces.hole.tolist()):
        faults.append(Fault(path, "got openings or sticking in walls toward which particles diffuse; expected none"))
    if faults:
        raise SceneError(faults)
    low, high = (*(tank.low or (0.0,) * d), 0.0)[:3], (*tank.high, 0.0)[:3]
    heights = np.array(mixing.heights if mixing is not None else (), float)
    spreads = np.array(mixing.diffusivities if mixing is not None else (), float)
    table = wall_drag.mobility_table() if near else np.zeros((2, 2))
    level = 0.0 if mixing is None else mixing.horizontal
    return Surroundings(low, high, walled, int(near), table, heights, spreads, level, ACCEPTING)  # type: ignore[arg-type]


ACCEPTING = 8
"""The first purpose of the random numbers that accept moves, see `counter_of`: three of them."""


def forces_of(scene: TracersScene) -> Forces:
    """The flags of the forces of a liquid whose velocity varies."""
    given = scene.hydrodynamics
    return Forces(float(given.fluid_acceleration), float(given.faxen), float(given.lift))


ALIKE = 1e-6
"""The largest difference of velocities on two periodic sides, over the largest speed."""


def _require_periodic(
    flow: LiquidFlow, box: tuple[tuple[float, ...], tuple[float, ...]], periodic: Periodic, duration: float
) -> None:
    """Raise SceneError if the velocities on both sides of a periodic axis differ."""
    if not periodic.any:
        return
    flow, (low, high) = flow.unbounded(), (np.array(corner, float) for corner in box)
    points = low + np.random.default_rng(0).uniform(size=(200, len(low))) * (high - low)
    times = flow.instants(duration)
    speed = max(np.abs(flow.velocity(points, time)).max() for time in times)
    for axis in range(len(low)):
        if periodic.sides[axis] > 0.0:
            here, there = points.copy(), points.copy()
            here[:, axis], there[:, axis] = low[axis], high[axis]
            off = max(float(np.abs(flow.velocity(here, t) - flow.velocity(there, t)).max()) for t in times)
            if off > ALIKE * speed:
                message = f"got {'xyz'[axis]}; the velocities of the liquid on its two sides differ by {off:.3g} m/s"
                raise SceneError([Fault("tank.periodic", f"{message}; expected the same")])


def fluid_of(scene: TracersScene) -> Fluid:
    """The properties of the liquid: given, or those of the named liquid at its temperature."""
    given = scene.liquid
    density, viscosity, path = medium_of(given)
    flow = (*(scene.flow.velocity or ()), 0.0, 0.0, 0.0)
    return Fluid(
        density if given.density is None else given.density,
        viscosity if given.viscosity is None else given.viscosity,
        scene.gravity,
        brownian_motion.thermal_energy(given.temperature) if scene.hydrodynamics.brownian else 0.0,
        (flow[0], flow[1], flow[2]),
        scene.flow.shear_rate,
        path if given.mean_free_path is None else given.mean_free_path,
    )


def medium_of(given: FluidSpec) -> tuple[float, float, float]:
    """Density, viscosity and mean free path of the named liquid or gas; the default is about that of water."""
    if given.name == AIR:
        density, viscosity = gases.air_density(given.temperature), gases.air_viscosity(given.temperature)
        return density, viscosity, gases.mean_free_path(density, viscosity, gases.ATMOSPHERE)
    named = named_liquid(given)
    return (1000.0, 1e-3, 0.0) if named is None else (named.density, named.viscosity, 0.0)


AIR = "air"


def bodies_of(scene: TracersScene, fluid: Fluid, inflow: Integers) -> Bodies:
    """Masses, weights, frictions and terminal speeds, species by species, followed by those of the entering
    particles.
    """
    counts = [species.count for species in scene.particles]
    kind = np.concatenate([np.repeat(np.arange(len(counts)), counts), inflow])
    # Only one evaluation per species if its particles are equal, since there may be millions.
    equal = not any(one.radii or one.sizes for one in scene.particles)
    radius, of = _radii(scene, kind, equal)
    density = np.array([one.density for one in scene.particles])[of]
    along = ADDED_MASS * fluid.density if scene.hydrodynamics.added_mass else 0.0
    sphericity = np.array([one.sphericity for one in scene.particles])[of]
    grains = zip(radius.tolist(), density.tolist(), sphericity.tolist(), strict=True)
    settling = np.array([settling_speed(scene, fluid, grain) for grain in grains])
    dragged = float(DRAGS[scene.hydrodynamics.drag].resists)
    slip = [drag.cunningham_factor(fluid.mean_free_path, a) for a in radius]
    friction = dragged * np.array([drag.stokes_friction(a, fluid.viscosity, 1.0) for a in radius]) / slip
    species, kind = kind, kind if equal else np.arange(len(kind))
    return Bodies(
        radius=radius[kind],
        mass=(4.0 / 3.0 * math.pi * radius**3 * (density + along))[kind],
        apparent_gravity=(fluid.gravity * (density - fluid.density) / (density + along))[kind],
        friction=friction[kind],
        settling=settling[kind],
        overdamped=np.zeros(len(kind), np.int64),
        density=density[kind],
        species=species,
        sphericity=sphericity[kind],
    )


def _radii(scene: TracersScene, kind: Integers, equal: bool) -> tuple[Array, Integers]:
    """The radius of each species if its particles are equal, otherwise that of each particle; and
    the species of each.
    """
    if equal:
        return np.array([species.radius for species in scene.particles]), np.arange(len(scene.particles))
    radius = np.zeros(len(kind))
    first = sum(species.count for species in scene.particles)
    for index, species in enumerate(scene.particles):
        own = np.flatnonzero(kind == index)
        enter = own[own >= first]
        radius[own[own < first]] = radii_of(species, species.count, (scene.seed, index))
        radius[enter] = species.radius
        if species.sizes is not None and len(enter):
            radius[enter] = radii_of(species, len(enter), (scene.seed, index))
    return radius, kind


def settling_speed(scene: TracersScene, fluid: Fluid, grain: tuple[float, float, float]) -> float:
    """The terminal speed (m/s), downwards, for a radius, density and sphericity; infinite without drag."""
    radius, excess = grain[0], grain[1] - fluid.density
    law = DRAGS[scene.hydrodynamics.drag]
    if not law.resists or fluid.viscosity == 0.0:
        return math.copysign(math.inf, excess) if excess and fluid.gravity else 0.0
    slow = drag.stokes_settling_speed(radius, excess, fluid.viscosity, fluid.gravity)
    slow *= drag.cunningham_factor(fluid.mean_free_path, radius)
    if law.linear or slow == 0.0:
        return slow
    reynolds = drag.particle_reynolds(abs(slow), radius, fluid.density, fluid.viscosity)
    return slow * law.settling_reynolds(reynolds, grain[2]) / reynolds


def time_step_of(scene: TracersScene, surfaces: Surfaces, fluid: Fluid, bodies: Bodies, scales: FlowScales) -> float:
    """The time step (s): as given, or limited by relaxation and walls. A frame is a whole number of steps."""
    asked, crossing = scene.integration.time_step, crossing_time(scene, fluid, bodies, scales)
    if asked is not None:
        if asked > crossing:
            message = (
                f"got {asked:g} s; expected at most {crossing:.3g} s, in which particles may cross the periodic box"
            )
            raise SceneError([Fault("integration.time_step", f"{message}: they would pass through obstacles")])
        steps = scene.frame_every / asked
        if abs(steps - round(steps)) > 1e-9 * steps or round(steps) < 1:
            fits = scene.frame_every / max(1, math.ceil(steps))
            message = f"got {asked:g} s; frame_every ({scene.frame_every:g} s) is not a multiple of it"
            raise SceneError([Fault("integration.time_step", f"{message}; {fits:.9g} s would fit")])
        return scene.frame_every / round(steps)
    longest = min(
        scene.frame_every, 0.1 / abs(fluid.shear_rate) if fluid.shear_rate else math.inf, scales.longest_step()
    )
    frames = scene.frames
    shortest = 0.0 if scene.integration.integrator == "inertial" else scene.frame_every / max(1, MOST_STEPS // frames)
    for mass, friction, speed, gravity, radius in kinds_of(bodies):
        if friction > 0.0:
            # Particles with more than Stokes drag relax faster.
            inertial = min(mass / friction, abs(speed / gravity) if gravity and speed else math.inf) / SHORTEST
            late = scene.integration.integrator == "overdamped" or inertial < shortest
            body = (friction, speed, mass * gravity, radius)
            longest = min(longest, overdamped_step(scene, body, surfaces, fluid) if late else inertial)
            if fluid.thermal > 0.0:
                longest = min(longest, scales.longest_diffusion(brownian_motion.diffusivity(fluid.thermal, friction)))
    longest = min(max(longest, shortest), 0.5 * crossing)
    steps = math.ceil(scene.frame_every / longest * (1 - 1e-12))
    return scene.frame_every / ending_on_a_step(scene, steps)


def crossing_time(scene: TracersScene, fluid: Fluid, bodies: Bodies, scales: FlowScales) -> float:
    """The shortest time (s) in which a particle may cross a periodic box with obstacles, whose copies exist only in
    adjacent boxes; infinite in other scenes.
    """
    sides, (low, high) = periodic_of(scene).sides[: scene.dimensions], bounds(scene)
    if not (max(sides) > 0.0 and scene.obstacles):
        return math.inf
    given = [each for species in scene.particles for each in (species.velocity, *species.velocities)]
    given += [hole.velocity for hole in scene.openings]
    first = max((math.hypot(*each) for each in given if each is not None), default=0.0)
    sheared = abs(fluid.shear_rate) * max(abs(low[-1]), abs(high[-1]))
    dragged, pull = bodies.friction > 0.0, float(np.abs(bodies.apparent_gravity).max())
    fall = float(np.abs(bodies.settling[dragged]).max(initial=0.0))
    if not dragged.all():
        fall = pull * scene.duration if sides[-1] > 0.0 else math.sqrt(2.0 * pull * (high[-1] - low[-1]))
    fastest = first + max(scales.speed, math.hypot(*fluid.flow) + sheared) + fall
    return min(side for side in sides if side > 0.0) / fastest if fastest > 0.0 else math.inf


def kinds_of(bodies: Bodies) -> set[tuple[float, ...]]:
    """Mass, friction, terminal speed, apparent gravity and radius of representative particles of each species."""
    columns = (bodies.mass, bodies.friction, bodies.settling, bodies.apparent_gravity, bodies.radius)
    first = np.flatnonzero(np.diff(bodies.species, prepend=-1))  # the first particle of each block of one species
    for species in np.unique(bodies.species):  # also its smallest and largest particle
        own = np.flatnonzero(bodies.species == species)
        first = np.append(first, [own[np.argmin(bodies.radius[own])], own[np.argmax(bodies.radius[own])]])
    return set(zip(*(column[first].tolist() for column in columns), strict=True))


def place_limit(scene: TracersScene, body: tuple[float, float, float, float], fluid: Fluid) -> float:
    """The longest step where the diffusivity depends on position: within it, settling and diffusion move a particle by
    a fraction of the length over which the diffusivity changes, which near walls is the radius.
    """
    friction, speed, _, radius = body
    mixing, limit = scene.flow.turbulence, math.inf
    if scene.hydrodynamics.wall_drag:
        limit = NEAR * radius / abs(speed) if speed else math.inf
        if fluid.thermal > 0.0:
            spread = brownian_motion.diffusivity(fluid.thermal, friction)
            limit = min(limit, 0.5 * (NEAR * radius) ** 2 / spread)
    if mixing is not None:
        spreads, heights = np.array(mixing.diffusivities), np.array(mixing.heights)
        largest = float(spreads.max())
        slope = float(np.abs(np.diff(spreads) / np.diff(heights)).max(initial=0.0))
        low, high = bounds(scene)
        room = high[-1] - low[-1]
        limit = min(limit, 0.5 * (NEAR * room) ** 2 / largest if largest else math.inf)
        limit = min(limit, NEAR * room / slope if slope else math.inf)
    return limit


NEAR = 0.2
"""The longest displacement of a step, over the length in which the diffusivity changes."""


def overdamped_step(
    scene: TracersScene, body: tuple[float, float, float, float], surfaces: Surfaces, fluid: Fluid
) -> float:
    """The longest step of tracers without inertia: they cross a small part of the tank or of the sediment layer."""
    friction, speed, weight, radius = body
    sizes = surfaces.size
    room = float(np.ptp(sizes) if len(sizes) > 1 else np.abs(sizes).sum() or math.inf)
    layer = room
    if fluid.thermal > 0.0 and weight != 0.0:
        # A sedimentation length below the radius means that particles are at rest on the floor.
        layer = min(room, max(radius, brownian_motion.sedimentation_length(fluid.thermal, abs(weight))))
    limit = FINENESS * room / abs(speed) if speed else math.inf
    limit = min(limit, place_limit(scene, body, fluid))
    if fluid.thermal > 0.0:
        limit = min(limit, FINENESS * layer * layer / brownian_motion.diffusivity(fluid.thermal, friction))
    return limit


def _require_names(scene: TracersScene) -> None:
    faults = []
    tables: tuple[tuple[str, str, Collection[str]], ...] = (
        ("hydrodynamics.drag", scene.hydrodynamics.drag, DRAGS),
        ("integration.integrator", scene.integration.integrator, REGIMES),
    )
    for path, name, known in tables:
        if name not in known:
            faults.append(Fault(path, f"got {name!r}; {suggestion(name, known)}"))
    drag = scene.hydrodynamics.drag
    if scene.hydrodynamics.brownian and drag in DRAGS and not DRAGS[drag].resists:
        faults.append(Fault("hydrodynamics.brownian", "needs drag: what the liquid kicks, it also slows down"))
    for k, species in enumerate(scene.particles):
        if species.sphericity != 1.0 and drag in DRAGS and not DRAGS[drag].shaped:
            usable = " or ".join(name for name, row in DRAGS.items() if row.shaped)
            message = f"is not used by the drag law {drag}; set hydrodynamics.drag to {usable}"
            faults.append(Fault(f"particles[{k}].sphericity", message))
    if faults:
        raise SceneError(faults)


CAPPED = 0
"""The index in `State.tally` of flights with too many bounces."""


class State(NamedTuple):
    """All arrays that can change a later result; random numbers follow from the seed, the particle and the step."""

    position: Array
    """(N, d) m"""
    velocity: Array
    """(N, d) m/s"""
    step: Integers
    """(1,)"""
    left: Integers
    """(N,) the opening through which a particle left, or -1"""
    hits: Integers
    """(K,) number of collisions with each wall"""
    tally: Integers
    """(1,) flights with more bounces than a step may have"""
    work: Array = np.zeros(1)
    """(1,) J of work from outside: see `energy_budget`"""
    image: Integers = np.zeros((0, 2), np.int64)
    """(N, d) the periods by which each particle has been wrapped along each axis; (0, 2) without periodic axes"""


class Workspace(NamedTuple):
    """Scratch arrays of a step."""

    origin: Array
    """(N, d) previous positions"""
    travel: Array
    """(N, d) the initial velocity of the step"""
    acceleration: Array
    """(N, d) the acceleration of the parabola that has the exact final position"""
    kick: Array
    """(N, d) the exact final velocity minus that of the parabola, without collisions"""
    noise: Array
    """(N, d) the thermal part of `kick`"""
    shift: Array
    """(N, d) the thermal part of the displacement; without inertia that by the drift"""
    external: Array
    """(N, d) m/s^2: the acceleration by laws of the user"""
    flow: Array
    """(N, d) m/s: the velocity of the liquid, in the middle of a step or its mean along the path"""
    hindrance: Array
    """(N, d) the friction along each axis over that without walls; (0, d) without drag near walls"""
    radius: Array
    hits: Integers
    """(N,)"""
    status: Integers
    """(N,)"""


def make_state(position: Array, velocity: Array, surfaces: int, periodic: Periodic) -> State:
    """The state at time 0."""
    count, shape = len(position), position.shape
    image = np.zeros(shape if periodic.any else (0, 2), np.int64)
    return State(
        np.ascontiguousarray(position),
        np.ascontiguousarray(velocity),
        np.zeros(1, np.int64),
        np.full(count, -1, np.int64),
        np.zeros(surfaces, np.int64),
        np.zeros(1, np.int64),
        np.zeros(1),
        image,
    )


def entered_count(parameters: Parameters, state: State) -> int:
    """The number of particles that have entered."""
    return len(state.position) - (len(parameters.bodies.radius) - len(parameters.arrivals.step))


def workspace(parameters: Parameters, state: State, room: float) -> Workspace:
    """Scratch arrays for the present particles; `room` is not used, since they cannot overflow."""
    count, shape = len(state.position), state.position.shape
    a, b, c, d, e, f, g, k = (np.zeros(shape) for _ in range(8))
    radius = np.ascontiguousarray(parameters.bodies.radius[:count])
    near = parameters.around != () and parameters.around.near_walls
    hindrance = np.zeros((count if near else 0, shape[1]))
    return Workspace(a, b, c, d, e, f, g, k, hindrance, radius, np.zeros(count, np.int64), np.zeros(count, np.int64))


TOUCHING = 1e-6
"""The permitted overlap of touching tracers with a wall, over the radius."""


def faults(scene: TracersScene, parameters: Parameters, state: State) -> list[str]:
    """Messages on tracers that are outside of the tank without having left through an opening."""
    surfaces, radius = surfaces_of(scene), parameters.bodies.radius[: len(state.position)]
    if not len(surfaces.kind):
        return []
    clear, which = clearance(state.position, surfaces)
    beyond = np.flatnonzero((clear < radius * (1.0 - TOUCHING)) & (state.left < 0))
    return [
        f"particle {i} is {radius[i] - clear[i]:.3g} m beyond {described(surfaces, int(which[i]))}; "
        "expected a position inside, its radius included"
        for i in beyond
    ]


def place(parameters: Parameters, state: State, position: Array) -> None:
    """Set the positions. Positions outside the periodic box are replaced by those of the images inside, with the
    numbers of the images.
    """
    d, periodic = position.shape[1], parameters.periodic
    sides = np.array(periodic.sides[:d])
    away = np.floor(np.divide(position - periodic.low[:d], sides, out=np.zeros_like(position), where=sides > 0.0))
    state.position[...] = position - away * sides
    if len(state.image):
        state.image[...] = away


TRACERS = Access(
    arrays=lambda state: {"position": state.position, "velocity": state.velocity},
    faults=faults,
    work=lambda state: state.work,
    sides=lambda parameters: np.array(parameters.periodic.sides),
    place=place,
)
