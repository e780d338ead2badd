"""Impacts of liquid on a wall: the dissipative pressure of the Riemann problem there, summed over the whole wall.

A sum over images has one image for each particle that arrives: too little for the tip of a jet, of one or two
particles, which then stops elastically in a water hammer of rho c u. The wall itself fills its half-space.
"""

from __future__ import annotations

from typing import Annotated

from ecume.units import Acceleration, Number, Speed, Unit

LIMITER = 3.0
"""How much of the dissipation small differences of velocity get [zhang2017]."""
PerLength = Annotated[float, Unit("1/m")]


def impact_braking(
    approach: Speed, plane_weight: PerLength, sound_speed: Speed, limiter: Number = LIMITER
) -> Acceleration:
    """min(eta U, c) U w away from the wall, of liquid that approaches at u, U = 2 u; zero for liquid that leaves.

    Riemann problem of the liquid and its mirror image, p* = p + rho min(eta U, c) U / 2 with the difference U of their
    velocities and eta = 3, limiter [zhang2017, eqs. 10 and 11], summed over the half-space behind the wall as in eq. 9:
    w, plane_weight, is the kernel summed over a plane at the particle's distance. Liquid at rest or in motion along
    the wall feels nothing; for small u the braking is of second order.

    >>> impact_braking(0.5, 2.0, 10.0), impact_braking(10.0, 2.0, 10.0), impact_braking(-1.0, 2.0, 10.0)
    (6.0, 400.0, 0.0)
    """
    both = 2.0 * max(approach, 0.0)
    return min(limiter * both, sound_speed) * both * plane_weight
