"""Incompressible liquids of particles: the excess of density, the diagonal of the pressure
equation, and shifting.

Shifting is that of the delta-plus scheme: particles move toward regions of lower concentration.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np

from ecume.units import Density, Length, Number, Speed, Time, Unit, Value

Pure = Annotated[Value, Unit("1")]
SquaredSlopes = Annotated[float, Unit("1/m^2")]
PerTime = Annotated[Value, Unit("1/s")]
PerTimeSquared = Annotated[Value, Unit("1/s^2")]
PerPressure = Annotated[float, Unit("1/Pa")]
CORRECTED = 0.1
"""The fraction of an excess of density that is corrected in a step."""


def density_excess(kernel_sum: Pure[Value], lattice_sum: Number) -> Pure[Value]:
    """Relative excess of the density, s = C/C_0 - 1, positive where particles are too close.

    C: sum_j V_j W_ij of a particle, itself included; C_0: the same sum in the lattice at rest, one except for the error
    of the sum. Ihmsen et al. 2014, eq. (1), with equal densities at rest. [ihmsen2014].

    >>> density_excess(1.01, 1.0) > 0.0099
    True
    """
    return kernel_sum / lattice_sum - 1.0


def correction(excess: Pure[Value]) -> Pure[Value]:
    """Part of an excess of density that a step corrects in liquid that fills its tank, s/10.

    A full correction would cause pressure noise; a tenth is small compared with the compression by the flow in a step,
    and keeps s near 1e-3. The weight is that of Asai et al. 2012. [asai2012].

    >>> correction(0.01)
    0.001
    """
    return CORRECTED * excess


def free_correction(excess: Pure[Value]) -> Pure[Value]:
    """Part of an excess of density that a step corrects in liquid with a free surface, max(s, 0)/10 + min(s, 0). Where
    particles are missing, s < 0, the flow may compress until the density is that at rest.

    Ihmsen et al. 2014, eq. (8), where s is negative; Asai et al. 2012 where it is positive. [ihmsen2014, asai2012].

    >>> float(free_correction(0.01)), float(free_correction(-0.01))
    (0.001, -0.01)
    """
    corrected: Value = np.minimum(excess, CORRECTED * excess)
    return corrected


def straight_motion_excess(
    divergence: PerTime[Value], squared_gradient: PerTimeSquared[Value], time_step: Time
) -> Pure[Value]:
    """Relative decrease of volume, of second order in the time step, of liquid that moves on straight lines, dt^2 [tr(G
    G) - (tr G)^2]/2.

    divergence: tr G of the gradient G of the velocity; squared_gradient: tr(G G) = sum_ab (dv_a/dx_b)(dv_b/dx_a). The
    sum of -dt tr G and of this is 1 - det(1 + dt G), exactly in 2D, and up to dt^3 det G in 3D. It is positive in shear
    without rotation, negative in rotation, and zero in a flow with strain in one direction only. A velocity for which
    it cancels dt div v has no divergence in the middle of the step.

    >>> round(straight_motion_excess(0.0, -2.0, 0.1), 9)  # a rotation by 0.1: straight lines lead outward
    -0.01
    >>> straight_motion_excess(-3.0, 9.0, 0.1)  # compression in one direction
    0.0
    """
    return 0.5 * time_step * time_step * (squared_gradient - divergence * divergence)


def decrease(exact: PerTimeSquared[Value], compact: PerTimeSquared[Value], time_step: Time) -> Pure[Value]:
    """Relative decrease of density in a step by a pressure, dt^2 [div a(p) + l(p)]/2.

    exact: the divergence of the acceleration by the pressure, from sums over neighbors [ihmsen2014]; compact: the
    Laplacian over the density in the form of [cummins1999].

    >>> round(decrease(2.0, 4.0, 0.1), 12)
    0.03
    """
    return 0.5 * time_step * time_step * (exact + compact)


def diagonal(slopes: SquaredSlopes, compact: SquaredSlopes, density: Density, time_step: Time) -> PerPressure:
    """Diagonal of the pressure equation: the relative decrease of a particle's density in a step by its own pressure,
    per pressure, a_ii = dt^2/(2 rho) (S_i + 2 D_i).

    slopes: S_i = sum_j V_i V_j |grad W_ij|^2 + |sum_j V_j grad W_ij|^2, as in Ihmsen et al. 2014, eq. (12), and,
    inverted, in Bender and Koschier 2015, eq. (10); compact: D_i = -sum_j V_j F_ij, of [cummins1999].
    [ihmsen2014, bender2015].

    >>> round(diagonal(100.0, 50.0, 1000.0, 0.1), 12)
    0.001
    """
    return 0.5 * time_step * time_step / density * (slopes + 2.0 * compact)


Diffusivity = Annotated[float, Unit("m^2/s")]


def shifting_coefficient(smoothing_length: Length, speed: Speed) -> Diffusivity:
    """Coefficient of the shifting velocity, 4 h u: the velocity is this times minus the gradient of
    the concentration.

    h: smoothing length; u: the largest speed of the flow. Sun et al. 2017, eq. (5), per time: in a step of Courant
    number C, with a speed of sound of u/Ma, particles move by C Ma (2h)^2 times the gradient. [sun2017].

    >>> shifting_coefficient(0.1, 2.0)
    0.8
    """
    return 4.0 * smoothing_length * speed


def tensile_weight(ratio: Pure[Value]) -> Pure[Value]:
    """Weight of a neighbor in the gradient of the concentration, 1 + 0.2 (W/W_0)^4.

    ratio: the kernel at the neighbor over that at one spacing. Close neighbors have larger weights, so that particles
    do not form pairs. Sun et al. 2017, eq. (6), after Monaghan 2000. [sun2017].

    >>> tensile_weight(0.0), tensile_weight(1.0)
    (1.0, 1.2)
    """
    return 1.0 + 0.2 * ratio * ratio * ratio * ratio
