"""The surroundings of the floats and their laws: liquid, dish, currents, contacts, interactions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path as Folder
from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from ecume.scenes.common import Constant, dataclass
from ecume.scenes.faults import Complaints, Inconsistent
from ecume.scenes.fields import FieldSpec
from ecume.scenes.floating.barriers import BarrierSpec
from ecume.scenes.quantities import (
    STRICT,
    AbsoluteTemperature,
    Amplitude,
    Color,
    Coordinate,
    Direction,
    Duration,
    Filling,
    Frequency,
    GasDensity,
    Gradient,
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
    Tension,
    TurningRate,
    Velocity,
    WettingAngle,
)
from ecume.scenes.tables import MOST_BYTES, beside, followed, lines_of, require_there, table_text
from ecume.units import ROOM, Angle, Force, Number, Rate, Unit

Torque = Annotated[float, Unit("N*m")]
FluxDensity = Annotated[float, Unit("T"), Field(ge=-10.0, le=10.0)]
Corners = Annotated[tuple[tuple[Coordinate, Coordinate], ...], Field(min_length=3, max_length=100)]
TABLE = "velocity_from"
COLUMNS = {"x": "m", "y": "m", "vx": "m/s", "vy": "m/s"}
STEEPEST = math.radians(60.0) * (1.0 + 1e-12)
"""The largest tilt of a dish (rad)."""
EVEN = 1e-6
"""The largest deviation of nodes from equal steps, over a step."""


def follow_current(raw: dict[str, Any], folder: Folder) -> Complaints:
    """Replace the file of a flow in `raw` by the velocities of its table; return the faults of the file."""
    flow = raw.get("flow")
    if not isinstance(flow, dict) or TABLE not in flow:
        return []
    return followed(("flow", TABLE), _nodes_from, flow, flow.pop(TABLE), folder)


def _nodes_from(flow: dict[str, Any], name: str, folder: Folder) -> None:
    path = beside(folder, name)
    require_there(path, folder)
    lines = lines_of(table_text(path, MOST_BYTES), COLUMNS)
    if missing := [column for column in COLUMNS if column not in lines[0].values]:
        raise ValueError(f"has no column {missing[0]}; expected x, y, vx and vy")
    flow["nodes"] = nodes_of([[line.values[column] for column in COLUMNS] for line in lines])


def nodes_of(rows: Sequence[Sequence[float]]) -> dict[str, Any]:
    """The `NodesSpec` of rows of x, y, vx and vy in any order. Raises ValueError if they are not on
    a grid.

    >>> nodes_of([(0, 0, 1, 2), (1, 0, 3, 4), (0, 1, 5, 6), (1, 1, 7, 8)])["vx"]
    [[1, 5], [3, 7]]
    """
    x, y = (sorted({row[axis] for row in rows}) for axis in (0, 1))
    at = {(row[0], row[1]): (row[2], row[3]) for row in rows}
    if len(at) != len(rows):
        raise ValueError("has a node twice")
    if len(x) < 2 or len(y) < 2 or len(at) != len(x) * len(y):
        raise ValueError(f"is not a grid: {len(at)} nodes, with {len(x)} different x and {len(y)} different y")
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
    """Velocities at the nodes of a regular grid, with linear interpolation; beyond the grid, the value at its edge
    applies.

    In a file this is `velocity_from = "table.csv"`, with the columns x, y, vx and vy.
    """

    low: tuple[Coordinate, Coordinate]
    """The position of the first node (m). Effect: shifts the tabulated flow."""
    high: tuple[Coordinate, Coordinate]
    """The position of the last node (m); the nodes are equidistant. Effect: stretches the tabulated flow."""
    vx: tuple[tuple[Velocity, ...], ...]
    """The velocity along x at the nodes (m/s): one row per x, one number per y. Effect: drags floats along x."""
    vy: tuple[tuple[Velocity, ...], ...]
    """The velocity along y at the nodes (m/s), in the same form. Effect: drags floats along y."""

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
    """The flow of the liquid's surface, which drags the floats: the sum of a uniform flow, three linear ones and that
    of a table or a file.
    """

    velocity: tuple[Velocity, Velocity] = (0.0, 0.0)
    """The velocity of the surface at the origin (m/s). Effect: moves all floats with this velocity."""
    shear_rate: Gradient = 0.0
    """The gradient of the x velocity along y (1/s). Effect: separates floats at different y; adds noise-independent
    drift."""
    rotation_rate: TurningRate = 0.0
    """The angular velocity of a rotation about the origin (rad/s), counterclockwise. Effect: carries floats around
    the origin."""
    extension_rate: Gradient = 0.0
    """The strain rate: extension along x, compression along y (1/s). Effect: moves floats away from the origin along
    x and toward it along y."""
    nodes: NodesSpec | None = None
    """A tabulated flow, added to these; a file gives it as `velocity_from = "table.csv"`. Effect: adds the
    velocities of the table, interpolated between its nodes."""
    field: FieldSpec | None = None
    """Velocities from a file or a run, which may vary in time, added to these. Effect: drags floats with these
    velocities; NaN is land, where the liquid is at rest."""

    @model_validator(mode="after")
    def _one_table(self) -> Self:
        if self.nodes is not None and self.field is not None:
            raise Inconsistent([(("field",), "got a table, too; expected one of velocity_from and field")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class LiquidSpec:
    """The liquid, and the gas or second liquid above it. The defaults are rounded values of clean water at 20 degrees
    Celsius. The gas has neither density nor viscosity by default (air: 1.2 kg/m^3 and 1.8e-5 Pa s).
    """

    name: Name = ""
    """A liquid of the table in `ecume.laws.liquids`, such as `water`, at the `temperature`. Effect: provides the
    density, viscosity and surface tension that are not given."""
    temperature: AbsoluteTemperature = ROOM
    """The temperature of the named liquid and of Brownian motion (K); text such as `20 degC` is allowed. Effect: a
    warmer liquid is less viscous; thermal noise grows with it."""
    density: PositiveDensity | None = None
    """The density of the liquid (kg/m^3); by default that of the named liquid, or 1000. Effect: denser liquids lift
    floats higher and shorten the capillary length."""
    viscosity: LiquidViscosity | None = None
    """The dynamic viscosity of the liquid (Pa s); by default that of the named liquid, or 0.001. Effect: drag is
    proportional to it."""
    surface_tension: PositiveTension | None = None
    """The surface tension of the liquid against the gas (N/m); by default that of the named liquid, or 0.0728.
    Effect: holds heavy floats and lengthens the range of the attraction."""
    gas_density: GasDensity = 0.0
    """The density of the gas, or of a second liquid, above the liquid (kg/m^3), smaller than that of the liquid.
    Effect: reduces weight and buoyancy; of air the effect is 0.1 %."""
    gas_viscosity: LiquidViscosity = 0.0
    """The dynamic viscosity of the gas, or of a second liquid, above the liquid (Pa s); neglected by default, of air
    1.8e-5. Example: `"0.9 mPa*s"`. Effect: drag grows with the sum of both viscosities."""
    color: Color | None = None
    """The color of the level surface in pictures, such as `white` or `#fbf8f0`; by default that of the named liquid.
    Effect: higher and lower parts have tints of it."""

    @model_validator(mode="after")
    def _gas_above_liquid(self) -> Self:
        for key, usual in (("density", 1000.0), ("viscosity", 1e-3), ("surface_tension", 0.0728)):
            if not self.name and getattr(self, key) is None:
                object.__setattr__(self, key, usual)
        if self.density is not None and self.gas_density >= self.density:
            raise Inconsistent(
                [
                    (
                        ("gas_density",),
                        f"got {self.gas_density:g}; expected less than that of the liquid ({self.density:g} kg/m^3)",
                    )
                ]
            )
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class DishMotionSpec:
    """A dish that moves uniformly or oscillates; positions and velocities of floats are relative to it."""

    velocity: tuple[Velocity, Velocity] = (0.0, 0.0)
    """A constant velocity of the dish (m/s); floats are described in the frame of the dish. Effect: the liquid drags
    floats against the motion, unless it moves along."""
    amplitude: Amplitude = 0.0
    """The amplitude A of the oscillation A(1 - cos(2 pi f t)) (m). Effect: the inertial force on floats is
    proportional to it."""
    direction: Direction = 0.0
    """The initial direction of the oscillation from the x axis (rad). Effect: rotates the oscillation."""
    frequency: Frequency = 1.0
    """The frequency f of the oscillation (1/s); text may be in Hz. Effect: the inertial force on floats grows with
    its square."""
    entrainment: Proportion = 0.0
    """The fraction of the motion of the dish that the liquid follows: 0 in an open frame, 1 in a closed dish that
    moves more slowly than its liquid sloshes. Effect: at 1 the floats stay at rest relative to the dish."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class DishTiltSpec:
    """A dish whose axis is tilted, at rest. The surface of the liquid stays level, so that floats do not slide along
    it: the walls meet it at another angle and along another line.
    """

    angle: Annotated[Angle, Field(ge=0.0, le=STEEPEST)]
    """The angle of the axis of the dish from the vertical (rad), up to 60 deg. Example: `"10 deg"`. Effect: the liquid
    stands higher at the wall that leans over it, and lower at the wall that leans away."""
    direction: Direction = 0.0
    """The direction from the x axis to which the rim leans (rad). Example: `"90 deg"`. Effect: light floats collect at
    the opposite wall."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class CellSpec:
    """A periodic rectangle with one corner at the origin."""

    size: tuple[Size, Size]
    """The width and height of the periodic cell (m); with `area_fraction` their proportions only. Example:
    `["6 cm", "6 cm"]`. Effect: a larger cell dilutes the floats and lengthens the times until they meet."""
    area_fraction: Filling | None = None
    """The fraction of the cell that the floats cover; by default it follows from `size`. Example: `0.3`. Effect: sets
    the area of the cell."""


def _require_rubbing(surface: DishSpec | ContactSpec) -> None:
    """Raise Inconsistent for rolling friction of surfaces without sliding friction, since nothing rotates their
    floats.
    """
    if surface.rolling_friction > 0.0 and surface.friction == 0.0:
        got = f"got {surface.rolling_friction:g} without friction, so that no contact turns a float"
        raise Inconsistent([(("rolling_friction",), f"{got}; expected friction above 0, or no rolling_friction")])


@dataclass(frozen=True, kw_only=True, config=STRICT)
class DishSpec:
    """A dish around the origin. A scene without a dish has an unbounded surface."""

    shape: LawName | None = None
    """The shape of the dish: `round`, `ring`, `rectangle`, `ellipse` or `polygon`; by default the one whose size is
    given, of a `size` the rectangle. Effect: determines where the wall is."""
    radius: Size | None = None
    """The radius of a round dish, or of the outer wall of a ring (m); either this, `size` or `vertices`. Effect: a
    larger dish lengthens the times until floats meet."""
    inner_radius: Size | None = None
    """The radius of the inner wall of a ring around the origin (m), less than `radius`. Example: `"1 cm"`. Effect:
    floats move in the channel between both walls."""
    size: tuple[Size, Size] | None = None
    """The width and height of a rectangular or elliptic dish, seen from above (m). Effect: a larger dish lengthens the
    times until floats meet."""
    vertices: Corners | None = None
    """The corners of a convex dish (m), one after the other in either direction, with the origin inside. Example:
    `[[-0.03, -0.02], [0.03, -0.02], [0.0, 0.04]]`. Effect: determines where the walls are."""
    contact_angle: WettingAngle = 0.7853981633974483
    """The contact angle of the liquid at the wall (rad). Effect: below 90 deg the liquid rises at the wall, which
    attracts light floats and repels heavy ones."""
    inner_contact_angle: WettingAngle | None = None
    """The contact angle of the liquid at the inner wall of a ring (rad); by default `contact_angle`. Example:
    `"110 deg"`. Effect: below 90 deg the liquid rises at the inner wall."""
    law: LawName | None = None
    """The force of the meniscus of the wall: `meniscus`, `profile`, `linear`, `two-point-legacy` or `none`; by
    default that of the theory. Effect: `none` leaves a wall that only reflects."""
    image: LawName = "none"
    """The effect of the wall on the meniscus of a float: `none`, `fixed-angle` or `pinned`. Effect: `fixed-angle`
    attracts floats to the wall, `pinned` repels them."""
    density: PositiveDensity = 2500.0
    """The density of the wall (kg/m^3), by default that of glass. Effect: used by the law `two-point-legacy` only."""
    restitution: Proportion = 0.2
    """The ratio of normal velocities after and before a collision with the wall. Effect: 1 conserves the kinetic
    energy, 0 stops the normal motion."""
    friction: Roughness = 0.0
    """The Coulomb friction coefficient at the wall. Effect: above 0 floats rotate when they slide along the wall."""
    rolling_friction: Roughness = 0.0
    """The coefficient of rolling friction at the wall, which needs `friction`: the couple is at most this times the
    normal force times the radius of the float. Effect: floats that roll along the wall stop."""
    motion: DishMotionSpec | None = None
    """The motion of the dish. Effect: inertial forces and drag act on the floats."""
    tilt: DishTiltSpec | None = None
    """The tilt of the dish. Effect: the height of the liquid differs around the wall, and attracts floats to one
    side."""
    barrier: BarrierSpec | None = None
    """A side of a rectangular dish that moves, or the whole wall of a dish that closes. Effect: compresses the floats,
    and records their surface pressure."""

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        given = [key for key in ("radius", "size", "vertices") if getattr(self, key) is not None]
        if len(given) != 1:
            raise Inconsistent(
                [((), f"expected one of radius, size and vertices; got {' and '.join(given) or 'none'}")]
            )
        _require_rubbing(self)
        if complaints := _ring_faults(self):
            raise Inconsistent(complaints)
        if self.barrier is not None:
            _require_sides(self, self.barrier, given[0])
        return self


def _ring_faults(dish: DishSpec) -> Complaints:
    """The faults of a ring without an inner wall that fits, or that tilts or closes, and of other shapes with one."""
    inner, shape = dish.inner_radius, dish.shape
    if inner is None:
        found: Complaints = []
        if dish.inner_contact_angle is not None:
            found.append((("inner_contact_angle",), "is that of the inner wall of a ring; expected inner_radius, too"))
        if shape == "ring":
            found.append((("inner_radius",), "is missing; expected the radius of the inner wall of the ring"))
        return found
    if dish.radius is None or shape not in (None, "ring"):
        got = f"got a dish of the shape {shape!r}" if shape not in (None, "ring") else "got a dish without a radius"
        return [(("inner_radius",), f"{got}; expected a ring, with radius and inner_radius")]
    if not inner < dish.radius:
        return [(("inner_radius",), f"got {inner:g} m; expected less than the radius, {dish.radius:g} m")]
    if dish.tilt is not None:
        return [(("tilt",), "got a tilted ring; expected an upright one: the inner wall would be cut along an ellipse")]
    if dish.barrier is not None:
        return [(("barrier",), "got a ring; expected a dish without an inner wall: a barrier would run into it")]
    return []


def _require_sides(dish: DishSpec, barrier: BarrierSpec, given: str) -> None:
    """Refuse barriers that are no side of a rectangle or lean, and menisci at a wall that closes."""
    if dish.tilt is not None:
        got = "got a tilted dish, whose barrier would lean with its walls"
        raise Inconsistent([(("barrier",), f"{got}; expected no dish.tilt, or no barrier")])
    if barrier.closes:
        key = "law" if dish.law != "none" else "image"
        if (law := getattr(dish, key)) != "none":
            got = f"got {repr(law) if law else 'a meniscus'} at a wall that closes, whose meniscus changes"
            raise Inconsistent([((key,), f"{got} with its curvature; expected law = 'none' and image = 'none'")])
    elif dish.size is None or dish.shape == "ellipse":
        got = f"got a dish with {given}" if dish.size is None else "got an ellipse"
        expected = "expected size, the sides of a rectangle: the barrier is one of them; or side = 'all'"
        raise Inconsistent([(("barrier",), f"{got}; {expected}")])


@dataclass(frozen=True, kw_only=True, config=STRICT)
class LubricationSpec:
    """The lubrication film between floats, which resists squeezing and separation."""

    roughness: Size
    """The gap below which the film no longer becomes thinner (m). Effect: smaller values slow down the last
    approach: smooth spheres never touch."""
    cutoff: Annotated[Number, Field(gt=2.0, le=1e3)] | None = None
    """The largest distance of two centers with a film between them, in radii; by default 4, and 6 with
    `hydrodynamics.interaction`. Example: `10.0`. Effect: larger values include more pairs and cost more time."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class IntegrationSpec:
    """The time integration."""

    integrator: LawName = "velocity-verlet"
    """The integration scheme: `velocity-verlet`, `explicit-euler`, `stormer-verlet`, `semi-implicit-euler`, `rk4` or
    `overdamped`. Effect: `overdamped` omits inertia; the others differ in order and stability."""
    time_step: Duration | None = None
    """The time step (s), a whole fraction of `frame_every`; by default chosen from the scene. Effect: smaller steps
    are more accurate and cost more; unstable steps are refused."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class HydrodynamicsSpec:
    """The forces of the liquid on moving floats."""

    drag: LawName | None = None
    """The drag law: `stokes` for slow floats, `schiller-naumann`, which grows with the Reynolds number, or `none`.
    By default `schiller-naumann`; `stokes` for integrators that cannot, for shapes, with films or noise, and in moving
    dishes; `none` in `legacy-2022`. Effect: without drag floats oscillate around each other."""
    added_mass: Switch = False
    """Whether the inertia of spheres includes half the mass of the displaced liquid. Effect: makes floats slower to
    accelerate."""
    lubrication: LubricationSpec | None = None
    """Lubrication films between approaching floats; by default the drag on each float is that of a lone one. Effect:
    slows down approach and separation at small gaps."""
    interaction: LawName = "none"
    """The interaction of floats through the flow of the liquid: `none`, where each float has the drag of a single one,
    or `rotne-prager`, with the integrator `overdamped`. Example: `"rotne-prager"`. Effect: rafts move faster than
    single floats, and floats carry their neighbors along."""
    brownian: Switch = False
    """Brownian motion at the temperature of the liquid. With inertia (any integrator but `overdamped` and `rk4`) it
    needs elastic collisions, and steps below the relaxation time of the drag. Effect: adds thermal noise, which
    disperses floats below a few micrometers, and turns the headings of active floats and of floats that waves turn."""

    @property
    def resists(self) -> bool:
        """Whether the liquid exerts drag on floats."""
        return self.drag != "none"


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ActivitySpec:
    """Forces that drive floats: a random force with a memory, propulsion along a heading, and a torque."""

    force: Annotated[Force, Field(ge=0.0, le=1.0)] = 0.0
    """The root mean square of a random force on each float (N), an Ornstein-Uhlenbeck process with the correlation time
    `persistence`. Example: `"2 nN"`. Effect: floats move straight for about the persistence, then at random."""
    persistence: Duration | None = None
    """The correlation time of the random force (s); needed with `force`. Example: `"0.5 s"`. Effect: longer times give
    longer straight paths, and drive the floats farther from equilibrium."""
    propulsion: Annotated[Force, Field(ge=0.0, le=1.0)] = 0.0
    """A constant force on each float along its heading (N), which is random at the start. Example: `"1 nN"`. Effect:
    floats swim at this force over their drag."""
    rotational_diffusion: Annotated[Rate, Field(ge=0.0, le=1e6)] = 0.0
    """The diffusion coefficient of the headings (1/s), in addition to that by `hydrodynamics.brownian`. Example: `0.2`.
    Effect: headings are forgotten after its inverse."""
    torque: Annotated[Torque, Field(ge=-1.0, le=1.0)] = 0.0
    """A constant torque on each float (N m), positive counterclockwise. Example: `1e-14`. Effect: turns the headings
    against the drag of the liquid, so that floats swim in circles."""
    species: tuple[Name, ...] = ()
    """The active species; by default all. Example: `["swimmer"]`. Effect: other species are passive."""

    @model_validator(mode="after")
    def _remembered(self) -> Self:
        if (self.force > 0.0) != (self.persistence is not None):
            missing = "persistence" if self.persistence is None else "force"
            raise Inconsistent([((missing,), "expected force and persistence together; got one of them")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class MagneticFieldSpec:
    """A uniform magnetic field, constant and oscillating, and the moments that it induces in spheres."""

    constant: tuple[FluxDensity, FluxDensity, FluxDensity] = (0.0, 0.0, 0.0)
    """The constant part along x, y and upward (T). Example: `["0 mT", "0 mT", "5 mT"]`. Effect: a vertical field makes
    floats repel one another, a horizontal one makes them attract along it."""
    amplitude: tuple[FluxDensity, FluxDensity, FluxDensity] = (0.0, 0.0, 0.0)
    """The amplitudes of the oscillating part along x, y and upward (T). Example: `["2 mT", "0 mT", "0 mT"]`. Effect:
    floats oscillate toward one another."""
    frequency: Frequency = 1.0
    """The frequency f of the oscillating part, B cos(2 pi f t + phase) (1/s). Example: `"2 Hz"`. Effect: sets the
    period of the motion."""
    phase: tuple[Direction, Direction, Direction] = (0.0, 0.0, 0.0)
    """The phases of the three components (rad). Example: `["0 deg", "-90 deg", "0 deg"]`. Effect: with 90 degrees
    between two components the field rotates."""
    susceptibility: Annotated[Number, Field(ge=0.0, le=1e6)] = 0.0
    """The magnetic susceptibility of the spheres; 1,000 or more for soft iron. Effect: the induced moments grow as
    3 chi/(3 + chi)."""
    species: tuple[Name, ...] = ()
    """The species with this susceptibility; by default all. Example: `["steel"]`. Effect: others have no induced
    moment."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class WaveSourceSpec:
    """A point of each float of a species that presses on the liquid at the frequency of the waves."""

    species: Name = ""
    """The species that has this source; by default all. Example: `"surfer"`. Effect: floats without sources neither
    radiate waves nor feel them."""
    place: tuple[Coordinate, Coordinate] = (0.0, 0.0)
    """The place of the source in the frame of the float (m): along its heading, and to the left. Example: `["1.5 mm",
    "0 mm"]`. Effect: sources beside the center turn the float."""
    force: Annotated[Force, Field(gt=0.0, le=1.0)]
    """The amplitude of the vertical force on the liquid (N): mass times amplitude times the square of the angular
    frequency. Example: `"0.1 mN"`. Effect: forces between floats grow with the product of two of them."""
    phase: Direction = 0.0
    """The phase of the force (rad). Example: `"90 deg"`. Effect: the forces of two sources that differ in phase are not
    opposite."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class WavesSpec:
    """Waves of floats that oscillate vertically, as on a vibrated bath."""

    frequency: Frequency
    """The frequency of the oscillation (1/s). Example: `"100 Hz"`. Effect: sets the wavelength, and with it the
    distances of bound floats."""
    sources: Annotated[tuple[WaveSourceSpec, ...], Field(min_length=1)]
    """The sources of waves, in the frame of each float. Effect: floats attract and repel one another at distances that
    alternate with the wavelength, and turn."""
    headings: tuple[Direction, ...] = ()
    """The heading of each float at the start from the x axis (rad), those of `rows` last; by default random, and the
    `angle` of rows. Example: `["0 deg", "180 deg"]`.
    Effect: sets the directions of sources and of propulsion."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SurfactantSourceSpec:
    """Floats of a species that release surfactant over their area."""

    species: Name = ""
    """The species that releases it; by default all. Example: `"camphor"`. Effect: others only feel the gradient of the
    surface tension."""
    release: Annotated[float, Unit("kg/s"), Field(gt=0.0, le=1.0)]
    """The mass that each float releases per time (kg/s). Example: `"10 ug/s"`. Effect: the forces are proportional to
    it; above a threshold a lone float swims."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SurfactantDropSpec:
    """Surfactant at the surface at the start, such as a drop of soap."""

    position: tuple[Coordinate, Coordinate]
    """The center of the drop (m). Example: `["0 mm", "0 mm"]`. Effect: floats move away from it."""
    radius: Size
    """The radius of the disc over which it is spread at the start (m). Example: `"2 mm"`. Effect: a smaller drop has
    steeper gradients."""
    mass: Annotated[float, Unit("kg"), Field(gt=0.0, le=1.0)]
    """The mass of the drop (kg). Example: `"1 ug"`. Effect: the forces are proportional to it."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SurfactantSpec:
    """A surfactant such as camphor or soap at the surface, whose gradient drives floats (Marangoni)."""

    diffusivity: Annotated[float, Unit("m^2/s"), Field(gt=0.0, le=1.0)]
    """The effective diffusivity at the surface (m^2/s), which contains the flow that the gradient causes. Example:
    `"1 cm^2/s"`. Effect: spreads the surfactant farther ahead of a float."""
    tension_slope: Annotated[float, Unit("N*m/kg"), Field(gt=0.0, le=1e12)]
    """The fall of the surface tension per mass of surfactant on an area (N m/kg). Example: `1e3`. Effect: the forces
    are proportional to it."""
    loss_rate: Annotated[Rate, Field(ge=0.0, le=1e6)] = 0.0
    """The rate at which surfactant leaves the surface by evaporation and dissolution (1/s). Example: `0.5`. Effect:
    limits the range of the surfactant and the trail behind a float."""
    largest_fall: Tension | None = None
    """The largest fall of the surface tension (N/m), where the surface is saturated; by default all of it. Example:
    `"40 mN/m"`. Effect: no forces act where the surface is saturated."""
    advected: Switch = True
    """Whether the imposed flow of the surface carries the surfactant along. Effect: moves the surfactant with
    `flow`."""
    spacing: Size | None = None
    """The spacing of the grid (m); by default a third of the smallest radius of a float. Example: `"1 mm"`. Effect:
    a finer grid is more accurate and costs the fourth power of its fineness."""
    sources: tuple[SurfactantSourceSpec, ...] = ()
    """The floats that release surfactant. Effect: they swim, and repel others."""
    drops: tuple[SurfactantDropSpec, ...] = ()
    """Surfactant that is at the surface at the start. Effect: floats move away from it."""

    @model_validator(mode="after")
    def _released(self) -> Self:
        if not self.sources and not self.drops:
            raise Inconsistent([(("sources",), "is missing; expected sources or drops of surfactant")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ContactSpec:
    """The contacts between floats."""

    restitution: Proportion = 0.2
    """The ratio of relative normal velocities after and before a collision of two floats. Effect: 1 conserves the
    kinetic energy, 0 makes floats stay together."""
    friction: Roughness = 0.0
    """The Coulomb friction coefficient between two floats, which limits the tangential impulse of a contact. Effect:
    above 0 floats rotate."""
    rolling_friction: Roughness = 0.0
    """The coefficient of rolling friction between two floats, which needs `friction`: the couple on each is at most
    this times the normal force times R_i R_j/(R_i + R_j). Example: `0.1`. Effect: chains stay bent instead of closing
    to triangles."""
    legacy_coefficient: Proportion | None = None
    """The coefficient C of the original program, with the restitution 2C - 1; takes precedence over `restitution`;
    in `legacy-2022` by default 0.3. Example: `0.7`. Effect: below 0.5 floats lose more than their approach
    velocity."""
    law: LawName = "impulse"
    """The contact law: `impulse`, `spring-dashpot`, which is soft, or `none`. Effect: without contacts floats pass
    through each other; the wall of a dish holds them all the same."""
    stiffness: Springiness | None = None
    """The stiffness of the springs (N/m); by default the value for an indentation of a thousandth of a radius.
    Effect: stiffer springs need shorter time steps."""

    @model_validator(mode="after")
    def _rubs(self) -> Self:
        _require_rubbing(self)
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class InteractionSpec:
    """The interaction of floats by their menisci."""

    law: LawName | None = None
    """The pair law: `capillary`, `one-sided-legacy` or `none`; by default that of the theory. Effect: `none` leaves
    floats that only collide."""
    constants: tuple[Constant, ...] = ()
    """The numbers that a pair law lets a scene set, in SI units and in the order of its definition; none of the three
    above has any. Example: `[2e-12, 1e-3]`. Effect: they set strength and range, as the law defines."""
    charge: LawName | None = None
    """The computation of the capillary charge: `nonlinear`, `closed-form` or `linear`; by default that of the
    theory. Effect: the forces are proportional to the product of two charges; for steep menisci only `nonlinear`
    is exact."""
    method: LawName = "superposition"
    """The treatment of several floats: `superposition`, `pair-corrected` by tables for two, or `multipole` for all
    at once. Effect: `multipole` is accurate near contact and costs much more."""
    order: Annotated[int, Field(strict=True, ge=1, le=60)] = 8
    """The order of the multipole expansion. Effect: 8 has an error of 1e-3 at a gap of 2 % of a diameter; the cost
    grows as the third power."""
    accuracy: Annotated[Proportion, Field(ge=1e-12, le=1e-1)] = 1e-4
    """The fraction of the force at the edge of a raft that may be neglected; with a grid also its r.m.s. error.
    Effect: smaller values lengthen the cutoff and cost more time."""
    summation: LawName = "auto"
    """The summation of superposed forces: pairs in `cells`, a `grid` for the long-range part, or the faster of both,
    `auto`. Effect: a grid is faster for many small floats."""
    precision: LawName = "double"
    """The floating-point precision of pair forces, `double` or `single`. Effect: `single` is faster and has an error
    of 1e-6."""
