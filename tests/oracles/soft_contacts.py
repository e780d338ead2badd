"""How a contact of soft spheres closes and relaxes, in closed form."""

from __future__ import annotations

import math

from ecume.errors import BadInput
from ecume.laws.soft_pair import SoftPair, size_under_force
from ecume.units import Force, Length, Speed, Time


def deflection_under_force(pair: SoftPair, gap: Length, force: Force) -> Length:
    """The deflection delta = F / (alpha_n E a), of the force's sign. [rognon2009, eq. 12].

    >>> round(deflection_under_force(SoftPair(1.0, 1000.0, 1.0), 0.01, 1.0), 8)
    0.00754878
    """
    return force / (pair.prefactors.normal * pair.modulus * size_under_force(pair, gap, force))


def gap_speed(pair: SoftPair, gap: Length, force: Force) -> Speed:
    """|dh/dt| = |F| h^3 / (c_n eta a^4) under a constant force. [rognon2009, eq. 10].

    >>> round(gap_speed(SoftPair(1.0, 1.0, 1.0), 0.01, 3.4641e-3) * 1e7, 4)
    8.1678
    """
    size = size_under_force(pair, gap, force)
    return abs(force) * gap**3 / (pair.prefactors.squeeze * pair.viscosity * size**4)


def relaxation_passage(pair: SoftPair, clearance: Length, deflection_from: Length, deflection_to: Length) -> Time:
    """How long tension takes to relax between two deflections while the centers are held.

    The clearance H = h + delta is that of the spheres as if they were not deflected. With c_h = c_d = c the contact
    size a^2 = R c H does not change, and t = (c_n eta / (alpha_n E)) (R c/H)^(3/2) [Phi(delta0) - Phi(delta1)] with
    Phi(d) = ln(d/(H-d)) + H/(H-d) + H^2/(2 (H-d)^2). From [rognon2009, eq. 10, 12 and 14].

    >>> round(relaxation_passage(SoftPair(1.0, 1000.0, 1.0), 0.05, 0.04, 0.03), 6)
    5.418589
    """
    factors = pair.prefactors
    if factors.gap_weight != factors.deflection_weight:
        raise BadInput("the relaxation has a closed form only where c_h = c_d, as in the prefactors called paper")

    def phi(deflection: float) -> float:
        gap = clearance - deflection
        return math.log(deflection / gap) + clearance / gap + clearance**2 / (2.0 * gap**2)

    level = pair.radius * factors.gap_weight / clearance
    time = factors.squeeze * pair.viscosity / (factors.normal * pair.modulus)
    return time * level * math.sqrt(level) * (phi(deflection_from) - phi(deflection_to))
