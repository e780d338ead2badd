"""The floats of a scene: a species at once or one by one, spheres or other shapes."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from ecume.scenes.faults import Complaints, Inconsistent
from ecume.scenes.quantities import (
    STRICT,
    Color,
    ContactAngle,
    Coordinate,
    Count,
    Direction,
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
from ecume.units import Length

Rise = Annotated[Length, Field(ge=-1e-2, le=1e-2)]
PINNED = ("square", "star")
"""Shapes whose contact line is pinned to an edge; the others have a contact angle."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ShapeSpec:
    """The outline of a float from above. The `radius` of its species is that of the circle around it."""

    kind: Literal["ellipsoid", "needle", "square", "star"]
    """An ellipsoid; a needle: a lying cylinder with round ends; a square plate or cube; a flat star."""
    width: Size | None = None
    """Across an ellipsoid, a needle or the arm of a star (m); a square has none."""
    thickness: Size | None = None
    """Upright (m): of an ellipsoid or a star, left out, the width; of a square, left out, its side; a needle is
    round."""
    arms: Annotated[int, Field(strict=True, ge=3, le=12)] = 5
    """Of a star."""
    corner: Annotated[Proportion, Field(ge=0.02)] = 0.1
    """How round the corners of a square are: their radius over half of its side."""
    rim: Literal["top", "bottom"] = "bottom"
    """The edge that pins a square or a star: the lower one of what is light, the upper one of what is heavy."""
    undulation: Rise | None = None
    """How high the contact line rises along the body's own direction (m), negative where it dips; by default of an
    ellipsoid what its contact angle says, of all others nothing."""
    mode: Annotated[int, Field(strict=True, ge=2, le=12)] | None = None
    """How often it does so around the body; by default twice (ellipsoid, needle), four times (square), once an arm."""
    angle: Direction | None = None
    """Of the body's own direction at the start (rad, from the x axis): a long axis, a corner, an arm; by default by
    chance."""

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
            complaints.append((("width",), f"left out; expected how wide the {self.kind} is"))
        if self.kind == "needle" and self.thickness is not None:
            complaints.append((("thickness",), "a needle is round: it has a width only"))
        if self.kind == "star" and self.mode not in (None, self.arms):
            complaints.append((("mode",), f"got {self.mode}; a star rises and falls once an arm: leave it out"))
        if complaints:
            raise Inconsistent(complaints)
        if self.mode is None:
            modes = {"square": 4, "star": self.arms}
            object.__setattr__(self, "mode", modes.get(self.kind, 2))
        return self


def fitting(shape: ShapeSpec, radius: Length) -> Complaints:
    """The faults of a shape inside a circle of that radius."""
    if shape.width is not None and shape.width > 2.0 * radius:
        came = f"got {shape.width:g} m, more than the circle around it is wide, {2.0 * radius:g} m"
        return [(("shape", "width"), came)]
    return []


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SurfaceEnergies:
    """The energies of a float's surface against the gas and the liquid: Young's law makes the contact angle of them."""

    solid_gas: Tension
    """J/m^2 = N/m"""
    solid_liquid: Tension
    """J/m^2 = N/m"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class DiscSpec:
    """A flat disc instead of a sphere: the contact line is pinned to one of its edges."""

    thickness: Size
    """m"""
    rim: Literal["top", "bottom"] = "bottom"
    """The edge that pins: the lower one of what is light, the upper one of what is heavier than the liquid."""
    tilting: Switch = True
    """Whether it may lean."""
    undulation: Undulation = 0.0
    """How high the rim rises and falls around the disc (m); such discs turn, and need the method `multipole`."""
    mode: Annotated[int, Field(strict=True, ge=2, le=12)] = 2
    """How often it does so: 2 is a quadrupole, as of an ellipsoid; 3 a hexapole, as of a cube on its corner."""
    angle: Direction | None = None
    """Where the rim is highest at the start (rad, from the x axis); by default by chance."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class FloatSpec:
    """Equal spheres, discs or other shapes, and where they start."""

    name: Name = ""
    """What this species is called; `float-1` and so on when empty."""
    count: Count = 0
    """How many; by default one or as many as there are positions."""
    radius: Radius
    """m"""
    density: PositiveDensity
    """kg/m^3"""
    contact_angle: ContactAngle | None = None
    """rad, through the liquid; or `original-closure`; or left out for `surface_energies`"""
    surface_energies: SurfaceEnergies | None = None
    """instead of a contact angle"""
    disc: DiscSpec | None = None
    """what makes it a disc; its edge pins the contact line, whatever the angle"""
    shape: ShapeSpec | None = None
    """what makes it longer than wide, or gives it corners; such floats turn"""
    placement: Literal["random", "lattice", "ring"] = "random"
    """How they are laid out: at random without overlap, on a triangular lattice, evenly on a ring."""
    positions: tuple[tuple[Coordinate, Coordinate], ...] = ()
    """Where each starts (m); overrules the placement."""
    velocity: tuple[Velocity, Velocity] = (0.0, 0.0)
    """What each starts with (m/s)."""
    velocities: tuple[tuple[Velocity, Velocity], ...] = ()
    """The same one by one, as many as positions; overrules the velocity."""
    spacing: Size | None = None
    """The lattice's distance between neighbors (m)."""
    ring_radius: Size | None = None
    """The ring's (m)."""
    center: tuple[Coordinate, Coordinate] = (0.0, 0.0)
    """The lattice's or ring's (m)."""
    magnetic_moment: MagneticMoment = 0.0
    """Of a magnet that stands upright (A m^2): positive points up; such floats repel one another."""
    color: Color | None = None
    """`#rrggbb`, or a plain English name."""

    @property
    def species_name(self) -> str:
        """The name of its species, as a row has it."""
        return self.name

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        complaints = [*_wetting(self), *_layout(self), *_figure(self)]
        if complaints:
            raise Inconsistent(complaints)
        if not self.count:
            object.__setattr__(self, "count", len(self.positions) or 1)
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class FloatRow:
    """One float of a table, or of another run's frame."""

    x: Coordinate
    """m"""
    y: Coordinate
    """m"""
    vx: Velocity = 0.0
    """m/s"""
    vy: Velocity = 0.0
    """m/s"""
    radius: Radius
    """m"""
    density: PositiveDensity
    """kg/m^3"""
    contact_angle: ContactAngle | None = None
    """as in FloatSpec"""
    surface_energies: SurfaceEnergies | None = None
    """as in FloatSpec"""
    magnetic_moment: MagneticMoment = 0.0
    """as in FloatSpec"""
    disc: DiscSpec | None = None
    """as in FloatSpec"""
    shape: ShapeSpec | None = None
    """as in FloatSpec"""
    angle: Direction = 0.0
    """rad, of what turns; overrules that of a disc or shape"""
    spin: TurningRate = 0.0
    """rad/s, of what turns"""
    species_name: Name = "float-1"
    """Rows of one name are one species."""
    color: Color | None = None
    """as in FloatSpec"""

    @property
    def count(self) -> int:
        """A row is one float."""
        return 1

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        complaints = [*_wetting(self), *_figure(self)]
        if complaints:
            raise Inconsistent(complaints)
        return self


def _wetting(body: FloatSpec | FloatRow) -> Complaints:
    """A contact angle comes from exactly one place."""
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
    came = "both" if all(given) else "neither"
    return [((), f"expected either contact_angle or surface_energies; got {came}")]


def _figure(species: FloatSpec | FloatRow) -> Complaints:
    """A float is a disc or another shape, which fits into its circle."""
    if species.shape is None:
        return []
    twice = [(("shape",), "a disc is a shape of its own: leave shape or disc out")] if species.disc is not None else []
    return [*twice, *fitting(species.shape, species.radius)]


def _layout(species: FloatSpec) -> Complaints:
    """Positions are as many as the count; lattices and rings have their length, and nothing else has it."""
    if len(species.velocities) not in (0, len(species.positions)):
        return [(("velocities",), f"got {len(species.velocities)}; there are {len(species.positions)} positions")]
    if species.positions:
        fits = species.count in (0, len(species.positions))
        return [] if fits else [(("count",), f"got {species.count}; there are {len(species.positions)} positions")]
    complaints: Complaints = []
    for placement, key in (("lattice", "spacing"), ("ring", "ring_radius")):
        given = getattr(species, key) is not None
        if given and species.placement != placement:
            complaints.append(((key,), f'means something only with placement = "{placement}"'))
        if not given and species.placement == placement:
            complaints.append((("placement",), f'"{placement}" needs {key} as well'))
    return complaints
