"""The original project's closure: a contact angle computed from the weight, kept by name to reproduce its figures."""

from __future__ import annotations

import math

from ecume.errors import BadInput
from ecume.laws.arguments import elementwise
from ecume.laws.flotation.bodies import weight_number
from ecume.units import Angle, Number


@elementwise
def closure_contact_angle(bond_number: Number, density_ratio: Number) -> Angle:
    """The contact angle that the original project derives from B and D; raises BadInput if there is no solution.

    phi_c = arcsin(pi B/2) = pi - theta + arctan(z'_c) put into its (13): (pi/2) tan(theta + phi_c) = Sigma(D,
    theta), solved on the branch of slopes below 90 degrees. A root needs B <= 2/pi and tan(arcsin(pi B/2)) >= 4 D/(3
    pi). Erratum of [canbraun2022, eq. 6 to 17]: a contact angle is a property of the materials, whatever the weight.
    Its phi_c is the slope relation of a horizontal cylinder without the density; small spheres would be dry, where
    in truth phi_c tends to pi - theta. Its (15) and (16) drop the factor pi/2, and its expansion (17) lacks
    sin(theta)/3; here (13) itself is solved.

    >>> round(math.degrees(closure_contact_angle(bond_number=0.6, density_ratio=0.5)), 4)
    117.2475
    """
    from scipy.optimize import brentq

    filling = math.asin(min(1.0, 0.5 * math.pi * bond_number))

    def excess(angle: float) -> float:
        return 0.5 * math.pi * math.tan(angle + filling - math.pi) - weight_number(density_ratio, angle)

    lowest = 0.5 * math.pi - filling
    if 0.5 * math.pi * bond_number > 1.0 or not excess(math.pi) >= 0.0 or not excess(lowest + 1e-9) < 0.0:
        raise BadInput(
            f"the original closure has no contact angle for B = {bond_number:g} and D = {density_ratio:g}: "
            "it needs B <= 2/pi and tan(arcsin(pi B/2)) >= 4 D/(3 pi); give the contact angle of the material instead"
        )
    return float(brentq(excess, lowest + 1e-9, math.pi, xtol=1e-14))
