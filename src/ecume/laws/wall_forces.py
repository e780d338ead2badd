"""Forces of walls on particles of a liquid: repulsion close to a wall, and the braking of impacts.

`standoff_push` is a spring over the last part of a spacing. A particle that touches a mirror coincides with its image,
and lies in one plane with all others that touch it: pairs push along that plane or not at all, and nothing lifts any of
them, however large the pressure. Gaps are measured from the wall into the liquid, and pushes are positive away from the
wall.

`impact_braking` is the dissipative pressure of the Riemann problem at a wall, summed over the half-space behind it. A
sum over images has one image for each particle that arrives: too little for the tip of a jet of one or two particles,
which would stop elastically in a water hammer of rho c u.
"""

from __future__ import annotations

from typing import Annotated

from ecume.laws.states import SpecificEnergy
from ecume.units import Acceleration, Length, Number, Speed, Unit


def standoff_push(gap: Length, reach: Length, speed: Speed) -> Acceleration:
    """(v/z)^2 (z - d) at a gap d below the reach z, else 0: who comes with the speed v just touches the wall.

    The plainest of the repulsions that walls are made of elsewhere [monaghan1994]; here it is a stand-in for what sums
    do not resolve, and zero for all liquid that keeps its distance. Weight w presses it in by w z^2/v^2.

    >>> round(standoff_push(0.05, 0.1, 2.0), 12), standoff_push(0.2, 0.1, 2.0)
    (20.0, 0.0)
    """
    stiffness = speed / reach
    return stiffness * stiffness * max(reach - gap, 0.0)


def standoff_energy(gap: Length, reach: Length, speed: Speed) -> SpecificEnergy:
    """v^2 (1 - d/z)^2 / 2 at a gap d below the reach z, else 0: what the push gives back [monaghan1994].

    >>> standoff_energy(0.0, 0.1, 2.0), standoff_energy(0.1, 0.1, 2.0)
    (2.0, 0.0)
    """
    missing = max(1.0 - gap / reach, 0.0)
    return 0.5 * speed * speed * missing * missing


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
