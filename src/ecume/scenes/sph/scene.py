"""The scene of the SPH model: a liquid in a tank, and the numerical methods."""

from __future__ import annotations

import itertools
import math
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from ecume.scenes.common import Common, dataclass
from ecume.scenes.faults import Inconsistent, Path
from ecume.scenes.quantities import (
    BODY_MASS,
    MOST_STEPS,
    STRICT,
    Color,
    Duration,
    Gradient,
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
    Up,
    WettingAngle,
    downwards,
    sides_along,
    up_faults,
)
from ecume.scenes.sph.extents import size_faults
from ecume.scenes.sph.motions import BaseExcitationSpec, RollSpec, formula_faults
from ecume.scenes.sph.solids import (
    BodySpec,
    ObstacleSpec,
    PassiveTracerSpec,
    ShapeSpec,
    Solids,
    extent,
    name_faults,
    passive_tracer_faults,
    solid_names,
)
from ecume.scenes.sph.sources import ParticlesSpec, particle_faults
from ecume.scenes.sph.tank import GaugeSpec, TankSpec, gauge_faults, side_faults
from ecume.units import AngularVelocity, Number, Pressure, Speed, Temperature

PositiveNumber = Annotated[Number, Field(gt=0.0, le=1e6)]
PositiveSpeed = Annotated[Speed, Field(gt=0.0, le=1e5)]
Exponent = Annotated[Number, Field(ge=1.0, le=20.0)]


Consistency = Annotated[Number, Field(ge=0.0, le=1e9)]
FlowExponent = Annotated[Number, Field(ge=0.1, le=2.0)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class RheologySpec:
    """A viscosity that depends on the rate of strain g: the stress is yield_stress + consistency g^exponent."""

    consistency: Consistency = 0.0
    """The factor K of the power law (Pa s^n, with n the exponent): with exponent 1 the plastic viscosity. Effect: the
    flow above yield is slower in proportion."""
    exponent: FlowExponent = 1.0
    """The exponent n of the power law: below 1 the liquid thins when sheared, above 1 it thickens; 1 is Bingham's
    liquid. Effect: makes profiles in channels blunter or sharper."""
    yield_stress: Annotated[Pressure, Field(ge=0.0, le=1e9)] = 0.0
    """The shear stress below which the liquid does not flow (Pa). Effect: heaps stop before they are flat."""
    largest_viscosity: Annotated[LiquidViscosity, Field(gt=0.0)] | None = None
    """The viscosity with which the liquid creeps where it should not flow (Pa s); by default 30 times that at the
    expected rate of strain. Effect: larger values creep less and shorten the time step."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.consistency == 0.0 and self.yield_stress == 0.0:
            raise Inconsistent([((), "expected a consistency, a yield_stress, or both")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class FluidSpec:
    """The properties of the liquid. By default `name` and `temperature` determine them; without a name the liquid is
    inviscid and has 1000 kg/m^3. Surface tension, no-slip walls and the artificial viscosity are switched on by
    separate keys.
    """

    name: Name = ""
    """A liquid of the table in `ecume.laws.liquids`, such as `water`, at the `temperature`. Effect: provides the
    density, viscosity and surface tension that are not given."""
    temperature: Annotated[Temperature, Field(gt=0.0, le=1e4)] | None = None
    """The temperature of a named liquid (K); text such as `20 degC` is allowed; by default 20 degrees Celsius.
    Effect: a warmer liquid is less viscous."""
    salinity: Proportion | None = None
    """The mass of salt per mass of seawater; by default 0.035. Effect: saltier water is denser."""
    density: PositiveDensity | None = None
    """The density where the gauge pressure is zero (kg/m^3); by default that of the named liquid, or 1000. Effect:
    pressures and forces are proportional to it."""
    viscosity: LiquidViscosity | None = None
    """The dynamic viscosity (Pa s); by default that of the named liquid, or 0. Effect: damps the flow; a viscosity
    that is given here makes walls no-slip, and the artificial viscosity 0, by default."""
    rheology: RheologySpec | None = None
    """A viscosity that depends on the rate of strain, in place of `viscosity`. Effect: the liquid thins, thickens or
    yields when it is sheared."""
    surface_tension: Tension | None = None
    """The surface tension (N/m); by default that of the named liquid, or 0. Effect: contracts the surface; small drops
    need short time steps. That of a named liquid acts with `surface_tension_model = "csf"` only."""
    contact_angle: WettingAngle | None = None
    """The contact angle at walls, obstacles and bodies (rad, or text such as `60 deg`), under surface tension; by
    default 90 degrees. Example: `"60 deg"`. Effect: liquid spreads on walls below 90 degrees, and beads above."""
    sound_speed: PositiveSpeed | None = None
    """The numerical speed of sound (m/s); by default ten times the maximum speed. Effect: larger values compress the
    liquid less and shorten the time step."""
    maximum_speed: PositiveSpeed | None = None
    """The largest expected speed of the flow (m/s); by default that of a free fall of liquid and bodies to the end of
    the tank. Effect: the speed of sound follows from it: too small values make the liquid compressible, too large ones
    cost time."""
    tait_exponent: Exponent = 7.0
    """The exponent gamma of Tait's equation of state; 1 is linear. Effect: larger values stiffen the liquid under
    compression."""
    atmospheric_pressure: Annotated[Pressure, Field(ge=0.0, le=1e9)] = 0.0
    """The pressure above the liquid, which is part of absolute pressures (Pa). Example: `"1 atm"`. Effect: shifts
    absolute pressures in gauges, figures, pages and exports; none on the motion."""

    @property
    def sticks(self) -> bool:
        """Whether walls are no-slip by default, which is the case if the scene gives a viscosity."""
        return bool(self.viscosity) or self.rheology is not None


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SecondLiquidSpec:
    """Another liquid in the tank, in the regions with `liquid = "second"`; it does not mix with the first. By default
    `name` and `temperature` set its properties; without a name it is inviscid.
    """

    name: Name = ""
    """A liquid of the table in `ecume.laws.liquids`, at the `temperature`. Effect: provides the density and viscosity
    that are not given."""
    temperature: Annotated[Temperature, Field(gt=0.0, le=1e4)] | None = None
    """The temperature of a named liquid (K); text such as `20 degC` is allowed; by default 20 degrees Celsius.
    Effect: a warmer liquid is less viscous."""
    density: PositiveDensity | None = None
    """The density where the gauge pressure is zero (kg/m^3), at most 1000 times that of the first liquid, at least a
    thousandth of it; by default that of the named liquid. Effect: the lighter liquid rises."""
    viscosity: LiquidViscosity | None = None
    """The dynamic viscosity (Pa s); by default that of the named liquid, or 0. Effect: damps the flow; both liquids
    have a viscosity, or none."""
    interface_tension: Tension = 0.0
    """The tension of the interface between both liquids (N/m), which must not meet the free surface of the denser one.
    Example: `"50 mN/m"`. Effect: contracts the interface; drops become round."""
    sound_speed: PositiveSpeed | None = None
    """The numerical speed of sound (m/s); by default that with which both liquids are equally stiff, so that it is
    larger in the lighter one. Effect: smaller values allow longer time steps, and let the liquid be compressed more."""
    tait_exponent: Exponent = 7.0
    """The exponent gamma of Tait's equation of state; 1 is linear. Effect: larger values stiffen the liquid under
    compression."""

    @model_validator(mode="after")
    def _has_density(self) -> Self:
        if self.density is None and not self.name:
            raise Inconsistent([(("density",), "expected a density, or the name of a liquid")])
        return self

    @property
    def alone(self) -> FluidSpec:
        """The same properties as a `FluidSpec`; its surface tension is that of the interface."""
        return FluidSpec(
            name=self.name, temperature=self.temperature, density=self.density, viscosity=self.viscosity,
            surface_tension=self.interface_tension, sound_speed=self.sound_speed, tait_exponent=self.tait_exponent,
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True, config=STRICT)
class RegionSpec(ShapeSpec):
    """A region that is full of liquid at the start, given by exactly one shape.

    In a file it may also be `particles_from = "TABLE.csv"` or `outline_from = "FILE"` (STL in 3D, DXF in 2D).
    """

    liquid: Literal["first", "second"] = "first"
    """The liquid of the region: `first`, that of `[liquid]`, or `second`, that of `[second_liquid]`. Effect: selects
    density, viscosity and speed of sound."""
    particles: ParticlesSpec | None = None
    """Individual particles from a table or another run, instead of a shape. Effect: replaces the lattice of
    particles."""
    velocity: Motion | None = None
    """The initial velocity of the region (m/s). Effect: moves the region as a whole."""
    velocity_gradient: tuple[tuple[Gradient, ...], ...] = ()
    """The initial velocity gradient d v_a / d x_b (1/s), a matrix about `center` or the origin. Effect: adds
    rotation, strain or shear."""
    flow: Literal["", "taylor-green", "standing-wave", "poiseuille"] = ""
    """A named initial velocity field of speed `flow_speed`: `taylor-green` has one vortex pair per length of the
    tank; `standing-wave` is a small wave twice as long as the tank, with a flat surface that rises at the left
    wall; `poiseuille` flows along x between bottom and top. Effect: selects the initial flow."""
    flow_speed: PositiveSpeed = 1.0
    """The speed of the named flow (m/s); for `poiseuille` the mean one. Effect: scales the initial flow."""
    color: Color | None = None
    """The color in pictures: `#rrggbb`, or an English name. Effect: none on the motion."""

    def _further(self) -> dict[str, bool]:
        return {"particles": self.particles is not None}


@dataclass(frozen=True, kw_only=True, config=STRICT)
class CentralForceSpec:
    """A force towards a point that is proportional to the distance: acceleration - rate^2 (x - center)."""

    angular_frequency: Annotated[AngularVelocity, Field(gt=0.0, le=1e6)]
    """The angular frequency w of a lone particle in the force -m w^2 (x - center) (rad/s). Effect: the force grows
    with its square."""
    center: Place
    """The point toward which the force acts (m). Effect: shifts the equilibrium."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class MethodSpec:
    """The method of solution. With the defaults, a tank at rest remains at rest with the smallest errors."""

    pressure: LawName = "tait"
    """How the pressure is computed: `tait`, from the density of a weakly compressible liquid; or `incompressible`, by
    solving for the pressure that keeps the density, without sound waves. Effect: `incompressible` allows time steps
    about ten times as long, which cost more each."""
    kernel: LawName = "wendland-c2"
    """The smoothing kernel, a name of `ecume.laws.kernels.KERNELS`, such as `wendland-c4`. Effect: wider kernels are
    smoother and cost more."""
    smoothing_ratio: PositiveNumber | None = None
    """The smoothing length, divided by the particle spacing; by default the value that suits the kernel. Effect:
    larger ratios have more neighbors: smoother sums, more cost."""
    nonnegative_wall_pressure: Switch | None = None
    """Whether walls of dummy particles only repel; by default true where the liquid can leave them, false in full
    tanks. Example: `true`. Effect: false lets walls hold liquid that moves away."""
    density_diffusion: LawName = "automatic"
    """The density diffusion: `hydrostatic`, exact for a liquid at rest and the default under gravity; `antuono`, the
    default without, and under surface tension; `linear`, `molteni` or `none`. Effect: removes pressure noise; `molteni`
    lifts the surface."""
    diffusion_coefficient: Annotated[Number, Field(ge=0.0, le=1.0)] = 0.1
    """The coefficient delta of the density diffusion. Effect: larger values smooth the pressure more strongly."""
    artificial_viscosity: Annotated[Number, Field(ge=0.0, le=10.0)] | None = None
    """The coefficient alpha of the artificial viscosity; by default 0.02, or 0 where `liquid.viscosity` is given, and
    where a side moves or a standing wave is set up, so that waves last. Effect: larger values damp
    noise and motion."""
    acoustic_damping: Annotated[Number, Field(ge=0.0, le=2.0)] | None = None
    """The coefficient alpha of the acoustic damping, a bulk viscosity; by default 2 where the liquid has a free surface
    and artificial viscosity is not set to 0, less with very light bodies, 0.5 where gradients of the pressure are
    completed, otherwise 0. Effect: damps sound waves, such as those of impacts."""
    viscosity_model: LawName = "automatic"
    """The viscous force: `monaghan` along the lines of centers, right at a free surface and between two liquids;
    `corrected`, the same with the part completed that has no neighbors there; `morris` along velocities, right in full
    tanks of one liquid; by default the one that fits. Effect: affects the damping near surfaces and walls."""
    pressure_force: LawName = "sum"
    """The pressure force: `sum` (p_i + p_j), `monaghan` (p/rho^2), `transport` (with the transport velocity) or
    `corrected` (with gradients completed at the free surface). Effect: `transport` keeps particles evenly spaced in
    full tanks; with `corrected` waves lose no energy by the method, but still water is less quiet."""
    pressure_split: Literal["none", "modified", "original"] = "none"
    """The treatment of the hydrostatic pressure: `none`, where the Tait pressure is complete; `modified`, where
    gravity is omitted and the hydrostatic pressure added for output, in closed and full tanks only; `original`,
    where gravity acts as well, which counts it twice. Effect: changes the pressures that are reported; wrong
    combinations are refused."""
    allow_invalid_split: Switch = False
    """Whether a refused `pressure_split` is run nevertheless. Effect: demonstrates the error of the combination."""
    initial_pressure: Literal["hydrostatic", "zero"] = "hydrostatic"
    """The initial pressure: `hydrostatic`, that of depth and motion, or `zero`. Effect: `zero` starts an oscillation
    of the column."""
    jitter: Annotated[Number, Field(ge=0.0, le=0.5)] = 0.0
    """The largest initial displacement from the lattice, in spacings. Effect: removes the order of the lattice."""
    turbulence: LawName = "none"
    """The subparticle turbulence: `smagorinsky` adds the eddy viscosity (0.12 spacing)^2 |S|; or `none`. Effect:
    damps shear at the scale of the particles."""
    surface_tension_model: LawName = "automatic"
    """The model of surface tension: `csf` (continuum surface force), `cohesion` (attraction between particles, for
    discs in 2D only) or `none`; by default `csf` where there is surface tension. Effect: `csf` has the tension
    that is given, `cohesion` approximately."""
    shifting: LawName = "automatic"
    """The particle shifting: `delta-plus` toward even spacing, the default in full tanks, or `none`. Effect:
    prevents voids and clumps."""
    background_pressure: Annotated[Pressure, Field(ge=0.0)] | None = None
    """The background pressure of the transport velocity (Pa); by default rho c^2. Effect: larger values even out the
    spacing faster."""
    precision: Literal["double", "single"] = "double"
    """The floating-point precision of sums over neighbors, `double` or `single`; states are always double. Effect:
    `single` is faster and less accurate."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class IntegrationSpec:
    """The time integration."""

    integrator: LawName = "automatic"
    """The integration scheme: `symplectic` (density at mid-step, the default) or `verlet` (one sum per step) for
    weakly compressible liquids, `projection` for incompressible ones. Effect: `verlet` is cheaper per step and less
    accurate."""
    time_step: Duration | None = None
    """The time step (s); by default the largest that the Courant number and the viscosity allow. Effect: smaller
    steps cost more; larger ones are refused."""
    courant_number: Annotated[Number, Field(gt=0.0, le=2.0)] = 0.25
    """The time step, divided by smoothing length over sound speed plus maximum speed. Effect: smaller values are
    more accurate and cost more."""
    pressure_tolerance: Annotated[Number, Field(gt=0.0, le=0.1)] | None = None
    """The r.m.s. error of the density that a step of an incompressible liquid may leave, divided by the density; by
    default 1e-4. Example: `1e-5`. Effect: smaller values need more iterations."""
    pressure_iterations: Annotated[int, Field(ge=1, le=100000)] | None = None
    """The largest number of iterations for the pressure of an incompressible liquid in a step; by default 500. Effect:
    a step that needs more ends the run with an error."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SphScene(Common):
    """A liquid in a tank, in two or three dimensions (as many as the tank's corners have coordinates)."""

    model: Literal["sph"] = "sph"
    """The model: a liquid in a tank, computed by smoothed particle hydrodynamics. Effect: selects the equations that
    are solved."""
    spacing: Size
    """The initial distance of particles (m). Effect: half of it has 4 times (2D) or 8 times (3D) as many particles
    and 8 or 16 times the cost."""
    liquid: FluidSpec = FluidSpec()
    """The properties of the liquid. Effect: they set inertia, viscosity, tension and speed of sound."""
    second_liquid: SecondLiquidSpec | None = None
    """Another liquid, which does not mix with the first. Effect: light regions rise, heavy ones sink."""
    fluid: tuple[RegionSpec, ...] = ()
    """The regions that contain liquid at the start. Effect: each region adds particles."""
    tank: TankSpec
    """The container of the liquid. Effect: determines walls and open sides."""
    obstacles: tuple[ObstacleSpec, ...] = ()
    """Fixed solids in the tank. Effect: the liquid flows around them."""
    bodies: tuple[BodySpec, ...] = ()
    """Rigid bodies that float, sink and collide, or follow a prescribed path. Effect: they move with the liquid and act
    on it."""
    passive_tracers: tuple[PassiveTracerSpec, ...] = ()
    """Particles that the liquid carries without reaction. Effect: none on the liquid."""
    gauges: tuple[GaugeSpec, ...] = ()
    """Points at which pressure, velocity or level are recorded. Effect: each gauge adds numbers to the frames."""
    base_excitation: BaseExcitationSpec | None = None
    """The imposed acceleration of the tank. Effect: makes the liquid slosh."""
    roll: RollSpec | None = None
    """The imposed rotation of the tank. Effect: makes the liquid slosh."""
    up: Up = "y"
    """The axis that points up: `y`, or `z` in 3D, as in most drawings. `bottom` and `top` are the sides across it,
    `front` and `back` those across the other one. Example: `"z"`. Effect: turns gravity, the sides of the tank, levels
    and pictures."""
    gravity: GravityVector = (9.81,)
    """The gravitational acceleration (m/s^2): a magnitude, downward, or a vector. Effect: pressures grow in
    proportion to it; a zero vector is weightless."""
    central_force: CentralForceSpec | None = None
    """A force toward a point, in addition to gravity, on liquid and bodies. Effect: holds a drop together."""
    method: MethodSpec = MethodSpec()
    """The spatial discretization. Effect: determines accuracy, noise and cost."""
    integration: IntegrationSpec = IntegrationSpec()
    """The time stepping. Effect: determines the error per step and the cost."""

    @property
    def numbers(self) -> frozenset[str]:
        """The names of the numbers of pressure and level gauges."""
        single = [(gauge, measure) for gauge in self.gauges for measure in gauge.quantities if measure != "velocity"]
        return frozenset(f"{name}_{measure}" for gauge, measure in single for name in gauge.names)

    @property
    def sides(self) -> tuple[str, ...]:
        """The names of the sides of the tank, low and high along each axis."""
        return sides_along(self.up, len(self.tank.low))

    @property
    def obstacle_names(self) -> tuple[str, ...]:
        """The names of the obstacles in numbers of frames."""
        return solid_names(self.obstacles, "obstacle")

    @property
    def body_names(self) -> tuple[str, ...]:
        """The names of the bodies in numbers of frames."""
        return solid_names(self.bodies, "body")

    @property
    def solid_labels(self) -> tuple[str, ...]:
        """The labels of obstacles and bodies in messages: their names, otherwise their places in the file."""
        tables: list[tuple[str, Solids]] = [("obstacles", self.obstacles), ("bodies", self.bodies)]
        return tuple(spec.name or f"{table}[{n}]" for table, specs in tables for n, spec in enumerate(specs))

    @property
    def up_axis(self) -> int:
        """The number of the axis that points up."""
        return "xyz".index(self.up)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        dimension = len(self.tank.low)
        if wrong := up_faults(self.up, dimension):
            raise Inconsistent(wrong)
        object.__setattr__(self, "gravity", downwards(self.gravity, dimension, self.up))
        complaints = [*_dimensions(self, dimension), *gauge_faults(self.gauges, self.tank), *_steps(self)]
        complaints += side_faults(self.tank, self.sides)
        complaints += _formula_faults(self)
        complaints += size_faults("obstacles", self.obstacles, self.spacing)
        complaints += size_faults("bodies", self.bodies, self.spacing)
        gauges = [name for gauge in self.gauges for name in gauge.names]
        complaints += name_faults((("obstacles", self.obstacles), ("bodies", self.bodies)), gauges)
        complaints += passive_tracer_faults(self.passive_tracers, self.tank, self.method.turbulence)
        complaints += _rheology_faults(self)
        complaints += _second_liquid_faults(self)
        if complaints:
            raise Inconsistent(complaints)
        return self


Complaints = list[tuple[Path, str]]


def _dimensions(scene: SphScene, dimension: int) -> Complaints:
    found: Complaints = []
    if len(scene.gravity) != dimension:
        found.append((("gravity",), f"got {len(scene.gravity)} numbers; the tank has {dimension} dimensions"))
    if scene.central_force is not None and len(scene.central_force.center) != dimension:
        got = f"got {len(scene.central_force.center)} numbers"
        found.append((("central_force", "center"), f"{got}; the tank has {dimension} dimensions"))
    if not scene.fluid:
        found.append((("fluid",), "there is no liquid; write a [[fluid]] table with low and high"))
    rows = (
        (scene.base_excitation.amplitude or (), *scene.base_excitation.accelerations, scene.base_excitation.formula)
        if scene.base_excitation
        else ()
    )
    for row in rows:
        if row and len(row) != dimension:
            found.append((("base_excitation",), f"got {len(row)} numbers; the tank has {dimension} dimensions"))
    if scene.roll is not None:
        found += [(("roll", *path), message) for path, message in scene.roll.dimension_faults(dimension)]
    found += _too_thin(scene)
    pieces = (("fluid", scene.fluid), ("obstacles", scene.obstacles), ("bodies", scene.bodies))
    for table, specs in pieces:
        for index, spec in enumerate(specs):
            found += [((table, index, *path), message) for path, message in _of_shape(spec, dimension)]
    return found


def _formula_faults(scene: SphScene) -> Complaints:
    """The faults of formulas of motions over the duration of the run."""
    sides = {name: getattr(scene.tank, name).motion for name in scene.sides}
    moved: list[tuple[Path, tuple[str, ...]]] = [
        (("tank", name, "motion"), (motion.formula,)) for name, motion in sides.items() if motion and motion.formula
    ]
    moved += [
        (("bodies", index, "motion"), body.motion.formulas()) for index, body in enumerate(scene.bodies) if body.motion
    ]
    if scene.roll is not None and scene.roll.formula:
        moved.append((("roll", "formula"), (scene.roll.formula,)))
    pulled = scene.base_excitation.formula if scene.base_excitation is not None else ()
    found = [(path, text) for path, texts in moved for text in formula_faults(texts, scene.duration, from_zero=True)]
    return found + [(("base_excitation",), text) for text in formula_faults(pulled, scene.duration, from_zero=False)]


LEAST_SIDE, LEAST_BODY = 0.5, 0.1
"""The smallest side of a tank, and of a body, in spacings."""


def _too_thin(scene: SphScene) -> Complaints:
    """The faults of tanks and bodies that are much smaller than the particle spacing."""
    found: Complaints = []
    for axis, (low, high) in zip("xyz", zip(scene.tank.low, scene.tank.high, strict=True), strict=False):
        if high - low < LEAST_SIDE * scene.spacing:
            limit = LEAST_SIDE * scene.spacing
            found.append(
                (("tank", "high"), f"the tank is {high - low:g} m wide along {axis}; expected {limit:g} m or more")
            )
    for index, body in enumerate(scene.bodies):
        thickness, limit = _smallest_extent(body), LEAST_BODY * scene.spacing
        if thickness < limit:
            message = f"is {thickness:.3g} m thick; expected at least a tenth of the spacing, {limit:.3g} m"
            found.append((("bodies", index), message))
    return found


def _smallest_extent(spec: ShapeSpec) -> float:
    """The smallest side of the bounding box of a shape (m)."""
    if spec.radius is not None:
        return min([2.0 * spec.radius, *([math.hypot(*spec.axis)] if spec.axis else [])])
    if corners := spec.vertices or tuple(itertools.chain.from_iterable(spec.triangles)):
        return min(extent(values) for values in zip(*corners, strict=True))
    return min((b - a for a, b in zip(spec.low or (), spec.high or (), strict=False)), default=math.inf)


def _of_shape(spec: ShapeSpec, dimension: int) -> Complaints:
    found: Complaints = []
    for key in ("low", "center", "velocity", "velocity_gradient"):
        value = getattr(spec, key, None)
        if value and len(value) != dimension:
            found.append(((key,), f"got {len(value)} numbers; the tank has {dimension} dimensions"))
    for key, corners in (("vertices", spec.vertices), ("triangles", spec.triangles and spec.triangles[0])):
        if corners and len(corners[0]) != dimension:
            found.append(((key,), f"has corners of {len(corners[0])} numbers; the tank has {dimension} dimensions"))
    if spec.axis is not None and (dimension == 2 or len(spec.axis) != 3):
        found.append((("axis",), "is of a cylinder: expected 3 numbers, in a tank of three dimensions"))
    if isinstance(spec, RegionSpec) and any(len(row) != dimension for row in spec.velocity_gradient):
        counts = ", ".join(str(len(row)) for row in spec.velocity_gradient)
        found.append((("velocity_gradient",), f"got rows of {counts} numbers; expected {dimension} in each"))
    if isinstance(spec, RegionSpec) and spec.particles is not None:
        found += particle_faults(spec.particles, dimension)
    if isinstance(spec, BodySpec) and (wrong := BODY_MASS.fault(spec.mass, dimension)):
        found.append((("mass",), wrong))
    if isinstance(spec, BodySpec) and spec.motion is not None:
        found += [(("motion", *path), message) for path, message in spec.motion.dimension_faults(dimension)]
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


def _second_liquid_faults(scene: SphScene) -> list[tuple[Path, str]]:
    """The faults of a second liquid without regions, and of regions of a second liquid that is not described."""
    regions = [index for index, region in enumerate(scene.fluid) if region.liquid == "second"]
    if scene.second_liquid is None:
        return [(("fluid", index, "liquid"), "there is no [second_liquid]; write the table") for index in regions]
    if len(regions) == len(scene.fluid) > 0:
        return [(("second_liquid",), "all regions have it; leave one to the first liquid, or describe it in [liquid]")]
    return [] if regions else [(("second_liquid",), 'no region has liquid = "second"; write it in one, or remove this')]


def _rheology_faults(scene: SphScene) -> list[tuple[Path, str]]:
    """The faults of options that have no law for liquids whose viscosity depends on the rate of strain."""
    if scene.liquid.rheology is None:
        return []
    complaints: list[tuple[Path, str]] = [
        (("passive_tracers", index, "radius"), "the drag on grains is that of a liquid of one viscosity; remove it")
        for index, spec in enumerate(scene.passive_tracers)
        if spec.radius > 0.0
    ]
    if scene.liquid.viscosity is not None:
        complaints.append((("liquid", "viscosity"), "the rheology sets it; remove one of the two"))
    if scene.method.turbulence != "none":
        complaints.append((("method", "turbulence"), "eddies were measured in liquids of one viscosity; use 'none'"))
    return complaints
