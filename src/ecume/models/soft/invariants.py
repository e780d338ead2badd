"""What soft spheres must not lose: the balance of forces on each, and the films between them."""

from __future__ import annotations

from ecume.models.invariants import Invariant, Seen
from ecume.models.soft.parameters import Parameters
from ecume.scenes.soft import SoftScene

UNBALANCED = 1e-7
"""Of the typical force: steps leave less than a tenth of it, but where deflections are lost in rounding."""


def invariants(scene: SoftScene, parameters: Parameters) -> list[Invariant]:
    """The rows of a scene."""
    balance = "what a step leaves on a sphere, over the typical force"
    return [
        Invariant("gap", "whether any is closed", 0.0, _closed),
        Invariant("force balance", balance, UNBALANCED, _left),
    ]


def _closed(seen: Seen) -> float:
    return 0.0 if seen.now["smallest_gap"] > 0.0 else 1.0


def _left(seen: Seen) -> float:
    return seen.now["imbalance"]
