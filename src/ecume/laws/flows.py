"""Exact flows: Taylor-Green vortices, and the start-up of channel flows.

The functions on Taylor-Green vortices accept arrays, since they also set initial states.
"""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from ecume.laws.water_waves import Wavenumber
from ecume.units import (
    Acceleration,
    Angles,
    Density,
    KinematicViscosity,
    Length,
    Pressure,
    Rate,
    Real,
    Speed,
    Time,
    Unit,
    Viscosity,
)

Speeds = Annotated[Real, Unit("m/s")]
Pressures = Annotated[Real, Unit("Pa")]
TERMS = 400
"""Number of terms of the series: the remainder is below 1e-7 of the largest speed at any time."""
CHANNEL_MODES = 199
"""Number of terms of the double series in each direction: the remainder is below 1e-7 of its largest value."""


def taylor_green_velocity(phase_along: Angles, phase_across: Angles, speed: Speed) -> Speeds:
    """Velocity along one axis of a square lattice of vortices, -U cos(k x) sin(k y).

    Angles: k x along that axis, k y across it. The other component is the same with -U and the phases exchanged, and
    with -U k_x/k_y where the lattice is not square. [taylor1937].

    >>> float(taylor_green_velocity(0.0, math.pi / 2.0, 2.0))
    -2.0
    """
    velocity: Real = -speed * np.cos(phase_along) * np.sin(phase_across)
    return velocity


def taylor_green_pressure(
    phase_x: Angles, phase_y: Angles, speed_x: Speed, speed_y: Speed, density: Density
) -> Pressures:
    """Gauge pressure in the vortices, -(rho/4) (U^2 cos(2 k_x x) + V^2 cos(2 k_y y)): low in their centers.

    U, V: largest speeds along x and y, equal in a square lattice. [taylor1937].

    >>> float(taylor_green_pressure(0.0, 0.0, 1.0, 1.0, 1000.0))
    -500.0
    """
    swing: Real = speed_x**2 * np.cos(2.0 * phase_x) + speed_y**2 * np.cos(2.0 * phase_y)
    return -0.25 * density * swing


def taylor_green_decay(
    wavenumber_x: Wavenumber, wavenumber_y: Wavenumber, kinematic_viscosity: KinematicViscosity
) -> Rate:
    """Decay rate of all velocities of the vortices, nu (k_x^2 + k_y^2); energy and pressure decay
    twice as fast.

    Exact at every Reynolds number: the flow decays without a change of its shape. [taylor1937].

    >>> round(math.exp(-taylor_green_decay(2.0 * math.pi, 2.0 * math.pi, 0.01)), 6)
    0.454041
    """
    return float(kinematic_viscosity * (wavenumber_x**2 + wavenumber_y**2))


def poiseuille_start(
    height: Length,
    time: Time,
    width: Length,
    kinematic_viscosity: KinematicViscosity,
    acceleration: Acceleration,
) -> Speed:
    """Speed at y of a liquid between two resting plates that a body force accelerates from t = 0
    on.

    F y (L - y)/(2 nu) - sum over odd n of 4 F L^2/(nu pi^3 n^3) sin(n pi y/L) exp(-n^2 pi^2 nu t/L^2); in the end the
    largest speed is F L^2/(8 nu). F: acceleration; L: width; nu: kinematic viscosity. [morris1997].

    >>> round(poiseuille_start(0.5, 0.1125, 1.0, 1.0, 8.0), 6)
    0.659993
    """
    nu = kinematic_viscosity
    steady = 0.5 * acceleration / nu * height * (width - height)
    scale = 4.0 * acceleration * width**2 / (nu * math.pi**3)
    terms = (
        math.sin(n * math.pi * height / width) * math.exp(-((n * math.pi / width) ** 2) * nu * time) / n**3
        for n in range(1, TERMS, 2)
    )
    return steady - scale * math.fsum(terms)


def channel_speed(height: Length, width: Length, speed: Speed) -> Speed:
    """Speed at y of a viscous liquid that flows steadily between two resting plates.

    6 U y (L - y)/L^2; 3/2 U in the middle. U: the mean `speed`; L: width. [batchelor1967, sec. 4.2].

    >>> channel_speed(0.5, 1.0, 1.0)
    1.5
    """
    return 6.0 * speed * height * (width - height) / (width * width)


def channel_pressure_drop(viscosity: Viscosity, speed: Speed, length: Length, width: Length) -> Pressure:
    """Pressure drop along a channel between two parallel walls, 12 eta u L / H^2, with the mean speed u of a parabolic
    profile. Exact for developed flow; more at an entrance.

    >>> round(channel_pressure_drop(0.05, 1.0, 3.0, 1.0), 12)
    1.8
    """
    return 12.0 * viscosity * speed * length / (width * width)


def couette_start(
    height: Length,
    time: Time,
    width: Length,
    kinematic_viscosity: KinematicViscosity,
    speed: Speed,
) -> Speed:
    """Speed at y of a liquid between a resting plate at 0 and one at L that moves from t = 0 on.

    V sum over k of erfc(((2k+1) L - y)/s) - erfc(((2k+1) L + y)/s) with s = 2 sqrt(nu t): the boundary layer at the
    moving plate, and its mirror images behind both plates. V: speed of the plate; L: width; nu: kinematic viscosity.
    The series of
    sines [morris1997] is equivalent, but loses all digits where the liquid is still at rest. [batchelor1967, sec. 4.3].

    >>> round(couette_start(0.5, 0.1125, 1.0, 1.0, 1.0), 6)
    0.290275
    """
    reach = 2.0 * math.sqrt(kinematic_viscosity * time)
    images = 1 + math.ceil(6.0 * reach / width)
    terms = (
        math.erfc(((2 * k + 1) * width - height) / reach) - math.erfc(((2 * k + 1) * width + height) / reach)
        for k in range(images)
    )
    return speed * math.fsum(terms)
