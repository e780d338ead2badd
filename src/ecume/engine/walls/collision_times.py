"""When a flight meets a surface: roots without cancellation. The flight is x + v t + a t^2/2, all relative to it."""

from __future__ import annotations

import math

from ecume._jit import compiled_inside
from ecume.engine.walls.vectors import Vector, dot, length

NEVER = math.inf
Quartic = tuple[float, float, float, float, float]


@compiled_inside
def time_to_plane(gap: float, speed: float, push: float) -> float:
    """The first t >= 0 at which gap + speed t + push t^2/2 turns negative, from above.

    The form of the root is chosen so that numbers of one sign are added. What begins below, as it may beside an
    obstacle's face, must come up first.
    """
    if gap < 0.0 and not (speed > 0.0 and push < 0.0 and speed * speed > 2.0 * push * gap):
        return NEVER
    if push == 0.0:
        return gap / -speed if speed < 0.0 else NEVER
    square = speed * speed - 2.0 * push * gap
    if speed < 0.0:
        return 2.0 * gap / (-speed + math.sqrt(square)) if square > 0.0 else NEVER
    return (speed + math.sqrt(square)) / -push if push < 0.0 else NEVER


@compiled_inside
def time_to_chord_end(gap: float, inward: float, square: float) -> float:
    """The first t >= 0 at which gap - 2 inward t - square t^2 turns negative: straight flight inside a sphere.

    gap = R^2 - p^2 >= 0, inward = p.v, square = v^2. From the sphere itself it is the chord, -2 p.v / v^2.
    """
    if square == 0.0:
        return NEVER
    root = math.sqrt(inward * inward + square * gap)
    return gap / (inward + root) if inward > 0.0 else (root - inward) / square


@compiled_inside
def time_to_ball(gap: float, inward: float, square: float) -> float:
    """The first t >= 0 at which gap + 2 inward t + square t^2 turns negative: straight flight outside a sphere.

    gap = p^2 - R^2 >= 0.
    """
    under = inward * inward - square * gap
    return gap / (math.sqrt(under) - inward) if inward < 0.0 and under > 0.0 else NEVER


@compiled_inside
def time_to_sphere(
    position: Vector, velocity: Vector, acceleration: Vector, shape: tuple[float, float, float]
) -> float:
    """The time at which a flight from one side of a sphere around the origin crosses it; shape = (radius, side, the
    longest time).

    The side is 1 inside, -1 outside.
    """
    radius, side, longest = shape
    away = length(position)
    gap = side * (radius - away)
    push = dot(acceleration, acceleration)
    reach = longest * length(velocity) + 0.5 * longest * longest * math.sqrt(push)
    if gap > reach:
        return NEVER
    gap = max(gap, 0.0) * (radius + away)
    inward, square = dot(position, velocity), dot(velocity, velocity)
    if push == 0.0:
        return time_to_chord_end(gap, inward, square) if side > 0.0 else time_to_ball(gap, inward, square)
    bend = -side * (square + dot(position, acceleration))
    return first_crossing(
        (gap, -2.0 * side * inward, bend, -side * dot(velocity, acceleration), -0.25 * side * push), longest
    )


@compiled_inside
def first_crossing(quartic: Quartic, longest: float) -> float:
    """The first t in [0, longest] at which c0 + c1 t + ... + c4 t^4 turns negative; c0 >= 0.

    Between the turning points, which lie between the points of inflection, a quartic is monotone: no root is missed.
    """
    c0, c1, c2, c3, c4 = quartic
    if c0 <= 0.0 and (c1 < 0.0 or (c1 == 0.0 and c2 < 0.0)):
        return 0.0
    slope = (c1, 2.0 * c2, 3.0 * c3, 4.0 * c4, 0.0)
    first, second = inflections(12.0 * c4, 6.0 * c3, 2.0 * c2, longest)
    ends = (first, second, longest)
    low, before = 0.0, 0.0
    for k in range(3):
        if value(slope, low) * value(slope, ends[k]) < 0.0:
            turn = bracketed(slope, low, ends[k])
            if value(quartic, turn) < 0.0:
                return bracketed(quartic, before, turn)
            before = turn
        low = ends[k]
    return bracketed(quartic, before, longest) if value(quartic, longest) < 0.0 else NEVER


@compiled_inside
def inflections(a: float, b: float, c: float, longest: float) -> tuple[float, float]:
    """The roots of a t^2 + b t + c, in order, moved into [0, longest]."""
    under = b * b - 4.0 * a * c
    if under <= 0.0 or a == 0.0:
        return 0.0, 0.0
    big = -0.5 * (b + math.copysign(math.sqrt(under), b))
    one, other = big / a, c / big if big != 0.0 else 0.0
    low, high = min(one, other), max(one, other)
    return min(max(low, 0.0), longest), min(max(high, 0.0), longest)


@compiled_inside
def value(c: Quartic, t: float) -> float:
    """c0 + c1 t + ... + c4 t^4"""
    return c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * c[4])))


@compiled_inside
def bracketed(c: Quartic, low: float, high: float) -> float:
    """The root between two ends of opposite sign: Newton's steps, halving where they lead out."""
    rising = value(c, high) > value(c, low)
    t = 0.5 * (low + high)
    for _ in range(100):
        height = value(c, t)
        if (height > 0.0) == rising:
            high = t
        else:
            low = t
        slope = c[1] + t * (2.0 * c[2] + t * (3.0 * c[3] + t * 4.0 * c[4]))
        new = t - height / slope if slope != 0.0 else low
        if not low < new < high:
            new = 0.5 * (low + high)
        if new == t or high - low <= 1e-16 * high:
            break
        t = new
    return t
