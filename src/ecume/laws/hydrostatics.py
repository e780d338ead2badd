"""Liquids at rest under gravity: hydrostatic and absolute pressure, and the exact compressible column.

`column_pressure` and `column_height` solve dp/dy = -rho g with Tait's law and p = 0 at the top: the exact state of a
tank at rest. With c_0 = 10 sqrt(g H) the column is 0.487 % shorter than H, which limits the agreement with rho_0 g (H -
y).
"""

from __future__ import annotations

import math
from typing import Annotated

from ecume.errors import BadInput
from ecume.laws.arguments import require_not_negative, require_positive
from ecume.laws.states import (
    WATER_EXPONENT,
    Densities,
    Pressures,
    speed_of_stiffness,
    tait_density,
    tait_pressure,
)
from ecume.units import Acceleration, Density, Length, Number, Pressure, Speed, Unit, Value

Heights = Annotated[Value, Unit("m")]


def hydrostatic_pressure(
    height: Heights[Value], surface_height: Length, reference_density: Density, gravity: Acceleration
) -> Pressures[Value]:
    """Hydrostatic pressure rho_0 g (H - y) at the height y below a surface at H; negative above H.

    Its gradient exactly balances the weight of a liquid of density rho_0; the gradient of rho_i g (H - y) does not.
    [batchelor1967].

    >>> round(hydrostatic_pressure(0.25, 1.0, 1000.0, 9.81), 6)
    7357.5
    """
    return reference_density * gravity * (surface_height - height)


def absolute_pressure(
    density: Densities[Value],
    height: Heights[Value],
    surface_height: Length,
    *,
    reference_density: Density = 1000.0,
    sound_speed: Speed | None = None,
    stiffness: Pressure | None = None,
    exponent: Number = WATER_EXPONENT,
    gravity: Acceleration = 9.81,
    atmospheric_pressure: Pressure = 0.0,
) -> Pressures[Value]:
    """Pressure b ((rho/rho_0)^gamma - 1) + rho g (H - y) + p_atm of a particle, a form used for reservoirs.

    rho, y: the particle's own density and height; H: surface_height; b from stiffness, or from sound_speed. Without
    p_atm it is a gauge pressure. The sum is meaningful only for certain forces on the particles [batchelor1967]:

    1. Gravity acts, forces come from Tait's part alone (the usual scheme): at rest Tait's part is rho_0 g (H - y)
       already, and this sum counts it TWICE: 2 rho_0 g H at the bottom. Use `tait_pressure`.
    2. No gravity acts, forces come from Tait's part alone: the sum is the pressure, in tanks that are closed or full,
       where no surface moves. With a free surface, waves would not fall and dams would not break.
    3. Gravity acts, forces come from the whole sum: right while the surface stays at H, wrong where it leaves it.

    In 2 and 3 the second term should have rho_0, see `hydrostatic_pressure`; with rho, as here, the forces at rest are
    off by drho/rho_0. `hydrostatic_fault` determines the case of a run.

    >>> round(absolute_pressure(1000.0, 0.0, 1.0, sound_speed=40.0, atmospheric_pressure=101325.0), 6)
    111135.0
    """
    c0 = _sound_speed(sound_speed, stiffness, reference_density, exponent)
    require_not_negative("atmospheric_pressure", atmospheric_pressure)
    compressed = tait_pressure(density, reference_density, c0, exponent)
    return compressed + density * gravity * (surface_height - height) + atmospheric_pressure


def hydrostatic_fault(*, added: bool, gravity_acts: bool, in_forces: bool, free_surface: bool) -> str:
    """The reason why a run that adds rho_0 g (H - y) to Tait's pressure would be wrong; empty if it
    would be right.

    added: the term is part of the pressure reported; gravity_acts: particles have weight; in_forces: the term is part
    of the pressure in the forces; free_surface: some of the liquid's surface can move. The cases are those of
    `absolute_pressure`.

    >>> hydrostatic_fault(added=True, gravity_acts=False, in_forces=False, free_surface=False)
    ''
    """
    if not added:
        return ""
    if gravity_acts and not in_forces:
        return (
            "the particles feel gravity, so that Tait's pressure at rest is rho_0 g (H - y) already: adding the "
            "hydrostatic part counts it twice; leave it out"
        )
    if not gravity_acts and in_forces:
        return (
            "the hydrostatic part would push particles up that feel no gravity; let gravity act, or keep it out of "
            "the forces"
        )
    if free_surface:
        return (
            "a hydrostatic part measured from a level H is right only where the surface stays at H: on a moving "
            "surface waves would feel no gravity; leave it out, or close the tank"
        )
    return ""


def _sound_speed(speed: Speed | None, stiff: Pressure | None, reference_density: Density, exponent: Number) -> Speed:
    require_positive("reference_density", reference_density)
    require_positive("exponent", exponent)
    if (speed is None) == (stiff is None):
        raise BadInput("give either sound_speed or stiffness: each follows from the other")
    if speed is not None:
        require_positive("sound_speed", speed)
        return speed
    assert stiff is not None  # noqa: S101  # for the type checker: one of the two is there
    require_positive("stiffness", stiff)
    return speed_of_stiffness(stiff, reference_density, exponent)


Load = Annotated[float, Unit("kg/m^2")]


def hydrostatic_density(
    depth: Length, gravity: Acceleration, reference_density: Density, sound_speed: Speed,
    exponent: Number = WATER_EXPONENT,
) -> Density:  # fmt: skip
    """Density rho = rho_0 (1 + (gamma-1) g d/c_0^2)^(1/(gamma-1)) at the depth d below the top of the column.

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
    """Gauge pressure at the depth d below the top, from Tait's law at the `hydrostatic_density`.
    [monaghan1994].

    >>> column_pressure(1.0, 10.0, 1000.0, 1e4) / 10000.0 - 1.0 < 1e-6
    True
    """
    density = hydrostatic_density(depth, gravity, reference_density, sound_speed, exponent)
    return tait_pressure(density, reference_density, sound_speed, exponent)


def column_height(
    load: Load, gravity: Acceleration, reference_density: Density, sound_speed: Speed,
    exponent: Number = WATER_EXPONENT,
) -> Length:  # fmt: skip
    """Height of a column with this mass per square meter, a little less than load / rho_0.

    The pressure at the bottom is exactly load times g. The density there follows from Tait's law, and the height from
    the profile of the density. [monaghan1994].

    >>> f"{1.0 - column_height(1.0, 1.0, 1.0, 10.0):.5%}"
    '0.48715%'
    """
    ratio = tait_density(load * gravity, reference_density, sound_speed, exponent) / reference_density
    scale = sound_speed * sound_speed / gravity
    if exponent == 1.0:
        return scale * math.log(ratio)
    return float(scale / (exponent - 1.0) * (ratio ** (exponent - 1.0) - 1.0))
