"""The liquid and the methods that a scene selects, with defaults for what it omits, and the laws behind them.

The properties of a liquid follow from its name and temperature; methods are rows of tables with the codes and constants
for the sums.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from typing import Any, cast

import numpy as np

from ecume.engine.shapes import Box, covered_volume
from ecume.errors import Fault, SceneError
from ecume.laws import (
    density_diffusion,
    incompressible,
    kernels,
    states,
    time_step_limits,
    viscous,
    wall_forces,
    yield_stress,
)
from ecume.laws.hydrostatics import hydrostatic_fault
from ecume.laws.kernels import KERNEL_CODES, KERNELS, Kernel, kernel
from ecume.laws.liquids import ICE_POINT, LiquidProperties
from ecume.models.liquids import correlations_of, named_liquid
from ecume.models.model import Source
from ecume.models.sph.fields import Constants, Precision, constants_from
from ecume.models.sph.parameters import Material
from ecume.models.sph.rates.methods import (
    DIFFUSIONS,
    FRICTIONS,
    PRESSURE_FORCES,
    PRESSURES,
    SUM_OF_TWO,
    Friction,
    PressureForce,
    PressureMethod,
)
from ecume.models.sph.rates.shifting import SHIFTINGS
from ecume.models.sph.rates.surface_tension import TENSIONS
from ecume.models.sph.setup.shapes import part_of, solid_of
from ecume.scenes.faults import suggestion
from ecume.scenes.sph import BodySpec, FluidSpec, ObstacleSpec, RegionSpec, SphScene
from ecume.scenes.sph.tank import SideSpec
from ecume.units import Array

TURBULENCES = {"none": False, "smagorinsky": True}
"""Whether eddies add a viscosity: see `gradients.set_viscosity`."""
NUMERICAL_MACH = 0.1
PRECISIONS: dict[str, Precision] = {"double": np.float64, "single": np.float32}
USUAL_ALPHA = 0.02
"""Coefficient of the artificial viscosity where the scene gives the liquid no viscosity."""


def chosen(name: str, names: Any, path: str) -> str:
    """The name of a law, if the law exists. Raises SceneError otherwise."""
    if name not in names:
        known = ", ".join(names)
        near = suggestion(name, names)
        meant = "" if near.startswith("known") else f"; {near}"
        raise SceneError([Fault(path, f"got {name!r}; expected one of {known}{meant}")])
    return name


def sides_of(scene: SphScene) -> list[Any]:
    """The tank's sides, low and high along each axis."""
    return [getattr(scene.tank, name) for name in scene.sides]


def gravity_of(scene: SphScene) -> Array:
    """The acceleration of gravity (d,) in m/s^2."""
    return np.array(scene.gravity, dtype=np.float64)


def held_pull(scene: SphScene) -> Array:
    """The part (d,) of gravity that pressure balances at rest: zero along periodic sides, along which liquid
    accelerates.
    """
    pull = gravity_of(scene)
    for number, side in enumerate(sides_of(scene)):
        if side.kind == "periodic":
            pull[number // 2] = 0.0
    return pull


def pressure_of(scene: SphScene) -> PressureMethod:
    """The pressure method of a scene."""
    return PRESSURES[chosen(scene.method.pressure, PRESSURES, "method.pressure")]


def modified(scene: SphScene) -> bool:
    """Whether the forces omit gravity and frames add the hydrostatic pressure."""
    return scene.method.pressure_split == "modified"


def kernel_of(scene: SphScene) -> Kernel:
    """The scene's kernel in its dimension."""
    return kernel(chosen(scene.method.kernel, KERNELS, "method.kernel"), dim=len(scene.tank.low))


def smoothing_of(scene: SphScene) -> float:
    """The smoothing length (m)."""
    given = scene.method.smoothing_ratio
    usual = KERNELS[chosen(scene.method.kernel, KERNELS, "method.kernel")].smoothing[len(scene.tank.low)]
    return scene.spacing * (usual if given is None else given)


def constants_of(scene: SphScene, material: Material, pull: Array) -> Constants:
    """The constants that sums read; `pull` is the gravity that pressure balances at rest."""
    shape, smoothing, dimension = kernel_of(scene), smoothing_of(scene), len(pull)
    spring = material.density / material.sound_speed**2
    damping_speed = material.sound_speed if math.isfinite(material.sound_speed) else material.fastest / NUMERICAL_MACH
    term = DIFFUSIONS[diffusion_of(scene, pull)]
    delta = 0.0
    if term.excess is not None:
        delta = density_diffusion.strength(scene.method.diffusion_coefficient, smoothing, material.sound_speed)
    if term.field == "enthalpy":
        delta *= spring
    by_mass = pressure_force_of(scene).by_mass
    if by_mass:  # Neighbors then have their masses as weights, but the diffusion is a sum over volumes.
        delta /= material.density
    rise = np.zeros(3)
    if term.balances_weight:
        rise[:dimension] = term.rise(material.density, material.sound_speed) * pull
    tensile = SHIFTINGS[shifting_of(scene)].tensile

    values = {
        "dimension": dimension,
        "kernel": KERNEL_CODES[scene.method.kernel],
        "zero": 0.0,
        "smoothing_length": smoothing,
        "inverse_length": 1.0 / smoothing,
        "slope_factor": shape.normalization / smoothing ** (dimension + 2),
        "softening": 0.01 * smoothing**2,
        "sound_speed": damping_speed,
        "alpha": artificial_viscosity_of(scene),
        # In the form by volumes the viscous term is not divided by the density squared.
        "damping_divisor": material.density if by_mass else 1.0 / material.density,
        "delta": delta,
        "rise_x": rise[0],
        "rise_y": rise[1],
        "rise_z": rise[2],
        "reference_value": cast(float, shape.shape(scene.spacing / smoothing)) if tensile else 0.0,
    }
    return constants_from(PRECISIONS[scene.method.precision], values)


def artificial_viscosity_of(scene: SphScene) -> float:
    """The coefficient alpha of the artificial viscosity. By default it is zero if the liquid has a viscosity, and in
    tanks with waves: it would damp them, and the acoustic damping is sufficient.
    """
    given = scene.method.artificial_viscosity
    if given is None:
        spared = makes_waves(scene) and acoustic_damping_of(scene) >= USUAL_DAMPING
        return USUAL_ALPHA * (not scene.liquid.sticks and not spared and scene.second_liquid is None)
    return given


def makes_waves(scene: SphScene) -> bool:
    """Whether a scene simulates surface waves: a side moves, or a standing wave is initialized."""
    moved = any(side.motion for side in sides_of(scene))
    return moved or any(region.flow == "standing-wave" for region in scene.fluid)


USUAL_DAMPING = 2.0
"""The coefficient of acoustic damping in scenes with impacts on walls. With 1.76 the fastest oscillation of a lattice
is critically damped.
"""


def impacts_dissipate(scene: SphScene) -> bool:
    """Whether the method dissipates the sound of impacts: for a compressible liquid with a free surface or an
    interface, unless the scene sets the artificial viscosity to zero.
    """
    moves = free_surface(scene) or scene.second_liquid is not None
    hits = pressure_of(scene).compressible and moves and scene.tank.walls != "reflect"
    return hits and scene.method.artificial_viscosity != 0.0


def acoustic_damping_of(scene: SphScene) -> float:
    """The coefficient alpha of the acoustic damping."""
    given = scene.method.acoustic_damping
    if given is None:
        return min(USUAL_DAMPING, pressure_force_of(scene).most_damping) * impacts_dissipate(scene)
    return given


def diffusion_of(scene: SphScene, pull: Array) -> str:
    """The density diffusion by its name. Under surface tension, gradients are completed: the pressure decreases within
    the outermost layers, and without completion the diffusion would draw particles off the surface.
    """
    name = scene.method.density_diffusion
    if name == "automatic" and not pressure_of(scene).compressible:
        return "none"
    if name == "automatic" and scene.second_liquid is not None:
        return "hydrostatic"
    if name == "automatic":
        uniform = (pull.any() or scene.base_excitation) and scene.central_force is None
        return "hydrostatic" if uniform and tension_of(scene) != "csf" else "antuono"
    return chosen(name, DIFFUSIONS, "method.density_diffusion")


def pressure_force_of(scene: SphScene) -> PressureForce:
    """The form of the pressure force."""
    if scene.second_liquid is not None and scene.method.pressure_force == "sum":
        return SUM_OF_TWO
    return PRESSURE_FORCES[chosen(scene.method.pressure_force, PRESSURE_FORCES, "method.pressure_force")]


def friction_of(scene: SphScene) -> Friction:
    """The form of the viscous force. The default is correct at a possible free surface, and where two viscosities meet;
    there div(eta grad v) is not the divergence of the viscous stress. Nor is it where the viscosity varies within a
    liquid, except in shear along walls, for which full tanks use div(eta grad v): with the other form, speeds in a
    channel with 20 particles across are 4 % too high.
    """
    if scene.method.viscosity_model == "automatic":
        at_surface = "corrected" if scene.method.pressure_force == "corrected" else "monaghan"
        return FRICTIONS[at_surface if free_surface(scene) or scene.second_liquid is not None else "morris"]
    return FRICTIONS[chosen(scene.method.viscosity_model, FRICTIONS, "method.viscosity_model")]


def acting_friction(scene: SphScene) -> Friction | None:
    """The form of the viscous force; None for an inviscid liquid."""
    return friction_of(scene) if is_viscous(scene) else None


def is_viscous(scene: SphScene) -> bool:
    """Whether the liquid has a viscosity, molecular or by eddies."""
    return bool(filled(scene.liquid).viscosity) or scene.liquid.rheology is not None or turbulent(scene)


def free_surface(scene: SphScene) -> bool:
    """Whether a part of the surface of the liquid may move: a side is open, liquid may leave but not enter, the volume
    of the tank changes, or the tank is not full.
    """
    kinds = {side.kind for side in sides_of(scene)}
    drains = "open" in kinds or ("outflow" in kinds and "inflow" not in kinds)
    return drains or room_changes(scene) or not full(scene)


def room_changes(scene: SphScene) -> bool:
    """Whether the volume of the tank changes: sides move, other than two opposite ones together."""
    sides = sides_of(scene)
    return any(one.motion != other.motion for one, other in zip(sides[::2], sides[1::2], strict=True))


SLIGHT = 2e-3
"""The volume that may be missing by rounding and sampling, over the volume of a full tank and over
that of a particle.
"""


@functools.lru_cache(maxsize=8)
def _lacking(room: tuple[Any, ...], spacing: float) -> float:
    """The volume that neither liquid nor solids fill, over that of the tank (see `full`)."""
    tank, fluid, solids, single = room
    box = Box(np.array(tank.low), np.array(tank.high))
    parts = [*(part_of(region, spacing) for region in fluid), *(solid_of(spec, tank) for spec in solids)]
    return 1.0 - (covered_volume(box, parts) + float(single)) / float(box.volume())


def full(scene: SphScene) -> bool:
    """Whether liquid and solids fill the tank, judged by their volume, since liquid may touch all sides of a tank with
    air.
    """
    single = sum(_volume_of(region, scene) for region in scene.fluid if region.particles is not None)
    shapes = tuple(region for region in scene.fluid if region.particles is None)
    lacking = _lacking((scene.tank, shapes, (*scene.obstacles, *scene.bodies), single), scene.spacing)
    volume = math.prod(high - low for low, high in zip(scene.tank.low, scene.tank.high, strict=True))
    return lacking <= max(SLIGHT, scene.spacing ** len(scene.tank.low) / volume)


def _volume_of(region: RegionSpec, scene: SphScene) -> float:
    """The volume of a region of single particles without masses: that of lattice cells."""
    table = region.particles
    if table is None or not table.masses:
        return 0.0 if table is None else float(len(table.positions) * scene.spacing ** len(scene.tank.low))
    density = np.array(table.densities or (liquid_in(region, scene).density,))
    return float(np.sum(np.array(table.masses) / density))


def fixed_volume(scene: SphScene) -> bool:
    """Whether walls and periodic sides fix the volume of the liquid. Without gravity a uniform pressure has no effect,
    and the density is that of the particles.
    """
    closed = all(side.kind in ("wall", "periodic") for side in sides_of(scene))
    return closed and bool(held_pull(scene).any()) and not free_surface(scene)


def smallest_extent(scene: SphScene) -> float:
    """The smallest extent of any region of liquid (m)."""
    bounds = [part_of(region, scene.spacing).bounds() for region in scene.fluid]
    return float(min((high - low).min() for low, high in bounds))


def shifting_of(scene: SphScene) -> str:
    """The shifting method by its name. Without a free surface, flows accumulate particles along
    their stagnation lines.
    """
    name = scene.method.shifting
    if name == "automatic":
        return "delta-plus" if not free_surface(scene) and not pressure_force_of(scene).transported else "none"
    return chosen(name, SHIFTINGS, "method.shifting")


def tension_of(scene: SphScene) -> str:
    """The model of surface tension by its name. The name of a liquid sets the value, but does not select a model."""
    name = scene.method.surface_tension_model
    if scene.second_liquid is not None:
        return "csf" if name != "none" and scene.second_liquid.interface_tension else "none"
    if name == "automatic":
        return "csf" if scene.liquid.surface_tension else "none"
    return chosen(name, TENSIONS, "method.surface_tension_model") if filled(scene.liquid).surface_tension else "none"


def color_reach_of(scene: SphScene) -> float:
    """The range of the color kernel (m); zero without the continuum surface force."""
    return TENSIONS[tension_of(scene)].color_reaches[len(scene.tank.low)] * scene.spacing


def contact_angle_of(scene: SphScene, spec: SideSpec | ObstacleSpec | BodySpec) -> float:
    """The contact angle (rad) of the liquid at a side, an obstacle or a body."""
    given = scene.liquid.contact_angle if spec.contact_angle is None else spec.contact_angle
    return 0.5 * math.pi if given is None else given


def contact_cosine(scene: SphScene, spec: SideSpec | ObstacleSpec | BodySpec) -> float:
    """The cosine of that contact angle: exactly zero at a right angle."""
    angle = contact_angle_of(scene, spec)
    return 0.0 if angle == 0.5 * math.pi else math.cos(angle)


def require_wetting(scene: SphScene) -> None:
    """Raise SceneError for contact angles without effect: without surface tension, or with a model that does not
    support them.
    """
    named = {"liquid": scene.liquid, **{f"tank.{name}": getattr(scene.tank, name) for name in scene.sides}}
    named |= {f"obstacles[{index}]": spec for index, spec in enumerate(scene.obstacles)}
    named |= {f"bodies[{index}]": spec for index, spec in enumerate(scene.bodies)}
    given = [f"{path}.contact_angle" for path, spec in named.items() if spec.contact_angle is not None]
    model = tension_of(scene)
    if given and model != "csf":
        cure = (
            "has no effect without surface tension; give liquid.surface_tension, or remove it"
            if model == "none"
            else f"is 90 degrees under surface_tension_model = '{model}'; use 'csf', or remove it"
        )
        raise SceneError([Fault(path, cure) for path in given])
    wetted = bool(wet_walls(scene)) or bool(scene.obstacles or scene.bodies)
    unread = [path for path in given if path.startswith("tank") and scene.tank.walls == "reflect"]
    unread += ["liquid.contact_angle"] * ("liquid.contact_angle" in given and not wetted)
    if unread:
        message = "has no effect: there are only open sides, or walls that reflect and have no contact angle"
        raise SceneError([Fault(path, message) for path in unread])


def wet_walls(scene: SphScene) -> dict[str, SideSpec]:
    """The sides at which the liquid has a contact angle: all walls except those that only reflect."""
    sides = {name: getattr(scene.tank, name) for name in scene.sides}
    return {} if scene.tank.walls == "reflect" else {name: side for name, side in sides.items() if side.kind == "wall"}


def turbulent(scene: SphScene) -> bool:
    """Whether eddies smaller than particles add a viscosity."""
    return TURBULENCES[chosen(scene.method.turbulence, TURBULENCES, "method.turbulence")]


def require_right_split(scene: SphScene) -> None:
    """Raise SceneError for a scene whose pressure would be wrong, with the reason."""
    split = scene.method.pressure_split
    if split == "none" or scene.method.allow_invalid_split:
        return
    reason = hydrostatic_fault(
        added=True, gravity_acts=split == "original", in_forces=False, free_surface=free_surface(scene)
    )
    if reason:
        raise SceneError([Fault("method.pressure_split", f"got {split!r}; {reason}; use 'none'")])


def liquid_in(region: RegionSpec, scene: SphScene) -> FluidSpec:
    """The liquid of a region, with density, viscosity and tension."""
    second = scene.second_liquid
    return filled(scene.liquid if second is None or region.liquid == "first" else second.alone)


WATER = 1000.0
"""kg/m^3, of a liquid without a name or a density."""
FILLED = ("density", "viscosity", "surface_tension")


def substance_of(given: FluidSpec) -> LiquidProperties | None:
    """The named liquid at its temperature. Raises SceneError."""
    if not given.name:
        given_keys = [key for key in ("temperature", "salinity") if getattr(given, key) is not None]
        if given_keys:
            raise SceneError([Fault(f"liquid.{given_keys[0]}", 'has no effect without a name; write name = "water"')])
    return named_liquid(given)


def filled(given: FluidSpec) -> FluidSpec:
    """The liquid with density, viscosity and surface tension: values in the scene override those of the named liquid. A
    liquid with a rheology has no other viscosity.
    """
    named = substance_of(given)
    density, viscosity, tension = (WATER, 0.0, 0.0) if named is None else [getattr(named, key) for key in FILLED]
    viscosity = 0.0 if given.rheology is not None else viscosity
    return dataclasses.replace(
        given,
        density=density if given.density is None else given.density,
        viscosity=viscosity if given.viscosity is None else given.viscosity,
        surface_tension=tension if given.surface_tension is None else given.surface_tension,
    )


def material_rows(given: FluidSpec) -> list[tuple[str, str, str]]:
    """The rows of `check` on the material, with the origin of each number."""
    named, full = substance_of(given), filled(given)
    units = {"density": "kg/m^3", "viscosity": "Pa s", "surface_tension": "N/m"}
    origin = "default" if named is None else f"{named.name} at {named.temperature - ICE_POINT:.4g} degrees Celsius"
    return [
        (key.replace("_", " "), f"{getattr(full, key):.5g} {units[key]}", origin if getattr(given, key) is None else "")
        for key in FILLED
        if getattr(full, key) or (named is not None and not (key == "viscosity" and given.rheology is not None))
    ]


PRESSURE_LAWS: dict[str, list[Source]] = {
    "tait": [states.tait_pressure, states.numerical_sound_speed],
    "incompressible": [incompressible.free_correction, incompressible.decrease, incompressible.diagonal],
}


def laws_of(scene: Any) -> list[Source]:
    """The sources of the kernel, pressure, diffusion, friction, tension and time step of a scene."""
    liquid, name = filled(scene.liquid), diffusion_of(scene, gravity_of(scene))
    excess = DIFFUSIONS[name].excess
    form = kernels.KERNELS[scene.method.kernel]
    laws: list[Source] = [form.value, *PRESSURE_LAWS[scene.method.pressure]]
    laws += [density_diffusion.strength, excess] if excess is not None else []
    if pressure_force_of(scene).corrected:
        laws += [kernels.missing_neighbors, kernels.correction_share]
    laws += [viscous.artificial_viscosity] if artificial_viscosity_of(scene) else []
    laws += [viscous.acoustic_damping] if acoustic_damping_of(scene) else []
    laws += [wall_forces.impact_braking] if impacts_dissipate(scene) else []
    laws += [wall_forces.covered_part] if scene.gauges else []
    if is_viscous(scene):
        laws += [friction_of(scene).law]
    laws += TENSIONS[tension_of(scene)].laws
    laws += [viscous.eddy_viscosity, viscous.subparticle_stress] if turbulent(scene) else []
    laws += [yield_stress.apparent_viscosity] if liquid.rheology is not None else []
    if shifting_of(scene) != "none":
        laws += [incompressible.shifting_coefficient, incompressible.tensile_weight]
    limit = time_step_limits.acoustic_limit if pressure_of(scene).compressible else time_step_limits.advective_limit
    return [*laws, limit, time_step_limits.force_limit, *correlations_of(scene.liquid.name)]
