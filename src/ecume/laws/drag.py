"""Viscous drag on spheres, floating on a liquid or deep in it, and friction of floats that turn about the vertical."""

from __future__ import annotations

import math
from functools import cache
from typing import Annotated

import numpy as np

from ecume.errors import BadInput
from ecume.units import (
    Acceleration,
    Angle,
    Angles,
    Array,
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

IMMERSION_FACTORS = (
    0.7245, 0.7218, 0.7138, 0.7004, 0.6812, 0.6561, 0.6253, 0.5887, 0.5468,
    0.5000, 0.4490, 0.3946, 0.3377, 0.2793, 0.2205, 0.1622, 0.1055, 0.0510, 0.0,
)  # fmt: skip
"""f at contact angles 0, 10, ... 180 degrees, from a boundary-element solution of Stokes flow; within 2e-4."""
THIN_CAP = -8.0 / (9.0 * math.pi)
"""df/dtheta at 180 degrees: a cap of radius a drags as half a disc edgewise, (16/3) eta a U."""

NEAREST = 1e-7
"""Gap over R below which the drag of two spheres is that of their film alone, to 1e-6."""
DECAY = 22.0


def immersion_factor(contact_angle: Angles) -> Numbers:
    """f(theta): the drag of a floating sphere over Stokes's 6 pi eta R U for one deep in the liquid.

    A cubic spline of the boundary-element table, flat at 0 and with the slope of a thin cap at 180 degrees. The
    surface is flat and free of shear, the gas has no viscosity, the sphere does not turn. 1/2 at 90 degrees by
    symmetry; 0.7245 for two touching spheres, at 0. Measured: 0.68 at 48.7 degrees, 0.54 at 82 [petkov1995]; series
    around 90 degrees [dorr2016]. Surfactants raise it.

    >>> round(immersion_factor(math.pi / 2), 12)
    0.5
    """
    angles = np.asarray(contact_angle, dtype=np.float64)
    if not bool(np.all((angles >= 0.0) & (angles <= math.pi))):
        raise BadInput(f"contact_angle is {contact_angle!r}; expected radians between 0 and pi")
    factors = np.maximum(_spline(angles, IMMERSION_FACTORS, THIN_CAP), 0.0)
    return float(factors) if factors.ndim == 0 else factors


def factor_at_filling(filling_angle: Angles) -> Numbers:
    """The factor f of a sphere whose contact line is displaced by its weight: `immersion_factor` at pi - phi_c.

    What counts is how deep it sits; on a flat surface pi - phi_c is the contact angle. [dorr2016].

    >>> factor_at_filling(math.pi / 2) == immersion_factor(math.pi / 2)
    True
    """
    return immersion_factor(np.clip(math.pi - np.asarray(filling_angle), 0.0, math.pi))


def pair_factor(separation: Numbers, roughness: Number = 0.0) -> Numbers:
    """lambda(l/R): the drag of each of two equal spheres that approach one another, over that of one alone.

    lambda = (4/3) sinh(a) sum_n n(n+1)/[(2n-1)(2n+3)] {[4 cosh^2((n+1/2)a) + (2n+1)^2 sinh^2(a)] / [2 sinh((2n+1)a) -
    (2n+1) sinh(2a)] - 1}, cosh(a) = l/2R: both deep in the liquid [brenner1961, its free surface]. Half immersed ones
    mirror that flow, and for other depths its product with f was found to hold. R/(2 gap) near contact, where smooth
    spheres would never arrive: below the gap `roughness` (over R) it stays. `separation`: l/R, of the centers.

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
    """The series for one distance, or its limit."""
    gap = separation - 2.0
    if gap < NEAREST:
        return 0.5 / gap
    alpha = math.acosh(0.5 * separation)
    n = np.arange(1.0, math.ceil(DECAY / alpha) + 3.0)
    odd = 2.0 * n + 1.0
    # Over exp((2n+1) a), which would overflow.
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


def added_mass(radius: Length, filling_angle: Angle, density: Density) -> Mass:
    """Mass of liquid that a floating sphere carries along, half of what it displaces; `density` of the liquid.

    Exact at 90 degrees, where the surface, a rigid lid for slow motion, is a plane of symmetry of the flow around a
    whole sphere [lamb1932, par. 92]; elsewhere an interpolation between that, the whole sphere and none.

    >>> round(added_mass(1.0, math.pi / 2, 1.0) / math.pi, 12)
    0.333333333333
    """
    return 0.5 * density * submerged_volume(radius, filling_angle)


def inertial_friction(friction: Friction, reynolds: Number) -> Friction:
    """The friction of a floater that is not slow: Stokes's times `schiller_naumann_factor`. [schiller1933].

    For single spheres deep in the liquid; fast, partly immersed ones of centimeters can drag more. Waves take nothing
    below (4 g gamma/rho)^(1/4), 0.23 m/s on water.

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
    """Zeta = (16/3) eta a: a thin disc that slides along the surface of deep liquid, one side wet.

    Half of the edgewise friction of a disc in the bulk [lamb1932, par. 339].

    >>> disc_friction(3.0, 1.0)
    16.0
    """
    return 16.0 / 3.0 * viscosity * radius


def disc_turning_friction(radius: Length, viscosity: Viscosity) -> TurningFriction:
    """Zeta = (16/3) eta a^3: a thin disc that turns in the surface of deep liquid, one side wet.

    Half of what a disc in the bulk feels when it turns about its axis, (32/3) eta a^3 [lamb1932, par. 334].

    >>> disc_turning_friction(3.0, 1.0)
    144.0
    """
    return 16.0 / 3.0 * viscosity * radius**3


def relaxation_time(mass: Mass, friction: Friction) -> Time:
    """Relaxation time tau = m / zeta: how long a floater coasts; for ever without friction. [stokes1851].

    >>> relaxation_time(2.0, 4.0)
    0.5
    """
    return mass / friction if friction > 0.0 else math.inf


def cunningham_factor(mean_free_path: Length, radius: Length) -> Number:
    """How many times faster a small sphere moves in a gas than by Stokes's law, since the gas slips along it.

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


def schiller_naumann_factor(reynolds: Number) -> Number:
    """The drag of a sphere deep in a liquid over Stokes's: 1 + 0.15 Re^0.687 up to Re = 1000.

    Beyond, Newton's constant coefficient 0.44, that is 0.44 Re/24; the two differ by 0.4 % where they meet. Within 5 %
    of measured drag up to Re = 2e5. [schiller1933].

    >>> schiller_naumann_factor(0.0), round(schiller_naumann_factor(100.0), 4)
    (1.0, 4.5489)
    """
    if reynolds > 1000.0:
        return 0.44 * reynolds / 24.0
    return 1.0 + 0.15 * math.pow(reynolds, 0.687)


def stokes_settling_speed(
    radius: Length, excess_density: Density, viscosity: Viscosity, gravity: Acceleration
) -> Speed:
    """The terminal speed of a slow sphere, 2 a^2 (rho_p - rho) g / (9 eta), positive downwards; Re < 0.1. [stokes1851].

    >>> round(stokes_settling_speed(1e-5, 1500.0, 1e-3, 9.81), 12)
    0.000327
    """
    return 2.0 * radius * radius * excess_density * gravity / (9.0 * viscosity)


def settling_reynolds(stokes_reynolds: Number) -> Number:
    """Reynolds number at the terminal speed under Schiller and Naumann's drag: Re f(Re) = Re_Stokes. [schiller1933].

    `stokes_reynolds` is that of the terminal speed that Stokes's drag would allow. Solved by halving: Re f(Re) rises.

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


Inertia = Annotated[float, Unit("kg*m^2")]

TURNING_FACTORS = (
    0.90154, 0.89833, 0.88826, 0.87005, 0.84180, 0.80134, 0.74683, 0.67749, 0.59422,
    0.50000, 0.39985, 0.30030, 0.20840, 0.13046, 0.07085, 0.03105, 0.00935, 0.00116, 0.0,
)  # fmt: skip
"""At contact angles 0, 10, ... 180 degrees; from a single layer on the wet cap and its mirror image, good to 1e-5."""


def turning_factor(contact_angle: Angles) -> Numbers:
    """The torque on a floating sphere that turns about the vertical, over 8 pi eta R^3 W for one deep in the liquid.

    The flow runs in circles, and v_phi cos(phi) is harmonic outside the wet cap and its mirror image in a flat surface
    that is free of shear. 1/2 at 90 degrees by symmetry; 3 zeta(3)/4 at 0, two spheres that touch and turn as one
    [jeffery1915]; 2 sin^3(theta)/(3 pi) of a thin cap. A cubic spline of the table, flat at both ends.

    >>> round(turning_factor(math.pi / 2), 12)
    0.5
    """
    angles = np.asarray(contact_angle, dtype=np.float64)
    if not bool(np.all((angles >= 0.0) & (angles <= math.pi))):
        raise BadInput(f"contact_angle is {contact_angle!r}; expected radians between 0 and pi")
    factors = np.maximum(_spline(angles, TURNING_FACTORS, 0.0), 0.0)
    return float(factors) if factors.ndim == 0 else factors


def sphere_turning_friction(radius: Length, viscosity: Viscosity, factor: Number) -> TurningFriction:
    """Zeta = 8 pi eta R^3 times the factor: the torque per spin on a slow floater. [lamb1932, par. 334].

    >>> round(sphere_turning_friction(1.0, 1.0, 0.5) / math.pi, 12)
    4.0
    """
    return 8.0 * math.pi * viscosity * radius**3 * factor


def sphere_inertia(mass: Mass, radius: Length) -> Inertia:
    """I = (2/5) m R^2, of a solid sphere. [lamb1932].

    >>> sphere_inertia(5.0, 1.0)
    2.0
    """
    return 0.4 * mass * radius * radius


def disc_inertia(mass: Mass, radius: Length) -> Inertia:
    """I = m a^2/2, of a solid disc about its axis. [lamb1932].

    >>> disc_inertia(2.0, 3.0)
    9.0
    """
    return 0.5 * mass * radius * radius


def _spline(angles: Array, table: tuple[float, ...], end: float) -> Array:
    """The cubic spline of a table from 0 to 180 degrees, flat at 0 and with the slope `end` at the other end: from its
    values and slopes at the two angles (radians) around.
    """
    step = math.pi / (len(table) - 1)
    place = np.minimum(angles / step, len(table) - 1.0)
    left = np.minimum(place.astype(np.int64), len(table) - 2)
    values, slopes, t = np.array(table), step * _slopes(table, end), place - left
    rise, u = values[left + 1] - values[left], 1.0 - t
    bend = u * (slopes[left] - rise) - t * (slopes[left + 1] - rise)
    factors: Array = u * values[left] + t * values[left + 1] + t * u * bend
    return factors


@cache
def _slopes(table: tuple[float, ...], end: float) -> Array:
    """Those that leave no jump in the second derivative: (m_{k-1} + 4 m_k + m_{k+1}) / 3 = (f_{k+1} - f_{k-1}) / step,
    given at both ends.
    """
    count, values = len(table), np.array(table)
    matrix = 4.0 * np.eye(count) + np.eye(count, k=1) + np.eye(count, k=-1)
    right = np.zeros(count)
    right[1:-1] = 3.0 * (count - 1) / math.pi * (values[2:] - values[:-2])
    matrix[0], matrix[-1] = np.eye(count)[0], np.eye(count)[-1]
    right[0], right[-1] = 0.0, end
    return np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)
