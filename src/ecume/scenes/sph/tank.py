"""The tank and its sides."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from ecume.scenes.faults import Inconsistent, Path
from ecume.scenes.quantities import STRICT, Coordinate, Motion, Place, Proportion
from ecume.scenes.sph.motions import MotionSpec
from ecume.scenes.sph.solids import Slip
from ecume.units import Pressure, Speed

SIDES = ("left", "right", "bottom", "top", "front", "back")
"""Of a tank: low and high x, low and high y, low and high z."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SideSpec:
    """What one side of the tank is."""

    kind: Literal["wall", "open", "periodic", "inflow", "outflow"] = "wall"
    """`wall`, `open` (nothing there: the liquid may leave), `periodic` (the opposite side must be so too), or
    `inflow` and `outflow`: liquid comes and goes
    """
    slip: Slip | None = None
    """of a wall; left out, no-slip where the liquid has a viscosity, free otherwise"""
    velocity: Motion | None = None
    """of a wall along itself: a lid that drives the liquid (m/s)"""
    motion: MotionSpec | None = None
    """of a wall along its axis: a piston; walls must be mirrors"""
    speed: Annotated[Speed, Field(gt=0.0, le=1e5)] | None = None
    """of an inflow: how fast liquid comes in, on the mean (m/s)"""
    profile: Literal["uniform", "parabolic"] = "uniform"
    """of an inflow: `parabolic` is that of a viscous liquid between walls"""
    level: Coordinate | None = None
    """of an in- or outflow: the height (along y) up to which there is liquid; left out, the whole side (m)"""
    pressure: Annotated[Pressure, Field(ge=-1e12, le=1e12)] = 0.0
    """of an outflow: the gauge pressure at its level, or the top of the side (Pa); the weight of the liquid adds"""

    @model_validator(mode="after")
    def _fits_its_kind(self) -> Self:
        complaints: list[tuple[Path, str]] = []
        if (self.kind == "inflow") != (self.speed is not None):
            complaints.append((("speed",), "wanted for an inflow, and for nothing else"))
        if self.kind != "outflow" and self.pressure != 0.0:
            complaints.append((("pressure",), f'is of an outflow; this side is of kind = "{self.kind}"'))
        if self.kind not in ("inflow", "outflow") and self.level is not None:
            complaints.append((("level",), f'is of an in- or outflow; this side is of kind = "{self.kind}"'))
        if complaints:
            raise Inconsistent(complaints)
        return self


def _velocity_fault(side: SideSpec, axis: int, dimension: int) -> str:
    """What is wrong with the velocity of a side that is normal to an axis; empty where nothing is."""
    if side.velocity is None:
        return ""
    if side.kind != "wall":
        return f'is of a wall; this side is of kind = "{side.kind}"'
    if len(side.velocity) != dimension:
        return f"came {len(side.velocity)} numbers; the tank has {dimension} dimensions"
    if axis < dimension and side.velocity[axis] != 0.0:
        return f"came {side.velocity[axis]:g} m/s across the wall; it goes along itself, and motion moves it across"
    return ""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class TankSpec:
    """A rectangular tank."""

    low: Place
    """its lowest corner (m)"""
    high: Place
    """its highest corner (m)"""
    walls: Literal["mirror", "dummy", "reflect"] = "mirror"
    """How walls act: `mirror` images, layers of `dummy` particles (Adami et al. 2012), or `reflect` alone, which is
    what the original text does: the liquid collapses at such walls.
    """
    restitution: Proportion = 0.5
    """of a particle's velocity normal to a wall, when the guard behind the walls has to turn it back"""
    left: SideSpec = SideSpec()
    """at low x"""
    right: SideSpec = SideSpec()
    """at high x"""
    bottom: SideSpec = SideSpec()
    """at low y"""
    top: SideSpec = SideSpec()
    """at high y"""
    front: SideSpec = SideSpec()
    """at low z"""
    back: SideSpec = SideSpec()
    """at high z"""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        complaints: list[tuple[Path, str]] = []
        if len(self.low) != len(self.high) or any(b <= a for a, b in zip(self.low, self.high, strict=False)):
            complaints.append((("high",), "wanted a corner above low in each direction"))
        for name in SIDES:
            side = getattr(self, name)
            if side.motion is not None and (side.kind != "wall" or self.walls == "dummy"):
                complaints.append(((name, "motion"), 'only a wall can move, and tank.walls must be "mirror"'))
            fault = _velocity_fault(side, SIDES.index(name) // 2, len(self.low))
            if fault:
                complaints.append(((name, "velocity"), fault))
        for axis in range(len(self.low)):
            pair = SIDES[2 * axis : 2 * axis + 2]
            periodic = [getattr(self, side).kind == "periodic" for side in pair]
            if any(periodic) and not all(periodic):
                complaints.append(((pair[periodic.index(False)], "kind"), "its opposite is periodic; both must be"))
        if complaints:
            raise Inconsistent(complaints)
        return self
