"""The choice of the linear solver of a step among those of `engine.linear_solvers`."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from ecume.engine.cells import Integers
from ecume.engine.linear_solvers import solvers
from ecume.engine.linear_solvers.solvers import Kept
from ecume.models.soft.integration import dirk, newton
from ecume.models.soft.integration.dirk_schemes import SCHEMES, Scheme
from ecume.models.soft.parameters import Contacts, Parameters
from ecume.models.soft.protocol import Drive, Rules
from ecume.models.soft.state import Step, StepRequest, Workspace

FINE = 1e-13
"""The largest relative change of a position in the last iteration of a balance."""
FINE_SPUN = 1e-10
"""The same with spins: in 3D only external loads resist a spin about the line of a contact, so that its rounding error
is larger.
"""
FEW = 72
"""The largest number of unknowns for which dense elimination is the fastest."""
AGAIN = 10
"""The number of steps after which the iterative solver is tried again; it may need fewer iterations by then."""
PATIENCE = 2
"""The number of times that a step is shortened before a factorization replaces the iterative solver."""
ITERATIONS, WITHOUT, BROKEN = range(3)
"""Indices of `State.effort`."""

Stepper = Callable[[Contacts, Step, Scheme, StepRequest, int], float]
"""A function that begins a step, balances forces, or computes a step. Returns the estimated error, or `dirk.FAILED`."""


def solver_names(parameters: Parameters, kept: Kept, effort: Integers) -> tuple[str, ...]:
    """The solvers to try, in order. They follow from the number of unknowns, the pattern and the state, so that a
    resumed run chooses the same ones.

    The iterative solver breaks down where the matrix is not positive definite, mostly because the step is too long.
    Where it also breaks down in shorter steps, a factorization replaces it until it succeeds again.
    """
    if parameters.solver not in ("auto", "iterative"):
        return (parameters.solver,)
    if parameters.solver == "auto" and parameters.force.size <= FEW:
        return ("dense",)
    fewer = effort[WITHOUT] < AGAIN and solvers.does_less(kept, int(effort[ITERATIONS]))
    if parameters.solver == "auto" and fewer:
        return ("direct", "iterative")
    return ("iterative", "direct") if effort[BROKEN] >= PATIENCE and solvers.pays(kept) else ("iterative",)


def stepper(parameters: Parameters, kept: Kept, rules: Rules, name: str) -> Stepper:
    """The function that computes a step by one of the solvers."""
    solve = partial(solvers.SOLVERS[name], kept)
    if any(rules) or len(parameters.walls.free) or parameters.permeation:
        return partial(dirk.step_many, partial(newton.newton_bordered, solve))
    return dirk.step_dense if name == "dense" else partial(dirk.step_many, partial(newton.newton_many, solve))


def attempt(parameters: Parameters, scratch: Workspace, during: StepRequest, rules: Rules, effort: Integers) -> float:
    """Try a step. Returns the estimated error, or `dirk.FAILED`."""
    step, kept, scheme = scratch.step, scratch.kept, SCHEMES[parameters.scheme].tableau
    step.cell.rules[:] = rules
    kept.iterations = kept.systems = 0
    name = ""
    for name in solver_names(parameters, kept, effort):
        error = stepper(parameters, kept, rules, name)(parameters.contacts, step, scheme, during, dirk.STEP)
        if error != dirk.FAILED:
            break
    if error == dirk.FAILED:  # the iterations of a failed step do not predict those of a shorter one
        effort[BROKEN] += 1
    elif name == "iterative":
        effort[:] = -(-kept.iterations // kept.systems), 0, 0
    else:
        effort[WITHOUT] += 1
    return error


def balance(parameters: Parameters, scratch: Workspace, at: tuple[Drive, Drive, Rules], effort: Integers) -> bool:
    """Move spheres and box at constant gaps until forces and stresses balance. Returns False if no balance is found.
    `at` contains the drive before, the drive now, and the components that stresses control.

    Spheres with drag move with the box.
    """
    (origin, drive, rules), step, kept = at, scratch.step, scratch.kept
    step.cell.rules[:] = rules
    fine = FINE_SPUN if parameters.torque.shape[1] else FINE
    during, scheme = StepRequest(0.0, np.array([origin, drive]), fine), SCHEMES[parameters.scheme].tableau
    names = solver_names(parameters, kept, effort)
    if names == ("iterative",) and solvers.pays(kept):
        names = ("iterative", "direct")
    ways = [stepper(parameters, kept, rules, name) for name in names]
    if parameters.drag.any():
        ways = [partial(dirk.step_many, newton.balance_borders)]
    return any(one(parameters.contacts, step, scheme, during, dirk.BALANCE) != dirk.FAILED for one in ways)


def begin_step(parameters: Parameters, step: Step, drive: Drive) -> None:
    """Compute contacts and forces at the start of a step and store them in `step`."""
    during, scheme = StepRequest(0.0, np.array([drive, drive]), FINE), SCHEMES[parameters.scheme].tableau
    few = parameters.solver == "auto" and parameters.force.size <= FEW
    start = (
        dirk.step_dense
        if (few or parameters.solver == "dense") and not any(step.cell.rules) and not parameters.permeation
        else partial(dirk.step_many, newton.newton_dense)
    )
    start(parameters.contacts, step, scheme, during, dirk.BEGIN)
