"""The tank and its sides."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import model_validator
from pydantic.dataclasses import dataclass

from ecume.scenes.faults import Inconsistent, Path
from ecume.scenes.quantities import STRICT, Motion, Place, Proportion
from ecume.scenes.sph.motions import MotionSpec
from ecume.scenes.sph.solids import Slip

SIDES = ("left", "right", "bottom", "top", "front", "back")
"""Of a tank: low and high x, low and high y, low and high z."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SideSpec:
    """What one side of the tank is."""

    kind: Literal["wall", "open", "periodic"] = "wall"
    """`wall`, `open` (nothing there: the liquid may leave) or `periodic` (the opposite side must be so too)"""
    slip: Slip | None = None
    """of a wall; left out, no-slip where the liquid has a viscosity, free otherwise"""
    velocity: Motion | None = None
    """of a wall along itself: a lid that drives the liquid (m/s)"""
    motion: MotionSpec | None = None
    """of a wall along its axis: a piston; walls must be mirrors"""


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
        for axis in range(len(self.low)):
            pair = SIDES[2 * axis : 2 * axis + 2]
            periodic = [getattr(self, side).kind == "periodic" for side in pair]
            if any(periodic) and not all(periodic):
                complaints.append(((pair[periodic.index(False)], "kind"), "its opposite is periodic; both must be"))
        if complaints:
            raise Inconsistent(complaints)
        return self
