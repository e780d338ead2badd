"""Units as part of an annotation, and the reading of `"2 mm"`.

`radius: Length` says that a radius is a number of meters. The same annotation makes a scene accept `"2 mm"`, lets a test
feed rescaled units through every law, and prints the unit in the documentation.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler
    from pydantic_core import CoreSchema

Array = NDArray[np.float64]
Real = float | Array

QUANTITY = re.compile(r"^\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)\s*([A-Za-zµ°%][A-Za-z0-9µ°%*/^. ()-]*)?\s*$")
LONGEST_TEXT = 40
LARGEST_EXPONENT = 9


@dataclass(frozen=True)
class Unit:
    """The SI unit of an annotated number. `symbol` is what Pint reads: `kg/m^3`."""

    symbol: str

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """A scene's number may be written as text with its unit."""
        from pydantic_core import core_schema

        def read(value: object) -> object:
            return parse(value, self.symbol) if isinstance(value, str) else value

        return core_schema.no_info_before_validator_function(read, handler(source))


def parse(text: str, symbol: str) -> float:
    """The value of `text` in SI; `symbol` says which dimension is wanted.

    >>> parse("2 mm", "m")
    0.002
    """
    match = QUANTITY.match(text) if len(text) <= LONGEST_TEXT else None
    if match is None:
        raise ValueError(f"{text[:LONGEST_TEXT]!r} is no quantity; write a number and a unit, such as {example(symbol)!r}")
    number, unit = float(match[1]), (match[2] or "").strip()
    if not math.isfinite(number):
        raise ValueError(f"{text!r} is too large a number")
    if any(int(power) > LARGEST_EXPONENT for power in re.findall(r"\d+", unit)) or unit.count("^") > 4 or "**" in unit:
        raise ValueError(f"the unit {unit!r} has no physical meaning; write for example {example(symbol)!r}")
    return number * factor(unit, symbol)


@cache
def factor(unit: str, symbol: str) -> float:
    """How many SI units of `symbol` one `unit` is."""
    import pint

    registry = _registry()
    try:
        # An absolute temperature is the one unit with an offset; the others scale.
        found: float = registry.Quantity(1.0, unit or "dimensionless").to(registry.Unit(symbol)).magnitude
    except pint.DimensionalityError as error:
        raise ValueError(
            f"{unit or 'a plain number'!r} measures {error.dim1 or 'nothing'}, wanted a unit like {symbol!r}"
        ) from None
    except Exception:  # Pint leaks its tokenizer's and registry's errors; all of them mean an unknown unit.
        raise ValueError(f"no such unit as {unit!r}; write for example {example(symbol)!r}") from None
    return found


EXAMPLES = {"m": "4 mm", "rad": "70 deg", "s": "20 s", "kg/m^3": "1030 kg/m^3", "Pa*s": "2 mPa*s", "N/m": "45 mN/m"}


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
Force = Annotated[float, Unit("N")]
Energy = Annotated[float, Unit("J")]
Pressure = Annotated[float, Unit("Pa")]
Viscosity = Annotated[float, Unit("Pa*s")]
KinematicViscosity = Annotated[float, Unit("m^2/s")]
SurfaceTension = Annotated[float, Unit("N/m")]
Friction = Annotated[float, Unit("N*s/m")]
Angle = Annotated[float, Unit("rad")]
Number = Annotated[float, Unit("1")]

# The same for functions that welcome arrays where a float is.
Lengths = Annotated[Real, Unit("m")]
Forces = Annotated[Real, Unit("N")]
Energies = Annotated[Real, Unit("J")]
Angles = Annotated[Real, Unit("rad")]
Numbers = Annotated[Real, Unit("1")]
Frictions = Annotated[Real, Unit("N*s/m")]
