"""Wave makers: wavenumbers, strokes of pistons and flaps, spectra, and waves of second order."""

from __future__ import annotations

import math
from typing import Annotated

from ecume.laws.arguments import require_positive
from ecume.laws.water_waves import Wavenumber
from ecume.units import Acceleration, Angle, Length, Number, Rate, Unit

SpectralDensity = Annotated[float, Unit("m^2*s")]
"""Variance of the elevation per frequency, in cycles."""

DEEPEST = 100.0
"""The depth times the wavenumber beyond which water counts as this deep: hyperbolic functions would overflow."""


def wavenumber_at(angular_frequency: Rate, depth: Length, gravity: Acceleration) -> Wavenumber:
    """Wavenumber k of small waves of an angular frequency, omega^2 = g k tanh(k H), by Newton's
    method.

    omega: `angular_frequency`; H: depth. It begins at the larger one of the limits of deep and shallow water.
    [lamb1932, art. 228].

    >>> round(wavenumber_at(3.759371, 1.0, 9.81), 6) == round(math.pi / 2.0, 6)
    True
    """
    for name, value in (("angular_frequency", angular_frequency), ("depth", depth), ("gravity", gravity)):
        require_positive(name, value)
    deep = angular_frequency**2 * depth / gravity
    steps = max(deep, math.sqrt(deep))
    for _ in range(50):
        slope = math.tanh(steps)
        change = (steps * slope - deep) / (slope + steps * (1.0 - slope * slope))
        steps -= change
        if abs(change) < 1e-15 * steps:
            break
    return steps / depth


def piston_ratio(wavenumber: Wavenumber, depth: Length) -> Number:
    """Height of the waves over the stroke of a piston, 2 (cosh 2 k H - 1)/(sinh 2 k H + 2 k H): twice its amplitude for
    each. In shallow water it is k H.

    [dean1991, sec. 6.3].

    >>> k = wavenumber_at(2.0 * math.pi, 0.3, 9.81)
    >>> round(piston_ratio(k, 0.3), 3)
    1.299
    """
    require_positive("wavenumber", wavenumber)
    require_positive("depth", depth)
    twice = 2.0 * min(wavenumber * depth, DEEPEST)
    return 2.0 * (math.cosh(twice) - 1.0) / (math.sinh(twice) + twice)


def flap_ratio(wavenumber: Wavenumber, depth: Length) -> Number:
    """Height of the waves over the stroke, at the level, of a flap hinged at the floor, 4 (sinh k H/(k H))
    (k H sinh k H - cosh k H + 1)/(sinh 2 k H + 2 k H). In shallow water it is half of a piston's, in deep water it
    tends to the same as 2 - 2/(k H).

    [dean1991, sec. 6.3].

    >>> round(flap_ratio(0.01, 1.0) / piston_ratio(0.01, 1.0), 4)
    0.5
    """
    require_positive("wavenumber", wavenumber)
    require_positive("depth", depth)
    steps = wavenumber * depth
    deep = min(steps, DEEPEST)
    height = steps * math.sinh(deep) - math.cosh(deep) + 1.0
    return 4.0 * math.sinh(deep) / steps * height / (math.sinh(2.0 * deep) + 2.0 * steps)


def jonswap(frequency: Rate, peak: Rate, height: Length, enhancement: Number = 3.3) -> SpectralDensity:
    """Variance per frequency f (in cycles) of the JONSWAP spectrum with the peak frequency f_p.

    beta H^2 f_p^4 f^-5 exp(-5/4 (f_p/f)^4) gamma^exp(-(f/f_p - 1)^2/(2 s^2)), s = 0.07 up to the peak and 0.09 beyond,
    beta = 0.0624/(0.230 + 0.0336 gamma - 0.185/(1.9 + gamma)). H: significant height, four times the root of the
    variance; gamma: `enhancement`; 1 is the spectrum of Pierson and Moskowitz. [hasselmann1973, goda2010].

    >>> jonswap(0.0, 0.5, 0.1)
    0.0
    >>> round(jonswap(0.5, 0.5, 0.1) / jonswap(0.5, 0.5, 0.1, 1.0), 2)
    2.16
    """
    require_positive("peak", peak)
    if frequency <= 0.0:
        return 0.0
    ratio, gamma = frequency / peak, enhancement
    width = 0.07 if ratio <= 1.0 else 0.09
    scale = 0.0624 / (0.230 + 0.0336 * gamma - 0.185 / (1.9 + gamma))
    peaked = math.pow(gamma, math.exp(-0.5 * ((ratio - 1.0) / width) ** 2))
    return scale * height**2 / peak * ratio**-5 * math.exp(-1.25 * ratio**-4) * peaked


def second_order_elevation(amplitude: Length, wavenumber: Wavenumber, depth: Length, phase: Angle) -> Length:
    """Elevation of a steady wave to second order, a cos p + a^2 k/4 cosh k H (2 + cosh 2 k H)/sinh^3 k H cos 2 p.

    p: k x - omega t. Crests are higher than troughs are deep, which linear theory does not have. [dean1991, sec. 11.2].

    >>> round(second_order_elevation(0.1, 1.0, 100.0, 0.0) - 0.1, 6)  # a^2 k/2 in deep water
    0.005
    """
    require_positive("wavenumber", wavenumber)
    require_positive("depth", depth)
    deep = min(wavenumber * depth, DEEPEST)
    shape = math.cosh(deep) * (2.0 + math.cosh(2.0 * deep)) / math.sinh(deep) ** 3
    return amplitude * math.cos(phase) + 0.25 * amplitude**2 * wavenumber * shape * math.cos(2.0 * phase)
