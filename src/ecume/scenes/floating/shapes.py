"""Floats that are longer than wide, or have corners: they have a direction, and turn."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from ecume.scenes.faults import Complaints, Inconsistent
from ecume.scenes.quantities import STRICT, Direction, Proportion, Size
from ecume.units import Length

Rise = Annotated[Length, Field(ge=-1e-2, le=1e-2)]
PINNED = ("square", "star")
"""Shapes whose contact line is pinned to an edge; the others have a contact angle."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ShapeSpec:
    """What a float looks like from above. Its species' `radius` is that of the circle around it."""

    kind: Literal["ellipsoid", "needle", "square", "star"]
    """An ellipsoid; a needle: a lying cylinder with round ends; a square plate or cube; a flat star."""
    width: Size | None = None
    """Across an ellipsoid, a needle or the arm of a star (m); a square has none."""
    thickness: Size | None = None
    """Upright (m): of an ellipsoid or a star, left out, the width; of a square, left out, its side; a needle is
    round."""
    arms: Annotated[int, Field(strict=True, ge=3, le=12)] = 5
    """Of a star."""
    corner: Annotated[Proportion, Field(ge=0.02)] = 0.1
    """How round the corners of a square are: their radius over half of its side."""
    rim: Literal["top", "bottom"] = "bottom"
    """The edge that pins a square or a star: the lower one of what is light, the upper one of what is heavy."""
    undulation: Rise | None = None
    """How high the contact line rises along the body's own direction (m), negative where it dips; left out, of an
    ellipsoid what its contact angle says, of all others nothing."""
    mode: Annotated[int, Field(strict=True, ge=2, le=12)] | None = None
    """How often it does so around the body; left out, twice (ellipsoid, needle), four times (square), once an arm."""
    angle: Direction | None = None
    """Of the body's own direction at the start (rad, from the x axis): a long axis, a corner, an arm; left out, by
    chance."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        complaints: Complaints = []
        if self.kind == "square" and self.width is not None:
            complaints.append((("width",), "a square has none: its radius, that of the circle around it, says all"))
        if self.kind != "square" and self.width is None:
            complaints.append((("width",), f"left out; wanted how wide the {self.kind} is"))
        if self.kind == "needle" and self.thickness is not None:
            complaints.append((("thickness",), "a needle is round: it has a width only"))
        if self.kind == "star" and self.mode not in (None, self.arms):
            complaints.append((("mode",), f"came {self.mode}; a star rises and falls once an arm: leave it out"))
        if complaints:
            raise Inconsistent(complaints)
        if self.mode is None:
            modes = {"square": 4, "star": self.arms}
            object.__setattr__(self, "mode", modes.get(self.kind, 2))
        return self


def fitting(shape: ShapeSpec, radius: Length) -> Complaints:
    """What is wrong with a shape inside a circle of that radius."""
    if shape.width is not None and shape.width > 2.0 * radius:
        came = f"came {shape.width:g} m, more than the circle around it is wide, {2.0 * radius:g} m"
        return [(("shape", "width"), came)]
    return []
