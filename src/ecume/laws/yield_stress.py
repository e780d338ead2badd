"""Liquids whose viscosity depends on the rate of strain (power law, Bingham, Herschel-Bulkley), and their channel flow.

The stress is tau = tau_y + K g^n where it exceeds the yield stress, with g = sqrt(2 S:S) the rate of strain. Below the
yield stress such a liquid does not flow. Here it creeps with a largest viscosity, the regularized viscosity of
[liu2016], which limits the time step of a simulation.
"""

from __future__ import annotations

import math
from typing import Annotated

from ecume.units import Length, Number, Pressure, Speed, Unit, Viscosity

Rate = Annotated[float, Unit("1/s")]
PressureGradient = Annotated[float, Unit("Pa/m")]
SLOWEST = 1e-30
"""1/s: prevents a division by zero for a liquid at rest"""
BISECTIONS = 64
"""The number of bisections, which resolve 60 decades to full precision."""


def apparent_viscosity(
    strain_rate: Rate, consistency: Number, exponent: Number, yield_stress: Pressure, largest: Viscosity
) -> Viscosity:
    """Apparent viscosity, stress over rate of strain, K g^(n - 1) + tau_y/g, at most the largest
    [herschel1926].

    consistency: K in Pa s^n; exponent: n, 1 for Bingham's liquid; yield_stress: tau_y, 0 for a power law.

    >>> apparent_viscosity(2.0, 3.0, 1.0, 8.0, 100.0)
    7.0
    >>> apparent_viscosity(0.0, 3.0, 1.0, 8.0, 100.0)
    100.0
    """
    rate = max(strain_rate, SLOWEST)
    return min(consistency * math.pow(rate, exponent - 1.0) + yield_stress / rate, largest)


def creep_rate(consistency: Number, exponent: Number, yield_stress: Pressure, largest: Viscosity) -> Rate:
    """Rate of strain below which the viscosity is the largest: K g^n + tau_y = largest g.

    The stress there exceeds the yield stress by K g^n. The rate is 0 if the viscosity never reaches the largest. With a
    yield stress and n > 1, the viscosity has a minimum, beyond which the liquid thickens.

    >>> round(creep_rate(3.0, 1.0, 8.0, 103.0), 12)
    0.08
    """
    if consistency == 0.0:
        return yield_stress / largest
    below, above = SLOWEST, 1.0 / SLOWEST
    if exponent > 1.0:
        above = max((yield_stress / (consistency * (exponent - 1.0))) ** (1.0 / exponent), SLOWEST)
    if apparent_viscosity(below, consistency, exponent, yield_stress, math.inf) <= largest:
        return 0.0
    for _ in range(BISECTIONS):
        middle = math.sqrt(below * above)
        if apparent_viscosity(middle, consistency, exponent, yield_stress, math.inf) > largest:
            below = middle
        else:
            above = middle
    return above


def channel_speed(
    from_middle: Length,
    half_width: Length,
    pressure_gradient: PressureGradient,
    consistency: Number,
    exponent: Number,
    yield_stress: Pressure,
) -> Speed:
    """The speed in a plane channel between walls at rest, with a plug in its middle where the stress is below yield.

    u = n/(n + 1) (G/K)^(1/n) [(h - y_p)^(1 + 1/n) - (y - y_p)^(1 + 1/n)] solves K |du/dy|^n = G y - tau_y with u = 0 at
    the wall; G: pressure_gradient, h: half_width, y_p = tau_y/G, y: from_middle, y_p in the plug.

    >>> round(channel_speed(0.0, 1.0, 2.0, 1.0, 1.0, 0.0), 12)  # parabola: G h^2 / 2 K
    1.0
    """
    plug = yield_stress / pressure_gradient
    if plug >= half_width:
        return 0.0
    power = 1.0 + 1.0 / exponent
    beyond = max(abs(from_middle), plug) - plug
    scale = (pressure_gradient / consistency) ** (1.0 / exponent) / power
    return float(scale * ((half_width - plug) ** power - beyond**power))
