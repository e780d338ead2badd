"""The scene of the floating model, and its floats.

Floats are spheres or other shapes, given as species or one by one.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from ecume.scenes.common import Common, Kind, dataclass
from ecume.scenes.faults import Complaints, Inconsistent
from ecume.scenes.floating.surroundings import (
    ActivitySpec,
    CellSpec,
    ContactSpec,
    DishSpec,
    FlowSpec,
    HydrodynamicsSpec,
    IntegrationSpec,
    InteractionSpec,
    LiquidSpec,
    MagneticFieldSpec,
    SurfactantSpec,
    WavesSpec,
)
from ecume.scenes.quantities import (
    MOST_PARTICLES,
    MOST_STEPS,
    STRICT,
    Color,
    ContactAngle,
    Coordinate,
    Count,
    Direction,
    Gravity,
    MagneticMoment,
    Name,
    PositiveDensity,
    Proportion,
    Radius,
    Size,
    Switch,
    Tension,
    TurningRate,
    Undulation,
    Velocity,
)
from ecume.scenes.sizes import Share, SizeSpec, list_faults, mean_power, shared_out, sized
from ecume.units import Length

Rise = Annotated[Length, Field(ge=-1e-2, le=1e-2)]
PINNED = ("square", "star")
"""Shapes whose contact line is pinned to an edge; the others have a contact angle."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ShapeSpec:
    """The outline of a float from above. The `radius` of its species is that of the circle around it."""

    kind: Literal["ellipsoid", "needle", "square", "star"]
    """The shape: an ellipsoid; a needle, which is a horizontal cylinder with round ends; a square plate or cube; a
    flat star. Effect: determines the capillary multipoles, the drag and the outline for collisions."""
    width: Size | None = None
    """The width of an ellipsoid, a needle or an arm of a star (m); squares have none. Effect: a smaller width makes
    the body more slender: its capillary quadrupole and its anisotropic drag grow."""
    thickness: Size | None = None
    """The vertical size of an ellipsoid, a star or a square (m); by default the width, of a square the side. A
    needle is round. Effect: a thicker body is heavier and displaces more liquid."""
    arms: Annotated[int, Field(strict=True, ge=3, le=12)] = 5
    """The number of arms of a star. Effect: sets the symmetry of the outline and the default `mode`."""
    corner: Annotated[Proportion, Field(ge=0.02)] = 0.1
    """The radius of the corners of a square, divided by half of its side. Effect: 1 gives a circle; small values
    give sharp corners, which collide at smaller distances."""
    rim: Literal["top", "bottom"] = "bottom"
    """The edge that pins the contact line of a square or a star. Effect: `bottom` holds light bodies, `top` holds
    bodies denser than the liquid."""
    undulation: Rise | None = None
    """The amplitude of the height of the contact line along the axis of the body (m), negative where it dips; by
    default the value that follows from the contact angle of an ellipsoid, zero for other shapes. Effect: forces
    and torques between undulated bodies grow with its square."""
    mode: Annotated[int, Field(strict=True, ge=2, le=12)] | None = None
    """The number of periods of the contact line around the body; by default 2 (ellipsoid, needle), 4 (square) or the
    number of arms. Example: `3`. Effect: higher modes give forces of shorter range."""
    angle: Direction | None = None
    """The initial angle of the long axis, a corner or an arm from the x axis (rad); by default random. Effect: sets
    the initial orientation."""

    @property
    def pinned(self) -> bool:
        """Whether the contact line is pinned to an edge."""
        return self.kind in PINNED

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        complaints: Complaints = []
        if self.kind == "square" and self.width is not None:
            complaints.append((("width",), "a square has none: its radius, that of the circle around it, says all"))
        if self.kind != "square" and self.width is None:
            complaints.append((("width",), f"is missing; expected the width of the {self.kind}"))
        if self.kind == "needle" and self.thickness is not None:
            complaints.append((("thickness",), "a needle is round: it has a width only"))
        if self.kind == "star" and self.mode not in (None, self.arms):
            complaints.append((("mode",), f"got {self.mode}; expected {self.arms}, one period per arm, or no mode"))
        if complaints:
            raise Inconsistent(complaints)
        if self.mode is None:
            modes = {"square": 4, "star": self.arms}
            object.__setattr__(self, "mode", modes.get(self.kind, 2))
        return self


THINNEST = 1e-4
"""The smallest width of a particle over its radius."""


def fitting(shape: ShapeSpec, radius: Length) -> Complaints:
    """The faults of a shape that does not fit into a circle of this radius."""
    if shape.width is not None and shape.width > 2.0 * radius:
        got = f"got {shape.width:g} m, more than the circle around it is wide, {2.0 * radius:g} m"
        return [(("shape", "width"), got)]
    if shape.width is not None and shape.width < THINNEST * radius:
        return [(("shape", "width"), f"got {shape.width:g} m; expected at least {THINNEST:g} of the radius")]
    return []


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SurfaceEnergies:
    """The energies of the surface of a float against the gas and the liquid, from which Young's law determines the
    contact angle.
    """

    solid_gas: Tension
    """The surface energy of the solid against the gas (J/m^2 = N/m). Effect: a larger value lowers the contact angle
    that follows from Young's law."""
    solid_liquid: Tension
    """The surface energy of the solid against the liquid (J/m^2 = N/m). Effect: a larger value raises the contact
    angle that follows from Young's law."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class DiscSpec:
    """A flat disc instead of a sphere: the contact line is pinned to one of its edges."""

    thickness: Size
    """The thickness of the disc (m). Effect: a thicker disc is heavier and displaces more liquid."""
    rim: Literal["top", "bottom"] = "bottom"
    """The edge that pins the contact line. Effect: `bottom` holds light discs, `top` holds discs denser than the
    liquid."""
    tilting: Switch = True
    """Whether the disc can tilt in the menisci of others. Effect: tilting discs attract each other more strongly at
    short distances."""
    tension_moment: Switch = False
    """Whether the horizontal tension at the rim rights a disc that tilts; the published balance leaves this moment
    out. Effect: discs smaller than the capillary length tilt half as much, and attract each other less in rafts."""
    undulation: Undulation = 0.0
    """The amplitude of the height of the rim (m); such discs rotate and require `interaction.method = "multipole"`.
    Effect: forces and torques between undulated discs grow with its square."""
    mode: Annotated[int, Field(strict=True, ge=2, le=12)] = 2
    """The number of periods of the height around the rim: 2 is a quadrupole, as of an ellipsoid, 3 a hexapole, as of
    a cube on its corner. Effect: higher modes give forces of shorter range."""
    angle: Direction | None = None
    """The initial direction of the highest point of the rim from the x axis (rad); by default random. Effect: sets
    the initial orientation."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.tension_moment and not self.tilting:
            raise Inconsistent([(("tension_moment",), "got true with tilting = false; expected it of discs that tilt")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class FloatSpec:
    """Equal spheres, discs or other shapes, and their initial positions."""

    name: Name = ""
    """The name of the species in frames, legends and exports; by default `float-1` and so on. Effect: none on the
    motion."""
    count: Count = 0
    """The number of floats; by default one, or the number of positions. Effect: forces cost more time than in
    proportion to it, except with a grid."""
    radius: Radius
    """The radius of each sphere or disc (m); of other shapes that of the circumscribed circle. A list has one per
    float, a table a distribution with the keys `distribution`, `mean` and `spread`. Effect: the capillary charge of a
    small sphere grows as the third power of it, the attraction as the sixth."""
    radii: tuple[Radius, ...] = ()
    """One radius per float (m), as a list in `radius` is kept. Example: `["1 mm", "1.2 mm"]`. Effect: gives each float
    its own size."""
    sizes: SizeSpec | None = None
    """The distribution of radii, as a table in `radius` is kept. Effect: gives the floats different sizes."""
    volume_share: Share | None = None
    """The part of the volume of all particles that this species is, instead of its count; at least one species
    has a count. Example: `"30 %"`. Effect: sets the number of particles."""
    density: PositiveDensity
    """The density of each float (kg/m^3). Effect: light floats raise the surface, heavy ones depress it; equal signs
    attract each other, opposite signs repel. Too dense floats sink and are refused."""
    contact_angle: ContactAngle | None = None
    """The contact angle, measured through the liquid (rad); or `original-closure`; or omitted with
    `surface_energies`. Effect: sets the height of a float and its capillary charge; above 90 deg the float is
    hydrophobic."""
    surface_energies: SurfaceEnergies | None = None
    """Surface energies, from which the contact angle follows, instead of a contact angle. Effect: replaces the
    contact angle by one that follows from the energies."""
    disc: DiscSpec | None = None
    """A flat disc instead of a sphere; its edge pins the contact line. Effect: replaces the contact angle by the
    edge."""
    shape: ShapeSpec | None = None
    """A shape that is elongated or has corners, instead of a sphere; such floats rotate. Effect: adds capillary
    torques, anisotropic drag and contacts of outlines."""
    placement: Literal["random", "lattice", "ring"] = "random"
    """The initial arrangement: random without overlap, a triangular lattice, or equal distances on a ring. Effect:
    random placement depends on `seed` and fails where there is too little area."""
    positions: tuple[tuple[Coordinate, Coordinate], ...] = ()
    """The initial position of each float (m); takes precedence over `placement`. Effect: replaces the random
    arrangement."""
    velocity: tuple[Velocity, Velocity] = (0.0, 0.0)
    """The initial velocity of all floats of the species (m/s). Effect: drag damps it within the relaxation time that
    `ecume check` prints."""
    velocities: tuple[tuple[Velocity, Velocity], ...] = ()
    """Individual initial velocities, one per position (m/s); take precedence over `velocity`. Effect: drag damps
    them within the relaxation time."""
    spacing: Size | None = None
    """The distance between neighbors of the lattice (m). Effect: must exceed the diameter; wider lattices take
    longer to collapse into rafts."""
    ring_radius: Size | None = None
    """The radius of the ring (m). Effect: larger rings have larger initial distances."""
    center: tuple[Coordinate, Coordinate] | None = None
    """The center of the lattice or the ring (m); by default the origin, in a periodic cell its center. Effect: shifts
    the arrangement."""
    magnetic_moment: MagneticMoment = 0.0
    """The moment of a vertical magnet in each float (A m^2), positive upward. Effect: parallel magnets repel each
    other with a force proportional to the product of their moments."""
    color: Color | None = None
    """The color in pictures: `#rrggbb`, or an English name. Effect: none on the motion."""

    @property
    def species_name(self) -> str:
        """The name of its species."""
        return self.name

    @property
    def sized(self) -> bool:
        """Whether its floats have different radii."""
        return bool(self.radii) or self.sizes is not None

    @model_validator(mode="before")
    @classmethod
    def _sized(cls, raw: Any) -> Any:
        return sized(raw)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        complaints = [*_wetting(self), *_layout(self), *_figure(self), *_sizes(self)]
        if complaints:
            raise Inconsistent(complaints)
        if not self.count and self.volume_share is None:
            object.__setattr__(self, "count", len(self.positions) or len(self.radii) or 1)
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class FloatRow:
    """One float of a table or of a frame of another run."""

    x: Coordinate
    """The initial position along x (m). Effect: sets the start of this float."""
    y: Coordinate
    """The initial position along y (m). Effect: sets the start of this float."""
    vx: Velocity = 0.0
    """The initial velocity along x (m/s). Effect: sets the start of this float."""
    vy: Velocity = 0.0
    """The initial velocity along y (m/s). Effect: sets the start of this float."""
    radius: Radius
    """The radius of this sphere or disc (m); of other shapes that of the circumscribed circle. Effect: as for a
    species of `particles`."""
    density: PositiveDensity
    """The density of this float (kg/m^3). Effect: as for a species of `particles`."""
    contact_angle: ContactAngle | None = None
    """The contact angle of this float, measured through the liquid (rad). Effect: as for a species of `particles`."""
    surface_energies: SurfaceEnergies | None = None
    """The surface energies of this float, instead of a contact angle. Effect: as for a species of `particles`."""
    magnetic_moment: MagneticMoment = 0.0
    """The moment of a vertical magnet in this float (A m^2). Effect: as for a species of `particles`."""
    disc: DiscSpec | None = None
    """A flat disc instead of a sphere. Effect: as for a species of `particles`."""
    shape: ShapeSpec | None = None
    """An elongated shape or one with corners instead of a sphere. Effect: as for a species of `particles`."""
    angle: Direction | None = None
    """The initial orientation of a float that rotates, or the heading of an active one (rad); by default that of its
    disc or shape, or 0, and a random heading. Example: `"30 deg"`. Effect: sets the start of this float."""
    spin: TurningRate = 0.0
    """The initial angular velocity of a float that rotates (rad/s). Effect: sets the start of this float."""
    species_name: Name = "float-1"
    """The name of the species; rows with equal names form one species. Effect: groups floats in numbers, legends and
    exports."""
    color: Color | None = None
    """The color in pictures: `#rrggbb`, or an English name. Example: `"orange"`. Effect: none on the motion."""

    @property
    def count(self) -> int:
        """The number of floats of a row: one."""
        return 1

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        complaints = [*_wetting(self), *_figure(self)]
        if complaints:
            raise Inconsistent(complaints)
        return self


def _wetting(body: FloatSpec | FloatRow) -> Complaints:
    """The fault if not exactly one key determines the contact angle."""
    given = [body.contact_angle is not None, body.surface_energies is not None]
    if body.disc is not None or (body.shape is not None and body.shape.pinned):
        what = "disc" if body.disc is not None else str(body.shape and body.shape.kind)
        return (
            [((), f"a {what} pins the contact line: leave contact_angle and surface_energies out")]
            if any(given)
            else []
        )
    if sum(given) == 1:
        return []
    got = "both" if all(given) else "neither"
    return [((), f"expected either contact_angle or surface_energies; got {got}")]


def _figure(species: FloatSpec | FloatRow) -> Complaints:
    """The fault if a float is neither a disc nor another shape that fits into its circle."""
    if species.shape is None:
        return []
    twice = [(("shape",), "got shape and disc; expected only one of them")] if species.disc is not None else []
    return [*twice, *fitting(species.shape, species.radius)]


def _sizes(species: FloatSpec) -> Complaints:
    """The faults of size distributions, or of shares of the volume, for floats that are not round."""
    found = list_faults(species, species.count or len(species.positions) or len(species.radii))
    if species.sized and species.shape is not None:
        found.append((("shape",), "has one size; expected one radius, or rows with a shape each"))
    if species.volume_share is not None and (species.shape is not None or species.disc is not None):
        found.append((("volume_share",), "is that of spheres; expected a count"))
    elif species.volume_share is not None and (species.positions or species.radii):
        found.append((("volume_share",), "got a list, which says how many; expected one of both"))
    return found


def _layout(species: FloatSpec) -> Complaints:
    """The faults if the number of positions differs from that of floats, if a lattice or a ring has no length, or if
    another placement has one.
    """
    if len(species.velocities) not in (0, len(species.positions)):
        return [(("velocities",), f"got {len(species.velocities)}; there are {len(species.positions)} positions")]
    complaints: Complaints = []
    placed = "" if species.positions else species.placement
    # Scenes of former versions contain the origin as the center.
    if species.center not in (None, (0.0, 0.0)) and placed in ("", "random"):
        complaints.append((("center",), 'means something only with placement = "lattice" or "ring", without positions'))
    for placement, key in (("lattice", "spacing"), ("ring", "ring_radius")):
        given = getattr(species, key) is not None
        if given and species.placement != placement:
            complaints.append(((key,), f'means something only with placement = "{placement}"'))
        if not given and placed == placement:
            complaints.append((("placement",), f'"{placement}" needs {key} as well'))
    if species.positions and species.count not in (0, len(species.positions)):
        complaints.append((("count",), f"got {species.count}; there are {len(species.positions)} positions"))
    return complaints


THEORIES: dict[str, dict[str, dict[str, Any]]] = {
    "nonlinear": {
        "interaction": {"law": "capillary", "charge": "nonlinear"},
        "dish": {"law": "meniscus"},
    },
    "linear": {
        "interaction": {"law": "capillary", "charge": "linear"},
        "dish": {"law": "linear"},
    },
    "legacy-2022": {
        "interaction": {"law": "one-sided-legacy", "charge": "linear"},
        "dish": {"law": "two-point-legacy"},
        "hydrodynamics": {"drag": "none"},
        "contacts": {"legacy_coefficient": 0.3},
    },
}
"""The defaults of each theory for laws that a scene omits."""

DRAG_BY_SPEED = ("velocity-verlet", "explicit-euler", "semi-implicit-euler")
"""The integrators that go with a drag which depends on the speed."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class FloatingScene(Common):
    """Spheres on a liquid surface, with or without a dish around them.

    A file may also contain `particles_from = "table.csv"` or `start_from = "RUN@-1"`; reading it converts either into
    `rows`, so that the scene does not depend on other files.
    """

    model: Literal["floating"] = "floating"
    """The model: particles at a liquid surface. Effect: selects the equations that are solved."""
    theory: Literal["nonlinear", "linear", "legacy-2022"] = "nonlinear"
    """The set of default laws: the exact far field, small slopes everywhere, or those of the original program.
    Effect: sets each law that the scene does not name."""
    liquid: LiquidSpec = LiquidSpec()
    """The properties of the liquid and of the gas above it. Effect: they set the capillary length, the drag and the
    attraction."""
    gravity: Gravity = 9.81
    """The gravitational acceleration (m/s^2), downward. Effect: a larger value shortens the capillary length, the
    range of the attraction, and increases the capillary charges."""
    flow: FlowSpec | None = None
    """A flow of the surface, imposed on the liquid. Effect: drags the floats along; requires drag."""
    particles: tuple[FloatSpec, ...] = ()
    """The species of floats, one table each. Effect: each species adds floats with common properties."""
    rows: tuple[FloatRow, ...] = ()
    """Individual floats, in addition to those of `particles`; tables and restarts are read into them. Effect: each
    row adds one float."""
    dish: DishSpec | None = None
    """The wall around the floats; without it and without a `cell` the surface is infinite. Effect: its meniscus
    attracts or repels floats, and they bounce off it."""
    cell: CellSpec | None = None
    """The periodic cell, instead of a dish. Effect: the floats are a part of an infinite layer, without walls and
    their menisci."""
    integration: IntegrationSpec = IntegrationSpec()
    """The time stepping. Effect: determines the error per step and the cost."""
    hydrodynamics: HydrodynamicsSpec = HydrodynamicsSpec()
    """The forces of the liquid on moving floats. Effect: they damp the motion or make it overdamped."""
    activity: ActivitySpec | None = None
    """Active forces and torques on floats. Effect: floats move without attraction or noise; requires drag."""
    magnetic_field: MagneticFieldSpec | None = None
    """A magnetic field, constant or oscillating, that induces moments. Effect: floats attract and repel one another by
    induced and permanent moments."""
    waves: WavesSpec | None = None
    """Waves radiated by floats that oscillate up and down. Effect: floats push and turn one another across many
    wavelengths; requires drag."""
    surfactant: SurfactantSpec | None = None
    """Surfactant such as camphor or soap at the surface. Effect: floats that release it swim, and the gradient of the
    surface tension pulls all others away from it; requires drag, and a dish or a cell."""
    contacts: ContactSpec = ContactSpec()
    """The contacts between floats. Effect: they determine collisions and the structure of rafts."""
    interaction: InteractionSpec = InteractionSpec()
    """The capillary interaction of floats. Effect: it determines attraction, accuracy and cost."""

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """The species, those of `particles` first."""
        return tuple(Kind(*named) for named in species_of(self))

    @property
    def rubs(self) -> bool:
        """Whether any surface has sliding friction."""
        return self.contacts.friction > 0.0 or (self.dish is not None and self.dish.friction > 0.0)

    @property
    def rolls(self) -> bool:
        """Whether any surface has rolling friction."""
        return self.contacts.rolling_friction > 0.0 or (self.dish is not None and self.dish.rolling_friction > 0.0)

    @property
    def sides(self) -> tuple[float, float]:
        """The sides of the periodic cell (m), as large as its area fraction requires; zero without a cell."""
        if self.cell is None:
            return 0.0, 0.0
        (width, height), asked = self.cell.size, self.cell.area_fraction
        if asked is None:
            return width, height
        covered = math.pi * sum(mean_power(one, 2, one.count) * one.count for one in self.particles)
        covered += math.pi * sum(row.radius**2 for row in self.rows)
        factor = math.sqrt(covered / asked / (width * height))
        return factor * width, factor * height

    @property
    def given(self) -> tuple[FloatSpec | FloatRow, ...]:
        """The entries that specify floats: tables of species, then rows."""
        return (*self.particles, *self.rows)

    @property
    def drag(self) -> str:
        """The drag law: that of `hydrodynamics.drag`, or the default, which is not a part of the scene and therefore
        may change with the integrator.
        """
        return default_drag(self) if self.hydrodynamics.drag is None else self.hydrodynamics.drag

    @property
    def shaped(self) -> bool:
        """Whether any float is longer than wide, or has corners."""
        return any(one.shape is not None for one in self.given)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        named = tuple(
            dataclasses.replace(species, name=species.name or f"float-{index}")
            for index, species in enumerate(shared_out(self.particles, 3), 1)
        )
        object.__setattr__(self, "particles", named)
        for part, laws in THEORIES[self.theory].items():
            given = getattr(self, part)
            left_out = {key: law for key, law in laws.items() if given is not None and getattr(given, key) is None}
            if left_out:
                object.__setattr__(self, part, dataclasses.replace(given, **left_out))
        complaints = [*_population(self), *_boundary(self), *_steps(self), *_doubles(self), *_tilts(self)]
        if complaints:
            raise Inconsistent(complaints)
        return self


def default_drag(scene: FloatingScene) -> str:
    """The drag law of a scene that does not name one: dependent on the Reynolds number where that is possible,
    otherwise Stokes's law.

    For slow floats both give Stokes drag.
    """
    sways = scene.dish is not None and scene.dish.motion is not None
    viscous = scene.liquid.viscosity != 0.0 or scene.liquid.gas_viscosity > 0.0
    slow = scene.integration.integrator not in DRAG_BY_SPEED or not viscous
    films, noisy = scene.hydrodynamics.lubrication is not None, scene.hydrodynamics.brownian
    return "stokes" if slow or sways or films or noisy or scene.shaped else "schiller-naumann"


def species_of(scene: FloatingScene) -> list[tuple[str, str | None]]:
    """The name and color of each species, in the order of the numbers in frames."""
    found: dict[str, str | None] = {species.name: species.color for species in scene.particles}
    for row in scene.rows:
        found[row.species_name] = found.get(row.species_name) or row.color
    return list(found.items())


def _population(scene: FloatingScene) -> Complaints:
    total = len(scene.rows) + sum(species.count for species in scene.particles)
    if total == 0:
        return [
            (
                ("particles",),
                "there is nothing afloat; write a [[particles]] table with radius, density and contact_angle",
            )
        ]
    if total > MOST_PARTICLES:
        return [(("particles",), f"{total} floats are more than {MOST_PARTICLES:.0e}")]
    return []


def _boundary(scene: FloatingScene) -> Complaints:
    if scene.cell is None or scene.dish is None:
        return []
    return [(("cell",), "is periodic along both axes, and there is a [dish] with walls; expected one of the two")]


def _steps(scene: FloatingScene) -> Complaints:
    step = scene.integration.time_step
    if step is None:
        return []
    if step > scene.frame_every * (1 + 1e-9):
        return [(("integration", "time_step"), f"got {step:g} s, longer than frame_every, {scene.frame_every:g} s")]
    steps = scene.duration / step
    return (
        [(("integration", "time_step"), f"gives {steps:.3g} steps, more than {MOST_STEPS:.0e}")]
        if steps > MOST_STEPS
        else []
    )


def _doubles(scene: FloatingScene) -> Complaints:
    names = [species.name for species in scene.particles]
    return [
        (("particles", index, "name"), f"got {name!r} for the second time; each species has its own name")
        for index, name in enumerate(names)
        if name in names[:index]
    ]


def _tilts(scene: FloatingScene) -> Complaints:
    """A fault for each disc with a moment of tilting in a scene whose sum of menisci tilts no disc."""
    if scene.interaction.method != "superposition":
        return []
    entries = [("particles", index, one.disc) for index, one in enumerate(scene.particles)]
    entries += [("rows", index, one.disc) for index, one in enumerate(scene.rows)]
    said = "superposed menisci tilt no disc; expected interaction.method = 'multipole' or 'pair-corrected'"
    return [
        ((table, index, "disc", "tension_moment"), f"got true, and {said}")
        for table, index, disc in entries
        if disc is not None and disc.tension_moment
    ]
