"""The tank: its sides with their motions, and gauges, whose readings are numbers of every frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from ecume.scenes.common import dataclass
from ecume.scenes.faults import Complaints, Inconsistent, Path
from ecume.scenes.quantities import SIDES, STRICT, Coordinate, Motion, Place, Proportion, Size, WettingAngle
from ecume.scenes.sph.motions import MotionSpec
from ecume.scenes.sph.solids import TAKEN, Slip
from ecume.units import Pressure, Speed

GaugeName = Annotated[str, Field(max_length=40, pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]
Measure = Literal["pressure", "hydrostatic_pressure", "dynamic_pressure", "absolute_pressure", "velocity", "level"]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class GaugeSpec:
    """A probe at a position, or a row of probes along a line. The reading is zero while the probe is dry."""

    name: GaugeName
    """The name of the gauge. Its numbers are `name_pressure`, `name_velocity_x` and so on, `name_level`; in a row
    `name_1_pressure` and so on. Effect: none on the readings."""
    position: Place
    """The position of the gauge, or of the first one of a row (m). Effect: moves the gauge."""
    end: Place | None = None
    """The position of the last gauge of a row (m). Effect: extends the row."""
    count: Annotated[int, Field(strict=True, ge=2, le=1000)] | None = None
    """The number of gauges in a row, both ends included. Example: `8`. Effect: more gauges resolve a profile better."""
    diameter: Size | None = None
    """The diameter of the sensing area (m), a disc along the nearest side of the tank, in 2D a line: pressures and
    velocities are averages over the part of it within the tank. By default those at the position. Example: `4.2e-3`.
    Effect: a wider sensor has lower and longer peaks."""
    quantities: Annotated[tuple[Measure, ...], Field(min_length=1)] = ("pressure",)
    """The recorded quantities: any of `pressure` (gauge pressure), `hydrostatic_pressure` (of liquid at rest up to the
    initial level), `dynamic_pressure` (the difference of both), `absolute_pressure`, `velocity`, and `level`, the depth
    of the liquid above the floor. Effect: each adds numbers to the frames."""

    @model_validator(mode="after")
    def _row(self) -> Self:
        complaints: Complaints = []
        if (self.end is None) != (self.count is None):
            complaints.append((("end",), "a row of gauges needs both, end and count"))
        if self.end is not None and len(self.end) != len(self.position):
            complaints.append((("end",), f"got {len(self.end)} numbers, and {len(self.position)} for position"))
        if TAKEN.fullmatch(self.name):
            complaints.append((("name",), f"got {self.name!r}; frames have numbers of this name; choose another"))
        if complaints:
            raise Inconsistent(complaints)
        return self

    @property
    def names(self) -> tuple[str, ...]:
        """The name of the gauge, or of each gauge in its row."""
        count = 0 if self.end is None else self.count or 2
        return tuple(f"{self.name}_{number}" for number in range(1, count + 1)) or (self.name,)


def gauge_faults(gauges: Sequence[GaugeSpec], tank: TankSpec) -> Complaints:
    """The faults of gauges outside the tank, and of equal names."""
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


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SideSpec:
    """One side of the tank."""

    kind: Literal["wall", "open", "periodic", "inflow", "outflow"] = "wall"
    """The kind of boundary: `wall`; `open`, where liquid leaves; `periodic`, like the opposite side; `inflow` or
    `outflow`. Effect: determines how the liquid ends there."""
    slip: Slip | None = None
    """The slip at a wall: `free` or `no-slip`; by default `no-slip` where `liquid.viscosity` is given. Effect:
    `no-slip` slows down the liquid along the wall."""
    restitution: Proportion | None = None
    """The ratio of normal velocities after and before a reflection at this wall; by default that of the tank. Effect:
    none unless particles penetrate."""
    tangential_restitution: Proportion | None = None
    """The ratio of tangential velocities after and before a reflection at this wall; by default that of the tank.
    Effect: none unless particles penetrate."""
    contact_angle: WettingAngle | None = None
    """The contact angle of the liquid at this wall (rad, or text such as `60 deg`); by default that of the liquid.
    Example: `"60 deg"`. Effect: small angles spread the liquid there, large ones repel it."""
    velocity: Motion | None = None
    """The velocity of a wall along itself (m/s), such as a moving lid. Effect: drags the liquid along."""
    motion: MotionSpec | None = None
    """The motion of a wall along its normal, such as a piston; walls must be mirrors. Effect: the wall makes waves."""
    speed: Annotated[Speed, Field(gt=0.0, le=1e5)] | None = None
    """The mean speed of an inflow (m/s). Effect: more liquid enters."""
    profile: Literal["uniform", "parabolic"] = "uniform"
    """The velocity profile of an inflow: `uniform` or `parabolic`, that of a viscous liquid between walls. Effect:
    `parabolic` avoids accumulation at no-slip walls."""
    level: Coordinate | None = None
    """The height of the liquid at an inflow or outflow (m); by default the whole side, and in a floor that of the
    floor. Effect: higher levels carry more liquid."""
    pressure: Annotated[Pressure, Field(ge=-1e12, le=1e12)] = 0.0
    """The gauge pressure of an outflow at its level (Pa); the weight of the liquid is added. Effect: higher
    pressures hold the liquid back."""

    @model_validator(mode="after")
    def _fits_its_kind(self) -> Self:
        complaints: list[tuple[Path, str]] = []
        if (self.kind == "inflow") != (self.speed is not None):
            complaints.append((("speed",), "expected for an inflow, and for nothing else"))
        given = [
            key for key in ("restitution", "tangential_restitution", "contact_angle") if getattr(self, key) is not None
        ]
        complaints += [
            ((key,), f'is of a wall; this side is of kind = "{self.kind}"') for key in given if self.kind != "wall"
        ]
        if self.kind != "outflow" and self.pressure != 0.0:
            complaints.append((("pressure",), f'is of an outflow; this side is of kind = "{self.kind}"'))
        if self.kind != "wall" and self.slip is not None:
            complaints.append((("slip",), f'is of a wall; this side is of kind = "{self.kind}"'))
        if self.kind != "inflow" and self.profile != "uniform":
            complaints.append((("profile",), f'is of an inflow; this side is of kind = "{self.kind}"'))
        if self.kind not in ("inflow", "outflow") and self.level is not None:
            complaints.append((("level",), f'is of an in- or outflow; this side is of kind = "{self.kind}"'))
        if complaints:
            raise Inconsistent(complaints)
        return self


def _velocity_fault(side: SideSpec, axis: int, dimension: int) -> str:
    """The fault of the velocity of a side that is normal to an axis; empty without a fault."""
    if side.velocity is None or axis >= dimension:
        return ""
    if side.kind != "wall":
        return f'is of a wall; this side is of kind = "{side.kind}"'
    if len(side.velocity) != dimension:
        return f"got {len(side.velocity)} numbers; the tank has {dimension} dimensions"
    if side.velocity[axis] != 0.0:
        return f"got {side.velocity[axis]:g} m/s normal to the wall; expected 0 (`motion` moves a wall)"
    return ""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class TankSpec:
    """A rectangular tank. In a file it may also be `outline_from = "FILE"` (STL in 3D, DXF in 2D), the outline of the
    room inside: a block around it, with this hole, becomes the first obstacle.
    """

    low: Place = ()
    """The lowest corner of the tank (m); by default the origin. Effect: moves the walls."""
    high: Place
    """The highest corner of the tank (m). Effect: moves the walls."""
    walls: Literal["mirror", "dummy", "reflect"] = "mirror"
    """The wall model: `mirror` images, layers of `dummy` particles (Adami et al. 2012), or `reflect` alone, at which
    the liquid collapses. Effect: `mirror` walls can move; `dummy` walls repel only."""
    restitution: Proportion = 0.5
    """The ratio of normal velocities after and before a reflection of particles that penetrate a wall. Effect: none
    unless particles penetrate."""
    tangential_restitution: Proportion = 1.0
    """The ratio of tangential velocities after and before a reflection of particles that penetrate a wall. Effect: none
    unless particles penetrate."""
    left: SideSpec = SideSpec()
    """The side at low x. Effect: determines the boundary there."""
    right: SideSpec = SideSpec()
    """The side at high x. Effect: determines the boundary there."""
    bottom: SideSpec = SideSpec()
    """The side at low y, or z where `up = "z"`. Effect: determines the boundary there."""
    top: SideSpec = SideSpec()
    """The side at high y, or z where `up = "z"`. Effect: determines the boundary there."""
    front: SideSpec = SideSpec()
    """The side at low z, or y where `up = "z"`. Effect: determines the boundary there."""
    back: SideSpec = SideSpec()
    """The side at high z, or y where `up = "z"`. Effect: determines the boundary there."""

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
            if SIDES.index(name) >= 2 * len(self.low) and side != SideSpec():
                complaints.append(((name,), f"is a side of 3D tanks; expected {', '.join(SIDES[:4])}: this tank is 2D"))
        for axis in range(len(self.low)):
            pair = SIDES[2 * axis : 2 * axis + 2]
            periodic = [getattr(self, side).kind == "periodic" for side in pair]
            if any(periodic) and not all(periodic):
                complaints.append(((pair[periodic.index(False)], "kind"), "its opposite is periodic; both must be"))
        if complaints:
            raise Inconsistent(complaints)
        return self


def side_faults(tank: TankSpec, names: Sequence[str]) -> Complaints:
    """Faults of the velocities of sides; `names` are ordered by axes."""
    dimension = len(tank.low)
    faults = [(name, _velocity_fault(getattr(tank, name), number // 2, dimension)) for number, name in enumerate(names)]
    return [(("tank", name, "velocity"), fault) for name, fault in faults if fault]
