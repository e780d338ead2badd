"""Surface tension between particles: Akinci's cohesion, and the pieces of the continuum surface force."""

from __future__ import annotations

import math
from typing import Annotated

from ecume.units import Density, Length, Number, Pressure, SurfaceTension, Time, Unit

PerArea = Annotated[float, Unit("1/m^2")]
PerVolume = Annotated[float, Unit("1/m^3")]
Curvature = Annotated[float, Unit("1/m")]
ForcePerVolume = Annotated[float, Unit("N/m^3")]
LengthSquared = Annotated[float, Unit("m^2")]
PlaneStrength = Annotated[float, Unit("m^5/(kg*s^2)")]
SpaceStrength = Annotated[float, Unit("m^4/(kg*s^2)")]
RELIABLE = 0.2


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


def cohesion_energy(distance: Length, support: Length) -> PerArea:
    """Energy over gamma m_i m_j of a pair under Akinci's cohesion: minus the integral of C from r to the support.

    Never positive, zero beyond the support; its slope is `cohesion_kernel`. [akinci2013].

    >>> cohesion_energy(0.75, 1.0) < 0.0, cohesion_energy(1.5, 1.0)
    (True, 0.0)
    """
    q = min(distance / support, 1.0)
    below = q * q * q * q * (0.25 + q * (-0.6 + q * (0.5 - q / 7.0)))
    left = 3.0 / 280.0 - 2.0 * below - (0.5 - q) / 64.0 if q <= 0.5 else 1.0 / 140.0 - below
    # Rounding leaves 1e-18 at the support.
    return -32.0 / (math.pi * support * support) * left if q < 1.0 else 0.0


def surface_deficiency(density_i: Density, density_j: Density, reference_density: Density) -> Number:
    """Akinci's K = 2 rho_0 / (rho_i + rho_j): strengthens pairs at the surface, where neighbors are missing.

    [akinci2013].

    >>> surface_deficiency(500.0, 500.0, 1000.0)
    2.0
    """
    return 2.0 * reference_density / (density_i + density_j)


def normal_is_reliable(color_gradient: Curvature, smoothing_length: Length) -> bool:
    """Whether the gradient of the color is long enough, above 0.2/h, for its direction to be the surface's normal.

    Elsewhere it is noise, and its curvature larger noise. At a flat surface of Wendland's C2 it is 0.74/h. Morris has
    0.01/h, with a second liquid around: at a free surface that lets the noise of the inside tear
    drops apart. [morris2000].

    >>> normal_is_reliable(5.0, 0.1), normal_is_reliable(0.05, 0.1)
    (True, False)
    """
    return color_gradient * smoothing_length > RELIABLE


def curvature_of_turning(turning: Length, spread: LengthSquared, dimensions: Number) -> Curvature:
    """Curvature kappa = -(dim - 1) sum w (n_j - n_i).t / sum w t.t of unit normals n into the liquid, at a surface.

    turning, spread: the two sums over neighbors with weights w, t: the part of x_j - x_i along
    the surface. One sum over the other, as Morris corrects for missing neighbors, but along the surface alone: normals
    do not turn across it, and whoever is missing on the other side changes nothing. 1/r for a disc, 2/r for a ball,
    positive. [morris2000].

    >>> curvature_of_turning(-0.5, 1.0, 3)
    1.0
    """
    return -(dimensions - 1.0) * turning / spread if spread > 0.0 else 0.0


def cohesion_strength_in_plane(
    surface_tension: SurfaceTension, density: Density, support: Length
) -> PlaneStrength:  # fmt: skip
    """The strength gamma with which Akinci's cohesion alone would make the tension sigma, in two dimensions.

    sigma = (rho^2 gamma / 3) int C r^3 dr, the integral being 33 s/(896 pi): what pair forces do across a sharp surface
    of evenly spread liquid. The pressure that the cohesion calls up takes some of it away. [kirkwood1949, akinci2013].

    >>> round(cohesion_strength_in_plane(33.0, 1.0, 0.1) * 0.1 / (3.0 * 896.0 * math.pi), 12)
    1.0
    """
    return 3.0 * surface_tension * 896.0 * math.pi / (33.0 * density * density * support)


def cohesion_strength_in_space(
    surface_tension: SurfaceTension, density: Density, support: Length
) -> SpaceStrength:  # fmt: skip
    """The same in three dimensions: sigma = (pi/8) rho^2 gamma int C r^4 dr, the integral being 21 s^2/(880 pi).

    [kirkwood1949, akinci2013].

    >>> round(cohesion_strength_in_space(21.0, 1.0, 0.1) * 0.01 / (8.0 * 880.0), 12)
    1.0
    """
    return 8.0 * surface_tension * 880.0 / (21.0 * density * density * support * support)


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
