"""How long a time step of a liquid made of particles may be; each limit is infinite where nothing limits."""

from __future__ import annotations

import math

from ecume.units import Acceleration, Density, KinematicViscosity, Length, Speed, SurfaceTension, Time

COURANT = 0.25
VISCOUS = 0.125


def acoustic_limit(smoothing_length: Length, sound_speed: Speed, speed: Speed) -> Time:
    """0.25 h / (c_0 + u): sound crosses a quarter of a smoothing length. [monaghan1992, morris1997].

    >>> acoustic_limit(0.1, 9.0, 1.0)
    0.0025
    """
    return COURANT * smoothing_length / (sound_speed + speed)


def viscous_limit(smoothing_length: Length, viscosity: KinematicViscosity) -> Time:
    """0.125 h^2 / nu: momentum diffuses no farther than particles see. [morris1997].

    >>> viscous_limit(0.1, 0.0), round(viscous_limit(0.1, 1e-3), 12)
    (inf, 1.25)
    """
    return VISCOUS * smoothing_length * smoothing_length / viscosity if viscosity > 0.0 else math.inf


def force_limit(smoothing_length: Length, acceleration: Acceleration) -> Time:
    """0.25 sqrt(h / a): a force moves a particle by a small part of h. [monaghan1992, morris1997].

    >>> force_limit(1.0, 0.0), force_limit(0.04, 1.0)
    (inf, 0.05)
    """
    return COURANT * math.sqrt(smoothing_length / acceleration) if acceleration > 0.0 else math.inf


def tension_limit(smoothing_length: Length, density: Density, surface_tension: SurfaceTension) -> Time:
    """sqrt(rho h^3 / (2 pi sigma)): the shortest capillary wave crosses a smoothing length. [brackbill1992].

    >>> tension_limit(0.1, 1000.0, 0.0)
    inf
    """
    if surface_tension <= 0.0:
        return math.inf
    return math.sqrt(density * smoothing_length**3 / (2.0 * math.pi * surface_tension))
