"""Constants of a run of a tank."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, cast

import numpy as np

from ecume.engine.cells import Integers, Sides
from ecume.engine.shapes import Panels, Shape
from ecume.engine.walls import Sheet
from ecume.models.sph.fields import Constants, EquationOfState, Numbers, Precision
from ecume.models.sph.rates.methods import DensityDiffusion, Friction, PressureForce, PressureMethod
from ecume.units import Array


class Guard(NamedTuple):
    """The surfaces that reflect particles."""

    sheet: Sheet
    owner: Integers
    """(K,) the side or obstacle that each surface belongs to"""
    radius: float
    """m, distance from the surface to which particles are reflected"""
    reach: float
    """m, range of the repulsion; zero if walls only reflect"""
    support: float
    """m, range of the braking"""
    weights: Array
    """1/m, the kernel summed over planes at even distances from zero to the support; empty without braking"""


class Material(NamedTuple):
    """The liquid."""

    density: float
    """kg/m^3, the reference"""
    sound_speed: float
    """m/s; infinite if the liquid is incompressible"""
    exponent: float
    viscosity: float
    surface_tension: float
    fastest: float
    """m/s, the fastest speed expected"""

    @property
    def laws(self) -> tuple[float, float, float]:
        """Density, sound speed and exponent, as laws take them."""
        return self.density, self.sound_speed, self.exponent


class SecondLiquid(NamedTuple):
    """Another liquid in the tank; `Parameters.material` is liquid 1."""

    material: Material
    """its surface tension is that of the interface"""
    kind: Array
    """(regions,) 1.0 or 2.0, the liquid of each region of the scene"""


class Rheology(NamedTuple):
    """The dependence of the viscosity on the rate of strain: see `ecume.laws.yield_stress.apparent_viscosity`."""

    consistency: float
    """Pa s^n"""
    exponent: float
    yield_stress: float
    """Pa"""
    largest_viscosity: float
    """Pa s"""


class Dummies(NamedTuple):
    """The particles that represent walls."""

    position: Array
    """(d, D)"""
    velocity: Array
    """(d, D) of the wall"""
    viscosity: Array
    """(D,) zero on walls with slip"""
    volume: Array
    """(D,)"""
    owner: Integers
    """(D,) the wall, obstacle or body of each: an index of `Boundary.names`"""
    bearer: Integers
    """(d, D) the one that bears each component of its force: the owner, or in a corner of the tank the side normal to
    the component
    """


class Boundary(NamedTuple):
    """The walls, solids and open sides that confine the liquid."""

    sides: Sides
    """planes with images behind them"""
    table: Array
    """the same with velocities, as `fill_fields.fill_images` reads it"""
    image_owner: Integers
    """(sides,) the owner of the images behind each side: an index of `names`; -1 behind periodic sides"""
    dummies: Dummies
    """of walls and obstacles at their positions, of bodies relative to their centers"""
    guard: Guard
    names: tuple[str, ...]
    """sides, obstacles, bodies"""
    centers: Array
    """(names, 3) the reference points of torques"""
    wetting: Array
    """(names,) the cosine of the contact angle of the liquid"""
    color: Array
    """(names,) the color of dummies under surface tension, which follows from that"""


class Drive(NamedTuple):
    """A prescribed motion: amplitude (sin(turning t + phase) + start), plus a table of n values, plus formulas."""

    amplitude: Array
    """(n,)"""
    turning: float
    """1/s, two pi times the frequency"""
    phase: float
    start: float
    times: Array
    """(T,) s"""
    values: Array
    """(n, T)"""
    formulas: tuple[str, ...] = ()
    """n formulas of the time, see `ecume.engine.formulas`, or none"""


class Roll(NamedTuple):
    """The prescribed rotation of the tank: see `boundaries.rolling`."""

    drive: Drive
    """of the angle"""
    pivot: Array
    """(3,) m"""
    axis: Array
    """(3,) of length 1"""


class BodyPath(NamedTuple):
    """The prescribed path of a body: see `boundaries.driven_bodies`."""

    drive: Drive
    """of the displacement along x, y and z, and of the angle"""
    pivot: Array
    """(3,) m"""
    axis: Array
    """(3,) of length 1"""
    pose: Array
    """(7,) without displacement"""


class Bodies(NamedTuple):
    """Rigid bodies. Positions and vectors have three rows in 2D too."""

    shapes: tuple[Shape, ...]
    """relative to their centers, in their initial orientation"""
    rims: tuple[Array, ...]
    """points of their surfaces, (S, 3)"""
    pose: Array
    """(7, B) at the start: center, and the quaternion of the rotation since then"""
    motion: Array
    """(6, B) at the start: velocity, spin"""
    mass: Array
    """(B,)"""
    inertia: Array
    """(3, B) about the axes of the shape"""
    restitution: Array
    friction: Array
    first: int
    """the index of the first dummy of a body: all later ones belong to bodies, too"""
    obstacles: tuple[Shape, ...]
    obstacle_rims: tuple[Array, ...]
    panels: tuple[Panels, ...]
    """of the surfaces of obstacles, then of bodies, in the axes of their shapes: see `touching_solids`"""
    drawn: tuple[int, ...]
    """the obstacles without surfaces in the guard"""
    paths: tuple[tuple[int, BodyPath], ...] = ()
    """the bodies with a prescribed motion, whose mass is infinite"""


class OpenBoundary(NamedTuple):
    """A side through which liquid flows in or out, with a buffer behind it."""

    zone: int
    """the value of `State.zone` for particles of its buffer"""
    axis: int
    inward: float
    """1 at the low end of the axis, -1 at the high end"""
    place: float
    """m along the axis"""
    enters: bool
    speed: float
    """m/s, mean"""
    curved: Array
    """(d,) 1 along an axis with a parabolic profile, 2 for half a parabola below a surface, 0 for a uniform profile"""
    low: Array
    high: Array
    """(d,) the upper corner of the part of the side that is open"""
    layers: int
    """of the buffer, one spacing each"""
    pressure: float
    """Pa, of an outflow at its level"""
    level: float
    """m: the height of the top of the open part, or of an opening in the floor or at the top"""


class Projection(NamedTuple):
    """Constants of the solver for the pressure of an incompressible liquid."""

    tolerance: float
    """the r.m.s. error of the density after a step, over the density"""
    iterations: int
    """at most, in a step"""
    lattice_sum: float
    """the sum of volumes times kernel in a lattice"""
    step: float
    """the length of projected gradient steps: the inverse of the largest eigenvalue, over the diagonal"""
    full: float
    """1/m^2: the sum of -V F over the neighbors in a lattice"""
    uppermost: float
    """Pa: the least pressure of particles in a full tank, which are half a spacing below the lid"""
    steepness: Array
    """1/m, ascending: |sum of V grad W| in rows of a lattice below a flat surface; zero below the first"""
    missing: Array
    """the missing density of those rows, over the density"""
    free_surface: bool
    """whether pressures are positive or zero; otherwise the liquid fills the tank and pressures are known up to a
    constant
    """


class Liquid(NamedTuple):
    """The particles of the liquid at the start; `State` has their later positions."""

    position: Array
    """(d, N)"""
    velocity: Array
    density: Array
    pressure: Array
    """(N,) Pa, the first guess of the solver for incompressible liquids"""
    mass: Array
    region: Integers
    """(N,) the index of the scene's table that each belongs to"""


class Gauge(NamedTuple):
    """One probe."""

    name: str
    place: Array
    """(d,) m"""
    area: Array
    """(n, d) m, the points over which pressures and velocities are averaged"""
    measures: tuple[str, ...]
    ground: float
    """the part of its surroundings, seen from above, that is in the tank at the start: less than 1 near a wall"""
    floor: Array
    """(2, d) m, the corners of the tank at the start"""
    ends: Array
    """(2, d) m, the sides beyond which there is no liquid, at the start; infinite where the tank is open or periodic"""
    periods: Array
    """(d,) m, infinite where the tank is not periodic"""


class PressureReference(NamedTuple):
    """The state from which hydrostatic and absolute pressures are measured."""

    density: float
    """kg/m^3"""
    gravity: Array
    """(d,) m/s^2: the acceleration that pressure balances at rest"""
    level: float
    """m: the height of the liquid at the start, against gravity, without drops above it"""
    atmospheric: float
    """Pa"""


class CarriedGroup(NamedTuple):
    """A group of equal passive particles."""

    radius: float
    """m; zero: a tracer"""
    density: float
    dispersion: float
    """eddy diffusivity over eddy viscosity"""


class PassiveTracers(NamedTuple):
    """Passive particles, one group for each table of the scene."""

    position: Array
    """(d, C) at the start"""
    start: tuple[int, ...]
    """the index of the first particle of each group, and the total number"""
    groups: tuple[CarriedGroup, ...]
    regions: int
    """the number of species of the liquid: those of passive particles follow"""
    weight: float
    """the kernel's factor"""
    seed: int


class Parameters(NamedTuple):
    """The parameters of a tank: see `ecume.models.model`. Python reads this tuple; compiled loops receive single arrays
    of it.
    """

    time_step: float
    steps_per_frame: int
    dimension: int
    spacing: float
    material: Material
    equation_of_state: EquationOfState
    gravity: Array
    """(d,) m/s^2, of the particles"""
    hydrostatic: Array
    """(d,) m/s^2: the gravity that modified pressures omit, zero otherwise"""
    surface: float
    """m along y, the reference level of the hydrostatic part of modified pressures"""
    constants: Constants
    pressure_method: PressureMethod
    projection: Projection | None
    """constants of the pressure solver, None for a weakly compressible liquid"""
    pressure_force: PressureForce
    density_diffusion: DensityDiffusion
    friction: Friction | None
    """the form of the viscous force, None without viscosity"""
    bulk_viscosity: float
    """Pa s, of the acoustic damping; zero without"""
    support: float
    boundary: Boundary
    bodies: Bodies
    drives: tuple[tuple[int, Drive], ...]
    """the sides that move, by number"""
    base_excitation: Drive | None
    gauges: tuple[Gauge, ...]
    pressure_reference: PressureReference
    pull_rate: float
    """1/s, of the pull towards a point; zero without"""
    pull_center: Array
    """(d,) m"""
    open_boundaries: tuple[OpenBoundary, ...]
    bounds: Array
    """(2, d) beyond which liquid is lost"""
    moves: bool
    """whether sides or bodies move"""
    integrator: str
    """a name of `time_stepping.INTEGRATORS`"""
    shifting: str
    """a name of `shifting.SHIFTINGS`"""
    shifting_limit: float
    """m^2: the largest product of the shifting coefficient and the time of a shift that does not overshoot; infinite
    without shifting"""
    background: float
    """Pa, of the transport velocity; zero without"""
    spreading_pressure: float
    """Pa: the part of the pressure whose gradient is not completed, see `rates.corrections`; zero without completion"""
    tension: str
    """a name of `surface_tension.TENSIONS`"""
    color_reach: float
    """m, the range of the color function of the continuum surface force; zero without it"""
    passive_tracers: PassiveTracers
    """particles that the liquid carries without reaction"""
    turbulence: bool
    """whether eddies smaller than particles add to the viscosity"""
    rheology: Rheology | None
    """how the viscosity depends on the rate of strain; None: it does not"""
    courant: float
    walls_clip: bool
    fixed_volume: bool
    """whether walls and periodic sides keep the volume of the liquid"""
    precision: Precision
    """of the input and output of sums over neighbors; the state is always in double precision"""
    origin: Array
    """(d,) m: positions that sums read are relative to this"""
    user_forces: Callable[[Parameters, Any, Any], Array] | None = None
    """laws of the user"""
    second: SecondLiquid | None = None
    """the other liquid, None in a tank with one"""
    roll: Roll | None = None
    """the rotation of the tank, None without one"""

    @property
    def materials(self) -> tuple[Material, ...]:
        """The liquids."""
        return (self.material,) if self.second is None else (self.material, self.second.material)

    def damping_ratio(self, liquid: Material) -> float:
        """The bulk viscosity of a liquid, alpha rho c h, over that of liquid 1."""
        return liquid.density * liquid.sound_speed / (self.material.density * self.material.sound_speed)

    @property
    def contrast(self) -> tuple[float, ...]:
        """(rho_1 - rho_2)/(rho_1 + rho_2), as sums of two liquids read it; empty for one liquid."""
        if self.second is None:
            return ()
        one, other = self.material.density, self.second.material.density
        return (cast(float, self.precision((one - other) / (one + other))),)

    def parts(self, region: Integers) -> list[tuple[Material, Any]]:
        """Each liquid with its particles from these regions of the scene."""
        if self.second is None:
            return [(self.material, slice(None))]
        kind = self.second.kind[region]
        return [(each, np.flatnonzero(kind == number)) for number, each in enumerate(self.materials, 1)]

    def of_each(self, name: str, region: Integers) -> Any:
        """A property of the liquid: one number for all particles, or (N,) for two liquids."""
        if self.second is None:
            return getattr(self.material, name)
        values = np.array([getattr(each, name) for each in self.materials])
        return values[self.second.kind[region].astype(np.int64) - 1]

    @property
    def numbers(self) -> Numbers:
        """Constants of the sums."""
        return self.constants[0]

    @property
    def corrects(self) -> bool:
        """Whether gradients are completed at free surfaces."""
        return self.pressure_force.corrected or (self.friction is not None and self.friction.corrected)

    @property
    def viscosity_varies(self) -> bool:
        """Whether the viscosity depends on the rate of strain."""
        return self.turbulence or self.rheology is not None

    @property
    def transports(self) -> bool:
        """Whether particles have a transport velocity."""
        return self.background > 0.0 or self.shifting != "none"


def up_axis(parameters: Parameters) -> int:
    """The number of the axis that points up: that of the side `top`."""
    return parameters.boundary.names.index("top") // 2
