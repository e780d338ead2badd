"""Flows that carry particles, as exact solutions: in channels and tubes, vortices, gyres and waves.

Velocities are those at one point: x along the flow, y across it, z upward. All are free of divergence.
"""

from __future__ import annotations

import math
from typing import Annotated

from ecume.units import Angle, Length, Number, Rate, Speed, Unit

Wavenumber = Annotated[float, Unit("1/m")]

DUCT_TERMS = 40
"""Terms of the series of a duct: the remainder is below 1e-4 of the mean speed at the sides, and far less inside."""


def couette_speed(height: Length, width: Length, speed: Speed) -> Speed:
    """Speed at a height above a wall at rest in steady flow below a wall that moves, U y/L.

    U: the `speed` of the upper wall; L: `width`, the distance of the walls. [batchelor1967, sec. 4.2].

    >>> couette_speed(0.25, 1.0, 2.0)
    0.5
    """
    return speed * height / width


def tube_speed(distance: Length, radius: Length, speed: Speed) -> Speed:
    """Speed at a distance from the axis of a tube in steady laminar flow, 2 U (1 - r^2/R^2).

    U: the mean `speed`; R: the radius of the tube. Beyond the wall it is that of the mirror image. [batchelor1967].

    >>> tube_speed(0.0, 1.0, 0.5), tube_speed(1.0, 1.0, 0.5)
    (1.0, 0.0)
    """
    r = distance if distance < radius else 2.0 * radius - distance
    return 2.0 * speed * (1.0 - (r / radius) * (r / radius))


def duct_speed(across: Length, upright: Length, width: Length, depth: Length, slope: Speed) -> Speed:
    """Speed at (y, z) from the middle of a rectangular duct of the sides a and b in steady laminar flow.

    G [1 - (2 z/b)^2 - sum over odd n of (32/(pi n)^3) (-1)^((n-1)/2) cosh(n pi y/b)/cosh(n pi a/(2 b)) cos(n pi z/b)].
    y: `across`; z: `upright`; a: `width`; b: `depth`, exchanged where b is longer, since the series converges along the
    longer side; G: `slope`, the speed in the middle of a wide duct, see `duct_mean`. [batchelor1967].

    >>> round(duct_speed(0.0, 0.0, 1.0, 1.0, 1.0), 5), abs(duct_speed(0.5, 0.1, 1.0, 1.0, 1.0)) < 1e-5
    (0.58937, True)
    """
    if width < depth:
        across, upright, width, depth = upright, across, depth, width
    y, total = abs(across), 1.0 - (2.0 * upright / depth) * (2.0 * upright / depth)
    sign = 1.0
    for k in range(DUCT_TERMS):
        n = (2 * k + 1) * math.pi
        # cosh over cosh, without overflow
        ratio = math.exp(n * (y - 0.5 * width) / depth)
        ratio *= (1.0 + math.exp(-2.0 * n * y / depth)) / (1.0 + math.exp(-n * width / depth))
        total -= sign * 32.0 / (n * n * n) * ratio * math.cos(n * upright / depth)
        sign = -sign
        if ratio < 1e-16:
            break
    return slope * total


def duct_mean(width: Length, depth: Length) -> Number:
    """The mean speed in a rectangular duct over the `slope` of `duct_speed`: 2/3 in a wide one.

    (2/3) [1 - (192 b/(pi^5 a)) sum over odd n of tanh(n pi a/(2 b))/n^5]; a: the longer side, b: the shorter one.
    [batchelor1967].

    >>> round(duct_mean(1.0, 1.0), 6), round(duct_mean(1e6, 1.0), 4), round(duct_mean(1.0, 1e6), 4)
    (0.281154, 0.6667, 0.6667)
    """
    if width < depth:
        width, depth = depth, width
    total = 0.0
    for k in range(DUCT_TERMS):
        n = 2.0 * k + 1.0
        total += math.tanh(0.5 * n * math.pi * width / depth) / n**5
    return 2.0 / 3.0 * (1.0 - 192.0 * depth / (math.pi**5 * width) * total)


def cellular_velocity(phase_x: Angle, phase_y: Angle, speed: Speed) -> tuple[Speed, Speed]:
    """Velocity (along x, upward) in square cells with alternating rotation, stream function (U/k)
    sin(kx) sin(kz).

    U sin(kx) cos(kz) and -U cos(kx) sin(kz); phases: k x and k z; U: the largest speed. No liquid crosses the sides
    of a cell, where kx or kz is a multiple of pi. [maxey1987; taylor1937].

    >>> cellular_velocity(0.0, math.pi / 2, 2.0)
    (0.0, -2.0)
    """
    along = speed * math.sin(phase_x) * math.cos(phase_y)
    return along, -speed * math.cos(phase_x) * math.sin(phase_y)


def double_gyre_velocity(x: Number, upright: Number, swing: Number, speed: Speed) -> tuple[Speed, Speed]:
    """Velocity (along x, upward) of two gyres side by side with an oscillating border, in units of
    their height.

    -U sin(pi f) cos(pi z) and U cos(pi f) sin(pi z) df/dx with f = s x^2 + (1 - 2 s) x, 0 < x < 2, 0 < z < 1; s: the
    `swing`, e sin(w t); U: the `speed`, pi A. [shadden2005].

    >>> double_gyre_velocity(0.5, 0.0, 0.0, 1.0), round(double_gyre_velocity(1.0, 0.5, 0.0, 1.0)[1], 12)
    ((-1.0, 0.0), -1.0)
    """
    f = x * (swing * x + 1.0 - 2.0 * swing)
    slope = 2.0 * swing * (x - 1.0) + 1.0
    along = -speed * math.sin(math.pi * f) * math.cos(math.pi * upright)
    return along, speed * math.cos(math.pi * f) * math.sin(math.pi * upright) * slope


def wave_velocity(
    phase_x: Angle, height: Length, wavenumber: Wavenumber, depth: Length, speed: Speed
) -> tuple[Speed, Speed]:
    """Velocity (along x, upward) under a small wave that travels along x, at a height above the bottom.

    U cosh(k z)/cosh(k H) cos(p) and U sinh(k z)/cosh(k H) sin(p), with the phase p = k x - w t; H: `depth`; U: the
    horizontal `speed` at the surface, which is highest where p = 0. A particle drifts along x by
    U^2 k/(2 w) cosh(2 k z)/cosh(k H)^2, to second order in U. [lamb1932].

    >>> wave_velocity(0.0, 2.0, 1.0, 2.0, 0.5)
    (0.5, 0.0)
    """
    k, twice = wavenumber, -2.0 * wavenumber * height
    # cosh over cosh, without overflow
    scale = speed * math.exp(k * (height - depth)) / (1.0 + math.exp(-2.0 * k * depth))
    return scale * (1.0 + math.exp(twice)) * math.cos(phase_x), scale * (1.0 - math.exp(twice)) * math.sin(phase_x)


def abc_velocity(phase_x: Angle, phase_y: Angle, phase_along: Angle, speed: Speed) -> tuple[Speed, Speed, Speed]:
    """Velocity (x, y, z) of Arnold, Beltrami and Childress's chaotic flow with A, B, C = sqrt(3), sqrt(2), 1 times U.

    A sin(kz) + C cos(ky), B sin(kx) + A cos(kz), C sin(ky) + B cos(kx); phases: kx, ky and kz. Its vorticity is k times
    the velocity, so that it is a steady solution of Euler's equations. [dombre1986].

    >>> tuple(round(each, 6) for each in abc_velocity(0.0, 0.0, 0.0, 1.0))
    (1.0, 1.732051, 1.414214)
    """
    a, b, c = math.sqrt(3.0) * speed, math.sqrt(2.0) * speed, speed
    return (
        a * math.sin(phase_along) + c * math.cos(phase_y),
        b * math.sin(phase_x) + a * math.cos(phase_along),
        c * math.sin(phase_y) + b * math.cos(phase_x),
    )


Vector = tuple[Speed, Speed, Speed]
Place = tuple[Length, Length, Length]


def _past_a_solid(place: Place, stream: Vector, along: Number, radial: Number, square: float) -> Vector:
    """The stream times `along`, minus its component away from the center times `radial`."""
    share = radial * (place[0] * stream[0] + place[1] * stream[1] + place[2] * stream[2]) / square
    return (
        along * stream[0] - share * place[0],
        along * stream[1] - share * place[1],
        along * stream[2] - share * place[2],
    )


def creeping_flow_past_sphere(place: Place, radius: Length, stream: Vector) -> Vector:
    """Velocity at a position relative to the center of a sphere at rest in a slow stream; zero at its surface.

    U (1 - 3 R/(4 r) - R^3/(4 r^3)) - (3/4) (R/r - R^3/r^3) (U.n) n; n: the unit vector from the center. For Reynolds
    numbers of the sphere below 1. [stokes1851].

    >>> creeping_flow_past_sphere((0.0, 0.0, 1.0), 1.0, (1.0, 2.0, 3.0)), creeping_flow_past_sphere(
    ...     (0.0, 2.0, 0.0), 1.0, (1.0, 0.0, 0.0))[0]
    ((0.0, 0.0, 0.0), 0.59375)
    """
    square = max(place[0] * place[0] + place[1] * place[1] + place[2] * place[2], radius * radius)
    a = radius / math.sqrt(square)
    return _past_a_solid(place, stream, 1.0 - 0.75 * a - 0.25 * a**3, 0.75 * (a - a**3), square)


def ideal_flow_past_sphere(place: Place, radius: Length, stream: Vector) -> Vector:
    """Velocity at a position relative to the center of a sphere at rest in a fast stream without viscosity.

    U (1 + R^3/(2 r^3)) - (3/2) (R/r)^3 (U.n) n. [lamb1932].

    >>> ideal_flow_past_sphere((0.0, 0.0, 1.0), 1.0, (0.0, 0.0, 3.0))[2], ideal_flow_past_sphere(
    ...     (0.0, 1.0, 0.0), 1.0, (1.0, 0.0, 0.0))[0]
    (0.0, 1.5)
    """
    square = max(place[0] * place[0] + place[1] * place[1] + place[2] * place[2], radius * radius)
    a = (radius / math.sqrt(square)) ** 3
    return _past_a_solid(place, stream, 1.0 + 0.5 * a, 1.5 * a, square)


def ideal_flow_past_cylinder(place: Place, radius: Length, stream: Vector) -> Vector:
    """Velocity at a position relative to the axis of a cylinder at rest across a fast stream without viscosity.

    U (1 + R^2/r^2) - 2 (R/r)^2 (U.n) n. The axis is along y. [lamb1932].

    >>> ideal_flow_past_cylinder((1.0, 0.0, 0.0), 1.0, (1.0, 0.0, 0.0))[0], ideal_flow_past_cylinder(
    ...     (0.0, 0.0, 1.0), 1.0, (1.0, 0.0, 0.0))[0]
    (0.0, 2.0)
    """
    square = max(place[0] * place[0] + place[2] * place[2], radius * radius)
    a = radius * radius / square
    return _past_a_solid((place[0], 0.0, place[2]), stream, 1.0 + a, 2.0 * a, square)


def time_factor(time: Annotated[float, Unit("s")], amplitude: Number, turning: Rate, decay: Rate) -> Number:
    """Factor (1 + A sin(w t)) exp(-c t) of the velocities of a flow at a time. [womersley1955].

    A: `amplitude`; w: `turning`; c: `decay`. The response is quasi-steady: the shape of the flow does not depend on the
    frequency, which holds for channels narrower than sqrt(nu/w).

    >>> time_factor(0.25, 0.5, 2.0 * math.pi, 0.0)
    1.5
    """
    return (1.0 + amplitude * math.sin(turning * time)) * math.exp(-decay * time)
