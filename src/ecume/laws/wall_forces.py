"""Walls and particles of a liquid: repulsion close to a wall, the braking of impacts, the wet part of a sensor.

`standoff_push` is a spring over the last part of a spacing. A particle that touches a mirror coincides with its image,
and lies in one plane with all others that touch it: pairs push along that plane or not at all, and nothing lifts any of
them, however large the pressure. Gaps are measured from the wall into the liquid, and pushes are positive away from the
wall.

`impact_braking` is the dissipative pressure of the Riemann problem at a wall, summed over the half-space behind it. A
sum over images has one image for each particle that arrives: too little for the tip of a jet of one or two particles,
which would stop elastically in a water hammer of rho c u.

A reading of pressure is a force per area: dry parts of a sensor have none. Each particle is smeared over a Gaussian of
variance dx^2/2. The sum over particles is 1 in the liquid, 1/2 at its surface, half a spacing beyond the last row, and
0 in the air; a sheet as thick as one spacing reaches 0.52. Where a wall or a solid takes up a part of the surroundings,
the sum is compared with what is left.
"""

from __future__ import annotations

import math
from typing import Annotated

from ecume.laws.states import SpecificEnergy
from ecume.units import Acceleration, Length, Number, Speed, Unit


def standoff_push(gap: Length, reach: Length, speed: Speed) -> Acceleration:
    """Acceleration (v/z)^2 (z - d) at a gap d below the range z, otherwise 0: particles with the speed v just reach the
    wall.

    The plainest of the repulsions that walls are made of elsewhere [monaghan1994]; here it is a stand-in for what sums
    do not resolve, and zero for all liquid that keeps its distance. Weight w presses it in by w z^2/v^2.

    >>> round(standoff_push(0.05, 0.1, 2.0), 12), standoff_push(0.2, 0.1, 2.0)
    (20.0, 0.0)
    """
    stiffness = speed / reach
    return stiffness * stiffness * max(reach - gap, 0.0)


def standoff_energy(gap: Length, reach: Length, speed: Speed) -> SpecificEnergy:
    """Potential v^2 (1 - d/z)^2 / 2 of this force at a gap d below the range z, otherwise 0
    [monaghan1994].

    >>> standoff_energy(0.0, 0.1, 2.0), standoff_energy(0.1, 0.1, 2.0)
    (2.0, 0.0)
    """
    missing = max(1.0 - gap / reach, 0.0)
    return 0.5 * speed * speed * missing * missing


LIMITER = 3.0
"""The factor of dissipation at small differences of velocity [zhang2017]."""
PerLength = Annotated[float, Unit("1/m")]


def impact_braking(
    approach: Speed, plane_weight: PerLength, sound_speed: Speed, limiter: Number = LIMITER
) -> Acceleration:
    """Acceleration min(eta U, c) U w away from the wall for liquid that approaches at u, with U = 2 u; zero for liquid
    that leaves.

    Riemann problem of the liquid and its mirror image, p* = p + rho min(eta U, c) U / 2 with the difference U of their
    velocities and eta = 3, limiter [zhang2017, eqs. 10 and 11], summed over the half-space behind the wall as in eq. 9:
    w, plane_weight, is the kernel summed over a plane at the particle's distance. Liquid at rest or in motion along
    the wall feels nothing; for small u the braking is of second order.

    >>> impact_braking(0.5, 2.0, 10.0), impact_braking(10.0, 2.0, 10.0), impact_braking(-1.0, 2.0, 10.0)
    (6.0, 400.0, 0.0)
    """
    both = 2.0 * max(approach, 0.0)
    return min(limiter * both, sound_speed) * both * plane_weight


SPREAD = math.sqrt(0.5)
"""Standard deviation of a particle's Gaussian, in spacings. The sum over a square lattice ripples by 2 exp(-pi^2)."""


def smeared(q: Number, dim: Number) -> Number:
    """exp(-q^2) / pi^(d/2), the Gaussian of a particle at q spacings, times its volume in units of spacing^d.

    Its integral is 1, as that of every smoothing kernel [liu2003].

    >>> round(smeared(0.0, 2.0) * math.pi, 12)
    1.0
    """
    return math.exp(-q * q) / math.pow(math.pi, 0.5 * dim)


def between_planes(low: Length, high: Length, spacing: Length) -> Number:
    """(erf(b/dx) - erf(a/dx)) / 2, the part of a Gaussian between two planes at a and b from its center.

    The room that walls leave: kernels that they cut off are divided by it [bonet1999].

    >>> between_planes(0.0, math.inf, 0.1), between_planes(-math.inf, math.inf, 0.1)
    (0.5, 1.0)
    """
    return 0.5 * (math.erf(high / spacing) - math.erf(low / spacing))


def covered_part(filled: Number, room: Number) -> Number:
    """min(1, 2 filled/room): 1 in the liquid up to its surface, where half of the room is filled, and less outside.

    Elsewhere sums over less than half of a kernel are not normalized, or count as dry [dominguez2022]; this is the
    continuous form.

    >>> covered_part(0.5, 1.0), covered_part(0.1, 1.0), covered_part(0.25, 0.5), covered_part(0.0, 0.0)
    (1.0, 0.2, 1.0, 1.0)
    """
    return 1.0 if 2.0 * filled >= room else 2.0 * filled / room
