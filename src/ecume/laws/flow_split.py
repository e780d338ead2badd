"""The flow of a point force in two parts, as Ewald sums of Stokes flow have them: one of short range, one smooth.

The smooth part is the flow of a force that is spread like (1 + k^2 w^2/4) exp(-k^2 w^2/4) over waves of wavenumber k
[hasimoto1959]. The rest decays as exp(-r^2/w^2). Both parts are flows of an incompressible liquid. Two spheres of radii
a and b have the mobility 6 pi eta M = S + (a^2 + b^2) D with D the Laplacian of S over 6: `pair_mobility.rotne_prager`.
Distances x = r/w are over the width w.
"""

from __future__ import annotations

import math

from ecume.units import Number

SLOPE = 2.0 / math.sqrt(math.pi)
"""of erf at zero"""
NEAR = 0.1
"""Below it the difference of two almost equal terms is a series."""


def smooth_flow(x: Number) -> tuple[float, float]:
    """The smooth part of S times w: velocities across and along the direction to a unit force, times
    6 pi eta.

    Far away 3/(4 x) and 3/(2 x); at zero 3/sqrt(pi). [hasimoto1959].

    >>> across, along = smooth_flow(8.0)
    >>> round(across * 8.0, 12), round(along * 8.0, 12)
    (0.75, 1.5)
    """
    bell = SLOPE * math.exp(-x * x)
    steep = math.erf(x) / x if x > 0.0 else SLOPE
    return 0.75 * (steep + bell), 1.5 * steep


def smooth_curvature(x: Number) -> tuple[float, float]:
    """The smooth part of D times w^3: far away 1/(4 x^3) and -1/(2 x^3). [hasimoto1959].

    >>> across, along = smooth_curvature(8.0)
    >>> round(across * 8.0**3, 12), round(along * 8.0**3, 12)
    (0.25, -0.5)
    """
    square = x * x
    bell = SLOPE * math.exp(-square)
    if x < NEAR:
        rest = SLOPE * (2.0 / 3.0 - square * (0.4 - square * (1.0 / 7.0 - square * (1.0 / 27.0 - square / 132.0))))
    else:
        rest = (math.erf(x) / x - bell) / square
    across = 0.125 * (bell * (4.0 * square - 8.0) + 2.0 * rest)
    return across, across + 0.125 * (bell * (4.0 - 4.0 * square) - 6.0 * rest)
