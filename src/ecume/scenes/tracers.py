"""The scene of the tracers: spheres deep in a liquid, in a tank with reflecting walls."""

from __future__ import annotations

import dataclasses
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from ecume.scenes.common import Common, Kind, dataclass
from ecume.scenes.faults import Inconsistent, Path
from ecume.scenes.fields import FieldSpec
from ecume.scenes.quantities import (
    CONCENTRATION,
    LONGEST_NAME,
    MOST_PARTICLES,
    STRICT,
    AbsoluteTemperature,
    Color,
    Concentration,
    Count,
    Duration,
    LawName,
    LiquidViscosity,
    Name,
    PositiveDensity,
    Proportion,
    Radius,
    Size,
    Switch,
    TurningRate,
    Velocity,
)
from ecume.scenes.sizes import Share, SizeSpec, list_faults, shared_out, sized
from ecume.units import ROOM, Acceleration, Length, Number, Rate, Unit

Coordinate = Annotated[Length, Field(ge=-1e8, le=1e8)]
"""As far as around the Earth, since fields may be of oceans."""
Point = Annotated[tuple[Coordinate, ...], Field(min_length=2, max_length=3)]
Speeds = Annotated[tuple[Velocity, ...], Field(min_length=2, max_length=3)]
Pull = Annotated[Acceleration, Field(ge=0.0, le=1e6)]
ComingRate = Annotated[float, Unit("1/s"), Field(gt=0.0, le=1e12)]
WallNumber = Annotated[int, Field(strict=True, ge=0, le=10_000)]
Diffusivity = Annotated[float, Unit("m^2/s"), Field(ge=0.0, le=1e6)]
Sphericity = Annotated[Number, Field(ge=0.1, le=1.0)]
ShearRate = Annotated[float, Unit("1/s"), Field(ge=-1e6, le=1e6)]
Complaints = list[tuple[Path, str]]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class FluidSpec:
    """The liquid that carries the particles."""

    name: Name = ""
    """A liquid of the table in `ecume.laws.liquids`, such as `water`, at the `temperature`; or `air`, at one
    atmosphere. Effect: provides the density and viscosity that are not given, and the mean free path of air."""
    temperature: AbsoluteTemperature = ROOM
    """The temperature of the named liquid and of Brownian motion (K); text such as `20 degC` is allowed. Effect: a
    warmer liquid is less viscous; thermal noise grows with it."""
    density: PositiveDensity | None = None
    """The density of the liquid (kg/m^3); by default that of the named liquid, or 1000. Effect: the buoyancy of the
    particles is proportional to it."""
    viscosity: LiquidViscosity | None = None
    """The dynamic viscosity of the liquid (Pa s); by default that of the named liquid, or 0.001. Effect: drag is
    proportional to it for slow particles; 0 disables drag."""
    mean_free_path: Size | None = None
    """The mean free path of the molecules of a gas (m), 65 nm in air at room temperature; by default that of a named
    gas, or none. Effect: gases slip along small particles, which settle and diffuse faster."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class PulseSpec:
    """The factor of the speed in time, (1 + A sin(2 pi t/T)) exp(-c t)."""

    amplitude: Annotated[Number, Field(ge=0.0, le=100.0)] = 0.0
    """The amplitude A of the oscillation over the steady speed. Effect: above 1 the flow reverses in each period."""
    period: Duration | None = None
    """The period T of the oscillation (s). Effect: slower oscillations move particles farther back and forth."""
    decay_rate: Annotated[Rate, Field(ge=0.0, le=1e6)] = 0.0
    """The rate c at which the flow decays (1/s); by viscosity 2 nu k^2 for cellular flows. Effect: the flow comes to
    rest."""

    @model_validator(mode="after")
    def _periodic(self) -> Self:
        if self.amplitude and self.period is None:
            raise Inconsistent([(("period",), "is missing; expected the period of the oscillation")])
        if self.period is not None and not self.amplitude:
            raise Inconsistent([(("period",), "is not used without amplitude; expected both")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class TurbulenceSpec:
    """Mixing by turbulence that the flow does not resolve, as a diffusivity of particles without inertia in a box."""

    heights: tuple[Coordinate, ...]
    """The heights of the profile (m), rising. Example: `["0 m", "5 m", "20 m"]`. Effect: where the diffusivities
    apply."""
    diffusivities: tuple[Diffusivity, ...]
    """The vertical diffusivity at each height (m^2/s), linear between them and constant beyond. Example: `["1 cm^2/s",
    "50 cm^2/s", "1 cm^2/s"]`. Effect: mixes particles over height; a well-mixed suspension stays so."""
    horizontal: Diffusivity = 0.0
    """The diffusivity along the other axes (m^2/s). Effect: spreads particles along these axes."""

    @model_validator(mode="after")
    def _profile(self) -> Self:
        if len(self.heights) != len(self.diffusivities) or not self.heights:
            message = f"got {len(self.diffusivities)} for {len(self.heights)} heights; expected one for each"
            raise Inconsistent([(("diffusivities",), message)])
        if any(b <= a for a, b in zip(self.heights, self.heights[1:], strict=False)):
            raise Inconsistent([(("heights",), "expected rising numbers")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class FlowSpec:
    """The flow of the liquid: the sum of a uniform velocity, a shear, and a flow by name or from a file."""

    velocity: Speeds | None = None
    """The velocity of the liquid (m/s); by default it is at rest. Effect: drag accelerates the particles toward it."""
    shear_rate: ShearRate = 0.0
    """The gradient of the x velocity of the liquid with height (1/s). Effect: particles at different heights drift
    apart."""
    around_obstacles: Literal["none", "creeping", "ideal"] = "none"
    """How the flow passes obstacles: `none`, through them; `creeping`, at small Reynolds numbers, a uniform flow past
    one sphere without a tank, or the flow `channel` of a box past any of them, in 3D also the flow `duct`, and past an
    array of them where the tank is periodic along x; `ideal`, without viscosity, a uniform flow past one disc or
    sphere. Effect: particles are carried around obstacles."""
    name: Annotated[str, Field(max_length=LONGEST_NAME)] = ""
    """A flow that adds to these two: `channel`, `couette`, `tube`, `duct`, `stagnation`, `rotation`, `cellular`,
    `double-gyre`, `wave` or `abc`. Example: `"channel"`. Effect: particles follow this flow."""
    speed: Velocity | None = None
    """The speed of the named flow (m/s): the mean one of a channel, tube or duct, that of the moving wall, the largest
    one of cells, the largest one along x of gyres and at the surface of waves, and the smallest amplitude of `abc`.
    Effect: scales the velocities."""
    rate: TurningRate | None = None
    """The rate of a stagnation flow (1/s), at which it approaches along the vertical, or the angular velocity of a
    rotation (rad/s). Effect: scales the velocities."""
    wavelength: Size | None = None
    """The length after which cells or waves repeat (m). Effect: sets the size of the cells."""
    period: Duration | None = None
    """The period of the swing of a double gyre (s). Effect: faster swings mix more."""
    swing: Proportion | None = None
    """The amplitude of the swing of the border between two gyres, over half of the length; by default 0, a steady
    flow. Effect: above 0 particles cross the border."""
    radius: Size | None = None
    """The radius of a tube (m); by default half of the smaller side of the box. Effect: sets the profile."""
    center: Point | None = None
    """The point around which the named flow turns, the axis of a tube, or a corner of a cell (m); by default the middle
    of the box, for cells its lower corner. Effect: shifts the flow."""
    low: Point | None = None
    """The lower corner of the box of the named flow (m); by default that of the tank. Effect: shifts its walls."""
    high: Point | None = None
    """The upper corner of the box of the named flow (m); by default that of the tank. Effect: shifts its walls."""
    field: FieldSpec | None = None
    """Velocities from a file or a run, instead of a named flow. Effect: particles follow these velocities."""
    turbulence: TurbulenceSpec | None = None
    """Mixing by eddies that the flow does not contain. Effect: particles mix over the height."""
    pulse: PulseSpec | None = None
    """How the speed of the named flow or of the file changes in time; by default it is steady. Effect: makes the flow
    pulsate or decay."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ParticleSpec:
    """Equal spheres, and their initial positions."""

    name: Name = ""
    """The name of the species in frames, legends and exports; by default `particle-1` and so on. Effect: none on the
    motion."""
    count: Count = 0
    """The number of particles; by default one, or the number of positions. Effect: run time and disk space are
    proportional to it; the particles do not interact."""
    radius: Radius
    """The radius of each sphere (m); a list has one per sphere, a table a distribution with the keys `distribution`,
    `mean` and `spread`. Effect: the settling speed grows as its square, diffusion falls as its inverse."""
    radii: tuple[Radius, ...] = ()
    """One radius per particle (m), as a list in `radius` is kept. Example: `["1 mm", "1.2 mm"]`. Effect: gives each
    particle its own size."""
    sizes: SizeSpec | None = None
    """The distribution of radii, as a table in `radius` is kept. Effect: gives the particles different sizes."""
    volume_share: Share | None = None
    """The part of the volume of all particles that this species is, instead of its count; at least one species
    has a count. Example: `"30 %"`. Effect: sets the number of particles."""
    density: PositiveDensity
    """The density of each sphere (kg/m^3). Effect: spheres denser than the liquid settle, others rise."""
    sphericity: Sphericity = 1.0
    """The surface of the sphere of the same volume over that of the particle: 1 of spheres, 0.81 of cubes; for the drag
    law `haider-levenspiel`, with `radius` that of this sphere. Effect: fast particles that are not round settle more
    slowly."""
    positions: tuple[Point, ...] = ()
    """The initial position of each particle (m); by default random in the tank. Effect: replaces the random
    positions."""
    low: Point | None = None
    """The lower corner of the box of random initial positions (m). Effect: restricts the start to a part of the
    tank."""
    high: Point | None = None
    """The upper corner of the box of random initial positions (m). Effect: restricts the start to a part of the
    tank."""
    velocity: Speeds | None = None
    """The initial velocity of all particles of the species (m/s); by default zero. Effect: drag damps it within the
    relaxation time."""
    velocities: tuple[Speeds, ...] = ()
    """Individual initial velocities, one per position (m/s); take precedence over `velocity`. Effect: drag damps
    them within the relaxation time."""
    color: Color | None = None
    """The color in pictures: `#rrggbb`, or an English name. Effect: none on the motion."""

    @model_validator(mode="before")
    @classmethod
    def _sized(cls, raw: Any) -> Any:
        return sized(raw)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.positions and self.count not in (0, len(self.positions)):
            raise Inconsistent([(("count",), f"got {self.count}; there are {len(self.positions)} positions")])
        if len(self.velocities) not in (0, len(self.positions)):
            message = f"got {len(self.velocities)}; there are {len(self.positions)} positions"
            raise Inconsistent([(("velocities",), message)])
        if self.volume_share is not None and (self.positions or self.radii):
            raise Inconsistent([(("volume_share",), "got a list, which says how many; expected one of both")])
        if not self.count and self.volume_share is None:
            object.__setattr__(self, "count", len(self.positions) or len(self.radii) or 1)
        if wrong := list_faults(self, self.count):
            raise Inconsistent(wrong)
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class WallSpec:
    """The coefficients of one wall of the tank, if they differ from those of the others."""

    wall: WallNumber
    """The number of the wall. Walls of a box are numbered left, bottom, right, top; in 3D low x, y, z, then high x, y,
    z; those of a polygon like its sides. Example: `1`. Effect: selects another wall."""
    restitution: Proportion | None = None
    """The ratio C_R of normal velocities after and before a collision with this wall; by default that of the tank.
    Effect: 1 conserves the kinetic energy, 0 stops the normal motion."""
    tangential_restitution: Proportion | None = None
    """The ratio C_T of tangential velocities after and before a collision with this wall; by default that of the tank.
    Effect: below 1 the wall slows down the motion along it."""
    sticking: Switch | None = None
    """Whether particles that touch this wall stay there; by default as the tank says. Example:
    `true`. Effect: collects particles, which are counted."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class TankSpec:
    """The walls: a box, or a disc or sphere around the origin, or a convex polygon."""

    low: Point | None = None
    """The lower corner of a box (m); by default the origin. Effect: shifts the walls."""
    high: Point | None = None
    """The upper corner of a box (m). Effect: a larger tank lengthens the times between collisions with walls."""
    radius: Size | None = None
    """The radius of a round tank around the origin (m), instead of a box. Effect: a larger tank lengthens the times
    between collisions with walls."""
    dimensions: Annotated[int, Field(strict=True, ge=2, le=3)] = 2
    """The number of dimensions of a round tank: a disc or a sphere. Effect: 3 gives positions three coordinates."""
    vertices: tuple[Point, ...] = ()
    """The corners of a convex polygon in order, or those of a convex polyhedron (m), instead of a box. Effect:
    determines the shape of the walls."""
    restitution: Proportion = 1.0
    """The ratio C_R of normal velocities after and before a collision with a wall. Effect: 1 conserves the kinetic
    energy, 0 stops the normal motion."""
    tangential_restitution: Proportion = 1.0
    """The ratio C_T of tangential velocities after and before a collision with a wall. Effect: below 1 walls slow
    down the motion along them."""
    sticking: Switch = False
    """Whether particles that touch a wall or an obstacle stay there. Effect: collects particles, which are counted by
    wall."""
    periodic: tuple[Literal["x", "y", "z"], ...] = ()
    """The axes along which a box is periodic: it has no walls there, and particles that leave on one side enter on the
    other; the remaining walls are numbered without these. Example: `["x"]`. Effect: makes the tank a part of a longer
    one."""
    walls: tuple[WallSpec, ...] = ()
    """The coefficients of single walls, one table each. Effect: these walls reflect in another way than the others."""

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        if sum((self.high is not None, self.radius is not None, bool(self.vertices))) != 1:
            raise Inconsistent([((), "expected one of high, radius and vertices")])
        if self.high is None and self.low is not None:
            raise Inconsistent([(("low",), "is of a box; expected high with it")])
        if self.periodic and self.high is None:
            raise Inconsistent([(("periodic",), "is of a box; expected high with it")])
        if len(set(self.periodic)) != len(self.periodic):
            raise Inconsistent([(("periodic",), "got an axis twice; expected each once")])
        if self.high is not None and "z" in self.periodic and len(self.high) == 2:
            raise Inconsistent([(("periodic",), "got z in 2D; expected x or y, the vertical axis")])
        if self.high is not None:
            low = self.low or (0.0,) * len(self.high)
            object.__setattr__(self, "low", low)
            if len(low) != len(self.high) or any(b <= a for a, b in zip(low, self.high, strict=True)):
                raise Inconsistent([(("high",), "expected a corner above low in each direction")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ObstacleSpec:
    """A convex body in the tank: a box between two corners, a disc or sphere, a polygon."""

    low: Point | None = None
    """The lower corner of a box (m), together with `high`. Effect: moves the side of the obstacle."""
    high: Point | None = None
    """The upper corner of a box (m), together with `low`. Effect: moves the side of the obstacle."""
    center: Point | None = None
    """The center of a disc or sphere (m), together with `radius`. Effect: shifts the obstacle."""
    radius: Size | None = None
    """The radius of a disc or sphere (m), together with `center`. Effect: larger obstacles reflect more particles."""
    vertices: tuple[Point, ...] = ()
    """The corners of a convex polygon or polyhedron (m). Effect: determines the shape of the obstacle."""
    restitution: Proportion | None = None
    """The ratio C_R of normal velocities after and before a collision with the obstacle; by default that of the tank.
    Effect: 1 conserves the kinetic energy, 0 stops the normal motion."""
    tangential_restitution: Proportion | None = None
    """The ratio C_T of tangential velocities after and before a collision with the obstacle; by default that of the
    tank. Effect: below 1 the obstacle slows down the motion along it."""
    sticking: Switch | None = None
    """Whether particles that touch the obstacle stay there; by default as the tank says. Example:
    `true`. Effect: collects particles, which are counted."""

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        box = self.low is not None and self.high is not None
        round_one = self.center is not None and self.radius is not None
        if sum((box, round_one, bool(self.vertices))) != 1:
            raise Inconsistent([((), "expected low and high, or center and radius, or vertices")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class OpeningSpec:
    """A part of a wall through which particles leave; with a rate or a concentration, particles
    also enter through it.
    """

    wall: WallNumber
    """The number of the wall with the opening. Walls of a box are numbered left, bottom, right, top; in 3D low x, y,
    z, then high x, y, z. Example: `1`. Effect: moves the opening to another wall."""
    low: Point
    """The lower corner of the opening (m). Effect: larger openings let more particles leave."""
    high: Point
    """The upper corner of the opening (m). Effect: larger openings let more particles leave."""
    rate: ComingRate | None = None
    """The number of particles that enter per second (1/s), at random positions in the opening. Effect: the number of
    particles grows in proportion to it."""
    concentration: Concentration | None = None
    """The number of particles per volume of the liquid that flows in (1/m^3; 1/m^2 in 2D), such as `100 1/mL` or
    `1 fmol/L`. Effect: the number of particles grows in proportion to it and to the inflow."""
    species: Name = ""
    """The name of the species that enters; by default the first one. Effect: selects radius and density of entering
    particles."""
    velocity: Speeds | None = None
    """The velocity of entering particles (m/s); by default that of the liquid plus the settling velocity. Effect:
    drag changes it within the relaxation time."""

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        comes = self.rate is not None or self.concentration is not None
        if self.rate is not None and self.concentration is not None:
            raise Inconsistent([(("concentration",), "given with rate; expected one of them")])
        if not comes and (self.species or self.velocity is not None):
            key = "species" if self.species else "velocity"
            raise Inconsistent([((key,), "no particles enter here; expected rate or concentration with it")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class TracerHydrodynamicsSpec:
    """The forces of the liquid on moving particles."""

    drag: LawName = "schiller-naumann"
    """The drag law: `stokes` for slow particles, `schiller-naumann`, which grows with the Reynolds number,
    `haider-levenspiel`, for particles that are not round, or `none`. Effect: `schiller-naumann` lowers the settling
    speed of large particles; without drag particles fly freely."""
    added_mass: Switch = True
    """Whether the inertia includes half the mass of the displaced liquid. Effect: makes light particles slower to
    accelerate."""
    fluid_acceleration: Switch = False
    """The force by the acceleration of the liquid: its pressure gradient, and that of the added mass; acts on particles
    with inertia. Effect: light particles follow and overtake accelerating liquid."""
    faxen: Switch = False
    """Faxen's correction of Stokes's drag in curved velocity profiles; acts on particles with inertia. Effect: large
    particles lag behind the liquid in a channel."""
    lift: Switch = False
    """Saffman's lift on a particle that moves relative to sheared liquid; acts on particles with inertia. Effect:
    particles that lag move toward faster liquid."""
    wall_drag: Switch = False
    """Whether drag grows near the walls of a box, by the exact series for a sphere and a plane: along each wall, and
    toward it. Effect: particles settle and diffuse more slowly near walls, and do not touch them."""
    brownian: Switch = False
    """Brownian motion at the temperature of the liquid; requires drag. Effect: disperses particles; those of a
    micrometer remain suspended."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class TracerIntegrationSpec:
    """The time integration."""

    integrator: LawName = "auto"
    """The equation of motion: `inertial`, `overdamped`, or `auto`, which is overdamped where a step is longer than
    half a relaxation time. Effect: `overdamped` omits inertia and allows long steps."""
    time_step: Duration | None = None
    """The time step (s), a whole fraction of `frame_every`; by default chosen from the scene. Effect: smaller steps
    are more accurate and cost more."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class TracersScene(Common):
    """Spheres in a liquid that move, bounce, disperse and settle without mutual forces."""

    model: Annotated[str, Field(pattern="^tracers$")] = "tracers"
    """The model: particles in a liquid that do not interact. Effect: selects the equations that are solved."""
    liquid: FluidSpec = FluidSpec()
    """The properties of the liquid. Effect: they set drag, buoyancy and diffusion."""
    gravity: Pull = 9.81
    """The gravitational acceleration (m/s^2), downward along the last axis; 0 is weightless. Effect: the settling
    speed of slow particles is proportional to it."""
    flow: FlowSpec = FlowSpec()
    """The imposed flow of the liquid. Effect: drags the particles along."""
    particles: tuple[ParticleSpec, ...] = ()
    """The species of particles, one table each. Effect: each species adds particles with common properties."""
    tank: TankSpec | None = None
    """The walls around the particles; without it space is infinite. Effect: walls reflect the particles."""
    obstacles: tuple[ObstacleSpec, ...] = ()
    """Convex bodies in the tank. Effect: they reflect the particles."""
    openings: tuple[OpeningSpec, ...] = ()
    """Openings in the walls of the tank. Effect: particles leave and enter through them."""
    hydrodynamics: TracerHydrodynamicsSpec = TracerHydrodynamicsSpec()
    """The forces of the liquid on moving particles. Effect: they determine drag, inertia and thermal noise."""
    integration: TracerIntegrationSpec = TracerIntegrationSpec()
    """The time stepping. Effect: determines the error per step and the cost."""

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """The species."""
        return tuple(Kind(species.name, species.color) for species in self.particles)

    @property
    def dimensions(self) -> int:
        """The number of dimensions, 2 or 3, of the tank, or without a tank of the first position or corner of
        particles.
        """
        if self.tank is not None:
            return len(self.tank.high or (self.tank.vertices or ((0.0,) * self.tank.dimensions,))[0])
        for species in self.particles:
            if species.positions or species.low:
                return len(species.positions[0] if species.positions else species.low or ())
        return 2

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        named = tuple(
            dataclasses.replace(species, name=species.name or f"particle-{index}")
            for index, species in enumerate(shared_out(self.particles, 3), 1)
        )
        object.__setattr__(self, "particles", named)
        complaints = [*_population(self), *_coordinates(self), *_newcomers(self)]
        if complaints:
            raise Inconsistent(complaints)
        return self


def _population(scene: TracersScene) -> Complaints:
    total = sum(species.count for species in scene.particles)
    if total == 0:
        return [(("particles",), "got no species; add a [[particles]] table with radius and density")]
    if total > MOST_PARTICLES:
        return [(("particles",), f"{total} particles are more than {MOST_PARTICLES:.0e}")]
    complaints: Complaints = []
    for index, species in enumerate(scene.particles):
        if scene.tank is None and not species.positions and (species.low is None or species.high is None):
            where = ("particles", index, "positions")
            complaints.append((where, "is missing; without a tank expected positions, or low and high"))
    return complaints


def _newcomers(scene: TracersScene) -> Complaints:
    """The faults of entering particles: their species, and their number."""
    names, complaints, expected = [species.name for species in scene.particles], list[tuple[Path, str]](), 0.0
    for index, hole in enumerate(scene.openings):
        expected += (hole.rate or 0.0) * scene.duration
        if hole.species and hole.species not in names:
            message = f"got {hole.species!r}; the species are {', '.join(map(repr, names))}"
            complaints.append((("openings", index, "species"), message))
        if wrong := CONCENTRATION.fault(hole.concentration, scene.dimensions):
            complaints.append((("openings", index, "concentration"), wrong))
    if expected > MOST_PARTICLES:
        complaints.append((("openings",), f"{expected:.3g} particles to come are more than {MOST_PARTICLES:.0e}"))
    return complaints


def _coordinates(scene: TracersScene) -> Complaints:
    """The faults of points whose number of coordinates differs from that of the tank."""
    required = scene.dimensions
    points: list[tuple[Path, Any]] = [
        (("flow", key), getattr(scene.flow, key)) for key in ("velocity", "center", "low", "high")
    ]
    for index, species in enumerate(scene.particles):
        points += [(("particles", index, key), getattr(species, key)) for key in ("low", "high", "velocity")]
        for key in ("positions", "velocities"):
            points += [(("particles", index, key, place), point) for place, point in enumerate(getattr(species, key))]
    for index, body in enumerate(scene.obstacles):
        points += [(("obstacles", index, key), getattr(body, key)) for key in ("low", "high", "center")]
    for index, hole in enumerate(scene.openings):
        points += [(("openings", index, key), getattr(hole, key)) for key in ("low", "high", "velocity")]
    return [
        (path, f"got {len(point)} coordinates; expected {required}")
        for path, point in points
        if point is not None and len(point) != required
    ]
