"""Viscous forces between particles of a liquid: artificial, laminar, and by eddies smaller than particles.

Pairs are (i, j) with x = x_i - x_j, v = v_i - v_j and the kernel's slope over the distance F = (1/r) dW/dr, never
positive. A friction Z exerts the force Z F v on i, against its motion relative to j; a pressure term P gives i the
acceleration -m_j P F x: positive repels.
"""

from __future__ import annotations

import math
from typing import Annotated

from ecume.units import Density, KinematicViscosity, Length, Number, Speed, Unit, Viscosity, Volume

SOFTENING = 0.01
"""Keeps a pair that nearly coincides from a division by zero; a part of h^2."""
SMAGORINSKY = 0.12
YOSHIZAWA = 0.0066
Rate = Annotated[float, Unit("1/s")]
Approach = Annotated[float, Unit("m^2/s")]
PairFriction = Annotated[float, Unit("Pa*s*m^6")]
PairPressure = Annotated[float, Unit("Pa*m^6/kg^2")]
SpecificStress = Annotated[float, Unit("m^2/s^2")]
PerLength = Annotated[float, Unit("1/m")]
LengthSquared = Annotated[float, Unit("m^2")]


def approach_speed(approach: Approach, distance_squared: LengthSquared, smoothing_length: Length) -> Speed:
    """Monaghan's mu = h v.x / (r^2 + 0.01 h^2) for approaching pairs, negative; 0 for separating
    ones.

    approach: v.x; h: smoothing_length. [monaghan1992, eq. 4.2].

    >>> approach_speed(1.0, 1.0, 1.0), approach_speed(-1.01, 1.0, 1.0)
    (0.0, -1.0)
    """
    return smoothing_length * min(0.0, approach) / (distance_squared + SOFTENING * smoothing_length * smoothing_length)


def artificial_viscosity(
    approach_speed: Speed, density: Density, sound_speed: Speed, alpha: Number, beta: Number = 0.0
) -> PairPressure:
    """Pressure term Pi = (-alpha c mu + beta mu^2) / rho of a pair that approaches; positive repels.

    mu: approach_speed, not positive; rho, c: density and sound_speed, means of the pair. alpha damps noise, beta
    prevents particles from crossing in shocks, which liquids do not have. [monaghan1992, eq. 4.1].

    >>> artificial_viscosity(-2.0, 1000.0, 10.0, 0.05)
    0.001
    """
    return approach_speed * (beta * approach_speed - alpha * sound_speed) / density


def acoustic_damping(alpha: Number, density: Density, smoothing_length: Length, sound_speed: Speed) -> Viscosity:
    """Alpha rho_0 c_0 h, the bulk viscosity zeta of the acoustic damper [sun2023].

    The paper adds -zeta div v to the pressure; here it is (zeta/rho) drho/dt, which is the same without density
    diffusion, and zero where diffusion balances a divergence that exists only in the sums. Sound of the wavenumber k
    decays at the rate alpha c_0 h k^2/2; flows of constant density are not damped.

    >>> acoustic_damping(1.0, 1000.0, 0.1, 20.0)
    2000.0
    """
    return alpha * density * smoothing_length * sound_speed


def viscosity_of_alpha(
    alpha: Number, smoothing_length: Length, sound_speed: Speed, dimensions: Number
) -> KinematicViscosity:
    """The kinematic viscosity nu = alpha h c / (2 (dim + 2)) that is equivalent to an artificial viscosity.

    This holds if it also acts on separating pairs; if it acts only on approaching pairs, the value is about half.
    [monaghan2005].

    >>> round(viscosity_of_alpha(0.08, 0.1, 10.0, 2), 9)
    0.01
    """
    return alpha * smoothing_length * sound_speed / (2.0 * (dimensions + 2.0))


def morris_friction(
    viscosity_i: Viscosity, viscosity_j: Viscosity, volume_i: Volume, volume_j: Volume
) -> PairFriction:  # fmt: skip
    """Friction Z = (eta_i + eta_j) V_i V_j of a pair. [morris1997, eq. 22].

    It conserves linear, not angular momentum. The paper softens r^2 by 0.01 h^2, which is not necessary with F. In 2D
    volumes are areas, and forces are per meter.

    >>> morris_friction(1.0, 3.0, 2.0, 0.5)
    4.0
    """
    return (viscosity_i + viscosity_j) * volume_i * volume_j


def adami_friction(viscosity_i: Viscosity, viscosity_j: Viscosity, volume_i: Volume, volume_j: Volume) -> PairFriction:
    """Friction Z = (V_i^2 + V_j^2) 2 eta_i eta_j / (eta_i + eta_j): the harmonic mean keeps shear stress continuous
    where two liquids meet; zero when either has no viscosity. [hu2006, adami2012].

    >>> adami_friction(1.0, 3.0, 2.0, 1.0)
    7.5
    """
    total = max(viscosity_i + viscosity_j, 5e-324)
    return (volume_i * volume_i + volume_j * volume_j) * 2.0 * viscosity_i * (viscosity_j / total)


def radial_friction(
    viscosity_i: Viscosity, viscosity_j: Viscosity, volume_i: Volume, volume_j: Volume, dimensions: Number
) -> PairFriction:
    """Friction Z = 4 (dim + 2) eta_i eta_j/(eta_i + eta_j) V_i V_j of a pair along the line between the two alone.

    The force on i is Z F (v.x) x/r^2: laminar viscosity in the form of the artificial one, for approaching and for
    separating pairs. [monaghan2005]. It also conserves angular momentum, and has the correct dissipation up to a free
    surface, where friction along v loses half of it [colagrossi2013].

    >>> radial_friction(1.0, 1.0, 2.0, 0.5, 2)
    8.0
    """
    mean = viscosity_i * viscosity_j / (viscosity_i + viscosity_j)
    return 4.0 * (dimensions + 2.0) * mean * volume_i * volume_j


def corrected_friction(
    viscosity_i: Viscosity, viscosity_j: Viscosity, volume_i: Volume, volume_j: Volume, dimensions: Number,
    completion: Number,
) -> PairFriction:  # fmt: skip
    """The `radial_friction` of a pair, times its completion x.(B_i + B_j) x / 2 r^2 at a free surface. [schwaiger2008].

    B: the matrix of corrected gradients, by which the paper completes the Laplacian of a scalar; here pair by pair, so
    that friction conserves linear and angular momentum, and never accelerates the liquid.

    >>> corrected_friction(1.0, 1.0, 2.0, 0.5, 2, 1.5)
    12.0
    """
    return completion * radial_friction(viscosity_i, viscosity_j, volume_i, volume_j, dimensions)


def friction_left(pair_distance: Length, surface_per_volume: PerLength, dimensions: Number) -> Number:
    """Fraction 1 - c (S/V) <r> of the friction in full surroundings that remains in a liquid with a
    free surface.

    <r>: pair_distance, the mean with the weights of pairs in the friction, (d+1)/d times the kernel's mean distance: h
    for Wendland's C2 in 2D, 10 h/9 in 3D. The fraction c (S/V) <r> of all pairs crosses a sharp surface, where
    neighbors are missing; c, half of the mean |cos| of the direction, is 1/pi in 2D, 1/4 in 3D. Derived here, to first
    order in <r>, for friction as in [monaghan2005] and a strain that is even.

    >>> round(friction_left(10.0 / 9.0 * 0.1, 3.0, 3), 12)
    0.916666666667
    """
    through = 1.0 / math.pi if dimensions < 3 else 0.25
    return 1.0 - through * surface_per_volume * pair_distance


def eddy_viscosity(strain_rate: Rate, spacing: Length, coefficient: Number = SMAGORINSKY) -> KinematicViscosity:
    """Smagorinsky's nu_t = (C_s Delta)^2 |S| of the eddies that are smaller than particles.

    |S| = sqrt(2 S_ij S_ij), strain_rate: from the symmetric part of the velocity's gradient; Delta: the spacing of the
    particles; C_s: coefficient, 0.12 as used in SPH [dalrymple2006]; 0.17 follows from the inertial range [lilly1967].

    >>> round(eddy_viscosity(2.0, 0.5), 12)
    0.0072
    """
    mixing = coefficient * spacing
    return mixing * mixing * strain_rate


def subparticle_stress(
    strain_component: Rate, divergence: Rate, strain_rate: Rate, spacing: Length, diagonal: Number
) -> SpecificStress:
    """Stress over density tau/rho = nu_t (2 S_ij - (2/3) S_kk d_ij) - (2/3) C_I Delta^2 |S|^2 d_ij of small eddies.

    S_ij: strain_component; S_kk: divergence; d_ij: diagonal, 1 for i = j and 0 otherwise; C_I = 0.0066. The
    acceleration is the divergence of tau over rho. [dalrymple2006].

    >>> round(subparticle_stress(1.0, 0.0, 2.0, 0.5, 0.0), 12)
    0.0144
    """
    shear = eddy_viscosity(strain_rate, spacing) * (2.0 * strain_component - 2.0 / 3.0 * divergence * diagonal)
    squeezed = spacing * strain_rate
    return shear - 2.0 / 3.0 * YOSHIZAWA * squeezed * squeezed * diagonal


LAMINAR = {"morris": morris_friction, "adami": adami_friction}
"""Frictions of a pair by name."""
