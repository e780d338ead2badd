"""A moving dish in its own frame: its position, velocity and acceleration."""

from __future__ import annotations

import math

from ecume.units import (
    Acceleration,
    Force,
    Friction,
    Length,
    Mass,
    Number,
    Rate,
    Speed,
    Time,
)


def sway_place(amplitude: Length, turning: Rate, time: Time) -> Length:
    """Position of an oscillating dish around A, from rest at 0: x = A (1 - cos(Omega t)).

    >>> round(sway_place(2.0, math.pi, 1.0), 12)
    4.0
    """
    return amplitude * (1.0 - math.cos(turning * time))


def sway_velocity(amplitude: Length, turning: Rate, time: Time) -> Speed:
    """Velocity of an oscillating dish, A Omega sin(Omega t): the derivative of `sway_place`.

    >>> sway_velocity(2.0, 3.0, 0.0)
    0.0
    """
    return amplitude * turning * math.sin(turning * time)


def sway_acceleration(amplitude: Length, turning: Rate, time: Time) -> Acceleration:
    """Acceleration of an oscillating dish, A Omega^2 cos(Omega t): the derivative of
    `sway_velocity`.

    >>> sway_acceleration(2.0, 3.0, 0.0)
    18.0
    """
    return amplitude * turning**2 * math.cos(turning * time)


def left_behind(mass: Mass, friction: Friction, acceleration: Acceleration, velocity: Speed, slip: Number) -> Force:
    """Inertial and drag force on a float in the frame of a moving dish, F = -s (m a + zeta V).

    The velocity and the acceleration of the liquid are 1 - s times those of the dish, V and a. At s = 0 the liquid
    moves with the dish, and there is no force: the effective gravity is uniform, but tilted. At s = 1 the liquid is at
    rest, and the full inertial force and drag act.

    >>> left_behind(2.0, 0.5, 3.0, 4.0, 0.0) == 0.0, left_behind(2.0, 0.5, 3.0, 4.0, 1.0)
    (True, -8.0)
    """
    return -slip * (mass * acceleration + friction * velocity)
