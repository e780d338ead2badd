"""Particle shifting of the scheme delta-plus: how fast particles move toward regions of lower concentration."""

from __future__ import annotations

from typing import Annotated

from ecume.units import Length, Speed, Unit, Value

Pure = Annotated[Value, Unit("1")]
Diffusivity = Annotated[float, Unit("m^2/s")]


def shifting_coefficient(smoothing_length: Length, speed: Speed) -> Diffusivity:
    """Return the coefficient of the shifting velocity, 4 h u: the velocity is this times minus the gradient of the
    concentration.

    h: smoothing length; u: the largest speed of the flow. Sun et al. 2017, eq. (5), per time: in a step of Courant
    number C, with a speed of sound of u/Ma, particles move by C Ma (2h)^2 times the gradient. [sun2017].

    >>> shifting_coefficient(0.1, 2.0)
    0.8
    """
    return 4.0 * smoothing_length * speed


def tensile_weight(ratio: Pure[Value]) -> Pure[Value]:
    """Return the weight of a neighbor in the gradient of the concentration, 1 + 0.2 (W/W_0)^4.

    ratio: the kernel at the neighbor over that at one spacing. Close neighbors count more, so that particles do not
    pair. Sun et al. 2017, eq. (6), after Monaghan 2000. [sun2017].

    >>> tensile_weight(0.0), tensile_weight(1.0)
    (1.0, 1.2)
    """
    return 1.0 + 0.2 * ratio * ratio * ratio * ratio
