"""Which way a step's linear systems are solved: `SOLVERS`, the table of them, and the choice."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from ecume.models.soft import stages
from ecume.models.soft.parameters import Drive, Parameters
from ecume.models.soft.schemes import Scheme
from ecume.models.soft.stages import During, Step, first_stage

FINE = 1e-13
"""The last change of a position, over its distance, with which spheres are said to be balanced."""
FEW = 72
"""Unknowns up to which elimination is the fastest."""
MANY = {2: 400_000, 3: 30_000}
"""Unknowns, in each dimension, beyond which a factorization takes too long to stand in for the gradients."""


class Solver(NamedTuple):
    """A way to try a step, and to solve a stage."""

    attempt: Callable[..., float]
    newton: Callable[..., bool]


SOLVERS = {
    "dense": Solver(stages.attempt_dense, stages.newton_dense),
    "gradients": Solver(stages.attempt_gradients, stages.newton_gradients),
    "direct": Solver(stages.attempt_direct, stages.newton_direct),
}


def ways(parameters: Parameters) -> tuple[Solver, ...]:
    """The ways to try, one after the other: by the number of unknowns alone, so that a run chooses as the last one did.

    Gradients may break down where the matrix is far from symmetric and positive; then a factorization stands in.
    """
    if parameters.solver != "auto":
        return (SOLVERS[parameters.solver],)
    unknowns = parameters.force.size
    if unknowns <= FEW:
        return (SOLVERS["dense"],)
    stands_in = unknowns <= MANY[parameters.dimensions]
    return (SOLVERS["gradients"], SOLVERS["direct"]) if stands_in else (SOLVERS["gradients"],)


def attempt(parameters: Parameters, step: Step, scheme: Scheme, during: During) -> float:
    """Try a step: the estimated error, or `stages.FAILED`."""
    error = stages.FAILED
    for way in ways(parameters):
        error = way.attempt(parameters.contacts, step, scheme, during)
        if error != stages.FAILED:
            break
    return error


def balance(parameters: Parameters, step: Step, drive: Drive) -> bool:
    """Move the spheres to where their forces balance while the gaps stay as they are; whether there is such a place."""
    for way in ways(parameters):
        first_stage(parameters.contacts, step, drive)
        if way.newton(parameters.contacts, step, (drive, 0.0), FINE):
            return True
    return False
