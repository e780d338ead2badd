"""Self-propulsion of a round float that releases surfactant at the surface of a liquid, in closed form.

The surface concentration obeys dc/dt = D lap c - k c + s. A disc of radius R releases the mass S per time, spread over
its area, and the fall of the surface tension is b c. The resultant of the surface tension on its perimeter is, by
Gauss's theorem, F = -b int grad c dA over its area. In the frame of a disc that moves at the speed v on an infinite
surface, the Fourier transform of the steady field is s(q)/(D q^2 + k - i v q_x). With the transform 2 pi R J1(q R)/q of
the disc, the integral over the direction of q is elementary:

    F(v) = (2 b S/v) int_0^inf J1(q R)^2/q (1 - A/sqrt(A^2 + v^2 q^2)) dq,    A = D q^2 + k.

At small speeds F = f v: the rest state of a float with less friction than f is unstable. The model is that of camphor
discs [koyano2018]; these integrals were derived here.

The surface pressure b c is that of an ideal surfactant, c f' - f with the free energy per area f.
"""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from ecume.laws.arguments import require_positive
from ecume.laws.drag import TimePerArea, schiller_naumann_factor
from ecume.units import Array, Force, Length, Speed, Unit

Release = Annotated[float, Unit("N/s")]
"""The fall of the surface tension per concentration, b, times the mass that is released per time, S."""
SurfaceDiffusivity = Annotated[float, Unit("m^2/s")]
LossRate = Annotated[float, Unit("1/s")]
SurfaceConcentration = Annotated[float, Unit("kg/m^2")]
TensionSlope = Annotated[float, Unit("N*m/kg")]
TensionFall = Annotated[float, Unit("N/m")]
SurfaceConcentrations = Annotated[Array, Unit("kg/m^2")]
EnergiesPerArea = Annotated[Array, Unit("J/m^2")]
FrictionCoefficient = Annotated[float, Unit("N*s/m")]

SMALLEST, LARGEST, NODES = 1e-6, 3e2, 20_000
"""The ends and the number of points of the integral over q R, on a logarithmic scale."""
TINY = 1e-300
SLOWEST = 1e-12
"""m/s: slower discs count as being at rest."""


def propulsion(
    speed: Speed, radius: Length, release: Release, diffusivity: SurfaceDiffusivity, loss_rate: LossRate
) -> Force:
    """The force of the released surfactant along the steady motion of a disc on an infinite surface.

    F = (2 b S/v) int J1(z)^2/z (1 - A/sqrt(A^2 + v^2 z^2/R^2)) dz, A = D z^2/R^2 + k. Positive along the motion.
    Derived from the model of [koyano2018], see above.

    >>> 0.0 < propulsion(0.01, 1e-3, 1e-6, 1e-5, 0.1)
    True
    """
    from scipy.special import j1

    require_positive("radius", radius)
    require_positive("diffusivity", diffusivity)
    if speed == 0.0:
        return 0.0
    z = np.geomspace(SMALLEST, LARGEST, NODES)
    decay = diffusivity * (z / radius) ** 2 + loss_rate
    carried = speed * z / radius
    # 1 - A/sqrt(A^2 + B^2) without cancellation.
    root = np.hypot(decay, carried)
    share = carried**2 / (root * (root + decay))
    return 2.0 * release / speed * float(np.trapezoid(j1(z) ** 2 * share, np.log(z)))


def threshold_friction(
    radius: Length, release: Release, diffusivity: SurfaceDiffusivity, loss_rate: LossRate
) -> FrictionCoefficient:
    """The friction below which a float at rest starts to swim: f = b S int q J1(q R)^2/(D q^2 + k)^2 dq.

    With m = R sqrt(k/D) and int q J1^2/(q^2 + (m/R)^2) dq = I1(m) K1(m), this is f = -b S R^2/(2 m D^2) d(I1 K1)/dm. It
    diverges as m tends to zero: without loss, the surfactant that a float leaves behind drives it at any speed. Derived
    from the model of [koyano2018], see above.

    >>> f = threshold_friction(1e-3, 1e-6, 1e-5, 0.1)
    >>> abs(propulsion(1e-6, 1e-3, 1e-6, 1e-5, 0.1) / (f * 1e-6) - 1.0) < 1e-4
    True
    """
    from scipy.special import iv, ivp, kv, kvp

    require_positive("radius", radius)
    require_positive("diffusivity", diffusivity)
    require_positive("loss rate", loss_rate)
    m = radius * math.sqrt(loss_rate / diffusivity)
    slope = float(ivp(1, m) * kv(1, m) + iv(1, m) * kvp(1, m))
    return -release * radius**2 / (2.0 * m * diffusivity**2) * slope


def swimming_speed(
    friction: FrictionCoefficient, radius: Length, release: Release, diffusivity: SurfaceDiffusivity,
    loss_rate: LossRate, inverse_viscosity: TimePerArea = 0.0,
) -> Speed:  # fmt: skip
    """The speed at which the propulsion of a single disc balances its drag, F(v) = zeta v; 0 below the threshold.

    With `inverse_viscosity`, rho/eta, the friction zeta grows with the Reynolds number 2 R v rho/eta, see
    `schiller_naumann_factor`.

    >>> swimming_speed(1.0, 1e-3, 1e-6, 1e-5, 0.1)
    0.0
    """
    require_positive("friction", friction)

    def faster(speed: float) -> bool:
        drag = friction * schiller_naumann_factor(2.0 * radius * speed * inverse_viscosity) * speed
        return propulsion(speed, radius, release, diffusivity, loss_rate) > drag

    low, high = SLOWEST, math.sqrt(release / friction)
    if (loss_rate > 0.0 and threshold_friction(radius, release, diffusivity, loss_rate) <= friction) or not faster(low):
        return 0.0
    # F(v) v < 2 b S int J1^2/z dz = b S: no faster than sqrt(b S/zeta).
    for _ in range(60):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if faster(middle) else (low, middle)
        if high < low * (1.0 + 1e-10):
            break
    return high


def source_repulsion(
    distance: Length, radius: Length, release: Release, diffusivity: SurfaceDiffusivity, loss_rate: LossRate
) -> Force:
    """The force on a disc by another one at rest that releases surfactant, on an infinite surface: F = b S q/(2 pi D)
    pi R^2 (2 I1(qR)/(qR))^2 K1(q l), q = sqrt(k/D). Positive: away from the source. Discs that do not overlap.

    The concentration is that of a point source, S K0(q l)/(2 pi D); the means over both discs give the square.

    >>> source_repulsion(4e-3, 1e-3, 1e-6, 1e-5, 0.1) > source_repulsion(5e-3, 1e-3, 1e-6, 1e-5, 0.1) > 0.0
    True
    """
    from scipy.special import iv, kv

    require_positive("diffusivity", diffusivity)
    require_positive("loss rate", loss_rate)
    wavenumber = math.sqrt(loss_rate / diffusivity)
    mean = 2.0 * float(iv(1, wavenumber * radius)) / (wavenumber * radius)
    point = release * wavenumber / (2.0 * diffusivity) * radius**2
    return point * mean**2 * float(kv(1, wavenumber * distance))


def free_energy(
    concentration: SurfaceConcentrations, tension_slope: TensionSlope, reference: SurfaceConcentration,
    largest_fall: TensionFall = math.inf,
) -> EnergiesPerArea:  # fmt: skip
    """The free energy per area of a surfactant whose surface pressure is b c, up to a saturation value P.

    f = b (c ln(c'/c0) - c') with c' = min(c, P/b): below P/b, c f' - f = b c, and above P. It is convex and its slope
    is continuous. Another reference c0 adds energy in proportion to the mass.

    >>> f, h = free_energy(2.0, 3.0, 1.0), 1e-6
    >>> slope = (free_energy(2.0 + h, 3.0, 1.0) - free_energy(2.0 - h, 3.0, 1.0)) / (2.0 * h)
    >>> bool(abs(2.0 * slope - f - 3.0 * 2.0) < 1e-6)
    True
    """
    unsaturated = np.minimum(concentration, largest_fall / tension_slope)
    # c ln c is zero at c = 0.
    potential = np.log(np.maximum(unsaturated, TINY) / reference)
    return np.asarray(tension_slope * (concentration * potential - unsaturated))
