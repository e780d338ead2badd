"""Forces on a small sphere in a liquid with unsteady and nonuniform velocity, in addition to drag and buoyancy."""

from __future__ import annotations

import math
from typing import Annotated

from ecume.units import (
    Acceleration,
    Density,
    Force,
    KinematicViscosity,
    Length,
    Mass,
    Number,
    Rate,
    Speed,
    Unit,
    Viscosity,
)

Curvature = Annotated[float, Unit("1/(m*s)")]
"""The Laplacian of a velocity."""


def liquid_inertia(displaced: Mass, acceleration: Acceleration, coefficient: Number) -> Force:
    """The force by the acceleration of the liquid, m_f (1 + C) Du/Dt: its pressure gradient, and the added mass.

    m_f: the `displaced` mass; C: the added mass over it, 1/2 of a sphere. The added mass also resists the
    acceleration of the particle itself, which is part of its inertia. [maxey1983].

    >>> liquid_inertia(2.0, 3.0, 0.5)
    9.0
    """
    return displaced * (1.0 + coefficient) * acceleration


def faxen_velocity(radius: Length, curvature: Curvature) -> Speed:
    """Addition to the velocity of the liquid in Stokes drag for a curved profile, (a^2/6) lap u.

    [maxey1983].

    >>> faxen_velocity(0.1, -6.0)
    -0.010000000000000002
    """
    return radius * radius / 6.0 * curvature


def saffman_lift(slip: Speed, radius: Length, density: Density, viscosity: Viscosity, rate: Rate) -> Force:
    """Saffman's lift on a sphere that moves along sheared liquid, 6.46 a^2 |u - v| sqrt(rho eta G).

    It acts along (u - v) x curl u: a sphere that lags moves toward faster liquid. u - v: the `slip`; G: the rate of
    shear. For Reynolds numbers of slip and shear below 1, that of the slip below the root of that of the shear, and far
    from walls. [saffman1965], whose abstract has the factor 81.2; OpenFOAM and waLBerla have 6.46. The corrigendum of
    1968 was not read.

    >>> round(saffman_lift(0.1, 1e-3, 1000.0, 1e-3, 4.0) * 1e6, 4)
    1.292
    """
    return 6.46 * radius * radius * slip * math.sqrt(density * viscosity * rate)


def history_ratio(radius: Length, kinematic_viscosity: KinematicViscosity, rate: Rate) -> Number:
    """Basset's history force over Stokes drag for a relative velocity that oscillates, a sqrt(w/nu).

    w: `rate`, the angular frequency. [maxey1983].

    >>> history_ratio(1e-3, 1e-6, 1.0)
    1.0
    """
    return radius * math.sqrt(rate / kinematic_viscosity)
