"""The surroundings of the floats and their laws: liquid, dish, currents, contacts, interactions."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as Folder
from typing import Annotated, Any, Self

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from ecume.scenes.faults import Complaints, Inconsistent
from ecume.scenes.files import beside, require_there, text_of
from ecume.scenes.quantities import (
    ROOM,
    STRICT,
    AbsoluteTemperature,
    Amplitude,
    Coordinate,
    Direction,
    Duration,
    Frequency,
    GasDensity,
    LawName,
    LiquidViscosity,
    Name,
    PositiveDensity,
    PositiveTension,
    Proportion,
    Roughness,
    Size,
    Springiness,
    Switch,
    TurningRate,
    Velocity,
    WettingAngle,
)
from ecume.scenes.tables import MOST_BYTES, followed, lines_of
from ecume.units import Number

TABLE = "velocity_from"
COLUMNS = {"x": "m", "y": "m", "vx": "m/s", "vy": "m/s"}
EVEN = 1e-6
"""How far nodes may be from equal steps, over a step."""


def follow_current(raw: dict[str, Any], folder: Folder) -> Complaints:
    """Put what the flow's table says into `raw`; what is wrong with it comes back."""
    flow = raw.get("flow")
    if not isinstance(flow, dict) or TABLE not in flow:
        return []
    return followed(("flow", TABLE), _nodes_from, flow, flow.pop(TABLE), folder)


def _nodes_from(flow: dict[str, Any], name: str, folder: Folder) -> None:
    path = beside(folder, name)
    require_there(path, folder)
    lines = lines_of(text_of(path, MOST_BYTES), COLUMNS)
    if missing := [column for column in COLUMNS if column not in lines[0].values]:
        raise ValueError(f"has no column {missing[0]}; expected x, y, vx and vy")
    flow["nodes"] = nodes_of([[line.values[column] for column in COLUMNS] for line in lines])


def nodes_of(rows: Sequence[Sequence[float]]) -> dict[str, Any]:
    """A `NodesSpec` from rows of x, y, vx and vy in any order. Raises ValueError where they are no grid.

    >>> nodes_of([(0, 0, 1, 2), (1, 0, 3, 4), (0, 1, 5, 6), (1, 1, 7, 8)])["vx"]
    [[1, 5], [3, 7]]
    """
    x, y = (sorted({row[axis] for row in rows}) for axis in (0, 1))
    at = {(row[0], row[1]): (row[2], row[3]) for row in rows}
    if len(at) != len(rows):
        raise ValueError("has a node twice")
    if len(x) < 2 or len(y) < 2 or len(at) != len(x) * len(y):
        raise ValueError(f"is no grid: {len(at)} nodes, with {len(x)} different x and {len(y)} different y")
    for axis, places in (("x", x), ("y", y)):
        _require_even(axis, places)
    along, across = ([[at[i, j][part] for j in y] for i in x] for part in (0, 1))
    return {"low": [x[0], y[0]], "high": [x[-1], y[-1]], "vx": along, "vy": across}


def _require_even(axis: str, places: Sequence[float]) -> None:
    step = (places[-1] - places[0]) / (len(places) - 1)
    if any(abs(place - places[0] - k * step) > EVEN * step for k, place in enumerate(places)):
        raise ValueError(f"is uneven along {axis}; expected equal steps of {step:g} m")


@dataclass(frozen=True, kw_only=True, config=STRICT)
class NodesSpec:
    """Velocities at the nodes of a grid of equal steps, straight between them; beyond it as at its edge.

    A file says `velocity_from = "table.csv"` instead, with the columns x, y, vx and vy.
    """

    low: tuple[Coordinate, Coordinate]
    """The node with the least x and y (m)."""
    high: tuple[Coordinate, Coordinate]
    """The node with the largest (m)."""
    vx: tuple[tuple[Velocity, ...], ...]
    """Along x (m/s): a row for each x, in it one for each y."""
    vy: tuple[tuple[Velocity, ...], ...]
    """Along y (m/s), likewise."""

    @model_validator(mode="after")
    def _rectangular(self) -> Self:
        shapes = {(len(part), len(row)) for part in (self.vx, self.vy) for row in part}
        if len(shapes) != 1 or min(next(iter(shapes))) < 2:
            raise Inconsistent([(("vx",), "expected as many numbers in each row as in vy, at least 2 rows of 2")])
        if not (self.low[0] < self.high[0] and self.low[1] < self.high[1]):
            raise Inconsistent([(("high",), "expected larger coordinates than low has")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class FlowSpec:
    """How the liquid's surface flows, which drags the floats along: a uniform flow, three linear ones and a table's,
    added up.
    """

    velocity: tuple[Velocity, Velocity] = (0.0, 0.0)
    """At the origin (m/s)."""
    shear_rate: TurningRate = 0.0
    """How much faster along x for each meter along y (1/s)."""
    rotation_rate: TurningRate = 0.0
    """About the origin, counterclockwise (1/s)."""
    extension_rate: TurningRate = 0.0
    """Apart along x and together along y, for each meter from the origin (1/s)."""
    nodes: NodesSpec | None = None
    """A flow of your own; a file says `velocity_from = "table.csv"` instead."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class LiquidSpec:
    """The liquid, and the gas above it."""

    name: Name = ""
    """A liquid of the table in `ecume.laws.liquids`, such as `water`; it provides the properties that are not given."""
    temperature: AbsoluteTemperature = ROOM
    """K, or text such as `20 degC`"""
    density: PositiveDensity | None = None
    """kg/m^3; by default that of the liquid named, or 1000"""
    viscosity: LiquidViscosity | None = None
    """Pa s; by default that of the liquid named, or 0.001"""
    surface_tension: PositiveTension | None = None
    """N/m; by default that of the liquid named, or 0.0728"""
    gas_density: GasDensity = 0.0
    """kg/m^3; smaller than the liquid's"""

    @model_validator(mode="after")
    def _gas_above_liquid(self) -> Self:
        for key, usual in (("density", 1000.0), ("viscosity", 1e-3), ("surface_tension", 0.0728)):
            if not self.name and getattr(self, key) is None:
                object.__setattr__(self, key, usual)
        if self.density is not None and self.gas_density >= self.density:
            raise Inconsistent(
                [(("gas_density",), f"got {self.gas_density:g}; the liquid, {self.density:g} kg/m^3, is no denser")]
            )
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class DishMotionSpec:
    """A dish that is drawn along, or swings to and fro; floats are where and as fast as they are seen from it."""

    velocity: tuple[Velocity, Velocity] = (0.0, 0.0)
    """Of the dish (m/s), which stays."""
    amplitude: Amplitude = 0.0
    """Of its swing (m), from rest: A(1 - cos(2 pi f t))."""
    direction: Direction = 0.0
    """Into which it swings first (rad, from the x axis)."""
    frequency: Frequency = 1.0
    """Of the swing (1/s)."""
    entrainment: Proportion = 0.0
    """The part of the dish's motion that the liquid goes along with: 0 for a frame in a wide pool, 1 for a closed dish
    moved more slowly than its liquid sloshes, in which floats feel nothing of it."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class DishSpec:
    """A dish around the origin. A scene without one is an endless surface."""

    shape: LawName | None = None
    """`round`, `rectangle` ...; left out, round with a `radius` and a rectangle with a `size`"""
    radius: Size | None = None
    """m; or else `size`"""
    size: tuple[Size, Size] | None = None
    """Width and height as seen from above (m)."""
    contact_angle: WettingAngle = 0.7853981633974483
    """Of the liquid on the wall (rad): below 90 degrees it climbs."""
    law: LawName | None = None
    """How the wall's meniscus pulls: `meniscus`, `profile`, `linear`, `two-point-legacy` or `none`; by default the
    theory's."""
    image: LawName = "none"
    """What the wall does with a float's own meniscus: `none`, `fixed-angle` (draws it near) or `pinned` (repels it)."""
    density: PositiveDensity = 2500.0
    """Of the wall (kg/m^3), glass by default; only `two-point-legacy` asks for it."""
    restitution: Proportion = 0.2
    """What is left of a normal velocity after a bounce off the wall."""
    friction: Roughness = 0.0
    """Coulomb's coefficient at the wall; with one, floats spin."""
    motion: DishMotionSpec | None = None
    """How it is moved, if it is."""

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        if (self.radius is None) == (self.size is None):
            came = "neither" if self.radius is None else "both"
            raise Inconsistent([((), f"expected either radius or size; got {came}")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class LubricationSpec:
    """Liquid between floats that resists being squeezed out, and drawn in."""

    roughness: Size
    """The gap (m) below which the film gets no thinner: smooth spheres would never touch."""
    cutoff: Annotated[Number, Field(gt=2.0, le=1e3)] = 4.0
    """How far apart centers may be, over the radius, for a film to be between them."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class IntegrationSpec:
    """The time integration."""

    integrator: LawName = "velocity-verlet"
    """`velocity-verlet`, `explicit-euler`, `stormer-verlet`, `semi-implicit-euler`, `rk4` or `overdamped`."""
    time_step: Duration | None = None
    """s; by default the model chooses"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class HydrodynamicsSpec:
    """The forces of the liquid on moving floats."""

    drag: LawName | None = None
    """`stokes`, for slow floats, `schiller-naumann`, which grows with the Reynolds number, or `none`; by default
    `stokes`, but `none` in `legacy-2022`."""
    added_mass: Switch = False
    """Whether spheres carry half the mass of the liquid that they displace."""
    lubrication: LubricationSpec | None = None
    """The drag of floats that approach one another; by default each drags as if it were alone."""
    brownian: Switch = False
    """Brownian motion at the liquid's temperature; needs the integrator `overdamped`."""

    @property
    def resists(self) -> bool:
        """Whether there is drag."""
        return self.drag != "none"


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ContactSpec:
    """The contacts between floats."""

    restitution: Proportion = 0.2
    """What is left of the approach velocity after a bounce."""
    friction: Roughness = 0.0
    """Coulomb's coefficient between two floats: the impulse along their surfaces is at most so much of the one that
    keeps them apart; with one, floats spin."""
    legacy_coefficient: Proportion | None = None
    """The original's C, which means a restitution of 2C - 1; overrules `restitution`. In `legacy-2022` 0.3, if left
    out."""
    law: LawName = "impulse"
    """`impulse`, `spring-dashpot`, which is soft, or `none`."""
    stiffness: Springiness | None = None
    """Of the springs (N/m); by default so stiff that what floats do to each other presses them in by a thousandth of a
    radius."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class InteractionSpec:
    """The interaction of floats by their menisci."""

    law: LawName | None = None
    """`capillary`, `one-sided-legacy` or `none`; by default the theory's"""
    charge: LawName | None = None
    """Where the capillary charge comes from: `nonlinear`, `closed-form` or `linear`; by default the theory's."""
    method: LawName = "superposition"
    """What floats do together: `superposition`, `pair-corrected` by tables for two, or `multipole`, all at once."""
    order: Annotated[int, Field(strict=True, ge=1, le=60)] = 8
    """Of the multipoles: 8 is good to 1e-3 at a gap of 2 % of a diameter."""
    accuracy: Annotated[Proportion, Field(ge=1e-12, le=1e-1)] = 1e-4
    """The part of the force at a raft's edge that may be cut off; of a grid also its r.m.s. error."""
    summation: LawName = "auto"
    """How superposed forces are added up: pair by pair with `cells`, with a `grid` beside them, which crowds of small
    floats want, or as is less work, `auto`."""
    precision: LawName = "double"
    """Of the pair forces: `double`, or `single`, which errs by 1e-6 and is faster."""
