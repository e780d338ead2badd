"""User pair laws for soft spheres: normal forces between surfaces as functions of the gap.

User laws are added to the long-range force of the scene between spheres, but not at walls. Compiled loops interpolate
in tables, one for each pair of species, so that compiled code does not depend on the user's code.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecume._portable import exp, log
from ecume.errors import BadInput
from ecume.models.model import Model
from ecume.models.soft.contacts.user_forces import INTERVALS, Tables, log_gaps, table_of
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.preparation import unprepared
from ecume.models.soft.report.check_report import advice
from ecume.models.user_laws import PAIR, BoundLaw, compiled_for_laws, masks_of, require_force, require_kinds
from ecume.scenes.soft import SoftScene
from ecume.units import Array, with_prefix

NARROWEST, WIDEST = 1e-10, 1e4
"""Ends of the tables: in radii of the smallest sphere, and of the largest one if films have no cutoff."""
TESTED = (1e-6, 1e-3, 1.0)
"""The gaps at which laws are tested, in radii of the smallest sphere."""


class SpherePair(NamedTuple):
    """The properties of the two spheres of a pair that user laws receive, in addition to the gap."""

    radius_i: float
    radius_j: float
    modulus_i: float
    modulus_j: float
    constants: tuple[float, ...]


def extended(model: Model, laws: Sequence[BoundLaw]) -> Model:
    """The soft model with user laws. Raises BadInput for unsuitable functions."""
    require_kinds("soft", laws, [PAIR])

    def parameters_of(scene: SoftScene) -> Parameters:
        parameters: Parameters = model.parameters(scene)
        return parameters._replace(user_forces=tables_of(laws, scene, parameters))

    def summary(scene: SoftScene) -> list[tuple[str, str, str]]:
        parameters = parameters_of(scene)
        return advice(scene, parameters, unprepared(scene, parameters))

    return dataclasses.replace(model, parameters=parameters_of, summary=summary)


def tables_of(laws: Sequence[BoundLaw], scene: SoftScene, parameters: Parameters) -> Tables:
    """The sum of the laws of each pair of species, tabulated over ln(gap)."""
    count = len(scene.particles)
    masks, row = masks_of(laws, count), np.full((count, count), -1)
    first = np.array([np.flatnonzero(parameters.species == kind)[0] for kind in range(count)])
    ends, values = _ends(parameters), list[Array]()
    for one in range(count):
        for other in range(one, count):
            chosen = [law for bit, law in enumerate(laws) if masks[one, other] >> bit & 1]
            if not chosen:
                continue
            pair = SpherePair(
                float(parameters.radius[first[one]]), float(parameters.radius[first[other]]),
                float(parameters.modulus[first[one]]), float(parameters.modulus[first[other]]), (),
            )  # fmt: skip
            row[one, other] = row[other, one] = len(values)
            force = np.sum([_forces(law, pair, ends, parameters) for law in chosen], axis=0)
            values.append(table_of(force, ends))
    return Tables(row, ends, np.array(values).reshape(-1, INTERVALS + 1, 3))


def _ends(parameters: Parameters) -> Array:
    """The first ln(gap) of tables, and the spacing of their nodes."""
    low = NARROWEST * float(parameters.radius.min())
    high = min(parameters.contacts.fade_to, WIDEST * float(parameters.radius.max()))
    begin, end = (float(log(np.float64(gap))) for gap in (low, high))
    return np.array([begin, (end - begin) / INTERVALS])


def _forces(law: BoundLaw, pair: SpherePair, ends: Array, parameters: Parameters) -> Array:
    """The force of a law at the gaps of a table (N). Raises BadInput where it is not finite, or differs between the
    spheres of a pair.
    """
    given = pair._replace(constants=law.constants)
    swapped = SpherePair(pair.radius_j, pair.radius_i, pair.modulus_j, pair.modulus_i, law.constants)
    require_force(law, [part * float(parameters.radius.min()) for part in TESTED], given, swapped)
    function, gaps = compiled_for_laws(law.function), exp(log_gaps(ends, 2))
    force = np.array([_number(function, float(gap), given) for gap in gaps])
    bad = np.flatnonzero(~np.isfinite(force))
    if len(bad):
        where = with_prefix(float(gaps[bad[-1]]), "m", 3)
        raise BadInput(
            f"extra_laws: {law.name}: got {force[bad[-1]]} at a gap of {where}; expected a finite force in N between "
            f"gaps of {with_prefix(float(gaps[0]), 'm', 3)} and {with_prefix(float(gaps[-1]), 'm', 3)}"
        )
    return force


def _number(function: object, gap: float, given: SpherePair) -> float:
    """A law at one gap; NaN where it raises an arithmetic error."""
    try:
        return float(function(gap, given))  # type: ignore[operator]
    except ArithmeticError:
        return math.nan
