"""Behind the walls: nobody gets out. In a smooth flow nobody tries, and the count of hits says so."""

from __future__ import annotations

from typing import Any

from ecume._jit import compiled


@compiled
def turn_back(position: Any, velocity: Any, low: Any, high: Any, restitution: float) -> int:
    """Reflect whoever passed a side of the tank; how many did."""
    hits = 0
    for axis in range(position.shape[0]):
        for i in range(position.shape[1]):
            x = position[axis, i]
            if x < low[axis]:
                position[axis, i] = low[axis] + restitution * (low[axis] - x)
                velocity[axis, i] = restitution * abs(velocity[axis, i])
                hits += 1
            elif x > high[axis]:
                position[axis, i] = high[axis] - restitution * (x - high[axis])
                velocity[axis, i] = -restitution * abs(velocity[axis, i])
                hits += 1
    return hits
