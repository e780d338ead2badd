"""The scene of the SPH model: a liquid in a tank, and how it is computed."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from ecume.scenes.common import Common
from ecume.scenes.faults import Inconsistent, Path
from ecume.scenes.quantities import (
    MOST_STEPS,
    STRICT,
    Color,
    Duration,
    GravityVector,
    LawName,
    LiquidViscosity,
    Motion,
    Name,
    Place,
    PositiveDensity,
    Proportion,
    Size,
    Switch,
    Tension,
    downwards,
)
from ecume.scenes.sph.passive_particles import PassiveTracerSpec, carried_faults
from ecume.scenes.sph.solids import BodySpec, ObstacleSpec, ShapeSpec
from ecume.scenes.sph.sources import ParticlesSpec, particle_faults
from ecume.scenes.sph.tank import BaseExcitationSpec, GaugeSpec, TankSpec, gauge_faults
from ecume.units import Number, Rate, Speed, Temperature

Gradient = Annotated[Rate, Field(ge=-1e6, le=1e6)]
PositiveNumber = Annotated[Number, Field(gt=0.0, le=1e6)]
PositiveSpeed = Annotated[Speed, Field(gt=0.0, le=1e5)]
Exponent = Annotated[Number, Field(ge=1.0, le=20.0)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class FluidSpec:
    """The liquid as a material. What is left out comes from `name` and `temperature`, or else is that of water."""

    name: Name = ""
    """A liquid of the table in `ecume.laws.liquids`, such as `water`; it provides the properties that are not given."""
    temperature: Annotated[Temperature, Field(gt=0.0, le=1e4)] | None = None
    """of a named liquid: `"20 degC"`, or kelvin; by default 20 degrees Celsius"""
    salinity: Proportion | None = None
    """kg of salt a kg of seawater; by default 0.035"""
    density: PositiveDensity | None = None
    """kg/m^3, where the gauge pressure is zero"""
    viscosity: LiquidViscosity | None = None
    """Pa s; zero by default without a name"""
    surface_tension: Tension | None = None
    """N/m; zero by default"""
    sound_speed: PositiveSpeed | None = None
    """m/s of the *numerical* liquid; by default ten times the fastest speed to be expected"""
    maximum_speed: PositiveSpeed | None = None
    """m/s, the maximum speed to be expected; by default that of a free fall through the liquid's depth"""
    tait_exponent: Exponent = 7.0
    """gamma of Tait's equation; 1 is a linear law"""
    atmospheric_pressure: Annotated[Number, Field(ge=0.0, le=1e9)] = 0.0
    """Pa, added where a pressure is called absolute"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class RegionSpec(ShapeSpec):
    """A part of space that is full of liquid at the start. Exactly one shape.

    In a file it may also be `particles_from = "TABLE.csv"` or `outline_from = "FILE"` (STL in space, DXF in the plane).
    """

    particles: ParticlesSpec | None = None
    """single particles, of a table or of another run"""
    triangles: tuple[tuple[Place, Place, Place], ...] = ()
    """of a closed surface, three dimensions only (m)"""
    velocity: Motion | None = None
    """m/s of all its liquid"""
    velocity_gradient: tuple[tuple[Gradient, ...], ...] = ()
    """d velocity_a / d x_b (1/s), a matrix, about `center` or the origin: rotation, strain, shear"""
    flow: Literal["", "taylor-green", "standing-wave", "poiseuille"] = ""
    """A velocity field by name, of speed `flow_speed`: `taylor-green` has one vortex pair a tank length;
    `standing-wave` is a small wave twice as long as the tank, at an instant when its surface is flat and rises at the
    left wall; `poiseuille` flows along x between bottom and top, with that mean speed
    """
    flow_speed: PositiveSpeed = 1.0
    """m/s"""
    color: Color | None = None
    """`#rrggbb`, or a plain English name"""

    def _further(self) -> dict[str, bool]:
        return {"particles": self.particles is not None, "triangles": bool(self.triangles)}


@dataclass(frozen=True, kw_only=True, config=STRICT)
class CentralForceSpec:
    """A pull towards a point that grows with the distance: acceleration - rate^2 (x - center)."""

    angular_frequency: Annotated[Rate, Field(gt=0.0, le=1e6)]
    """1/s, of the swing of a particle alone"""
    center: Place
    """m"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class MethodSpec:
    """The method of solution. The defaults are those that keep a tank at rest best."""

    kernel: LawName = "wendland-c2"
    """a name of `ecume.laws.kernels.KERNELS`"""
    smoothing_ratio: PositiveNumber | None = None
    """smoothing length in spacings; by default what suits the kernel"""
    nonnegative_wall_pressure: Switch | None = None
    """whether dummies push only, never pull; by default where the liquid may leave them: not in tanks that are full"""
    density_diffusion: LawName = "automatic"
    """`hydrostatic` (exact for a Tait liquid at rest; the default under gravity), `antuono` (the default without),
    `linear`, `molteni` (for comparison: it lifts the surface) or `none`
    """
    diffusion_coefficient: Annotated[Number, Field(ge=0.0, le=1.0)] = 0.1
    """delta of the density diffusion"""
    artificial_viscosity: Annotated[Number, Field(ge=0.0, le=10.0)] | None = None
    """alpha; by default 0.02, or zero where the liquid has a viscosity of its own"""
    viscosity_model: LawName = "automatic"
    """of a viscous liquid: `monaghan` along the lines between particles (right at a free surface, the default where
    there is one), or `morris` (the default in tanks that are full)
    """
    pressure_force: LawName = "sum"
    """`sum` (p_i + p_j), `monaghan` (p/rho^2) or `transport` (density-weighted, with the transport velocity)"""
    pressure_split: Literal["none", "modified", "original"] = "none"
    """`none`: Tait's pressure is the whole; `modified`: gravity is left out and the hydrostatic pressure added for
    output, right in closed and full tanks only; `original`: gravity acts and it is added all the same, which counts it
    twice. What would be wrong is refused.
    """
    allow_invalid_split: Switch = False
    """run a refused `pressure_split` nevertheless, to see what comes of it"""
    initial_pressure: Literal["hydrostatic", "zero"] = "hydrostatic"
    """whether the liquid starts with the pressure of its depth and of its motion, as far as known, or with none"""
    jitter: Annotated[Number, Field(ge=0.0, le=0.5)] = 0.0
    """how far particles start from their lattice, at most, in spacings"""
    turbulence: LawName = "none"
    """`smagorinsky`: eddies smaller than particles add a viscosity (0.12 spacing)^2 |S| to the liquid's own; `none`"""
    surface_tension_model: LawName = "automatic"
    """`csf` (continuum surface force, the slope of the surface's energy on nodes; the default where
    `liquid.surface_tension` is given), `cohesion` (attraction between particles, which press each other: discs in a
    plane only, roughly), or `none`
    """
    shifting: LawName = "automatic"
    """`delta-plus` shifts particles towards even spacing, away from the surface (the default where the liquid fills a
    tank without an open side, and nothing else spreads it); `none` (the default elsewhere)
    """
    background_pressure: Annotated[Number, Field(ge=0.0)] | None = None
    """Pa, of the transport velocity; by default rho0 c0^2"""
    precision: Literal["double", "single"] = "double"
    """of the sums over neighbors; states are always double"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class IntegrationSpec:
    """The time integration."""

    integrator: LawName = "symplectic"
    """`symplectic` (density at mid-step) or `verlet` (one sum a step)"""
    time_step: Duration | None = None
    """s; by default the largest that the Courant number and the viscosity allow"""
    courant_number: Annotated[Number, Field(gt=0.0, le=2.0)] = 0.25
    """time step over smoothing length / (sound speed + maximum speed)"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SphScene(Common):
    """A liquid in a tank, in two or three dimensions (as many as the tank's corners have coordinates)."""

    model: Literal["sph"] = "sph"
    """Which model."""
    spacing: Size
    """between particles at the start (m)"""
    liquid: FluidSpec = FluidSpec()
    """The material."""
    fluid: tuple[RegionSpec, ...] = ()
    """Where there is liquid at the start."""
    tank: TankSpec
    """What holds it."""
    obstacles: tuple[ObstacleSpec, ...] = ()
    """What stands in it."""
    bodies: tuple[BodySpec, ...] = ()
    """What moves in it."""
    passive_tracers: tuple[PassiveTracerSpec, ...] = ()
    """What the liquid carries along."""
    gauges: tuple[GaugeSpec, ...] = ()
    """Where pressure, velocity or level are read at every frame."""
    base_excitation: BaseExcitationSpec | None = None
    """How it is shaken."""
    gravity: GravityVector = (9.81,)
    """m/s^2: a magnitude, downwards (along -y), or a vector"""
    central_force: CentralForceSpec | None = None
    """What pulls towards a point, beside gravity; at bodies, too."""
    method: MethodSpec = MethodSpec()
    """How it is computed."""
    integration: IntegrationSpec = IntegrationSpec()
    """The time stepping."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        dimension = len(self.tank.low)
        object.__setattr__(self, "gravity", downwards(self.gravity, dimension))
        complaints = [*_dimensions(self, dimension), *gauge_faults(self.gauges, self.tank), *_steps(self)]
        complaints += carried_faults(self.passive_tracers, self.tank, self.method.turbulence)
        if complaints:
            raise Inconsistent(complaints)
        return self


Complaints = list[tuple[Path, str]]


def _dimensions(scene: SphScene, dimension: int) -> Complaints:
    found: Complaints = []
    if len(scene.gravity) != dimension:
        found.append((("gravity",), f"got {len(scene.gravity)} numbers; the tank has {dimension} dimensions"))
    if scene.central_force is not None and len(scene.central_force.center) != dimension:
        came = f"got {len(scene.central_force.center)} numbers"
        found.append((("central_force", "center"), f"{came}; the tank has {dimension} dimensions"))
    if not scene.fluid:
        found.append((("fluid",), "there is no liquid; write a [[fluid]] table with low and high"))
    rows = (
        (scene.base_excitation.amplitude or (), *scene.base_excitation.accelerations) if scene.base_excitation else ()
    )
    for row in rows:
        if row and len(row) != dimension:
            found.append((("base_excitation",), f"got {len(row)} numbers; the tank has {dimension} dimensions"))
    pieces = (("fluid", scene.fluid), ("obstacles", scene.obstacles), ("bodies", scene.bodies))
    for table, specs in pieces:
        for index, spec in enumerate(specs):
            found += [((table, index, *path), message) for path, message in _of_shape(spec, dimension)]
    return found


def _of_shape(spec: ShapeSpec, dimension: int) -> Complaints:
    found: Complaints = []
    for key in ("low", "center", "velocity", "velocity_gradient"):
        value = getattr(spec, key, None)
        if value and len(value) != dimension:
            found.append(((key,), f"got {len(value)} numbers; the tank has {dimension} dimensions"))
    if isinstance(spec, RegionSpec) and spec.particles is not None:
        found += particle_faults(spec.particles, dimension)
    if isinstance(spec, RegionSpec) and spec.triangles and dimension == 2:
        found.append((("triangles",), "a surface is for tanks in three dimensions"))
    if spec.vertices and dimension == 3:
        found.append((("vertices",), "a polygon is for tanks in two dimensions"))
    if isinstance(spec, BodySpec) and isinstance(spec.spin, tuple) and dimension == 2:
        found.append((("spin",), "got 3 numbers; in two dimensions a body turns about z alone: one number"))
    return found


def _steps(scene: SphScene) -> Complaints:
    step = scene.integration.time_step
    if step is not None and step > scene.frame_every * (1 + 1e-9):
        return [(("integration", "time_step"), f"got {step:g} s, longer than frame_every, {scene.frame_every:g} s")]
    if step is not None and scene.duration / step > MOST_STEPS:
        return [(("integration", "time_step"), f"gives more than {MOST_STEPS:.0e} steps")]
    return []
