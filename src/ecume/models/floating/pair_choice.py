"""The pair law of a scene: its constants, and the errors for options that it cannot be combined with."""

from __future__ import annotations

from typing import Any

import numpy as np

from ecume.laws import pair_laws
from ecume.laws.pair_laws import CAPABILITIES, PAIR_LAWS, PairLaw
from ecume.models.floating.options import Option
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


def row_of_law(law: Any) -> PairLaw:
    """The row of these constants, be they those of a scene or of a part of it."""
    return pair_laws.row_of(type(law))


def in_double(law: Any, parameters: Parameters) -> Any:
    """The constants in double precision: those of the scene's law as they were derived."""
    return type(law)(*law_of(parameters)) if parameters.single else law


def pair_option(name: str) -> Option:
    """The pair law of this name, with its capabilities."""
    row = PAIR_LAWS[name]
    gives = frozenset(capability for capability in CAPABILITIES if getattr(row, capability))
    charges = {"charges"} if row.menisci or not row.has_force else set()
    return Option(slot="pair law", path="interaction.law", name=repr(name), gives=gives | charges)
