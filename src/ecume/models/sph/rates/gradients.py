"""Renormalized gradients, which are exact for linear fields also at a free surface, and the viscosity that depends on
the velocity gradient.

sum_j V_j F (A_j - A_i) x_ij = B grad A with B = sum_j V_j F x_ij x_ij (minus the unit matrix in full surroundings);
Randles and Libersky, Comput. Methods Appl. Mech. Eng. 139 (1996) 375. [randles1996]

The gradient of the density corrects the density diffusion; that of the velocity gives the rate of strain. The viscosity
of shear-thinning and yield-stress liquids depends on it, as does the eddy viscosity below the particle size
(Smagorinsky), which is added to the viscosity of the liquid.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ecume._jit import admit, summed_inside
from ecume.engine.vectors import (
    Symmetric,
    Vector,
    Vector2,
    Vector3,
    adjugate,
    axpy,
    by_dimension,
    difference,
    dot,
    plus_square,
    scaled,
    store_vector,
    times,
    zero_matrix,
    zeros,
)
from ecume.laws import density_diffusion, viscous, yield_stress
from ecume.models.sph.fields import FIELD, RATE, Floats, Numbers
from ecume.models.sph.parameters import Parameters, Rheology
from ecume.models.sph.rates.corrections import SINGULAR
from ecume.models.sph.rates.fill_fields import read_from_sources, read_means
from ecume.models.sph.rates.neighbor_sums import Particle, Reading, neighbor_sum
from ecume.models.sph.rates.sum_evaluation import evaluate_sum
from ecume.models.sph.state import Workspace

admit(density_diffusion, viscous, yield_stress)


@summed_inside
def solved(matrix: Symmetric, vector: Vector) -> Vector:
    """The solution of a symmetric system; zero where it is nearly singular."""
    inverse, determinant = adjugate(matrix)
    found: Vector = scaled(1.0 / determinant if math.fabs(determinant) > SINGULAR else 0.0, times(inverse, vector))
    return found


@summed_inside
def given_density_gradient(numbers: Numbers, settings: Any, like: Vector) -> tuple[float, float]:
    """The factor of slopes, and zero."""
    return numbers.slope_factor, numbers.zero


@summed_inside
def no_density_gradient(zero: float, like: Vector) -> tuple[Symmetric, Vector]:
    """An empty matrix and an empty right-hand side."""
    return zero_matrix(zero, like), zeros(zero, like)


@summed_inside
def pair_density_gradient(
    total: tuple[Symmetric, Vector], apart: Vector, slope: float, own: Particle, other: Particle, given: Any
) -> tuple[Symmetric, Vector]:
    """sum_j V_j F x_ij x_ij and sum_j V_j F (rho_j - rho_i) x_ij; walls and bodies do not contribute."""
    (factor, zero), (matrix, right) = given, total
    share = factor * slope * max(other.weight, zero)
    return plus_square(matrix, share, apart), axpy(right, share * (other.value - own.value), apart)


@summed_inside
def store_density_gradient(
    rates: Floats, fields: Floats, i: int, total: tuple[Symmetric, Vector], own: Particle, given: Any
) -> None:  # fmt: skip
    store_vector(fields, FIELD.density_gradient, i, 1.0, solved(total[0], total[1]))


DENSITY_GRADIENT = neighbor_sum(
    Reading(weight=FIELD.volume, value=FIELD.density, signed=True),
    given_density_gradient, no_density_gradient, pair_density_gradient, store_density_gradient,
)  # fmt: skip
"""The density gradients of the liquid."""


@summed_inside
def given_gradient_diffusion(numbers: Numbers, settings: Any, like: Vector) -> tuple[float, float]:
    """Zero, and the factor of the diffusion (Antuono et al. 2010, eq. 6)."""
    return numbers.zero, numbers.delta * numbers.slope_factor


@summed_inside
def no_number(zero: float, like: Vector) -> float:
    """The empty sum of numbers."""
    return zero


@summed_inside
def pair_gradient_diffusion(
    total: float, apart: Vector, slope: float, own: Particle, other: Particle, given: tuple[float, float]
) -> float:
    """The sum with the term of a pair: minus the difference that follows from the mean density gradient of both
    particles; dummies do not contribute.
    """
    zero = given[0]
    rise = density_diffusion.mean_rise(dot(own.vector, apart), dot(other.vector, apart))
    return total + density_diffusion.flow(
        density_diffusion.beyond_rest(zero, zero, rise), slope * max(other.weight, zero)
    )


@summed_inside
def add_diffusion(
    rates: Floats, fields: Floats, i: int, total: float, own: Particle, given: tuple[float, float]
) -> None:  # fmt: skip
    """Add the sum to the diffusion."""
    rates[RATE.diffusion, i] += given[1] * total


GRADIENT_DIFFUSION = neighbor_sum(
    Reading(FIELD.density_gradient, FIELD.weight, signed=True),
    given_gradient_diffusion, no_number, pair_gradient_diffusion, add_diffusion,
)  # fmt: skip
"""Antuono's correction of the diffusion."""


LEAST = 1e-30
"""Pa s, a lower bound: the harmonic mean of two zeros is not a number."""


def set_viscosity(parameters: Parameters, workspace: Workspace) -> None:
    """Set the viscosity of the liquid and its images according to the rate of strain; walls without slip have the mean
    viscosity of the liquid in front of them.
    """
    fields, lists, images = workspace.fields, workspace.lists, workspace.images
    count, real, dummies = workspace.rates.shape[1], len(lists.counts), parameters.boundary.dummies
    evaluate_sum(SHEAR, parameters, workspace, settings=_strain_settings(parameters))
    read_from_sources(fields.viscosity, images, real)
    if parameters.rheology is not None and real > count:
        read_means(fields.table, fields.viscosity, count, lists, parameters.constants)
        fields.viscosity[count:real] *= dummies.viscosity > 0.0
        read_from_sources(fields.viscosity, images, real)


def _strain_settings(parameters: Parameters) -> tuple[float, ...]:
    """The spacing, Smagorinsky's coefficient, and the four numbers of the rheology."""
    eddies = viscous.SMAGORINSKY if parameters.turbulence else 0.0
    newtonian = Rheology(max(parameters.material.viscosity, LEAST), 1.0, 0.0, math.inf)
    return (parameters.spacing, eddies, *(parameters.rheology or newtonian))


class Strain2(NamedTuple):
    """In 2D, the matrix of positions, and the right-hand sides of the gradients of u and v."""

    matrix: Any
    u: Any
    v: Any


class Strain3(NamedTuple):
    """In 3D, the matrix of positions, and the right-hand sides of the gradients of u, v and w."""

    matrix: Any
    u: Any
    v: Any
    w: Any


@summed_inside
def _no_strain2(zero: float, like: Vector2) -> Strain2:
    none = zeros(zero, like)
    return Strain2(zero_matrix(zero, like), none, none)


@summed_inside
def _no_strain3(zero: float, like: Vector3) -> Strain3:
    none = zeros(zero, like)
    return Strain3(zero_matrix(zero, like), none, none, none)


no_strain = by_dimension(_no_strain2, _no_strain3)


@summed_inside
def _plus_strain2(total: Strain2, share: float, change: Vector2, apart: Vector2) -> Strain2:
    return Strain2(
        plus_square(total.matrix, share, apart),
        axpy(total.u, share * change.x, apart),
        axpy(total.v, share * change.y, apart),
    )


@summed_inside
def _plus_strain3(total: Strain3, share: float, change: Vector3, apart: Vector3) -> Strain3:
    return Strain3(
        plus_square(total.matrix, share, apart),
        axpy(total.u, share * change.x, apart),
        axpy(total.v, share * change.y, apart),
        axpy(total.w, share * change.z, apart),
    )


plus_strain = by_dimension(_plus_strain2, _plus_strain3)


@summed_inside
def _strain_rate2(total: Strain2, like: Vector2) -> float:
    u, v = solved(total.matrix, total.u), solved(total.matrix, total.v)
    return math.sqrt(2.0 * (u.x * u.x + v.y * v.y) + (u.y + v.x) * (u.y + v.x))


@summed_inside
def _strain_rate3(total: Strain3, like: Vector3) -> float:
    found: Any = solved(total.matrix, total.u), solved(total.matrix, total.v), solved(total.matrix, total.w)
    u, v, w = found
    shear = (u.y + v.x) * (u.y + v.x) + (u.z + w.x) * (u.z + w.x) + (v.z + w.y) * (v.z + w.y)
    return math.sqrt(2.0 * (u.x * u.x + v.y * v.y + w.z * w.z) + shear)


strain_rate = by_dimension(_strain_rate2, _strain_rate3)
"""The norm sqrt(2 S:S) of the rate of strain."""


class ByStrain(NamedTuple):
    """The parameters of a viscosity that depends on the rate of strain."""

    slope_factor: float
    spacing: float
    coefficient: float
    consistency: float
    exponent: float
    yield_stress: float
    largest: float


@summed_inside
def given_shear(numbers: Numbers, settings: Any, like: Vector) -> ByStrain:
    """The factor of slopes, and the settings."""
    return ByStrain(numbers.slope_factor, settings[0], settings[1], settings[2], settings[3], settings[4], settings[5])


@summed_inside
def pair_strain(total: Any, apart: Vector, slope: float, own: Particle, other: Particle, given: ByStrain) -> Any:
    """The sums with the terms of a pair for the gradient of the friction velocity; walls contribute."""
    return plus_strain(total, given.slope_factor * slope * other.weight, difference(other.vector, own.vector), apart)


@summed_inside
def store_viscosity(rates: Floats, fields: Floats, i: int, total: Any, own: Particle, given: ByStrain) -> None:
    """Store the viscosity of the liquid plus the eddy viscosity."""
    strain = strain_rate(total, own.vector)
    liquid = yield_stress.apparent_viscosity(
        strain, given.consistency, given.exponent, given.yield_stress, given.largest
    )
    eddies = viscous.eddy_viscosity(strain, given.spacing, given.coefficient)
    fields[FIELD.viscosity, i] = liquid + fields[FIELD.density, i] * eddies


SHEAR = neighbor_sum(
    Reading(FIELD.friction_velocity, FIELD.volume), given_shear, no_strain, pair_strain, store_viscosity
)
"""The viscosity of the liquid by the renormalized gradient of the friction velocity."""
