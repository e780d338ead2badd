"""Forms of the equations that a scene's `[method]` chooses from: one row each, with everything that depends on it.

A row is found by its name in a scene, or by its code in the table of choices. There is no default: a name or a code
without a row is an error.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol, TypeVar

from ecume.laws import diffusion, viscous
from ecume.models.sph.fields import (
    ANTUONO,
    DIFFUSION,
    ENTHALPY,
    HYDROSTATIC,
    LAMINAR,
    LINEAR,
    MOLTENI,
    MONAGHAN,
    NO_DIFFUSION,
    RADIAL,
    RHO,
    STRESS,
    SUM,
    TRANSPORT,
)
from ecume.models.sph.friction import push_transported, rub, rub_radially

Law = Callable[..., Any]


class Row(Protocol):
    """A row of any of these tables."""

    @property
    def code(self) -> int:
        """Its number in the table of choices."""


AnyRow = TypeVar("AnyRow", bound=Row)


class PressureForce(NamedTuple):
    """A form of the pressure force, and of the equation of continuity that goes with it."""

    code: int
    by_mass: bool
    """whether a neighbor counts by p/rho^2 and its mass, instead of its pressure and volume: see `PUSH` and `WEIGHT`"""
    per_volume: bool
    """whether the sum is a force per volume, instead of per mass"""
    transported: bool
    """whether particles move with a transport velocity, driven by a background pressure"""
    loop: Any
    """the sum; None: `push` of the kernel, see `sums`"""


class Friction(NamedTuple):
    """A form of the viscous force."""

    code: int
    radial: bool
    """whether it acts along the line between two particles, instead of along their relative velocity"""
    loop: Any
    law: Law


class DensityDiffusion(NamedTuple):
    """A diffusion term in the equation of continuity."""

    code: int
    excess: Law | None
    """what one of a pair has in excess of the other; None: no diffusion"""
    field: int
    """the row of `fields` that diffuses: `RHO` or `ENTHALPY`"""
    balances_weight: bool
    """whether the change of that field along gravity in a liquid at rest is subtracted"""
    gradients: bool
    """whether the mean gradient of the density at both particles is subtracted"""

    def rise(self, density: float, sound_speed: float) -> float:
        """What gravity is multiplied with for the field's change along it at rest: rho/c^2 for the density."""
        spring = 1.0 if self.field == ENTHALPY else density / sound_speed**2
        return spring if self.balances_weight else 0.0


PRESSURE_FORCES: Mapping[str, PressureForce] = {
    "sum": PressureForce(SUM, by_mass=False, per_volume=True, transported=False, loop=None),
    "monaghan": PressureForce(MONAGHAN, by_mass=True, per_volume=False, transported=False, loop=None),
    "transport": PressureForce(TRANSPORT, by_mass=False, per_volume=False, transported=True, loop=push_transported),
}
FRICTIONS: Mapping[str, Friction] = {
    "morris": Friction(LAMINAR, radial=False, loop=rub, law=viscous.morris_friction),
    "monaghan": Friction(RADIAL, radial=True, loop=rub_radially, law=viscous.radial_friction),
}
DIFFUSIONS: Mapping[str, DensityDiffusion] = {
    "none": DensityDiffusion(NO_DIFFUSION, None, RHO, balances_weight=False, gradients=False),
    "molteni": DensityDiffusion(MOLTENI, diffusion.molteni_excess, RHO, balances_weight=False, gradients=False),
    "antuono": DensityDiffusion(ANTUONO, diffusion.antuono_excess, RHO, balances_weight=False, gradients=True),
    "linear": DensityDiffusion(LINEAR, diffusion.fourtakas_linear_excess, RHO, balances_weight=True, gradients=False),
    "hydrostatic": DensityDiffusion(
        HYDROSTATIC, diffusion.fourtakas_excess, ENTHALPY, balances_weight=True, gradients=False
    ),
}


def row_of(table: Mapping[str, AnyRow], code: int) -> AnyRow:
    """The row with this code; ValueError where there is none."""
    for row in table.values():
        if row.code == code:
            return row
    codes = {name: row.code for name, row in table.items()}
    raise ValueError(f"got the code {code}; expected one of {codes}")


def pressure_of(choices: Any) -> PressureForce:
    """The row that a table of choices asks for."""
    return row_of(PRESSURE_FORCES, int(choices[STRESS]))


def diffusion_of(choices: Any) -> DensityDiffusion:
    """The row that a table of choices asks for."""
    return row_of(DIFFUSIONS, int(choices[DIFFUSION]))
