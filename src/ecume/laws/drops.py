"""Drops that swing, exactly: what a simulated one is held against."""

from __future__ import annotations

import cmath
import math
from typing import Annotated

from scipy.special import ive

from ecume.errors import BadInput
from ecume.laws.arguments import require_not_negative, require_positive
from ecume.laws.waves import Decay
from ecume.units import KinematicViscosity, Length, Number, Time, Unit

SpecificTension = Annotated[float, Unit("m^3/s^2")]
"""Surface tension over density."""


def drop_period(tension: SpecificTension, radius: Length, mode: Number, dimensions: Number) -> Time:
    """Period of a drop that swings a little in its mode n (2: ellipse), without viscosity and air.

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
    """Decay and frequency of a small swing of a viscous drop without air, in its mode n.

    The root s = -rate + i frequency of the linear Navier-Stokes equations without stress on the surface, R = 1:
    (s^2 + 2 nu n (n-1) s + omega^2) (k^2 + 2t - 2Q) = 2t (omega^2 + 2 nu n (n-1+Q) s), where k^2 = s/nu,
    t = (n-1) (n+dim-2), and Q = k I_{m+1}(k)/I_m(k) with m = n in 2D, n + 1/2 in 3D: what a potential flow,
    r^n, and the vorticity from the surface, I_m, do together. For thin liquids the rate is nu (n-1) (2n+dim-2)/R^2,
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
    n, dimensions = mode
    k, t = cmath.sqrt(s / nu), (n - 1.0) * (n + dimensions - 2.0)
    order = n + 0.5 * (dimensions - 2.0)
    above, here = ive([order + 1.0, order], [k, k])
    vorticity = k * complex(above / here)
    potential = (s * s + 2.0 * nu * n * (n - 1.0) * s + swing * swing) * (k * k + 2.0 * t - 2.0 * vorticity)
    return potential / (k * k) - 2.0 * t / (k * k) * (swing * swing + 2.0 * nu * n * (n - 1.0 + vorticity) * s)
