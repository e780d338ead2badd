"""What keeps a particle from lying on a wall, where pressure cannot: a spring over the last part of a spacing.

A particle that touches a mirror coincides with its image, and lies in one plane with all others that touch it: each
pair pushes along that plane or not at all, and nothing lifts anyone, however large the pressure. Gaps are measured from
the wall into the liquid, pushes are positive away from the wall.
"""

from __future__ import annotations

from ecume.laws.enthalpy import SpecificEnergy
from ecume.units import Acceleration, Length, Speed


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
