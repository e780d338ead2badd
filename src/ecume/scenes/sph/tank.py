"""The tank: its sides and how they move, and the gauges whose readings are numbers of every frame."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from ecume.scenes.faults import Complaints, Inconsistent, Path
from ecume.scenes.quantities import STRICT, Coordinate, Motion, Place, Proportion, Pull
from ecume.scenes.sph.solids import Slip
from ecume.units import Angle, Pressure, Rate, Speed, Time

Frequency = Annotated[Rate, Field(gt=0.0, le=1e6)]
Phase = Annotated[Angle, Field(ge=-1e3, le=1e3)]
Moment = Annotated[Time, Field(ge=0.0, le=1e10)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class MotionSpec:
    """The motion of a side along its axis: a sine, or a table of times and positions with straight lines between."""

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
class BaseExcitationSpec:
    """The acceleration in the frame of a shaken tank, beside gravity: minus the tank's own."""

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
        raise Inconsistent([((), f"expected either amplitude and frequency, or times and {values}")])
    if sine and spec.frequency is None:
        raise Inconsistent([(("frequency",), "is missing; a sine needs it")])
    if table and len(spec.times) != len(getattr(spec, values)):
        message = f"got {len(getattr(spec, values))} for {len(spec.times)} times; expected as many"
        raise Inconsistent([((values,), message)])
    if any(later <= earlier for earlier, later in zip(spec.times, spec.times[1:], strict=False)):
        raise Inconsistent([(("times",), "expected times that ascend")])


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
    position: Place
    """where it is, or a row begins (m)"""
    end: Place | None = None
    """where a row ends (m)"""
    count: Annotated[int, Field(strict=True, ge=2, le=1000)] | None = None
    """of a row, how many there are, both ends included"""
    quantities: Annotated[tuple[Measure, ...], Field(min_length=1)] = ("pressure",)
    """any of `pressure`, `velocity` and `level`, the depth of the liquid above the floor under the gauge"""

    @model_validator(mode="after")
    def _row(self) -> Self:
        complaints: Complaints = []
        if (self.end is None) != (self.count is None):
            complaints.append((("end",), "a row of gauges needs both, end and count"))
        if self.end is not None and len(self.end) != len(self.position):
            complaints.append((("end",), f"got {len(self.end)} numbers, and {len(self.position)} for position"))
        if TAKEN.fullmatch(self.name):
            complaints.append((("name",), f"got {self.name!r}; frames have numbers of that name, take another"))
        if complaints:
            raise Inconsistent(complaints)
        return self


def gauge_faults(gauges: Sequence[GaugeSpec], tank: TankSpec) -> Complaints:
    """Gauges that do not fit into the tank, or have one name together."""
    found: Complaints = []
    names = [gauge.name for gauge in gauges]
    for index, gauge in enumerate(gauges):
        if names.index(gauge.name) < index:
            found.append((("gauges", index, "name"), f"got {gauge.name!r}, as in gauges[{names.index(gauge.name)}]"))
        for key in ("position", "end"):
            found += [(("gauges", index, key), text) for text in _place_faults(getattr(gauge, key), tank)]
    return found


def _place_faults(place: Sequence[float] | None, tank: TankSpec) -> list[str]:
    if place is None:
        return []
    if len(place) != len(tank.low):
        return [f"got {len(place)} numbers; the tank has {len(tank.low)} dimensions"]
    inside = all(low <= x <= high for low, x, high in zip(tank.low, place, tank.high, strict=True))
    return [] if inside else ["is outside the tank"]


SIDES = ("left", "right", "bottom", "top", "front", "back")
"""Of a tank: low and high x, low and high y, low and high z."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SideSpec:
    """One side of the tank."""

    kind: Literal["wall", "open", "periodic", "inflow", "outflow"] = "wall"
    """`wall`, `open` (nothing there: the liquid may leave), `periodic` (the opposite side must be so too), or
    `inflow` and `outflow`: liquid comes and goes
    """
    slip: Slip | None = None
    """of a wall; by default no-slip where the liquid has a viscosity, free otherwise"""
    velocity: Motion | None = None
    """of a wall along itself: a lid that drives the liquid (m/s)"""
    motion: MotionSpec | None = None
    """of a wall along its axis: a piston; walls must be mirrors"""
    speed: Annotated[Speed, Field(gt=0.0, le=1e5)] | None = None
    """of an inflow: how fast liquid comes in, on the mean (m/s)"""
    profile: Literal["uniform", "parabolic"] = "uniform"
    """of an inflow: `parabolic` is that of a viscous liquid between walls"""
    level: Coordinate | None = None
    """of an in- or outflow: the height (along y) up to which there is liquid; by default the whole side (m)"""
    pressure: Annotated[Pressure, Field(ge=-1e12, le=1e12)] = 0.0
    """of an outflow: the gauge pressure at its level, or the top of the side (Pa); the weight of the liquid adds"""

    @model_validator(mode="after")
    def _fits_its_kind(self) -> Self:
        complaints: list[tuple[Path, str]] = []
        if (self.kind == "inflow") != (self.speed is not None):
            complaints.append((("speed",), "expected for an inflow, and for nothing else"))
        if self.kind != "outflow" and self.pressure != 0.0:
            complaints.append((("pressure",), f'is of an outflow; this side is of kind = "{self.kind}"'))
        if self.kind not in ("inflow", "outflow") and self.level is not None:
            complaints.append((("level",), f'is of an in- or outflow; this side is of kind = "{self.kind}"'))
        if complaints:
            raise Inconsistent(complaints)
        return self


def _velocity_fault(side: SideSpec, axis: int, dimension: int) -> str:
    """The fault of the velocity of a side that is normal to an axis; empty where there is none."""
    if side.velocity is None:
        return ""
    if side.kind != "wall":
        return f'is of a wall; this side is of kind = "{side.kind}"'
    if len(side.velocity) != dimension:
        return f"got {len(side.velocity)} numbers; the tank has {dimension} dimensions"
    if axis < dimension and side.velocity[axis] != 0.0:
        return f"got {side.velocity[axis]:g} m/s across the wall; it goes along itself, and motion moves it across"
    return ""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class TankSpec:
    """A rectangular tank."""

    low: Place = ()
    """its lowest corner (m); the origin by default"""
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
        if not self.low:
            object.__setattr__(self, "low", (0.0,) * len(self.high))
        complaints: list[tuple[Path, str]] = []
        if len(self.low) != len(self.high) or any(b <= a for a, b in zip(self.low, self.high, strict=False)):
            complaints.append((("high",), "expected a corner above low in each direction"))
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
