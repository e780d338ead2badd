"""Viscous drag on floats and on spheres deep in a liquid, and rotational friction of floats about the vertical."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from ecume.errors import BadInput
from ecume.units import (
    Acceleration,
    Angle,
    Density,
    Friction,
    Length,
    Mass,
    Number,
    Numbers,
    Speed,
    Time,
    Unit,
    Viscosity,
    Volume,
)

TurningFriction = Annotated[float, Unit("N*m*s")]

NEAREST = 1e-7
"""Gap over R below which the drag of two spheres is that of their film alone, within 1e-6."""
DECAY = 22.0
INERTIAL_GROWTH = 0.687
"""The exponent of the Reynolds number in the excess over Stokes drag. [schiller1933]."""

TimePerArea = Annotated[float, Unit("s/m^2")]


def pair_factor(separation: Numbers, roughness: Number = 0.0) -> Numbers:
    """Factor lambda(l/R): the drag of each of two equal spheres that approach one another, over the drag of an isolated
    sphere.

    lambda = (4/3) sinh(a) sum_n n(n+1)/[(2n-1)(2n+3)] {[4 cosh^2((n+1/2)a) + (2n+1)^2 sinh^2(a)] / [2 sinh((2n+1)a) -
    (2n+1) sinh(2a)] - 1}, cosh(a) = l/2R, for spheres deep in the liquid [brenner1961, its free surface]. Half-immersed
    spheres have the same factor by mirror symmetry; for other depths its product with f was found to hold. It is R/(2
    gap) near contact, which smooth spheres would never reach, and constant below the gap `roughness` (over R).
    `separation`: l/R, of the centers.

    >>> round(pair_factor(3.0), 8), round(pair_factor(2.0, roughness=0.01), 3)
    (2.03865464, 53.422)
    """
    distances = np.maximum(np.asarray(separation, dtype=np.float64), 2.0 + roughness)
    if not bool(np.all((distances > 2.0) & np.isfinite(distances))) or not roughness >= 0.0:
        raise BadInput(
            f"separation is {separation!r} and roughness {roughness!r}; expected more than 2 radii, or a roughness"
        )
    factors = np.reshape([_pair_sum(float(each)) for each in distances.ravel()], distances.shape)
    return float(factors) if factors.ndim == 0 else factors


def _pair_sum(separation: float) -> float:
    """The value of the series, or of its limit, at one distance."""
    gap = separation - 2.0
    if gap < NEAREST:
        return 0.5 / gap
    alpha = math.acosh(0.5 * separation)
    n = np.arange(1.0, math.ceil(DECAY / alpha) + 3.0)
    odd = 2.0 * n + 1.0
    # Divided by exp((2n+1) a), which would overflow.
    shrunk = np.exp(-odd * alpha)
    top = (1.0 + shrunk) ** 2 + (odd * math.sinh(alpha)) ** 2 * shrunk
    bottom = -np.expm1(-2.0 * odd * alpha) - odd * math.sinh(2.0 * alpha) * shrunk
    terms = n * (n + 1.0) / ((odd - 2.0) * (odd + 2.0)) * (top / bottom - 1.0)
    return 4.0 / 3.0 * math.sinh(alpha) * float(terms.sum())


def submerged_volume(radius: Length, filling_angle: Angle) -> Volume:
    """Volume of a sphere below its contact line, pi R^3 (2/3 - cos(phi_c) + cos(phi_c)^3/3). [keller1998].

    >>> round(submerged_volume(1.0, math.pi) / math.pi, 12)
    1.333333333333
    """
    cosine = math.cos(filling_angle)
    return math.pi * radius**3 * (2.0 / 3.0 - cosine + cosine**3 / 3.0)


def added_mass(radius: Length, filling_angle: Angle, density: Density, density_above: Density = 0.0) -> Mass:
    """Added mass of a floating sphere: half of the liquid that it displaces below and above the
    surface.

    Exact at 90 degrees, where the surface, a rigid lid for slow motion, is a plane of symmetry of the flow around a
    whole sphere [lamb1932, par. 92]; elsewhere an interpolation between that, the whole sphere and none.

    >>> round(added_mass(1.0, math.pi / 2, 1.0) / math.pi, 12)
    0.333333333333
    """
    above = submerged_volume(radius, math.pi - filling_angle)
    return 0.5 * (density * submerged_volume(radius, filling_angle) + density_above * above)


def inertial_friction(friction: Friction, reynolds: Number) -> Friction:
    """Friction of a float at finite Reynolds number: Stokes friction times
    `schiller_naumann_factor`. [schiller1933].

    It holds for single spheres deep in the liquid; fast, partly immersed spheres of centimeter size can have more drag.
    There is no wave drag below (4 g gamma/rho)^(1/4), 0.23 m/s on water.

    >>> inertial_friction(2.0, 0.0)
    2.0
    """
    return friction * schiller_naumann_factor(reynolds)


def stokes_friction(radius: Length, viscosity: Viscosity, factor: Number) -> Friction:
    """Friction zeta = 6 pi eta R f, the drag per speed of a slow floater; for Reynolds numbers below 1. [stokes1851].

    >>> round(stokes_friction(1e-3, 1e-3, 0.5) * 1e6, 3)
    9.425
    """
    return 6.0 * math.pi * viscosity * radius * factor


def disc_friction(radius: Length, viscosity: Viscosity) -> Friction:
    """Friction zeta = (16/3) eta a of a thin disc that moves along the surface of deep liquid, with
    one side wet.

    Half of the edgewise friction of a disc in the bulk [lamb1932, par. 339].

    >>> disc_friction(3.0, 1.0)
    16.0
    """
    return 16.0 / 3.0 * viscosity * radius


def disc_turning_friction(radius: Length, viscosity: Viscosity) -> TurningFriction:
    """Rotational friction zeta = (16/3) eta a^3 of a thin disc in the surface of deep liquid, with
    one side wet.

    Half of the friction of a disc in the bulk that rotates about its axis, (32/3) eta a^3 [lamb1932, par. 334].

    >>> disc_turning_friction(3.0, 1.0)
    144.0
    """
    return 16.0 / 3.0 * viscosity * radius**3


def relaxation_time(mass: Mass, friction: Friction) -> Time:
    """Relaxation time tau = m / zeta of the velocity of a floater; infinite without friction.
    [stokes1851].

    >>> relaxation_time(2.0, 4.0)
    0.5
    """
    return mass / friction if friction > 0.0 else math.inf


def cunningham_factor(mean_free_path: Length, radius: Length) -> Number:
    """Ratio of the speed of a small sphere in a gas to that by Stokes's law; slip at its surface increases the speed.

    C = 1 + Kn (1.257 + 0.4 exp(-1.1/Kn)) with the Knudsen number Kn, the mean free path over the radius; a fit to
    measurements for all Kn, within 2 %. [davies1945].

    >>> round(cunningham_factor(66.5e-9, 50e-9), 2), round(cunningham_factor(66.5e-9, 500e-9), 2)
    (2.9, 1.17)
    """
    knudsen = mean_free_path / radius
    return 1.0 + knudsen * (1.257 + 0.4 * math.exp(-1.1 / knudsen)) if knudsen > 0.0 else 1.0


def particle_reynolds(speed: Speed, radius: Length, density: Density, viscosity: Viscosity) -> Number:
    """Reynolds number of a sphere, Re = 2 a v rho / eta, by its diameter and the liquid's density. [schiller1933].

    >>> round(particle_reynolds(0.01, 1e-3, 1000.0, 1e-3), 9)
    20.0
    """
    return 2.0 * radius * speed * density / viscosity


def inverse_kinematic_viscosity(
    density: Density, viscosity: Viscosity, density_above: Density = 0.0, viscosity_above: Viscosity = 0.0
) -> TimePerArea:
    """Ratio rho/eta for the Reynolds number Re = 2 a v rho/eta of a float; infinite without
    viscosity.

    Between two liquids, the ratio for which `schiller_naumann_factor` is the mean of those of both liquids up to Re =
    1000, weighted by their viscosities: each half of a sphere then has the drag of half a sphere deep in its liquid.
    [schiller1933].

    >>> round(inverse_kinematic_viscosity(1000.0, 1e-3)), round(inverse_kinematic_viscosity(900.0, 1e-3, 900.0, 1e-3))
    (1000000, 900000)
    """
    viscous = [(rho, eta) for rho, eta in ((density, viscosity), (density_above, viscosity_above)) if eta > 0.0]
    if len(viscous) < 2:
        return viscous[0][0] / viscous[0][1] if viscous else math.inf
    parts = [eta * (rho / eta) ** INERTIAL_GROWTH for rho, eta in viscous]
    return float((sum(parts) / (viscosity + viscosity_above)) ** (1.0 / INERTIAL_GROWTH))


def schiller_naumann_factor(reynolds: Number) -> Number:
    """The drag of a sphere deep in a liquid over Stokes drag: 1 + 0.15 Re^0.687 up to Re = 1000.

    Above, Newton's constant coefficient 0.44, that is 0.44 Re/24; the two differ by 0.4 % at Re = 1000. Within 5 %
    of measured drag up to Re = 2e5. [schiller1933].

    >>> schiller_naumann_factor(0.0), round(schiller_naumann_factor(100.0), 4)
    (1.0, 4.5489)
    """
    if reynolds > 1000.0:
        return 0.44 * reynolds / 24.0
    return 1.0 + 0.15 * math.pow(reynolds, INERTIAL_GROWTH)


def stokes_settling_speed(
    radius: Length, excess_density: Density, viscosity: Viscosity, gravity: Acceleration
) -> Speed:
    """The terminal speed of a slow sphere, 2 a^2 (rho_p - rho) g / (9 eta), positive downwards; Re < 0.1. [stokes1851].

    >>> round(stokes_settling_speed(1e-5, 1500.0, 1e-3, 9.81), 12)
    0.000327
    """
    return 2.0 * radius * radius * excess_density * gravity / (9.0 * viscosity)


def settling_reynolds(stokes_reynolds: Number) -> Number:
    """Reynolds number at the terminal speed with Schiller and Naumann's drag: Re f(Re) = Re_Stokes.
    [schiller1933].

    `stokes_reynolds` is that at the terminal speed with Stokes drag. Solved by bisection, since Re f(Re) increases.

    >>> round(settling_reynolds(0.654) / 0.654, 4)
    0.9053
    """
    low, high = 0.0, stokes_reynolds
    for _ in range(200):
        middle = 0.5 * (low + high)
        if middle * schiller_naumann_factor(middle) < stokes_reynolds:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def inertial_speed(stokes_speed: Speed, radius: Length, inverse_viscosity: TimePerArea) -> Speed:
    """The speed of a sphere with Schiller and Naumann's drag [schiller1933] under the force that would move it at
    `stokes_speed` with Stokes drag.

    `inverse_viscosity` is rho/eta; zero for Stokes drag.

    >>> inertial_speed(0.01, 1e-3, 0.0), round(inertial_speed(0.01, 1e-3, 1e6), 5)
    (0.01, 0.00559)
    """
    if inverse_viscosity == 0.0:
        return stokes_speed
    return settling_reynolds(2.0 * radius * stokes_speed * inverse_viscosity) / (2.0 * radius * inverse_viscosity)


def haider_levenspiel_factor(reynolds: Number, sphericity: Number) -> Number:
    """The drag of a nonspherical particle over Stokes drag on the sphere of its volume.

    1 + A Re^B + (C Re/24)/(1 + D/Re) with A = exp(2.3288 - 6.4581 s + 2.4486 s^2), B = 0.0964 + 0.5565 s, C =
    exp(4.905 - 13.8944 s + 18.4222 s^2 - 10.2599 s^3), D = exp(1.4681 + 12.2584 s - 20.7322 s^2 + 15.8855 s^3). Re: the
    Reynolds number by the diameter of the sphere of the same volume; s: the sphericity, the surface of that sphere over
    that of the particle. A fit to measurements on spheres, cubes, octahedra, tetrahedra and discs. At Re = 0 it is the
    drag of the sphere, which is too small for flat particles. [haider1989].

    >>> round(haider_levenspiel_factor(100.0, 1.0), 3), round(haider_levenspiel_factor(100.0, 0.67), 3)
    (4.791, 7.863)
    """
    s = sphericity
    a = math.exp(2.3288 - s * (6.4581 - 2.4486 * s))
    c = math.exp(4.905 - s * (13.8944 - s * (18.4222 - 10.2599 * s)))
    d = math.exp(1.4681 + s * (12.2584 - s * (20.7322 - 15.8855 * s)))
    return 1.0 + a * math.pow(reynolds, 0.0964 + 0.5565 * s) + c * reynolds * reynolds / (24.0 * (reynolds + d))


def settling_reynolds_of_shape(stokes_reynolds: Number, sphericity: Number) -> Number:
    """Reynolds number at the terminal speed under Haider and Levenspiel's drag: Re f(Re) = Re_Stokes. [haider1989].

    >>> settling_reynolds_of_shape(100.0, 0.5) < settling_reynolds_of_shape(100.0, 1.0) < settling_reynolds(110.0)
    True
    """
    low, high = 0.0, stokes_reynolds
    for _ in range(200):
        middle = 0.5 * (low + high)
        if middle * haider_levenspiel_factor(middle, sphericity) < stokes_reynolds:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


Inertia = Annotated[float, Unit("kg*m^2")]


def sphere_turning_friction(radius: Length, viscosity: Viscosity, factor: Number) -> TurningFriction:
    """Rotational friction zeta = 8 pi eta R^3 times the factor: the torque on a slow float per angular velocity.
    [lamb1932, par. 334].

    >>> round(sphere_turning_friction(1.0, 1.0, 0.5) / math.pi, 12)
    4.0
    """
    return 8.0 * math.pi * viscosity * radius**3 * factor


def sphere_inertia(mass: Mass, radius: Length) -> Inertia:
    """Moment of inertia I = (2/5) m R^2 of a solid sphere. [lamb1932].

    >>> sphere_inertia(5.0, 1.0)
    2.0
    """
    return 0.4 * mass * radius * radius


def disc_inertia(mass: Mass, radius: Length) -> Inertia:
    """Moment of inertia I = m a^2/2 of a solid disc about its axis. [lamb1932].

    >>> disc_inertia(2.0, 3.0)
    9.0
    """
    return 0.5 * mass * radius * radius
