"""Parts of space, and what is solid in the liquid: obstacles, and bodies that move."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from ecume.scenes.common import dataclass
from ecume.scenes.faults import Inconsistent
from ecume.scenes.quantities import STRICT, Color, Coordinate, Motion, Place, PositiveDensity, Proportion, Size
from ecume.units import Number, Rate

Slip = Literal["free", "no-slip"]
Turning = Annotated[Rate, Field(ge=-1e6, le=1e6)]


THINNEST = 1e-9
"""The smallest area of a polygon, relative to the square around it."""


def above_fault(low: Sequence[float] | None, high: Sequence[float] | None) -> str:
    """The fault of a corner that is not above `low` in each direction, or an empty text."""
    for axis, (a, b) in zip("xyz", zip(low or (), high or (), strict=False), strict=False):
        if not a < b:
            return f"got {b:g} m along {axis}; expected more than {a:g} m, that of low"
    return ""


def area_of(vertices: Sequence[tuple[float, float]]) -> float:
    """The area of a polygon (m^2), negative where it is clockwise.

    >>> area_of([(0.0, 0.0), (2.0, 0.0), (0.0, 1.0)])
    1.0
    """
    following = (*vertices[1:], vertices[0])
    return 0.5 * sum(a * d - b * c for (a, b), (c, d) in zip(vertices, following, strict=True))


def extent(values: Sequence[float]) -> float:
    """From the smallest to the largest."""
    return max(values) - min(values)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ShapeSpec:
    """A part of space: exactly one shape."""

    low: Place | None = None
    """The lowest corner of a box (m), together with `high`. Effect: moves the sides of the box."""
    high: Place | None = None
    """The highest corner of a box (m), together with `low`. Effect: moves the sides of the box."""
    vertices: tuple[tuple[Coordinate, Coordinate], ...] = ()
    """The corners of a polygon (m), in 2D only. Effect: determines the shape."""
    center: Place | None = None
    """The center of a disc or sphere (m), together with `radius`. Effect: shifts the shape."""
    radius: Size | None = None
    """The radius of a disc or sphere (m), together with `center`. Effect: enlarges the shape."""

    def _further(self) -> dict[str, bool]:
        """Other ways to give a shape, and whether they were taken."""
        return {}

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        shapes = [self.low is not None or self.high is not None, bool(self.vertices), self.radius is not None]
        further = self._further()
        if sum(shapes) + sum(further.values()) != 1:
            known = ["low and high", "vertices", "center and radius", *further]
            raise Inconsistent([((), f"expected exactly one shape: {', or '.join(known)}")])
        if shapes[0] and (self.low is None or self.high is None or len(self.low) != len(self.high)):
            raise Inconsistent([((), "a box needs low and high, of the same dimension")])
        flat = above_fault(self.low, self.high)
        if flat:
            raise Inconsistent([(("high",), flat)])
        if shapes[2] and self.center is None:
            raise Inconsistent([((), "a disc needs its center as well")])
        if shapes[1] and len(self.vertices) < 3:
            raise Inconsistent([(("vertices",), f"got {len(self.vertices)}; a polygon has at least 3")])
        if (
            self.vertices
            and abs(area_of(self.vertices)) <= THINNEST * max(map(extent, zip(*self.vertices, strict=True))) ** 2
        ):
            raise Inconsistent([(("vertices",), "enclose no area; expected the corners of a polygon, in order")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ObstacleSpec(ShapeSpec):
    """Something solid that stands in the tank. A polygon must be convex: put others together of several."""

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
    color: Color | None = None
    """The color in pictures: `#rrggbb`, or an English name. Example: `"orange"`. Effect: none on the motion."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class BodySpec(ShapeSpec):
    """A rigid body that floats, sinks and collides. A polygon must be convex. In a plane it is one meter deep."""

    density: PositiveDensity | None = None
    """The density of the body (kg/m^3), instead of its mass. Effect: bodies denser than the liquid sink."""
    mass: Annotated[Number, Field(gt=0.0, le=1e15)] | None = None
    """The mass of the body (kg; kg/m in 2D), instead of its density. Effect: heavier bodies sink deeper."""
    velocity: Motion | None = None
    """The initial velocity of the body (m/s). Effect: sets the start of the body."""
    spin: Turning | tuple[Turning, Turning, Turning] = 0.0
    """The initial angular velocity (rad/s): one number about z, or three in 3D. Example: `5`. Effect: sets the start
    of the body."""
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
    color: Color | None = None
    """The color in pictures: `#rrggbb`, or an English name. Example: `"orange"`. Effect: none on the motion."""

    @model_validator(mode="after")
    def _weighed(self) -> Self:
        if (self.density is None) == (self.mass is None):
            raise Inconsistent([((), "expected density or mass, one of them")])
        return self
