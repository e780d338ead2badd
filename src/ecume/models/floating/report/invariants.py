"""What floats must not lose: energy that nobody brings, momentum where nobody takes any, and their distance."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ecume.models.floating.forces.pair_forces import row_of
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.time_integration.energy_budget import is_driven
from ecume.models.invariants import INJECTED, Invariant, Seen, energy_never_rises, kept, part_of
from ecume.scenes.floating import FloatingScene

RISE = 1e-3
"""Of the energy: what steps as long as are chosen may err."""

OVERLAP = 0.02
"""Of the smallest radius: contacts leave 1e-4 alone, and a crowd that rushes together more for a step."""

UNSETTLED = 0.01
"""The part of all steps whose contacts may end before they converge."""

ROUNDING = 1e-9
"""Of momentum: pairs cancel to the bit, sums of them to rounding."""


def invariants(scene: FloatingScene, parameters: Parameters) -> list[Invariant]:
    """The rows of a scene."""
    return list(_rows(scene, parameters))


def _rows(scene: FloatingScene, parameters: Parameters) -> Iterator[Invariant]:
    if scene.contacts.law != "none":
        smallest = float(parameters.floats.radius.min())
        yield Invariant(
            "overlap", "the deepest so far, over the smallest radius", OVERLAP,
            lambda seen: seen.now["deepest_overlap"] / smallest,
        )  # fmt: skip
        yield Invariant(
            "contacts", "steps whose contacts did not converge, over all", UNSETTLED,
            lambda seen: part_of(seen.now["unconverged_steps"], max(seen.now["step"], 1.0 / UNSETTLED)),
        )  # fmt: skip
    if row_of(parameters).energy is not None:
        yield _energy(parameters)
    if _alone(scene, parameters):
        mass = float(parameters.floats.mass.sum())
        yield kept("momentum", ("momentum_x", "momentum_y"), lambda seen: _momenta(seen, mass), ROUNDING)


def _energy(parameters: Parameters) -> Invariant:
    """Energy less what is done from outside never rises. Without inertia it is all potential, and what chance does
    with less than kT a float is nothing. A law that breaks Newton's third has none.
    """
    heat = len(parameters.floats.mass) * parameters.drift.thermal
    motion = ("kinetic_energy",) if parameters.scheme.inertia else ()
    energy = energy_never_rises(RISE, lambda seen: heat, motion)
    if not is_driven(parameters):
        return energy
    # Runs that a former version began did not book.
    return energy._replace(value=lambda seen: energy.value(seen) if INJECTED in seen.now else 0.0)


def _alone(scene: FloatingScene, parameters: Parameters) -> bool:
    """Whether floats feel one another and nothing else."""
    dragged = any(math.isfinite(float(time)) for time in parameters.floats.relaxation_time)
    pushed = is_driven(parameters) or not row_of(parameters).reciprocal or not parameters.scheme.inertia
    return scene.dish is None and not dragged and not pushed


def _momenta(seen: Seen, mass: float) -> float:
    """At most what all of them together would have if they went the same way: sqrt(2 m E)."""
    return math.sqrt(2.0 * mass * seen.largest["kinetic_energy"])
