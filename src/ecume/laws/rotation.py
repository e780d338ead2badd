"""Floaters that turn about the vertical: how hard they are to turn, and how the liquid drags at them."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from ecume.engine.angle_splines import spline
from ecume.errors import BadInput
from ecume.laws.drag import TurningFriction
from ecume.units import Angles, Length, Mass, Number, Numbers, Unit, Viscosity

Inertia = Annotated[float, Unit("kg*m^2")]

TURNING_FACTORS = (
    0.90154, 0.89833, 0.88826, 0.87005, 0.84180, 0.80134, 0.74683, 0.67749, 0.59422,
    0.50000, 0.39985, 0.30030, 0.20840, 0.13046, 0.07085, 0.03105, 0.00935, 0.00116, 0.0,
)  # fmt: skip
"""At contact angles 0, 10, ... 180 degrees; from a single layer on the wet cap and its mirror image, good to 1e-5."""


def turning_factor(contact_angle: Angles) -> Numbers:
    """The torque on a floating sphere that turns about the vertical, over 8 pi eta R^3 W for one deep in the liquid.

    The flow runs in circles, and v_phi cos(phi) is harmonic outside the wet cap and its mirror image in a flat surface
    that is free of shear. 1/2 at 90 degrees by symmetry; 3 zeta(3)/4 at 0, two spheres that touch and turn as one
    [jeffery1915]; 2 sin^3(theta)/(3 pi) of a thin cap. A cubic spline of the table, flat at both ends.

    >>> round(turning_factor(math.pi / 2), 12)
    0.5
    """
    angles = np.asarray(contact_angle, dtype=np.float64)
    if not bool(np.all((angles >= 0.0) & (angles <= math.pi))):
        raise BadInput(f"contact_angle is {contact_angle!r}; expected radians between 0 and pi")
    factors = np.maximum(spline(angles, TURNING_FACTORS, 0.0), 0.0)
    return float(factors) if factors.ndim == 0 else factors


def sphere_turning_friction(radius: Length, viscosity: Viscosity, factor: Number) -> TurningFriction:
    """Zeta = 8 pi eta R^3 times the factor: the torque per spin on a slow floater. [lamb1932, par. 334].

    >>> round(sphere_turning_friction(1.0, 1.0, 0.5) / math.pi, 12)
    4.0
    """
    return 8.0 * math.pi * viscosity * radius**3 * factor


def sphere_inertia(mass: Mass, radius: Length) -> Inertia:
    """I = (2/5) m R^2, of a solid sphere. [lamb1932].

    >>> sphere_inertia(5.0, 1.0)
    2.0
    """
    return 0.4 * mass * radius * radius


def disc_inertia(mass: Mass, radius: Length) -> Inertia:
    """I = m a^2/2, of a solid disc about its axis. [lamb1932].

    >>> disc_inertia(2.0, 3.0)
    9.0
    """
    return 0.5 * mass * radius * radius
