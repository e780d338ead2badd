"""Which way a step's linear systems are solved: `SOLVERS`, the table of them, and the choice."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from ecume.models.soft import newton, stages
from ecume.models.soft.parameters import Contacts, Parameters
from ecume.models.soft.protocol import Drive, Rules
from ecume.models.soft.schemes import SCHEMES, Scheme
from ecume.models.soft.step import During, Step

FINE = 1e-13
"""The last change of a position, over its distance, with which spheres are said to be balanced."""
FINE_SPUN = 1e-10
"""The same where spheres spin: in space loads alone resist a spin about the line of a contact, so that rounding leaves
more of it.
"""
AT_ONCE = 1e-9
"""Of a step: the time in which the liquid is to hold spheres where they are."""
FEW = 72
"""Unknowns up to which elimination is the fastest."""
MANY = {2: 400_000, 3: 30_000}
"""Unknowns, in each dimension, beyond which a factorization takes too long to stand in for the gradients."""


Solver = Callable[[Contacts, Step, Scheme, During, int], float]
"""A way to begin a step, to balance, or to try a step: what came of it, or `stages.FAILED`."""

SOLVERS: dict[str, Solver] = {
    "dense": stages.dense,
    "gradients": partial(stages.many, newton.newton_gradients),
    "direct": partial(stages.many, newton.newton_direct),
}
BORDERED: dict[str, Solver] = {name: partial(stages.many, partial(newton.newton_bordered, name)) for name in SOLVERS}
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
        error = way(parameters.contacts, step, scheme, during, stages.STEP)
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
    fine = FINE_SPUN if parameters.torque.shape[1] else FINE
    during, scheme = During(span, np.array([origin, drive]), fine), SCHEMES[parameters.scheme]
    tries = (way(parameters.contacts, step, scheme, during, stages.BALANCE) for way in ways(parameters, rules))
    return any(found != stages.FAILED for found in tries)


def begin(parameters: Parameters, step: Step, drive: Drive) -> None:
    """Contacts and forces at the step's beginning, into `step`."""
    during, scheme = During(0.0, np.array([drive, drive]), FINE), SCHEMES[parameters.scheme]
    ways(parameters, Rules(*map(int, step.cell.rules)))[0](parameters.contacts, step, scheme, during, stages.BEGIN)
