"""Units as part of an annotation, and the reading of `"2 mm"`.

`radius: Length` says that a radius is a number of meters. The same annotation makes a scene accept `"2 mm"`, lets a
test feed rescaled units through every law, and prints the unit in the documentation.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler
    from pydantic_core import CoreSchema

Array = NDArray[np.float64]
Real = float | Array
Value = TypeVar("Value", float, Array)
"""A float for a float, an array for an array."""

LONGEST_TEXT = 40
QUANTITY = re.compile(r"\s*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?)\s*(.*?)\s*", re.DOTALL)
# Pint's own parser would work out `m**9**9**9`; it is given only what this grammar lets through, one digit to a power.
FACTOR = r"[A-Za-zµμ°%Ω_]+(?:(?:\^|\*\*)?-?[0-9])?"
PRODUCT = rf"{FACTOR}(?:\s*[* ]\s*{FACTOR})*"
UNIT = re.compile(rf"{PRODUCT}(?:\s*/\s*(?:{FACTOR}|\({PRODUCT}\)))*")
POWER = re.compile(r"(?<=[A-Za-zµμ°%Ω_])(?:\^|\*\*)?(-?[0-9])")
TYPOGRAPHY = str.maketrans({"·": "*", "⋅": "*", "²": "^2", "³": "^3"})


ROOM = 293.15
"""The temperature of liquids and of Brownian motion by default (K)."""


@dataclass(frozen=True)
class Unit:
    """The SI unit of an annotated number. `symbol` is what Pint reads: `kg/m^3`."""

    symbol: str

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """A scene's number may be written as text with its unit."""
        from pydantic_core import core_schema

        return core_schema.no_info_before_validator_function(self.number, handler(source))

    def number(self, value: object) -> float:
        """A scene's value in SI: a number as it is, text through its unit, anything else refused."""
        if isinstance(value, str):
            return parse(value, self.symbol)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ValueError(f"expected a number, or text with a unit such as {example(self.symbol)!r}")
        try:
            return float(value)
        except OverflowError:
            raise ValueError("too large a number") from None


def parse(text: str, symbol: str) -> float:
    """The value of `text` in SI, rounded once; `symbol` gives the expected dimension.

    >>> parse("1.7 mm", "m")
    0.0017
    """
    match = QUANTITY.fullmatch(text) if len(text) <= LONGEST_TEXT else None
    if match is None:
        raise ValueError(
            f"{text[:LONGEST_TEXT]!r} is no quantity; write a number and a unit, such as {example(symbol)!r}"
        )
    if not match[2]:
        raise ValueError(
            f"text without a unit; write the number without quotes, or with a unit as in {example(symbol)!r}"
        )
    if not math.isfinite(float(match[1])):
        raise ValueError(f"{text!r} is too large a number")
    shift, scale = _offset(match[2]) if symbol == "K" else ("0", repr(factor(match[2], symbol)))
    try:
        # Through fractions, so that "1.7 mm" is the same float as 0.0017.
        return float((Fraction(match[1]) + Fraction(shift)) * Fraction(scale))
    except OverflowError:
        raise ValueError(f"{text!r} is too large a number") from None


def _offset(unit: str) -> tuple[str, str]:
    """The offset and the factor that turn a temperature of this unit into kelvin.

    Only a temperature that stands alone has an offset: in `J/(kg*K)` there are differences of temperatures.
    """
    known = OFFSETS.get(unit.strip())
    return ("0", repr(factor(unit, "K"))) if known is None else known


OFFSETS = {
    "degC": ("273.15", "1"),
    "°C": ("273.15", "1"),
    "celsius": ("273.15", "1"),
    "degF": ("459.67", "5/9"),
    "°F": ("459.67", "5/9"),
}
"""Scales of temperature whose zero is not the absolute one."""


@lru_cache(maxsize=256)
def factor(unit: str, symbol: str) -> float:
    """The number of SI units of `symbol` in one `unit`.

    >>> factor("mN/m", "N/m")
    0.001
    """
    if (unit, symbol) in COMMON:
        return COMMON[unit, symbol]
    plain = unit.strip().translate(TYPOGRAPHY)
    if len(plain) > LONGEST_TEXT or UNIT.fullmatch(plain) is None:
        hint = "; decimals stand behind a point" if plain.startswith(",") else ""
        raise ValueError(f"{unit!r} is not how a unit is written{hint}; write for example {example(symbol)!r}")
    found, wanted = _in_base_units(POWER.sub(r"**(\1)", plain), symbol), _in_base_units(symbol, symbol)
    if found.units != wanted.units:
        raise ValueError(
            f"{unit!r} measures {_dimension(found)}, expected {_dimension(wanted)} as in {example(symbol)!r}"
        )
    return _snapped(float(found.magnitude / wanted.magnitude))


COMMON = {
    ("m", "m"): 1.0,
    ("cm", "m"): 1e-2,
    ("mm", "m"): 1e-3,
    ("um", "m"): 1e-6,
    ("s", "s"): 1.0,
    ("ms", "s"): 1e-3,
    ("us", "s"): 1e-6,
    ("min", "s"): 60.0,
    ("m/s", "m/s"): 1.0,
    ("cm/s", "m/s"): 1e-2,
    ("mm/s", "m/s"): 1e-3,
    ("m/s^2", "m/s^2"): 1.0,
    ("deg", "rad"): math.pi / 180.0,
    ("rad", "rad"): 1.0,
    ("kg/m^3", "kg/m^3"): 1.0,
    ("g/cm^3", "kg/m^3"): 1e3,
    ("Pa*s", "Pa*s"): 1.0,
    ("mPa*s", "Pa*s"): 1e-3,
    ("N/m", "N/m"): 1.0,
    ("mN/m", "N/m"): 1e-3,
}
"""What most scenes are written in: to read these needs no Pint, whose start takes most of a second."""


def _in_base_units(unit: str, symbol: str) -> Any:
    """One `unit` as Pint knows it, in base units; radians stay apart from plain numbers."""
    try:
        one, none = (_registry().Quantity(value, unit).to_base_units() for value in (1.0, 0.0))
    except Exception:  # Pint leaks its tokenizer's and registry's errors; all of them mean an unknown unit.
        raise ValueError(f"no such unit as {unit!r}; write for example {example(symbol)!r}") from None
    if none.magnitude != 0.0:
        raise ValueError(f"{unit!r} has an offset; write the value in {symbol}")
    return one


def _dimension(quantity: Any) -> str:
    """The dimension of a quantity, in words where there is one: `length`, `an angle`, `mass / length ** 3`."""
    if quantity.dimensionless:
        return "an angle" if str(quantity.units) == "radian" else "a plain number"
    return str(quantity.dimensionality).replace("[", "").replace("]", "")


def _snapped(scale: float) -> float:
    """Without the last-digit noise of Pint's products: 0.001, not 0.0010000000000000002."""
    short = float(f"{scale:.12g}")
    return short if math.isclose(short, scale, rel_tol=1e-15) else scale


EXAMPLES = {
    "m": "4 mm",
    "m/s": "2 mm/s",
    "m/s^2": "9.81 m/s^2",
    "rad": "70 deg",
    "s": "20 s",
    "kg/m^3": "1030 kg/m^3",
    "Pa*s": "2 mPa*s",
    "N/m": "45 mN/m",
    "1": "20 %",
    "1/s": "5 s^-1",
    "K": "20 degC",
}


def example(symbol: str) -> str:
    """A value as a user might write it."""
    return EXAMPLES.get(symbol, f"1 {symbol}")


@cache
def _registry() -> Any:
    """Pint's registry, made when the first unit is read: it takes a quarter of a second."""
    import pint

    return pint.UnitRegistry(cache_folder=None)


def in_unit(symbol: str) -> Callable[[type], Any]:
    """Annotate another type with a unit: `in_unit("m")(Array)`."""
    return lambda kind: Annotated[kind, Unit(symbol)]


Length = Annotated[float, Unit("m")]
Area = Annotated[float, Unit("m^2")]
Volume = Annotated[float, Unit("m^3")]
Time = Annotated[float, Unit("s")]
Speed = Annotated[float, Unit("m/s")]
Acceleration = Annotated[float, Unit("m/s^2")]
Mass = Annotated[float, Unit("kg")]
Density = Annotated[float, Unit("kg/m^3")]
ArealMass = Annotated[float, Unit("kg/m^2")]
Force = Annotated[float, Unit("N")]
Energy = Annotated[float, Unit("J")]
Pressure = Annotated[float, Unit("Pa")]
Viscosity = Annotated[float, Unit("Pa*s")]
KinematicViscosity = Annotated[float, Unit("m^2/s")]
SurfaceTension = Annotated[float, Unit("N/m")]
Friction = Annotated[float, Unit("N*s/m")]
Angle = Annotated[float, Unit("rad")]
Number = Annotated[float, Unit("1")]
Rate = Annotated[float, Unit("1/s")]
Temperature = Annotated[float, Unit("K")]

# The same for functions that welcome arrays where a float is.
Lengths = Annotated[Real, Unit("m")]
Forces = Annotated[Real, Unit("N")]
Energies = Annotated[Real, Unit("J")]
Angles = Annotated[Real, Unit("rad")]
Numbers = Annotated[Real, Unit("1")]
Frictions = Annotated[Real, Unit("N*s/m")]
