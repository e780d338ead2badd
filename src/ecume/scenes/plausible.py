"""Remarks on implausible values of a scene: most are wrong units, such as 45 for 45 mN/m.

Values without a unit are taken in SI units and are often wrong; their plausible range is that of everyday matter.
Values with a unit are usually correct; their range contains everything in nature. One table has the ranges of all
models.
"""

from __future__ import annotations

import math
import re
import typing
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from ecume.scenes.faults import Path, written
from ecume.scenes.load import name_liquid
from ecume.scenes.quantities import ByDimension
from ecume.scenes.schema import SCENES, below, item_unit
from ecume.units import Unit, same_dimension, with_prefix

Remark = tuple[str, str, str]
"""The key, its value with unit, and the remark."""


class Range(NamedTuple):
    """The usual values of some keys, in SI units."""

    keys: str
    """a pattern for model and path, `floating liquid.density`"""
    usual: tuple[float, float]
    """the range of plain numbers"""
    possible: tuple[float, float]
    """the range of numbers with a unit"""
    units: tuple[str, ...]
    """the units in which a plain number may be meant, the likeliest first"""
    reference: tuple[float, str] = (0.0, "")
    """a well-known value, and its description"""


LENGTHS = ("mm", "um", "cm", "nm")
WATER_DENSITY, AIR_DENSITY = (998.0, "that of water"), (1.2, "that of air")
TENSION = (0.0728, "that of water")
THIN = 1e-4
"""Viscosity (Pa s) below which a carrier is a gas."""
GAS = Range("", (0.02, 200.0), (1e-4, 1e3), ("g/cm^3", "g/m^3"), AIR_DENSITY)

RANGES = (
    Range(r"\w+ .*(surface_tension|interface_tension|largest_fall)", (5e-4, 0.6), (1e-8, 3.0), ("mN/m",), TENSION),
    Range(r"floating .*largest_pressure", (1e-9, 1.0), (1e-12, 100.0), ("mN/m",), TENSION),
    Range(r"\w+ .*surface_energies\.\w+", (1e-5, 5.0), (1e-8, 20.0), ("mN/m",), TENSION),
    Range(r"floating liquid\.density", (500.0, 2e4), (50.0, 2.5e4), ("g/cm^3", "g/m^3"), WATER_DENSITY),
    Range(r"\w+ liquid\.density", (500.0, 2e4), (0.05, 2.5e4), ("g/cm^3", "g/m^3"), WATER_DENSITY),
    Range(r"\w+ liquid\.gas_density", (GAS.usual[0], 2000.0), (GAS.possible[0], 2e4), GAS.units, AIR_DENSITY),
    Range(r"\w+ liquid\.gas_viscosity", (3e-6, 1.0), (1e-7, 1e12), ("mPa*s", "uPa*s"), (1.8e-5, "that of air")),
    Range(r"(floating|soft|sph) (?!second_).*density", (20.0, 2.5e4), (1.0, 2.5e4), ("g/cm^3", "g/m^3"), WATER_DENSITY),
    Range(r"\w+ .*(density|densities)", (20.0, 2.5e4), (0.05, 2.5e4), ("g/cm^3", "g/m^3"), WATER_DENSITY),
    Range(r"tracers liquid\.viscosity", (3e-6, 0.9), (1e-7, 1e12), ("mPa*s", "uPa*s"), (1e-3, "that of water")),
    Range(r"soft liquid\.viscosity", (1e-5, 200.0), (1e-7, 1e12), ("mPa*s", "uPa*s"), (1e-3, "that of water")),
    Range(r"sph .*largest_viscosity", (1e-3, 1e9), (1e-7, 1e12), ("mPa*s", "kPa*s")),
    Range(r"\w+ .*viscosity", (1e-5, 0.9), (1e-7, 1e12), ("mPa*s", "uPa*s"), (1e-3, "that of water")),
    Range(r"\w+ (second_)?liquid\.temperature", (150.0, 3000.0), (1.0, 1e4), ("degC",)),
    Range(r"\w+ (second_)?liquid\.sound_speed", (1e-3, 5e3), (1e-6, 2e4), ("cm/s", "mm/s"), (1482.0, "that of water")),
    Range(r"\w+ gravity", (0.1, 50.0), (1e-6, 1e5), ("cm/s^2", "mm/s^2"), (9.81, "that of the Earth")),
    Range(
        r"\w+ liquid\.atmospheric_pressure", (2e4, 1e7), (1.0, 1e9), ("kPa", "bar", "hPa"), (101325.0, "that of air"),
    ),
    Range(r"soft films\.cavitation_pressure", (500.0, 1e8), (1e-3, 1e10), ("kPa", "bar", "MPa")),
    Range(r"soft .*modulus", (100.0, 2e12), (1e-3, 2e12), ("kPa", "MPa", "GPa")),
    Range(r"soft .*(debye_length|steric_length)", (1e-10, 1e-4), (1e-11, 1.0), ("nm", "um")),
    Range(r"soft .*smallest_separation", (1e-11, 1e-8), (1e-12, 1.0), ("nm",)),
    Range(r"soft .*hamaker_constant", (1e-22, 1e-17), (1e-24, 1e-10), ("zJ",)),
    Range(r"soft .*(strength|critical_load|force)", (1e-15, 1.0), (1e-18, 1e6), ("uN", "mN", "nN")),
    Range(r"soft .*(pressure|stress)", (1e-9, 1e8), (1e-12, 1e11), ("kPa", "Pa")),
    Range(r"floating (waves|activity)\..*(force|propulsion)", (1e-15, 1e-2), (1e-18, 10.0), ("uN", "mN", "nN")),
    Range(r"floating surfactant\.diffusivity", (1e-13, 0.01), (1e-16, 10.0), ("cm^2/s", "mm^2/s", "um^2/s")),
    Range(r"floating surfactant\.(spacing|.*radius)", (1e-7, 0.1), (1e-9, 10.0), LENGTHS),
    Range(r"floating (surfactant|waves)\..*(position|place)", (1e-9, 1.0), (1e-9, 50.0), LENGTHS),
    Range(r"floating .*(velocity|velocities|\bv[xy])", (1e-12, 0.9), (1e-12, 100.0), ("mm/s", "cm/s", "um/s")),
    Range(r"soft walls\.velocity", (1e-12, 1.0), (1e-12, 100.0), ("mm/s", "um/s")),
    Range(r"sph .*(velocity|velocities|speed)", (1e-12, 20.0), (1e-12, 3e3), ("cm/s", "mm/s")),
    Range(r"sph base_excitation\..*", (1e-12, 60.0), (1e-12, 1e5), ("cm/s^2", "mm/s^2"), (9.81, "that of the Earth")),
    Range(r"floating waves\.frequency", (0.9, 2e4), (1e-3, 1e7), ("kHz",)),
    Range(r"\w+ .*(frequency|rate|rates)", (1e-12, 1e5), (1e-12, 1e9), ("1/hour", "1/minute")),
    Range(r"\w+ .*(frequency|rate|spin|rates)", (1e-12, 500.0), (1e-12, 1e6), ("rpm", "deg/s")),
    Range(r"sph .*mass", (1e-15, 5e4), (1e-18, 1e7), ("g",)),
    Range(r"tracers .*mean_free_path", (1e-11, 1e-3), (1e-12, 1.0), ("nm", "um")),
    Range(r"tracers .*(diffusivities|horizontal)", (1e-13, 1e3), (1e-16, 1e7), ("cm^2/s", "mm^2/s")),
    Range(r"soft .*permeability", (1e-20, 1e-6), (1e-24, 1.0), ("mm^2", "um^2", "nm^2")),
    Range(r"soft particles\.torque", (1e-24, 1e-3), (1e-27, 1e3), ("uN*m", "nN*m")),
    Range(r"floating contacts\.stiffness", (1e-9, 1e7), (1e-12, 1e9), ("mN/m",)),
    Range(r"sph gauges\.diameter", (1e-6, 1.0), (1e-9, 100.0), LENGTHS),
    Range(r"floating surfactant\..*release", (1e-15, 1e-3), (1e-21, 1.0), ("ug/s", "mg/s")),
    Range(r"floating surfactant\..*mass", (1e-15, 1e-3), (1e-21, 1.0), ("ug", "mg")),
    Range(r"floating activity\.torque", (1e-20, 1e-5), (1e-24, 1.0), ("nN*m", "uN*m")),
    Range(r"floating magnetic_field\.(constant|amplitude)", (1e-9, 10.0), (1e-12, 100.0), ("mT", "uT")),
    Range(r"floating .*magnetic_moment", (1e-15, 1.0), (1e-20, 1e3), ("mA*m^2", "uA*m^2")),
    Range(r"\w+ .*(roughness|undulation|minimum_gap)", (1e-10, 0.01), (1e-11, 1.0), ("um", "nm", "mm")),
    Range(r"floating (particles|rows)\.(radius|radii|sizes\.\w+)", (1e-8, 0.1), (1e-9, 0.5), LENGTHS),
    Range(r"soft particles\.(radius|radii|sizes\.\w+)", (1e-8, 0.1), (1e-9, 10.0), LENGTHS),
    Range(r"tracers particles\.(radius|radii|sizes\.\w+)", (1e-8, 0.1), (1e-9, 10.0), ("um", "mm", "nm")),
    Range(r"sph passive_tracers\.radius", (1e-8, 0.1), (1e-9, 10.0), LENGTHS),
    Range(r"floating .*\.(thickness|width)", (1e-8, 0.1), (1e-9, 10.0), LENGTHS),
    Range(
        r"floating (dish|cell|particles|rows)\..*(radius|size|spacing|positions|center|vertices|amplitude|[xy])",
        (1e-9, 1.0), (1e-9, 50.0), ("cm", "mm", "um"),
    ),
    Range(r"floating flow\.nodes\..*", (1e-9, 10.0), (1e-9, 1e4), ("cm", "mm", "um")),
    # Fields may have the size of oceans.
    Range(r"tracers .*\.(low|high|center|vertices|positions|heights)", (1e-12, 1e3), (1e-12, 1e8), LENGTHS),
    Range(r"soft (cell|particles|films|walls|permeation)\..*", (1e-12, 1.0), (1e-12, 1e3), LENGTHS),
    Range(r"tracers particles\..*", (1e-12, 10.0), (1e-12, 1e3), LENGTHS),
    Range(r"sph spacing", (1e-9, 2.0), (1e-9, 100.0), ("mm", "cm", "um")),
    Range(r"sph .*amplitude", (1e-9, 4.0), (1e-9, 100.0), ("mm", "cm", "um")),
    Range(
        r"(sph|tracers|soft) (tank|fluid|obstacles|bodies|gauges|spacing|cell|openings|walls|passive_tracers)\b.*",
        (1e-9, 30.0), (1e-9, 1e3), ("mm", "cm", "um"),
    ),
    Range(r"\w+ .*", (1e-12, 1e3), (1e-12, 1e4), LENGTHS),
)  # fmt: skip
"""The ranges of keys; the first row whose pattern and dimension fit is used."""

SPEEDS = Range("", (1e-12, 100.0), (1e-12, 3e3), ("mm/s", "cm/s", "um/s"))
ANGLES = Range("", (0.0, 2.0 * math.pi), (0.0, 1e3), ("deg",))
TIMES = Range("", (1e-12, 1e6), (1e-15, 1e10), ("ms", "us"))
ACCELERATIONS = Range("", (1e-12, 500.0), (1e-12, 1e5), ("cm/s^2", "mm/s^2"), (9.81, "the gravity of the Earth"))
OF_UNITS = {"m/s": SPEEDS, "rad": ANGLES, "s": TIMES, "m/s^2": ACCELERATIONS}
"""The ranges of keys without a row, by their unit."""


def range_of(model: str, path: Path, unit: str) -> Range | None:
    """The usual values of a key."""
    name = f"{model} {'.'.join(key for key in path if isinstance(key, str))}"
    for row in RANGES:
        if re.fullmatch(row.keys, name) and _same_dimension(row.units[0], unit):
            return row
    return OF_UNITS.get(unit)


def _same_dimension(one: str, unit: str) -> bool:
    if one == "degC" or unit == "K":
        return (one, unit) == ("degC", "K")
    return same_dimension(one, unit)


def remarks(raw: Mapping[str, Any]) -> list[Remark]:
    """The implausible values of a scene file's plain data, in order; for a list, the largest number counts."""
    plain = dict(raw)
    name_liquid(plain)
    model = str(plain.get("model"))
    return list(_below(model, plain, SCENES[model], ())) if model in SCENES else []


def _below(model: str, value: Any, kind: Any, path: Path, unit: str = "") -> Iterator[Remark]:
    either = _by_dimension(kind)
    unit = item_unit(kind) or (either.space if either else unit)
    if isinstance(value, Mapping):
        yield from _shaking(value, kind, path)
        for key, item in value.items():
            if not _is_proportion(value, key):
                gas = model == "tracers" and path == ("liquid",) and key == "density" and _is_gas(value)
                yield from _below("gas" if gas else model, item, below(kind, key), (*path, key))
    elif isinstance(value, list) and value and isinstance(value[0], Mapping):
        for index, item in enumerate(value):
            yield from _below(model, item, below(kind, index), (*path, index))
    elif unit not in ("", "1") and (found := _largest(value, unit)) is not None:
        row = GAS if model == "gas" else range_of(model, path, unit)
        message = "" if row is None else _oddity(row, found, unit)
        if message:
            plane = f" ({either.plane} in 2D)" if either else ""
            yield written(path), f"{found.value:.6g} {unit}{plane}", message


def _by_dimension(kind: Any) -> ByDimension | None:
    """The mark of a number whose unit depends on the dimension of the scene; None for others."""
    marks = (part if isinstance(part, ByDimension) else _by_dimension(part) for part in typing.get_args(kind))
    return next((mark for mark in marks if mark is not None), None)


VIOLENT = 50.0
"""Peak acceleration (m/s^2) above which the frequency of a motion is probably that of a minute."""


def _shaking(table: Mapping[str, Any], kind: Any, path: Path) -> Iterator[Remark]:
    """Yield the remark on an oscillation of a wall, a body or a dish that is too violent for a frequency without a
    unit.
    """
    if item_unit(below(kind, "amplitude")) != "m" or item_unit(below(kind, "frequency")) != "1/s":
        return
    amplitude, frequency = _largest(table.get("amplitude"), "m"), _largest(table.get("frequency"), "1/s")
    if amplitude is None or frequency is None or frequency.stated:
        return
    peak = abs(amplitude.value) * (2.0 * math.pi * frequency.value) ** 2
    if peak > VIOLENT:
        meant = (
            f"a peak acceleration of {_round(peak / 9.81)} g; plain numbers are in Hz: {frequency.value:g} 1/minute?"
        )
        yield written((*path, "frequency")), f"{frequency.value:.6g} Hz", meant


def _is_proportion(table: Mapping[str, Any], key: str) -> bool:
    """Whether a length matters only as a ratio, since a covered or filled fraction scales it."""
    return key == "size" and bool({"volume_fraction", "area_fraction", "coverage"} & set(table))


def _is_gas(liquid: Mapping[str, Any]) -> bool:
    """Whether the liquid that carries tracers has the viscosity of a gas."""
    found = _largest(liquid.get("viscosity"), "Pa*s")
    return found is not None and found.value < THIN


class Given(NamedTuple):
    """A number in SI units, and whether it was given with a unit."""

    value: float
    stated: bool


def _largest(value: Any, unit: str) -> Given | None:
    """The number of a key, or the largest one of a list; plain numbers precede those with units.
    None without a number.
    """
    if isinstance(value, (list, tuple)):
        found = [one for item in value if (one := _largest(item, unit)) is not None]
        return max(found, key=lambda one: (not one.stated, abs(one.value)), default=None)
    try:
        size = Unit(unit).number(value)
    # A name instead of a number, such as that of a closure relation, or a fault of the scene.
    except (TypeError, ValueError):
        return None
    return Given(size, isinstance(value, str)) if math.isfinite(size) else None


def _oddity(row: Range, found: Given, unit: str) -> str:
    """The remark on an implausible number, and the unit that may be meant; empty for a plausible one."""
    low, high = row.possible if found.stated else row.usual
    size = abs(found.value)
    if low <= size <= high or (size == 0.0 and unit != "K"):
        return ""
    known, whose = row.reference
    if known:
        text = f"{_round(size / known)} times {whose}"
    elif unit == "K":
        text = f"{found.value - 273.15:.4g} degrees Celsius"
    else:
        text = f"more than {with_prefix(high, unit)}" if size > high else f"less than {with_prefix(low, unit)}"
    meant = next((one for one in row.units if low <= abs(_in_si(size, one, unit)) <= high), "")
    plain = "plain numbers are in SI units" if not found.stated else "unusual for matter"
    question = f"{found.value:g} {meant}?" if meant and not found.stated else "is the unit right?"
    return f"{text}; {plain}: {question}"


def _in_si(number: float, one: str, unit: str) -> float:
    return Unit(unit).number(f"{number!r} {one}")


def _round(ratio: float) -> str:
    """The number with one or two digits: 600, 0.0003.

    >>> _round(618.1), _round(2.63), _round(0.00030060)
    ('600', '2.6', '0.0003')
    """
    digits = 1 if ratio >= 10.0 or ratio < 0.1 else 2
    return f"{float(f'{ratio:.{digits}g}'):.12g}"
