"""Invariants of floats: the energy budget, momentum of isolated floats, and overlaps."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ecume.models.floating.forces.pair_forces import row_of
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.time_integration.energy_budget import is_driven
from ecume.models.invariants import INJECTED, Invariant, Seen, energy_never_rises, kept, part_of
from ecume.scenes.floating import FloatingScene

RISE = 1e-3
"""Tolerance of the energy with the default time step."""

OVERLAP = 0.02
"""Over the smallest radius: contacts tolerate 1e-4; many fast floats overlap more for one step."""

UNSETTLED = 0.01
"""Tolerated fraction of steps whose contacts do not converge."""

ROUNDING = 1e-9
"""Tolerance of momentum: pair forces cancel exactly, sums to rounding."""


def invariants(scene: FloatingScene, parameters: Parameters) -> list[Invariant]:
    """The invariants of a scene."""
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
    """The energy minus the injected work never increases. Without inertia it is potential energy only, and thermal
    noise changes it by kT per float. A law that is not reciprocal has no energy.
    """
    heat = len(parameters.floats.mass) * parameters.drift.thermal
    motion = ("kinetic_energy",) if parameters.scheme.inertia else ()
    energy = energy_never_rises(RISE, lambda seen: heat, motion)
    if not is_driven(parameters):
        return energy
    # Runs of former versions have no injected work.
    return energy._replace(value=lambda seen: energy.value(seen) if INJECTED in seen.now else 0.0)


def _alone(scene: FloatingScene, parameters: Parameters) -> bool:
    """Whether floats interact with one another only."""
    dragged = any(math.isfinite(float(time)) for time in parameters.floats.relaxation_time)
    pushed = is_driven(parameters) or not row_of(parameters).reciprocal or not parameters.scheme.inertia
    return scene.dish is None and not dragged and not pushed


def _momenta(seen: Seen, mass: float) -> float:
    """The largest possible momentum at this energy, sqrt(2 m E)."""
    return math.sqrt(2.0 * mass * seen.largest["kinetic_energy"])
