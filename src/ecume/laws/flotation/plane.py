"""The surface beside a straight contact line: the Young–Laplace equation in two dimensions, exact. Lengths in L."""

from __future__ import annotations

import math

from ecume.units import Angle, Number


def sloping_height(slope_angle: Angle) -> Number:
    """Height of a straight contact line that the surface leaves with a slope angle, z = -2 sin(psi/2).

    psi is positive where the surface rises away from the line, which then lies low. [landau1987, par. 61].

    >>> round(sloping_height(-math.radians(60.0)), 12)
    1.0
    """
    return -2.0 * math.sin(0.5 * slope_angle)


def sloping_amplitude(slope_angle: Angle) -> Number:
    """The amplitude of exp(-x) far from a straight contact line, with x from that line; signed as the height is.

    4 exp(-2 - u + 2 tanh u) with u = arccosh(2/|z|); holds past the vertical, where x at first falls. Derived from
    [landau1987, par. 61].

    >>> round(sloping_amplitude(-math.pi / 2), 12)
    0.922317584014
    """
    height = sloping_height(slope_angle)
    if height == 0.0:
        return 0.0
    u = math.acosh(2.0 / abs(height))
    return math.copysign(4.0 * math.exp(-2.0 - u + 2.0 * math.tanh(u)), height)
