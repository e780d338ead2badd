"""Which part of a sensor is covered with liquid. A reading of pressure is a force per area: dry parts have none.

Each particle is smeared over a Gaussian of variance dx^2/2. The sum over particles is 1 in the liquid, 1/2 at its
surface, half a spacing beyond the last row, and 0 in the air; a sheet as thick as one spacing reaches 0.52. Where a
wall or a solid takes up a part of the surroundings, the sum is compared with what is left.
"""

from __future__ import annotations

import math

from ecume.units import Length, Number

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
