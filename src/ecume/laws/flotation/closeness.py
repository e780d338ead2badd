"""How much harder two small spheres close together attract each other than the sum of their menisci says."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ecume.errors import BadInput
from ecume.laws.arguments import elementwise
from ecume.units import Angle, Number

MODES = 80
"""Good to 3e-3 for spheres of 90 degrees that touch, whose contact lines do, and far better otherwise."""
WIDEST = 100.0


@elementwise
@lru_cache(maxsize=1024)
def superposition_excess(contact_angle: Angle, gap: Number) -> Number:
    """Force over `capillarity.pair_force` less one, of two equal spheres much smaller than L; `gap` over a diameter.

    Each contact line slides in the other's curved meniscus and answers its n-th mode with (n-1)/(n+1) of it. The two
    answers are solved for together, with h = Re(A ln z + sum_n a_n z^-n) about each; the force is the residue of
    Blasius's integral, A c_1 - sum_n n (n+1) a_n c_(n+1), with c_n the regular coefficients there. At B = 0.1 the
    excess is a third larger, at B = 1 about three times as large. Derived; the limit of small bodies of
    [vassileva2005].

    >>> [round(superposition_excess(math.radians(degrees), 0.0), 3) for degrees in (30.0, 60.0)]
    [0.003, 0.038]
    """
    rim = 0.5 * math.sin(contact_angle) / (1.0 + gap)  # contact radius over the distance of the centers
    n = np.arange(1, MODES + 2)
    # Lengths over that distance; a_n in rim^n, c_n in rim^-n.
    source = -(rim**n) / n
    mutual = np.array([[math.comb(m + k - 1, k) * rim ** (m + k) for m in n[:-1]] for k in n])
    answer = ((n - 1.0) / (n + 1.0))[:-1]
    own = np.linalg.solve(np.eye(MODES) - answer[:, None] * mutual[:-1], answer * source[:-1])
    regular = source + mutual @ own
    if rim == 0.0:
        return 0.0
    force = -regular[0] / rim + float(np.sum(n[:-1] * n[1:] * own * regular[1:])) / rim
    return float(force) - 1.0


@elementwise
def superposition_reach(contact_angle: Angle, excess: Number) -> Number:
    """The gap, over a diameter, beyond which `superposition_excess` is below `excess`; zero if it always is.

    [vassileva2005].

    >>> superposition_reach(math.radians(60.0), 0.05)
    0.0
    """
    from scipy.optimize import brentq

    if superposition_excess(contact_angle, 0.0) <= excess:
        return 0.0
    least = superposition_excess(contact_angle, WIDEST)
    if excess <= least:
        raise BadInput(
            f"the excess is {excess!r}; expected more than {least:.2g}, that of a gap of {WIDEST:g} diameters"
        )
    return float(brentq(lambda gap: superposition_excess(contact_angle, gap) - excess, 0.0, WIDEST, xtol=1e-9))
