"""What soft spheres must not lose: the balance of forces on each, and the films between them."""

from __future__ import annotations

from ecume.models.invariants import Invariant, Seen, part_of
from ecume.models.soft.parameters import Parameters
from ecume.scenes.soft import SoftScene

UNBALANCED = 1e-3
"""Of the largest force so far: steps leave 1e-9, but a film that ends at its reach takes along what it held."""


def invariants(scene: SoftScene, parameters: Parameters) -> list[Invariant]:
    """The rows of a scene. With drag a sphere's balance has its velocity in it, which frames know less well."""
    gap = Invariant("gap", "whether any is closed", 0.0, _closed)
    balance = Invariant("force balance", "what is left on a sphere, over the largest force", UNBALANCED, _left)
    return [gap] if scene.liquid.drag else [gap, balance]


def _closed(seen: Seen) -> float:
    return 0.0 if seen.now["smallest_gap"] > 0.0 else 1.0


def _left(seen: Seen) -> float:
    """At the start contacts have no force yet, and nothing balances."""
    if seen.now["step"] == 0.0:
        return 0.0
    return part_of(seen.now["imbalance"], max(seen.largest["largest_tension"], seen.largest["largest_compression"]))
