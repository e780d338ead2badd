"""The march with a user's own pair laws compiled into it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from ecume._jit import compiled_once
from ecume.errors import BadInput
from ecume.models.floating.forces import Screened, forces_with, screened_of, screened_pull
from ecume.models.floating.parameters import ONE_SIDED, RARE, PairParameters, Parameters
from ecume.models.floating.pulling import pull_pairs_with
from ecume.models.floating.schemes import predict, predict_rarely_with
from ecume.models.floating.state import State, Workspace
from ecume.models.floating.stepping import march_with

LEAST_DISTANCE = 1e-300
ROUNDING = 1e-12
"""By how much of itself a force may change when i and j are swapped: sums in another order, no more."""


def advance_extended(extra_laws: Sequence[Callable[..., float]]) -> Callable[..., int]:
    """The `advance` of floats with a user's own pair laws compiled into it, which takes seconds a process.

    A law is a function (distance, parameters) -> force (N, positive repels) of a `PairParameters`, the same when i and
    j are swapped. It acts up to the scene's cutoff. Raises BadInput for what is no such law.
    """
    for law in extra_laws:
        _require_force(law)
    return _advance_with_extra(tuple(extra_laws))


DISTANCES = (3.2e-3, 5e-3, 2e-2)
"""At which laws are tried, m."""


def _require_force(law: Callable[..., float]) -> None:
    """Try a user's law on two likely spheres: what is wrong with it is told before the march is compiled around it."""
    own = PairParameters(1e-3, 2e-3, 1e-4, -3e-5, 2.7e-3, 0.07)
    seen_from_j = PairParameters(2e-3, 1e-3, -3e-5, 1e-4, 2.7e-3, 0.07)
    try:
        compiled: Callable[..., object] = compiled_once(law)
        forces = [(compiled(distance, own), compiled(distance, seen_from_j)) for distance in DISTANCES]
    except Exception as error:  # a user's function may raise anything, and so may its compilation
        said = [line for line in str(error).splitlines() if line.strip() and not line.startswith("Failed in nopython")]
        why = said[0].strip() if said else type(error).__name__
        raise BadInput(
            f"extra_laws: {_named(law)}: cannot be used: {why}; wanted a plain function (distance, parameters) -> "
            "force, of numbers and the functions of math"
        ) from error
    for distance, (one, other) in zip(DISTANCES, forces, strict=True):
        _require_action_and_reaction(_named(law), distance, one, other)


def _require_action_and_reaction(name: str, distance: float, one: object, other: object) -> None:
    """What i does to j, j does to i: the force is a number, and the same whoever of the two is called i."""
    for force in (one, other):
        if isinstance(force, bool) or not isinstance(force, (int, float)) or not math.isfinite(force):
            raise BadInput(f"extra_laws: {name}: came {force!r} at {distance:g} m; wanted a force in N")
    assert isinstance(one, (int, float))  # noqa: S101  # for the type checker: the loop has seen to it
    assert isinstance(other, (int, float))  # noqa: S101
    if abs(one - other) > ROUNDING * max(abs(one), abs(other)):
        raise BadInput(
            f"extra_laws: {name}: {distance:g} m apart, two unlike floats push each other with {one:.4g} N and with "
            f"{other:.4g} N, which would create momentum; wanted a force that stays the same when i and j are swapped, "
            "such as one of radius_i * radius_j"
        )


def _named(law: object) -> str:
    return str(getattr(law, "__name__", repr(law)))


def _advance_with_extra(laws: tuple[Callable[..., float], ...]) -> Callable[..., int]:
    """The march with the laws' sum compiled in. A function a law: a tuple of functions is no value for compiled
    code.
    """
    extra = _no_law
    for law in laws:
        extra = _sum_of(compiled_once(law), extra)

    @compiled_once
    def extended_pull(square: float, own: PairParameters, law: Screened) -> float:
        distance = max(math.sqrt(square), LEAST_DISTANCE)
        return screened_pull(square, own, law) - extra(distance, own) / distance

    @compiled_once
    def pull(rows: Any, floats: Any, pair: Any, force: Any) -> None:
        force[:] = 0.0
        pull_pairs_with(extended_pull, screened_of, (0, force.shape[1]), rows, floats, pair, (force[0], force[1]))

    @compiled_once
    def forces(parameters: Any, position: Any, lists: Any, scratch: Any) -> None:
        forces_with(pull, parameters, position, lists, scratch)

    @compiled_once
    def predict_rarely(parameters: Any, state: Any, scratch: Any) -> None:
        predict_rarely_with(forces, parameters, state, scratch)

    @compiled_once
    def march(parameters: Any, state: Any, scratch: Any, steps: int) -> int:
        return march_with(predict, forces, parameters, state, scratch, steps)

    @compiled_once
    def march_rarely(parameters: Any, state: Any, scratch: Any, steps: int) -> int:
        return march_with(predict_rarely, forces, parameters, state, scratch, steps)

    def advance(parameters: Parameters, state: State, scratch: Workspace, steps: int) -> int:
        _require_pair_forces(parameters)
        return (march_rarely if parameters.scheme in RARE else march)(parameters, state, scratch, steps)

    return advance


def _require_pair_forces(parameters: Parameters) -> None:
    """Refuse scenes whose march is another one than that which the laws are compiled into."""
    if parameters.pair_law == ONE_SIDED:
        raise BadInput("extra_laws do not go with interaction.law = 'one-sided-legacy'; take 'capillary' or 'none'")
    if parameters.many != ():
        raise BadInput(
            "extra_laws do not go with interaction.method = 'multipole' or 'pair-corrected', with interaction.sum = "
            "'grid' or with dipoles, whose marches know no other forces; take method = 'superposition' and sum = "
            "'cells', or leave extra_laws out"
        )
    if parameters.springs != ():
        raise BadInput("extra_laws do not go with contacts.law = 'spring-dashpot'; take 'impulse'")
    if parameters.rough != ():
        raise BadInput("extra_laws do not go with friction; leave contacts.friction and dish.friction out")
    if parameters.single:
        raise BadInput("extra_laws want interaction.precision = 'double'")


@compiled_once
def _no_law(distance: float, own: PairParameters) -> float:
    return 0.0


def _sum_of(one: Callable[..., float], other: Callable[..., float]) -> Callable[..., float]:
    @compiled_once
    def both(distance: float, own: PairParameters) -> float:
        return one(distance, own) + other(distance, own)

    return both
