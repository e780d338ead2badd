"""The scene of the floating model: liquid, floats, dish, and which laws rule them."""

from __future__ import annotations

import dataclasses
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from ecume.scenes.common import Common, Kind
from ecume.scenes.faults import Inconsistent, Path
from ecume.scenes.quantities import (
    MOST_PARTICLES,
    MOST_STEPS,
    STRICT,
    Color,
    ContactAngle,
    Coordinate,
    Count,
    Duration,
    GasDensity,
    Gravity,
    LawName,
    LiquidViscosity,
    Name,
    PositiveDensity,
    PositiveTension,
    Proportion,
    Radius,
    Size,
    Switch,
    Tension,
    Velocity,
    WettingAngle,
)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class LiquidSpec:
    """The liquid, and the gas above it. The defaults are water and air at 20 degrees Celsius."""

    density: PositiveDensity = 1000.0
    """kg/m^3"""
    viscosity: LiquidViscosity = 1e-3
    """Pa s"""
    surface_tension: PositiveTension = 0.0728
    """N/m"""
    gravity: Gravity = 9.81
    """m/s^2, downwards"""
    gas_density: GasDensity = 0.0
    """kg/m^3; smaller than the liquid's"""

    @model_validator(mode="after")
    def _gas_above_liquid(self) -> Self:
        if self.gas_density >= self.density:
            raise Inconsistent(
                [(("gas_density",), f"came {self.gas_density:g}; the liquid, {self.density:g} kg/m^3, is no denser")]
            )
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SurfaceEnergies:
    """What a float's surface costs against the gas and the liquid: Young's law makes the contact angle of them."""

    solid_gas: Tension
    """J/m^2 = N/m"""
    solid_liquid: Tension
    """J/m^2 = N/m"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class FloatSpec:
    """Equal spheres, and where they start."""

    name: Name = ""
    """What this species is called; `float-1` and so on when empty."""
    count: Count = 0
    """How many; left out, one or as many as there are positions."""
    radius: Radius
    """m"""
    density: PositiveDensity
    """kg/m^3"""
    contact_angle: ContactAngle | None = None
    """rad, through the liquid; or `original-closure`; or left out for `surface_energies`"""
    surface_energies: SurfaceEnergies | None = None
    """instead of a contact angle"""
    placement: Literal["random", "lattice", "ring"] = "random"
    """How they are laid out: at random without overlap, on a triangular lattice, evenly on a ring."""
    positions: tuple[tuple[Coordinate, Coordinate], ...] = ()
    """Where each starts (m); overrules the placement."""
    velocity: tuple[Velocity, Velocity] = (0.0, 0.0)
    """What each starts with (m/s)."""
    spacing: Size | None = None
    """The lattice's distance between neighbors (m)."""
    ring_radius: Size | None = None
    """The ring's (m)."""
    center: tuple[Coordinate, Coordinate] = (0.0, 0.0)
    """The lattice's or ring's (m)."""
    color: Color | None = None
    """`#rrggbb`, or a plain English name."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        complaints = [*_wetting(self), *_layout(self)]
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
    species_name: Name = "float-1"
    """Rows of one name are one species."""
    color: Color | None = None
    """as in FloatSpec"""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        complaints = _wetting(self)
        if complaints:
            raise Inconsistent(complaints)
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class DishSpec:
    """A round or rectangular dish around the origin. A scene without one is an endless surface."""

    radius: Size | None = None
    """m; or else `size`"""
    size: tuple[Size, Size] | None = None
    """Width and height as seen from above (m)."""
    contact_angle: WettingAngle = 0.7853981633974483
    """Of the liquid on the wall (rad): below 90 degrees it climbs."""
    law: LawName = "meniscus"
    """How the wall's meniscus pulls: `meniscus`, `two-point-legacy` or `none`."""
    density: PositiveDensity = 2500.0
    """Of the wall (kg/m^3), glass if left out; only `two-point-legacy` asks for it."""
    restitution: Proportion = 0.2
    """What is left of a normal velocity after a bounce off the wall."""

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        if (self.radius is None) == (self.size is None):
            came = "neither" if self.radius is None else "both"
            raise Inconsistent([((), f"wanted either radius or size; came {came}")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class MotionSpec:
    """How the equation of motion is stepped."""

    integrator: LawName = "velocity-verlet"
    """`velocity-verlet`, `explicit-euler`, `stormer-verlet`, `semi-implicit-euler` or `rk4`."""
    time_step: Duration | None = None
    """s; left out, the model chooses"""
    drag: Switch = True
    """Whether the liquid's viscosity slows the floats down."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ContactSpec:
    """What happens when two floats touch."""

    restitution: Proportion = 0.2
    """What is left of the approach velocity after a bounce."""
    legacy_coefficient: Proportion | None = None
    """The original's C, which means a restitution of 2C - 1; overrules `restitution`."""
    law: LawName = "impulse"
    """`impulse` or `none`"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class InteractionSpec:
    """How the floats' menisci pull at one another."""

    law: LawName = "capillary"
    """`capillary` or `none`"""
    charge: LawName = "nonlinear"
    """Where the capillary charge comes from: `nonlinear`, `closed-form` or `linear`."""
    accuracy: Annotated[Proportion, Field(ge=1e-12, le=1e-1)] = 1e-4
    """The part of the force at a raft's edge that may be cut off."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class FloatingScene(Common):
    """Spheres on a liquid surface, with or without a dish around them.

    A file may also say `floats_from = "table.csv"` or `start_from = "RUN@-1"`: reading it turns either into `rows`, so
    that a scene that was read stands alone.
    """

    model: Literal["floating"] = "floating"
    """Which model."""
    liquid: LiquidSpec = LiquidSpec()
    """What they float on."""
    floats: tuple[FloatSpec, ...] = ()
    """The species."""
    rows: tuple[FloatRow, ...] = ()
    """Floats given one by one, beside those of `floats`."""
    dish: DishSpec | None = None
    """The wall around them, if any."""
    motion: MotionSpec = MotionSpec()
    """The time stepping."""
    contacts: ContactSpec = ContactSpec()
    """The collisions."""
    interaction: InteractionSpec = InteractionSpec()
    """The pair force."""

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """The species, those of `floats` first."""
        return tuple(Kind(*named) for named in species_of(self))

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        named = tuple(
            dataclasses.replace(species, name=species.name or f"float-{index}")
            for index, species in enumerate(self.floats, 1)
        )
        object.__setattr__(self, "floats", named)
        complaints = [*_population(self), *_steps(self), *_doubles(self)]
        if complaints:
            raise Inconsistent(complaints)
        return self


def species_of(scene: FloatingScene) -> list[tuple[str, str | None]]:
    """The name and color of each species; its place in the list is its number in frames."""
    found: dict[str, str | None] = {species.name: species.color for species in scene.floats}
    for row in scene.rows:
        found[row.species_name] = found.get(row.species_name) or row.color
    return list(found.items())


Complaints = list[tuple[Path, str]]


def _wetting(body: FloatSpec | FloatRow) -> Complaints:
    """A contact angle comes from exactly one place."""
    given = [body.contact_angle is not None, body.surface_energies is not None]
    if sum(given) == 1:
        return []
    came = "both" if all(given) else "neither"
    return [((), f"wanted either contact_angle or surface_energies; came {came}")]


def _layout(species: FloatSpec) -> Complaints:
    """Positions are as many as the count; lattices and rings have their length, and nothing else has it."""
    if species.positions:
        fits = species.count in (0, len(species.positions))
        return [] if fits else [(("count",), f"came {species.count}; there are {len(species.positions)} positions")]
    complaints: Complaints = []
    for placement, key in (("lattice", "spacing"), ("ring", "ring_radius")):
        given = getattr(species, key) is not None
        if given and species.placement != placement:
            complaints.append(((key,), f'means something only with placement = "{placement}"'))
        if not given and species.placement == placement:
            complaints.append((("placement",), f'"{placement}" needs {key} as well'))
    return complaints


def _population(scene: FloatingScene) -> Complaints:
    total = len(scene.rows) + sum(species.count for species in scene.floats)
    if total == 0:
        return [
            (("floats",), "there is nothing afloat; write a [[floats]] table with radius, density and contact_angle")
        ]
    if total > MOST_PARTICLES:
        return [(("floats",), f"{total} floats are more than {MOST_PARTICLES:.0e}")]
    return []


def _steps(scene: FloatingScene) -> Complaints:
    step = scene.motion.time_step
    if step is None:
        return []
    if step > scene.frame_every * (1 + 1e-9):
        return [(("motion", "time_step"), f"came {step:g} s, longer than frame_every, {scene.frame_every:g} s")]
    steps = scene.duration / step
    return (
        [(("motion", "time_step"), f"gives {steps:.3g} steps, more than {MOST_STEPS:.0e}")]
        if steps > MOST_STEPS
        else []
    )


def _doubles(scene: FloatingScene) -> Complaints:
    names = [species.name for species in scene.floats]
    return [
        (("floats", index, "name"), f"came {name!r} for the second time; each species has its own name")
        for index, name in enumerate(names)
        if name in names[:index]
    ]
