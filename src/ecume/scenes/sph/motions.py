"""Prescribed motions: of a side along its axis, of a shaken tank, of a body that follows a path."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sized
from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from ecume.engine.formulas import formula_at, formula_fault
from ecume.scenes.common import dataclass
from ecume.scenes.faults import Complaints, Inconsistent
from ecume.scenes.quantities import STRICT, Coordinate, Motion, Place, Pull, TurningRate
from ecume.units import Angle, Number, Rate, Time

Frequency = Annotated[Rate, Field(gt=0.0, le=1e6)]
Phase = Annotated[Angle, Field(ge=-1e3, le=1e3)]
Moment = Annotated[Time, Field(ge=0.0, le=1e10)]
Turn = Annotated[Angle, Field(ge=-1e6, le=1e6)]
Formula = Annotated[str, Field(max_length=300)]
OF_SINES = "belongs to a sine; expected none with another law of motion"


@dataclass(frozen=True, kw_only=True, config=STRICT)
class MotionSpec:
    """The motion of a side along its axis: a sine, a table of times and positions with linear interpolation, or a
    formula.
    """

    amplitude: Coordinate | None = None
    """The amplitude of a sine that starts at 0 (m). Effect: larger strokes make higher waves."""
    frequency: Frequency | None = None
    """The frequency of the sine in cycles per second (1/s). Effect: faster motion makes shorter waves."""
    phase: Phase = 0.0
    """The phase of the sine (rad); 90 deg starts at rest. Effect: shifts the sine in time."""
    times: tuple[Moment, ...] = ()
    """The times of a table (s), ascending; outside of it the side is at rest. Effect: shifts the motion in time."""
    positions: tuple[Coordinate, ...] = ()
    """The displacement of the side at these times (m). Effect: determines the path of the side."""
    formula: Formula = ""
    """The displacement of the side (m) as a formula of the time t (s), instead of a sine or a table. Example:
    `"0.02*sin(2*pi*t)*tanh(t)"`. Effect: determines the path of the side."""

    @model_validator(mode="after")
    def _one_law(self) -> Self:
        _require_one(self, "positions")
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class BaseExcitationSpec:
    """The inertial acceleration in the frame of a shaken tank, in addition to gravity: minus the acceleration of the
    tank.
    """

    amplitude: Pull | None = None
    """The amplitude of a sinusoidal acceleration (m/s^2). Effect: sloshing grows in proportion to it, while it is
    small."""
    frequency: Frequency | None = None
    """The frequency of the sine in cycles per second (1/s). Effect: near a natural frequency of the tank there is
    resonance."""
    phase: Phase = 0.0
    """The phase of the sine (rad); 90 deg starts at the maximum. Effect: shifts the sine in time."""
    times: tuple[Moment, ...] = ()
    """The times of a table (s), ascending; outside of it the first and the last value hold. Effect: shifts the
    acceleration in time."""
    accelerations: tuple[Pull, ...] = ()
    """The acceleration of the liquid in the frame of the tank at these times (m/s^2). Effect: determines the motion
    of the tank."""
    formula: tuple[Formula, ...] = ()
    """Each component of this acceleration (m/s^2) as a formula of the time t (s), instead of a sine or a table.
    Example: `["0.5*sin(3*t)", "0"]`. Effect: determines the motion of the tank."""

    @model_validator(mode="after")
    def _one_law(self) -> Self:
        _require_one(self, "accelerations")
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class RollSpec:
    """The rotation of the whole tank about a pivot, a sine or a formula. The scene is that of the frame of the tank:
    gravity turns, and the inertial forces act on the liquid.
    """

    amplitude: Turn | None = None
    """The amplitude of the angle of a sine that starts at 0 (rad). Example: `"4 deg"`. Effect: the tank rolls
    farther."""
    frequency: Frequency | None = None
    """The frequency of the sine in cycles per second (1/s). Effect: near a natural frequency of the tank there is
    resonance."""
    phase: Phase = 0.0
    """The phase of the sine (rad); 90 deg starts at rest. Effect: shifts the sine in time."""
    formula: Formula = ""
    """The angle (rad) as a formula of the time t (s), instead of a sine. Example: `"0.07*sin(3.85*t)*tanh(2*t)"`.
    Effect: determines the rotation of the tank."""
    pivot: Place | None = None
    """The point about which the tank turns (m); by default the middle of its floor. Effect: a lower pivot shakes the
    liquid sideways, too."""
    axis: tuple[Number, Number, Number] = (0.0, 0.0, 1.0)
    """The direction of the axis of rotation in 3D; in 2D it is z. Example: `[1, 0, 0]`. Effect: the tank turns
    counterclockwise about it."""

    @model_validator(mode="after")
    def _one_law(self) -> Self:
        if (self.amplitude is None) == (not self.formula):
            raise Inconsistent([((), "expected either amplitude and frequency, or a formula")])
        if (self.amplitude is None) != (self.frequency is None):
            raise Inconsistent([(("frequency",), "belongs to an amplitude; expected both or none")])
        if self.phase != 0.0 and self.amplitude is None:
            raise Inconsistent([(("phase",), OF_SINES)])
        _require_formulas("formula", (self.formula,) if self.formula else ())
        if not any(self.axis):
            raise Inconsistent([(("axis",), "expected a vector that is not zero")])
        return self

    def dimension_faults(self, dimension: int) -> Complaints:
        """The faults of vectors whose dimension differs from that of the tank."""
        found: Complaints = []
        if self.pivot is not None and len(self.pivot) != dimension:
            found.append((("pivot",), f"got {len(self.pivot)} numbers; the tank has {dimension} dimensions"))
        if dimension == 2 and (self.axis[0], self.axis[1]) != (0.0, 0.0):
            found.append((("axis",), "in two dimensions a tank turns about z alone"))
        return found


@dataclass(frozen=True, kw_only=True, config=STRICT)
class BodyMotionSpec:
    """The path of a body: uniform, a sine, a table of times with linear interpolation, or formulas. The body is
    translated, and rotated about a pivot that moves with it.
    """

    velocity: Motion | None = None
    """The velocity of a uniform motion (m/s). Effect: a gate opens faster."""
    spin: TurningRate = 0.0
    """The angular velocity of a uniform rotation (rad/s). Example: `5`. Effect: turns the body faster."""
    start: Moment = 0.0
    """The time at which the uniform motion begins (s). Effect: delays the motion."""
    until: Moment | None = None
    """The time at which the uniform motion ends (s); by default it lasts. Effect: stops the body there."""
    amplitude: Place | None = None
    """The amplitude of a sine that starts at 0 (m). Effect: the body moves farther."""
    angle_amplitude: Turn = 0.0
    """The amplitude of the angle of the sine (rad). Example: `"4 deg"`. Effect: the body swings farther."""
    frequency: Frequency | None = None
    """The frequency of the sine in cycles per second (1/s). Effect: the body moves faster."""
    phase: Phase = 0.0
    """The phase of the sine (rad); 90 deg starts at rest. Effect: shifts the sine in time."""
    times: tuple[Moment, ...] = ()
    """The times of a table (s), ascending; outside of it the body is at rest. Effect: shifts the motion in time."""
    positions: tuple[Place, ...] = ()
    """The displacement of the body at these times (m). Effect: determines the path of the body."""
    angles: tuple[Turn, ...] = ()
    """The angle of the body at these times (rad). Effect: determines the rotation of the body."""
    formula: tuple[Formula, ...] = ()
    """Each component of the displacement (m) as a formula of the time t (s). Example: `["0", "0.1*t**2"]`. Effect:
    determines the path of the body."""
    angle_formula: Formula = ""
    """The angle (rad) as a formula of the time t (s). Example: `"0.07*sin(3.85*t)"`. Effect: determines the rotation of
    the body."""
    pivot: Place | None = None
    """The point about which the body turns, as it starts (m); by default its center. Effect: a body with a pivot at
    its edge is a flap."""
    axis: tuple[Number, Number, Number] = (0.0, 0.0, 1.0)
    """The direction of the axis of rotation in 3D; in 2D it is z. Example: `[0, 1, 0]`. Effect: the body turns
    counterclockwise about it."""

    @model_validator(mode="after")
    def _one_law(self) -> Self:
        uniform = self.velocity is not None or self.spin != 0.0
        sine = self.amplitude is not None or self.angle_amplitude != 0.0
        table = bool(self.times or self.positions or self.angles)
        if uniform + sine + table + bool(self.formula or self.angle_formula) != 1:
            laws = (
                "velocity or spin, amplitude or angle_amplitude with frequency, times with positions or angles, "
                "formula or angle_formula"
            )
            raise Inconsistent([((), f"expected exactly one law: {laws}")])
        if sine and self.frequency is None:
            raise Inconsistent([(("frequency",), "is missing; a sine needs it")])
        unused = {
            "frequency": self.frequency is not None and not sine,
            "phase": self.phase != 0.0 and not sine,
            "start": self.start != 0.0 and not uniform,
        }
        if wrong := [key for key, there in unused.items() if there]:
            raise Inconsistent([((wrong[0],), "belongs to another law of motion than the one that is given")])
        if self.until is not None and not (uniform and self.until > self.start):
            raise Inconsistent([(("until",), "expected the end of a uniform motion, after its start")])
        if table and not (self.positions or self.angles):
            raise Inconsistent([((), "a table of times needs positions, angles, or both")])
        for name in ("positions", "angles"):
            if getattr(self, name) and len(getattr(self, name)) != len(self.times):
                message = f"got {len(getattr(self, name))} for {len(self.times)} times; expected the same number"
                raise Inconsistent([((name,), message)])
        _require_ascending(self.times)
        _require_formulas("formula", self.formula)
        _require_formulas("angle_formula", (self.angle_formula,) if self.angle_formula else ())
        if not any(self.axis):
            raise Inconsistent([(("axis",), "expected a vector that is not zero")])
        return self

    def formulas(self) -> tuple[str, ...]:
        """The formulas of the displacement along x, y and z, and of the angle; empty for another law."""
        if not (self.formula or self.angle_formula):
            return ()
        along = (*self.formula, *("0",) * (3 - len(self.formula)))
        return (*along, self.angle_formula or "0")

    def dimension_faults(self, dimension: int) -> Complaints:
        """The faults of vectors whose dimension differs from that of the tank."""
        rows: dict[str, Sized | None] = {"velocity": self.velocity, "amplitude": self.amplitude, "pivot": self.pivot}
        rows["positions"] = next((row for row in self.positions if len(row) != dimension), None)
        rows["formula"] = self.formula or None
        of_tank = f"the tank has {dimension} dimensions"
        found: Complaints = [
            ((name,), f"got {len(row)} {'formulas' if name == 'formula' else 'numbers'}; {of_tank}")
            for name, row in rows.items()
            if row is not None and len(row) != dimension
        ]
        if dimension == 2 and (self.axis[0], self.axis[1]) != (0.0, 0.0):
            found.append((("axis",), "in two dimensions a body turns about z alone"))
        return found


def _require_one(spec: Any, values: str) -> None:
    """Raise an error unless there is exactly one complete sine, one complete table, or a formula."""
    sine, table = spec.amplitude is not None, bool(spec.times or getattr(spec, values))
    if sine + table + bool(spec.formula) != 1:
        raise Inconsistent([((), f"expected either amplitude and frequency, or times and {values}, or a formula")])
    _require_formulas("formula", (spec.formula,) if isinstance(spec.formula, str) and spec.formula else spec.formula)
    if sine and spec.frequency is None:
        raise Inconsistent([(("frequency",), "is missing; a sine needs it")])
    if not sine and (wrong := [name for name in ("frequency", "phase") if getattr(spec, name)]):
        raise Inconsistent([((wrong[0],), OF_SINES)])
    if table and len(spec.times) != len(getattr(spec, values)):
        message = f"got {len(getattr(spec, values))} for {len(spec.times)} times; expected the same number"
        raise Inconsistent([((values,), message)])
    _require_ascending(spec.times)


def _require_formulas(key: str, texts: Iterable[str]) -> None:
    if fault := next((fault for text in texts if (fault := formula_fault(text))), ""):
        raise Inconsistent([((key,), fault)])


TRIED = 2000
"""The number of times of a run at which formulas are tried."""


def tried(duration: Time) -> Iterator[float]:
    """The times of a run at which formulas are tried."""
    return (duration * step / TRIED for step in range(TRIED + 1))


def formula_faults(texts: Iterable[str], duration: Time, *, from_zero: bool) -> Iterator[str]:
    """The faults of formulas that have no value at some time of a run, or do not begin at 0."""
    for text in texts:
        if from_zero and abs(_value(text, 0.0)) > 1e-12:
            yield f"got {text!r}, which is {_value(text, 0.0):.3g} at t = 0; expected 0, as the solid is drawn"
            continue
        if (bad := next((time for time in tried(duration) if not math.isfinite(_value(text, time))), None)) is not None:
            yield f"got {text!r}, which with its derivatives has no finite value at t = {bad:.3g} s"


def _value(text: str, time: float) -> float:
    """The value of a formula; NaN where it or one of its derivatives has none."""
    try:
        jet = formula_at(text, time)
    except (ArithmeticError, ValueError):
        return math.nan
    return jet[0] if all(map(math.isfinite, jet)) else math.nan


def _require_ascending(times: tuple[float, ...]) -> None:
    if any(later <= earlier for earlier, later in itertools.pairwise(times)):
        raise Inconsistent([(("times",), "expected times that ascend")])
