"""The quantities of a scene: their units, and ranges that contain all physical values.

Both limits are far beyond any experiment. They ensure that products of valid numbers neither overflow nor underflow.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import ConfigDict, Field, PlainValidator

from ecume.scenes.faults import Complaints
from ecume.units import (
    Acceleration,
    Angle,
    AngularVelocity,
    Density,
    Length,
    Number,
    Rate,
    Speed,
    SurfaceTension,
    Time,
    Unit,
    Viscosity,
    example,
    quantity_of,
)

STRICT = ConfigDict(extra="forbid", allow_inf_nan=False)
"""The configuration of all pieces of a scene: no unknown keys, no infinities."""

LONGEST_TITLE = 200
LONGEST_NAME = 60
MOST_PARTICLES = 50_000_000
MOST_FRAMES = 10_000_000
MOST_STEPS = 100_000_000_000
FARTHEST = 1e3
"""The largest distance from the origin (m)."""

Size = Annotated[Length, Field(gt=0.0, le=1e3)]
Radius = Annotated[Length, Field(ge=1e-8, le=1e3)]
Undulation = Annotated[Length, Field(ge=0.0, le=1e-2)]
Amplitude = Annotated[Length, Field(ge=0.0, le=1e3)]
Direction = Annotated[Angle, Field(ge=-1e3, le=1e3)]
Coordinate = Annotated[Length, Field(ge=-FARTHEST, le=FARTHEST)]
Velocity = Annotated[Speed, Field(ge=-1e3, le=1e3)]
Duration = Annotated[Time, Field(gt=0.0, le=1e10)]
PositiveDensity = Annotated[Density, Field(ge=1e-3, le=1e5)]
GasDensity = Annotated[Density, Field(ge=0.0, le=1e5)]
LiquidViscosity = Annotated[Viscosity, Field(ge=0.0, le=1e9)]
PositiveTension = Annotated[SurfaceTension, Field(ge=1e-9, le=1e3)]
Tension = Annotated[SurfaceTension, Field(ge=0.0, le=1e3)]
Gravity = Annotated[Acceleration, Field(ge=1e-6, le=1e6)]
MagneticMoment = Annotated[float, Unit("A*m^2"), Field(ge=-1e3, le=1e3)]
TurningRate = Annotated[AngularVelocity, Field(ge=-1e6, le=1e6)]
Gradient = Annotated[Rate, Field(ge=-1e6, le=1e6)]
Frequency = Annotated[Rate, Field(gt=0.0, le=1e6)]
Proportion = Annotated[Number, Field(ge=0.0, le=1.0)]
Filling = Annotated[Number, Field(gt=0.0, lt=1.0)]
Roughness = Annotated[Number, Field(ge=0.0, le=10.0)]
Springiness = Annotated[float, Unit("N/m"), Field(gt=0.0, le=1e9)]

Text = Annotated[str, Field(max_length=LONGEST_TITLE, pattern=r"^[^\x00-\x1f\x7f]*$")]
Name = Annotated[str, Field(max_length=LONGEST_NAME, pattern=r"^[^\x00-\x1f\x7f]*$")]
LawName = Annotated[str, Field(min_length=1, max_length=LONGEST_NAME, pattern=r"^[a-z0-9][a-z0-9-]*$")]
"""The name of a law, which the model checks: a scene does not contain the tables of laws."""

Count = Annotated[int, Field(strict=True, ge=1, le=MOST_PARTICLES)]
Seed = Annotated[int, Field(strict=True, ge=0, le=2**63 - 1)]
Switch = Annotated[bool, Field(strict=True)]


@dataclass(frozen=True)
class Measured:
    """The SI unit of numbers that are read by another function than `Unit`."""

    symbol: str


ORIGINAL_CLOSURE = "original-closure"


def wetting_angle(value: object) -> float:
    """An angle between 0 and 180 degrees."""
    angle = Unit("rad").number(value)
    if not 0.0 <= angle <= math.pi:
        meant = (
            f": write '{value:g} deg' for degrees" if isinstance(value, int | float) and 0.0 <= value <= 180.0 else ""
        )
        raise ValueError(f"expected an angle from 0 to 180 deg; plain numbers are radians{meant}")
    return angle


def contact_angle(value: object) -> float | str:
    """An angle between 0 and 180 degrees, or the name of the closure that computes it."""
    return ORIGINAL_CLOSURE if isinstance(value, str) and value == ORIGINAL_CLOSURE else wetting_angle(value)


WettingAngle = Annotated[Angle, PlainValidator(wetting_angle)]
ContactAngle = Annotated[float | str, PlainValidator(contact_angle), Measured("rad")]


COLORS = {
    "black": "#000000",
    "white": "#ffffff",
    "gray": "#808080",
    "silver": "#c0c0c0",
    "red": "#d62728",
    "orange": "#ff7f0e",
    "gold": "#e0b000",
    "yellow": "#f2e205",
    "olive": "#8a8a1f",
    "green": "#2ca02c",
    "teal": "#008080",
    "cyan": "#17becf",
    "blue": "#1f77b4",
    "navy": "#14305c",
    "purple": "#9467bd",
    "magenta": "#c837ab",
    "pink": "#f2a0b5",
    "brown": "#8c564b",
    "tan": "#d2b48c",
    "wheat": "#e8c583",
}
HEXADECIMAL = re.compile(r"#[0-9a-f]{6}")


def color(value: object) -> str:
    """A color as `#rrggbb`, from this form or from one of the names in `COLORS`."""
    text = value.lower() if isinstance(value, str) else ""
    if text in COLORS:
        return COLORS[text]
    if not HEXADECIMAL.fullmatch(text):
        raise ValueError(f"expected a color such as '#c8a165', or one of {', '.join(COLORS)}")
    return text


Color = Annotated[str, PlainValidator(color)]


def vector(symbol: str, most: float) -> Callable[[object], tuple[float, ...]]:
    """A reader of two or three quantities of one unit, none larger than `most`."""

    def read(value: object) -> tuple[float, ...]:
        if not isinstance(value, (list, tuple)) or len(value) not in (2, 3):
            raise ValueError(f"expected two or three numbers, or texts such as {example(symbol)!r}")
        numbers = tuple(Unit(symbol).number(item) for item in value)
        if not all(abs(number) <= most for number in numbers):
            raise ValueError(f"expected numbers between {-most:g} and {most:g} {symbol}")
        return numbers

    return read


Place = Annotated[tuple[float, ...], PlainValidator(vector("m", 1e3)), Measured("m")]
Motion = Annotated[tuple[float, ...], PlainValidator(vector("m/s", 1e3)), Measured("m/s")]
Pull = Annotated[tuple[float, ...], PlainValidator(vector("m/s^2", 1e6)), Measured("m/s^2")]


class InPlane(float):
    """A reader of numbers as text with the unit in 2D, such as kg/m."""


class InSpace(float):
    """A reader of numbers as text with the unit in 3D, such as kg."""


@dataclass(frozen=True)
class ByDimension:
    """The units of numbers whose unit depends on the dimension of the scene: in 2D, and in 3D."""

    plane: str
    space: str

    def number(self, value: object) -> float:
        """A number in SI units. A number from text stores its unit for `fault`; a plain number has none."""
        if not isinstance(value, str) and quantity_of(value) is None:
            return value if isinstance(value, (InPlane, InSpace)) else Unit(self.space).number(value)
        try:
            return InSpace(Unit(self.space).number(value))
        except ValueError:
            try:
                return InPlane(Unit(self.plane).number(value))
            except ValueError as error:
                raise ValueError(f"{error} in 2D, or {self.space} in 3D") from None

    def fault(self, value: float | None, dimensions: int) -> str:
        """The fault of a number whose unit has another dimension; empty for a fitting unit."""
        wrong, unit = (InSpace, self.plane) if dimensions == 2 else (InPlane, self.space)
        return (
            f"has the unit of another dimension; expected {unit} in {dimensions}D" if isinstance(value, wrong) else ""
        )

    def reader(self, least: float, most: float) -> Callable[[object], float]:
        """A reader of numbers above `least` and up to `most`."""

        def read(value: object) -> float:
            number = self.number(value)
            if not least < number <= most:
                raise ValueError(f"expected more than {least:g} and at most {most:g}")
            return number

        return read


AVOGADRO = 6.02214076e23
"""The number of particles in a mole, exact in the SI of 2019."""


@dataclass(frozen=True)
class NumberDensity(ByDimension):
    """The units of numbers of particles per area or volume, in which a number may also be stated in moles."""

    def number(self, value: object) -> float:
        """A number in SI units, as of `ByDimension`; moles are numbers of particles."""
        try:
            moles = ByDimension("mol/m^2", "mol/m^3").number(value) if _has_moles(value) else None
        except ValueError:  # of another dimension: the fault names the unit of the numbers
            moles = None
        return super().number(value) if moles is None else type(moles)(AVOGADRO * moles)


def _has_moles(value: object) -> bool:
    return "mol" in str(value)


BODY_MASS, CONCENTRATION = ByDimension("kg/m", "kg"), NumberDensity("1/m^2", "1/m^3")
BodyMass = Annotated[float, PlainValidator(BODY_MASS.reader(0.0, 1e15)), BODY_MASS]
Concentration = Annotated[float, PlainValidator(CONCENTRATION.reader(0.0, 1e30)), CONCENTRATION]


def gravity(value: object) -> tuple[float, ...]:
    """The magnitude of gravity, as one number, or its vector."""
    if isinstance(value, (list, tuple)) and len(value) != 1 and quantity_of(value) is None:
        return vector("m/s^2", 1e6)(value)
    magnitude = Unit("m/s^2").number(value[0] if isinstance(value, (list, tuple)) else value)
    if not 0.0 <= magnitude <= 1e6:
        raise ValueError("expected a magnitude from 0 to 1e6 m/s^2, or a vector such as ['0 m/s^2', '-9.81 m/s^2']")
    return (magnitude,)


Up = Literal["y", "z"]
"""The axis that points up in a scene."""
AXES = "xyz"
SIDES = ("left", "right", "bottom", "top", "front", "back")
"""The sides of a box: low and high x, low and high y, low and high z, where y points up."""


def sides_along(up: Up, dimensions: int) -> tuple[str, ...]:
    """The names of the sides of a box, low and high along each axis.

    >>> sides_along("z", 3)
    ('left', 'right', 'front', 'back', 'bottom', 'top')
    """
    return SIDES[: 2 * dimensions] if up == "y" else (*SIDES[:2], *SIDES[4:], *SIDES[2:4])


def up_faults(up: Up, dimensions: int) -> Complaints:
    """The fault of an axis that a scene in 2D does not have."""
    return [(("up",), "got 'z'; expected 'y' in 2D")] if AXES.index(up) >= dimensions else []


def downwards(given: tuple[float, ...], dimensions: int, up: Up = "y") -> tuple[float, ...]:
    """The vector of gravity: a magnitude acts downward.

    >>> downwards((9.81,), 3), downwards((9.81,), 3, "z")
    ((0.0, -9.81, 0.0), (0.0, 0.0, -9.81))
    """
    return given if len(given) != 1 else tuple(-given[0] if axis == up else 0.0 for axis in AXES[:dimensions])


GravityVector = Annotated[tuple[float, ...], PlainValidator(gravity), Measured("m/s^2")]
"""Gravity as a vector; a scene may give its magnitude."""


def absolute_temperature(value: object) -> float:
    """A temperature in kelvin; text may be in degrees Celsius."""
    kelvin = Unit("K").number(value)
    if not 0.0 <= kelvin <= 1e4:
        raise ValueError("expected a temperature from 0 to 10,000 K; write '20 degC' or kelvin")
    return kelvin


AbsoluteTemperature = Annotated[float, PlainValidator(absolute_temperature), Measured("K")]
