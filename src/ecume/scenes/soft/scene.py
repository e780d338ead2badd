"""The scene of the soft model: elastic spheres close together in a viscous liquid, and the forces on them."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from ecume.scenes.common import Common, Kind
from ecume.scenes.faults import Complaints, Inconsistent, Path
from ecume.scenes.quantities import (
    ROOM,
    STRICT,
    AbsoluteTemperature,
    Color,
    Coordinate,
    Count,
    GravityVector,
    LawName,
    Name,
    PositiveDensity,
    Radius,
    Size,
    Switch,
    downwards,
)
from ecume.scenes.soft.protocol import StageSpec, protocol_faults
from ecume.scenes.soft.walls import WallSpec, wall_faults
from ecume.units import Energy, Force, Number, Pressure, SurfaceTension, Unit, Viscosity

MOST_SPHERES = 1_000_000

Modulus = Annotated[Pressure, Field(ge=1e-9, le=1e15)]
ThickViscosity = Annotated[Viscosity, Field(ge=1e-12, le=1e12)]
Load = Annotated[Force, Field(ge=-1e9, le=1e9)]
Strength = Annotated[Force, Field(ge=0.0, le=1e9)]
Hamaker = Annotated[Energy, Field(ge=0.0, le=1e9)]
Tension = Annotated[SurfaceTension, Field(ge=1e-12, le=1e12)]
ViscosityRatio = Annotated[Number, Field(ge=1e-6, le=1e6)]
Coefficient = Annotated[Number, Field(ge=0.0, le=100.0)]
Prefactor = Annotated[Number, Field(gt=1e-6, le=1e6)]
Weight = Annotated[Number, Field(ge=1e-6, le=1e6)]
Tolerance = Annotated[Number, Field(ge=1e-11, le=1e-2)]
Position = Annotated[tuple[Coordinate, ...], Field(min_length=2, max_length=3)]
"""Two coordinates in a layer, three in space."""
ForceVector = Annotated[tuple[Load, ...], Field(min_length=2, max_length=3)]
Twist = Annotated[float, Unit("N*m"), Field(ge=-1e9, le=1e9)]
TorqueVector = Annotated[tuple[Twist, ...], Field(min_length=1, max_length=3)]
Filling = Annotated[Number, Field(gt=0.0, lt=1.0)]
Sides = Annotated[tuple[Size, ...], Field(min_length=2, max_length=3)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SoftLiquid:
    """The liquid between the spheres."""

    name: Name = ""
    """A liquid of the table in `ecume.laws.liquids`, such as `water`; it provides the properties that are not given."""
    temperature: AbsoluteTemperature = ROOM
    """K, or text such as `20 degC`"""
    viscosity: ThickViscosity | None = None
    """Pa s; needed without a name"""
    surface_tension: Tension | None = None
    """of bubbles or drops in it (N/m)"""
    density: PositiveDensity | None = None
    """kg/m^3; needed with gravity"""

    @model_validator(mode="after")
    def _viscous(self) -> Self:
        if self.viscosity is None and not self.name:
            raise Inconsistent([(("viscosity",), 'is missing; give it, or the name of a liquid such as "water"')])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SoftHydrodynamicsSpec:
    """The forces of the liquid far away on moving spheres."""

    drag: Literal["none", "stokes"] = "none"
    """`stokes`: the liquid far away drags on each sphere with 6 pi eta R; or `none`"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SphereSpec:
    """Equal spheres, where they start, and what pulls at each."""

    name: Name = ""
    """What this species is called; `sphere-1` and so on when empty."""
    radius: Radius
    """m, undeformed"""
    modulus: Modulus | None = None
    """Young's modulus of the material (Pa); bubbles and drops have none"""
    density: PositiveDensity | None = None
    """kg/m^3; needed with gravity"""
    positions: tuple[Position, ...] = ()
    """Where each starts (m): two coordinates in a layer, three in space."""
    count: Count | None = None
    """How many are placed at random in the box, for lack of positions."""
    force: ForceVector | None = None
    """What pulls at each of them (N), at load 1."""
    torque: TorqueVector | None = None
    """What turns each of them (N m), at load 1, where spheres spin: one number in a layer, three in space."""
    color: Color | None = None
    """`#rrggbb`, or a plain English name"""

    @model_validator(mode="after")
    def _placed(self) -> Self:
        if bool(self.positions) == (self.count is not None):
            came = "both" if self.positions else "neither"
            raise Inconsistent([((), f"expected either positions or count; got {came}")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class FilmSpec:
    """Contacts: a film of liquid in series with the surfaces' elasticity."""

    surface: LawName = "hertz"
    """How surfaces give way: `hertz` as those of elastic spheres, `bubble` as those of bubbles and drops."""
    interface: LawName = "rigid"
    """What surfaces the film lies between: `rigid` ones hold the liquid, along `mobile` ones it slips freely, along one
    of the two where `half-mobile`; those of a `drop` drag the liquid inside along."""
    viscosity_ratio: ViscosityRatio = 1.0
    """of a drop's liquid, over that of the film"""
    friction: LawName = "none"
    """Contact friction: `none`, or `coulomb`, where gaps are below the roughness."""
    friction_coefficient: Coefficient = 0.5
    """what holds the surfaces, over what presses them together"""
    roughness: Size | None = None
    """the gap below which there is contact friction (m)"""
    prefactors: LawName = "paper"
    """Where the six numbers come from that follow: `paper` or `physical`."""
    squeeze: Prefactor | None = None
    """c_n: friction c_n eta a^4/h^3 of squeezing; overrules the set"""
    shear: Prefactor | None = None
    """c_t: friction c_t eta a^2/h of sliding; overrules the set"""
    normal: Prefactor | None = None
    """alpha_n: stiffness alpha_n E a along the normal; overrules the set"""
    tangential: Prefactor | None = None
    """alpha_t: stiffness alpha_t E a along the surface; overrules the set"""
    gap_weight: Weight | None = None
    """c_h in a^2 = R (c_h h + c_d |delta|); overrules the set"""
    deflection_weight: Weight | None = None
    """c_d in the same; overrules the set"""
    cutoff: Size | None = None
    """The gap up to which spheres have a film between them (m); by default half of the smallest radius in a box, and
    without a box all spheres have one, always."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class LongRangeSpec:
    """The force between surfaces across the film."""

    law: LawName = "none"
    """`none`, `steric` or `dlvo`"""
    steric_strength: Strength = 0.0
    """of the steric repulsion (N): that at half its length"""
    steric_length: Size = 1e-8
    """of the steric repulsion (m)"""
    hamaker_constant: Hamaker = 0.0
    """Hamaker's constant of van der Waals's attraction (J)"""
    double_layer_strength: Strength = 0.0
    """of the electric double layer (J/m = N)"""
    debye_length: Size = 1e-8
    """of the electric double layer (m)"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class CellSpec:
    """A periodic box; Lees and Edwards's shear moves its copies above and below."""

    size: Sides
    """Its sides (m), as many as there are dimensions; with a volume fraction their proportions."""
    volume_fraction: Filling | None = None
    """What part of it undeformed spheres take at the start, discs of a layer; by default what the sides make it."""
    minimum_gap: Size | None = None
    """The least gap of spheres that are placed at random (m); by default a hundredth of the smallest radius."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class IntegrationSpec:
    """The time integration: implicit, with steps as long as the tolerance allows."""

    integrator: LawName = "esdirk4"
    """`esdirk4` of order 4 or `tr-bdf2` of order 2, both L-stable"""
    tolerance: Tolerance = 1e-6
    """the error of ln(gap), and of directions in radians, that a step may make"""
    solver: LawName = "auto"
    """`auto`, `dense`, `iterative`, `direct` or `cholmod`: how a step's linear systems are solved"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SoftScene(Common):
    """Soft spheres in a viscous liquid, so slow that inertia plays no part."""

    model: Literal["soft"] = "soft"
    """Which model."""
    liquid: SoftLiquid
    """What is between them."""
    particles: Annotated[tuple[SphereSpec, ...], Field(min_length=1)]
    """The species."""
    rotation: Switch = False
    """Whether spheres spin, so that torques balance, too."""
    films: FilmSpec = FilmSpec()
    """The contacts."""
    long_range_forces: LongRangeSpec = LongRangeSpec()
    """What acts across the films."""
    gravity: GravityVector | None = None
    """Acceleration of gravity (m/s^2): a magnitude, downwards, or a vector; by default none; needs densities"""
    cell: CellSpec | None = None
    """The periodic box, if any."""
    walls: tuple[WallSpec, ...] = ()
    """Planes that the spheres lie between or on."""
    protocol: tuple[StageSpec, ...] = ()
    """What is done to spheres and box over time."""
    hydrodynamics: SoftHydrodynamicsSpec = SoftHydrodynamicsSpec()
    """The drag of the liquid far away."""
    integration: IntegrationSpec = IntegrationSpec()
    """The time stepping."""

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """The species, each in the place that is its number in frames."""
        return tuple(Kind(one.name or f"sphere-{index}", one.color) for index, one in enumerate(self.particles, 1))

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.gravity is not None:
            object.__setattr__(self, "gravity", downwards(self.gravity, dimensions_of(self)))
        complaints = [
            *_dimensions(self), *_protocol(self), *_walls(self), *_gravity(self), *_crowd(self),
        ]  # fmt: skip
        if complaints:
            raise Inconsistent(complaints)
        return self


def sides_of(scene: SoftScene) -> tuple[float, ...]:
    """The sides of the box at scale 1 (m), as large as its volume fraction wants it; none without a box."""
    if scene.cell is None:
        return ()
    size, wanted = scene.cell.size, scene.cell.volume_fraction
    if wanted is None:
        return size
    unit, power = (math.pi, 2) if len(size) == 2 else (4.0 / 3.0 * math.pi, 3)
    volume = sum((one.count or len(one.positions)) * unit * one.radius**power for one in scene.particles)
    factor = (volume / wanted / math.prod(size)) ** (1.0 / len(size))
    return tuple(factor * side for side in size)


def dimensions_of(scene: SoftScene) -> int:
    """2 for a layer, 3 for a packing in space: as many as the box, or the first position, has."""
    if scene.cell is not None:
        return len(scene.cell.size)
    return next((len(position) for species in scene.particles for position in species.positions), 2)


def _dimensions(scene: SoftScene) -> Complaints:
    """The faults of positions and forces whose numbers of components differ."""
    wanted = dimensions_of(scene)
    found: Complaints = []
    for index, species in enumerate(scene.particles):
        path: Path = ("particles", index)
        found += [
            ((*path, "positions", place), f"got {len(position)} coordinates; expected {wanted} as elsewhere")
            for place, position in enumerate(species.positions)
            if len(position) != wanted
        ]
        if species.force is not None and len(species.force) != wanted:
            found.append(((*path, "force"), f"got {len(species.force)} components; expected {wanted}"))
        if species.torque is not None:
            found += _torque((*path, "torque"), len(species.torque), scene)
        if species.count is not None and scene.cell is None:
            found.append(((*path, "count"), "spheres are placed at random in a [cell]; there is none"))
    return found


def _torque(path: Path, came: int, scene: SoftScene) -> Complaints:
    wanted = 1 if dimensions_of(scene) == 2 else 3
    if not scene.rotation:
        return [(path, "spheres do not spin; expected rotation = true")]
    return [] if came == wanted else [(path, f"got {came} components; expected {wanted}")]


def _walls(scene: SoftScene) -> Complaints:
    sides = None if scene.cell is None else scene.cell.size
    found = wall_faults(scene.walls, dimensions_of(scene), sides)
    yields = [wall.shear_stress is not None for wall in scene.walls]
    if yields and all(yields) and scene.hydrodynamics.drag == "none":
        found.append(
            (
                (0, "shear_stress"),
                "all walls yield along x; expected one that does not, or hydrodynamics.drag = 'stokes'",
            )
        )
    return [(("walls", *path), message) for path, message in found]


def _gravity(scene: SoftScene) -> Complaints:
    if scene.gravity is None:
        return []
    found: Complaints = []
    if len(scene.gravity) != dimensions_of(scene):
        found.append((("gravity",), f"got {len(scene.gravity)} components; expected {dimensions_of(scene)}"))
    if scene.liquid.density is None and not scene.liquid.name:
        found.append((("liquid", "density"), "is missing; gravity needs it, for what the liquid lifts"))
    missing = [index for index, species in enumerate(scene.particles) if species.density is None]
    return found + [(("particles", index, "density"), "is missing; gravity needs it") for index in missing]


def _protocol(scene: SoftScene) -> Complaints:
    boxed = scene.cell is not None and not scene.walls
    found = protocol_faults(scene.protocol, dimensions_of(scene), boxed)
    if all(wall.shear_stress is None for wall in scene.walls):
        given = [index for index, stage in enumerate(scene.protocol) if stage.wall_shear is not None]
        found += [((index, "wall_shear"), "multiplies the shear_stress of walls; there is none") for index in given]
    return [(("protocol", *path), message) for path, message in found]


def _crowd(scene: SoftScene) -> Complaints:
    total = sum(species.count or len(species.positions) for species in scene.particles)
    if total < 2:
        return [(("particles",), "a single sphere has no film; expected two or more")]
    if total > MOST_SPHERES:
        return [(("particles",), f"{total} spheres are more than {MOST_SPHERES:.0e}")]
    return []
