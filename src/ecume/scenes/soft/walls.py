"""Plane walls on which spheres settle, and between which they are squeezed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import Field

from ecume.scenes.faults import Complaints
from ecume.scenes.quantities import STRICT, Coordinate, Motion
from ecume.scenes.soft.protocol import STRESS_UNITS, Stress, StressInSpace, StressOfLayer
from ecume.scenes.validated import dataclass
from ecume.units import Pressure

Modulus = Annotated[Pressure, Field(ge=1e-9, le=1e15)]
Side = Literal["left", "right", "bottom", "top", "front", "back"]
SIDES: dict[str, tuple[int, float]] = {
    "left": (0, -1.0), "right": (0, 1.0), "bottom": (1, -1.0), "top": (1, 1.0), "front": (2, -1.0), "back": (2, 1.0),
}  # fmt: skip
"""By name: the axis that a wall stands across, and on which side of the spheres it is."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class WallSpec:
    """A plane across an axis: it is fixed, moves with a given velocity, or follows a force. A box is not periodic along
    the normals of walls.
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


def wall_faults(walls: Sequence[WallSpec], dimensions: int, sides: Sequence[float] | None) -> Complaints:
    """The faults of walls that cannot stand or move."""
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
    wrong = StressInSpace if dimensions == 2 else StressOfLayer
    for name in ("pressure", "shear_stress"):
        value = getattr(wall, name)
        if value is not None and sides is None:
            found.append(((name,), "acts on the wall's area, that of the [cell]; add that table"))
        if isinstance(value, wrong):
            found.append(((name,), f"stresses here are in {STRESS_UNITS[dimensions]}"))
    return found
