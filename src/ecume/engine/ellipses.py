"""Ellipses: distance and nearest points of two, and extent of one.

Two ellipses are as far apart as the widest strip between them; its direction is what is looked for.
"""

from __future__ import annotations

import math

from ecume._jit import compiled, compiled_inside

DIRECTIONS = 7
"""Tried on either side of the line of centers, before the best is made better."""
Ellipse = tuple[float, float, float]
"""Semi-axes, and the angle of the first."""
Near = tuple[float, float, float, float, float, float, float]
"""Gap, normal from one to the other, and where they are nearest, as seen from the center of each."""


@compiled_inside
def breadth(ellipse: Ellipse, direction: float) -> tuple[float, float, float]:
    """The support function of an ellipse, h = sqrt(a^2 cos^2 + b^2 sin^2), and its first two derivatives."""
    a, b, turn = ellipse
    c, s = math.cos(direction - turn), math.sin(direction - turn)
    h = math.sqrt(a * a * c * c + b * b * s * s)
    slope = (b * b - a * a) * c * s / h
    return h, slope, ((b * b - a * a) * (c * c - s * s) - slope * slope) / h


@compiled_inside
def farthest_point(ellipse: Ellipse, direction: float) -> tuple[float, float]:
    """The point of an ellipse farthest in a direction: h u + h' (u turned by 90 degrees)."""
    h, slope, _ = breadth(ellipse, direction)
    c, s = math.cos(direction), math.sin(direction)
    return h * c - slope * s, h * s + slope * c


@compiled_inside
def strip(x: float, y: float, one: Ellipse, other: Ellipse, direction: float) -> tuple[float, float, float]:
    """The width of the strip between two ellipses across a direction, negative where they overlap; its first two
    slopes.
    """
    c, s = math.cos(direction), math.sin(direction)
    h, slope, bend = breadth(one, direction)
    h_other, slope_other, bend_other = breadth(other, direction)
    along = x * c + y * s
    return along - h - h_other, y * c - x * s - slope - slope_other, -along - bend - bend_other


@compiled
def widest_strip(x: float, y: float, one: Ellipse, other: Ellipse, reach: float) -> float:
    """The direction across which two ellipses are farthest apart; any that shows them farther than `reach`.

    Where they are apart the width has one maximum; overlapping ones have several, and the highest is taken. It is
    bracketed from the best of some directions, those across each ellipse among them, and found by Newton's method.
    """
    ahead = math.atan2(y, x)
    best, direction = strip(x, y, one, other, ahead)[0], ahead
    if best > reach or (one[0] == one[1] and other[0] == other[1]):
        return ahead
    for k in range(2 * DIRECTIONS + 4):
        if k < 4:
            tried = (one[2] if k < 2 else other[2]) + (0.5 if k % 2 == 0 else -0.5) * math.pi
        else:
            side = k - 3 - DIRECTIONS
            tried = ahead + side * 0.5 * math.pi / (DIRECTIONS + 1)
        width = strip(x, y, one, other, tried)[0]
        if width > reach:
            return tried
        if width > best:
            best, direction = width, tried
    return climb(x, y, one, other, direction)


@compiled
def climb(x: float, y: float, one: Ellipse, other: Ellipse, direction: float) -> float:
    """The maximum of the strip's width next to a direction: the zero of its slope, between two of unlike sign."""
    slope = strip(x, y, one, other, direction)[1]
    if slope == 0.0:
        return direction
    step = math.copysign(0.01, slope)
    near, far = direction, direction + step
    for _ in range(12):
        if strip(x, y, one, other, far)[1] * slope <= 0.0:
            break
        step *= 2.0
        near, far = far, far + step
    found = 0.5 * (near + far)
    for _ in range(80):
        _, value, bend = strip(x, y, one, other, found)
        if value * slope > 0.0:
            near = found
        else:
            far = found
        # Newton's step where it stays between the two, else their middle.
        going = found - value / bend if bend < 0.0 else far
        if (going - near) * (going - far) >= 0.0:
            going = 0.5 * (near + far)
        if abs(going - found) <= 1e-15 * (1.0 + abs(found)):
            return going
        found = going
    return found


@compiled
def ellipses_near(x: float, y: float, one: Ellipse, other: Ellipse, reach: float) -> Near:
    """Two ellipses whose centers are (x, y) apart; the gap is a lower bound where it is above `reach`."""
    direction = widest_strip(x, y, one, other, reach)
    gap = strip(x, y, one, other, direction)[0]
    on_one, on_other = farthest_point(one, direction), farthest_point(other, direction)
    return gap, math.cos(direction), math.sin(direction), on_one[0], on_one[1], -on_other[0], -on_other[1]


@compiled
def farthest_from_origin(x: float, y: float, ellipse: Ellipse) -> float:
    """The direction in which the point of an ellipse lies that is farthest from the origin, the center being (x, y).

    Fixed-point iteration, in the direction of the farthest point so far, never increases the error; Newton's method
    then completes it.
    """
    direction = math.atan2(y, x)
    for _ in range(4):
        far_x, far_y = farthest_point(ellipse, direction)
        direction = math.atan2(y + far_y, x + far_x)
    for _ in range(20):
        _, slope, bend = breadth(ellipse, direction)
        c, s = math.cos(direction), math.sin(direction)
        value, change = c * y - s * x + slope, bend - c * x - s * y
        if change >= 0.0:
            far_x, far_y = farthest_point(ellipse, direction)
            direction = math.atan2(y + far_y, x + far_x)
        else:
            direction -= value / change
            if abs(value) <= 1e-15 * abs(change):
                break
    return direction
