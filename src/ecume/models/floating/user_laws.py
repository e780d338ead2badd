"""Pair laws of the user, compiled into the simulation together with the pair law of the scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ecume._jit import compiled_once, of_this_process
from ecume.errors import BadInput
from ecume.laws.pair_laws import add_row, row_of
from ecume.models.floating.forces.pair_forces import LEAST_DISTANCE, Superposed, pull_by_force
from ecume.models.floating.options import Option
from ecume.models.floating.parameters import PairParameters, Parameters
from ecume.models.floating.setup.scene_parameters import faults_with
from ecume.models.floating.state import State, Workspace
from ecume.models.floating.time_integration.integration import advance_with

ROUNDING = 1e-12
"""Tolerated relative change of a force when i and j are exchanged: rounding only."""


def advance_extended(extra_laws: Sequence[Callable[..., float]]) -> Callable[..., int]:
    """Return `advance` with pair laws of the user, whose compilation takes seconds per process.

    A law is a function (distance, parameters) -> force (N, positive repels) of a `PairParameters`, the same when i and
    j are swapped. It acts up to the scene's cutoff. Raises BadInput for what is no such law.
    """
    for law in extra_laws:
        _require_force(law)
    return _advance_with_extra(tuple(extra_laws))


DISTANCES = (3.2e-3, 5e-3, 2e-2)
"""m: distances at which user laws are tested."""


def _require_force(law: Callable[..., float]) -> None:
    """Test a user law with two typical spheres, so that faults are reported before the time step is compiled."""
    own = PairParameters(1e-3, 2e-3, 1e-4, -3e-5, 2.7e-3, 0.07)
    seen_from_j = PairParameters(2e-3, 1e-3, -3e-5, 1e-4, 2.7e-3, 0.07)
    try:
        compiled: Callable[..., object] = compiled_once(law)
        forces = [(compiled(distance, own), compiled(distance, seen_from_j)) for distance in DISTANCES]
    except Exception as error:  # a user's function may raise anything, and so may its compilation
        said = [line for line in str(error).splitlines() if line.strip() and not line.startswith("Failed in nopython")]
        why = said[0].strip() if said else type(error).__name__
        raise BadInput(
            f"extra_laws: {_named(law)}: cannot be used: {why}; expected a plain function (distance, parameters) -> "
            "force, of numbers and the functions of math"
        ) from error
    for distance, (one, other) in zip(DISTANCES, forces, strict=True):
        _require_action_and_reaction(_named(law), distance, one, other)


def _require_action_and_reaction(name: str, distance: float, one: object, other: object) -> None:
    """Require that the force is a number, and the same if i and j are exchanged."""
    for force in (one, other):
        if isinstance(force, bool) or not isinstance(force, (int, float)) or not math.isfinite(force):
            raise BadInput(f"extra_laws: {name}: got {force!r} at {distance:g} m; expected a force in N")
    assert isinstance(one, (int, float))  # noqa: S101  # for the type checker: the loop has seen to it
    assert isinstance(other, (int, float))  # noqa: S101
    if abs(one - other) > ROUNDING * max(abs(one), abs(other)):
        raise BadInput(
            f"extra_laws: {name}: at {distance:g} m, got forces of {one:.4g} N and "
            f"{other:.4g} N on two unequal floats, which would create momentum; expected a force that is "
            "the same if i and j are exchanged, such as one of radius_i * radius_j"
        )


def _named(law: object) -> str:
    return str(getattr(law, "__name__", repr(law)))


def _advance_with_extra(laws: tuple[Callable[..., float], ...]) -> Callable[..., int]:
    """Return `advance` with the sum of the laws added to the pair law of the scene."""
    extra = _no_law
    for law in laws:
        extra = _sum_of(compiled_once(law), extra)
    known: dict[type, type] = {}

    def advance(parameters: Parameters, state: State, scratch: Workspace, steps: int) -> int:
        _require_pair_sums(parameters)
        base, *others = parameters.parts.interactions
        constants = known.setdefault(type(base.law), _extended(type(base.law), extra))
        parts = parameters.parts._replace(interactions=(Superposed(constants(*base.law)), *others))
        return advance_with(parts, parameters, state, scratch, steps)

    return advance


def _extended(constants: type, extra: Callable[..., float]) -> Any:
    """Return the type of constants that selects a pair law plus the user laws in compiled code."""
    row = row_of(constants)
    alone = compiled_once(row.pull or pull_by_force)

    def pull(square: float, own: PairParameters, law: Any) -> float:
        distance = max(math.sqrt(square), LEAST_DISTANCE)
        return alone(square, own, law) - extra(distance, own) / distance

    both = of_this_process(constants.__name__, constants._fields)  # type: ignore[attr-defined]  # a NamedTuple's
    # Without threads, since compiling the parallel loop takes several seconds longer.
    add_row(row._replace(constants=both, pull=pull, needs_radii=True, threaded=False))
    return both


EXTRA_LAWS = Option(
    slot="extra laws", path="extra_laws", name="a user law",
    needs={
        "reciprocal": "its sum counts each pair once",
        "pair sum": "it is added to the pair law, as far as lists of neighbors reach",
    },
)  # fmt: skip


def _require_pair_sums(parameters: Parameters) -> None:
    """Raise BadInput for scenes whose forces are not a sum over pairs of floats."""
    if faults := faults_with(EXTRA_LAWS, parameters):
        raise BadInput("; ".join(str(fault) for fault in faults))
    periods = parameters.periods[0]
    if np.any(periods) and 2.0 * parameters.cutoff > periods.min():
        raise BadInput(
            f"extra_laws: a user law acts up to the cutoff, {parameters.cutoff:.4g} m, beyond the nearest images in "
            f"the cell; expected sides of at least {2.0 * parameters.cutoff:.4g} m, or a larger interaction.accuracy"
        )
    if parameters.single:
        raise BadInput("extra_laws: got interaction.precision = 'single'; expected 'double'")


@compiled_once
def _no_law(distance: float, own: PairParameters) -> float:
    return 0.0


def _sum_of(one: Callable[..., float], other: Callable[..., float]) -> Callable[..., float]:
    @compiled_once
    def both(distance: float, own: PairParameters) -> float:
        return one(distance, own) + other(distance, own)

    return both
