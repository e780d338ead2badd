"""Surface tension between particles: Akinci's cohesion, and the energy of a smoothed color's contours."""

from __future__ import annotations

import math
from typing import Annotated

from ecume.units import Density, Length, Number, Pressure, SurfaceTension, Unit

PerArea = Annotated[float, Unit("1/m^2")]
PerVolume = Annotated[float, Unit("1/m^3")]
Curvature = Annotated[float, Unit("1/m")]
PlaneStrength = Annotated[float, Unit("m^5/(kg*s^2)")]
SpaceStrength = Annotated[float, Unit("m^4/(kg*s^2)")]
RELIABLE = 0.2
"""The least steepness of the color, over its smoothing length; at a flat surface it is three times that and more."""


def cohesion_kernel(distance: Length, support: Length) -> PerVolume:
    """Akinci's cohesion C(r), positive attracts: neighbors beyond half the support are attracted, the nearest are
    repelled.

    32/(pi s^9) (s-r)^3 r^3 for s/2 < r < s, with 2 (s-r)^3 r^3 - s^6/64 instead of the product below s/2; s: support,
    the kernel's whole support radius. The force on i is -gamma m_i m_j C(r) (x_i - x_j)/r, where gamma is an adjustable
    strength (in m^3/(kg s^2)), not a tension in N/m. [akinci2013].

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


def cohesion_strength_in_plane(
    surface_tension: SurfaceTension, density: Density, support: Length
) -> PlaneStrength:  # fmt: skip
    """Strength gamma of Akinci's cohesion that alone would give the surface tension sigma, in 2D.

    sigma = (rho^2 gamma / 3) int C r^3 dr, the integral being 33 s/(896 pi): the tension by pair forces at a sharp
    surface of uniform liquid. The pressure in response to the cohesion reduces it. [kirkwood1949, akinci2013].

    >>> round(cohesion_strength_in_plane(33.0, 1.0, 0.1) * 0.1 / (3.0 * 896.0 * math.pi), 12)
    1.0
    """
    return 3.0 * surface_tension * 896.0 * math.pi / (33.0 * density * density * support)


def cohesion_strength_in_space(
    surface_tension: SurfaceTension, density: Density, support: Length
) -> SpaceStrength:  # fmt: skip
    """Strength gamma of Akinci's cohesion in 3D: sigma = (pi/8) rho^2 gamma int C r^4 dr, the integral being 21
    s^2/(880 pi).

    [kirkwood1949, akinci2013].

    >>> round(cohesion_strength_in_space(21.0, 1.0, 0.1) * 0.01 / (8.0 * 880.0), 12)
    1.0
    """
    return 8.0 * surface_tension * 880.0 / (21.0 * density * density * support * support)


def surface_weight(color: Number) -> Number:
    """Weight psi(c) = 12 c (1-c)^2 for 0 < c < 1, otherwise 0, of the contour of value c in the area of the surface;
    its integral is 1.

    The surface's energy is E = sigma int psi(c) |grad c| dV, c the smoothed color, 1 inside and 0 outside. By the
    coarea formula this is sigma times the area of the contours of c, each with the weight psi: the area of the surface
    at any width of the layer, for any psi whose integral over c is one. [brackbill1992].

    The choice of psi: its slope is zero at c = 1, so that color variations by disorder in the interior have no energy;
    it is zero at c = 0, so that the edge of the kernel has none. Its weight is larger below 1/2 than above: in a drop
    at rest the layer has the pressure sigma kappa (int_0^c psi - c psi), which is negative only where c < 0.54, outside
    of nearly all particles. With a psi that is symmetric about 1/2 the outermost particles are under tension, and
    slowly detach.

    >>> surface_weight(0.5), surface_weight(1.1)
    (1.5, 0.0)
    """
    inside = min(max(color, 0.0), 1.0)
    return 12.0 * inside * (1.0 - inside) * (1.0 - inside)


def surface_weight_slope(color: Number) -> Number:
    """Slope psi'(c) = 12 (1-c) (1-3c) for 0 < c < 1, else 0. [brackbill1992].

    >>> surface_weight_slope(0.0), surface_weight_slope(1.0)
    (0.0, 0.0)
    """
    return 12.0 * (1.0 - color) * (1.0 - 3.0 * color) if 0.0 < color < 1.0 else 0.0


def wetted_share(color: Number) -> Number:
    """Part chi(c) = int_0^c psi = 6 c^2 - 8 c^3 + 3 c^4 of the contours with values below a color;
    1 above 1.

    On a wall, contours of the color end in lines, and the contour of value c encloses the part of the wall whose color
    is above c. With the energy -sigma cos(theta) int chi(c) dA of the wall each contour contributes Young's difference
    sigma_sl - sigma_sg = -sigma cos(theta) for the area that it encloses, whatever the width of the layer.
    [young1805, brackbill1992].

    >>> wetted_share(0.0), wetted_share(1.0), wetted_share(2.0)
    (0.0, 1.0, 1.0)
    """
    inside = min(max(color, 0.0), 1.0)
    return inside * inside * (6.0 - 8.0 * inside + 3.0 * inside * inside)


def solid_color(cosine: Number) -> Number:
    """The color of a solid that liquid wets with a contact angle of this cosine, between 0 (180 degrees) and 1.

    Between a solid of color s and liquid lie the contours from s to 1, between the solid and gas those from 0 to s:
    sigma_sl = sigma (1 - chi(s)) and sigma_sg = sigma chi(s), so that Young's law is chi(s) = (1 + cos(theta))/2.
    [young1805, brackbill1992].

    >>> solid_color(-1.0), round(solid_color(0.0), 4), solid_color(1.0)
    (0.0, 0.3857, 1.0)
    """
    low, high = 0.0, 1.0
    if abs(cosine) >= 1.0:
        return 0.5 + 0.5 * math.copysign(1.0, cosine)
    while low < 0.5 * (low + high) < high:
        middle = 0.5 * (low + high)
        if wetted_share(middle) < 0.5 * (1.0 + cosine):
            low = middle
        else:
            high = middle
    return high


def steepness(gradient: Curvature, least: Curvature) -> Curvature:
    """Function phi(g): the length g of the gradient of the color, and (g^2/g_0 + g_0)/2 below g_0, where its direction
    is noise.

    Value and slope are continuous there; phi'(g)/g = 1/max(g, g_0). [brackbill1992].

    >>> steepness(3.0, 1.0), steepness(0.0, 1.0)
    (3.0, 0.5)
    """
    return gradient if gradient > least else 0.5 * (gradient * gradient / least + least)


def laplace_pressure(surface_tension: SurfaceTension, radius: Length, dimensions: Number) -> Pressure:
    """Excess pressure (dim - 1) sigma / R in a drop at rest: a disc in two dimensions, a ball in three.

    [landau1987, par. 61].

    >>> round(laplace_pressure(0.072, 1e-3, 3), 9)
    144.0
    """
    return (dimensions - 1.0) * surface_tension / radius
