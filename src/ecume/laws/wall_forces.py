"""Forces at walls on liquid particles: short-range repulsion and braking of impacts; and the wet
part of a sensor.

`standoff_push` is a spring over the last part of a spacing. A particle at a mirror plane coincides with its image, and
all such particles are in one plane, so that pair forces cannot move them away from it at any pressure. Gaps are
measured from the wall into the liquid, and forces are positive away from the wall.

`impact_braking` is the dissipative pressure of the Riemann problem at a wall, summed over the half-space behind it. A
sum over images has one image for each arriving particle. This is not enough at the tip of a jet of one or two
particles, which would stop elastically with a water hammer of rho c u.

The reading of a pressure sensor is a force per area; dry parts contribute no force. Each particle is smoothed to a
Gaussian of variance dx^2/2. The sum over particles is 1 in the liquid, 1/2 at its surface, half a spacing beyond the
last row, and 0 in the air; a sheet as thick as one spacing reaches 0.52. Near walls and solids the sum is divided by
the free part of the surroundings.
"""

from __future__ import annotations

import math
from typing import Annotated

from ecume.laws.states import SpecificEnergy
from ecume.units import Acceleration, Length, Number, Speed, Unit


def standoff_push(gap: Length, reach: Length, speed: Speed) -> Acceleration:
    """Acceleration (v/z)^2 (z - d) at a gap d below the range z, otherwise 0; particles with the speed v just reach the
    wall.

    The simplest of the common wall repulsions [monaghan1994]; here it replaces forces that sums do not resolve, and is
    zero for liquid beyond z. A weight w compresses it by w z^2/v^2.

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
    w, plane_weight, is the kernel summed over a plane at the particle's distance. It is zero for liquid at rest or in
    motion along the wall, and of second order for small u.

    >>> impact_braking(0.5, 2.0, 10.0), impact_braking(10.0, 2.0, 10.0), impact_braking(-1.0, 2.0, 10.0)
    (6.0, 400.0, 0.0)
    """
    both = 2.0 * max(approach, 0.0)
    return min(limiter * both, sound_speed) * both * plane_weight


SPREAD = math.sqrt(0.5)
"""Standard deviation of a particle's Gaussian, in spacings. The sum over a square lattice varies by 2 exp(-pi^2)."""


def smeared(q: Number, dim: Number) -> Number:
    """Gaussian exp(-q^2) / pi^(d/2) of a particle at q spacings, times its volume in units of
    spacing^d.

    Its integral is 1, as that of every smoothing kernel [liu2003].

    >>> round(smeared(0.0, 2.0) * math.pi, 12)
    1.0
    """
    return math.exp(-q * q) / math.pow(math.pi, 0.5 * dim)


def between_planes(low: Length, high: Length, spacing: Length) -> Number:
    """Part (erf(b/dx) - erf(a/dx)) / 2 of a Gaussian between two planes at a and b from its center.

    This is the part of a kernel inside of walls; truncated kernels are divided by it [bonet1999].

    >>> between_planes(0.0, math.inf, 0.1), between_planes(-math.inf, math.inf, 0.1)
    (0.5, 1.0)
    """
    return 0.5 * (math.erf(high / spacing) - math.erf(low / spacing))


def covered_part(filled: Number, room: Number) -> Number:
    """Wet part min(1, 2 filled/room): 1 in the liquid up to its surface, where half of the room is filled, and less
    outside.

    Other codes do not normalize sums over less than half of a kernel, or count them as dry [dominguez2022]; this form
    is continuous.

    >>> covered_part(0.5, 1.0), covered_part(0.1, 1.0), covered_part(0.25, 0.5), covered_part(0.0, 0.0)
    (1.0, 0.2, 1.0, 1.0)
    """
    return 1.0 if 2.0 * filled >= room else 2.0 * filled / room
