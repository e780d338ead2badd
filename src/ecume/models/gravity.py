"""The direction of gravity in the report of `ecume check`, for every model."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ecume.units import with_prefix


def gravity_text(pull: Sequence[float]) -> tuple[str, str]:
    """Gravity with its direction, and the upward axis; empty without gravity, and in 2D, where
    pictures show it.

    >>> gravity_text((0.0, 0.0, -9.81))
    ('9.81 m/s^2 along -z', 'up is +z')
    >>> gravity_text((0.0, -9.81)), gravity_text((0.0, 0.0, 0.0))
    (('9.81 m/s^2 along -y', ''), ('none', ''))
    """
    size = math.hypot(*pull)
    if size == 0.0:
        return "none", ""
    axis = max(range(len(pull)), key=lambda k: abs(pull[k]))
    ahead, behind = "-+" if pull[axis] < 0.0 else "+-"
    along = "along" if abs(pull[axis]) == size else "mainly along"
    up = f"up is {behind}{'xyz'[axis]}" if len(pull) == 3 else ""
    return f"{with_prefix(size, 'm/s^2')} {along} {ahead}{'xyz'[axis]}", up
