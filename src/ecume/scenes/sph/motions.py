"""What moves as it is told: sides of the tank, and the tank itself."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from ecume.scenes.faults import Inconsistent
from ecume.scenes.quantities import STRICT, Coordinate, Pull
from ecume.units import Angle, Rate, Time

Frequency = Annotated[Rate, Field(gt=0.0, le=1e6)]
Phase = Annotated[Angle, Field(ge=-1e3, le=1e3)]
Moment = Annotated[Time, Field(ge=0.0, le=1e10)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class MotionSpec:
    """How a side moves along its axis: a sine, or a table of times and positions with straight lines between."""

    amplitude: Coordinate | None = None
    """of a sine that starts at 0 (m)"""
    frequency: Frequency | None = None
    """of a sine, in cycles a second (1/s)"""
    phase: Phase = 0.0
    """of a sine; 90 deg starts at rest"""
    times: tuple[Moment, ...] = ()
    """of a table, ascending (s); before and after it the side stands still"""
    positions: tuple[Coordinate, ...] = ()
    """of a table: how far the side is from where the tank has it (m)"""

    @model_validator(mode="after")
    def _one_law(self) -> Self:
        _require_one(self, "positions")
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ShakeSpec:
    """What pulls at everything beside gravity, in the frame of a tank that is shaken: minus the tank's acceleration."""

    amplitude: Pull | None = None
    """of a sine (m/s^2)"""
    frequency: Frequency | None = None
    """of a sine, in cycles a second (1/s)"""
    phase: Phase = 0.0
    """of a sine: 90 deg starts at its height"""
    times: tuple[Moment, ...] = ()
    """of a table, ascending (s); before and after it the first and the last row hold"""
    accelerations: tuple[Pull, ...] = ()
    """of a table (m/s^2)"""

    @model_validator(mode="after")
    def _one_law(self) -> Self:
        _require_one(self, "accelerations")
        return self


def _require_one(spec: Any, values: str) -> None:
    """Raises unless there is a whole sine or a whole table."""
    sine, table = spec.amplitude is not None, bool(spec.times or getattr(spec, values))
    if sine == table:
        raise Inconsistent([((), f"wanted either amplitude and frequency, or times and {values}")])
    if sine and spec.frequency is None:
        raise Inconsistent([(("frequency",), "is missing; a sine needs it")])
    if table and len(spec.times) != len(getattr(spec, values)):
        message = f"came {len(getattr(spec, values))} for {len(spec.times)} times; wanted as many"
        raise Inconsistent([((values,), message)])
    if any(later <= earlier for earlier, later in zip(spec.times, spec.times[1:], strict=False)):
        raise Inconsistent([(("times",), "wanted times that ascend")])
