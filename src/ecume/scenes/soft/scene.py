"""The scene of the soft model: elastic spheres close to contact in a viscous liquid, walls, and the forces on them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from ecume.engine.stationarity import FEWEST
from ecume.scenes.common import Common, Kind, dataclass
from ecume.scenes.faults import Complaints, Inconsistent, Path
from ecume.scenes.quantities import (
    STRICT,
    AbsoluteTemperature,
    Color,
    Coordinate,
    Count,
    Filling,
    GravityVector,
    LawName,
    Motion,
    Name,
    PositiveDensity,
    Radius,
    Size,
    Switch,
    downwards,
)
from ecume.scenes.sizes import Share, SizeSpec, list_faults, mean_power, shared_out, sized
from ecume.scenes.soft.protocol import (
    STRESS,
    StageSpec,
    Stress,
    end_of,
    protocol_faults,
)
from ecume.units import ROOM, Area, Energy, Force, Number, Pressure, Rate, SurfaceTension, Unit, Viscosity, with_prefix

Modulus = Annotated[Pressure, Field(ge=1e-9, le=1e15)]
Side = Literal["left", "right", "bottom", "top", "front", "back"]
SIDES: dict[str, tuple[int, float]] = {
    "left": (0, -1.0), "right": (0, 1.0), "bottom": (1, -1.0), "top": (1, 1.0), "front": (2, -1.0), "back": (2, 1.0),
}  # fmt: skip
"""The axis normal to each wall, and the side of the spheres on which it is."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class WallSpec:
    """A plane wall normal to an axis, which is fixed, moves with a given velocity, or follows a force. A box is not
    periodic along the normals of walls.
    """

    side: Side
    """The side of the wall: `left`, `right` (normal to x), `bottom`, `top` (normal to y), `front` or `back` (normal
    to z). Effect: moves the wall to another side."""
    position: Coordinate | None = None
    """The initial position of the wall along its normal (m); by default that end of the cell. Effect: shifts the
    wall."""
    modulus: Modulus | None = None
    """Young's modulus of the wall (Pa); by default it is rigid. Effect: softer walls are indented more."""
    velocity: Motion | None = None
    """The velocity of the wall (m/s). Effect: moves the wall: shear along it, compression across it."""
    pressure: Stress | None = None
    """The pressure that pushes the wall toward the spheres (Pa; N/m in 2D), at load 1; the wall then moves along its
    normal. Example: `"100 Pa"`. Effect: higher pressures compress the packing."""
    shear_stress: Stress | None = None
    """The shear stress that pulls the wall along x (Pa; N/m in 2D), at load 1; the wall then moves along x. Example:
    `"100 Pa"`. Effect: above the yield stress the packing flows."""
    drained: Switch | None = None
    """Whether liquid passes through the wall, with `[permeation]`; required at both walls across which it permeates.
    Effect: liquid leaves and enters the packing at drained walls only."""


def wall_faults(walls: Sequence[WallSpec], dimensions: int, sides: Sequence[float] | None) -> Complaints:
    """The faults of walls with impossible positions or motions."""
    found: Complaints = []
    seen: set[str] = set()
    for index, wall in enumerate(walls):
        axis, _ = SIDES[wall.side]
        if axis >= dimensions:
            found.append(((index, "side"), f"a layer has no {wall.side}; expected left, right, bottom or top"))
        if wall.side in seen:
            found.append(((index, "side"), f"appears twice: there is another {wall.side} wall"))
        seen.add(wall.side)
        if wall.position is None and sides is None:
            found.append(((index, "position"), "is missing; there is no [cell] at whose end the wall could stand"))
        found += [((index, *path), message) for path, message in _driven(wall, dimensions, sides)]
    return found


def _driven(wall: WallSpec, dimensions: int, sides: Sequence[float] | None) -> Complaints:
    axis, _ = SIDES[wall.side]
    found: Complaints = []
    if wall.velocity is not None and len(wall.velocity) != dimensions:
        found.append((("velocity",), f"got {len(wall.velocity)} components; expected {dimensions}"))
        return found
    velocity = wall.velocity or (0.0,) * dimensions
    if wall.pressure is not None and axis < dimensions and velocity[axis] != 0.0:
        found.append((("pressure",), "the wall's velocity along its axis is given; expected one of both"))
    if wall.shear_stress is not None and axis == 0:
        found.append((("shear_stress",), "pulls along x, which this wall stands across; expected pressure"))
    elif wall.shear_stress is not None and velocity[0] != 0.0:
        found.append((("shear_stress",), "the wall's velocity along x is given; expected one of both"))
    for name in ("pressure", "shear_stress"):
        value = getattr(wall, name)
        if value is not None and sides is None:
            found.append(((name,), "acts on the wall's area, that of the [cell]; add that table"))
        if fault := STRESS.fault(value, dimensions):
            found.append(((name,), fault))
    return found


MOST_SPHERES = 1_000_000

CavitationPressure = Annotated[Pressure, Field(gt=0.0, le=1e15)]
ThickViscosity = Annotated[Viscosity, Field(ge=1e-12, le=1e12)]
Load = Annotated[Force, Field(ge=-1e9, le=1e9)]
Strength = Annotated[Force, Field(ge=0.0, le=1e9)]
Hamaker = Annotated[Energy, Field(ge=0.0, le=1e9)]
Permeability = Annotated[Area, Field(gt=0.0, le=1e6)]
Tension = Annotated[SurfaceTension, Field(ge=1e-12, le=1e12)]
ViscosityRatio = Annotated[Number, Field(ge=1e-6, le=1e6)]
Coefficient = Annotated[Number, Field(ge=0.0, le=100.0)]
Prefactor = Annotated[Number, Field(gt=1e-6, le=1e6)]
Weight = Annotated[Number, Field(ge=1e-6, le=1e6)]
Tolerance = Annotated[Number, Field(ge=1e-11, le=1e-2)]
CompressionRate = Annotated[Rate, Field(ge=1e-9, le=1e9)]
Position = Annotated[tuple[Coordinate, ...], Field(min_length=2, max_length=3)]
"""Two coordinates in 2D, three in 3D."""
ForceVector = Annotated[tuple[Load, ...], Field(min_length=2, max_length=3)]
Twist = Annotated[float, Unit("N*m"), Field(ge=-1e9, le=1e9)]
TorqueVector = Annotated[tuple[Twist, ...], Field(min_length=1, max_length=3)]
Sides = Annotated[tuple[Size, ...], Field(min_length=2, max_length=3)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SoftLiquid:
    """The liquid between the spheres."""

    name: Name = ""
    """A liquid of the table in `ecume.laws.liquids`, such as `water`, at the `temperature`. Effect: provides the
    viscosity, density and surface tension that are not given."""
    temperature: AbsoluteTemperature = ROOM
    """The temperature of the named liquid (K); text such as `20 degC` is allowed. There is no thermal noise. Effect:
    a warmer liquid is less viscous."""
    viscosity: ThickViscosity | None = None
    """The dynamic viscosity of the liquid in the films (Pa s); required without a name. Effect: film forces are
    proportional to it: all times of relaxation grow with it."""
    surface_tension: Tension | None = None
    """The surface tension of bubbles or drops (N/m); required for `films.surface = "bubble"`. Effect: stiffens
    bubbles and drops."""
    density: PositiveDensity | None = None
    """The density of the liquid (kg/m^3); required with gravity. Effect: the buoyancy of the spheres is proportional
    to it."""

    @model_validator(mode="after")
    def _viscous(self) -> Self:
        if self.viscosity is None and not self.name:
            raise Inconsistent([(("viscosity",), 'is missing; give it, or the name of a liquid such as "water"')])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SoftHydrodynamicsSpec:
    """The drag of the surrounding liquid on moving spheres."""

    drag: Literal["none", "stokes"] = "none"
    """The drag of the surrounding liquid: `stokes` is 6 pi eta R per sphere, `none` leaves the films alone. Effect:
    gives spheres without contacts a finite velocity."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class PermeationSpec:
    """The flow of the liquid through the packing and through walls with `drained`, and its pore pressure."""

    law: LawName = "kozeny-carman"
    """The permeability: `kozeny-carman`, by the solid fraction of each layer, or `constant`. Effect: dense packings
    take in liquid more slowly with `kozeny-carman`."""
    permeability: Permeability | None = None
    """The permeability (m^2); required for `law = "constant"`. Example: `1e-9`. Effect: the time of consolidation is
    inversely proportional to it."""
    layer_height: Size | None = None
    """The height of the layers between which the pore pressure differs (m); by default two mean diameters. Effect:
    thinner layers resolve the pressure, and cost time."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SphereSpec:
    """Equal spheres with their initial positions and external forces."""

    name: Name = ""
    """The name of the species in frames, legends and exports; by default `sphere-1` and so on. Effect: none on the
    motion."""
    radius: Radius
    """The radius of each undeformed sphere (m); a list has one per sphere, a table a distribution with the keys
    `distribution`, `mean` and `spread`. Effect: larger spheres have larger contacts and stronger film forces."""
    radii: tuple[Radius, ...] = ()
    """One radius per particle (m), as a list in `radius` is kept. Example: `["1 mm", "1.2 mm"]`. Effect: gives each
    particle its own size."""
    sizes: SizeSpec | None = None
    """The distribution of radii, as a table in `radius` is kept. Effect: gives the particles different sizes."""
    modulus: Modulus | None = None
    """Young's modulus of the material (Pa); bubbles and drops have none. Effect: stiffer spheres are indented less;
    contact forces relax faster."""
    density: PositiveDensity | None = None
    """The density of each sphere (kg/m^3); required with gravity. Effect: spheres denser than the liquid settle,
    others rise."""
    positions: tuple[Position, ...] = ()
    """The initial position of each sphere (m): two coordinates in 2D, three in 3D. Effect: replaces the random
    packing of `count`."""
    count: Count | None = None
    """The number of spheres at random positions in the cell, instead of positions. Effect: run time grows faster
    than in proportion to it."""
    volume_share: Share | None = None
    """The part of the volume of all particles that this species is (in 2D of the area), instead of its count; at least
    one species has a count. Example: `"30 %"`. Effect: sets the number of particles."""
    glued: Side | None = None
    """The wall to which the spheres are glued: they make it rough, and move with it; those of a `count` touch the
    wall at random places. Example: `"bottom"`. Effect: rough walls drag the packing along, smooth ones slide."""
    force: ForceVector | None = None
    """The external force on each sphere (N), at load 1. Effect: moves the spheres; the forces must be balanced."""
    torque: TorqueVector | None = None
    """The external torque on each sphere (N m), at load 1, with `rotation`: one number in 2D, three in 3D. Effect:
    rotates the spheres."""
    color: Color | None = None
    """The color in pictures: `#rrggbb`, or an English name. Effect: none on the motion."""

    @model_validator(mode="before")
    @classmethod
    def _sized(cls, raw: Any) -> Any:
        return sized(raw)

    @property
    def number(self) -> int:
        """The number of spheres."""
        return self.count or len(self.positions)

    @model_validator(mode="after")
    def _placed(self) -> Self:
        given = self.count is not None or self.volume_share is not None
        if bool(self.positions) == given:
            got = "both" if self.positions else "neither"
            raise Inconsistent([((), f"expected either positions or count; got {got}")])
        if self.volume_share is not None and self.radii:
            raise Inconsistent([(("volume_share",), "got a list of radii, which says how many; expected one of both")])
        if wrong := list_faults(self, self.number or len(self.radii)):
            raise Inconsistent(wrong)
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class FilmSpec:
    """The law of contacts: a film of liquid in series with elastic surfaces."""

    surface: LawName = "hertz"
    """The elasticity of the surfaces: `hertz` for elastic spheres, `bubble` for bubbles and drops. Effect: `bubble`
    takes the stiffness from the surface tension."""
    interface: LawName = "rigid"
    """The mobility of the interfaces: `rigid`, `mobile` with free slip, `half-mobile` with one of both, `drop`, whose
    inner liquid is dragged along, or `elastohydrodynamic`, where sliding lifts soft surfaces apart. Effect: mobile
    interfaces let films drain faster; elastohydrodynamic films resist sliding with the root of its speed."""
    viscosity_ratio: ViscosityRatio = 1.0
    """The viscosity of the liquid in a drop, divided by that of the film. Effect: large ratios approach rigid
    interfaces."""
    friction: LawName = "none"
    """Contact friction: `none`, `coulomb` where gaps are below the roughness, or `critical-load`, there and above the
    critical load. Effect: friction resists shear and rotation in dense packings."""
    friction_coefficient: Coefficient = 0.5
    """The Coulomb friction coefficient: the largest tangential force divided by the normal one. Effect: larger
    values resist more before surfaces slide."""
    roughness: Size | None = None
    """The gap below which there is contact friction (m). Effect: larger values bring more contacts into friction."""
    critical_load: Strength | None = None
    """The compression of a contact above which there is friction (N); required for `friction = "critical-load"`.
    Example: `"5 uN"`. Effect: larger values delay shear thickening to larger stresses."""
    tangential_law: LawName = "potential"
    """The tangential force of a contact: `potential`, or `secant` as in the paper on the T1 process. Effect:
    `potential` keeps the stiffness definite where neighbors change."""
    tension_law: LawName | None = None
    """The law of contacts in tension: `gap` for a contact size by the gap alone, `symmetric` as in the paper, or
    `cavitation`; by default `gap` in a cell, without a cell `symmetric`. Effect: `symmetric` binds pairs."""
    cavitation_pressure: CavitationPressure | None = None
    """By how much the pressure in a film can fall below that outside (Pa); required for `tension_law =
    "cavitation"`. Example: `"98 kPa"`. Effect: lower values let films open more easily."""
    prefactors: LawName = "paper"
    """The set of the six numbers that follow: `paper` or `physical`. Effect: `physical` has the stiffness of Hertz
    contacts."""
    squeeze: Prefactor | None = None
    """The prefactor c_n of the squeezing friction c_n eta a^4/h^3; takes precedence over the set. Effect: larger
    values slow down approach and separation."""
    shear: Prefactor | None = None
    """The prefactor c_t of the sliding friction c_t eta a^2/h; takes precedence over the set. Effect: larger values
    slow down sliding."""
    normal: Prefactor | None = None
    """The prefactor alpha_n of the normal stiffness alpha_n E a; takes precedence over the set. Effect: larger
    values reduce the indentations."""
    tangential: Prefactor | None = None
    """The prefactor alpha_t of the tangential stiffness alpha_t E a; takes precedence over the set. Effect: larger
    values reduce the tangential deformation."""
    gap_weight: Weight | None = None
    """The weight c_h of the gap in the contact size a^2 = R (c_h h + c_d |delta|); takes precedence over the set.
    Effect: larger values widen contacts with wide films."""
    deflection_weight: Weight | None = None
    """The weight c_d of the indentation in the contact size a^2 = R (c_h h + c_d |delta|); takes precedence over the
    set. Effect: larger values widen contacts with strong indentation."""
    output: LawName = "scalars"
    """The contacts in frames: `scalars` for the narrowest ones of each sphere, `vectors` for all of them with image,
    force vectors and deflection. Effect: `vectors` enlarges frames, from which balance and stress can be computed."""
    cutoff: Size | None = None
    """The largest gap with a film (m); by default half of the smallest radius in a cell, without a cell infinite. At
    most half of the shortest periodic side. Effect: larger values include more pairs and cost more time."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class LongRangeSpec:
    """The force between surfaces across the film."""

    law: LawName = "none"
    """The force between surfaces across the film: `none`, `steric` or `dlvo`. Effect: `steric` repels, `dlvo`
    attracts at small gaps and repels at larger ones."""
    steric_strength: Strength = 0.0
    """The force of the steric repulsion at half its length (N). Effect: stronger repulsion holds films open."""
    steric_length: Size = 1e-8
    """The range of the steric repulsion (m). Effect: longer ranges hold thicker films."""
    hamaker_constant: Hamaker = 0.0
    """The Hamaker constant of the van der Waals attraction (J). Effect: larger values attract the surfaces more
    strongly."""
    double_layer_strength: Strength = 0.0
    """The strength of the electric double layer (J/m = N). Effect: larger values repel the surfaces more strongly."""
    debye_length: Size = 1e-8
    """The Debye length of the electric double layer (m). Effect: longer values extend the repulsion."""
    smallest_separation: Size = 1.65e-10
    """The gap at which attracting surfaces touch (m): the repulsion of their atoms balances the van der Waals
    attraction there. Effect: larger values weaken the adhesion of surfaces in contact."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class CellSpec:
    """A periodic box. Under Lees-Edwards shear the copies above and below it move."""

    size: Sides
    """The sides of the periodic cell (m), one per dimension; with `volume_fraction` their proportions only. Effect:
    a larger cell dilutes the packing."""
    volume_fraction: Filling | None = None
    """The fraction of the cell in undeformed spheres at the start, in 2D of the area; by default it follows from
    `size`. Example: `0.84`. Effect: above jamming the spheres are compressed."""
    minimum_gap: Size | None = None
    """The smallest gap of spheres placed at random (m); by default a hundredth of the smallest radius. Effect:
    larger gaps are harder to place in dense packings."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class PreparationSpec:
    """The preparation of a random packing before time 0: isotropic compression, or compression by a wall, followed by
    relaxation until forces are nearly constant. Loads, torques, gravity and the motion of walls start at time 0.
    """

    volume_fraction: Filling | None = None
    """The volume fraction to which the packing is compressed; that of the cell is where it begins. The sides at time 0
    are those of this fraction. Example: `0.86`. Effect: denser packings bear larger stresses."""
    pressure: Stress | None = None
    """The pressure to which the packing is compressed, and at which it is left (Pa; N/m in 2D), instead of a fraction.
    Between walls the one that has a pressure compresses it.
    Example: `"10 Pa"`. Effect: higher pressures leave denser packings."""
    rate: CompressionRate | None = None
    """The rate at which the sides are shortened (1/s); by default a thousandth of pressure over viscosity, or a
    millionth of modulus over viscosity. Effect: slower compression leaves time for rearrangements, and costs time."""
    relaxed: Annotated[Number, Field(ge=1e-6, le=1.0)] = 0.01
    """The part of the forces on contacts by which they still change within a time of 1/rate when time 0 begins; both
    are root mean squares. Effect: smaller values leave the packing to itself for longer."""

    @model_validator(mode="after")
    def _one(self) -> Self:
        if (self.volume_fraction is None) == (self.pressure is None):
            raise Inconsistent([((), "expected either volume_fraction or pressure")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class IntegrationSpec:
    """The time integration: implicit, with steps as long as the tolerance allows."""

    integrator: LawName = "esdirk4"
    """The implicit scheme: `esdirk4` of order 4 or `tr-bdf2` of order 2, both L-stable. Effect: `tr-bdf2` is cheaper
    per step, `esdirk4` more accurate."""
    tolerance: Tolerance = 1e-6
    """The error per step of ln(gap), and of directions (rad). Effect: smaller values shorten the steps and cost more
    time."""
    solver: LawName = "auto"
    """The solver of the linear systems: `auto`, `dense`, `iterative`, `direct` or `cholmod`. Effect: none on the
    result beyond the tolerance; run times differ."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SoftScene(Common):
    """Soft spheres in a viscous liquid, with motion so slow that inertia is negligible."""

    model: Literal["soft"] = "soft"
    """The model: soft spheres with films between them, without inertia. Effect: selects the equations that are
    solved."""
    liquid: SoftLiquid
    """The properties of the liquid in the films. Effect: they set the film forces."""
    particles: Annotated[tuple[SphereSpec, ...], Field(min_length=1)]
    """The species of spheres, one table each. Effect: each species adds spheres with common properties."""
    rotation: Switch = False
    """Whether spheres rotate, so that torques are balanced as well. Effect: rotation reduces the resistance to shear
    and costs time."""
    films: FilmSpec = FilmSpec()
    """The contacts: a film of liquid in series with the elasticity of the surfaces. Effect: determines resistance
    and stiffness."""
    long_range_forces: LongRangeSpec = LongRangeSpec()
    """The colloidal forces across the films. Effect: they hold films open or attract surfaces."""
    gravity: GravityVector | None = None
    """The gravitational acceleration (m/s^2): a magnitude, along -y, or a vector; by default none; requires
    densities. Effect: spheres settle or rise in proportion to it."""
    cell: CellSpec | None = None
    """The periodic cell; without it space is infinite. Effect: allows homogeneous shear and compression."""
    preparation: PreparationSpec | None = None
    """How the packing is compressed and relaxed before time 0. Effect: the run begins with a packing at rest."""
    walls: tuple[WallSpec, ...] = ()
    """Plane walls; the cell is not periodic across them. Effect: spheres rest on them or are compressed between
    them."""
    protocol: tuple[StageSpec, ...] = ()
    """The loading over time, one table per instant. Effect: drives loads, shear and compression."""
    hydrodynamics: SoftHydrodynamicsSpec = SoftHydrodynamicsSpec()
    """The drag of the surrounding liquid. Effect: balances forces on spheres without contacts."""
    permeation: PermeationSpec | None = None
    """The flow of the liquid through the packing between walls; by default it takes no pressure. Effect: dense packings
    start to flow late, since they must take in liquid."""
    integration: IntegrationSpec = IntegrationSpec()
    """The time stepping: implicit, with steps chosen by the tolerance. Effect: determines the error per step and the
    cost."""

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """The species; the index of each is its number in frames."""
        return tuple(Kind(one.name or f"sphere-{index}", one.color) for index, one in enumerate(self.particles, 1))

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.gravity is not None:
            object.__setattr__(self, "gravity", downwards(self.gravity, dimensions_of(self)))
        object.__setattr__(self, "particles", shared_out(self.particles, dimensions_of(self)))
        complaints = [
            *_dimensions(self), *_protocol(self), *_walls(self), *_gravity(self), *_too_dense(self), *_cutoff(self),
            *_preparation(self), *_permeation(self),
        ]  # fmt: skip
        if complaints:
            raise Inconsistent(complaints)
        return self


def sides_of(scene: SoftScene) -> tuple[float, ...]:
    """The sides of the box at scale 1 (m), from the volume fraction, or that of the preparation; empty without a
    box.
    """
    if scene.cell is None:
        return ()
    size, expected = scene.cell.size, scene.cell.volume_fraction
    if scene.preparation is not None:
        expected = scene.preparation.volume_fraction or expected
    if expected is None:
        return size
    factor = (volume_of(scene) / expected / math.prod(size)) ** (1.0 / len(size))
    return tuple(factor * side for side in size)


def volume_of(scene: SoftScene) -> float:
    """The volume of all undeformed spheres (m^3); in 2D the area of their sections (m^2)."""
    unit, power = (math.pi, 2) if dimensions_of(scene) == 2 else (4.0 / 3.0 * math.pi, 3)
    return sum(one.number * unit * mean_power(one, power, one.number) for one in scene.particles)


def first_fraction(scene: SoftScene) -> float:
    """The volume fraction at which spheres are placed at random; 0 without a box."""
    if scene.cell is None:
        return 0.0
    return scene.cell.volume_fraction or volume_of(scene) / math.prod(scene.cell.size)


def tension_law_of(scene: SoftScene) -> str:
    """The tension law of a scene: the given one, otherwise the default of packings in a cell, or that of clusters
    without a cell.
    """
    if scene.films.tension_law is not None:
        return scene.films.tension_law
    return "symmetric" if scene.cell is None else "gap"


def dimensions_of(scene: SoftScene) -> int:
    """The number of dimensions, from the box or the first position: 2 for a layer, 3 for a packing in 3D."""
    if scene.cell is not None:
        return len(scene.cell.size)
    return next((len(position) for species in scene.particles for position in species.positions), 2)


def _dimensions(scene: SoftScene) -> Complaints:
    """The faults of positions and forces whose numbers of components differ."""
    expected = dimensions_of(scene)
    found: Complaints = []
    for index, species in enumerate(scene.particles):
        path: Path = ("particles", index)
        found += [
            ((*path, "positions", place), f"got {len(position)} coordinates; expected {expected} as elsewhere")
            for place, position in enumerate(species.positions)
            if len(position) != expected
        ]
        if species.force is not None and len(species.force) != expected:
            found.append(((*path, "force"), f"got {len(species.force)} components; expected {expected}"))
        if species.torque is not None:
            found += _torque((*path, "torque"), len(species.torque), scene)
        if species.count is not None and scene.cell is None:
            found.append(((*path, "count"), "spheres are placed at random in a [cell]; add that table"))
    return found


def _torque(path: Path, got: int, scene: SoftScene) -> Complaints:
    expected = 1 if dimensions_of(scene) == 2 else 3
    if not scene.rotation:
        return [(path, "spheres do not spin; expected rotation = true")]
    return [] if got == expected else [(path, f"got {got} components; expected {expected}")]


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
    return [(("walls", *path), message) for path, message in found] + _rough(scene)


DENSEST_LAYER = {2: 1.0, 3: 0.9}
"""The largest part of a wall that spheres on it cover, by dimension: in 3D about that of the triangular lattice."""


def _rough(scene: SoftScene) -> Complaints:
    """The faults of glued spheres: without the wall, in a liquid with drag, or more spheres than there is room on the
    wall.
    """
    found: Complaints = []
    given = [(index, one) for index, one in enumerate(scene.particles) if one.glued is not None]
    dimensions, sides = dimensions_of(scene), sides_of(scene)
    for index, one in given:
        path = ("particles", index, "glued")
        if one.glued not in [wall.side for wall in scene.walls]:
            found.append((path, f'there is no {one.glued} wall; expected [[walls]] with side = "{one.glued}"'))
        elif scene.hydrodynamics.drag != "none":
            found.append((path, 'the drag of the liquid on a rough wall is not known; expected drag = "none"'))
        elif one.count and sides:
            axis = SIDES[one.glued][0]
            disc = 2.0 if dimensions == 2 else math.pi
            covered = disc * sum(
                mean_power(other, dimensions - 1, other.number) * other.number
                for _, other in given
                if other.glued == one.glued
            )
            room = math.prod(sides) / sides[axis] * DENSEST_LAYER[dimensions]
            if covered > room:
                cause = f"{covered / room:.3g} times as many spheres as have room on the {one.glued} wall"
                found.append((("particles", index, "count"), f"{cause}; expected fewer, or a larger cell.size"))
    return found


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
        found += [((index, "wall_shear"), "multiplies the shear_stress of walls; no wall has one") for index in given]
    found += [
        ((index, "rate_steps"), f"end at {end_of(stage):g} s; expected a duration of that, got {scene.duration:g} s")
        for index, stage in enumerate(scene.protocol)
        if end_of(stage) > max(scene.duration * (1.0 + 1e-9), stage.time)
    ]
    found += [fault for index, stage in enumerate(scene.protocol) for fault in _untested(index, stage, scene)]
    return [(("protocol", *path), message) for path, message in found]


def _untested(index: int, stage: StageSpec, scene: SoftScene) -> Complaints:
    """The fault of a rate with too few frames to find its stress stationary."""
    steps = stage.rate_steps
    if steps is None or steps.stationary_within is None:
        return []
    counts = [
        span / scene.frame_every / each * (1.0 + 1e-9) for span, each in zip(steps.spans, steps.strides, strict=True)
    ]
    if min(counts) >= FEWEST:
        return []
    place = counts.index(min(counts))
    most = steps.spans[place] / steps.strides[place] / FEWEST
    cause = (
        f"is tested at frames, of which {abs(steps.rates[place]):g} /s has {math.floor(counts[place])} in a strain of "
    )
    cause += f"{steps.strain:g}; expected {FEWEST} or more: a frame_every of {most:.3g} s or less, or a larger strain"
    return [((index, "rate_steps", "stationary_within"), cause)]


def _preparation(scene: SoftScene) -> Complaints:
    """The faults of a preparation: without a periodic cell, with a wrong unit, or to a size that is not the initial one
    of the protocol.
    """
    spec = scene.preparation
    if spec is None:
        return []
    if scene.cell is None:
        return [(("preparation",), "is that of a [cell]; add that table")]
    if scene.walls and (cause := _unpressed(scene, spec)):
        return [(("preparation",), cause)]
    if fault := STRESS.fault(spec.pressure, dimensions_of(scene)):
        return [(("preparation", "pressure"), fault)]
    found: Complaints = []
    goal, begin = spec.volume_fraction, first_fraction(scene)
    if goal is not None and goal <= begin:
        found.append((("preparation", "volume_fraction"), f"got {goal:g}; expected more than the cell's {begin:.4g}"))
    for index, stage in enumerate(scene.protocol):
        if stage.time == 0.0 and (stage.strain or (stage.scale or 1.0) != 1.0):
            found.append((("protocol", index), "expected neither a strain nor a scale at time 0, after a preparation"))
        elif stage.scale is not None and spec.pressure is not None:
            cause = "cannot be reached after a preparation to a pressure; expected height_rate, normal_stress, pressure"
            found.append((("protocol", index, "scale"), cause))
    return found


def _unpressed(scene: SoftScene, spec: PreparationSpec) -> str:
    """The reason why no wall can compress a packing; empty if one can."""
    if spec.pressure is None:
        return "to a volume fraction shortens all sides of a cell; between walls expected preparation.pressure"
    pressed = [wall for wall in scene.walls if wall.pressure is not None]
    if len(pressed) != 1:
        return f"between walls is by the wall that has a pressure; expected one of them, got {len(pressed)}"
    return ""


def _permeation(scene: SoftScene) -> Complaints:
    """The faults of a permeation: without the required walls, or where no flow is possible."""
    ends = [(index, wall) for index, wall in enumerate(scene.walls) if wall.drained is not None]
    if scene.permeation is None:
        cause = "is that of a packing with [permeation]; add that table"
        return [(("walls", index, "drained"), cause) for index, _ in ends]
    if scene.cell is None:
        return [(("permeation",), "passes through the cross-section of a [cell]; add that table")]
    if not ends:
        return [(("permeation",), "is across walls; expected drained = true or false at the walls across one axis")]
    if scene.hydrodynamics.drag != "none":
        cause = 'and permeation both are the drag of the liquid on the spheres; expected drag = "none"'
        return [(("hydrodynamics", "drag"), cause)]
    axis = SIDES[ends[0][1].side][0]
    found: Complaints = []
    for index, wall in enumerate(scene.walls):
        across = SIDES[wall.side][0]
        if across == axis and wall.drained is None:
            found.append((("walls", index, "drained"), "is missing; the wall across from it has it"))
        elif across != axis and wall.drained is not None:
            found.append((("walls", index, "drained"), "is that of a wall across another axis; expected one axis"))
        elif across != axis and (wall.pressure is not None or _approach(wall)):
            cause = "changes the cross-section that the liquid permeates; expected a wall that stays"
            found.append((("walls", index), cause))
    return found or _closed([(index, wall) for index, wall in ends if not wall.drained])


def _closed(undrained: Sequence[tuple[int, WallSpec]]) -> Complaints:
    """The fault of two undrained walls that would approach each other."""
    pressed = any(wall.pressure is not None for _, wall in undrained)
    if len(undrained) < 2 or not (pressed or len({_approach(wall) for _, wall in undrained}) > 1):
        return []
    cause = "is false at both walls, and liquid and spheres keep their volume; expected one that is drained"
    return [(("walls", undrained[1][0], "drained"), cause)]


def _approach(wall: WallSpec) -> float:
    """The velocity of a wall along its normal (m/s)."""
    axis, velocity = SIDES[wall.side][0], wall.velocity or ()
    return velocity[axis] if axis < len(velocity) else 0.0


def _cutoff(scene: SoftScene) -> Complaints:
    """The fault of films longer than half of the box, which would reach several copies of a sphere."""
    walled = {SIDES[wall.side][0] for wall in scene.walls}
    periodic = [side for axis, side in enumerate(sides_of(scene)) if axis not in walled]
    cutoff, most = scene.films.cutoff, 0.5 * min(periodic, default=math.inf)
    if cutoff is None or cutoff <= most:
        return []
    got, limit = with_prefix(cutoff, "m", 3), with_prefix(most, "m", 3)
    return [(("films", "cutoff"), f"got {got}; expected at most half of the shortest periodic side, {limit}")]


def _too_dense(scene: SoftScene) -> Complaints:
    total = sum(species.count or len(species.positions) for species in scene.particles)
    if total < 2 and not scene.walls:
        return [(("particles",), "a single sphere has no film; expected two or more, or a wall")]
    if total > MOST_SPHERES:
        return [(("particles",), f"{total} spheres are more than {MOST_SPHERES:.0e}")]
    return []
