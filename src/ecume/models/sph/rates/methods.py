"""Forms of the equations that a scene's `[method]` chooses from: one row each, with everything that depends on it.

A row is selected by its name, and `Parameters` contains the row itself. There is no default: an unknown name is an
error.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Literal, NamedTuple

import numpy as np

from ecume.laws import density_diffusion, viscous
from ecume.models.sph.fields import FIELD, ConstantDensity, Fields, Liquid, Tait
from ecume.models.sph.rates.corrections import (
    CORRECTED_CONTINUITY,
    CORRECTED_FRICTION,
    CORRECTED_PRESSURE,
    completion_factors,
)
from ecume.models.sph.rates.neighbor_sums import NeighborSum
from ecume.models.sph.rates.sums import CONTINUITY, FRICTION, PRESSURE, RADIAL_FRICTION, RATES, TRANSPORTED_PRESSURE
from ecume.models.sph.rates.sums_of_two import ALL_RATES_OF_TWO, CONTINUITIES_OF_TWO, PRESSURE_OF_TWO
from ecume.units import Array

Law = Callable[..., float]


class PressureMethod(NamedTuple):
    """A method to compute the pressure, and the capabilities that it offers to other options."""

    equation: type[Liquid]
    integrator: str
    """the default integrator, a key of `time_stepping.INTEGRATORS`"""
    has: frozenset[str]
    """capabilities, which `incompressible.NEEDS` compares with what other options need"""

    @property
    def compressible(self) -> bool:
        """Whether the liquid has sound waves."""
        return SOUND in self.has


SOUND, DENSITY_RATE, BUFFERS, BODIES, DENSITY_FORCES, SOLVER = (
    "sound", "rates of density", "buffers", "bodies", "pressure forces by density", "solver",
)  # fmt: skip
PRESSURES: Mapping[str, PressureMethod] = {
    "tait": PressureMethod(Tait, "symplectic", frozenset([SOUND, DENSITY_RATE, BUFFERS, BODIES, DENSITY_FORCES])),
    "incompressible": PressureMethod(ConstantDensity, "projection", frozenset([SOLVER])),
}


class PressureForce(NamedTuple):
    """A form of the pressure force, and its equation of continuity."""

    by_mass: bool
    """whether the force has the terms m p/rho^2 of two particles, instead of V p: see `Fields`"""
    per_volume: bool
    """whether the sum is a force per volume, instead of per mass"""
    transported: bool
    """whether particles move with a transport velocity, driven by a background pressure"""
    sum: NeighborSum
    """over neighbors"""
    most_damping: float
    """largest coefficient of the acoustic damping with which the usual time step is stable; zero: takes none"""
    both: Mapping[int | None, NeighborSum] | None = None
    """this sum and continuity in one, by the row of the field that diffuses, for schemes that take both at once"""
    continuity: Mapping[int, NeighborSum] = CONTINUITY
    """the equation of continuity that is adjoint to the force, by the row of the diffusing field"""

    @property
    def corrected(self) -> bool:
        """Whether gradients are completed where neighbors are missing."""
        return self.continuity is CORRECTED_CONTINUITY

    def damping_shares(self, fields: Fields, count: int) -> Array:
        """The factors (N,) of the acoustic damping of the first particles: less than 1 where gradients are
        completed.
        """
        return completion_factors(fields, count) ** -2.0 if self.corrected else np.ones(count)


class Friction(NamedTuple):
    """A form of the viscous force."""

    radial: bool
    """whether it acts along the line between two particles, instead of along their relative velocity"""
    sum: NeighborSum
    """over neighbors"""
    law: Law
    corrected: bool = False
    """whether pairs have larger weights where neighbors are missing at a free surface"""


class DensityDiffusion(NamedTuple):
    """A diffusion term in the equation of continuity."""

    excess: Law | None
    """the difference between two particles that diffuses; None without diffusion"""
    field: Literal["density", "enthalpy"]
    """the field that diffuses"""
    balances_weight: bool
    """whether the change of that field along gravity in a liquid at rest is subtracted"""
    gradients: bool
    """whether the mean gradient of the density at both particles is subtracted"""

    @property
    def row(self) -> int:
        """The field that diffuses, as a row of the table of fields."""
        return FIELD.enthalpy if self.field == "enthalpy" else FIELD.density

    def rise(self, density: float, sound_speed: float) -> float:
        """The gradient of the diffusing field at rest over gravity: rho/c^2 for the density."""
        spring = 1.0 if self.field == "enthalpy" else density / sound_speed**2
        return spring if self.balances_weight else 0.0


PRESSURE_FORCES: Mapping[str, PressureForce] = {
    "sum": PressureForce(by_mass=False, per_volume=True, transported=False, sum=PRESSURE, both=RATES, most_damping=2.0),
    "monaghan": PressureForce(
        by_mass=True, per_volume=False, transported=False, sum=PRESSURE, both=RATES, most_damping=2.0
    ),
    "transport": PressureForce(
        by_mass=False, per_volume=False, transported=True, sum=TRANSPORTED_PRESSURE, most_damping=0.0
    ),
    "corrected": PressureForce(
        by_mass=False,
        per_volume=True,
        transported=False,
        sum=CORRECTED_PRESSURE,
        most_damping=2.0,
        continuity=CORRECTED_CONTINUITY,
    ),
}
SUM_OF_TWO = PressureForce(
    by_mass=False, per_volume=True, transported=False, sum=PRESSURE_OF_TWO, both=ALL_RATES_OF_TWO, most_damping=2.0,
    continuity=CONTINUITIES_OF_TWO,
)  # fmt: skip
"""The row "sum" where there are two liquids."""
FRICTIONS: Mapping[str, Friction] = {
    "morris": Friction(radial=False, sum=FRICTION, law=viscous.morris_friction),
    "monaghan": Friction(radial=True, sum=RADIAL_FRICTION, law=viscous.radial_friction),
    "corrected": Friction(radial=True, sum=CORRECTED_FRICTION, law=viscous.corrected_friction, corrected=True),
}
DIFFUSIONS: Mapping[str, DensityDiffusion] = {
    "none": DensityDiffusion(None, "density", balances_weight=False, gradients=False),
    "molteni": DensityDiffusion(density_diffusion.molteni_excess, "density", balances_weight=False, gradients=False),
    "antuono": DensityDiffusion(density_diffusion.antuono_excess, "density", balances_weight=False, gradients=True),
    "linear": DensityDiffusion(
        density_diffusion.fourtakas_linear_excess, "density", balances_weight=True, gradients=False
    ),
    "hydrostatic": DensityDiffusion(
        density_diffusion.fourtakas_excess, "enthalpy", balances_weight=True, gradients=False
    ),
}
