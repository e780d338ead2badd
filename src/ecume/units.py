"""Units as part of an annotation, the reading of `"2 mm"`, and quantities such as `2 * mm`.

`radius: Length` says that a radius is a number of meters. The same annotation makes a scene accept `"2 mm"`, lets a
test feed rescaled units through every law, and prints the unit in the documentation.

>>> from ecume.units import Quantity, kg, m, mm, s
>>> 2 * mm, 3 * mm / s, 1030 * kg / m**3, [1, 2] * mm, float(2 * mm), Quantity(5, "mPa*s")
(2 mm, 3 mm/s, 1030 kg/m^3, [1 mm, 2 mm], 0.002, 5 mPa*s)

Values as text: with a unit, and with the prefix of their size.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, TypeGuard, TypeVar, overload

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
# Pint's parser would evaluate `m**9**9**9`; it only receives texts of this grammar, with exponents of one digit.
FACTOR = r"[A-Za-zµμ°%Ω_]+(?:(?:\^|\*\*)?-?[0-9])?"
PRODUCT = rf"{FACTOR}(?:\s*[* ]\s*{FACTOR})*"
UNIT = re.compile(rf"(?:{PRODUCT}|1(?=\s*/))(?:\s*/\s*(?:{FACTOR}|\({PRODUCT}\)))*")
POWER = re.compile(r"(?<=[A-Za-zµμ°%Ω_])(?:\^|\*\*)?(-?[0-9])")
TYPOGRAPHY = str.maketrans({"·": "*", "⋅": "*"})
RAISED = re.compile("⁻?[¹²³⁴-⁹]")
LOWERED = str.maketrans("⁻¹²³⁴⁵⁶⁷⁸⁹", "-123456789")


ROOM = 293.15
"""The temperature of liquids and of Brownian motion by default (K)."""


@dataclass(frozen=True)
class Unit:
    """The SI unit of an annotated number; `symbol` is a text for Pint: `kg/m^3`."""

    symbol: str

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """The schema by which the number of a scene may be text with a unit."""
        from pydantic_core import core_schema

        return core_schema.no_info_before_validator_function(self.number, handler(source))

    def number(self, value: object) -> float:
        """The value of a number of a scene in SI: numbers are unchanged, text and quantities are converted, and
        anything else is refused.
        """
        if isinstance(value, str):
            return parse(value, self.symbol)
        if (quantity := quantity_of(value)) is not None:
            return quantity.to(self.symbol)
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
            f"{text[:LONGEST_TEXT]!r} is not a quantity; expected a number and a unit, such as {example(symbol)!r}"
        )
    if not match[2]:
        raise ValueError(
            f"text without a unit; write the number without quotes, or with a unit as in {example(symbol)!r}"
        )
    if not math.isfinite(float(match[1])):
        raise ValueError(f"{text!r} is too large a number")
    return _converted(match[1], match[2], symbol)


def _converted(number: str, unit: str, symbol: str) -> float:
    """A number of `unit` in units of `symbol`, computed with fractions, so that "1.7 mm" is the same float as
    0.0017.
    """
    shift, scale = _offset(unit) if symbol == "K" else ("0", repr(factor(unit, symbol)))
    try:
        return float((Fraction(number) + Fraction(shift)) * Fraction(scale))
    except OverflowError:
        raise ValueError(f"'{number} {unit}' is too large a number") from None


@dataclass(frozen=True)
class Quantity:
    """A number with a unit, such as `3 * mm` or `Quantity(3, "mm")`; products and quotients have combined units."""

    value: float
    unit: str

    __array_ufunc__ = None
    """An array of NumPy leaves the multiplication to the quantity: `array * mm` is a list of quantities."""

    def to(self, unit: str) -> float:
        """The number of `unit` in the quantity, rounded once. Raises ValueError if the dimensions differ.

        >>> Quantity(5, "mm").to("m")
        0.005
        """
        if not math.isfinite(self.value):
            raise ValueError("expected a finite number")
        return float(self.value) if self.unit == unit == "1" else _converted(repr(float(self.value)), self.unit, unit)

    def __float__(self) -> float:
        """The number in SI base units: `float(2 * mm)` is 0.002."""
        if self.unit == "1" or self.unit in OFFSETS:
            return self.to("K" if self.unit in OFFSETS else "1")
        found = _in_base_units(_readable(self.unit, "m"), "m")
        return self.to(str(found.units).replace(" ", "") or "1")

    def __repr__(self) -> str:
        return f"{self.value:.15g} {self.unit}"

    def __neg__(self) -> Quantity:
        return Quantity(-self.value, self.unit)

    def __mul__(self, other: float | Quantity) -> Quantity:
        if isinstance(other, Quantity):
            return Quantity(self.value * other.value, _product(self.unit, other.unit, 1))
        return Quantity(self.value * other, self.unit) if isinstance(other, (int, float)) else NotImplemented

    @overload
    def __rmul__(self, other: float) -> Quantity: ...

    @overload
    def __rmul__(self, other: Nested | Array) -> Quantities: ...

    def __rmul__(self, other: float | Nested | Array) -> Quantity | Quantities:
        if isinstance(other, (np.ndarray, np.generic)):
            plain: Nested = other.tolist()
            return self.__rmul__(plain)
        if isinstance(other, (int, float)):
            return Quantity(float(other) * self.value, self.unit)
        if not isinstance(other, (list, tuple)):
            raise TypeError(f"got {other!r} times {self.unit}; expected a number or lists of numbers")
        found: Quantities = [self.__rmul__(item) for item in other]
        return found

    def __truediv__(self, other: float | Quantity) -> Quantity:
        if isinstance(other, Quantity):
            return Quantity(self.value / other.value, _product(self.unit, other.unit, -1))
        return Quantity(self.value / other, self.unit) if isinstance(other, (int, float)) else NotImplemented

    def __rtruediv__(self, other: float) -> Quantity:
        return Quantity(other / self.value, _product("", self.unit, -1))

    def __pow__(self, power: int) -> Quantity:
        if not isinstance(power, int) or not 1 <= abs(power) <= 9:
            raise ValueError(f"got the power {power!r}; expected a whole number from -9 to 9, except 0")
        unit = ""
        for _ in range(abs(power)):
            unit = _product(unit, self.unit, 1 if power > 0 else -1)
        return Quantity(self.value**power, unit)


Nested = Sequence["float | Nested"]
"""Numbers in lists, of any depth."""
Quantities = list["Quantity | Quantities"]
"""Quantities in lists, of any depth."""


def _product(one: str, other: str, sign: int) -> str:
    """The unit of a product (`sign` 1) or a quotient (-1): `kg/m^3` of `kg` and `m^3`; powers of equal units add up."""
    powers: dict[str, int] = {}
    for unit, factor_sign in ((one, 1), (other, sign)):
        for name, power in _powers(unit).items():
            powers[name] = powers.get(name, 0) + factor_sign * power
    above = [_power(name, power) for name, power in powers.items() if power > 0]
    below = [_power(name, -power) for name, power in powers.items() if power < 0]
    if not above:
        return "*".join(_power(name, power) for name, power in powers.items() if power) or "1"
    return "/".join(["*".join(above), *below])


def _typed(unit: str) -> str:
    """A unit in the characters of a keyboard: `m^-3` for `m⁻³`, `1/mL` for `/mL`."""
    plain = RAISED.sub(lambda found: "^" + found[0].translate(LOWERED), unit.strip().translate(TYPOGRAPHY))
    return f"1{plain}" if plain.startswith("/") else plain


def _power(name: str, power: int) -> str:
    return name if power == 1 else f"{name}^{power}"


def _powers(unit: str) -> dict[str, int]:
    """The powers of the units in a product or quotient: `{"kg": 1, "m": -3}` for `kg/m^3`."""
    found: dict[str, int] = {}
    plain = _typed(unit).replace("**", "^")
    for sign, bracket, single in re.findall(r"(^|/)\s*(?:\(([^()]*)\)|([^/()]*))", plain):
        for name, power in re.findall(r"([^\s*^0-9-]+)\^?(-?[0-9])?", bracket or single):
            found[name] = found.get(name, 0) + int(power or 1) * (-1 if sign else 1)
    return found


def quantity_of(value: object) -> Quantity | None:
    """The quantity that corresponds to a Python object: a quantity of ecume, a pair `(2, "mm")`, or a quantity of Pint;
    None otherwise.
    """
    if isinstance(value, Quantity):
        return value
    if isinstance(value, tuple) and len(value) == 2 and isinstance(value[1], str) and _is_number(value[0]):
        return Quantity(float(value[0]), value[1])
    number, unit = getattr(value, "magnitude", None), getattr(value, "units", None)
    return Quantity(float(number), str(unit).replace(" ", "")) if unit is not None and _is_number(number) else None


def _is_number(value: object) -> TypeGuard[float]:
    return isinstance(value, (int, float, np.integer)) and not isinstance(value, bool)


def _offset(unit: str) -> tuple[str, str]:
    """The offset and the factor that convert a temperature of this unit to kelvin.

    Only a single temperature has an offset: `J/(kg*K)` contains a difference of temperatures.
    """
    known = OFFSETS.get(unit.strip())
    return ("0", repr(factor(unit, "K"))) if known is None else known


OFFSETS = {
    "degC": ("273.15", "1"),
    "°C": ("273.15", "1"),
    "celsius": ("273.15", "1"),
    "degF": ("459.67", "5/9"),
    "°F": ("459.67", "5/9"),
    "degree_Celsius": ("273.15", "1"),
    "degree_Fahrenheit": ("459.67", "5/9"),
}
"""Scales of temperature whose zero is not the absolute one."""


PER_LONG_TIME = [{name: -1} for name in ("min", "minute", "h", "hour", "hr", "d", "day")]
"""Units of rates that are those of turns where something rotates: `1/min` of a motor."""


@lru_cache(maxsize=256)
def factor(unit: str, symbol: str) -> float:
    """The number of SI units of `symbol` in one `unit`.

    Text may omit the radians of `rad/s`, but not those of `rad/min`, where it would mean revolutions.

    >>> factor("mN/m", "N/m")
    0.001
    """
    if (unit.strip(), symbol) == ("deg", "rad"):
        return DEGREE
    if symbol == "rad/s" and same_dimension(unit, "1/s"):
        named = _powers(unit)
        if named in PER_LONG_TIME or any(name.endswith(("Hz", "hertz")) for name in named):
            raise ValueError(f"{unit!r} counts turns; write for example {example(symbol)!r}")
        symbol = "1/s"
    known, target = base_of(unit), base_of(symbol)
    if known is not None and target is not None and known.powers == target.powers and known.powers:
        return float(known.value / target.value)
    if unit == symbol != "1":
        return 1.0
    found, expected = _in_base_units(_readable(unit, symbol), symbol), _in_base_units(symbol, symbol)
    if found.units != expected.units:
        raise ValueError(
            f"{unit!r} measures {_dimension(found)}, expected {_dimension(expected)} as in {example(symbol)!r}"
        )
    return _snapped(float(found.magnitude / expected.magnitude))


def _readable(unit: str, symbol: str) -> str:
    """A unit in the notation of Pint. Raises ValueError for text that is not a unit."""
    plain = _typed(unit)
    if len(plain) > LONGEST_TEXT or UNIT.fullmatch(plain) is None:
        hint = "; the decimal separator is a point" if plain.startswith(",") else ""
        raise ValueError(f"{unit!r} is not how a unit is written{hint}; write for example {example(symbol)!r}")
    return POWER.sub(r"**(\1)", plain)


POWERS_OF_TEN = {
    "f": -15, "p": -12, "n": -9, "u": -6, "\u00b5": -6, "\u03bc": -6, "m": -3, "c": -2, "h": 2, "k": 3, "M": 6, "G": 9,
}  # fmt: skip
"""SI prefixes; micro is also written with either character for it."""
NAMED: Mapping[str, tuple[Fraction, Mapping[str, int]]] = {
    **{name: (Fraction(1), {name: 1}) for name in ("m", "s", "K", "A", "rad")},
    "g": (Fraction(1, 1000), {"kg": 1}),
    "L": (Fraction(1, 1000), {"m": 3}),
    "min": (Fraction(60), {"s": 1}),
    "Hz": (Fraction(1), {"s": -1}),
    "N": (Fraction(1), {"kg": 1, "m": 1, "s": -2}),
    "Pa": (Fraction(1), {"kg": 1, "m": -1, "s": -2}),
    "bar": (Fraction(100000), {"kg": 1, "m": -1, "s": -2}),
    "J": (Fraction(1), {"kg": 1, "m": 2, "s": -2}),
    "W": (Fraction(1), {"kg": 1, "m": 2, "s": -3}),
    "T": (Fraction(1), {"kg": 1, "s": -2, "A": -1}),
}
"""Units by value and powers of SI base units. Scenes with these need no Pint, which takes a quarter of a second."""
NOT_PREFIXED = {"hbar", *(f"{prefix}min" for prefix in POWERS_OF_TEN)}
"""Names that accept no prefix: a constant of nature, and words that are not units."""
DEGREE = math.pi / 180.0


class Base(NamedTuple):
    """A unit in base units of the SI."""

    value: Fraction
    powers: Mapping[str, int]


@lru_cache(maxsize=256)
def base_of(unit: str) -> Base | None:
    """A product or quotient of prefixed units in base units; None for units that only Pint knows.

    >>> base_of("mN/m")
    Base(value=Fraction(1, 1000), powers={'kg': 1, 's': -2})
    """
    plain = _typed(unit)
    if plain != "1" and (len(plain) > LONGEST_TEXT or UNIT.fullmatch(plain) is None):
        return None
    value, powers = Fraction(1), dict[str, int]()
    for name, power in _powers(plain).items():
        found = _named(name)
        if found is None:
            return None
        value *= found.value**power
        for base, exponent in found.powers.items():
            powers[base] = powers.get(base, 0) + exponent * power
    return Base(value, {base: powers[base] for base in sorted(powers) if powers[base]})


def _named(name: str) -> Base | None:
    """A unit with its prefix."""
    if name in NAMED:
        return Base(*NAMED[name])
    if name[:1] in POWERS_OF_TEN and name[1:] in NAMED and name not in NOT_PREFIXED:
        value, powers = NAMED[name[1:]]
        return Base(value * Fraction(10) ** POWERS_OF_TEN[name[0]], powers)
    return None


def same_dimension(one: str, other: str) -> bool:
    """Whether two units have the same dimension; radians differ from plain numbers."""
    known, expected = base_of(one), base_of(other)
    if known is not None and expected is not None:
        return known.powers == expected.powers
    try:
        return factor(one, other) > 0.0
    except ValueError:
        return False


def _in_base_units(unit: str, symbol: str) -> Any:
    """One `unit` in base units by Pint; radians are distinguished from plain numbers."""
    try:
        one, none = (_registry().Quantity(value, unit).to_base_units() for value in (1.0, 0.0))
    except Exception:  # Pint raises errors of its tokenizer and registry; all of them mean an unknown unit.
        raise ValueError(f"no such unit as {unit!r}; write for example {example(symbol)!r}") from None
    if none.magnitude != 0.0:
        raise ValueError(f"{unit!r} has an offset; write the value in {symbol}")
    return one


def _dimension(quantity: Any) -> str:
    """The dimension of a quantity as text: `length`, `an angle`, `mass / length ** 3`."""
    if quantity.dimensionless:
        return "an angle" if str(quantity.units) == "radian" else "a plain number"
    plain = str(quantity.dimensionality).replace("[", "").replace("]", "")
    return re.sub("^1", "angle", plain) if "radian" in str(quantity.units) else plain


def _snapped(scale: float) -> float:
    """A scale without the rounding errors of Pint's products: 0.001, not 0.0010000000000000002."""
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
    "rad/s": "60 rpm",
    "1/m^2": "100 1/mm^2",
    "1/m^3": "100 1/mL",
    "K": "20 degC",
}


def example(symbol: str) -> str:
    """A value as a user might write it."""
    return EXAMPLES.get(symbol, f"1 {symbol.replace('1/m^', 'm^-')}")


@cache
def _registry() -> Any:
    """Pint's registry, made when the first unit is read: it takes a quarter of a second."""
    import pint

    return pint.UnitRegistry(cache_folder=None)


def in_unit(symbol: str) -> Callable[[type], Any]:
    """Annotate another type with a unit: `in_unit("m")(Array)`."""
    return lambda kind: Annotated[kind, Unit(symbol)]


# For scenes in Python: `3 * mm`. Other units are `Quantity(2, "dyn/cm")`.
m, cm, mm, um, nm, km = (Quantity(1.0, name) for name in ("m", "cm", "mm", "um", "nm", "km"))
s, ms, us, minute, hour = (Quantity(1.0, name) for name in ("s", "ms", "us", "minute", "hour"))
kg, g, mg = (Quantity(1.0, name) for name in ("kg", "g", "mg"))
N, mN, uN, J = (Quantity(1.0, name) for name in ("N", "mN", "uN", "J"))
Pa, kPa, MPa = (Quantity(1.0, name) for name in ("Pa", "kPa", "MPa"))
K, degC, rad, deg, percent = (Quantity(1.0, name) for name in ("K", "degC", "rad", "deg", "%"))

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
AngularVelocity = Annotated[float, Unit("rad/s")]
NumberPerArea = Annotated[float, Unit("1/m^2")]
NumberPerVolume = Annotated[float, Unit("1/m^3")]
Temperature = Annotated[float, Unit("K")]

# The same for functions that also accept arrays.
Lengths = Annotated[Real, Unit("m")]
Forces = Annotated[Real, Unit("N")]
Energies = Annotated[Real, Unit("J")]
Angles = Annotated[Real, Unit("rad")]
Numbers = Annotated[Real, Unit("1")]


PREFIXES = ((9, "G"), (6, "M"), (3, "k"), (0, ""), (-3, "m"), (-6, "µ"), (-9, "n"), (-12, "p"))


FIRST = re.compile(r"(?:A|Hz|J|K|N|Pa|T|V|W|m|rad|s)(?:\^?([23])|([²³]))?(?![A-Za-z0-9^²³])")
"""The first factor of a unit that takes a prefix."""


def prefix_power(unit: str) -> int:
    """The power to which a prefix of this unit is raised; 0 for a unit without prefixes.

    >>> [prefix_power(unit) for unit in ("m/s", "m^2/s", "m³", "kg/m^3", "1/s")]
    [1, 2, 3, 0, 0]
    """
    match = FIRST.match(unit)
    return 0 if match is None else int(match[1] or {"²": 2, "³": 3, None: 1}[match[2]])


def with_prefix(value: float, unit: str, digits: int = 4) -> str:
    """A value with the prefix of its size. The prefix of `m^2/s` is squared; `kg` and `1/s` have none.

    >>> with_prefix(16.64, "m/s"), with_prefix(0.0021, "m"), with_prefix(5e-14, "s"), with_prefix(5536.0, "s")
    ('16.64 m/s', '2.1 mm', '0.05 ps', '5536 s')
    >>> with_prefix(4.3e-13, "m^2/s")
    '0.43 µm^2/s'
    """
    return range_with_prefix([value], unit, digits)


def range_with_prefix(values: Iterable[float], unit: str, digits: int = 4) -> str:
    """The least and the greatest of some values, or the common value, with the prefix of the largest magnitude.

    >>> range_with_prefix([0.002, 0.0004, 0.001], "m"), range_with_prefix([1e-6, 1e-6], "N")
    ('0.4 to 2 mm', '1 µN')
    """
    ordered = sorted(value + 0.0 for value in values)  # converts -0.0 to 0.0
    scale, prefix = _prefix(max(abs(ordered[0]), abs(ordered[-1])), unit, digits)
    low, high = (f"{end / scale:.{digits}g}" for end in (ordered[0], ordered[-1]))
    return f"{low if low == high else f'{low} to {high}'} {prefix}{unit}"


def _prefix(size: float, unit: str, digits: int) -> tuple[float, str]:
    """The factor and the prefix for numbers of this size."""
    order = prefix_power(unit)
    if not size or not math.isfinite(size) or not order:
        return 1.0, ""
    rounded = size * (1.0 + 0.5 * 10.0 ** (1 - digits))
    least = 0.1**order if order > 1 else 1.0  # 0.43 µm^2/s instead of 430,000 nm^2/s
    power, prefix = next((one for one in PREFIXES if rounded >= least * 10.0 ** (order * one[0])), PREFIXES[-1])
    return (1.0, "") if unit == "s" and power > 0 else (10.0 ** (order * power), prefix)


def duration_text(seconds: float) -> str:
    """A duration in the unit that fits.

    >>> duration_text(12.34), duration_text(3000.0), duration_text(36000.0), duration_text(0.0034), duration_text(3e5)
    ('12 s', '50 min', '10 h', '3.4 ms', '3.5 days')
    """
    if seconds < 0.1:
        return f"{1e3 * seconds:.2g} ms"
    for unit, size, below in (("s", 1.0, 100.0), ("min", 60.0, 100.0), ("h", 3600.0, 48.0)):
        if seconds < size * below:
            return f"{seconds / size:.2g} {unit}"
    return f"{seconds / 86400.0:.2g} days"


def size_text(size: float) -> str:
    """A number of bytes in the unit that fits.

    >>> size_text(950.0), size_text(2.35e5), size_text(3.2e9), size_text(4e13)
    ('950 B', '235 kB', '3.2 GB', '40 TB')
    """
    for unit, power in (("B", 0), ("kB", 3), ("MB", 6), ("GB", 9)):
        if size < 0.9995 * 10.0 ** (power + 3):
            return f"{size / 10.0**power:.3g} {unit}"
    return f"{size / 1e12:.3g} TB"
