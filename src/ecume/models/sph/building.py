"""From a scene to parameters: the material, the forces, the time step."""

from __future__ import annotations

import math

import numpy as np

from ecume.errors import Fault, SceneError
from ecume.laws.tension import laplace_pressure
from ecume.models.sph.bodies import bodies_of
from ecume.models.sph.boundaries import boundary_of
from ecume.models.sph.defaults import (
    PRECISIONS,
    acting_friction,
    chosen,
    color_reach_of,
    constants_of,
    diffusion_of,
    free_surface,
    gravity_of,
    held_pull,
    kernel_of,
    modified,
    pressure_force_of,
    shifting_of,
    sides_of,
    smoothing_of,
    tension_of,
    turbulent,
)
from ecume.models.sph.fields import Tait
from ecume.models.sph.gauges import gauges_of
from ecume.models.sph.methods import DIFFUSIONS
from ecume.models.sph.motions import drives_of, fastest_drive, shake_of
from ecume.models.sph.open_boundaries import bounds_of, gates_of
from ecume.models.sph.parameters import Material, Parameters
from ecume.models.sph.passive_particles import carried_of
from ecume.models.sph.solids import part_of
from ecume.models.sph.starting import velocity_in
from ecume.models.sph.stepping import INTEGRATORS
from ecume.models.sph.substances import filled
from ecume.models.sph.tension import TENSIONS
from ecume.models.sph.time_step import steps_of
from ecume.scenes.sph import SphScene
from ecume.units import Array

NUMERICAL_MACH = 0.1


def material_of(scene: SphScene) -> Material:
    """The liquid, with a sound speed for the numerics."""
    given = filled(scene.liquid)
    fastest = given.maximum_speed or fastest_of(scene)
    sound = given.sound_speed or fastest / NUMERICAL_MACH
    return Material(
        density=given.density or 0.0,
        sound_speed=sound,
        exponent=given.tait_exponent,
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
    if scene.central_force is not None:
        away = np.maximum(np.abs(low - scene.central_force.center), np.abs(high - scene.central_force.center))
        speeds.append(scene.central_force.angular_frequency * float(away.max()))
    speeds.append(capillary_speed(scene, bounds))
    fastest = max(speeds)
    if fastest == 0.0:
        raise SceneError(
            [Fault("liquid.maximum_speed", "nothing moves and nothing pulls: say which speed is to be expected")]
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
    support = kernel_of(scene).support * smoothing_of(scene)
    pressure += TENSIONS[tension_of(scene)].inner_pressure * (filled(scene.liquid).surface_tension or 0.0) / support
    return math.sqrt(2.0 * pressure / density)


def parameters_of(scene: SphScene) -> Parameters:
    """Everything that does not move."""
    material, method = material_of(scene), scene.method
    shape, smoothing = kernel_of(scene), smoothing_of(scene)
    support = shape.support * smoothing
    time_step, per_frame = steps_of(scene, material)
    held = held_pull(scene) * (not modified(scene))
    boundary = boundary_of(scene, material, support)
    bodies, drives, shake = bodies_of(scene, boundary), drives_of(scene), shake_of(scene)
    rate, center = central_pull_of(scene)
    return Parameters(
        time_step=time_step,
        steps_per_frame=per_frame,
        dimension=len(scene.tank.low),
        spacing=scene.spacing,
        material=material,
        tait=Tait(material.sound_speed, material.exponent, material.density),
        gravity=gravity_of(scene) * (not modified(scene)),
        hydrostatic=gravity_of(scene) * (method.pressure_split != "none"),
        surface=max(float(part_of(region, scene.spacing).bounds()[1][1]) for region in scene.fluid),
        constants=constants_of(scene, material, held),
        pressure_force=pressure_force_of(scene),
        density_diffusion=DIFFUSIONS[diffusion_of(scene, held)],
        friction=acting_friction(scene),
        support=support,
        boundary=boundary,
        bodies=bodies,
        drives=drives,
        gates=gates_of(scene, support),
        bounds=bounds_of(scene),
        shake=shake,
        gauges=gauges_of(scene, support),
        pull_rate=rate,
        pull_center=center,
        moves=bool(bodies.shapes or drives or shake),
        integrator=chosen(scene.integration.integrator, INTEGRATORS, "integration.integrator"),
        shifting=shifting_of(scene),
        background=background_of(scene, material),
        tension=tension_of(scene),
        color_reach=color_reach_of(scene),
        carried=carried_of(scene, shape.normalization / smoothing ** len(scene.tank.low)),
        turbulence=turbulent(scene),
        courant=scene.integration.courant_number,
        walls_clip=free_surface(scene)
        if method.nonnegative_wall_pressure is None
        else method.nonnegative_wall_pressure,
        precision=PRECISIONS[method.precision],
        origin=0.5 * (np.array(scene.tank.low) + np.array(scene.tank.high)) * (method.precision == "single"),
    )


def central_pull_of(scene: SphScene) -> tuple[float, Array]:
    """Its rate (1/s), zero where there is none, and the point it pulls to."""
    pull = scene.central_force
    return (0.0, np.zeros(len(scene.tank.low))) if pull is None else (pull.angular_frequency, np.array(pull.center))


def background_of(scene: SphScene, material: Material) -> float:
    """Pa, of the transport velocity; zero without."""
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
