"""The scene of the tracers: spheres deep in a liquid, in a tank whose walls turn them back."""

from __future__ import annotations

import dataclasses
from typing import Annotated, Any, Self

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from ecume.scenes.common import Common, Kind
from ecume.scenes.faults import Inconsistent, Path
from ecume.scenes.quantities import (
    MOST_PARTICLES,
    ROOM,
    STRICT,
    AbsoluteTemperature,
    Color,
    Coordinate,
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
    Velocity,
)
from ecume.units import Acceleration, Unit

Point = Annotated[tuple[Coordinate, ...], Field(min_length=2, max_length=3)]
Speeds = Annotated[tuple[Velocity, ...], Field(min_length=2, max_length=3)]
Pull = Annotated[Acceleration, Field(ge=0.0, le=1e6)]
ComingRate = Annotated[float, Unit("1/s"), Field(gt=0.0, le=1e12)]
Concentration = Annotated[float, Field(gt=0.0, le=1e30)]
ShearRate = Annotated[float, Unit("1/s"), Field(ge=-1e6, le=1e6)]
Complaints = list[tuple[Path, str]]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class FluidSpec:
    """The liquid that carries the particles."""

    name: Name = ""
    """`water`, `seawater`, `ethanol`, `glycerol` or `mercury`: density and viscosity at the temperature."""
    temperature: AbsoluteTemperature = ROOM
    """K, or text such as `20 degC`"""
    density: PositiveDensity | None = None
    """kg/m^3; that of the liquid named, or 1000"""
    viscosity: LiquidViscosity | None = None
    """Pa s; that of the liquid named, or 0.001; 0 is no drag"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class FlowSpec:
    """How the liquid flows."""

    velocity: Speeds | None = None
    """The liquid's velocity (m/s); at rest by default."""
    shear_rate: ShearRate = 0.0
    """How much faster the liquid flows along x for each meter up (1/s)."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ParticleSpec:
    """Equal spheres, and where they start."""

    name: Name = ""
    """What this species is called; `particle-1` and so on when empty."""
    count: Count = 0
    """How many; by default one or as many as there are positions."""
    radius: Radius
    """m"""
    density: PositiveDensity
    """kg/m^3"""
    positions: tuple[Point, ...] = ()
    """Where each starts (m); by default at random in the tank."""
    low: Point | None = None
    """The lower corner of the part of the tank where they start at random (m)."""
    high: Point | None = None
    """The upper one."""
    velocity: Speeds | None = None
    """What each starts with (m/s)."""
    color: Color | None = None
    """`#rrggbb`, or a plain English name."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.positions and self.count not in (0, len(self.positions)):
            raise Inconsistent([(("count",), f"got {self.count}; there are {len(self.positions)} positions")])
        if not self.count:
            object.__setattr__(self, "count", len(self.positions) or 1)
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class TankSpec:
    """The walls: a box, or a disc or sphere around the origin, or a convex polygon."""

    low: Point | None = None
    """The lower corner of a box (m); the origin by default."""
    high: Point | None = None
    """The upper corner of a box (m)."""
    radius: Size | None = None
    """m"""
    dimensions: Annotated[int, Field(strict=True, ge=2, le=3)] = 2
    """Of a round tank: 2 or 3."""
    vertices: tuple[Point, ...] = ()
    """The corners in order (m)."""
    restitution: Proportion = 1.0
    """C_R: what is left of the normal velocity after a hit."""
    tangential_restitution: Proportion = 1.0
    """C_T: what is left of the tangential one."""

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        if sum((self.high is not None, self.radius is not None, bool(self.vertices))) != 1:
            raise Inconsistent([((), "expected one of high, radius and vertices")])
        if self.high is None and self.low is not None:
            raise Inconsistent([(("low",), "is of a box; expected high with it")])
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
    """m"""
    high: Point | None = None
    """m"""
    center: Point | None = None
    """m"""
    radius: Size | None = None
    """m"""
    vertices: tuple[Point, ...] = ()
    """m"""

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        box = self.low is not None and self.high is not None
        round_one = self.center is not None and self.radius is not None
        if sum((box, round_one, bool(self.vertices))) != 1:
            raise Inconsistent([((), "expected low and high, or center and radius, or vertices")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class OpeningSpec:
    """A part of a wall through which particles leave; with a rate or a concentration, others come in through it."""

    wall: Annotated[int, Field(strict=True, ge=0, le=10_000)]
    """The number of the wall: of a box 0 is left, 1 the bottom (in space the front), then upwards, then the others."""
    low: Point
    """Its lower corner (m)."""
    high: Point
    """Its upper corner (m)."""
    rate: ComingRate | None = None
    """How many come in each second (1/s), anywhere in it."""
    concentration: Concentration | None = None
    """How many there are in a cubic meter of what flows in, in the plane in a square meter; the flow brings them."""
    species: Name = ""
    """Which species comes in; the first by default."""
    velocity: Speeds | None = None
    """What they come in with (m/s); by default the liquid's velocity there less the speed at which they settle."""

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        comes = self.rate is not None or self.concentration is not None
        if self.rate is not None and self.concentration is not None:
            raise Inconsistent([(("concentration",), "given with rate; expected one of them")])
        if not comes and (self.species or self.velocity is not None):
            key = "species" if self.species else "velocity"
            raise Inconsistent([((key,), "nobody comes in here; expected rate or concentration with it")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class TracerHydrodynamicsSpec:
    """The forces of the liquid on moving particles."""

    drag: LawName = "schiller-naumann"
    """`stokes`, `schiller-naumann` or `none`"""
    added_mass: Switch = True
    """Whether half of the displaced liquid's mass is moved along."""
    brownian: Switch = False
    """Whether the liquid's heat kicks the particles."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class TracerIntegrationSpec:
    """The time integration."""

    integrator: LawName = "auto"
    """`inertial`, `overdamped`, or `auto`: overdamped where a step is longer than half a relaxation time."""
    time_step: Duration | None = None
    """s; by default the model chooses"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class TracersScene(Common):
    """Spheres in a liquid: they fly, bounce, disperse and settle, and do not feel one another."""

    model: Annotated[str, Field(pattern="^tracers$")] = "tracers"
    """Which model."""
    liquid: FluidSpec = FluidSpec()
    """What they are in."""
    gravity: Pull = 9.81
    """m/s^2, down the last axis"""
    flow: FlowSpec = FlowSpec()
    """How it flows."""
    particles: tuple[ParticleSpec, ...] = ()
    """The species."""
    tank: TankSpec | None = None
    """The walls around them, if any."""
    obstacles: tuple[ObstacleSpec, ...] = ()
    """Bodies in the tank."""
    openings: tuple[OpeningSpec, ...] = ()
    """Holes in its walls."""
    hydrodynamics: TracerHydrodynamicsSpec = TracerHydrodynamicsSpec()
    """The forces of the liquid on moving particles."""
    integration: TracerIntegrationSpec = TracerIntegrationSpec()
    """The time stepping."""

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """The species."""
        return tuple(Kind(species.name, species.color) for species in self.particles)

    @property
    def dimensions(self) -> int:
        """2 or 3: as many as the tank has, or else the first position."""
        if self.tank is not None:
            return len(self.tank.high or (self.tank.vertices or ((0.0,) * self.tank.dimensions,))[0])
        placed = [species.positions[0] for species in self.particles if species.positions]
        return len(placed[0]) if placed else 2

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        named = tuple(
            dataclasses.replace(species, name=species.name or f"particle-{index}")
            for index, species in enumerate(self.particles, 1)
        )
        object.__setattr__(self, "particles", named)
        complaints = [*_population(self), *_coordinates(self), *_newcomers(self)]
        if complaints:
            raise Inconsistent(complaints)
        return self


def _population(scene: TracersScene) -> Complaints:
    total = sum(species.count for species in scene.particles)
    if total == 0:
        return [(("particles",), "there are none; write a [[particles]] table with radius and density")]
    if total > MOST_PARTICLES:
        return [(("particles",), f"{total} particles are more than {MOST_PARTICLES:.0e}")]
    complaints: Complaints = []
    for index, species in enumerate(scene.particles):
        if scene.tank is None and not species.positions and (species.low is None or species.high is None):
            where = ("particles", index, "positions")
            complaints.append((where, "is missing; without a tank expected positions, or low and high"))
    return complaints


def _newcomers(scene: TracersScene) -> Complaints:
    """The faults of particles that come in: their species, and their number."""
    names, complaints, expected = [species.name for species in scene.particles], list[tuple[Path, str]](), 0.0
    for index, hole in enumerate(scene.openings):
        expected += (hole.rate or 0.0) * scene.duration
        if hole.species and hole.species not in names:
            message = f"got {hole.species!r}; the species are {', '.join(map(repr, names))}"
            complaints.append((("openings", index, "species"), message))
    if expected > MOST_PARTICLES:
        complaints.append((("openings",), f"{expected:.3g} particles to come are more than {MOST_PARTICLES:.0e}"))
    return complaints


def _coordinates(scene: TracersScene) -> Complaints:
    """Every point has as many coordinates as the tank."""
    wanted = scene.dimensions
    points: list[tuple[Path, Any]] = [(("flow", "velocity"), scene.flow.velocity)]
    for index, species in enumerate(scene.particles):
        points += [(("particles", index, key), getattr(species, key)) for key in ("low", "high", "velocity")]
        points += [(("particles", index, "positions", place), point) for place, point in enumerate(species.positions)]
    for index, body in enumerate(scene.obstacles):
        points += [(("obstacles", index, key), getattr(body, key)) for key in ("low", "high", "center")]
    for index, hole in enumerate(scene.openings):
        points += [(("openings", index, key), getattr(hole, key)) for key in ("low", "high", "velocity")]
    return [
        (path, f"got {len(point)} coordinates; expected {wanted}")
        for path, point in points
        if point is not None and len(point) != wanted
    ]
