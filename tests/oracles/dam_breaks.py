"""Dam breaks of shallow water over a dry and a wet bed."""

from __future__ import annotations

import math
from typing import NamedTuple

from ecume.errors import BadInput
from ecume.laws.arguments import require_positive
from ecume.units import Acceleration, Length, Speed, Time


class Bore(NamedTuple):
    """The step of water that runs ahead of a dam break over a wet bed."""

    middle_depth: Length
    middle_speed: Speed
    bore_speed: Speed


def ritter_depth(
    x: Length, time: Time, dam_depth: Length, gravity: Acceleration
) -> Length:  # fmt: skip
    """Depth of shallow water at x, a time t after a dam at x = 0 broke, over a dry bed: (2 c - x/t)^2 / (9 g).

    Between x = -c t and 2 c t with c^2 = g H; at the dam 4/9 of H. Not for what is near the tip, nor for early times:
    there the water is not shallow. [ritter1892].

    >>> round(ritter_depth(0.0, 1.0, 1.0, 9.81), 12) == round(4.0 / 9.0, 12)
    True
    """
    celerity = math.sqrt(gravity * dam_depth)
    along = min(max(x / time, -celerity), 2.0 * celerity)
    return (2.0 * celerity - along) ** 2 / (9.0 * gravity)


def ritter_speed(x: Length, time: Time, dam_depth: Length, gravity: Acceleration) -> Speed:
    """Speed of the water of `ritter_depth`, 2 (c + x/t)/3; zero before the wave has come and where the bed is dry.

    [ritter1892].

    >>> round(ritter_speed(0.0, 1.0, 1.0, 9.0), 12)
    2.0
    """
    celerity = math.sqrt(gravity * dam_depth)
    along = x / time
    return 2.0 / 3.0 * (celerity + along) if -celerity < along < 2.0 * celerity else 0.0


def stoker_bore(dam_depth: Length, downstream_depth: Length, gravity: Acceleration) -> Bore:
    """The bore of a dam break over a bed with water h_1: the depth and speed behind it, and its own speed.

    The depth h between the fan and the bore solves 2 (sqrt(g H) - sqrt(g h)) = (h - h_1) sqrt(g (h + h_1)/(2 h h_1)).
    [stoker1957, sec. 10.8].

    >>> round(stoker_bore(1.0, 0.1, 1.0).middle_depth, 7)
    0.3961748
    """
    require_positive("downstream_depth", downstream_depth)
    if not downstream_depth < dam_depth:
        raise BadInput(f"downstream_depth is {downstream_depth!r}; expected less than behind the dam, {dam_depth!r}")
    low, high = downstream_depth, dam_depth
    while high - low > 4e-16 * dam_depth:
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        low, high = (middle, high) if _fan_is_faster(middle, dam_depth, downstream_depth) else (low, middle)
    speed = 2.0 * (math.sqrt(gravity * dam_depth) - math.sqrt(gravity * low))
    return Bore(low, speed, speed * low / (low - downstream_depth))


def stoker_depth(
    x: Length, time: Time, dam_depth: Length, downstream_depth: Length, gravity: Acceleration
) -> Length:  # fmt: skip
    """Depth of shallow water at x, a time t after a dam at x = 0 broke over a wet bed: fan, shelf, bore.

    [stoker1957, sec. 10.8].

    >>> stoker_depth(10.0, 1.0, 1.0, 0.1, 9.81)
    0.1
    """
    bore = stoker_bore(dam_depth, downstream_depth, gravity)
    if x >= bore.bore_speed * time:
        return downstream_depth
    return max(ritter_depth(x, time, dam_depth, gravity), bore.middle_depth)


def _fan_is_faster(depth: float, dam_depth: float, downstream: float) -> bool:
    fan = 2.0 * (math.sqrt(dam_depth) - math.sqrt(depth))
    return fan > (depth - downstream) * math.sqrt((depth + downstream) / (2.0 * depth * downstream))
