"""Upper limits of the time step of a liquid of particles; infinite if a process is absent."""

from __future__ import annotations

import math
from typing import Annotated

from ecume.units import (
    Acceleration,
    ArealMass,
    Density,
    KinematicViscosity,
    Length,
    Number,
    Speed,
    SurfaceTension,
    Time,
    Unit,
    Viscosity,
)

WaveNumber = Annotated[float, Unit("1/m")]
PerLength = Annotated[float, Unit("1/m")]
COURANT = 0.25
VISCOUS = 0.125


def acoustic_limit(smoothing_length: Length, sound_speed: Speed, speed: Speed, courant: Number = COURANT) -> Time:
    """Time 0.25 h / (c_0 + u) in which sound crosses a quarter of a smoothing length. [monaghan1992, morris1997].

    >>> acoustic_limit(0.1, 9.0, 1.0)
    0.0025
    """
    return courant * smoothing_length / (sound_speed + speed)


def advective_limit(smoothing_length: Length, speed: Speed, courant: Number = COURANT) -> Time:
    """Time 0.25 h / u in which the liquid moves by a quarter of a smoothing length, for liquids without sound.
    [ihmsen2014].

    >>> advective_limit(0.1, 1.0)
    0.025
    """
    return courant * smoothing_length / speed if speed > 0.0 else math.inf


def viscous_limit(smoothing_length: Length, viscosity: KinematicViscosity) -> Time:
    """Time 0.125 h^2 / nu in which momentum diffuses over less than the range of the kernel. [morris1997].

    >>> viscous_limit(0.1, 0.0), round(viscous_limit(0.1, 1e-3), 12)
    (inf, 1.25)
    """
    return VISCOUS * smoothing_length * smoothing_length / viscosity if viscosity > 0.0 else math.inf


def force_limit(smoothing_length: Length, acceleration: Acceleration) -> Time:
    """Time 0.25 sqrt(h / a) in which an acceleration moves a particle by a small fraction of h. [monaghan1992,
    morris1997].

    >>> force_limit(1.0, 0.0), force_limit(0.04, 1.0)
    (inf, 0.05)
    """
    return COURANT * math.sqrt(smoothing_length / acceleration) if acceleration > 0.0 else math.inf


def late_damping_limit(density: Density, bulk_viscosity: Viscosity, wavenumber: WaveNumber) -> Time:
    """Time 0.35 rho / (zeta k^2), the limit for damping by the rate of density of the previous step; k is the largest
    wavenumber of smoothed gradients in a lattice.

    With lambda = zeta k^2/rho and omega = c k the Verlet scheme of `sph` is stable up to lambda dt = 0.82, 0.78 and
    0.72 for omega dt = 0.1, 0.2 and 0.3: derived here, from the eigenvalues of a step. Near a surface the largest
    eigenvalue of smoothed gradients is up to 1.25 times k^2, and more where impacts press particles together. Pools at
    rest burst from 0.6 on if two rows deep, from 0.65 on if three; in a tank whose gate opens, water was thrown at
    three times its speed with 0.45, and not with 0.35. Infinite without damping.

    >>> late_damping_limit(1000.0, 350.0, 10.0), late_damping_limit(1000.0, 0.0, 10.0)
    (0.01, inf)
    """
    return 0.35 * density / (bulk_viscosity * wavenumber * wavenumber) if bulk_viscosity > 0.0 else math.inf


def tension_limit(smoothing_length: Length, density: Density, surface_tension: SurfaceTension) -> Time:
    """Time sqrt(rho h^3 / (2 pi sigma)) in which the shortest capillary wave crosses a smoothing length.
    [brackbill1992].

    >>> tension_limit(0.1, 1000.0, 0.0)
    inf
    """
    if surface_tension <= 0.0:
        return math.inf
    return math.sqrt(density * smoothing_length**3 / (2.0 * math.pi * surface_tension))


def body_sound_limit(areal_mass: ArealMass, density: Density, sound_speed: Speed, overlap: PerLength) -> Time:
    """Time sqrt(m / (rho c_0^2 I)), the limit for the pressure response of the liquid to a body of the mass m per unit
    of its surface.

    A surface that approaches by x raises the density of a particle at the distance z by rho x w(z), where w(z) is the
    kernel summed over the plane of the surface; dummies exert the same pressure again. This is a spring of stiffness 2
    rho c_0^2 I per unit of surface, I = integral of w^2 over z > 0, and an oscillation of the frequency omega <= sqrt(2
    rho c_0^2 I / m) for any convex body. Explicit schemes are stable up to steps of 2/omega; this is sqrt(2)/omega.
    Derived here; continuity and pressure are those of [monaghan1992], dummies those of [adami2012].

    >>> body_sound_limit(1.0, 1000.0, 10.0, 10.0)
    0.001
    """
    return math.sqrt(areal_mass / (density * overlap)) / sound_speed


def body_damping_limit(areal_mass: ArealMass, bulk_viscosity: Viscosity, overlap: PerLength) -> Time:
    """Time m / (4 zeta I), the limit for the response of the liquid's acoustic damping to a body of the mass m per unit
    of its surface.

    A surface that approaches at the speed v raises the density of a particle at the distance z at the rate rho v w(z),
    see `body_sound_limit`; damping with the bulk viscosity zeta adds the pressure zeta v w(z), and dummies the same
    again. The body slows down at the rate gamma = 2 zeta I / m while it oscillates at the frequency omega of
    `body_sound_limit`; explicit schemes are stable for (omega dt)^2 < 4 - 2 gamma dt; this is 1/(2 gamma). Derived here
    for the damper of [sun2023]. Infinite without damping.

    >>> body_damping_limit(1.0, 2.5, 10.0), body_damping_limit(1.0, 0.0, 10.0)
    (0.01, inf)
    """
    return areal_mass / (4.0 * bulk_viscosity * overlap) if bulk_viscosity > 0.0 else math.inf


def body_drag_limit(areal_mass: ArealMass, viscosity: Viscosity, plane_weight: PerLength) -> Time:
    """Time M / (4 eta w(0)) after which a body with the mass m per unit of surface responds to the
    liquid's friction.

    Friction along velocities [morris1997] between liquid and dummies that move as mirrored at the surface [adami2012]
    slows such a body at the rate 4 eta w(0) / m, w(0) being the kernel summed over a plane through its middle. Explicit
    schemes are stable up to twice this time. Derived here. Infinite without viscosity.

    >>> body_drag_limit(1.0, 0.25, 10.0), body_drag_limit(1.0, 0.0, 10.0)
    (0.1, inf)
    """
    return areal_mass / (4.0 * viscosity * plane_weight) if viscosity > 0.0 else math.inf


def radial_excess(dimensions: Number) -> Number:
    """Ratio 2 (d + 2) / (d + 1) of the friction along lines between particles, on a plate that moves along its normal,
    to the friction along velocities.

    For a pair that is inclined to the motion, the former is (d + 2) cos^2 times the latter; averaged over the pairs
    that cross a plane, cos^2 is 2 / (d + 1). Friction as in [monaghan2005]; the mean is derived here.

    >>> round(radial_excess(2.0), 12), radial_excess(3.0)
    (2.666666666667, 2.5)
    """
    return 2.0 * (dimensions + 2.0) / (dimensions + 1.0)
