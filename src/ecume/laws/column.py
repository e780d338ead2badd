"""A column of weakly compressible liquid at rest, exactly: what a tank has to look like after a long time.

p = 0 at the top, dp/dy = -rho g, and Tait's law between the two. With c_0 = 10 sqrt(g H) the column is 0.487 % shorter
than H, so that no comparison with rho_0 g (H - y) can be closer than that.
"""

from __future__ import annotations

import math
from typing import Annotated

from ecume.laws.states import WATER_EXPONENT, tait_density, tait_pressure
from ecume.units import Acceleration, Density, Length, Number, Pressure, Speed, Unit

Load = Annotated[float, Unit("kg/m^2")]


def hydrostatic_density(
    depth: Length, gravity: Acceleration, reference_density: Density, sound_speed: Speed,
    exponent: Number = WATER_EXPONENT,
) -> Density:  # fmt: skip
    """Density rho = rho_0 (1 + (gamma-1) g d/c_0^2)^(1/(gamma-1)) at the depth d below the column's own top.

    From dp/dy = -rho g with dp = c^2 drho and Tait's c^2 = c_0^2 (rho/rho_0)^(gamma-1); an exponential for gamma = 1.
    [monaghan1994].

    >>> round(hydrostatic_density(1.0, 1.0, 1000.0, 10.0, 1.0), 6)
    1010.050167
    """
    head = gravity * depth / (sound_speed * sound_speed)
    if exponent == 1.0:
        return reference_density * math.exp(head)
    return float(reference_density * (1.0 + (exponent - 1.0) * head) ** (1.0 / (exponent - 1.0)))


def column_pressure(
    depth: Length, gravity: Acceleration, reference_density: Density, sound_speed: Speed,
    exponent: Number = WATER_EXPONENT,
) -> Pressure:  # fmt: skip
    """Gauge pressure at the depth d below the top: Tait's at the `hydrostatic_density`. [monaghan1994].

    >>> column_pressure(1.0, 10.0, 1000.0, 1e4) / 10000.0 - 1.0 < 1e-6
    True
    """
    density = hydrostatic_density(depth, gravity, reference_density, sound_speed, exponent)
    return tait_pressure(density, reference_density, sound_speed, exponent)


def column_height(
    load: Load, gravity: Acceleration, reference_density: Density, sound_speed: Speed,
    exponent: Number = WATER_EXPONENT,
) -> Length:  # fmt: skip
    """Height of a column that has this mass on each square meter, a little less than load / rho_0.

    The pressure at the bottom is exactly load times g; density there follows from Tait, height from its profile.
    [monaghan1994].

    >>> f"{1.0 - column_height(1.0, 1.0, 1.0, 10.0):.5%}"
    '0.48715%'
    """
    ratio = tait_density(load * gravity, reference_density, sound_speed, exponent) / reference_density
    scale = sound_speed * sound_speed / gravity
    if exponent == 1.0:
        return scale * math.log(ratio)
    return float(scale / (exponent - 1.0) * (ratio ** (exponent - 1.0) - 1.0))
