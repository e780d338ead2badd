"""Diffusion of density between SPH particles, which removes noise from the pressure.

    drho_i/dt = ... + sum_j V_j flow_ij, where flow_ij follows from the excess of j over i by one of these laws.

The excess must vanish in a liquid at rest under gravity; otherwise the level drifts. Molteni's does not vanish (the
surface rises until the tank diverges), Fourtakas's linear one nearly does, Fourtakas's with the exact column and
Antuono's do. Antuono's gradients are wrong near walls of dummy particles and are not used there.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

from ecume.units import Density, Length, Number, Speed, Unit

Potential = Annotated[float, Unit("m^2/s^2")]
Diffusivity = Annotated[float, Unit("m^2/s")]


def strength(delta: Number, smoothing_length: Length, sound_speed: Speed) -> Diffusivity:
    """Strength 2 delta h c_0 of the density diffusion of a liquid. [antuono2010].

    >>> strength(0.1, 0.5, 10.0)
    1.0
    """
    return 2.0 * delta * smoothing_length * sound_speed


def flow(excess: Number, slope: Number) -> Number:
    """Flow -excess F: toward the particle with less of the quantity, since F is never positive.
    [antuono2010].

    >>> flow(1.0, -2.0)
    2.0
    """
    return -excess * slope


def beyond_rest(here: Number, there: Number, rise: Number) -> Number:
    """Excess of the value at j over that at i, minus `rise`, its excess at rest; for any quantity.
    [antuono2010].

    For the enthalpy, `rise` is the potential g.(x_j - x_i) at any exponent of Tait's law; times rho_0/c_0^2 it is an
    excess of density.

    >>> beyond_rest(1.0, 4.0, 3.0)
    0.0
    """
    return there - here - rise


def mean_rise(rise_i: Number, rise_j: Number) -> Number:
    """Mean difference from both gradients, (grad_i + grad_j).(x_j - x_i) / 2, given the two
    projections. [antuono2010].

    >>> mean_rise(2.0, 4.0)
    3.0
    """
    return 0.5 * (rise_i + rise_j)


def molteni_excess(density_i: Density, density_j: Density) -> Density:
    """Density excess rho_j - rho_i. Not zero at rest under gravity, so that the liquid flows
    upward. [molteni2009].

    >>> molteni_excess(1000.0, 1001.0)
    1.0
    """
    return beyond_rest(density_i, density_j, 0.0 * density_i)


def antuono_excess(density_i: Density, density_j: Density, rise_i: Density, rise_j: Density) -> Density:
    """Density excess rho_j - rho_i minus the difference by the renormalized gradients between i and
    j. [antuono2010].

    rise: grad rho . (x_j - x_i) with the renormalized gradient of i, and that of j. Zero for every linear density.

    >>> antuono_excess(1000.0, 1003.0, 2.0, 4.0)
    0.0
    """
    return beyond_rest(density_i, density_j, mean_rise(rise_i, rise_j))


def fourtakas_linear_excess(
    density_i: Density, density_j: Density, potential: Potential, reference_density: Density, sound_speed: Speed
) -> Density:
    """Density excess rho_j - rho_i minus the hydrostatic difference rho_0 g.(x_j - x_i) / c_0^2 of the linear law.
    [fourtakas2019].

    potential: g.(x_j - x_i), positive when j lies deeper. To first order at rho_0 it agrees with the inverse of Tait's
    law in the paper: with gamma = 7 the level of a tank drifts by one or two percent in 1e5 steps.

    >>> fourtakas_linear_excess(1000.0, 1001.0, 1.0, 1000.0, 10.0)
    -9.0
    """
    return beyond_rest(density_i, density_j, reference_density * potential / (sound_speed * sound_speed))


def fourtakas_excess(
    density_i: Density, density_j: Density, potential: Potential, sound_speed_i: Speed, exponent: Number
) -> Density:
    """Density excess rho_j - rho_i minus the hydrostatic difference in an exact column of Tait's liquid. After
    [fourtakas2019].

    potential: g.(x_j - x_i), positive when j lies deeper; sound_speed_i: Tait's at rho_i, not c_0. Zero between any two
    particles of the column at rest, for every exponent.

    >>> fourtakas_excess(1000.0, 1000.0, 0.0, 10.0, 7.0)
    0.0
    """
    head = potential / (sound_speed_i * sound_speed_i)
    return beyond_rest(density_i, density_j, density_i * hydrostatic_gain(head, exponent))


def hydrostatic_gain(head: Number, exponent: Number) -> Number:
    """Relative density increase (1 + a u)^(1/a) - 1, a = gamma - 1, of a liquid at rest by the head u = g d/c^2.

    The binomial series to the seventh order, without powers and branches: loops vectorize. For gamma = 1 exp(u) - 1.
    Relative error below 1e-7 for |a u| < 0.1, below 1e-14 for |a u| < 0.01. [monaghan1994].

    >>> abs(hydrostatic_gain(0.001, 7.0) / (1.006 ** (1 / 6) - 1) - 1) < 1e-12
    True
    """
    a = exponent - 1.0
    u = head
    # Multiplication by inverse constants: a division takes as long as the rest of a term.
    sixth = 1.0 + (1.0 - 5.0 * a) * (1.0 / 6.0) * u * (1.0 + (1.0 - 6.0 * a) * (1.0 / 7.0) * u)
    fourth = 1.0 + (1.0 - 3.0 * a) * 0.25 * u * (1.0 + (1.0 - 4.0 * a) * 0.2 * u * sixth)
    return u * (1.0 + (1.0 - a) * 0.5 * u * (1.0 + (1.0 - 2.0 * a) * (1.0 / 3.0) * u * fourth))


EXCESSES: dict[str, Callable[..., float]] = {
    "molteni": molteni_excess,
    "antuono": antuono_excess,
    "fourtakas-linear": fourtakas_linear_excess,
    "fourtakas": fourtakas_excess,
}
"""The laws by name; their arguments differ."""
