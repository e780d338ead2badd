"""Gauges: places of the tank whose readings are numbers of every frame."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from ecume.scenes.faults import Complaints, Inconsistent
from ecume.scenes.quantities import STRICT, Place
from ecume.scenes.sph.tank import TankSpec

TAKEN = re.compile(r"largest|(body|obstacle)[0-9]+|left|right|bottom|top|front|back")
"""What frames already have numbers of."""
GaugeName = Annotated[str, Field(max_length=40, pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]
Measure = Literal["pressure", "velocity", "level"]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class GaugeSpec:
    """A probe at a place, or a row of them along a line. It reads zero while it is dry."""

    name: GaugeName
    """Its readings are the numbers `name_pressure`, `name_velocity_x` ..., `name_level`; in a row
    `name_1_pressure` and so on.
    """
    place: Place
    """where it is, or a row begins (m)"""
    end: Place | None = None
    """where a row ends (m)"""
    count: Annotated[int, Field(strict=True, ge=2, le=1000)] | None = None
    """of a row, how many there are, both ends included"""
    measures: Annotated[tuple[Measure, ...], Field(min_length=1)] = ("pressure",)
    """any of `pressure`, `velocity` and `level`, the depth of the liquid above the floor under the gauge"""

    @model_validator(mode="after")
    def _row(self) -> Self:
        complaints: Complaints = []
        if (self.end is None) != (self.count is None):
            complaints.append((("end",), "a row of gauges needs both, end and count"))
        if self.end is not None and len(self.end) != len(self.place):
            complaints.append((("end",), f"came {len(self.end)} numbers, and {len(self.place)} for place"))
        if TAKEN.fullmatch(self.name):
            complaints.append((("name",), f"came {self.name!r}; frames have numbers of that name, take another"))
        if complaints:
            raise Inconsistent(complaints)
        return self


def gauge_faults(gauges: Sequence[GaugeSpec], tank: TankSpec) -> Complaints:
    """Gauges that do not fit into the tank, or have one name together."""
    found: Complaints = []
    names = [gauge.name for gauge in gauges]
    for index, gauge in enumerate(gauges):
        if names.index(gauge.name) < index:
            found.append((("gauges", index, "name"), f"came {gauge.name!r}, as in gauges[{names.index(gauge.name)}]"))
        for key in ("place", "end"):
            found += [(("gauges", index, key), text) for text in _place_faults(getattr(gauge, key), tank)]
    return found


def _place_faults(place: Sequence[float] | None, tank: TankSpec) -> list[str]:
    if place is None:
        return []
    if len(place) != len(tank.low):
        return [f"came {len(place)} numbers; the tank has {len(tank.low)} dimensions"]
    inside = all(low <= x <= high for low, x, high in zip(tank.low, place, tank.high, strict=True))
    return [] if inside else ["is outside the tank"]
