"""What a law may be asked: arguments are checked here, and what is refused is refused with its value and the way
out.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from typing import Any, ParamSpec, TypeVar

import numpy as np

from ecume.errors import BadInput
from ecume.units import Array, Lengths, Real

LEAST_BOND_NUMBER = 1e-20
"""A radius of 1e-10 capillary lengths: less than an atom's."""
LARGEST_BOND_NUMBER = 1e3
SMALLEST = 5e-324
"""The least distance that is not zero: two centers in one place have neither an energy nor a direction."""
Row = TypeVar("Row")
Given = ParamSpec("Given")


def require_positive(name: str, value: float, hint: str = "expected a positive number") -> None:
    """Refuse what is not a positive, finite number."""
    if not (value > 0.0 and math.isfinite(value)):
        raise BadInput(f"the {name} is {value!r}; {hint}")


def require_not_negative(name: str, value: float) -> None:
    """Refuse what is negative or not finite."""
    if not (value >= 0.0 and math.isfinite(value)):
        raise BadInput(f"the {name} is {value!r}; expected zero or a positive number")


def require_finite(name: str, value: float) -> None:
    """Refuse what is infinite or no number."""
    if not math.isfinite(value):
        raise BadInput(f"the {name} is {value!r}; expected a finite number")


def require_angle(name: str, value: float) -> None:
    """Refuse what is no contact angle."""
    if not 0.0 <= value <= math.pi:
        hint = f"; did you mean {value:g} degrees, {math.radians(value):.4g} rad?" if math.pi < value <= 180.0 else ""
        raise BadInput(f"the {name} is {value!r}; expected radians between 0 and pi{hint}")


def require_numbers(bond_number: float, density_ratio: float, contact_angle: float) -> None:
    """Refuse pure numbers that describe no floater."""
    require_positive("bond number", bond_number)
    if bond_number > LARGEST_BOND_NUMBER:
        raise BadInput(
            f"the bond number is {bond_number:g}: a radius of {math.sqrt(bond_number):.0f} capillary lengths; "
            f"these laws are for floaters up to {LARGEST_BOND_NUMBER:g}; plain numbers are SI: "
            "is the radius one in meters?"
        )
    if bond_number < LEAST_BOND_NUMBER:
        raise BadInput(
            f"the bond number is {bond_number:g}: a radius of {math.sqrt(bond_number):.1e} capillary lengths "
            "is less than an atom's; expected a larger one"
        )
    if not math.isfinite(density_ratio):
        raise BadInput(f"the density ratio is {density_ratio!r}; expected a finite number")
    require_angle("contact_angle", contact_angle)


def chosen(table: Mapping[str, Row], name: str, what: str) -> Row:
    """The row of a table of laws, or a BadInput that says which there are."""
    if name not in table:
        raise BadInput(f"no {what} is called {name!r}; there are {', '.join(table)}")
    return table[name]


def as_distances(name: str, value: Lengths, least: float = 0.0) -> Array:
    """Distances as an array, refused below `least`."""
    distances = np.asarray(value, dtype=np.float64)
    if not bool(np.all((distances >= least) & np.isfinite(distances))):
        expected = "zero or more" if least == 0.0 else "positive numbers"
        raise BadInput(f"{name} is {value!r}; expected {expected}, in meters")
    return distances


def each_element(law: Callable[Given, float]) -> Callable[Given, float]:
    """A law of single numbers that takes arrays as well, broadcast against one another, and then gives one back."""
    single: Any = law

    @functools.wraps(law)
    def over(*given: Given.args, **named: Given.kwargs) -> Any:
        every: list[Any] = [*given, *named.values()]
        spread = [place for place, value in enumerate(every) if isinstance(value, (np.ndarray, list, tuple))]
        if not spread:
            return law(*given, **named)
        found = []
        arrays = np.broadcast_arrays(*(every[place] for place in spread))
        for numbers in zip(*(array.ravel().tolist() for array in arrays), strict=True):
            for place, number in zip(spread, numbers, strict=True):
                every[place] = number
            found.append(single(*every[: len(given)], **dict(zip(named, every[len(given) :], strict=True))))
        return np.reshape(np.array(found), arrays[0].shape)

    return over


def as_given(values: Array) -> Real:
    """A float for a float, an array for an array."""
    return float(values) if np.ndim(values) == 0 else values
