"""The pair law of a scene: its constants, and the errors for options that it cannot be combined with."""

from __future__ import annotations

from typing import Any

import numpy as np

from ecume.errors import Fault, SceneError
from ecume.laws.pair_laws import CAPABILITIES, PAIR_LAWS, PairLaw
from ecume.models.floating.parameters import CAPILLARY_LENGTH, OWN, SURFACE_TENSION, PairParameters, Parameters

NAMES = tuple(PAIR_LAWS)


def row_of(parameters: Parameters) -> PairLaw:
    """The row of the scene's pair law in the table."""
    return PAIR_LAWS[NAMES[parameters.pair_law]]


def law_of(parameters: Parameters) -> Any:
    """The constants of the scene's pair law, in double precision."""
    row = row_of(parameters)
    return row.constants(*map(float, parameters.pair[OWN:]))


def law_in_precision(parameters: Parameters, law: Any) -> Any:
    """These constants in the precision of the sum over pairs. Their type selects the compiled code of the law."""
    return type(law)(*map(np.float32, law)) if parameters.single else law


def summed_law(parameters: Parameters) -> Any:
    """The constants of the scene's pair law, in the precision of the sum over pairs."""
    return law_in_precision(parameters, law_of(parameters))


def two_floats(parameters: Parameters, radius: tuple[float, float], charge: tuple[float, float]) -> PairParameters:
    """Two floats in the liquid of the scene, as pair laws see them."""
    length, tension = float(parameters.pair[CAPILLARY_LENGTH]), float(parameters.pair[SURFACE_TENSION])
    return PairParameters(*radius, *charge, length, tension)


def lacks(parameters: Parameters, capability: str) -> str:
    """The requirement that the scene's pair law does not meet, for an error message; empty if it has the capability."""
    if getattr(row_of(parameters), capability):
        return ""
    fit = ", ".join(repr(name) for name, row in PAIR_LAWS.items() if getattr(row, capability))
    return (
        f"a pair law that {CAPABILITIES[capability]}: got interaction.law = {NAMES[parameters.pair_law]!r}; "
        f"expected one of {fit}"
    )


def require(parameters: Parameters, path: str, what: str, capability: str) -> None:
    """Raise SceneError if the scene's pair law lacks a capability that an option needs."""
    if missing := lacks(parameters, capability):
        raise SceneError([Fault(path, f"{what} needs {missing}")])
