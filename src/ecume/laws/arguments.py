"""Checks of the arguments of laws: a refused value is reported with the accepted range."""

from __future__ import annotations

import functools
import inspect
import math
import sys
from collections.abc import Callable, Mapping
from numbers import Real as RealNumber
from typing import Any, ParamSpec, TypeVar

import numpy as np

from ecume.errors import BadInput
from ecume.units import Array, Lengths, Real

LEAST_BOND_NUMBER = 1e-20
"""A radius of 1e-10 capillary lengths: less than an atom's."""
LARGEST_BOND_NUMBER = 1e3
SMALLEST = 5e-324
"""The smallest positive float: two centers at the same place have neither an energy nor a direction."""
MOST = sys.float_info.max
"""The largest float."""
Row = TypeVar("Row")
Given = ParamSpec("Given")


def require_number(name: str, value: float) -> None:
    """Raise BadInput unless the value is a single real number; booleans, and integers beyond the range of floats, are
    refused.
    """
    if isinstance(value, bool) or not isinstance(value, RealNumber):
        raise BadInput(f"the {name} is {value!r}; expected a number")
    if isinstance(value, int) and abs(value) > MOST:
        raise BadInput(f"the {name} is an integer of {len(str(abs(value)))} digits; expected less than {MOST:.0e}")


def require_positive(name: str, value: float, hint: str = "expected a positive number") -> None:
    """Raise BadInput unless the value is positive and finite."""
    require_number(name, value)
    if not (value > 0.0 and math.isfinite(value)):
        raise BadInput(f"the {name} is {value!r}; {hint}")


def require_not_negative(name: str, value: float) -> None:
    """Raise BadInput unless the value is zero or positive, and finite."""
    require_number(name, value)
    if not (value >= 0.0 and math.isfinite(value)):
        raise BadInput(f"the {name} is {value!r}; expected zero or a positive number")


def require_finite(name: str, value: float) -> None:
    """Raise BadInput unless the value is finite."""
    require_number(name, value)
    if not math.isfinite(value):
        raise BadInput(f"the {name} is {value!r}; expected a finite number")


def require_angle(name: str, value: float) -> None:
    """Raise BadInput unless the value is a contact angle."""
    require_number(name, value)
    if not 0.0 <= value <= math.pi:
        hint = f"; did you mean {value:g} degrees, {math.radians(value):.4g} rad?" if math.pi < value <= 180.0 else ""
        raise BadInput(f"the {name} is {value!r}; expected radians between 0 and pi{hint}")


def require_bond_number(name: str, value: float) -> None:
    """Raise BadInput for the Bond number of a float that no surface can carry or that is smaller than an atom."""
    require_positive(name, value)
    if value > LARGEST_BOND_NUMBER:
        raise BadInput(
            f"the {name} is {value:g}: a radius of {math.sqrt(value):.3g} capillary lengths; "
            f"these laws are for floats up to {LARGEST_BOND_NUMBER:g}; plain numbers are SI: "
            "is the radius one in meters?"
        )
    if value < LEAST_BOND_NUMBER:
        raise BadInput(
            f"the {name} is {value:g}: a radius of {math.sqrt(value):.1e} capillary lengths "
            "is less than an atom's; expected a larger one"
        )


Check = tuple[str, Callable[[str, float], None]]
CHECKS: dict[str, Check] = {
    "bond_number": ("bond number", require_bond_number),
    "density_ratio": ("density ratio", require_finite),
    "contact_angle": ("contact_angle", require_angle),
    "gap": ("gap", require_not_negative),
    "excess": ("excess", require_not_negative),
}
"""The name in messages and the check of each dimensionless argument, by its name."""


def require_numbers(bond_number: float, density_ratio: float, contact_angle: float) -> None:
    """Raise BadInput for dimensionless numbers that do not describe a float."""
    for argument, value in (
        ("bond_number", bond_number),
        ("density_ratio", density_ratio),
        ("contact_angle", contact_angle),
    ):
        name, check = CHECKS[argument]
        check(name, value)


def chosen(table: Mapping[str, Row], name: str, what: str) -> Row:
    """The row of a table of laws. Raises BadInput with the known names for an unknown one."""
    if name not in table:
        raise BadInput(f"no {what} is called {name!r}; there are {', '.join(table)}")
    return table[name]


def as_distances(name: str, value: Lengths, least: float = 0.0) -> Array:
    """Distances as an array. Raises BadInput for values below `least`."""
    expected = f"{'zero or more' if least == 0.0 else 'positive numbers'}, in meters"
    try:
        distances = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise BadInput(f"{name} is {value!r}; expected {expected}") from None
    if not bool(np.all((distances >= least) & np.isfinite(distances))):
        raise BadInput(f"{name} is {value!r}; expected {expected}")
    return distances


def elementwise(law: Callable[Given, Row]) -> Callable[Given, Row]:
    """Wrap a law of single numbers so that it also takes arrays, which are broadcast, and checks dimensionless
    arguments by their names (`CHECKS`). A result of several numbers becomes one of several arrays.
    """
    single: Any = law
    signature = inspect.signature(law)
    checks = [CHECKS.get(name) for name in signature.parameters]

    @functools.wraps(law)
    def checked(*given: Given.args, **named: Given.kwargs) -> Any:
        values = list(signature.bind(*given, **named).args)
        spread = [place for place, value in enumerate(values) if isinstance(value, (np.ndarray, list, tuple))]
        if not spread:
            return _checked(single, checks, values)
        found, arrays = [], _broadcast([values[place] for place in spread])
        for numbers in zip(*(array.ravel().tolist() for array in arrays), strict=True):
            for place, number in zip(spread, numbers, strict=True):
                values[place] = number
            found.append(_checked(single, checks, values))
        shape = arrays[0].shape
        if found and isinstance(found[0], tuple):
            kind: Any = type(found[0])
            return kind(*(np.reshape(column, shape) for column in zip(*found, strict=True)))
        return np.reshape(np.array(found, dtype=np.float64), shape)

    return checked


def _checked(law: Any, checks: list[Check | None], values: list[Any]) -> Any:
    for place, (found, value) in enumerate(zip(checks, values, strict=True)):
        if found is not None:
            name, check = found
            check(name, value)
            values[place] = float(value)
    return law(*values)


def _broadcast(values: list[Any]) -> list[Array]:
    try:
        return list(np.broadcast_arrays(*(np.asarray(value, dtype=np.float64) for value in values)))
    except (TypeError, ValueError):
        raise BadInput(f"got {', '.join(map(repr, values))}; expected numbers, or arrays of one shape") from None


def as_given(values: Array) -> Real:
    """The values as a float for a single number, otherwise as an array."""
    return float(values) if np.ndim(values) == 0 else values
