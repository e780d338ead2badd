"""Regions of space, and the contents of a tank: obstacles, bodies and passive particles.

Passive particles, which the liquid carries without reaction, are tracers, and grains that settle.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ecume.scenes.common import dataclass
from ecume.scenes.faults import Inconsistent, Path
from ecume.scenes.quantities import (
    STRICT,
    BodyMass,
    Color,
    Count,
    Motion,
    Place,
    PositiveDensity,
    Proportion,
    Size,
    Switch,
    TurningRate,
    WettingAngle,
)
from ecume.scenes.sph.motions import BodyMotionSpec
from ecume.units import Array, Length, Number

Slip = Literal["free", "no-slip"]
TAKEN = re.compile(r"largest|(body|obstacle)[0-9]+|left|right|bottom|top|front|back|center|momentum|first|second|guard")
"""The pattern of names of numbers that frames already have."""
QUANTITY = re.compile(r".*_(force|torque|velocity|spin)")
"""The pattern of names that would be the number of another solid without its axis."""
SolidName = Annotated[str, Field(max_length=40, pattern=r"^([A-Za-z][A-Za-z0-9_]*)?$")]


THINNEST = 1e-9
"""The smallest area of a polygon, relative to the square around it."""


def above_fault(low: Sequence[float] | None, high: Sequence[float] | None) -> str:
    """The fault of a corner that is not above `low` in each direction; empty without a fault."""
    for axis, (a, b) in zip("xyz", zip(low or (), high or (), strict=False), strict=False):
        if not a < b:
            return f"got {b:g} m along {axis}; expected more than {a:g} m, that of low"
    return ""


def area_of(vertices: Sequence[tuple[float, ...]]) -> float:
    """The area of a polygon (m^2), negative where it is clockwise.

    >>> area_of([(0.0, 0.0), (2.0, 0.0), (0.0, 1.0)])
    1.0
    """
    following = (*vertices[1:], vertices[0])
    return 0.5 * sum(a * d - b * c for (a, b), (c, d) in zip(vertices, following, strict=True))


def extent(values: Sequence[float]) -> float:
    """The difference of the largest and the smallest value."""
    return max(values) - min(values)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ShapeSpec:
    """A part of space: exactly one shape."""

    low: Place | None = None
    """The lowest corner of a box (m), together with `high`. Effect: moves the sides of the box."""
    high: Place | None = None
    """The highest corner of a box (m), together with `low`. Effect: moves the sides of the box."""
    vertices: tuple[Place, ...] = ()
    """The corners of a polygon in order (m); in 3D those of a convex body, such as a ramp, in any order. Effect:
    determines the shape."""
    triangles: tuple[tuple[Place, Place, Place], ...] = ()
    """The triangles of a closed surface (m), in 3D only. Example: `[[[0,0,0],[1,0,0],[0,1,0]]]`. Effect: determines
    the shape."""
    center: Place | None = None
    """The center of a disc, sphere or cylinder (m), together with `radius`. Effect: shifts the shape."""
    radius: Size | None = None
    """The radius of a disc, sphere or cylinder (m), together with `center`. Effect: enlarges the shape."""
    axis: Place | None = None
    """The way from one end of a cylinder to the other (m), with `center` and `radius`, in 3D only. Example:
    `["0 m", "20 cm", "0 m"]`. Effect: turns a sphere into a cylinder of this length."""

    def _further(self) -> dict[str, bool]:
        """The other ways to specify a shape, and whether each is used."""
        return {}

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        shapes = [self.low is not None or self.high is not None, bool(self.vertices), self.radius is not None]
        further = {"triangles": bool(self.triangles), **self._further()}
        if sum(shapes) + sum(further.values()) != 1:
            known = ["low and high", "vertices", "center and radius", "outline_from", *further]
            raise Inconsistent([((), f"expected exactly one shape: {', or '.join(known)}")])
        if shapes[0] and (self.low is None or self.high is None or len(self.low) != len(self.high)):
            raise Inconsistent([((), "a box needs low and high, of the same dimension")])
        flat = above_fault(self.low, self.high)
        if flat:
            raise Inconsistent([(("high",), flat)])
        if shapes[2] and self.center is None:
            raise Inconsistent([((), "a disc needs its center as well")])
        if self.axis is not None and not (self.radius is not None and any(self.axis)):
            raise Inconsistent([(("axis",), "is of a cylinder; expected a vector, with center and radius")])
        if fault := _corner_fault(self.vertices):
            raise Inconsistent([(("vertices",), fault)])
        return self


def _corner_fault(vertices: Sequence[tuple[float, ...]]) -> str:
    """The fault of the corners of a shape; empty without one."""
    if not vertices:
        return ""
    dimension = len(vertices[0])
    if any(len(corner) != dimension for corner in vertices):
        return "have different dimensions"
    if len(vertices) <= dimension:
        least = f"a {'polygon' if dimension == 2 else 'body'} has at least {dimension + 1}"
        return f"got {len(vertices)}; {least}"
    if dimension == 2 and abs(area_of(vertices)) <= THINNEST * max(map(extent, zip(*vertices, strict=True))) ** 2:
        return "enclose no area; expected the corners of a polygon, in order"
    if dimension == 2 and (found := crossing_edges(vertices)):
        (x, y), (k, m) = vertices[found[0]], found
        return f"cross: edges {k} (from {x:.6g}, {y:.6g} m) and {m} meet; expected the corners of a polygon, in order"
    return ""


def crossing_edges(vertices: Sequence[tuple[float, ...]]) -> tuple[int, int] | None:
    """The numbers of two edges of a polygon that cross one another, in their insides; None if it is simple. Edges are
    sorted by x, and each is compared with those that begin before it ends.
    """
    first = np.array(vertices, dtype=float)
    last = np.roll(first, -1, axis=0)
    low, high = np.minimum(first, last), np.maximum(first, last)
    order = np.argsort(low[:, 0], kind="stable")
    until = np.searchsorted(low[order, 0], high[order, 0], side="left")
    for place, end in enumerate(until):
        mine, others = order[place], order[place + 1 : end]
        others = others[(low[others, 1] < high[mine, 1]) & (high[others, 1] > low[mine, 1])]
        a, b, c, d = first[mine], last[mine], first[others], last[others]
        apart = (_side(a, b, c) * _side(a, b, d) < 0.0) & (_side(c, d, a) * _side(c, d, b) < 0.0)
        if apart.any():
            one, other = sorted((int(mine), int(others[np.argmax(apart)])))
            return one, other
    return None


def _side(start: Array, end: Array, point: Array) -> Array:
    """Twice the area of the triangles start, end, point, positive counterclockwise; zero within rounding."""
    way, away = end - start, point - start
    area = way[..., 0] * away[..., 1] - way[..., 1] * away[..., 0]
    rounding = 1e-12 * (np.abs(way[..., 0] * away[..., 1]) + np.abs(way[..., 1] * away[..., 0]))
    return np.where(np.abs(area) <= rounding, 0.0, area)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ObstacleSpec(ShapeSpec):
    """A solid obstacle in the tank. In a file it may also be `outline_from = "FILE"` (STL in 3D, DXF in 2D)."""

    name: SolidName = ""
    """The name of the obstacle in numbers of frames, figures and messages; by default `obstacle0`, `obstacle1` and
    so on. Example: `"post"`. Effect: none on the motion."""
    hollow: Switch = False
    """Whether the shape is a hole in a block that fills the tank, as of a basin, and not the solid itself. Example:
    `true`. Effect: liquid is inside of the shape, not around it."""
    slip: Slip | None = None
    """The slip at the surface: `free` or `no-slip`; by default `no-slip` where `liquid.viscosity` is
    given. Effect:
    `no-slip` slows down the liquid along the surface."""
    restitution: Proportion | None = None
    """The ratio of normal velocities after and before a reflection at the surface; by default that of the tank.
    Effect: none unless particles penetrate."""
    tangential_restitution: Proportion | None = None
    """The ratio of tangential velocities after and before a reflection at the surface; by default that of the tank.
    Effect: none unless particles penetrate."""
    contact_angle: WettingAngle | None = None
    """The contact angle of the liquid at this surface (rad, or text such as `60 deg`); by default that of the liquid.
    Example: `"60 deg"`. Effect: small angles spread the liquid there, large ones repel it."""
    color: Color | None = None
    """The color in pictures: `#rrggbb`, or an English name. Example: `"orange"`. Effect: none on the motion."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class BodySpec(ShapeSpec):
    """A rigid body that floats, sinks and collides, or that follows a prescribed `motion`; in 2D it is one meter deep.
    In a file it may also be `outline_from = "FILE"` (STL in 3D, DXF in 2D).
    """

    name: SolidName = ""
    """The name of the body in numbers of frames, figures and messages; by default `body0`, `body1` and so on.
    Example: `"post"`. Effect: none on the motion."""
    density: PositiveDensity | None = None
    """The density of the body (kg/m^3), instead of its mass. Effect: bodies denser than the liquid sink."""
    mass: BodyMass | None = None
    """The mass of the body (kg; kg/m in 2D), instead of its density. Effect: heavier bodies sink deeper."""
    velocity: Motion | None = None
    """The initial velocity of the body (m/s). Effect: sets the start of the body."""
    spin: TurningRate | tuple[TurningRate, TurningRate, TurningRate] = 0.0
    """The initial angular velocity (rad/s): one number about z, or three in 3D. Example: `5`. Effect: sets the start
    of the body."""
    motion: BodyMotionSpec | None = None
    """A prescribed path, instead of `density` and `mass`: of a gate, a piston, a flap, a stirrer, a rolling tank.
    Effect: the body moves along it, whatever the forces on it."""
    slip: Slip | None = None
    """The slip at the surface: `free` or `no-slip`; by default `no-slip` where `liquid.viscosity` is
    given. Effect:
    `no-slip` increases the drag."""
    restitution: Proportion = 0.3
    """The ratio of normal velocities after and before a collision; two bodies take the smaller one. Effect: 1
    conserves the kinetic energy."""
    friction: Annotated[Number, Field(ge=0.0, le=10.0)] = 0.3
    """The Coulomb friction coefficient of collisions; two bodies take the smaller one. Effect: larger values hold
    bodies on slopes."""
    contact_angle: WettingAngle | None = None
    """The contact angle of the liquid at this surface (rad, or text such as `60 deg`); by default that of the liquid.
    Example: `"60 deg"`. Effect: small angles spread the liquid there, large ones repel it; the
    body feels no force by it."""
    color: Color | None = None
    """The color in pictures: `#rrggbb`, or an English name. Example: `"orange"`. Effect: none on the motion."""

    @model_validator(mode="after")
    def _weighed(self) -> Self:
        given = [self.density is not None, self.mass is not None, self.motion is not None]
        if sum(given) != 1:
            raise Inconsistent([((), "expected density, mass, or a prescribed motion, one of them")])
        if self.motion is not None and (self.velocity is not None or self.spin != 0.0):
            raise Inconsistent([(("motion",), "prescribes the velocity, too; remove velocity and spin of the body")])
        return self


Solids = Sequence[ObstacleSpec | BodySpec]


def solid_names(solids: Solids, kind: str) -> tuple[str, ...]:
    """The names of obstacles or bodies in numbers of frames: the given ones, otherwise `obstacle0`, `obstacle1` ..."""
    return tuple(solid.name or f"{kind}{index}" for index, solid in enumerate(solids))


def name_faults(solids: Sequence[tuple[str, Solids]], gauges: Sequence[str]) -> list[tuple[Path, str]]:
    """The faults of names of solids that frames, gauges or other solids already use; `solids` are tables with their
    names.
    """
    found: list[tuple[Path, str]] = []
    used = dict.fromkeys(gauges, "a gauge")
    for table, specs in solids:
        for index, spec in enumerate(specs):
            if TAKEN.fullmatch(spec.name) or QUANTITY.fullmatch(spec.name):
                fault = f"got {spec.name!r}; frames have numbers of this name; choose another"
                found.append(((table, index, "name"), fault))
            elif spec.name in used:
                found.append(((table, index, "name"), f"got {spec.name!r}, the name of {used[spec.name]} as well"))
            if spec.name:
                used.setdefault(spec.name, f"{table}[{index}]")
    return found


Radius = Annotated[Length, Field(ge=0.0, le=1e3)]
Schmidt = Annotated[Number, Field(gt=0.0, le=1e3)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class PassiveTracerSpec:
    """Particles that move with the liquid, at given positions or a number of random ones in a box."""

    positions: tuple[Place, ...] = ()
    """The initial position of each tracer (m), instead of `count`. Effect: replaces the random positions."""
    count: Count | None = None
    """The number of tracers at random positions between `low` and `high`. Example: `200`. Effect: more tracers
    resolve the flow better."""
    low: Place | None = None
    """The lowest corner of the box of random positions (m). Effect: moves the side of the box."""
    high: Place | None = None
    """The highest corner of the box of random positions (m). Effect: moves the side of the box."""
    radius: Radius = 0.0
    """The radius of each tracer (m); without a radius it follows the liquid exactly. Effect: larger tracers settle
    faster."""
    density: PositiveDensity | None = None
    """The density of tracers with a radius (kg/m^3). Effect: tracers denser than the liquid settle, others rise."""
    turbulent_dispersion: Switch = False
    """Whether the eddies of `method.turbulence` disperse the tracers by a random walk. Effect: spreads the tracers."""
    schmidt_number: Schmidt = 0.7
    """The eddy viscosity, divided by the diffusivity of the tracers. Effect: smaller values disperse more strongly."""
    color: Color | None = None
    """The color in pictures: `#rrggbb`, or an English name. Example: `"orange"`. Effect: none on the motion."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        complaints: list[tuple[Path, str]] = []
        box = self.low is not None and self.high is not None and self.count is not None
        if box == bool(self.positions):
            complaints.append(((), "expected either positions, or count with low and high"))
        if any(b < a for a, b in zip(self.low or (), self.high or (), strict=False)):
            complaints.append((("high",), "expected a corner above low in each direction"))
        if len(self.low or ()) != len(self.high or ()):
            complaints.append((("high",), "expected as many numbers as low has"))
        if (self.radius > 0.0) != (self.density is not None):
            complaints.append((("density",), "expected with a radius, and only then"))
        if complaints:
            raise Inconsistent(complaints)
        return self


def passive_tracer_faults(tracers: tuple[PassiveTracerSpec, ...], tank: Any, turbulence: str) -> list[tuple[Path, str]]:
    """The faults of positions outside the tank, and of eddies in a scene without turbulence."""
    found: list[tuple[Path, str]] = []
    for index, spec in enumerate(tracers):
        for place in (*spec.positions, *(corner for corner in (spec.low, spec.high) if corner is not None)):
            inside = len(place) == len(tank.low) and all(
                a <= x <= b for a, x, b in zip(tank.low, place, tank.high, strict=True)
            )
            if not inside:
                found.append((("passive_tracers", index), f"{tuple(place)} is not in the tank"))
        if spec.turbulent_dispersion and turbulence == "none":
            found.append(
                (("passive_tracers", index, "turbulent_dispersion"), "there are no eddies; set method.turbulence")
            )
    return found
