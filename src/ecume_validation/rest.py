"""Ten minutes of a bowl of cereal: no overlaps, no energy gain, and rest at the end."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ecume.simulation import simulate
from ecume_validation.runner import Row, below, floating_scene, within

BOWLS: dict[str, tuple[str, ...]] = {
    "milk": (),
    "syrup": ("liquid.viscosity=0.2 Pa*s", "dish.radius=2.2 cm", "seed=5"),
}
MOST_OVERLAP = 1e-3
"""The limit of overlaps over a radius."""
MOST_RISE = 1e-6
"""The limit of the sum of all energy rises, over the final energy."""
MOST_SPEED = 1e-6
"""The limit of the final speed (m/s)."""


def rows() -> list[Row]:
    """Compare both bowls."""
    return [row for name, changes in BOWLS.items() for row in bowl(name, changes)]


def bowl(name: str, changes: Sequence[str]) -> list[Row]:
    """Compare one bowl."""
    scene = floating_scene("rest", changes)
    radius = scene.particles[0].radius
    frames = list(simulate(scene))
    energy = np.array([frame.numbers["total_energy"] for frame in frames])
    rises = float(np.sum(np.maximum(np.diff(energy), 0.0)))
    last = frames[-1].numbers
    # The model reports the deepest overlap in any step; this function evaluates frames without it.
    overlap = max(last["deepest_overlap"], *(frame.numbers["largest_overlap"] for frame in frames))
    lost = sum(not np.isfinite(frame.arrays["position"]).all() for frame in frames)
    return [
        within(f"{name}: frames with a float that has no place", lost, 0.0, 0.0),
        below(f"{name}: deepest overlap of all steps, over a radius", overlap / radius, MOST_OVERLAP),
        below(f"{name}: rises of the energy, summed, over the energy", rises / abs(float(energy[-1])), MOST_RISE),
        below(f"{name}: largest speed in the end (m/s)", last["largest_speed"], MOST_SPEED),
        within(f"{name}: steps whose contacts did not converge", last["unconverged_steps"], 0.0, 0.0),
    ]
