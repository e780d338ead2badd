"""Surface tension between particles: Akinci's cohesion, and the pieces of the continuum surface force."""

from __future__ import annotations

import math
from typing import Annotated

from ecume.units import Density, Length, Number, Pressure, SurfaceTension, Time, Unit

PerVolume = Annotated[float, Unit("1/m^3")]
Curvature = Annotated[float, Unit("1/m")]
ForcePerVolume = Annotated[float, Unit("N/m^3")]
RELIABLE = 0.01


def cohesion_kernel(distance: Length, support: Length) -> PerVolume:
    """Akinci's C(r), positive attracts: neighbors beyond half the support are pulled in, the nearest are pushed off.

    32/(pi s^9) (s-r)^3 r^3 for s/2 < r < s, and 2 (s-r)^3 r^3 - s^6/64 in place of the product below; s: support, the
    kernel's whole reach. The force on i is -gamma m_i m_j C(r) (x_i - x_j)/r, where gamma is a strength to be tuned (in
    m^3/(kg s^2)) and no N/m. [akinci2013].

    >>> cohesion_kernel(0.75, 1.0) > 0.0 > cohesion_kernel(0.05, 1.0), cohesion_kernel(1.5, 1.0)
    (True, 0.0)
    """
    q = min(distance / support, 1.0)
    hill = (1.0 - q) * q
    hill = hill * hill * hill
    shape = 2.0 * hill - 1.0 / 64.0 if q <= 0.5 else hill
    return 32.0 / (math.pi * support * support * support) * shape


def surface_deficiency(density_i: Density, density_j: Density, reference_density: Density) -> Number:
    """Akinci's K = 2 rho_0 / (rho_i + rho_j): strengthens pairs at the surface, where neighbors are missing.

    [akinci2013].

    >>> surface_deficiency(500.0, 500.0, 1000.0)
    2.0
    """
    return 2.0 * reference_density / (density_i + density_j)


def normal_is_reliable(color_gradient: Curvature, smoothing_length: Length) -> bool:
    """Whether the gradient of the color is long enough, above 0.01/h, for its direction to be the surface's normal.

    Elsewhere it is noise, and its curvature larger noise. [morris2000].

    >>> normal_is_reliable(5.0, 0.1), normal_is_reliable(0.05, 0.1)
    (True, False)
    """
    return color_gradient * smoothing_length > RELIABLE


def surface_force(
    surface_tension: SurfaceTension, curvature: Curvature, color_gradient: Curvature
) -> ForcePerVolume:  # fmt: skip
    """Force per volume sigma kappa n along the color's gradient n, which points into the liquid.

    kappa: curvature, minus the divergence of the unit normal, positive for a drop, which is pressed together; the
    acceleration is that over rho. [brackbill1992, morris2000].

    >>> surface_force(0.07, 200.0, 10.0) > 0.0
    True
    """
    return surface_tension * curvature * color_gradient


def laplace_pressure(surface_tension: SurfaceTension, radius: Length, dimensions: Number) -> Pressure:
    """Excess pressure (dim - 1) sigma / R in a drop at rest: a disc in two dimensions, a ball in three.

    [landau1987, par. 61].

    >>> round(laplace_pressure(0.072, 1e-3, 3), 9)
    144.0
    """
    return (dimensions - 1.0) * surface_tension / radius


def drop_period(
    surface_tension: SurfaceTension, density: Density, radius: Length, mode: Number, dimensions: Number
) -> Time:
    """Period of a drop that swings a little in its mode n (2: ellipse), without viscosity and air.

    omega^2 = n (n-1) (n+dim-1) sigma / (rho R^3): n (n-1) (n+2) for a ball, n (n^2-1) for a disc. [lamb1932, art. 273,
    275].

    >>> round(drop_period(1.0, 1.0, 1.0, 2, 3) / (2 * math.pi / math.sqrt(8.0)), 12)
    1.0
    """
    squared = mode * (mode - 1.0) * (mode + dimensions - 1.0) * surface_tension / (density * radius**3)
    return 2.0 * math.pi / math.sqrt(squared)
