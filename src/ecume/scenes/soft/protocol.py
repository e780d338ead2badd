"""What is done to the spheres over time: a table of moments."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from ecume.scenes.quantities import STRICT
from ecume.units import Number, Time

Instant = Annotated[Time, Field(ge=0.0, le=1e10)]
Factor = Annotated[Number, Field(ge=-1e9, le=1e9)]
Scale = Annotated[Number, Field(ge=1e-3, le=1e3)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class StageSpec:
    """A moment of the protocol: between two, everything changes evenly; before the first and after the last, not."""

    time: Instant
    """s"""
    load: Factor = 1.0
    """what the spheres' forces are multiplied by"""
    strain: Factor = 0.0
    """shear strain of the box, along x from bottom to top"""
    scale: Scale = 1.0
    """what the sides of the box are multiplied by"""
