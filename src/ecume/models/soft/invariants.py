"""What soft spheres must not lose: the balance of forces on each, the films between them, and energy."""

from __future__ import annotations

from ecume.models.invariants import DISSIPATED, ENERGY, INJECTED, Invariant, Seen, part_of
from ecume.models.soft.observing import SIZE_WORK, STAKE
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.schemes import SCHEMES
from ecume.scenes.soft import SoftScene

UNBALANCED = 1e-7
"""Of the typical force: steps leave less than a tenth of it, but where deflections are lost in rounding."""
LOOSE = 5.0
"""Times the error that a scheme's order and the tolerance leave in a whole run."""
ROUNDED = 1e-8
"""Of the energy: what balances and rounding leave at any tolerance."""


def invariants(scene: SoftScene, parameters: Parameters) -> list[Invariant]:
    """The rows of a scene."""
    balance = "what a step leaves on a sphere, over the typical force"
    return [
        Invariant("gap", "whether any is closed", 0.0, _closed),
        Invariant("force balance", balance, UNBALANCED, _left),
        Invariant(ENERGY, "what its books miss, over what moved", most_missing(parameters), _missing),
    ]


def most_missing(parameters: Parameters) -> float:
    """Steps err by the tolerance e, in the power p + 1 of their length where p is the scheme's order: all of them
    together by e^(p/(p+1)). The tolerance is one of ln(gap) and directions, so where little moved, of what moving as
    much would do.
    """
    order = SCHEMES[parameters.scheme].tableau.order
    return float(LOOSE * parameters.tolerance ** (order / (order + 1.0)) + ROUNDED)


def _missing(seen: Seen) -> float:
    """What was put in, less what there is more, what was dissipated, and what contacts' sizes took."""
    if INJECTED not in seen.now:
        return 0.0
    first, now = seen.first, seen.now
    spent = sum(now[key] - first.get(key, 0.0) for key in ("total_energy", DISSIPATED, SIZE_WORK))
    moved = now[DISSIPATED] + seen.largest["total_energy"] - seen.least["total_energy"]
    return part_of(abs(now[INJECTED] - first.get(INJECTED, 0.0) - spent), moved + seen.largest[STAKE])


def _closed(seen: Seen) -> float:
    return 0.0 if seen.now["smallest_gap"] > 0.0 else 1.0


def _left(seen: Seen) -> float:
    return seen.now["imbalance"]
