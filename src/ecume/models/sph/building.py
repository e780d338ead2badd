"""From a scene to parameters: the material, the walls, the liquid's particles, the time step."""

from __future__ import annotations

import math
from typing import Any, cast

import numpy as np

from ecume.engine.shapes import Box, Part, apart, lattice_in
from ecume.errors import Fault, SceneError
from ecume.laws.enthalpy import density_at_enthalpy
from ecume.laws.kernels import KERNEL_CODES, Kernel, kernel
from ecume.laws.pace import tension_limit
from ecume.laws.tension import laplace_pressure
from ecume.models.sph.bodies import bodies_of
from ecume.models.sph.boundaries import boundary_of
from ecume.models.sph.carried import carried_of
from ecume.models.sph.fields import (
    ALPHA,
    CHOICES,
    DELTA,
    DIFFUSION,
    DIMENSION,
    FRICTION,
    G0,
    INVERSE,
    KERNEL,
    LAMINAR,
    NO_FRICTION,
    NUMBERS,
    ONE,
    RADIAL,
    REFERENCE,
    SCALE,
    SHARE,
    SOFT,
    SOUND,
    STRESS,
    H,
)
from ecume.models.sph.gates import bounds_of, gates_of
from ecume.models.sph.gauges import gauges_of
from ecume.models.sph.motions import drives_of, fastest_drive, shake_of
from ecume.models.sph.parameters import INTEGRATORS, SHIFTINGS, TENSIONS, Liquid, Material, Parameters
from ecume.models.sph.solids import free_of, part_of, solids_of
from ecume.models.sph.starting import pressure_in, velocity_in
from ecume.models.sph.substances import filled
from ecume.models.sph.tables import Said, said_of, with_said
from ecume.scenes.faults import suggestion
from ecume.scenes.sph import SphScene
from ecume.units import Array

TURBULENCES = ("none", "smagorinsky")
NUMERICAL_MACH = 0.1
COHESIVE = 6.0
"""A quarter of the pressure inside that cohesion calls up, in tensions over supports."""
SMOOTHING = {
    "wendland-c2": (2.0, 1.6),
    "wendland-c4": (2.0, 1.8),
    "wendland-c6": (2.2, 2.0),
    "quintic-spline": (1.3, 1.2),
    "quartic-spline": (1.3, 1.2),
    "lucy": (2.6, 2.4),
}
"""Smoothing lengths in spacings that suit a kernel, in two and in three dimensions; 1.3 and 1.2 for all others."""
DIFFUSIONS = ("none", "molteni", "antuono", "linear", "hydrostatic")
FRICTIONS = ("morris", "monaghan")
STRESSES = ("sum", "monaghan", "transport")
PRECISIONS: dict[str, type[np.floating[Any]]] = {"double": np.float64, "single": np.float32}
USUAL_ALPHA = 0.02
"""Of the artificial viscosity, where the liquid has none of its own."""


def chosen(name: str, names: Any, path: str) -> str:
    """A law's name, if there is such a law."""
    if name not in names:
        wanted = ", ".join(names)
        raise SceneError([Fault(path, f"came {name!r}; wanted one of {wanted}; {suggestion(name, names)}")])
    return name


def kernel_of(scene: SphScene) -> Kernel:
    """The scene's kernel in its dimension."""
    return kernel(chosen(scene.method.kernel, tuple(KERNEL_CODES), "method.kernel"), dim=len(scene.tank.low))


def smoothing_of(scene: SphScene) -> float:
    """The smoothing length (m)."""
    given = scene.method.smoothing
    usual = SMOOTHING.get(scene.method.kernel, (1.3, 1.2))[len(scene.tank.low) - 2]
    return scene.spacing * (usual if given is None else given)


def gravity_of(scene: SphScene) -> Array:
    """(d,) m/s^2."""
    return np.array(scene.gravity, dtype=np.float64)


def held_pull(scene: SphScene) -> Array:
    """(d,) the part of gravity that pressure balances at rest: none along periodic sides, where all flows on and on."""
    pull = gravity_of(scene)
    for number, side in enumerate(sides_of(scene)):
        if side.kind == "periodic":
            pull[number // 2] = 0.0
    return pull


def material_of(scene: SphScene) -> Material:
    """The liquid, with a sound speed for the numerics."""
    given = filled(scene.liquid)
    fastest = given.fastest or fastest_of(scene)
    sound = given.sound_speed or fastest / NUMERICAL_MACH
    return Material(
        density=given.density or 0.0,
        sound_speed=sound,
        exponent=given.exponent,
        viscosity=given.viscosity or 0.0,
        surface_tension=given.surface_tension or 0.0,
        atmospheric_pressure=given.atmospheric_pressure,
        fastest=fastest,
    )


def fastest_of(scene: SphScene) -> float:
    """The fastest speed to be expected: of what moves at the start, and of a free fall through the liquid's depth."""
    pull = gravity_of(scene)
    bounds = [part_of(region, scene.spacing).bounds() for region in scene.fluid]
    low, high = np.min([b[0] for b in bounds], axis=0), np.max([b[1] for b in bounds], axis=0)
    depth = float(np.abs(pull) @ (high - low))
    speeds = [math.sqrt(2.0 * depth)]
    for region in scene.fluid:
        points = np.stack(part_of(region, scene.spacing).bounds())
        speeds.append(float(np.linalg.norm(velocity_in(region, scene, points), axis=1).max()))
        speeds.append(region.flow_speed if region.flow else 0.0)
    speeds += [math.hypot(*side.velocity) for side in sides_of(scene) if side.velocity]
    speeds += [math.hypot(*body.velocity) for body in scene.bodies if body.velocity]
    speeds += [1.5 * side.speed for side in sides_of(scene) if side.speed]
    speeds.append(fastest_drive(scene))
    if scene.central_pull is not None:
        away = np.maximum(np.abs(low - scene.central_pull.center), np.abs(high - scene.central_pull.center))
        speeds.append(scene.central_pull.rate * float(away.max()))
    speeds.append(capillary_speed(scene, bounds))
    fastest = max(speeds)
    if fastest == 0.0:
        raise SceneError(
            [Fault("liquid.fastest", "nothing moves and nothing pulls: say which speed is to be expected")]
        )
    return fastest


def capillary_speed(scene: SphScene, bounds: list[tuple[Array, Array]]) -> float:
    """Of the narrowest liquid that draws itself together: rho v^2 / 2 is what its surface presses with, and half of
    what cohesion presses with, so that it compresses by a hundredth or two.
    """
    if tension_of(scene) == "none":
        return 0.0
    narrowest = min(float((high - low).min()) for low, high in bounds)
    density = 1000.0 if scene.liquid.density is None else scene.liquid.density
    pressure = laplace_pressure(filled(scene.liquid).surface_tension or 0.0, 0.5 * narrowest, len(scene.tank.low))
    if tension_of(scene) == "cohesion":
        support = kernel_of(scene).support * smoothing_of(scene)
        pressure += COHESIVE * (filled(scene.liquid).surface_tension or 0.0) / support
    return math.sqrt(2.0 * pressure / density)


def sides_of(scene: SphScene) -> list[Any]:
    """The tank's sides, low and high along each axis."""
    tank = scene.tank
    return [tank.left, tank.right, tank.bottom, tank.top, tank.front, tank.back][: 2 * len(tank.low)]


def liquid_of(scene: SphScene, material: Material) -> Liquid:
    """The particles at the start, with the pressure of their depth."""
    pull = np.zeros(len(scene.tank.low)) if modified(scene) else held_pull(scene)
    tank = Box(np.array(scene.tank.low), np.array(scene.tank.high))
    generator = np.random.default_rng(scene.seed)
    pieces: list[tuple[Array, Array, Array]] = []
    earlier: list[Part] = []
    told: list[Said] = []
    solids = solids_of(scene)
    for index, region in enumerate(scene.fluid):
        shape = part_of(region, scene.spacing)
        given = region.particles
        points = lattice_in(shape, scene.spacing) if given is None else np.array(given.positions)
        kept = apart(points, earlier) & free_of(points, solids, scene.spacing)
        points = points[kept]
        outside = ~tank.inside(points)
        if outside.any():
            where = tuple(float(f"{x:.4g}") for x in points[outside][0])
            raise SceneError([Fault(f"fluid[{index}]", f"reaches out of the tank, at {where}")])
        earlier.append(shape)
        head = np.zeros(len(points))
        if pull.any() and scene.method.start == "hydrostatic":
            head = np.linalg.norm(pull) * shape.way_out(points, -pull / np.linalg.norm(pull))
        if given is None:
            points = points + scene.method.jitter * scene.spacing * generator.uniform(-1.0, 1.0, points.shape)
        head += pressure_in(region, scene, points, material.density) / material.density
        pieces.append((points, velocity_in(region, scene, points), head))
        told.append(said_of(region, kept))
    return with_said(_particles(scene, material, pieces), told)


def _particles(scene: SphScene, material: Material, pieces: list[tuple[Array, Array, Array]]) -> Liquid:
    """Densities and masses of points where the enthalpy (J/kg) is known."""
    points, velocity, head = (np.concatenate(parts) for parts in zip(*pieces, strict=True))
    if len(points) == 0:
        raise SceneError([Fault("spacing", f"came {scene.spacing:g} m: no particle fits into the liquid")])
    laws = material.density, material.sound_speed, material.exponent
    density = np.array([density_at_enthalpy(each, *laws) for each in head])
    mass = density * scene.spacing ** points.shape[1]
    region = np.repeat(np.arange(len(pieces)), [len(piece[0]) for piece in pieces])
    return Liquid(np.ascontiguousarray(points.T), np.ascontiguousarray(velocity.T), density, mass, region)


def modified(scene: SphScene) -> bool:
    """Whether gravity is left out of the motion, and the hydrostatic pressure added for output."""
    return scene.method.pressure_split == "modified"


def parameters_of(scene: SphScene) -> Parameters:
    """Everything that does not move."""
    material, method = material_of(scene), scene.method
    shape, smoothing = kernel_of(scene), smoothing_of(scene)
    dimension = len(scene.tank.low)
    gravity = gravity_of(scene)
    pull, held = gravity, held_pull(scene)
    if modified(scene):
        pull = held = np.zeros(dimension)
    time_step, per_frame = steps_of(scene, material, smoothing)
    transports = chosen(method.pressure_force, STRESSES, "method.pressure_force") == "transport"
    usual = material.density * material.sound_speed**2
    support = shape.support * smoothing
    origin = 0.5 * (np.array(scene.tank.low) + np.array(scene.tank.high)) * (method.precision == "single")
    boundary = boundary_of(scene, material, support)
    center = scene.central_pull
    bodies, drives, shake = bodies_of(scene, boundary), drives_of(scene), shake_of(scene)
    return Parameters(
        time_step=time_step,
        steps_per_frame=per_frame,
        dimension=dimension,
        spacing=scene.spacing,
        material=material,
        constants=np.array([material.sound_speed, material.exponent, material.density]),
        gravity=pull,
        hydrostatic=gravity if method.pressure_split != "none" else 0.0 * gravity,
        surface=max(float(part_of(region, scene.spacing).bounds()[1][1]) for region in scene.fluid),
        numbers=numbers_of(scene, material, held),
        choices=choices_of(scene, held),
        support=support,
        boundary=boundary,
        bodies=bodies,
        drives=drives,
        gates=gates_of(scene, support),
        bounds=bounds_of(scene),
        shake=shake,
        gauges=gauges_of(scene, support),
        pull_rate=0.0 if center is None else center.rate,
        pull_center=np.zeros(dimension) if center is None else np.array(center.center),
        moves=bool(bodies.shapes or drives or shake),
        integrator=INTEGRATORS.index(chosen(method.integrator, INTEGRATORS, "method.integrator")),
        shifting=SHIFTINGS.index(shifting_of(scene)),
        background=(usual if method.background_pressure is None else method.background_pressure) * transports,
        tension=TENSIONS.index(tension_of(scene)),
        carried=carried_of(scene, shape.normalization / smoothing**dimension),
        turbulence=turbulent(scene),
        courant=method.courant,
        walls_clip=free_surface(scene) if method.walls_clip is None else method.walls_clip,
        precision=PRECISIONS[method.precision],
        origin=origin,
    )


def numbers_of(scene: SphScene, material: Material, pull: Array) -> Array:
    """The table of numbers that sums read."""
    shape, smoothing, dimension = kernel_of(scene), smoothing_of(scene), len(pull)
    given = scene.method.artificial_viscosity
    alpha = USUAL_ALPHA * (material.viscosity == 0.0) if given is None else given
    spring = material.density / material.sound_speed**2
    diffusion = diffusion_of(scene, pull)
    numbers = np.zeros(NUMBERS)
    numbers[ONE], numbers[H], numbers[INVERSE] = 1.0, smoothing, 1.0 / smoothing
    numbers[SCALE] = shape.normalization / smoothing ** (dimension + 2)
    numbers[SOFT] = 0.01 * smoothing**2
    # By volume the viscosity's term is not per density squared.
    by_mass = scene.method.pressure_force == "monaghan"
    numbers[SHARE] = material.density if by_mass else 1.0 / material.density
    numbers[ALPHA], numbers[SOUND] = alpha, material.sound_speed
    numbers[DELTA] = 2.0 * scene.method.diffusion * smoothing * material.sound_speed * (diffusion != "none")
    if diffusion == "hydrostatic":
        numbers[DELTA] *= spring
        numbers[G0 : G0 + dimension] = pull
    elif diffusion == "linear":
        numbers[G0 : G0 + dimension] = spring * pull
    shifts = shifting_of(scene) == "delta-plus"
    numbers[REFERENCE] = float(cast(float, shape.shape(scene.spacing / smoothing))) if shifts else 0.0
    return numbers.astype(PRECISIONS[scene.method.precision])


def diffusion_of(scene: SphScene, pull: Array) -> str:
    """The density diffusion by its name."""
    name = scene.method.density_diffusion
    if name == "automatic":
        uniform = pull.any() or scene.shake
        return "hydrostatic" if uniform and scene.central_pull is None else "antuono"
    return chosen(name, DIFFUSIONS, "method.density_diffusion")


def friction_of(scene: SphScene) -> int:
    """The form of the viscosity: the one that is right at a free surface, where there may be one."""
    if scene.method.friction == "automatic":
        return RADIAL if free_surface(scene) else LAMINAR
    return {"morris": LAMINAR, "monaghan": RADIAL}[chosen(scene.method.friction, FRICTIONS, "method.friction")]


def free_surface(scene: SphScene) -> bool:
    """Whether a part of the liquid's surface may move: a side is open, or the tank is not full."""
    bounds = [part_of(region, scene.spacing).bounds() for region in scene.fluid]
    low, high = np.min([b[0] for b in bounds], axis=0), np.max([b[1] for b in bounds], axis=0)
    room = np.maximum(low - np.array(scene.tank.low), np.array(scene.tank.high) - high)
    return any(side.kind == "open" for side in sides_of(scene)) or bool((room > 0.5 * scene.spacing).any())


def shifting_of(scene: SphScene) -> str:
    """The shifting by its name. Where there is no surface flows pile particles up along their stagnation lines."""
    name = scene.method.shifting
    if name == "automatic":
        return "delta-plus" if not free_surface(scene) and scene.method.pressure_force != "transport" else "none"
    return chosen(name, SHIFTINGS, "method.shifting")


def tension_of(scene: SphScene) -> str:
    """The model of surface tension by its name."""
    name, there = scene.method.surface_tension_model, (filled(scene.liquid).surface_tension or 0.0) > 0.0
    wanted = "cohesion" if name == "automatic" else chosen(name, TENSIONS, "method.surface_tension_model")
    return wanted if there else "none"


def turbulent(scene: SphScene) -> bool:
    """Whether eddies smaller than particles are reckoned with."""
    return chosen(scene.method.turbulence, TURBULENCES, "method.turbulence") == "smagorinsky"


def choices_of(scene: SphScene, pull: Array) -> Any:
    """The table of choices that sums read."""
    choices = np.zeros(CHOICES, np.int64)
    choices[DIMENSION] = len(scene.tank.low)
    choices[KERNEL] = KERNEL_CODES[scene.method.kernel]
    choices[DIFFUSION] = DIFFUSIONS.index(diffusion_of(scene, pull))
    choices[STRESS] = STRESSES.index(scene.method.pressure_force)
    choices[FRICTION] = friction_of(scene) if filled(scene.liquid).viscosity or turbulent(scene) else NO_FRICTION
    return choices


def steps_of(scene: SphScene, material: Material, smoothing: float) -> tuple[float, int]:
    """The time step and how many fit between two frames: sound and viscosity set it [monaghan1992, morris1997]."""
    longest = scene.method.courant * smoothing / (material.sound_speed + material.fastest)
    if material.viscosity > 0.0:
        longest = min(longest, 0.125 * smoothing**2 * material.density / material.viscosity)
    if tension_of(scene) != "none":
        longest = min(longest, tension_limit(smoothing, material.density, material.surface_tension))
    wanted = scene.method.time_step or longest
    if wanted > 4.0 * longest:
        raise SceneError([Fault("method.time_step", f"came {wanted:g} s; sound and viscosity allow {longest:.3g} s")])
    per_frame = max(1, math.ceil(scene.frame_every / wanted * (1.0 - 1e-9)))
    return scene.frame_every / per_frame, per_frame
