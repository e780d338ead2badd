"""Ellipsoids in a liquid surface: how their contact line rises and falls, what they drag as they glide and turn."""

from __future__ import annotations

import math
from typing import Annotated

from ecume.laws.drag import TurningFriction
from ecume.units import Angle, Friction, Length, Unit, Viscosity

PerLength = Annotated[float, Unit("1/m")]
PerVolume = Annotated[float, Unit("1/m^3")]


def ellipsoid_undulation(along: Length, across: Length, contact_angle: Angle) -> Length:
    """H of the contact line H cos 2 phi of a free ellipsoid, phi from its first semi-axis: H = -(a - b)/6 sin^2 cos.

    Exact to first order in a - b for small ones, whatever the upright semi-axis (which bends all sides alike). For r
    = R (1 + f), Young's law at the polar angle theta says H (1 + m) = R (cos f - sin f_theta)_m in mode m. A wetted
    ellipsoid (below 90 degrees) has dips at its tips and rises at its flanks; at 90 degrees none. The second order is
    ignored: with a = 3 b it is a guess of the right sign. First order of [vannierop2005]; compare [lehle2008].

    >>> ellipsoid_undulation(1.2, 1.0, 1.0) < 0.0 < ellipsoid_undulation(1.2, 1.0, 2.0)
    True
    """
    return -(along - across) / 6.0 * math.sin(contact_angle) ** 2 * math.cos(contact_angle)


def _chi(along: Length, across: Length, upright: Length) -> PerLength:
    """The integral of 1/Delta over all confocal ellipsoids, Delta^2 = (a^2 + s)(b^2 + s)(c^2 + s) [lamb1932]."""
    from scipy.special import elliprf

    return 2.0 * float(elliprf(along**2, across**2, upright**2))


def _alpha(along: Length, across: Length, upright: Length) -> PerVolume:
    """The integral of 1/((a^2 + s) Delta) over all confocal ellipsoids [lamb1932]."""
    from scipy.special import elliprd

    return 2.0 / 3.0 * float(elliprd(across**2, upright**2, along**2))


def ellipsoid_friction(along: Length, across: Length, upright: Length, viscosity: Viscosity) -> Friction:
    """Friction of an ellipsoid that glides along its first semi-axis, deep in a liquid: 16 pi eta / (chi + a^2 alpha).

    Half of it where the liquid ends at a plane of symmetry that is free of shear. A sphere has 6 pi eta R, a disc
    edgewise (32/3) eta a. [lamb1932, par. 339].

    >>> round(ellipsoid_friction(1.0, 1.0, 1.0, 1.0) / math.pi, 12)
    6.0
    """
    return 16.0 * math.pi * viscosity / (_chi(along, across, upright) + along**2 * _alpha(along, across, upright))


def ellipsoid_turning_friction(along: Length, across: Length, upright: Length, viscosity: Viscosity) -> TurningFriction:
    """Friction of an ellipsoid that turns about its upright semi-axis, deep in a liquid.

    (16/3) pi eta (a^2 + b^2) / (a^2 alpha + b^2 beta). A sphere has 8 pi eta R^3, a disc (32/3) eta a^3.
    [jeffery1922].

    >>> round(ellipsoid_turning_friction(1.0, 1.0, 1.0, 1.0) / math.pi, 12)
    8.0
    """
    resisting = along**2 * _alpha(along, across, upright) + across**2 * _alpha(across, along, upright)
    return 16.0 / 3.0 * math.pi * viscosity * (along**2 + across**2) / resisting
