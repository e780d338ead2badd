"""Parameters from a scene: the material, the methods, the boundaries, and the time step.

The time step is limited by sound, viscosity, surface tension and light bodies: see `limits_of`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ecume.errors import Fault, SceneError
from ecume.laws.flows import channel_pressure_drop
from ecume.laws.kernels import Kernel
from ecume.laws.tension import laplace_pressure
from ecume.laws.time_step_limits import (
    acoustic_limit,
    advective_limit,
    body_damping_limit,
    body_drag_limit,
    body_sound_limit,
    late_damping_limit,
    radial_excess,
    tension_limit,
    viscous_limit,
)
from ecume.laws.viscous import acoustic_damping
from ecume.laws.yield_stress import apparent_viscosity
from ecume.models.sph.fields import EquationOfState, TwoLiquids
from ecume.models.sph.incompressible import projection_of, require_suitable
from ecume.models.sph.integration.time_stepping import INTEGRATORS, LATE
from ecume.models.sph.parameters import CarriedGroup, Material, Parameters, PassiveTracers, Rheology, SecondLiquid
from ecume.models.sph.rates.methods import DIFFUSIONS, PressureMethod
from ecume.models.sph.rates.surface_tension import TENSIONS
from ecume.models.sph.report.observation import gauges_of, reference_of
from ecume.models.sph.setup.choices import (
    PRECISIONS,
    WATER,
    acoustic_damping_of,
    acting_friction,
    chosen,
    color_reach_of,
    constants_of,
    diffusion_of,
    filled,
    fixed_volume,
    free_surface,
    friction_of,
    gravity_of,
    held_pull,
    kernel_of,
    liquid_in,
    modified,
    pressure_force_of,
    pressure_of,
    shifting_of,
    sides_of,
    smallest_extent,
    smoothing_of,
    tension_of,
    turbulent,
)
from ecume.models.sph.setup.initial_particles import velocity_in
from ecume.models.sph.setup.packing import shifting_limit
from ecume.models.sph.setup.second_liquid import require_two_liquids
from ecume.models.sph.setup.shapes import part_of, shape_of
from ecume.models.sph.setup.walls_and_bodies import (
    base_excitation_of,
    bodies_of,
    boundary_of,
    bounds_of,
    driven_speeds,
    drives_of,
    fastest_drive,
    holds,
    mass_of,
    narrowest_channel,
    open_boundaries_of,
    roll_of,
)
from ecume.models.step_counts import ending_on_a_step
from ecume.scenes.sph import BodySpec, FluidSpec, SphScene
from ecume.scenes.sph.scene import RheologySpec
from ecume.units import Array

NUMERICAL_MACH = 0.1


def material_of(scene: SphScene) -> Material:
    """The liquid with its speed of sound."""
    return _material(scene, filled(scene.liquid), filled(scene.liquid).maximum_speed or fastest_of(scene))


def second_of(scene: SphScene, material: Material) -> SecondLiquid | None:
    """The other liquid, or None."""
    if scene.second_liquid is None:
        return None
    require_two_liquids(scene)
    kind = np.array([1.0 + (region.liquid == "second") for region in scene.fluid])
    return SecondLiquid(_material(scene, filled(scene.second_liquid.alone), material.fastest), kind)


def materials_of(scene: SphScene, material: Material) -> tuple[Material, ...]:
    """The liquids of a tank; `material` is the first."""
    second = second_of(scene, material)
    return (material,) if second is None else (material, second.material)


def _material(scene: SphScene, given: FluidSpec, fastest: float) -> Material:
    """The material of a liquid. By default two liquids are equally stiff, rho c^2: with equal speeds of sound the
    weight of a dense liquid would compress a light one below it.
    """
    densest = max(liquid_in(region, scene).density or 0.0 for region in scene.fluid)
    sound = given.sound_speed or fastest / NUMERICAL_MACH * math.sqrt(densest / (given.density or densest))
    if not pressure_of(scene).compressible:
        sound = given.sound_speed or math.inf
    return Material(
        density=given.density or 0.0,
        sound_speed=sound,
        exponent=given.tait_exponent,
        viscosity=given.viscosity or largest_viscosity(scene, fastest),
        surface_tension=given.surface_tension or 0.0,
        fastest=fastest,
    )


STIFFER = 30.0
"""The largest viscosity, by default, over that at the expected rate of strain."""


def viscosity_at(spec: RheologySpec | None, strain_rate: float) -> float:
    """The viscosity (Pa s) at a rate of strain, without an upper bound; zero for a liquid without rheology."""
    if spec is None or strain_rate == 0.0:
        return 0.0
    return apparent_viscosity(strain_rate, spec.consistency, spec.exponent, spec.yield_stress, math.inf)


def largest_viscosity(scene: SphScene, fastest: float) -> float:
    """The viscosity of slow flow below the yield stress (Pa s); zero for liquids without rheology."""
    spec = scene.liquid.rheology
    if spec is None:
        return 0.0
    usual = viscosity_at(spec, fastest / smallest_extent(scene))
    newtonian = spec.exponent == 1.0 and spec.yield_stress == 0.0
    return spec.largest_viscosity or (usual if newtonian else STIFFER * usual)


def rheology_of(scene: SphScene, material: Material) -> Rheology | None:
    """The dependence of the viscosity on the rate of strain, or None."""
    spec = scene.liquid.rheology
    return None if spec is None else Rheology(spec.consistency, spec.exponent, spec.yield_stress, material.viscosity)


def fastest_of(scene: SphScene) -> float:
    """The highest expected speed: of the initial motion, and of free fall to the end of the tank."""
    bounds = [part_of(region, scene.spacing).bounds() for region in scene.fluid]
    speeds = [math.sqrt(2.0 * weight_enthalpy(scene))]
    for region, ends in zip(scene.fluid, bounds, strict=True):
        initial = float(np.linalg.norm(velocity_in(region, scene, np.stack(ends)), axis=1).max())
        speeds.append(math.sqrt(initial**2 + 2.0 * fall_enthalpy(scene, ends[1], ends[0])))
        speeds.append(region.flow_speed if region.flow else 0.0)
    speeds += [math.hypot(*side.velocity) for side in sides_of(scene) if side.velocity]
    for body in scene.bodies:
        if body.motion is not None:
            continue
        ends = shape_of(body).bounds()
        fall = fall_enthalpy(scene, *ends)
        speeds.append(math.sqrt(math.hypot(*(body.velocity or ())) ** 2 + 2.0 * fall))
    speeds += [1.5 * side.speed for side in sides_of(scene) if side.speed]
    speeds += [fastest_drive(scene), *driven_speeds(scene)]
    if scene.central_force is not None:
        speeds.append(scene.central_force.angular_frequency * farthest_from_center(scene, scene.central_force.center))
    speeds.append(capillary_speed(scene, bounds))
    speeds.append(math.sqrt(channel_enthalpy(scene)))
    fastest = max(speeds)
    if fastest == 0.0:
        raise SceneError(
            [Fault("liquid.maximum_speed", "no motion, gravity or force sets a speed; give the expected maximum speed")]
        )
    return fastest


def farthest_from_center(scene: SphScene, center: Sequence[float]) -> float:
    """The largest distance (m) of the liquid from the center of the central force, along an axis."""
    ends = np.array([part_of(region, scene.spacing).bounds() for region in scene.fluid])
    return float(np.abs(ends - np.array(center)).max())


def strongest_pull(scene: SphScene) -> float:
    """The largest acceleration (m/s^2) of the liquid at the start by gravity and the central force."""
    pull, central = float(np.linalg.norm(gravity_of(scene))), scene.central_force
    return (
        pull if central is None else pull + central.angular_frequency**2 * farthest_from_center(scene, central.center)
    )


def fall_enthalpy(scene: SphScene, low: Array, high: Array) -> float:
    """The energy (J/kg) of a fall to the sides of the tank: from the corner `low` toward lower coordinates, and from
    `high` toward higher ones; zero along periodic sides.
    """
    pull = held_pull(scene)
    way = np.where(pull < 0.0, low - np.array(scene.tank.low), np.array(scene.tank.high) - high)
    return float(np.abs(pull) @ np.maximum(way, 0.0))


def weight_enthalpy(scene: SphScene) -> float:
    """The enthalpy g H (J/kg) at the bottom caused by the weight of the liquid above."""
    bounds = [part_of(region, scene.spacing).bounds() for region in scene.fluid]
    extent = np.max([high for _, high in bounds], axis=0) - np.min([low for low, _ in bounds], axis=0)
    return float(np.abs(gravity_of(scene)) @ extent)


def channel_enthalpy(scene: SphScene) -> float:
    """The largest viscous pressure drop between no-slip walls behind an inflow, over the density (J/kg). The speed of
    sound must also be large compared with its square root [morris1997].
    """
    liquid, drops = filled(scene.liquid), [0.0]
    for number, side in enumerate(sides_of(scene)):
        if side.kind == "inflow" and side.speed:
            axis = number // 2
            length, width = scene.tank.high[axis] - scene.tank.low[axis], narrowest_channel(scene, axis)
            viscosity = liquid.viscosity or viscosity_at(liquid.rheology, side.speed / width)
            drops.append(channel_pressure_drop(viscosity, side.speed, length, width) if viscosity else 0.0)
    return max(drops) / (liquid.density or WATER)


def capillary_speed(scene: SphScene, bounds: list[tuple[Array, Array]]) -> float:
    """The speed scale of the narrowest region under surface tension: rho v^2 / 2 is Laplace's pressure, and half of the
    pressure by cohesion, so that the compression is one or two percent.
    """
    if tension_of(scene) == "none":
        return 0.0
    narrowest = min(float((high - low).min()) for low, high in bounds)
    liquid = max((liquid_in(region, scene) for region in scene.fluid), key=lambda each: each.density or WATER)
    tension = (liquid if scene.second_liquid is None else scene.second_liquid.alone).surface_tension or 0.0
    pressure = laplace_pressure(tension, 0.5 * narrowest, len(scene.tank.low))
    support = kernel_of(scene).support * smoothing_of(scene)
    pressure += TENSIONS[tension_of(scene)].inner_pressure * tension / support
    return math.sqrt(2.0 * pressure / (liquid.density or WATER))


def parameters_of(scene: SphScene) -> Parameters:
    """The parameters of a scene."""
    material, method, pressure = material_of(scene), scene.method, pressure_of(scene)
    require_suitable(scene, pressure)
    shape, smoothing = kernel_of(scene), smoothing_of(scene)
    support = shape.support * smoothing
    second = second_of(scene, material)
    time_step, per_frame = steps_of(scene, material)
    held = held_pull(scene) * (not modified(scene))
    boundary = boundary_of(scene, material, support)
    bodies, drives, excitation = bodies_of(scene, boundary), drives_of(scene), base_excitation_of(scene)
    roll = roll_of(scene)
    rate, center = central_force_of(scene)
    return Parameters(
        time_step=time_step,
        steps_per_frame=per_frame,
        dimension=len(scene.tank.low),
        spacing=scene.spacing,
        material=material,
        equation_of_state=equation_of(material, second, pressure),
        gravity=gravity_of(scene) * (not modified(scene)),
        hydrostatic=gravity_of(scene) * (method.pressure_split != "none"),
        surface=max(float(part_of(region, scene.spacing).bounds()[1][scene.up_axis]) for region in scene.fluid),
        constants=constants_of(scene, material, held),
        pressure_method=pressure,
        projection=None
        if pressure.compressible
        else projection_of(scene, free_surface(scene), material.density * held),
        pressure_force=pressure_force_of(scene),
        density_diffusion=DIFFUSIONS[diffusion_of(scene, held)],
        friction=acting_friction(scene),
        bulk_viscosity=bulk_viscosity_of(scene, material),
        support=support,
        boundary=boundary,
        bodies=bodies,
        drives=drives,
        open_boundaries=open_boundaries_of(scene, support),
        bounds=bounds_of(scene),
        base_excitation=excitation,
        roll=roll,
        gauges=gauges_of(scene, support),
        pressure_reference=reference_of(scene),
        pull_rate=rate,
        pull_center=center,
        moves=bool(bodies.shapes or drives or excitation or roll),
        integrator=integrator_of(scene),
        shifting=shifting_of(scene),
        shifting_limit=math.inf if shifting_of(scene) == "none" else shifting_limit(scene),
        background=background_of(scene, material),
        spreading_pressure=material.density
        * strongest_pull(scene)
        * scene.spacing
        * pressure_force_of(scene).corrected,
        tension=tension_of(scene),
        color_reach=color_reach_of(scene),
        passive_tracers=passive_tracers_of(scene, shape.normalization / smoothing ** len(scene.tank.low)),
        turbulence=turbulent(scene),
        rheology=rheology_of(scene, material),
        courant=scene.integration.courant_number,
        walls_clip=free_surface(scene)
        if method.nonnegative_wall_pressure is None
        else method.nonnegative_wall_pressure,
        fixed_volume=pressure.compressible and fixed_volume(scene),
        precision=PRECISIONS[method.precision],
        second=second,
        origin=0.5 * (np.array(scene.tank.low) + np.array(scene.tank.high)) * (method.precision == "single"),
    )


def equation_of(material: Material, second: SecondLiquid | None, pressure: PressureMethod) -> EquationOfState:
    """The constants of the equation of state."""
    own = material.sound_speed, material.exponent, material.density
    if second is None:
        return pressure.equation(*own)
    other = second.material
    return TwoLiquids(*own, other.sound_speed, other.exponent, other.density)


def central_force_of(scene: SphScene) -> tuple[float, Array]:
    """The rate of the central force (1/s), zero without one, and its center."""
    pull = scene.central_force
    return (0.0, np.zeros(len(scene.tank.low))) if pull is None else (pull.angular_frequency, np.array(pull.center))


def bulk_viscosity_of(scene: SphScene, material: Material) -> float:
    """The bulk viscosity (Pa s) of the acoustic damping; zero without damping. The default does not require shorter
    steps for light bodies.
    """
    alpha = acoustic_damping_of(scene)
    if alpha == 0.0:
        return 0.0
    faults = []
    if not pressure_of(scene).compressible:
        faults.append("an incompressible liquid has no sound waves; remove the key")
    force, most = scene.method.pressure_force, pressure_force_of(scene).most_damping
    if most == 0.0:
        faults.append(f"is added to the sum of pressures, which {force!r} does not take; use pressure_force = 'sum'")
    elif alpha > most:
        faults.append(f"pressure_force = {force!r} diverges with more than {most:g}; use that, or 'sum'")
    if faults:
        raise SceneError([Fault("method.acoustic_damping", f"got {alpha:g}; {fault}") for fault in faults])
    full = acoustic_damping(alpha, material.density, smoothing_of(scene), material.sound_speed)
    if scene.method.acoustic_damping is not None:
        return full
    # The limit by damping is proportional to the mass of the body and to the inverse of the bulk viscosity.
    step = scene.integration.time_step or min(limits_of(scene, material, 0.0).values())
    return min([full, *(full * damping_limit(scene, spec, material, full) / step for spec in scene.bodies)])


def background_of(scene: SphScene, material: Material) -> float:
    """The background pressure (Pa) of the transport velocity; zero without transport velocity."""
    given = scene.method.background_pressure
    if not pressure_force_of(scene).transported:
        if given is not None:
            raise SceneError([Fault("method.background_pressure", 'is of pressure_force = "transport" alone')])
        return 0.0
    background = material.density * material.sound_speed**2 if given is None else given
    if background > 0.0 and (free_surface(scene) or scene.tank.walls == "reflect"):
        message = (
            "got 'transport', whose background pressure drives particles through a free surface and at walls that only "
            "reflect; expected a full tank without open sides; otherwise use 'sum'"
        )
        raise SceneError([Fault("method.pressure_force", message)])
    return background


LENIENT = 4.0
"""The largest ratio of a specified time step to the limits, which are rules of thumb."""
NEARLY = 1.01
"""The same for a limit without a margin."""
BODIES, DAMPING = "the lightest body", "acoustic damping"


def limits_of(scene: SphScene, material: Material, bulk_viscosity: float) -> dict[str, float]:
    """The longest time step (s) for each limit, over all liquids; infinite if a limit does not apply."""
    stiffness, found = material.density * material.sound_speed, list[dict[str, float]]()
    for liquid in materials_of(scene, material):
        ratio = liquid.density * liquid.sound_speed / stiffness if bulk_viscosity else 1.0
        found.append(_limits_in(scene, liquid, ratio * bulk_viscosity))
    return {name: min(limits[name] for limits in found) for name in found[0]}


def _limits_in(scene: SphScene, material: Material, bulk_viscosity: float) -> dict[str, float]:
    h, courant = smoothing_of(scene), scene.integration.courant_number
    tension = material.surface_tension if tension_of(scene) != "none" else 0.0
    if scene.second_liquid is not None:  # the force acts on the denser liquid
        tension = scene.second_liquid.interface_tension
        tension *= material.density == max(liquid_in(region, scene).density or 0.0 for region in scene.fluid)
    return {
        **speed_limit(h, material, courant),
        "viscosity": viscous_limit(h, material.viscosity / material.density),
        "surface tension": tension_limit(h, material.density, tension),
        DAMPING: damping_step(scene, material, bulk_viscosity),
        BODIES: min((body_limit(scene, spec, material, bulk_viscosity) for spec in scene.bodies), default=math.inf),
    }


def damping_step(scene: SphScene, material: Material, bulk_viscosity: float) -> float:
    """The longest time step (s) of schemes in which the damping uses a previous rate; infinite for others."""
    if bulk_viscosity == 0.0 or integrator_of(scene) not in LATE:
        return math.inf
    wavenumber = largest_wavenumber(kernel_of(scene), smoothing_of(scene), scene.spacing)
    return late_damping_limit(material.density, bulk_viscosity, wavenumber)


WAVENUMBERS = 64
"""The number of wavenumbers tried along each direction."""


def largest_wavenumber(kernel: Kernel, smoothing_length: float, spacing: float) -> float:
    """The largest wavenumber (1/m) of smoothed gradients in a lattice, |sum_j V_j F x_ij sin(k.x_ij)|, for waves along
    its axes and diagonals.
    """
    most = math.ceil(kernel.support * smoothing_length / spacing)
    steps = np.arange(-most, most + 1)
    lattice = spacing * np.stack(np.meshgrid(*[steps] * kernel.dim), axis=-1).reshape(-1, kernel.dim)
    distance = np.sqrt((lattice**2).sum(axis=1))
    near = (distance > 0.0) & (distance < kernel.support * smoothing_length)
    lattice, distance = lattice[near], distance[near]
    pull = kernel.slope(distance, smoothing_length) / distance * spacing**kernel.dim
    found = 0.0
    for axes in range(1, kernel.dim + 1):
        along = lattice[:, :axes].sum(axis=1)
        waves = np.sin(np.outer(np.linspace(0.0, np.pi / spacing, WAVENUMBERS), along))
        found = max(found, float(np.abs(waves @ (pull * along)).max()) / math.sqrt(axes))
    return found


def speed_limit(smoothing_length: float, material: Material, courant: float) -> dict[str, float]:
    """The time step limit by sound, or by the flow in incompressible liquids."""
    if math.isfinite(material.sound_speed):
        return {"sound": acoustic_limit(smoothing_length, material.sound_speed, material.fastest, courant)}
    return {"the maximum speed": advective_limit(smoothing_length, material.fastest, courant)}


def integrator_of(scene: SphScene) -> str:
    """The integration scheme by its name."""
    name = scene.integration.integrator
    default = pressure_of(scene).integrator
    return default if name == "automatic" else chosen(name, INTEGRATORS, "integration.integrator")


def damping_limit(scene: SphScene, spec: BodySpec, material: Material, bulk_viscosity: float) -> float:
    """The longest time step for a body (s) by the acoustic damping of the adjacent liquid."""
    return body_damping_limit(areal_mass_of(spec), bulk_viscosity, kernel_of(scene).overlap / smoothing_of(scene))


def areal_mass_of(spec: BodySpec) -> float:
    """The ratio of the mass of a body to its surface area."""
    shape = shape_of(spec)
    return float(mass_of(spec, shape) / shape.surface())


def body_limit(scene: SphScene, spec: BodySpec, material: Material, bulk_viscosity: float) -> float:
    """The longest stable time step for a body (s) by pressure, damping and viscosity of the adjacent liquid."""
    kernel, h, areal_mass = kernel_of(scene), smoothing_of(scene), areal_mass_of(spec)
    pressed = body_sound_limit(areal_mass, material.density, material.sound_speed, kernel.overlap / h)
    viscosity = material.viscosity * holds(spec, scene)
    if friction_of(scene).radial:
        viscosity *= radial_excess(kernel.dim)
    damped = damping_limit(scene, spec, material, bulk_viscosity)
    return min(pressed, damped, body_drag_limit(areal_mass, viscosity, float(kernel.over_plane(0.0)) / h))


def steps_of(scene: SphScene, material: Material) -> tuple[float, int]:
    """The time step and the number of steps between two frames."""
    limits = limits_of(scene, material, bulk_viscosity_of(scene, material))
    longest = min(limits.values())
    step = scene.integration.time_step or longest
    # The other limits are estimates with a margin. A body that is too light for its time step diverges, and so does
    # delayed damping, since the number of substeps follows from the speed of sound alone.
    lenient = NEARLY if limiter(limits) == DAMPING else LENIENT
    if step > min(lenient * longest, limits[BODIES]):
        message = f"got {step:g} s; {limiter(limits)} requires {longest:.3g} s or less"
        raise SceneError([Fault("integration.time_step", message)])
    per_frame = ending_on_a_step(scene, max(1, math.ceil(scene.frame_every / step * (1.0 - 1e-9))))
    return scene.frame_every / per_frame, per_frame


def limiter(limits: dict[str, float]) -> str:
    """The limit that determines the time step."""
    return min(limits, key=lambda name: limits[name])


def passive_tracers_of(scene: SphScene, weight: float) -> PassiveTracers:
    """The groups of passive particles of a scene; `weight` is the normalization of the kernel."""
    generator, places, groups = np.random.default_rng([scene.seed, 3]), [], list[CarriedGroup]()
    for spec in scene.passive_tracers:
        if spec.low is not None and spec.high is not None:
            places.append(generator.uniform(spec.low, spec.high, (spec.count or 0, len(spec.low))))
        else:
            places.append(np.array(spec.positions))
        dispersion = 1.0 / spec.schmidt_number if spec.turbulent_dispersion else 0.0
        groups.append(CarriedGroup(spec.radius, spec.density or 0.0, dispersion))
    start = tuple(int(end) for end in np.cumsum([0, *map(len, places)]))
    none = np.zeros((0, len(scene.tank.low)))
    position = np.ascontiguousarray(np.concatenate([none, *places]).T)
    return PassiveTracers(position, start, tuple(groups), len(scene.fluid), weight, scene.seed)
