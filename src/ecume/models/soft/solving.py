"""Which way a step's linear systems are solved: `SOLVERS`, the table of them, and the choice."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from ecume.models.soft import newton, stages
from ecume.models.soft.cell import Goal
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.protocol import Drive, Rules
from ecume.models.soft.schemes import Scheme
from ecume.models.soft.stages import first_stage
from ecume.models.soft.step import During, Step

FINE = 1e-13
"""The last change of a position, over its distance, with which spheres are said to be balanced."""
AT_ONCE = 1e-9
"""Of a step: the time in which the liquid is to hold spheres where they are."""
FEW = 72
"""Unknowns up to which elimination is the fastest."""
MANY = {2: 400_000, 3: 30_000}
"""Unknowns, in each dimension, beyond which a factorization takes too long to stand in for the gradients."""


class Solver(NamedTuple):
    """A way to try a step, and to solve a stage."""

    attempt: Callable[..., float]
    newton: Callable[..., bool]


SOLVERS = {
    "dense": Solver(stages.attempt_dense, newton.newton_dense),
    "gradients": Solver(stages.attempt_gradients, newton.newton_gradients),
    "direct": Solver(stages.attempt_direct, newton.newton_direct),
}
BORDERED = {
    name: Solver(partial(stages.attempt_bordered, name), partial(newton.newton_bordered, name)) for name in SOLVERS
}
"""The same where the box answers to stresses."""


def ways(parameters: Parameters, rules: Rules) -> tuple[Solver, ...]:
    """The ways to try, one after the other: by the number of unknowns alone, so that a run chooses as the last one did.

    Gradients may break down where the matrix is far from symmetric and positive; then a factorization stands in.
    """
    table = BORDERED if any(rules) or len(parameters.walls.free) else SOLVERS
    if parameters.solver != "auto":
        return (table[parameters.solver],)
    unknowns = parameters.force.size
    if unknowns <= FEW:
        return (table["dense"],)
    stands_in = unknowns <= MANY[parameters.dimensions]
    return (table["gradients"], table["direct"]) if stands_in else (table["gradients"],)


def attempt(parameters: Parameters, step: Step, scheme: Scheme, during: During, rules: Rules) -> float:
    """Try a step: the estimated error, or `stages.FAILED`."""
    error = stages.FAILED
    step.cell.rules[:] = rules
    for way in ways(parameters, rules):
        error = way.attempt(parameters.contacts, step, scheme, during)
        if error != stages.FAILED:
            break
    return error


def balance(parameters: Parameters, step: Step, at: tuple[Drive, Drive, Rules], span: float = 0.0) -> bool:
    """Move spheres and box to where forces and stresses balance while the gaps stay as they are; whether there is such
    a place. `at` is what was imposed, what is, and what answers to a stress.

    Spheres on which the liquid drags are held by it: a `span` of time that is next to none.
    """
    origin, drive, rules = at
    step.cell.rules[:] = rules
    for way in ways(parameters, rules):
        first_stage(parameters.contacts, step, origin)
        if way.newton(parameters.contacts, step, Goal(drive, origin, span), FINE):
            return True
    return False
