"""Exact flows to hold a simulated liquid against: vortices that decay, channels that start, drops that swing.

The functions of Taylor and Green welcome arrays: they also start runs.
"""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from ecume.units import (
    Acceleration,
    Angles,
    Density,
    KinematicViscosity,
    Length,
    Number,
    Pressure,
    Rate,
    Real,
    Speed,
    Time,
    Unit,
)

Speeds = Annotated[Real, Unit("m/s")]
Pressures = Annotated[Real, Unit("Pa")]
Wavenumber = Annotated[float, Unit("1/m")]
Stretching = Annotated[float, Unit("1/s^2")]
TERMS = 400
"""Number of terms of the series: the remainder is below 1e-7 of the largest speed at any time."""
MODES = 199
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
    """Rate at which all velocities of the vortices fall, nu (k_x^2 + k_y^2); energy and pressure fall twice as fast.

    Exact at every Reynolds number: the flow only fades. [taylor1937].

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
    """Speed at y of a liquid between two resting plates that is pulled along them from t = 0 on.

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


def couette_start(
    height: Length,
    time: Time,
    width: Length,
    kinematic_viscosity: KinematicViscosity,
    speed: Speed,
) -> Speed:
    """Speed at y of a liquid between a resting plate at 0 and one at L that moves from t = 0 on.

    V sum over k of erfc(((2k+1) L - y)/s) - erfc(((2k+1) L + y)/s) with s = 2 sqrt(nu t): the layer that the plate
    drags along, and its images behind both. V: speed of the plate; L: width; nu: kinematic viscosity. The series of
    sines [morris1997] is the same, and loses all digits where nothing moves yet. [batchelor1967, sec. 4.3].

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


def patch_pressure(across: Length, along: Length, width: Length, stretching: Stretching, density: Density) -> Pressure:
    """Gauge pressure in a square of liquid without walls at the instant at which it moves as v = G x.

    rho S sum over odd m, n of 16/(m n pi^2 ((m pi/L)^2 + (n pi/L)^2)) sin(m pi x/L) sin(n pi y/L), from one corner: the
    solution of lap p = -rho S with S = tr(G^2) that is zero on the sides. It is negative everywhere inside where the
    patch spins like a solid, S = -2 w^2. L: width. [colagrossi2005].

    >>> round(patch_pressure(0.5, 0.5, 1.0, -2.0, 1.0), 6)
    -0.147343
    """
    modes = np.arange(1, MODES + 1, 2) * math.pi / width
    m, n = modes[:, None], modes[None, :]
    terms = np.sin(m * across) * np.sin(n * along) / (m * n * (m * m + n * n))
    return float(16.0 * density * stretching / width**2 * terms.sum())


def ball_pressure(
    distance: Length, radius: Length, stretching: Stretching, density: Density, dimensions: Number
) -> Pressure:
    """Gauge pressure in a disc or ball of liquid without walls while it moves as v = G x, rho S (R^2 - r^2)/(2 d).

    S = tr(G^2) + d w^2, where w^2 times its distance pulls everything to the center; 2 s^2 where a disc is stretched at
    the rate s. The solution of lap p = -rho S that is zero on the surface. d: dimensions. [monaghan1994] with w = 0,
    [monaghan2013].

    >>> ball_pressure(0.0, 1.0, 2.0 * 100.0**2, 1.0, 2.0)
    5000.0
    """
    return 0.5 * density * stretching / dimensions * (radius**2 - distance**2)


def drop_strain_change(strain_rate: Rate, pull_rate: Rate, width: Length, height: Length) -> Stretching:
    """How fast the rate of strain of an elliptic drop changes, (s^2 + w^2) (b^2 - a^2)/(a^2 + b^2).

    The drop flows as u = s x, v = -s y, so that da/dt = s a and db/dt = -s b; each particle is pulled to the center by
    w^2 times its distance (not at all if w = 0). s: rate of strain; w: rate of the pull; a: width, b: height, both
    half. (s^2 + w^2) (a^2 + b^2) is conserved. [monaghan1994] with w = 0, [monaghan2013].

    >>> drop_strain_change(2.0, 1.0, 1.0, 1.0)
    0.0
    """
    a, b = width * width, height * height
    return (strain_rate**2 + pull_rate**2) * (b - a) / (a + b)
