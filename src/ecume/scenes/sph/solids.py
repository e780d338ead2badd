"""Parts of space, and what is solid in the liquid: obstacles, and bodies that move."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from ecume.scenes.faults import Inconsistent
from ecume.scenes.quantities import STRICT, Color, Coordinate, Motion, Place, PositiveDensity, Proportion, Size
from ecume.units import Number, Rate

Slip = Literal["free", "no-slip"]
Turning = Annotated[Rate, Field(ge=-1e6, le=1e6)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ShapeSpec:
    """A part of space: exactly one shape."""

    low: Place | None = None
    """of a box, together with `high` (m)"""
    high: Place | None = None
    """of a box (m)"""
    vertices: tuple[tuple[Coordinate, Coordinate], ...] = ()
    """of a polygon, two dimensions only (m)"""
    center: Place | None = None
    """of a disc or sphere, together with `radius` (m)"""
    radius: Size | None = None
    """of a disc or sphere (m)"""

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
        if shapes[2] and self.center is None:
            raise Inconsistent([((), "a disc needs its center as well")])
        if shapes[1] and len(self.vertices) < 3:
            raise Inconsistent([(("vertices",), f"got {len(self.vertices)}; a polygon has at least 3")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ObstacleSpec(ShapeSpec):
    """Something solid that stands in the tank. A polygon must be convex: put others together of several."""

    slip: Slip | None = None
    """by default no-slip where `liquid.viscosity` is given, free otherwise"""
    restitution: Proportion | None = None
    """of what the guard turns back at it; by default that of the tank"""
    color: Color | None = None
    """`#rrggbb`, or a plain English name"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class BodySpec(ShapeSpec):
    """A rigid body that floats, sinks and collides. A polygon must be convex. In a plane it is one meter deep."""

    density: PositiveDensity | None = None
    """kg/m^3; or else give `mass`"""
    mass: Annotated[Number, Field(gt=0.0, le=1e15)] | None = None
    """kg (kg/m in two dimensions)"""
    velocity: Motion | None = None
    """m/s at the start"""
    spin: Turning | tuple[Turning, Turning, Turning] = 0.0
    """1/s at the start: one number about z, or three in three dimensions"""
    slip: Slip | None = None
    """by default no-slip where `liquid.viscosity` is given, free otherwise"""
    restitution: Proportion = 0.3
    """of collisions; two bodies take the smaller one"""
    friction: Annotated[Number, Field(ge=0.0, le=10.0)] = 0.3
    """Coulomb's, of collisions; two bodies take the smaller one"""
    color: Color | None = None
    """`#rrggbb`, or a plain English name"""

    @model_validator(mode="after")
    def _weighed(self) -> Self:
        if (self.density is None) == (self.mass is None):
            raise Inconsistent([((), "expected density or mass, one of them")])
        return self
