"""Drops: their pressure in a central force, and the period and decay of their oscillations."""

from __future__ import annotations

import cmath
import math
from typing import Annotated

import numpy as np

from ecume.errors import BadInput
from ecume.laws.arguments import require_not_negative, require_positive
from ecume.laws.flows import CHANNEL_MODES
from ecume.laws.water_waves import Decay, SpecificTension
from ecume.units import (
    Density,
    KinematicViscosity,
    Length,
    Number,
    Pressure,
    Rate,
    Time,
    Unit,
)

Stretching = Annotated[float, Unit("1/s^2")]


def patch_pressure(across: Length, along: Length, width: Length, stretching: Stretching, density: Density) -> Pressure:
    """Gauge pressure in a square of liquid without walls at the instant at which it moves as v = G x.

    rho S sum over odd m, n of 16/(m n pi^2 ((m pi/L)^2 + (n pi/L)^2)) sin(m pi x/L) sin(n pi y/L), from one corner: the
    solution of lap p = -rho S with S = tr(G^2) that is zero on the sides. For rigid rotation, S = -2 w^2, it is
    negative everywhere inside. L: width. [colagrossi2005].

    >>> round(patch_pressure(0.5, 0.5, 1.0, -2.0, 1.0), 6)
    -0.147343
    """
    modes = np.arange(1, CHANNEL_MODES + 1, 2) * math.pi / width
    m, n = modes[:, None], modes[None, :]
    terms = np.sin(m * across) * np.sin(n * along) / (m * n * (m * m + n * n))
    return float(16.0 * density * stretching / width**2 * terms.sum())


def ball_pressure(
    distance: Length, radius: Length, stretching: Stretching, density: Density, dimensions: Number
) -> Pressure:
    """Gauge pressure in a disc or ball of liquid without walls while it moves as v = G x, rho S (R^2 - r^2)/(2 d).

    S = tr(G^2) + d w^2, where the acceleration to the center is w^2 times the distance; S = 2 s^2 for a disc that is
    stretched at the rate s. The solution of lap p = -rho S that is zero on the surface. d: dimensions. [monaghan1994]
    with w = 0, [monaghan2013].

    >>> ball_pressure(0.0, 1.0, 2.0 * 100.0**2, 1.0, 2.0)
    5000.0
    """
    return 0.5 * density * stretching / dimensions * (radius**2 - distance**2)


def drop_strain_change(strain_rate: Rate, pull_rate: Rate, width: Length, height: Length) -> Stretching:
    """Time derivative of the strain rate of an elliptic drop, (s^2 + w^2) (b^2 - a^2)/(a^2 + b^2). The drop flows as u
    = s x, v = -s y, so that da/dt = s a and db/dt = -s b; the acceleration to the center is w^2 times the distance
    (zero if w = 0). s: rate of strain; w: rate of the pull; a: width, b: height, both half. (s^2 + w^2) (a^2 + b^2) is
    conserved. [monaghan1994] with w = 0, [monaghan2013].

    >>> drop_strain_change(2.0, 1.0, 1.0, 1.0)
    0.0
    """
    a, b = width * width, height * height
    return (strain_rate**2 + pull_rate**2) * (b - a) / (a + b)


def drop_period(tension: SpecificTension, radius: Length, mode: Number, dimensions: Number) -> Time:
    """Period of a small oscillation of a drop in its mode n (2: ellipse), without viscosity and
    air.

    omega^2 = n (n-1) (n+dim-1) sigma / (rho R^3): n (n-1) (n+2) for a ball, n (n^2-1) for a disc. [lamb1932, art. 273,
    275].

    >>> round(drop_period(1.0, 1.0, 2, 3) / (2 * math.pi / math.sqrt(8.0)), 12)
    1.0
    """
    require_positive("radius", radius)
    return 2.0 * math.pi / math.sqrt(mode * (mode - 1.0) * (mode + dimensions - 1.0) * tension / radius**3)


def drop_decay(
    tension: SpecificTension,
    kinematic_viscosity: KinematicViscosity,
    radius: Length,
    mode: Number,
    dimensions: Number,
) -> Decay:
    """Decay rate and frequency of a small oscillation of a viscous drop without air, in its mode n.

    The root s = -rate + i frequency of the linear Navier-Stokes equations without stress on the surface, R = 1:
    (s^2 + 2 nu n (n-1) s + omega^2) (k^2 + 2t - 2Q) = 2t (omega^2 + 2 nu n (n-1+Q) s), where k^2 = s/nu,
    t = (n-1) (n+dim-2), and Q = k I_{m+1}(k)/I_m(k) with m = n in 2D, n + 1/2 in 3D: a potential flow, r^n, plus the
    vorticity from the surface, I_m. For thin liquids the rate is nu (n-1) (2n+dim-2)/R^2,
    2n (n-1) nu/R^2 for a disc and (n-1) (2n+1) nu/R^2 for a ball [lamb1932, art. 355].

    >>> found = drop_decay(1.0, 1e-4, 1.0, 2, 3)
    >>> round(found.rate / 5e-4, 2), round(found.frequency / math.sqrt(8.0), 4)
    (0.99, 1.0)
    """
    require_not_negative("kinematic_viscosity", kinematic_viscosity)
    swing = 2.0 * math.pi / drop_period(tension, radius, mode, dimensions)
    nu = kinematic_viscosity / (radius * radius)
    if nu == 0.0:
        return Decay(0.0, swing)
    root = complex(-nu * (mode - 1.0) * (2.0 * mode + dimensions - 2.0), swing)
    before, at_before = root * (1.0 + 1e-3), _stress(root * (1.0 + 1e-3), nu, swing, (mode, dimensions))
    for _ in range(60):
        here = _stress(root, nu, swing, (mode, dimensions))
        if here == at_before:
            break
        step = here * (root - before) / (here - at_before)
        before, at_before, root = root, here, root - step
        if abs(step) < 1e-13 * abs(root):
            break
    if not (root.imag > 1e-9 * swing and abs(root - before) < 1e-9 * abs(root)):
        raise BadInput(
            f"a drop of {radius:g} m is overdamped at a kinematic viscosity of {kinematic_viscosity:g} m^2/s"
        )
    return Decay(-root.real, root.imag)


def _stress(s: complex, nu: float, swing: float, mode: tuple[float, float]) -> complex:
    from scipy.special import ive

    n, dimensions = mode
    k, t = cmath.sqrt(s / nu), (n - 1.0) * (n + dimensions - 2.0)
    order = n + 0.5 * (dimensions - 2.0)
    above, here = ive([order + 1.0, order], [k, k])
    vorticity = k * complex(above / here)
    potential = (s * s + 2.0 * nu * n * (n - 1.0) * s + swing * swing) * (k * k + 2.0 * t - 2.0 * vorticity)
    return potential / (k * k) - 2.0 * t / (k * k) * (swing * swing + 2.0 * nu * n * (n - 1.0 + vorticity) * s)
